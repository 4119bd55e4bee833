#include "benchmarks/suite/nonlinear_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "benchmarks/data_file.hpp"
#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/autodiff/math.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/model/recorded_derivatives.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/solve_in_scale.hpp"

namespace saltus::bench {
namespace {

template <class S>
S power(const FormulaSteps& f, const std::vector<S>& values, const FormulaStep& s) {
  const FormulaStep& exponent = f.steps[s.b];
  return exponent.operation == Operation::constant ? S(pow(values[s.a], exponent.value))
                                                   : S(pow(values[s.a], values[s.b]));
}

// The value of step i from those of earlier steps.
template <class S>
S value_of(const FormulaSteps& f, std::size_t i, const std::vector<S>& values, const S* z) {
  const FormulaStep& s = f.steps[i];
  const auto a = [&]() -> const S& { return values[s.a]; };
  const auto b = [&]() -> const S& { return values[s.b]; };
  switch (s.operation) {
    case Operation::input:
      return z[static_cast<std::size_t>(s.value)];
    case Operation::constant:
      return S(s.value);
    case Operation::add:
      return S(a() + b());
    case Operation::subtract:
      return S(a() - b());
    case Operation::multiply:
      return S(a() * b());
    case Operation::divide:
      return S(a() / b());
    case Operation::negate:
      return S(-a());
    case Operation::sin:
      return S(sin(a()));
    case Operation::cos:
      return S(cos(a()));
    case Operation::tan:
      return S(tan(a()));
    case Operation::asin:
      return S(asin(a()));
    case Operation::acos:
      return S(acos(a()));
    case Operation::atan:
      return S(atan(a()));
    case Operation::sinh:
      return S(sinh(a()));
    case Operation::cosh:
      return S(cosh(a()));
    case Operation::tanh:
      return S(tanh(a()));
    case Operation::exp:
      return S(exp(a()));
    case Operation::log:
      return S(log(a()));
    case Operation::sqrt:
      return S(sqrt(a()));
    case Operation::abs:
      return S(saltus::abs(a()));
    case Operation::min:
      return S(saltus::min(a(), b()));
    case Operation::max:
      return S(saltus::max(a(), b()));
    case Operation::atan2:
      return S(atan2(a(), b()));
    case Operation::hypot:
      return S(hypot(a(), b()));
    case Operation::pow:
      return power(f, values, s);
    case Operation::select:
      return S(select(a(), b(), values[s.c]));
  }
  return S(0.0);
}

template <class S>
void evaluate(const FormulaSteps& f, const S* z, std::vector<S>& values) {
  values.resize(f.steps.size());
  for (std::size_t i = 0; i < f.steps.size(); ++i) values[i] = value_of(f, i, values, z);
}

// Derivatives from the recorded steps, or one direction at a time if a step cannot be recorded.
class StepsBody final : public FunctionBody {
  using First = Dual<double, 1>;
  using Second = Dual<First, 1>;

 public:
  explicit StepsBody(FormulaSteps steps)
      : FunctionBody(steps.inputs, static_cast<int>(steps.outputs.size())),
        steps_(std::move(steps)) {
    std::vector<Tracer> z(static_cast<std::size_t>(inputs())), values, y;
    for (int i = 0; i < inputs(); ++i) z[i] = Tracer::input(i);
    evaluate(steps_, z.data(), values);
    y.reserve(steps_.outputs.size());
    for (const int output : steps_.outputs) y.push_back(values[output]);
    const detail::FormulaStructure structure = detail::structure_of(inputs(), y);
    jacobian_pattern_ = structure.jacobian;
    hessian_pattern_ = structure.hessian;
    recorded_ = std::make_shared<detail::RecordedDerivatives>(
        steps_, jacobian_pattern_, hessian_pattern_, detail::RecordedDerivatives::Parts{});
    workspace_ = recorded_->is_complete() ? recorded_->workspace()
                                          : detail::RecordedDerivatives::Workspace();
  }

  int degree(int output, const std::vector<char>& variable) const override {
    return steps_.degree(output, variable);
  }
  const FormulaSteps* steps() const override { return &steps_; }
  std::shared_ptr<const FunctionBody> separate() const override {
    return std::make_shared<StepsBody>(steps_);
  }

  void value(const double* z, double* y) const override {
    evaluate(steps_, z, values_);
    for (int r = 0; r < outputs(); ++r) y[r] = values_[steps_.outputs[r]];
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    if (recorded_->is_complete()) return recorded_->jacobian(z, y, entries, workspace_);
    value(z, y);
    std::vector<First> at(static_cast<std::size_t>(inputs())), values;
    for (int j = 0; j < inputs(); ++j) {
      for (int i = 0; i < inputs(); ++i) at[i] = seeded(z[i], i == j);
      evaluate(steps_, at.data(), values);
      jacobian_pattern_.for_each([&](int row, int col, int e) {
        if (col == j) entries[e] = values[steps_.outputs[row]].tangent[0];
      });
    }
  }

