// Change of the optimal cost and the first wrench with the time of the impact.
//
// The data of instance ICUB-1 with the event "impact" moved to any time: exactly, or rounded to the
// grid as a controller without nodes at events would do it.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::push_recovery {

/// Options of the controller of a sweep; everything else is as in ICUB-1.
struct SweepVariant {
  double step = 0.01;                    ///< dt, s
  int intervals = 15;                    ///< N
  CostRule cost_rule = CostRule::nodes;  ///< sums by default, as in the paper
  /// Weight on first differences of every wrench component; the wrench before the horizon is the
  /// one ICUB-1 states. 0: none.
  double wrench_change = 0.0;

  std::string name() const;  ///< "10 ms, N = 15, node-summed, first differences"
};

/// The twelve variants: (10 ms, 15), (50 ms, 3), (50 ms, 15), both cost rules, with and without
/// first differences.
std::vector<SweepVariant> sweep_variants();

struct SweepPoint {
  double impact_time = 0.0;  ///< requested time, s
  SolveStatus status = SolveStatus::invalid_problem;
  double cost = 0.0;
  VectorXd first_input;  ///< both wrenches of the first interval, N and Nm
  double kkt = 0.0;      ///< scaled KKT residual, recomputed from the program
  int iterations = 0;
};

/// One transcription for all impact times, retimed between solves; every solve starts from the
/// previous solution.
class ImpactSweep {
 public:
  explicit ImpactSweep(const SweepVariant& variant);
  ~ImpactSweep();

  /// Impact at this time, s.
  SweepPoint solve(double impact_time);
  /// Impact at the node nearest to this time; solved once per node in a row.
  SweepPoint solve_rounded(double impact_time);

 private:
  SweepVariant variant_;
  MultipleShooting shooting_;
  std::unique_ptr<Solver> solver_;
  Solution last_;
  SweepPoint rounded_;
  long rounded_node_ = -1;
};

/// First and last impact time of the sweep, s.
inline constexpr double sweep_begin = 0.040, sweep_end = 0.110;

/// Impact times from sweep_begin to sweep_end inclusive, s; `step` divides the range.
std::vector<double> sweep_times(double step);

/// The largest difference between neighbours of a sweep, and where it is.
struct Change {
  double cost = 0.0;
  double input = 0.0;  ///< largest difference of an entry of the first input, N or Nm
  std::size_t cost_step = 0, input_step = 0;  ///< between points i and i + 1
};
Change largest_change(const std::vector<SweepPoint>& points);

}  // namespace saltus::push_recovery
