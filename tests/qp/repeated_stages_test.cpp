// Repeated stages, as a controller has them. Equal rows, costs and dynamics are stored once, states
// that pass on an earlier input are copied, and inputs may be held. None of this may change the
// optimum, so the sparse solver, which does not use stages, is the reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "tests/support/random_qp.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus {
namespace {

constexpr int programs = 200;
constexpr double required = 1e-8;  // relative error of cost; residuals in units of the multipliers

// The first `own` states follow dynamics. The others are the inputs of the previous stage.
struct Sizes {
  int own, inputs, first_copied;
  int states() const { return own + first_copied; }
};

qp::Stage repeated_stage(const Sizes& sizes, Random& random, qp::Stage s) {
  const int nx = sizes.states(), nu = sizes.inputs, m = sizes.first_copied;
  s.A.setZero();
  s.B.setZero();
  s.A.topLeftCorner(sizes.own, sizes.own) = 0.6 * random.matrix(sizes.own, sizes.own);
  s.B.topRows(sizes.own) = random.matrix(sizes.own, nu);
  s.B.block(sizes.own, nu - m, m, m).setIdentity();
  s.b.head(sizes.own) = 0.1 * random.vector(sizes.own);
  const MatrixXd root = random.matrix(nx + nu, nx + nu);
  const MatrixXd H =
      root * root.transpose() / (nx + nu) + 0.1 * MatrixXd::Identity(nx + nu, nx + nu);
  s.Q = H.topLeftCorner(nx, nx);
  s.S = H.bottomLeftCorner(nu, nx);
  s.R = H.bottomRightCorner(nu, nu);
  s.q = random.vector(nx);
  s.r = random.vector(nu);
  s.u_lower.setConstant(-0.5);
  s.u_upper.setConstant(0.7);
  if (random.chance(0.3)) s.u_lower[0] = s.u_upper[0] = 0.05;  // held

  qp::RowGroup& hard = s.groups[0];  // on inputs: held inputs are compatible with these bounds
  hard.rows = 2;
  for (int j = 0; j < nu; ++j) hard.columns.push_back(nx + j);
  hard.M = random.matrix(2, nu);
  hard.lower.setConstant(-0.4);
  hard.upper.setConstant(0.3);
  qp::RowGroup& soft = s.groups[1];
  soft.rows = 3;
  for (int j = 0; j < sizes.own; ++j) soft.columns.push_back(j);
  soft.M = random.matrix(3, sizes.own);
  soft.lower.setConstant(random.chance(0.5) ? -0.2 : -infinity);
  soft.upper.setConstant(0.1);
  soft.l1.setConstant(random.chance(0.5) ? 0.3 : 0.0);
  soft.l2.setConstant(2.0);
  return s;
}

// Equal stages. With `changes`, stages from the middle on differ. Linear costs differ in every
// stage.
qp::StageQp repeated_stages(int seed, bool changes) {
  Random random(seed);
  const int inputs = random.integer(1, 14);
  const Sizes sizes{random.integer(1, 6), inputs,
                    random.chance(0.7) ? random.integer(1, inputs) : 0};
  const qp::StageCapacity inner{sizes.states(), inputs, {{2, inputs, false}, {3, sizes.own, true}}};
  std::vector<qp::StageCapacity> capacity(random.integer(4, 9), inner);
  capacity.push_back({sizes.states(), 0, {}});
  qp::StageQp qp(capacity);
  const qp::Stage empty = qp.stages.front();
  const qp::Stage first = repeated_stage(sizes, random, empty),
                  second = repeated_stage(sizes, random, empty);
  for (int k = 0; k < qp.intervals(); ++k) {
    qp.stages[k] = changes && 2 * k >= qp.intervals() ? second : first;
    if (changes) qp.stages[k].r = random.vector(inputs);
  }
  qp.stages.back().Q.setIdentity();
  qp.start = 0.5 * random.vector(sizes.states());
  return qp;
}

class RepeatedStages : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Stages, RepeatedStages, ::testing::Values(false, true),
                         [](const auto& param) {
                           return param.param ? "change_once" : "are_equal";
                         });

void expect_optimum(const qp::StageQp& qp, int seed) {
  qp::StagePoint point(qp);
  const qp::QpResult structured = qp::make_riccati_solver(qp)->solve(qp, point, /*warm=*/false);
  const qp::SparseQp sparse = to_sparse(qp);
  PrimalDualPoint other{VectorXd::Zero(sparse.variables()),
                        VectorXd::Zero(sparse.row_pattern.rows()),
                        VectorXd::Zero(sparse.variables())};
  const qp::QpResult expected =
      qp::make_sparse_qp_solver(sparse.hessian_pattern, sparse.row_pattern)
          ->solve(sparse, other, false);
  ASSERT_EQ(expected.status, qp::QpStatus::optimal) << "seed " << seed;
  ASSERT_EQ(structured.status, qp::QpStatus::optimal) << "seed " << seed;
  EXPECT_LE(kkt_residual(qp, point).largest(), required * testing::multiplier_scale(point))
      << "seed " << seed;
  EXPECT_NEAR(structured.objective, expected.objective,
              2.0 * required * std::max(1.0, std::abs(expected.objective)))
      << "seed " << seed;
}

TEST_P(RepeatedStages, HaveTheOptimumOfTheSparseProgram) {
  for (int seed = 1; seed <= programs; ++seed)
    expect_optimum(repeated_stages(seed, GetParam()), seed);
}

