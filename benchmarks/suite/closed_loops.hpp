// The quadratic programs of a nonlinear model predictive controller in closed loop, one per tick.
// The dynamics are linearised about the previous plan, one stage earlier.
#pragma once

#include <functional>
#include <string>

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

struct ClosedLoop {
  struct Tick {
    qp::StageQp qp;
    qp::StagePoint warm;  ///< previous optimum, one stage earlier
  };
  std::string name = {};
  int ticks = 0, intervals = 0;
  std::function<Tick(int number)> tick = {};  ///< from 1
};

/// The chain of masses (hanging_chain.hpp) returns to rest.
ClosedLoop chain_loop();
/// A car at 12 m/s changes to the left lane and back.
ClosedLoop car_loop();

}  // namespace saltus::bench
