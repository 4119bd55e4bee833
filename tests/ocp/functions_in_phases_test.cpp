// A Function in place of a formula: every method of a phase takes one, and the program is the same
// to the bit.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

struct Cart {  // x = (place, speed), u = (force), p = (mass)
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    return {x[1], u[0] / p[0] - 0.3 * sin(x[0]) * x[1] + 0.1 * t};
  }
};
const auto lanes = [](const auto&, const auto& x, const auto& u) {
  using S = std::decay_t<decltype(x[0] * u[0])>;
  return Vec<S, 2>{x[0] * u[0], x[1] * x[1]};
};
const auto effort = [](const auto&, const auto& x, const auto& u) {
  return u[0] * u[0] * (1.0 + x[0] * x[0]);
};
const auto place = [](const auto&, const auto& x) { return x[0] * x[1] + x[0]; };
const auto both = [](const auto&, const auto& x) {
  using S = std::decay_t<decltype(x[0])>;
  return Vec<S, 2>{x[0] - 1.0, sin(x[1])};
};
const auto far = [](const auto&, const auto& x) { return x[0] - 9.0; };
const auto behind = [](const auto&, const auto& x) { return x[1]; };

// The formula itself, or the Function of it.
struct Plain {
  template <class F>
  F operator()(F formula) const {
    return formula;
  }
};
struct Erased {
  template <class F>
  Function operator()(F formula) const {
    return make_function<2, 1, 1>(std::move(formula));
  }
};

template <class As>
OptimalControlProblem cart(const As& as) {
  Phase<2, 1, 1> drive("drive", as(Cart{}), between(0.5, 2.0));
  drive.data("mass", Vec<double, 1>{2.0})
      .keep("lanes", as(lanes), {between(-1.0, 1.0), at_most(4.0)})
      .keep("soft lanes", as(lanes), {between(-0.1, 0.1), at_most(1.0)}, {}, soft("lanes", 3.0))
      .keep("one lane", as(place), at_most(2.0))
      .begin_with("begin", as(behind), at_most(3.0))
      .reach("there", as(both), {exactly(0.0), at_most(0.5)})
      .bound_integral("work", as(effort), at_most(9.0))
      .minimise("effort", as(effort))
      .minimise_at_start("first", as(place))
      .minimise_at_end("last", as(place))
      .track("both", as(both), Vec<double, 2>{1.0, 2.0})
      .track_at_end("both at last", as(both), Vec<double, 2>{3.0, 4.0});
  Phase<2, 1, 1> stop("stop", as(Cart{}), between(0.5, 2.0));
  stop.data("mass", Vec<double, 1>{2.0}).ends_when("stand", as(behind), Crossing::falling);
  Phase<2, 1, 1> change("change", as(Cart{}), exactly(1.0));
  change.data("mass", Vec<double, 1>{2.0})
      .switch_at("ice", as(far), as(Cart{}))
      .on("wall", as(far), Crossing::falling, as(both));
  OptimalControlProblem problem("cart");
  problem.start_at({0.3, 1.0}).then(drive).then(stop).then(change);
  return problem;
}

struct Numbers {
  std::vector<double> rows, jacobian, hessian, bounds;
  double cost = 0.0;
};
Numbers numbers_of(const OptimalControlProblem& problem) {
  MultipleShooting shooting(problem, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  NonlinearProgram& nlp = shooting.nlp();
  VectorXd w = shooting.initial_guess().w;
  for (int i = 0; i < w.size(); ++i) w[i] += 0.01 * (i % 7);
  const VectorXd multipliers = VectorXd::LinSpaced(nlp.rows(), -1.0, 2.0);
  Numbers n;
  n.rows.resize(nlp.rows());
  n.jacobian.resize(nlp.jacobian_pattern().entries());
  n.hessian.resize(nlp.hessian_pattern().entries());
  nlp.objective(w.data(), n.cost);
  nlp.constraints(w.data(), n.rows.data());
  nlp.jacobian(w.data(), n.jacobian.data());
  nlp.hessian(w.data(), 1.0, multipliers.data(), n.hessian.data(), Curvature::exact);
  for (int i = 0; i < nlp.rows(); ++i) n.bounds.push_back(nlp.row_lower()[i]);
  return n;
}

TEST(FunctionsInPhases, GiveTheSameProgramAsFormulas) {
  const Numbers formulas = numbers_of(cart(Plain{})), functions = numbers_of(cart(Erased{}));
  EXPECT_GT(formulas.rows.size(), 30u);
  EXPECT_EQ(formulas.cost, functions.cost);
  EXPECT_EQ(formulas.rows, functions.rows);
  EXPECT_EQ(formulas.jacobian, functions.jacobian);
  EXPECT_EQ(formulas.hessian, functions.hessian);
  EXPECT_EQ(formulas.bounds, functions.bounds);
}

// x' = (x1, u - x0^2) with derivatives written out.
class ByHand final : public FunctionBody {
 public:
  ByHand() : FunctionBody(4, 2) {  // z = (t | x0 x1 | u)
    jacobian_pattern_ = SparsityPattern::from_pairs(2, 4, {{0, 2}, {1, 1}, {1, 3}});
    hessian_pattern_ = SparsityPattern::from_pairs(4, 4, {{1, 1}});
  }
  bool is_reentrant() const override { return true; }
  void value(const double* z, double* y) const override {
    y[0] = z[2];
    y[1] = z[3] - z[1] * z[1];
  }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    entries[0] = 1.0;
    entries[1] = -2.0 * z[1];
    entries[2] = 1.0;
  }
  void hessian(const double*, const double* weights, double* entries, Curvature) const override {
    entries[0] = -2.0 * weights[1];
  }
};
struct InCpp {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - x[0] * x[0]};
  }
};

