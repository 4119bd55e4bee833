// The quadratic programs that a nonlinear model predictive controller solves in closed loop, one
// per tick: the dynamics linearised about the plan of the tick before, one stage earlier.
#pragma once

#include <functional>
#include <string>

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

struct ClosedLoop {
  struct Tick {
    StageQp qp;
    StagePoint warm;  ///< the optimum of the tick before, one stage earlier
  };
  std::string name = {};
  int ticks = 0, intervals = 0;
  std::function<Tick(int number)> tick = {};  ///< from 1
};

/// The chain of masses (hanging_chain.hpp) is brought to rest.
ClosedLoop chain_loop();
/// A car at 12 m/s changes to the left lane and back.
ClosedLoop car_loop();

}  // namespace saltus::bench
