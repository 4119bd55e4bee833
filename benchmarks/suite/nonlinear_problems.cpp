#include "benchmarks/suite/nonlinear_problems.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "benchmarks/suite/qp_file.hpp"
#include "benchmarks/suite/shooting_steps.hpp"
#include "problems/library/catalogue.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/core/text.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/transcription/quantities.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus::bench {
namespace {

using Json = nlohmann::ordered_json;

// [["input", 0], ["constant", 2.0], ["multiply", 1, 0]]
Json steps_json(const FormulaSteps& f) {
  Json steps = Json::array();
  for (const FormulaStep& s : f.steps) {
    Json step = Json::array({name_of(s.operation)});
    if (s.operation == Operation::input) step.push_back(static_cast<int>(s.value));
    if (s.operation == Operation::constant) step.push_back(s.value);
    for (const int argument : {s.a, s.b, s.c})
      if (argument >= 0) step.push_back(argument);
    steps.push_back(std::move(step));
  }
  return {{"inputs", f.inputs}, {"steps", std::move(steps)}, {"outputs", f.outputs}};
}

Json block_json(const Block& block) {
  Json coefficients = Json::array(), outputs = Json::array();
  for (const std::vector<VariableCoefficient>& of_argument : block.coefficients) {
    Json one = Json::array();
    for (const VariableCoefficient& c : of_argument) one.push_back({c.variable, c.factor});
    coefficients.push_back(std::move(one));
  }
  for (const BlockOutput& o : block.outputs) outputs.push_back({o.row, o.factor});
  return {{"constants", json_list(block.constants)},
          {"coefficients", std::move(coefficients)},
          {"outputs", std::move(outputs)}};
}

Json pattern_json(const SparsityPattern& pattern) {
  Json row = Json::array(), col = Json::array();
  pattern.for_each([&](int i, int j, int) {
    row.push_back(i);
    col.push_back(j);
  });
  return {{"row", row}, {"col", col}};
}

// Values and derivatives of our program.
Json check_json(ShootingProgram& program, const VectorXd& w, Random& random) {
  const int n = program.variables(), m = program.rows();
  VectorXd gradient(n), rows(m), lambda = random.vector(m);
  std::vector<double> jacobian(program.jacobian_pattern().entries()),
      hessian(program.hessian_pattern().entries());
  double objective = 0.0;
  const bool exact = program.supports(Curvature::exact);
  const bool there =
      program.objective(w.data(), objective) && program.gradient(w.data(), gradient.data()) &&
      program.constraints(w.data(), rows.data()) && program.jacobian(w.data(), jacobian.data()) &&
      (!exact || program.hessian(w.data(), 1.0, lambda.data(), hessian.data(), Curvature::exact));
  if (!there) return Json();
  Json check{{"w", json_list(w)},       {"objective", objective}, {"gradient", json_list(gradient)},
             {"rows", json_list(rows)}, {"jacobian", jacobian},   {"lambda", json_list(lambda)}};
  if (exact) check["hessian"] = hessian;
  return check;
}

}  // namespace

NonlinearProblem::NonlinearProblem(const ReferenceCase& c)
    : case_(c), shooting_(c.problem(), c.options) {}

int NonlinearProblem::intervals() const {
  int sum = 0;
  for (int j = 0; j < shooting_.grid().phases(); ++j) sum += shooting_.grid().intervals(j);
  return sum;
}

Json NonlinearProblem::file() {
  ShootingProgram& program = shooting_.editable_program();
  const VectorXd start = shooting_.initial_guess().w;
  const ShootingSteps steps = shooting_steps(program, *case_.options.integrator, start);

  Json functions = Json::array(), blocks = Json::array();
  for (const FormulaSteps& f : steps.functions) functions.push_back(steps_json(f));
  for (std::size_t b = 0; b < program.blocks().size(); ++b) {
    if (steps.function_of[b] < 0) continue;
    Json block = block_json(program.blocks()[b]);
    block["function"] = steps.function_of[b];
    blocks.push_back(std::move(block));
  }
  Json linear = Json::array(), costs = Json::array();
  program.for_each_linear([&](int row, int variable, double coefficient) {
    linear.push_back({row, variable, coefficient});
  });
  // cost (a + b/2 w) w of a variable, from its values at 1 and -1
  for (int i = 0; i < program.variables(); ++i) {
    const double up = program.variable_cost(i, 1.0), down = program.variable_cost(i, -1.0);
    if (up != 0.0 || down != 0.0) costs.push_back({i, 0.5 * (up - down), up + down});
  }

  Json checks = Json::array();
  Random random(1);
  // in scaled variables; the density of air depends strongly on the altitude
  constexpr double radius = 1e-3;
  for (int k = 0; k < 3; ++k) {
    const VectorXd w = start + (k == 0 ? 0.0 : radius) * random.vector(program.variables());
    Json check = check_json(program, w, random);
    if (!check.is_null()) checks.push_back(std::move(check));
  }
  return {{"format", "saltus-nlp 1"},
          {"problem", library_prefix + case_.name},
          {"variables", program.variables()},
          {"rows", program.rows()},
          {"lower", json_sides(program.lower())},
          {"upper", json_sides(program.upper())},
          {"row_lower", json_sides(program.row_lower())},
          {"row_upper", json_sides(program.row_upper())},
          {"start", json_list(start)},
          {"functions", std::move(functions)},
          {"blocks", std::move(blocks)},
          {"linear", std::move(linear)},
          {"variable_costs", std::move(costs)},
          {"jacobian", pattern_json(program.jacobian_pattern())},
          {"hessian", pattern_json(program.hessian_pattern())},
          {"checks", std::move(checks)}};
}

NonlinearProblem::Solved NonlinearProblem::solve(SolverChoice choice, double tolerance) {
  const auto solver =
      make_solver(choice, {.tolerance = tolerance, .max_iterations = case_.max_iterations});
  const NlpPoint start = shooting_.initial_guess();
  const auto once = [&] {
    return solve_in_scale(*solver, shooting_.nlp(), start, /*warm=*/false,
                          undeclared_quantities(shooting_.program()))
        .nlp;
  };
  Solved solved;
  timed_twice(solved.times, [&] { solved.result = once(); });
  return solved;
}

std::vector<std::string> nonlinear_names() {
  std::vector<std::string> names;
  for (const ReferenceCase& c : reference_cases())
    if (!NonlinearProblem(c).is_linear_quadratic()) names.push_back(library_prefix + c.name);
  return names;
}

const ReferenceCase& nonlinear_case(const std::string& name) {
  const std::string prefix = library_prefix;
  return reference_case(name.starts_with(prefix) ? name.substr(prefix.size()) : name);
}

}  // namespace saltus::bench
