// A SwitchingSystem made ready for integration: one field per mode, the guards that end each mode,
// and the sliding modes of all surfaces, as modes like any other.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/integrators/interval_field.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// A guard that ends a mode, oriented: sign * function is negative inside the mode.
struct OutgoingGuard {
  std::string name;
  Function function;
  double sign = 1.0;
  int target = 0;    ///< mode
  Function reset;    ///< may be empty
  int partner = -1;  ///< guard of `target` that is the same surface seen from the other side
  int slide = -1;    ///< mode that slides on it; -1: none
  bool ends_sliding = false;
  std::vector<char>
      counts;  ///< per state: the guard reads it, or the rate of one that it reads does
};

struct FlowMode {
  std::string name;
  std::unique_ptr<IntervalField> field;
  std::vector<OutgoingGuard> guards;
  Function surface;  ///< of a sliding mode: what stays zero
  /// Sliding modes: it cannot be followed, because the surface moves with a linear input.
  bool unsupported = false;
};

class HybridModes {
 public:
  /// Throws DefinitionError as SwitchingSystem::check() does.
  explicit HybridModes(const IntervalProblem& problem);

  const FlowMode& operator[](int mode) const { return modes_[mode]; }
  int count() const { return static_cast<int>(modes_.size()); }
  /// Modes that the user declared; those behind are sliding modes.
  int declared() const { return declared_; }
  int largest_guard_count() const;
  /// Entries of the largest Jacobian of any field, guard or reset.
  int largest_entry_count() const;

  /// Takes over the interval's argument in all fields.
  void load(const double* w);

 private:
  void add_sliding(const IntervalProblem& problem, int below, int guard);

  std::vector<FlowMode> modes_;
  int declared_ = 0;
};

/// A guard and its rate of change along the field of its mode at one instant.
struct GuardSample {
  double value = 0.0;     ///< oriented: negative inside the mode
  double rate = 0.0;      ///< per unit of scaled time
  double rounding = 0.0;  ///< |value| below which the state counts as on the guard
  double scale = 0.0;     ///< |g_x| |F| + |g_s|, F of what counts, by which the rate is judged

  bool is_on() const;
  /// Whether the motion is along the guard, as far as numbers can tell.
  bool is_tangent() const;
};

/// Evaluates guards of one interval. Owns scratch memory.
class GuardEvaluator {
 public:
  GuardEvaluator(const IntervalProblem& problem, const HybridModes& modes);

  /// All guards of the mode at (s, x), into samples[0 .. number of guards).
  void sample(const FlowMode& mode, double s, const double* x, GuardSample* samples);
  GuardSample sample(const FlowMode& mode, int guard, double s, const double* x);

  /// A flow begins at x, or has come to x: a state that is small has the rounding of what it was.
  void begin(const double* x);
  void pass(const double* x);

 private:
  GuardSample evaluate(const FlowMode& mode, const OutgoingGuard& guard);

  Arguments sizes_;
  VectorXd nominal_;
  VectorXd reach_;  // the largest |x| of the flow so far
  std::vector<double> z_, rates_, entries_, slope_;
};

}  // namespace saltus
