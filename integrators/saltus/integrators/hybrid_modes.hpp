// A SwitchingSystem prepared for integration: one field per mode, the guards that end each mode,
// and the sliding modes of all surfaces as ordinary modes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// A guard that ends a mode, oriented so that sign * function is negative inside the mode.
struct OutgoingGuard {
  std::string name;
  Function function;
  double sign = 1.0;
  int target = 0;    ///< next mode
  Function reset;    ///< empty: no jump
  int partner = -1;  ///< the same surface as a guard of `target`, or -1
  int slide = -1;    ///< mode that slides on the surface, or -1
  bool ends_sliding = false;
  std::vector<char>
      counts;  ///< per state: the guard reads it, or the rate of a state that it reads does
};

struct FlowMode {
  std::string name;
  std::unique_ptr<IntervalField> field;
  std::vector<OutgoingGuard> guards;
  Function surface;  ///< function that stays zero in a sliding mode
  /// True for a sliding mode that cannot be integrated, because the surface moves with a linear
  /// input.
  bool unsupported = false;
};

class HybridModes {
 public:
  /// Throws DefinitionError like SwitchingSystem::check().
  explicit HybridModes(const IntervalProblem& problem);

  const FlowMode& operator[](int mode) const { return modes_[mode]; }
  int count() const { return static_cast<int>(modes_.size()); }
  /// Number of declared modes. Sliding modes follow them.
  int declared() const { return declared_; }
  int largest_guard_count() const;
  /// Number of entries of the largest Jacobian of all fields, guards and resets.
  int largest_entry_count() const;

  /// Loads the interval's argument into all fields.
  void load(const double* w);

 private:
  void add_sliding(const IntervalProblem& problem, int below, int guard);

  std::vector<FlowMode> modes_;
  int declared_ = 0;
};

/// Value of a guard and its rate along the field of its mode.
struct GuardSample {
  double value = 0.0;     ///< oriented: negative inside the mode
  double rate = 0.0;      ///< per unit of scaled time
  double rounding = 0.0;  ///< |value| up to which the state counts as on the guard
  double scale = 0.0;     ///< scale of the rate: |g_x| |F| + |g_s|, over relevant F

  bool is_on() const;
  /// True if the trajectory is tangent to the guard to rounding.
  bool is_tangent() const;
};

/// Evaluates guards of one interval. Owns its workspace.
class GuardEvaluator {
 public:
  GuardEvaluator(const IntervalProblem& problem, const HybridModes& modes);

  /// Samples all guards of the mode at (s, x) into samples[0 .. number of guards).
  void sample(const FlowMode& mode, double s, const double* x, GuardSample* samples);
  GuardSample sample(const FlowMode& mode, int guard, double s, const double* x);

  /// begin() starts a flow at x, pass() records that it reached x. The rounding error of a state
  /// depends on the largest value that it had.
  void begin(const double* x);
  void pass(const double* x);

 private:
  GuardSample evaluate(const FlowMode& mode, const OutgoingGuard& guard);

  Arguments sizes_;
  VectorXd nominal_;
  VectorXd reach_;  // largest |x| along the flow
  std::vector<double> z_, rates_, entries_, slope_;
};

}  // namespace saltus