  void hessian(const double* z, const double* weights, double* entries, Curvature) const override {
    if (recorded_->is_complete()) return recorded_->hessian(z, weights, entries, workspace_);
    std::vector<Second> at(static_cast<std::size_t>(inputs())), values;
    hessian_pattern_.for_each([&](int row, int col, int e) {
      for (int i = 0; i < inputs(); ++i)
        at[i] = Second(seeded(z[i], i == row), {{First(i == col ? 1.0 : 0.0)}});
      evaluate(steps_, at.data(), values);
      entries[e] = 0.0;
      for (int r = 0; r < outputs(); ++r)
        entries[e] += weights[r] * values[steps_.outputs[r]].tangent[0].tangent[0];
    });
  }

 private:
  static First seeded(double value, bool is_seeded) {
    const double tangent = is_seeded ? 1.0 : 0.0;
    return First(value, First::Tangent::load(&tangent));
  }

  FormulaSteps steps_;
  std::shared_ptr<const detail::RecordedDerivatives> recorded_;
  // For one thread: the body is not re-entrant.
  mutable detail::RecordedDerivatives::Workspace workspace_;
  mutable std::vector<double> values_;
};

Operation operation_of(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(Operation::select); ++i)
    if (name == name_of(static_cast<Operation>(i))) return static_cast<Operation>(i);
  throw DefinitionError(fmt::format("there is no operation '{}'", name));
}

int checked(int index, int count, const char* what) {
  if (index < 0 || index >= count)
    throw DefinitionError(fmt::format("there is no {} {}", what, index));
  return index;
}

FormulaSteps steps_of(const nlohmann::json& json) {
  FormulaSteps f;
  f.inputs = json.at("inputs").get<int>();
  for (const nlohmann::json& step : json.at("steps")) {
    const int before = static_cast<int>(f.steps.size());
    FormulaStep s{.operation = operation_of(step.at(0).get<std::string>())};
    if (s.operation == Operation::constant) {
      s.value = step.at(1).get<double>();
    } else if (s.operation == Operation::input) {
      s.value = checked(step.at(1).get<int>(), f.inputs, "input");
    } else {
      int* const arguments[] = {&s.a, &s.b, &s.c};
      const bool is_binary = s.operation <= Operation::divide ||
                             (s.operation >= Operation::min && s.operation <= Operation::pow);
      const std::size_t count = s.operation == Operation::select ? 3 : is_binary ? 2 : 1;
      if (step.size() != 1 + count)
        throw DefinitionError(fmt::format("'{}' has {} arguments", name_of(s.operation), count));
      for (std::size_t i = 0; i < count; ++i)
        *arguments[i] = checked(step.at(1 + i).get<int>(), before, "earlier step");
    }
    f.steps.push_back(s);
  }
  for (const nlohmann::json& output : json.at("outputs"))
    f.outputs.push_back(checked(output.get<int>(), static_cast<int>(f.steps.size()), "step"));
  if (f.inputs == 0) f.inputs = 1;  // a function has at least one argument; nothing reads it
  return f;
}

Block block_of(const nlohmann::json& json, const Function& function, int variables, int rows) {
  Block block(function);
  const nlohmann::json &constants = json.at("constants"), &coefficients = json.at("coefficients");
  if (constants.size() != coefficients.size() ||
      static_cast<int>(constants.size()) > function.inputs())
    throw DefinitionError("a block needs one constant and one list of coefficients per argument");
  for (std::size_t i = 0; i < constants.size(); ++i) {
    block.constants[static_cast<int>(i)] = constants[i].get<double>();
    for (const nlohmann::json& pair : coefficients[i])
      block.coefficients[i].push_back(
          {checked(pair.at(0).get<int>(), variables, "variable"), pair.at(1).get<double>()});
  }
  for (const nlohmann::json& output : json.at("outputs")) {
    const int row = output.at(0).get<int>();
    block.outputs.push_back(
        {row < 0 ? BlockOutput::objective : checked(row, rows, "row"), output.at(1).get<double>()});
  }
  if (static_cast<int>(block.outputs.size()) != function.outputs())
    throw DefinitionError("a block needs one entry of outputs per output of its function");
  return block;
}

constexpr double first_product = 1.0, last_product = 1e-9, product_step = 0.1;

}  // namespace

Function function_of(FormulaSteps steps) {
  return Function(std::unique_ptr<const FunctionBody>(new StepsBody(std::move(steps))));
}

