// A phase after type erasure, as the transcription reads it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/model/arguments.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/integrator.hpp"
#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/end_guard.hpp"
#include "saltus/ocp/guess.hpp"
#include "saltus/ocp/limits.hpp"
#include "saltus/ocp/term.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus {

/// A named block of parameters of a phase. Blocks with the same name in several phases are the same
/// parameter.
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

/// An integral along the phase, limited at the end of the phase. The same name in several phases is
/// one integral that continues from phase to phase.
struct IntegralConstraint {
  std::string name;        ///< name for messages
  Function integrand;      ///< z = (t | x | u | p) -> scalar
  Limits limits;           ///< limits of the integral
  double magnitude = 1.0;  ///< for scaling, positive
};

/// Tolerances of a path constraint that replace the defaults, in the units of the term.
struct Allowance {
  std::string term;            ///< name of the term, or "bounds of state 0"
  double between_nodes = 0.0;  ///< tolerance between the nodes
  double at_nodes = 0.0;       ///< tolerance at the nodes; 0: the default (GridAccuracy::rows)
};

/// Shape of the inputs within an interval.
enum class InputParametrisation {
  piecewise_constant,
  piecewise_linear,             ///< may jump at every node
  piecewise_linear_continuous,  ///< jumps at events only
};

/// All declarations of a phase, with sizes at run time.
struct PhaseDefinition {
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
  std::vector<ComponentBounds> input_bounds;     ///< in order of declaration
  std::vector<ComponentBounds> state_bounds;     ///< in order of declaration
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

  /// Magnitude of entry i of p.
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
void add_bounds(std::vector<ComponentBounds>& all, int component, const Bounds& bounds,
                Window&& window);
/// Appends a constraint. A single Bounds applies to all rows of the function.
void add_constraint(PhaseDefinition& phase, std::string&& name, TermDomain domain,
                    Function&& function, std::vector<Bounds>&& bounds, Window&& window,
                    std::optional<Penalty>&& penalty);
/// Appends a soft constraint on a component of x (first = sizes.x()) or u (first = sizes.u()) under
/// a name such as "state 2".
void add_soft_bounds(PhaseDefinition& phase, const char* what, int first, int count, int component,
                     const Bounds& bounds, Window&& window, Penalty&& penalty);
/// Appends an integral constraint after checking it.
void add_integral(PhaseDefinition& phase, std::string&& name, Function&& integrand, Limits&& limits,
                  double magnitude);
/// Appends tolerances of a term that was declared before.
void add_allowance(PhaseDefinition& phase, std::string&& term, double between_nodes,
                   double at_nodes);
/// Makes the guard end the phase.
void add_end_guard(PhaseDefinition& phase, std::string&& event, Function&& guard,
                   Crossing crossing);
/// Appends a cost after checking it.
void add_cost(PhaseDefinition& phase, std::string&& name, TermDomain domain, Function&& function,
              Window&& window);
/// Appends a constraint on one algebraic state.
void add_algebraic_bounds(PhaseDefinition& phase, int component, const Bounds& bounds,
                          Window&& window, std::optional<Penalty>&& penalty = std::nullopt);
/// Appends the cost 1/2 (residual - reference)' diag(weights) (residual - reference).
void add_least_squares(PhaseDefinition& phase, std::string&& name, TermDomain domain,
                       Function&& residual, const VectorXd& weights, Window&& window,
                       Reference&& reference);
/// Appends a block of parameters after checking it.
void add_parameter(PhaseDefinition& phase, std::string&& name, const VectorXd& value,
                   std::span<const ParameterEntry> entries);
/// Turns the last added parameter into an unknown.
void make_unknown(PhaseDefinition& phase, const Bounds& bounds, double magnitude);

}  // namespace saltus
