// A phase once its sizes and formulas are erased: what the transcription reads.
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

/// A named block of a phase's parameters. Blocks of the same name in several phases are one: data
/// have the same value in all of them.
struct ParameterBlock {
  std::string name;            ///< the same name in two phases is the same parameter
  VectorXd value;              ///< data, or the guess of an unknown
  bool unknown = false;        ///< decided by the solver
  std::vector<Bounds> bounds;  ///< unknowns only
  VectorXd nominal;            ///< magnitude, for scaling
  /// Names of parts of the block, if it was declared by a struct; of static storage.
  std::span<const ParameterEntry> entries = {};
};

/// Bounds on one component of the input or state during a window.
struct ComponentBounds {
  int component = 0;   ///< number of the state or input
  Bounds bounds;       ///< what is allowed
  Window window = {};  ///< when
};

/// An integral along the phase that is kept within limits where the phase ends. The same name in
/// several phases is one integral, which goes on from phase to phase.
struct IntegralConstraint {
  std::string name;        ///< for messages
  Function integrand;      ///< z = (t | x | u | p) -> one number
  Limits limits;           ///< of what it adds up to
  double magnitude = 1.0;  ///< for scaling, positive
};

/// Tolerance of a path constraint in place of the default one, in the units of the term.
struct Allowance {
  std::string term;            ///< its name, or "bounds of state 0"
  double between_nodes = 0.0;  ///< between the nodes
  double at_nodes = 0.0;       ///< at nodes; 0: the default (GridAccuracy::rows)
};

/// How a phase's inputs vary within an interval.
enum class InputParametrisation {
  piecewise_constant,
  piecewise_linear,             ///< may jump at every node
  piecewise_linear_continuous,  ///< jumps at events only
};

/// Everything that a phase declares, sizes at run time.
struct PhaseDefinition {
  PhaseDefinition();
  PhaseDefinition(const PhaseDefinition& other);
  PhaseDefinition(PhaseDefinition&& other) noexcept;
  PhaseDefinition& operator=(const PhaseDefinition& other);
  PhaseDefinition& operator=(PhaseDefinition&& other) noexcept;
  ~PhaseDefinition();

  std::string name;   ///< of the mode, too
  Arguments sizes;    ///< of its formulas
  Function dynamics;  ///< z = (t | x | u | p) -> dx/dt
  Bounds duration;    ///< s; equal sides: fixed
  /// Events inside the phase; empty: none. Otherwise `dynamics` are those of the first mode.
  SwitchingSystem switching;
  /// Algebraic equations, from which z is eliminated in all functions here; empty: none.
  AlgebraicPart algebraic;

  InputParametrisation input_parametrisation =
      InputParametrisation::piecewise_constant;  ///< how inputs run over an interval
  std::vector<ComponentBounds> input_bounds;     ///< in the order of their declaration
  std::vector<ComponentBounds> state_bounds;     ///< in the order of their declaration
  std::vector<Term> terms;  ///< costs and constraints in the order of their declaration
  std::vector<IntegralConstraint> integrals;  ///< of what formulas add up to
  std::vector<Allowance> allowances;          ///< tolerances of terms
  std::vector<EndGuard> end_guards;           ///< at most one; a term of its name keeps it at zero
  std::vector<ParameterBlock> parameters;     ///< concatenated they are p
  /// Weights of 1/2 |u_k - u_(k-1)|^2 for piecewise constant inputs; empty: no such cost.
  VectorXd input_change_weight;

  /// Groups of inputs that act on the state through a common resultant: the first of each.
  std::vector<int> resultants;
  int resultant_size = 0;  ///< as Stage::resultant_size; 0: nothing declared

  VectorXd nominal_state;             ///< magnitudes, all positive
  VectorXd nominal_input;             ///< magnitude of each input; empty: 1
  double nominal_duration = 1.0;      ///< s
  bool has_nominal = false;           ///< the magnitudes of state and input were given
  bool has_nominal_duration = false;  ///< that of the duration was
  Guess state_guess;                  ///< where the search begins
  Guess input_guess;                  ///< where the search begins
  double duration_guess = 0.0;        ///< s; for a free duration

  /// Magnitude of entry i of p.
  double nominal_parameter(int i) const;
  /// Position of the integral of this name, or -1.
  int integral_index(const std::string& integral) const;
  /// Whether the duration is an unknown.
  bool has_free_duration() const { return !duration.is_equality(); }
  /// The same in terms of an interval.
  InputShape input_shape() const {
    return input_parametrisation == InputParametrisation::piecewise_constant ? InputShape::constant
                                                                             : InputShape::linear;
  }
  /// Throws DefinitionError with the phase, the term, the expected size and the given one. `start`:
  /// when the phase may begin, s.
  void check(const Bounds& start = exactly(0.0)) const;
};

// What the methods of a Phase come down to, compiled once. What is moved from is taken by
// reference: each further temporary would be destroyed once more in every definition of a problem.
/// Name, sizes and dynamics, checked.
void begin(PhaseDefinition& phase, std::string&& name, const Arguments& sizes, Function&& dynamics,
           const Bounds& duration);
/// 0 = equations(t | x z | u | p), with `dynamics` of the same argument; sets phase.dynamics too.
/// Throws DefinitionError with the phase and the equation, as AlgebraicEquations does.
void add_algebraic(PhaseDefinition& phase, Function&& dynamics, Function&& equations,
                   const VectorXd& guess);
/// Appends a bound, checked.
void add_bounds(std::vector<ComponentBounds>& all, int component, const Bounds& bounds,
                Window&& window);
/// One Bounds serves all rows of the function.
void add_constraint(PhaseDefinition& phase, std::string&& name, TermDomain domain,
                    Function&& function, std::vector<Bounds>&& bounds, Window&& window,
                    std::optional<Penalty>&& penalty);
/// A component of x (first = sizes.x()) or u (sizes.u()) within bounds as a soft constraint of its
/// own name, "state 2".
void add_soft_bounds(PhaseDefinition& phase, const char* what, int first, int count, int component,
                     const Bounds& bounds, Window&& window, Penalty&& penalty);
/// Appends an integral constraint, checked.
void add_integral(PhaseDefinition& phase, std::string&& name, Function&& integrand, Limits&& limits,
                  double magnitude);
/// Appends an allowance, checked: the term must have been declared.
void add_allowance(PhaseDefinition& phase, std::string&& term, double between_nodes,
                   double at_nodes);
/// The phase ends where the guard passes zero.
void add_end_guard(PhaseDefinition& phase, std::string&& event, Function&& guard,
                   Crossing crossing);
/// Appends a cost, checked.
void add_cost(PhaseDefinition& phase, std::string&& name, TermDomain domain, Function&& function,
              Window&& window);
/// z within bounds: one constraint of the algebraic state's own name.
void add_algebraic_bounds(PhaseDefinition& phase, int component, const Bounds& bounds,
                          Window&& window, std::optional<Penalty>&& penalty = std::nullopt);
/// 1/2 (residual - reference)' diag(weights) (residual - reference)
void add_least_squares(PhaseDefinition& phase, std::string&& name, TermDomain domain,
                       Function&& residual, const VectorXd& weights, Window&& window,
                       Reference&& reference);
/// Appends a block of parameters, checked.
void add_parameter(PhaseDefinition& phase, std::string&& name, const VectorXd& value,
                   std::span<const ParameterEntry> entries);
/// The parameter added last becomes an unknown.
void make_unknown(PhaseDefinition& phase, const Bounds& bounds, double magnitude);

}  // namespace saltus