NonlinearFile::NonlinearFile(const std::filesystem::path& file) try {
  const nlohmann::json json = read_json(file);
  if (json.at("format") != "saltus-nlp 1")
    throw DefinitionError("its format is not 'saltus-nlp 1'");
  const int n = json.at("variables").get<int>(), m = json.at("rows").get<int>();
  start_ = vector_of(json.at("start"), n, file);
  const auto side = [&](const char* key, int i, double absent) {
    const nlohmann::json& value = json.at(key).at(static_cast<std::size_t>(i));
    return value.is_null() ? absent : value.get<double>();
  };
  add_variables(n);
  add_rows(m);
  for (int i = 0; i < n; ++i)
    bound_variable(i, side("lower", i, -infinity), side("upper", i, infinity));
  for (int i = 0; i < m; ++i)
    bound_row(i, side("row_lower", i, -infinity), side("row_upper", i, infinity));
  for (const nlohmann::json& l : json.at("linear"))
    add_linear(checked(l.at(0).get<int>(), m, "row"), checked(l.at(1).get<int>(), n, "variable"),
               l.at(2).get<double>());
  std::vector<Function> functions;
  for (const nlohmann::json& f : json.at("functions"))
    functions.push_back(function_of(steps_of(f)));
  for (const nlohmann::json& b : json.at("blocks")) {
    const int number =
        checked(b.at("function").get<int>(), static_cast<int>(functions.size()), "function");
    add_block(block_of(b, functions[number], n, m));
  }
  for (const nlohmann::json& c : json.at("variable_costs"))
    if (c.at(2).get<double>() != 0.0) declare_quadratic(checked(c.at(0).get<int>(), n, "variable"));
  finish();
  for (const nlohmann::json& c : json.at("variable_costs"))
    set_variable_cost(checked(c.at(0).get<int>(), n, "variable"), c.at(1).get<double>(),
                      c.at(2).get<double>());
  if (const auto pairs = json.find("pairs"); pairs != json.end())
    for (const nlohmann::json& p : *pairs)
      pairs_.push_back({checked(p.at(0).get<int>(), n, "variable"),
                        checked(p.at(1).get<int>(), n, "variable"),
                        checked(p.at(2).get<int>(), m, "row")});
} catch (const DefinitionError& error) {
  throw InputError(fmt::format("'{}' is not a valid program: {}", file.string(), error.what()));
} catch (const nlohmann::json::exception& error) {
  throw InputError(fmt::format("'{}' is not a valid program: {}", file.string(), error.what()));
}

std::string NonlinearFile::describe_variable(int i) const { return fmt::format("variable {}", i); }
std::string NonlinearFile::describe_row(int i) const { return fmt::format("row {}", i); }

NlpResult NonlinearFile::solve_once(Solver& solver) {
  const NlpPoint start{start_, VectorXd::Zero(rows()), VectorXd::Zero(variables())};
  return solve_in_scale(solver, *this, start, /*warm=*/false).nlp;
}

NlpResult NonlinearFile::solve_pairs(Solver& solver) {
  for (const Pair& pair : pairs_)
    for (const int i : {pair.first, pair.second}) bound_variable(i, 0.0, infinity);
  NlpPoint point{start_, VectorXd::Zero(rows()), VectorXd::Zero(variables())};
  NlpResult result;
  int iterations = 0;
  const auto step = [&] {
    result = solve_in_scale(solver, *this, point, /*warm=*/false).nlp;
    iterations += result.iterations;
    if (result.point.w.size() == variables() && result.point.w.allFinite()) point = result.point;
  };
  for (double largest = first_product; largest > 0.5 * last_product; largest *= product_step) {
    for (const Pair& pair : pairs_) bound_row(pair.product, -infinity, largest);
    step();
  }
  for (const Pair& pair : pairs_) {
    bound_row(pair.product, -infinity, infinity);
    const bool is_first = point.w[pair.first] <= point.w[pair.second];
    bound_variable(is_first ? pair.first : pair.second, 0.0, 0.0);
  }
  step();
  result.iterations = iterations;
  return result;
}

NonlinearFile::Solved NonlinearFile::solve(SolverChoice choice, double tolerance) {
  constexpr int most_iterations = 1000;
  Solved solved;
  std::unique_ptr<Solver> solver;
  solved.times.setup = timed([&] {
    solver = make_solver(choice, {.tolerance = tolerance, .max_iterations = most_iterations});
  });
  timed_twice(solved.times,
              [&] { solved.result = pairs_.empty() ? solve_once(*solver) : solve_pairs(*solver); });
  return solved;
}

}  // namespace saltus::bench
