// Both linear systems of the barrier method, tested by the equations in sparse_qp.hpp.
#include "saltus/qp/sparse_qp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "saltus/core/random.hpp"
#include "saltus/qp/riccati_newton.hpp"
#include "saltus/qp/sparse_newton.hpp"
#include "tests/qp/random_staged.hpp"

namespace saltus {
namespace {

using testing::RandomStaged;

constexpr unsigned programs = 60;
constexpr double accurate = 1e-6;  // error of steps before refinement, relative to their terms

enum class Kind { sparse, by_stages };

class NewtonSystemOf : public ::testing::TestWithParam<Kind> {
 protected:
  static std::unique_ptr<qp::NewtonSystem> make(const qp::SparseQp& qp,
                                                const qp::StageStructure& structure,
                                                Kind kind = GetParam()) {
    return kind == Kind::sparse
               ? qp::make_sparse_newton(qp.hessian_pattern, qp.row_pattern)
               : qp::make_riccati_newton(qp.hessian_pattern, qp.row_pattern, structure);
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, NewtonSystemOf, ::testing::Values(Kind::sparse, Kind::by_stages),
                         [](const auto& kind) {
                           return kind.param == Kind::sparse ? "sparse" : "by_stages";
                         });

// Weights as a barrier gives them: one for each existing side, none for fixed variables, infinite
// for equalities.
struct Weights {
  Weights(const qp::SparseQp& qp, Random& random)
      : variables(VectorXd::Zero(qp.variables())), rows(VectorXd::Zero(qp.row_pattern.rows())) {
    for (int i = 0; i < variables.size(); ++i)
      if (qp.lower[i] != qp.upper[i] && (qp.lower[i] > -infinity || qp.upper[i] < infinity))
        variables[i] = random.log_uniform(1e-2, 1e2);
    for (int i = 0; i < rows.size(); ++i)
      rows[i] = qp.row_lower[i] == qp.row_upper[i] ? infinity
                : qp.row_lower[i] > -infinity || qp.row_upper[i] < infinity
                    ? random.log_uniform(1e-2, 1e2)
                    : 0.0;
  }
  VectorXd variables, rows;
};

// Residuals of the equations after a step, for variables that are not fixed and rows with a weight.
struct Left {
  VectorXd variables, rows;
};
Left with_exit_guard(const qp::SparseQp& qp, const Weights& weights, const VectorXd& rw,
                     const VectorXd& rr, const VectorXd& dw, const VectorXd& dlambda) {
  Left left{rw + weights.variables.cwiseProduct(dw), rr};
  qp.hessian_pattern.for_each([&](int a, int b, int e) {
    left.variables[a] += qp.hessian[e] * dw[b];
    if (a != b) left.variables[b] += qp.hessian[e] * dw[a];
  });
  qp.row_pattern.for_each([&](int r, int v, int e) {
    left.rows[r] += qp.rows[e] * dw[v];
    left.variables[v] += qp.rows[e] * dlambda[r];
  });
  for (int i = 0; i < rw.size(); ++i)
    if (qp.lower[i] == qp.upper[i]) left.variables[i] = 0.0;
  for (int i = 0; i < rr.size(); ++i)
    left.rows[i] = weights.rows[i] > 0.0 ? left.rows[i] - dlambda[i] / weights.rows[i] : 0.0;
  return left;
}

void expect_solved(const qp::SparseQp& qp, const Weights& weights, qp::NewtonSystem& system,
                   Random& random, int refinements) {
  const int n = qp.variables(), m = qp.row_pattern.rows();
  const VectorXd rw = random.vector(n), rr = random.vector(m);
  VectorXd dw(n), dlambda(m), more_w(n), more_lambda(m);
  system.solve(rw, rr, dw, dlambda);
  Left left = with_exit_guard(qp, weights, rw, rr, dw, dlambda);
  for (; refinements > 0; --refinements) {
    system.solve(left.variables, left.rows, more_w, more_lambda);
    dw += more_w;
    dlambda += more_lambda;
    left = with_exit_guard(qp, weights, rw, rr, dw, dlambda);
  }
  const double size = 1.0 + dw.lpNorm<Eigen::Infinity>() + dlambda.lpNorm<Eigen::Infinity>() +
                      weights.variables.cwiseProduct(dw).lpNorm<Eigen::Infinity>();
  EXPECT_LE(left.variables.lpNorm<Eigen::Infinity>(), accurate * size);
  EXPECT_LE(left.rows.lpNorm<Eigen::Infinity>(), accurate * size);
  for (int i = 0; i < n; ++i)
    if (qp.lower[i] == qp.upper[i]) {
      EXPECT_EQ(dw[i], 0.0) << "variable " << i;
    }
  for (int i = 0; i < m; ++i)
    if (weights.rows[i] == 0.0) {
      EXPECT_NEAR(dlambda[i], 0.0, accurate * size) << "row " << i;
    }
}

TEST_P(NewtonSystemOf, SolvesItsEquations) {
  for (unsigned seed = 1; seed <= programs; ++seed) {
    RandomStaged staged(seed, /*whole_diagonal=*/true);
    const auto system = make(staged.qp, staged.structure);
    ASSERT_NE(system, nullptr);
    Random random(seed);
    for (int draw = 0; draw < 3; ++draw) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << " draw " << draw);
      if (draw > 0) staged.draw();
      ASSERT_TRUE(system->load(staged.qp));
      const Weights weights(staged.qp, random);
      ASSERT_TRUE(system->factor(weights.variables, weights.rows));
      expect_solved(staged.qp, weights, *system, random, /*refinements=*/0);
    }
  }
}

// Every factorisation gives the same step and is tried once. Stages have one more factorisation.
TEST_P(NewtonSystemOf, OtherFactorisationGivesTheSameSolution) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RandomStaged staged(seed, /*whole_diagonal=*/true);
    Random random(seed);
    const Weights weights(staged.qp, random);
    const auto ways = [&](Kind kind) {
      const auto system = make(staged.qp, staged.structure, kind);
      EXPECT_TRUE(system->load(staged.qp));
      EXPECT_TRUE(system->factor(weights.variables, weights.rows));
      int count = 1;
      for (; count < 20 && system->factor_with_fallback(); ++count)
        if (kind == GetParam())
          expect_solved(staged.qp, weights, *system, random, /*refinements=*/8);
      return count;
    };
    EXPECT_EQ(ways(Kind::sparse), 6);  // five regularisations and pivots
    EXPECT_EQ(ways(Kind::by_stages), 7);
  }
}

