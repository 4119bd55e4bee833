// The common interface of integrators: end state and running costs of one shooting interval, and
// their derivatives with respect to all arguments of the interval.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/algebraic.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/switching_system.hpp"

namespace saltus {

/// Shape of the input over an interval of length h, with s = (t - t0) / h in [0, 1].
enum class InputShape {
  constant,  ///< u(s) = c0; nu coefficients
  linear     ///< u(s) = c0 + s (c1 - c0); 2 nu coefficients (c0 | c1)
};

/// The differential equations of an interval: x' = f(t, x, u(t), p) and q' = L(t, x, u(t), p), q(0)
/// = 0.
struct IntervalProblem {
  IntervalProblem();
  IntervalProblem(const IntervalProblem& other);
  IntervalProblem(IntervalProblem&& other) noexcept;
  IntervalProblem& operator=(const IntervalProblem& other);
  IntervalProblem& operator=(IntervalProblem&& other) noexcept;
  ~IntervalProblem();

  Arguments arguments;                      ///< sizes; both functions take z = (t | x | u | p)
  Function dynamics;                        ///< nx outputs
  Function running_cost;                    ///< nq outputs; empty if there are none
  InputShape shape = InputShape::constant;  ///< shape of the input over the interval
  /// Flags of the parameters with derivatives, size np. Empty means none.
  std::vector<bool> differentiate_parameter;
  /// True if derivatives with respect to start time and length are required.
  bool differentiate_time = false;
  /// Typical magnitudes of the states, size nx. Empty means ones. They scale absolute tolerances.
  VectorXd nominal_state = {};
  /// Modes and state-triggered events. If empty, `dynamics` is always active. Otherwise `dynamics`
  /// belongs to the first mode, and the mode at the start follows from the state.
  SwitchingSystem switching = {};
  /// The DAE of a differential-algebraic phase, for integrators that solve for z themselves. All
  /// functions above have z eliminated. Empty for an ODE.
  AlgebraicPart algebraic = {};

  /// The same problem with separate functions (Function::separate()). Handles to one function
  /// remain handles to one function. A function that cannot be separated is shared.
  IntervalProblem separate() const;

  /// Number of running costs.
  int nq() const { return running_cost ? running_cost.outputs() : 0; }
  /// Number of input coefficients of an interval.
  int coefficients() const {
    return shape == InputShape::constant ? arguments.nu : 2 * arguments.nu;
  }
};

/// Layout of the argument of an interval: w = (x0 | c | p | t0 | h).
struct IntervalArguments {
  int nx = 0;  ///< states
  int nc = 0;  ///< number of input coefficients
  int np = 0;  ///< parameters

  /// Index of initial state i.
  constexpr int x(int i = 0) const { return i; }
  /// Index of input coefficient i.
  constexpr int c(int i = 0) const { return nx + i; }
  /// Index of parameter i.
  constexpr int p(int i = 0) const { return nx + nc + i; }
  /// Index of the start time.
  constexpr int t0() const { return nx + nc + np; }
  /// Index of the length.
  constexpr int h() const { return nx + nc + np + 1; }
  /// Total number of entries.
  constexpr int size() const { return nx + nc + np + 2; }
};

/// Outcome of an integration. A failure is a result, not an exception, so that a solver can try
/// another point.
enum class IntegrationStatus {
  success,
  not_finite,       ///< the right-hand side or the state became NaN or infinite
  too_many_steps,   ///< the step limit was reached before the end of the interval
  step_too_small,   ///< error control or the nonlinear solver failed repeatedly
  library_failure,  ///< any other error of the underlying library
  // Intervals with events, see framework/design/events.md.
  grazing,          ///< a guard touches zero without crossing: no derivative exists
  ambiguous_start,  ///< starts on a guard with zero rate: the mode is undetermined
  non_unique,       ///< start on a surface where both fields point away
  beyond_guard,     ///< no mode fits the state, or a reset ends on or beyond a guard
  accumulation,     ///< infinitely many events in finite time (Zeno), or more than the limit
  sliding_input,    ///< sliding on a guard that depends on an input that is not constant
  backward,         ///< negative length: a reset cannot be reversed
};
/// Text for messages.
const char* describe(IntegrationStatus status);

/// Integrates one interval, for one thread at a time. Objects own their workspace, including that
/// of the functions. Fixed-step schemes do not allocate after construction. Length h = 0 is allowed
/// and gives the identity with q = 0. Its derivative with respect to h is f and L at the start.
class Integrator {
 public:
  /// Stores the problem with separate() functions. Users call IntegratorScheme::make() instead.
  explicit Integrator(const IntervalProblem& problem);
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// The problem that it integrates.
  const IntervalProblem& problem() const { return problem_; }
  /// Layout and sizes of the argument w.
  IntervalArguments arguments() const { return interval_arguments_; }
  /// Number of results: states at the end, then running costs.
  int outputs() const { return problem_.arguments.nx + problem_.nq(); }

  /// Computes end = (x(t0 + h) | q(t0 + h)), nx + nq entries.
  virtual IntegrationStatus value(const double* w, double* end) = 0;

  /// Also computes d end / d w, (nx + nq) x arguments().size(). The caller sizes the matrix.
  /// Columns of parameters or times without derivatives are zero.
  virtual IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) = 0;

  /// True if hessian() is available, i.e. second-order sensitivities.
  virtual bool has_hessian() const { return false; }

