// A phase after type erasure, as the transcription reads it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/model/switching_system.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/ocp/term.hpp"

namespace saltus {

// The initial guess of a phase: constant, interpolated or simulated.

/// A trajectory over a phase as a function of the fraction in [0, 1] of its duration.
class Guess {
 public:
  Guess();  ///< not given: the start of the problem for states, zero for inputs
  Guess(const Guess& other);
  Guess(Guess&& other) noexcept;
  Guess& operator=(const Guess& other);
  Guess& operator=(Guess&& other) noexcept;
  ~Guess();
  /// A constant value.
  static Guess constant(VectorXd value);
  /// A straight line from `first` at the start of the phase to `last` at its end.
  static Guess interpolate(VectorXd first, VectorXd last);
  /// A function of the fraction of the phase, 0 to 1.
  static Guess trajectory(std::function<VectorXd(double fraction)> f);
  /// For states only: integrates the dynamics from the start of the phase with the guessed inputs.
  static Guess simulate();

  /// True if a trajectory was given.
  bool is_given() const { return static_cast<bool>(trajectory_); }
  /// True if the guess is a simulation.
  bool is_simulated() const { return simulated_; }
  /// Value at a fraction of the phase, 0 to 1. Throws DefinitionError if no trajectory was given.
  VectorXd at(double fraction) const;

 private:
  explicit Guess(std::function<VectorXd(double)> f);
  std::function<VectorXd(double)> trajectory_;
  bool simulated_ = false;
};

// A phase that ends where its guard crosses zero, which determines its duration.
//
// The end condition is g(t, x-) = 0. It defines the event time only if the guard crosses zero with
// a non-zero rate,
//     dg/dt = g_t + g_x f(t, x-, u) != 0     (transversality),
// because dt/dx = -g_x / (g_t + g_x f). With zero rate, the trajectory grazes the surface, and the
// event time has no derivative (framework/design/conventions.md).

struct PhaseDefinition;

/// The guard that ends a phase.
struct EndGuard {
  /// Rate of a guard along the trajectory, in the guard's units per second.
  struct Rate {
    double value = 0.0;  ///< g_t + g_x f
    /// Scale of the rate: |g_t| + |g_x N| |N^-1 f| with the nominal states N.
    double scale = 0.0;

    /// Below this fraction of the scale, the crossing counts as grazing: errors of the state would
    /// be amplified a million times in the event time.
    static constexpr double grazing_fraction = 1e-6;
    /// True if the rate is too small, i.e. the guard touches zero without crossing.
    bool grazes() const;
  };

  std::string event;                      ///< name for messages and tables
  Function guard;                         ///< z = (t | x | u | p) -> one number; must not read u
  Crossing crossing = Crossing::falling;  ///< direction of the zero crossing
};
/// Deprecated name.
using GuardRate [[deprecated("use EndGuard::Rate; removed in 0.4")]] = EndGuard::Rate;

/// Rate at z = (t | x- | u | p) of the phase, with the dynamics active there. Allocates.
EndGuard::Rate guard_rate(const PhaseDefinition& phase, const Function& dynamics,
                          const Function& guard, const VectorRef& z);

/// Throws DefinitionError with phase and event if the guard cannot end the phase: the duration is
/// fixed, the guard is not a scalar, or in no mode the dynamics move the guard in the declared
/// direction. The last check samples seeded points around the guesses within the bounds. `start`
/// bounds the start time of the phase, s.
void check_end_guard(const PhaseDefinition& phase, const EndGuard& guard, const Bounds& start);

/// An integral along the phase, limited at the end of the phase. The same name in several phases is
/// one integral that continues from phase to phase.
struct IntegralConstraint {
  std::string name;        ///< name for messages
  Function integrand;      ///< z = (t | x | u | p) -> scalar
  Limits limits;           ///< limits of the integral
  double magnitude = 1.0;  ///< positive scale factor
};

/// Shape of the inputs within an interval.
enum class InputParametrisation {
  piecewise_constant,
  piecewise_linear,             ///< may jump at every node
  piecewise_linear_continuous,  ///< jumps at events only
};

/// All declarations of a phase, with sizes at run time.
struct PhaseDefinition {
  /// A named block of parameters of a phase. Blocks with the same name in several phases are the
  /// same parameter.
  struct ParameterBlock {
    std::string name;            ///< identifies the block across phases
    VectorXd value;              ///< data, or the initial guess of an unknown
    bool unknown = false;        ///< true: determined by the solver
    std::vector<Bounds> bounds;  ///< bounds of an unknown
    VectorXd nominal;            ///< magnitudes for scaling
    /// Names of the entries if a struct declared the block. They have static storage duration.
    std::span<const ParameterEntry> entries = {};
  };