// The step ignores an equation between fixed variables, with every factorisation.
TEST(SparseNewton, HandlesAnEquationOfFixedVariables) {
  qp::SparseQp qp(SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 1}}),
                  SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}}));
  qp.hessian << 1.0, 2.0;
  qp.rows << 1.0, 0.5, 1.0;
  qp.lower[0] = qp.upper[0] = 1.0;
  qp.row_lower << 1.0, 0.0;
  qp.row_upper << 1.0, 0.0;
  const auto system = qp::make_sparse_newton(qp.hessian_pattern, qp.row_pattern);
  ASSERT_TRUE(system->load(qp));
  ASSERT_TRUE(system->factor(VectorXd::Zero(2), VectorXd::Constant(2, infinity)));
  int ways = 1;
  do {
    VectorXd dw(2), dlambda(2);
    system->solve(Vec<double, 2>(0.0, 1.0), Vec<double, 2>(0.0, 3.0), dw, dlambda);
    EXPECT_EQ(dw[0], 0.0) << ways;
    EXPECT_NEAR(dw[1], -3.0, 1e-4) << ways;  // regularisation of 1e-6 and less
    EXPECT_NEAR(dlambda[1], 5.0, 1e-4) << ways;
  } while (system->factor_with_fallback() && ++ways < 20);
  EXPECT_EQ(ways, 6);
}

// A restart discards the settings learned from one program.
TEST(SparseNewton, RestartTakesTheSameStep) {
  RandomStaged staged(3, /*whole_diagonal=*/true);
  Random random(3);
  const qp::SparseQp& qp = staged.qp;
  const Weights weights(qp, random);
  const VectorXd rw = random.vector(qp.variables()), rr = random.vector(qp.row_pattern.rows());
  const auto system = qp::make_sparse_newton(qp.hessian_pattern, qp.row_pattern);
  VectorXd first = rw, dw = rw, dlambda = rr;
  ASSERT_TRUE(system->load(qp) && system->factor(weights.variables, weights.rows));
  system->solve(rw, rr, first, dlambda);
  ASSERT_TRUE(system->factor_with_fallback());
  ASSERT_TRUE(system->factor(weights.variables, weights.rows));  // with the last good settings
  system->solve(rw, rr, dw, dlambda);
  EXPECT_NE(dw, first);
  system->restart();
  ASSERT_TRUE(system->factor(weights.variables, weights.rows));
  system->solve(rw, rr, dw, dlambda);
  EXPECT_EQ(dw, first);
}

// The curvature of a slack eliminates the slack.
TEST(RiccatiNewton, RejectsASlackWithoutCost) {
  RandomStaged staged(8, /*whole_diagonal=*/true);
  Random random(8);
  Weights weights(staged.qp, random);
  const int slack = staged.structure.soft_rows.front().below;
  ASSERT_GE(slack, 0);
  const auto system =
      qp::make_riccati_newton(staged.qp.hessian_pattern, staged.qp.row_pattern, staged.structure);
  const auto works = [&] {
    return system->load(staged.qp) && system->factor(weights.variables, weights.rows);
  };
  EXPECT_TRUE(works());
  staged.qp.hessian[staged.qp.hessian_pattern.find(slack, slack)] = 0.0;
  EXPECT_TRUE(works());  // the weight of its bound suffices
  weights.variables[slack] = 0.0;
  EXPECT_FALSE(works());
}

TEST_P(NewtonSystemOf, RejectsNonFiniteAndNonConvexSystems) {
  RandomStaged staged(3, /*whole_diagonal=*/true);
  Random random(3);
  qp::SparseQp& qp = staged.qp;
  const Weights weights(qp, random);
  const auto system = make(qp, staged.structure);
  const auto works = [&] {
    return system->load(qp) && system->factor(weights.variables, weights.rows);
  };
  EXPECT_TRUE(works());
  for (VectorXd* values : {&qp.hessian, &qp.rows}) {
    const double right = (*values)[0];
    (*values)[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(system->load(qp));
    (*values)[0] = right;
    EXPECT_TRUE(works());
  }
  const VectorXd right = qp.hessian;
  qp.hessian *= -1e3;
  EXPECT_FALSE(works());
  qp.hessian = right;
  EXPECT_TRUE(works());
}

}  // namespace
}  // namespace saltus