  /// Computes the symmetric matrix sum_i weights[i] d2 end_i / dw2, both triangles.
  /// Curvature::gauss_newton drops the curvature of the dynamics. Running costs then contribute
  /// their Gauss-Newton matrix along first-order sensitivities.
  virtual IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                                    Curvature curvature);

  /// Computes Jacobian and Hessian together, which often share work.
  virtual IntegrationStatus derivatives(const double* w, const double* weights, double* end,
                                        MatrixXd& derivative, MatrixXd& hessian,
                                        Curvature curvature);

  /// True if each call evaluates the running costs along the interval. If false, the integrator
  /// stores their coefficients between calls, and all running costs must be evaluated.
  virtual bool follows_running_costs() const { return true; }

  /// One sentence about the last failed call, with time, mode and event where known. Empty if no
  /// call failed or if the status is sufficient.
  virtual std::string failure() const { return {}; }

 private:
  IntervalProblem problem_;
  IntervalArguments interval_arguments_;
};

/// A method with its tolerances. Creates one Integrator per phase. Has value semantics.
class IntegratorScheme {
 public:
  virtual ~IntegratorScheme() = default;
  /// Throws DefinitionError with the reason if the method does not fit the problem, e.g. the exact
  /// zero-order hold with nonlinear dynamics.
  virtual std::unique_ptr<Integrator> make(const IntervalProblem& problem) const = 0;
  /// Text for results and messages, e.g. "CVODES BDF, tolerance 1e-09".
  virtual std::string name() const = 0;
};
/// The user's choice of scheme. Several phases may share it.
using IntegratorChoice = std::shared_ptr<const IntegratorScheme>;

// Interface of integrators with events: a record of the events, and a mode that persists between
// intervals.

/// A recorded event.
struct HybridEvent {
  /// Effect of an event inside an interval.
  enum class Kind {
    crosses,  ///< the dynamics change, the state is continuous
    jumps,    ///< the state is reset
    slides,   ///< sliding begins
    leaves,   ///< sliding ends
  };

  double time = 0.0;                          ///< s
  Kind kind = Kind::crosses;                  ///< effect of the event
  std::string name, mode_before, mode_after;  ///< name of the event and modes before and after it
  VectorXd before, after;                     ///< states x-, x+
  /// d time / d w of the interval (x0 | c | p | t0 | h). In a simulation: d time / d (x0 | p) of
  /// the whole simulation.
  VectorXd time_derivative;
};
/// Deprecated name.
using EventKind [[deprecated("use HybridEvent::Kind; removed in 0.4")]] = HybridEvent::Kind;
/// Text for messages.
const char* describe(HybridEvent::Kind kind);

/// An integrator that locates events inside an interval and continues after them.
class EventIntegrator : public Integrator {
 public:
  using Integrator::Integrator;

  /// Appends the events of the following calls to `events`, which is not owned. Null stops
  /// recording. Recording allocates; integration itself does not.
  virtual void record(std::vector<HybridEvent>* events) = 0;
  /// Mode in which the following calls start. -1: derive the mode from the state.
  virtual void start_in(int mode) = 0;
  /// Mode at the end of the last successful call. Sliding modes have separate indices.
  virtual int end_mode() const = 0;
  /// Name of a mode, for messages and tables.
  virtual const std::string& mode_name(int mode) const = 0;
};

// An integrator for concurrent use by any number of threads.

/// Integrates intervals of one problem with one scheme. Const and re-entrant: each call borrows an
/// Integrator from a pool. A call allocates if none is free, so use it offline.
class ReentrantIntegrator {
 public:
  /// Throws DefinitionError if the scheme is null. The first call reports a scheme that does not
  /// fit the problem; IntegratorScheme::make() reports it earlier.
  ReentrantIntegrator(IntervalProblem problem, IntegratorChoice scheme);

  /// The problem that it integrates.
  const IntervalProblem& problem() const { return problem_; }
  /// Layout and sizes of the argument w.
  IntervalArguments arguments() const { return interval_arguments_; }
  /// Number of results: states at the end, then running costs.
  int outputs() const { return problem_.arguments.nx + problem_.nq(); }
  /// Same as Integrator::value().
  IntegrationStatus value(const double* w, double* end) const;
  /// Creates an Integrator of the same problem and scheme, for one thread.
  std::unique_ptr<Integrator> make() const { return scheme_->make(problem_); }

 private:
  IntervalProblem problem_;
  IntegratorChoice scheme_;
  IntervalArguments interval_arguments_;
  detail::WorkspacePool<Integrator> integrators_;
};

// Directional derivatives of the flow of an interval, also where it has no Jacobian. Where two
// events coincide, the flow is only piecewise smooth: the direction decides which event comes
// first.

/// One-sided derivative along a direction.
struct DirectionalDerivative {
  VectorXd value;       ///< d end / d epsilon at epsilon = 0+; NaN where it does not exist
  double error = 0.0;   ///< estimate, relative to 1 + the largest entry
  bool exists = false;  ///< true if the derivative exists
  std::string message;  ///< the reason if it does not exist, else empty
};

/// Limit of (F(w + epsilon direction) - F(w)) / epsilon for epsilon -> 0+, where F(w) is the end of
/// the interval. Extrapolates the Jacobians at w + epsilon direction, where the order of events is
/// defined, with epsilon = first_step, first_step / 2, ... No other event may occur within
/// `first_step` along the direction. Near grazing, the Jacobians grow without bound and the message
/// says so. Allocates; intended for analysis and design.
DirectionalDerivative directional_derivative(Integrator& integrator, const VectorRef& w,
                                             const VectorRef& direction, double first_step = 1e-3);

}  // namespace saltus