  /// Bounds on one component of the input or state within a window.
  struct ComponentBounds {
    int component = 0;   ///< index of the state or input
    Bounds bounds;       ///< allowed values
    Window window = {};  ///< where the bounds are active
  };

  /// Tolerances of a path constraint that replace the defaults, in the units of the term.
  struct Allowance {
    std::string term;            ///< name of the term, or "bounds of state 0"
    double between_nodes = 0.0;  ///< tolerance between the nodes
    double at_nodes = 0.0;       ///< tolerance at the nodes; 0: the default (GridAccuracy::rows)
  };

  PhaseDefinition();
  PhaseDefinition(const PhaseDefinition& other);
  PhaseDefinition(PhaseDefinition&& other) noexcept;
  PhaseDefinition& operator=(const PhaseDefinition& other);
  PhaseDefinition& operator=(PhaseDefinition&& other) noexcept;
  ~PhaseDefinition();

  std::string name;   ///< also the name of the mode
  Arguments sizes;    ///< sizes of the formulas
  Function dynamics;  ///< z = (t | x | u | p) -> dx/dt
  Bounds duration;    ///< s; equal sides: fixed duration
  /// Events inside the phase. Empty if there are none. Otherwise `dynamics` belongs to the first
  /// mode.
  SwitchingSystem switching;
  /// The algebraic equations. All functions here have z eliminated. Empty for an ODE.
  AlgebraicPart algebraic;

  InputParametrisation input_parametrisation =
      InputParametrisation::piecewise_constant;  ///< shape of the inputs over an interval
  std::vector<ComponentBounds> input_bounds;     ///< input bounds in order of declaration
  std::vector<ComponentBounds> state_bounds;     ///< state bounds in order of declaration
  std::vector<Term> terms;                       ///< costs and constraints in order of declaration
  std::vector<IntegralConstraint> integrals;     ///< integral constraints
  std::vector<Allowance> allowances;             ///< tolerances of path constraints
  std::vector<EndGuard> end_guards;  ///< at most one; the term of the same name keeps it at zero
  std::vector<ParameterBlock> parameters;  ///< concatenated, they form p
  /// Weights of 1/2 |u_k - u_(k-1)|^2 for piecewise constant inputs. Empty: no such cost.
  VectorXd input_change_weight;

  /// First input of each group that acts on the state through a common resultant.
  std::vector<int> resultants;
  int resultant_size = 0;  ///< see Stage::resultant_size; 0: none declared

  VectorXd nominal_state;             ///< magnitudes of the states, all positive
  VectorXd nominal_input;             ///< magnitudes of the inputs; empty: 1
  double nominal_duration = 1.0;      ///< magnitude of the duration, s
  bool has_nominal = false;           ///< true if magnitudes of state and input were given
  bool has_nominal_duration = false;  ///< true if the magnitude of the duration was given
  Guess state_guess;                  ///< initial guess of the states
  Guess input_guess;                  ///< initial guess of the inputs
  double duration_guess = 0.0;        ///< initial guess of a free duration, s

