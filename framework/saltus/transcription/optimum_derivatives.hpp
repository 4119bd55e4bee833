// Derivatives of an optimum: how its cost, its first input and the whole plan change with event
// times, durations, parameters and the start. Derivation: framework/design/switch_times.md.
//
// Of the program min f(w, theta) with rows g(w, theta) between sides and variables between bounds,
//
//     dJ*/dtheta = d_theta L(w, lambda, z; theta)                              (envelope theorem)
//
// and dw*/dtheta follows from the KKT system of what holds (saltus/solver/optimum_system.hpp).
// Derivatives with respect to theta at fixed (w, lambda) are exact where theta is a variable of
// the program or the side of a row. Elsewhere the program takes on data at theta +- h and
// differenced with Richardson extrapolation; the second derivatives of w enter through exact
// gradients.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "saltus/solver/optimum_system.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/parametric_sensitivity.hpp"

namespace saltus {

/// Per unit of theta: per second, or per unit of the parameter or state.
struct OptimumDerivative {
  double cost = 0.0;     ///< NaN where it does not exist
  VectorXd first_input;  ///< of the input applied at the start, in its own units; NaN: not known
  /// Of all variables of the program (see Layout), scaled as they are. States and inputs belong to
  /// their nodes, and those may move with theta.
  VectorXd w;
  /// Estimated error of the differences, relative to 1 + the largest entry; 0: no differences.
  double difference_error = 0.0;
  bool reliable = false;  ///< whether the optimum was regular enough
  std::string message;    ///< why not; empty if reliable
};

/// How an event of the schedule moves along a direction: rate seconds per unit of it. Later: +1.
struct EventRate {
  std::string event;  ///< of the schedule
  double rate = 1.0;  ///< s per unit of the direction
};
/// The schedule with all events `d` units further along the direction. Throws DefinitionError if
/// they would pass one another, or one that stays.
Schedule moved(const Schedule& schedule, std::span<const EventRate> direction, double d);

/// Of the solution of the program as it stands: no data may have changed since the solve. Every
/// call leaves the program as it was found. Allocates; meant for analysis and design.
class OptimumDerivatives {
 public:
  /// `shooting` must outlive it. Throws DefinitionError if the solution is none of its program.
  OptimumDerivatives(MultipleShooting& shooting, const Solution& solution);

  /// An event of the schedule, the others held. An event at a node of the grid, or at another
  /// event, has derivatives from either side only: not reliable.
  OptimumDerivative wrt_event(std::string_view event);
  /// Several events that move together, per unit of the direction.
  OptimumDerivative wrt_events(std::span<const EventRate> direction);
  /// The duration of a phase. Fixed: later phases move along, events stay. Free: the cost and the
  /// plan if the duration were held at a value near the present one.
  OptimumDerivative wrt_duration(int phase);
  /// Entry i of a parameter of this name; an unknown is held like a free duration.
  OptimumDerivative wrt_parameter(std::string_view name, int i = 0);
  /// Entry i of the state at the start; one that is free is held like a free duration.
  OptimumDerivative wrt_start(int i);
  /// The time of the start: phases move along, events stay.
  OptimumDerivative wrt_start_time();

  /// Whether active constraints are independent and the Hessian is positive definite on them;
  /// otherwise message() says in a sentence what fails, and where.
  bool reliable() const { return system_.reliable(); }
  /// Why there are none; empty if there are.
  const std::string& message() const { return system_.message(); }
  /// "exact", or "differences of gradients" where an integrator has no second derivatives.
  const std::string& hessian() const { return system_.hessian(); }
  /// The solution, refined by Newton steps on the active constraints.
  const NlpPoint& point() const { return system_.point(); }

 private:
  /// Brings data from theta to theta + d.
  using EditData = std::function<void(double d, ProblemData& data)>;
  OptimumDerivative by_differences(const std::string& name, StepRange steps, const EditData& edit);
  OptimumDerivative by_holding(int variable, double nominal);
  OptimumDerivative unchanged() const;
  void finish(OptimumDerivative& result, bool solved, const OptimumMovement& moved,
              double rate) const;

  MultipleShooting* shooting_;
  OptimumSystem system_;
};

}  // namespace saltus