template <class Dynamics>
OptimalControlProblem swing(Dynamics dynamics) {
  Phase<2, 1> phase("swing", dynamics, between(0.5, 2.0));
  phase.minimise("energy", effort);
  OptimalControlProblem problem("swing");
  problem.start_at({0.4, 1.0}).then(phase);
  return problem;
}

TEST(FunctionsInPhases, MayBeWrittenByHand) {
  const Function by_hand(std::make_shared<const ByHand>());
  EXPECT_TRUE(check_derivatives(by_hand, Eigen::Vector4d(0.0, 0.4, 1.0, 0.2)).ok);
  const Numbers formula = numbers_of(swing(InCpp{})), hand = numbers_of(swing(by_hand));
  ASSERT_EQ(formula.hessian.size(), hand.hessian.size());
  for (std::size_t i = 0; i < hand.hessian.size(); ++i)
    EXPECT_NEAR(formula.hessian[i], hand.hessian[i], 1e-14);  // rounding of numbers of size 1
  for (std::size_t i = 0; i < hand.jacobian.size(); ++i)
    EXPECT_NEAR(formula.jacobian[i], hand.jacobian[i], 1e-14);
}

// 0 = z - x0^2: a Function reads z after x, or does not read it at all.
struct Slope {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& z, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0] - z[0] * x[0]);
  }
};
struct Square {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& z, const Vec<S, 1>&) const {
    return Vec<S, 1>(z[0] - x[0] * x[0]);
  }
};
template <class F>
Function with_z(F formula) {
  return make_function<2, 1, 0>(FormulaWithAlgebraic<1, 1, F>{std::move(formula)});
}
const auto cube = [](const auto&, const auto& x) { return x[0] * x[0] * x[0]; };

TEST(FunctionsInPhases, ReadAlgebraicStates) {
  const Vec<double, 1> guess{0.5};
  Phase<1, 1, 0, 1> formulas("melt", Slope{}, Square{}, guess, exactly(1.0));
  formulas.keep("z", Square{}, at_most(1.0)).minimise("x", cube);
  Phase<1, 1, 0, 1> functions("melt", with_z(Slope{}), with_z(Square{}), guess, exactly(1.0));
  functions.keep("z", with_z(Square{}), at_most(1.0)).minimise("x", make_function<1, 1, 0>(cube));
  const auto problem = [](const auto& phase) {
    OptimalControlProblem ocp("melt");
    ocp.start_at({0.7}).then(phase);
    return ocp;
  };
  const Numbers expected = numbers_of(problem(formulas)), given = numbers_of(problem(functions));
  EXPECT_EQ(expected.rows, given.rows);
  EXPECT_EQ(expected.jacobian, given.jacobian);
  EXPECT_DOUBLE_EQ(expected.cost, given.cost);
}

TEST(FunctionsInPhases, AreModesOfAnAutomatonAndJumps) {
  Automaton<1> formulas, functions;
  const auto rate = [](const auto&, const auto& x) { return -1.0 * x[0]; };
  formulas.mode("fall", rate).event("hit", "fall", "fall", cube, Crossing::falling, rate);
  const Function f = make_function<1, 0, 0>(rate);
  functions.mode("fall", f).event("hit", "fall", "fall", make_function<1, 0, 0>(cube),
                                  Crossing::falling, f);
  EXPECT_TRUE(functions.system().modes[0].dynamics.is(f));
  EXPECT_TRUE(jump<1>("kick", f).map.is(f));
  EXPECT_EQ(formulas.system().transitions.size(), functions.system().transitions.size());
}

TEST(FunctionsInPhases, AreLinks) {
  const Phase<1, 0> phase{"fall", [](const auto&, const auto& x) { return -1.0 * x[0]; },
                          exactly(1.0)};
  // (nothing | t duration x)
  const Function f = make_function<3, 0, 0>([](const auto&, const auto& v) { return v[2] - v[1]; });
  EXPECT_TRUE(make_link("level", f, exactly(0.0), end_of(phase)).function.is(f));
  const Function longer =
      make_function<4, 0, 0>([](const auto&, const auto& v) { return v[2] - v[1]; });
  EXPECT_THROW(make_link("level", longer, exactly(0.0), end_of(phase)), DefinitionError);
}

}  // namespace
}  // namespace saltus