// Equal stages from the last solve must be compared again with the present numbers.
TEST_P(RepeatedStages, AreReadAgainInTheNextSolve) {
  for (int seed = 1; seed <= programs; seed += 10) {
    const qp::StageQp first = repeated_stages(seed, GetParam());
    qp::StageQp next = first;
    for (int k = 0; k < next.intervals(); k += 2) {
      next.stages[k].groups[0].upper.array() -= 0.05;
      next.stages[k].groups[1].M *= 1.1;
      next.stages[k].A *= 0.9;
    }
    for (const qp::QpOptions::Start start :
         {qp::QpOptions::Start::least_squares, qp::QpOptions::Start::guess}) {
      qp::RiccatiOptions options;
      options.start = start;
      const auto solver = qp::make_riccati_solver(first, options);
      qp::StagePoint point(first), again(first), fresh(first);
      solver->solve(first, point, false);
      const qp::QpResult a = solver->solve(next, again, false);
      const qp::QpResult b = qp::make_riccati_solver(next, options)->solve(next, fresh, false);
      EXPECT_EQ(a.status, qp::QpStatus::optimal) << "seed " << seed;
      EXPECT_EQ(a.objective, b.objective) << "seed " << seed;
      EXPECT_EQ(a.iterations, b.iterations) << "seed " << seed;
    }
  }
}

// Each stage has the rows of the previous one except for one difference.
qp::StageQp almost_repeated_stages(int seed) {
  Random random(seed);
  const int inputs = random.integer(2, 6);
  const Sizes sizes{random.integer(2, 5), inputs, 0};
  const std::vector<qp::StageCapacity::RowGroup> groups{{2, inputs, true}, {3, sizes.own, true}};
  std::vector<qp::StageCapacity> capacity(10, {sizes.states(), inputs, groups});
  capacity.push_back({sizes.states(), 0, {}});
  qp::StageQp qp(capacity);
  const qp::Stage first = repeated_stage(sizes, random, qp.stages.front());
  for (int k = 0; k < qp.intervals(); ++k) {
    qp::Stage& s = qp.stages[k];
    s = k == 0 ? first : qp.stages[k - 1];
    qp::RowGroup &on_inputs = s.groups[0], &on_states = s.groups[1];
    if (k == 0) {
      on_inputs.l1.setConstant(0.2);
      on_inputs.l2.setConstant(1.0);
      continue;
    }
    switch (random.integer(0, 7)) {
      case 0:
      case 1:
        on_inputs.soft = !on_inputs.soft;
        break;
      case 2:
        on_states.l1[random.integer(0, 2)] += 0.5;
        break;
      case 3:
        on_states.l2[random.integer(0, 2)] *= 3.0;
        break;
      case 4:
        on_states.lower[random.integer(0, 2)] = -random.uniform(0.0, 0.1);
        break;
      case 5:
        on_states.upper[random.integer(0, 2)] = random.uniform(0.0, 0.1);
        break;
      case 6:
        on_states.M(random.integer(0, 2), random.integer(0, sizes.own - 1)) *= -2.0;
        break;
      default:  // other columns, or one row fewer
        if (on_states.columns.size() > 1)
          on_states.columns.erase(
              on_states.columns.begin() +
              random.integer(0, static_cast<int>(on_states.columns.size()) - 1));
        else
          on_states.rows = 2;
    }
  }
  qp.stages.back().Q.setIdentity();
  qp.start = 0.5 * random.vector(sizes.states());
  return qp;
}

TEST(AlmostRepeatedStages, AreNotTreatedAsRepeated) {
  for (int seed = 1; seed <= programs; ++seed) expect_optimum(almost_repeated_stages(seed), seed);
}

// The same rows in stages of different sizes. Each stage has its own positions for their entries.
TEST(RepeatedRows, StagesOfOtherSizesHaveSeparateStorage) {
  constexpr int nx = 7;
  for (int seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const auto inputs = [&](int k) { return 1 + k % 2 * (seed % 3 + 1); };
    std::vector<qp::StageCapacity> capacity;
    for (int k = 0; k < 8; ++k) capacity.push_back({nx, inputs(k), {{2, 2, false}}});
    capacity.push_back({nx, 0, {}});
    qp::StageQp qp(capacity);
    const MatrixXd rows = random.matrix(2, 2);
    for (int k = 0; k <= 8; ++k) {
      qp::Stage& s = qp.stages[k];
      s.Q.setIdentity();
      s.q = random.vector(nx);
      if (k == 8) break;
      s.R.setIdentity();
      s.A = 0.5 * random.matrix(nx, nx);
      s.B = random.matrix(nx, inputs(k));
      if (k == 0) continue;  // the start is given
      qp::RowGroup& g = s.groups[0];
      g.rows = 2;
      g.columns = {2, 5};
      g.M = rows;
      g.upper.setConstant(0.05);
    }
    expect_optimum(qp, seed);
  }
}

TEST(QpStatus, EachStatusHasItsSentence) {
  std::set<std::string> sentences;
  for (const qp::QpStatus status :
       {qp::QpStatus::optimal, qp::QpStatus::infeasible, qp::QpStatus::unbounded,
        qp::QpStatus::iteration_limit, qp::QpStatus::deadline, qp::QpStatus::numerical_failure,
        qp::QpStatus::invalid_problem}) {
    const std::string sentence = describe(status);
    ASSERT_FALSE(sentence.empty());
    EXPECT_EQ(sentence.back(), '.');
    EXPECT_TRUE(sentences.insert(sentence).second) << sentence;
  }
}

}  // namespace
}  // namespace saltus
