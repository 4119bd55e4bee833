// Tests that the recorded steps of a formula compute the same values.
#include "saltus/model/steps_of.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/error.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/ocp/cost_functions.hpp"

namespace saltus {
namespace {

// Every supported operation, on numbers for which all are defined.
struct Everything {
  template <class S>
  Vec<S, 6> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    S mixed = select(x[0] - 0.5, x[1] * u[0], -x[1]);
    mixed += 2.0 * p[0] - t / 3.0;
    return {sin(x[0]) + cos(x[1]) + tan(u[0]) + asin(x[0]) + acos(x[1]) + atan(u[0]),
            sinh(x[0]) - cosh(x[1]) * tanh(u[0]) + exp(p[0]) + log(x[0]) / sqrt(x[1]),
            abs(x[0] - x[1]) + min(x[0], p[0]) + max(x[1], 0.2) + atan2(x[0], u[0]),
            hypot(x[0], x[1]) + pow(x[0], 3) + pow(x[1], u[0]) + pow(x[0], 1) + pow(x[1], 0),
            mixed,
            S(3.0)};
  }
};

TEST(StepsOf, EveryOperationIsRecorded) {
  const Function f = make_function<2, 1, 1>(Everything{});
  const FormulaSteps steps = steps_of(f);
  std::set<Operation> seen;
  for (const FormulaStep& s : steps.steps) seen.insert(s.operation);
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(Operation::select) + 1);
  for (const double x0 : {0.3, 0.6}) {  // both branches
    const Eigen::Matrix<double, 5, 1> z(0.7, x0, 0.4, 0.8, 0.9);
    const VectorXd expected = f(z);
    const std::vector<double> found = steps.evaluate(std::span<const double>(z.data(), 5));
    for (int i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(found[i], expected[i]) << i;
  }
}

TEST(StepsOf, OmitsUnusedSteps) {
  const FormulaSteps steps = steps_of(make_function<2, 1, 0>(
      [](const auto&, const auto& x) { return sin(x[0] * x[1]) * 0.0 + x[1]; }));
  ASSERT_EQ(steps.steps.size(), 3u);  // 0 + x[1]
  EXPECT_EQ(steps.steps.back().operation, Operation::add);
}

TEST(StepsOf, KnowTheDegreeOfEachOutput) {
  const Function f = make_function<3, 0, 0>([](const auto& t, const auto& x) {
    using S = std::decay_t<decltype(t)>;
    return Vec<S, 9>(S(3.0), sin(t) * exp(t), x[0] * t - x[1] / t, x[0] * x[1], x[0] / x[1],
                     x[0] * x[1] * x[2], abs(x[0]), pow(x[0], 2), 2.0 * (x[0] - x[1]) / 3.0);
  });
  const std::vector<char> states{0, 1, 1, 1}, first{0, 1, 0, 0}, all(4, 1);
  const auto degrees = [&](const std::vector<char>& variable) {
    std::vector<int> result;
    result.reserve(f.outputs());
    for (int i = 0; i < f.outputs(); ++i) result.push_back(f.degree(i, variable));
    return result;
  };
  EXPECT_EQ(degrees(states), (std::vector<int>{0, 0, 1, 2, 3, 3, 3, 3, 1}));
  EXPECT_EQ(degrees(first), (std::vector<int>{0, 0, 1, 1, 1, 1, 3, 3, 1}));
  EXPECT_EQ(degrees(all), (std::vector<int>{0, 3, 3, 2, 3, 3, 3, 3, 1}));
}

TEST(StepsOf, RecordsFormulasOfFormulas) {
  const FormulaSteps inner = steps_of(make_function<1, 1, 0>(
      [](const auto&, const auto& x, const auto& u) { return x[0] / u[0]; }));
  FormulaSteps outer;
  outer.inputs = 1;
  const int a = outer.add_input(0), two = outer.add_constant(2.0);
  const std::vector<int> arguments{a, two, a};
  const int quotient = outer.add(inner, arguments).front();
  outer.outputs = {outer.add(Operation::multiply, quotient, two)};
  const double z = 8.0;
  EXPECT_EQ(outer.evaluate({&z, 1}).front(), 0.5);
}

// A formula of the time in other units. It passes degree() on, as wrappers do.
class InOtherUnits final : public FunctionBody {
 public:
  explicit InOtherUnits(Function f) : FunctionBody(f.inputs(), f.outputs()), f_(std::move(f)) {
    jacobian_pattern_ = f_.jacobian_pattern();
    hessian_pattern_ = f_.hessian_pattern();
  }
  int degree(int output, const std::vector<char>& variable) const override {
    return f_.degree(output, variable);
  }
  void value(const double* z, double* y) const override {
    const double inner[] = {0.1 * z[0], z[1]};
    f_.value(inner, y);
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    const double inner[] = {0.1 * z[0], z[1]};
    f_.jacobian(inner, y, entries);
    entries[0] *= 0.1;
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  Function f_;
};

TEST(StepsOf, WrapperIsNotTakenForTheFormulaItWraps) {
  // The two differ only near t = 15 and t = 150, where values are not compared.
  const Function peak = make_function<1, 0, 0>(
      [](const auto& t, const auto& x) { return x[0] - exp(-4.0 * (t - 15.0) * (t - 15.0)); });
  EXPECT_NO_THROW(steps_of(peak));
  EXPECT_THROW(steps_of(Function(std::make_shared<const InOtherUnits>(peak))), DefinitionError);
}

TEST(StepsOf, RejectsNonFormulas) {
  const Function f = make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0]; });
  // It traces like its residual but is a different function.
  EXPECT_THROW(steps_of(least_squares_cost(f, MatrixXd::Identity(1, 1), {})), DefinitionError);
  EXPECT_THROW(steps_of(change_costs(VectorXd::Ones(2))), DefinitionError);
}

}  // namespace
}  // namespace saltus