  /// Magnitude of entry i of p. Throws DefinitionError if there is no such entry.
  double nominal_parameter(int i) const;
  /// Index of the integral with this name, or -1.
  int integral_index(const std::string& integral) const;
  /// True if the solver determines the duration.
  bool has_free_duration() const { return !duration.is_equality(); }
  /// The input shape within one interval.
  InputShape input_shape() const {
    return input_parametrisation == InputParametrisation::piecewise_constant ? InputShape::constant
                                                                             : InputShape::linear;
  }
  /// Throws DefinitionError with the phase, the term, the expected size and the given size. `start`
  /// bounds the start time of the phase, s.
  void check(const Bounds& start = exactly(0.0)) const;
};
/// Deprecated name.
using ParameterBlock [[deprecated("use PhaseDefinition::ParameterBlock; removed in 0.4")]] =
    PhaseDefinition::ParameterBlock;
/// Deprecated name.
using ComponentBounds [[deprecated("use PhaseDefinition::ComponentBounds; removed in 0.4")]] =
    PhaseDefinition::ComponentBounds;

// Implementation of the methods of Phase, compiled once. Moved arguments are passed by reference,
// because each temporary would add a destructor call to every problem definition.
/// Sets name, sizes, dynamics and duration after checking them.
void begin(PhaseDefinition& phase, std::string&& name, const Arguments& sizes, Function&& dynamics,
           const Bounds& duration);
/// Adds 0 = equations(t | x z | u | p) and `dynamics` with the same argument. Also sets
/// phase.dynamics. Throws DefinitionError with the phase and the equation, as AlgebraicEquations
/// does.
void add_algebraic(PhaseDefinition& phase, Function&& dynamics, Function&& equations,
                   const VectorXd& guess);
/// Appends bounds after checking them.
void add_bounds(std::vector<PhaseDefinition::ComponentBounds>& all, int component,
                const Bounds& bounds, Window&& window);
/// Appends a constraint. A single Bounds applies to all rows of the function.
void add_constraint(PhaseDefinition& phase, std::string&& name, Term::Domain domain,
                    Function&& function, std::vector<Bounds>&& bounds, Window&& window,
                    std::optional<Penalty>&& penalty);
/// Appends a soft constraint on a component of x (first = sizes.x()) or u (first = sizes.u()) under
/// a name such as "state 2".
void add_soft_bounds(PhaseDefinition& phase, const char* what, int first, int count, int component,
                     const Bounds& bounds, Window&& window, Penalty&& penalty);
/// Appends an integral constraint after checking it.
void add_integral(PhaseDefinition& phase, std::string&& name, Function&& integrand, Limits&& limits,
                  double magnitude);
/// Appends tolerances of a term that is already declared.
void add_allowance(PhaseDefinition& phase, std::string&& term, double between_nodes,
                   double at_nodes);
/// Makes the guard end the phase.
void add_end_guard(PhaseDefinition& phase, std::string&& event, Function&& guard,
                   Crossing crossing);
/// Appends a cost after checking it.
void add_cost(PhaseDefinition& phase, std::string&& name, Term::Domain domain, Function&& function,
              Window&& window);
/// Appends a constraint on one algebraic state.
void add_algebraic_bounds(PhaseDefinition& phase, int component, const Bounds& bounds,
                          Window&& window, std::optional<Penalty>&& penalty = std::nullopt);
/// Appends the cost 1/2 (residual - reference)' diag(weights) (residual - reference).
void add_least_squares(PhaseDefinition& phase, std::string&& name, Term::Domain domain,
                       Function&& residual, const VectorXd& weights, Window&& window,
                       Reference&& reference);
/// Appends a block of parameters after checking it.
void add_parameter(PhaseDefinition& phase, std::string&& name, const VectorXd& value,
                   std::span<const ParameterEntry> entries);
/// Turns the last added parameter into an unknown.
void make_unknown(PhaseDefinition& phase, const Bounds& bounds, double magnitude);

}  // namespace saltus
