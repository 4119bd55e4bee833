// Derivatives of an optimum: cost, first input and whole plan with respect to event times,
// durations, parameters and the start. Derivation: framework/design/switch_times.md.
//
// For the program min f(w, theta) with bounds on rows g(w, theta) and variables,
//
//     dJ*/dtheta = d_theta L(w, lambda, z; theta)                              (envelope theorem)
//
// and dw*/dtheta follows from the KKT system of the active constraints
// (saltus/solver/optimum_system.hpp). Derivatives with respect to theta at fixed (w, lambda) are
// exact if theta is a variable of the program or the side of a row. Otherwise they are differences
// of the program at theta +- h with Richardson extrapolation. Second derivatives with respect to w
// use exact gradients.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

class OptimumSystem;
struct OptimumMovement;
struct StepRange;

/// Motion of an event along a direction: `rate` seconds later per unit of the direction.
struct EventRate {
  std::string event;  ///< name in the schedule
  double rate = 1.0;  ///< s per unit of the direction
};
/// The schedule with all events moved by `d` units along the direction. Throws DefinitionError if
/// events would change their order.
Schedule moved(const Schedule& schedule, std::span<const EventRate> direction, double d);

/// Derivatives of the solution of the program in its current state: data must not have changed
/// since the solve. Each call restores the program. Allocates; intended for analysis and design.
class OptimumDerivatives {
 public:
  /// Derivative per unit of theta: per second, or per unit of the parameter or state.
  struct Derivative {
    double cost = 0.0;     ///< NaN if it does not exist
    VectorXd first_input;  ///< derivative of the first input, in its own units; NaN if unknown
    /// Derivative of all scaled variables of the program (see Layout). States and inputs belong to
    /// nodes, which may move with theta.
    VectorXd w;
    /// Estimated error of the differences, relative to 1 + the largest entry. 0 without
    /// differences.
    double difference_error = 0.0;
    bool reliable = false;  ///< true if the optimum is sufficiently regular
    std::string message;    ///< the reason if not reliable, else empty
  };

  /// `shooting` must outlive this object. Throws DefinitionError if the solution does not belong to
  /// its program.
  OptimumDerivatives(MultipleShooting& shooting, const Solution& solution);
  ~OptimumDerivatives();
  OptimumDerivatives(OptimumDerivatives&&) noexcept;
  OptimumDerivatives& operator=(OptimumDerivatives&&) noexcept;

  /// Derivative with respect to one event time, with the other events fixed. An event at a node of
  /// the grid, or at another event, has only one-sided derivatives: the result is not reliable.
  Derivative wrt_event(std::string_view event);
  /// Derivative with respect to several events that move together, per unit of the direction.
  Derivative wrt_events(std::span<const EventRate> direction);
  /// Derivative with respect to the duration of a phase. If fixed, later phases move with it and
  /// events stay. If free, the result is for a duration fixed near its current value.
  Derivative wrt_duration(int phase);
  /// Derivative with respect to entry i of the parameter. An unknown is treated like a free
  /// duration.
  Derivative wrt_parameter(std::string_view name, int i = 0);
  /// Derivative with respect to entry i of the state at the start. A free one is treated like a
  /// free duration.
  Derivative wrt_start(int i);
  /// Derivative with respect to the start time: phases move with it, events stay.
  Derivative wrt_start_time();

  /// True if active constraints are linearly independent and the Hessian is positive definite on
  /// their null space. Otherwise message() says which condition fails and where.
  bool reliable() const;
  /// The reason if there are no derivatives, else empty.
  const std::string& message() const;
  /// "exact", or "differences of gradients" if an integrator has no second derivatives.
  const std::string& hessian() const;
  /// The solution, refined by Newton steps on the active constraints.
  const NlpPoint& point() const;

 private:
  /// Changes data from theta to theta + d.
  using EditData = std::function<void(double d, ProblemData& data)>;
  Derivative by_differences(const std::string& name, StepRange steps, const EditData& edit);
  Derivative by_holding(int variable, double nominal);
  Derivative unchanged() const;
  void finish(Derivative& result, bool solved, const OptimumMovement& moved, double rate) const;

  MultipleShooting* shooting_;
  std::unique_ptr<OptimumSystem> system_;
};
/// Deprecated name.
using OptimumDerivative [[deprecated("use OptimumDerivatives::Derivative; removed in 0.4")]] =
    OptimumDerivatives::Derivative;

// One-sided derivatives of an optimum at an event that coincides with a node or another event. The
// optimal cost has a kink there, and OptimumDerivatives reports NaN with the reason.
//
// The optimal cost is smooth on either side. With event times t_i + d rate_i,
//
//     dJ*/dd (0+) = lim dJ*/dd (d),   d -> 0 from above, (framework/design/switch_times.md)
//
// The derivatives at d, d/2, d/4, ..., each at an optimum computed there, are extrapolated to zero.

/// One-sided derivative of an optimum along a direction.
struct OneSidedDerivative {
  double cost = 0.0;      ///< d J* / dd at d = 0+; NaN if unknown
  VectorXd first_input;   ///< derivative of the first input, in its own units
  double error = 0.0;     ///< estimate, relative to 1 + the largest entry
  bool reliable = false;  ///< true if the optimum is sufficiently regular
  std::string message;    ///< the reason if not reliable, else empty
};

/// Computes the derivative along a direction in which events move. `solution` is an optimum at the
/// current event times. `solver` solves nearby problems and needs a tolerance of 1e-9 or less. The
/// problem is unchanged on return. Throws DefinitionError if an event is not in the schedule.
/// Allocates.
OneSidedDerivative one_sided_derivative(MultipleShooting& shooting, Solver& solver,
                                        const Solution& solution,
                                        std::span<const EventRate> direction);

}  // namespace saltus
