// Compares the push recovery problem with an independent dense solution. The capture point moves
// along the edge of the hull, also at the end of the horizon. The impact falls between two grid
// nodes, also with a penalty on first differences there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "problems/push_recovery/problem.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/problems/dense_step_recovery.hpp"

namespace saltus::push_recovery {
namespace {

using saltus::testing::DenseQpResult;
using saltus::testing::DenseStepRecovery;
using saltus::testing::StepRecovery;

struct Instance {
  const char* name;
  StepRecovery data;
  double optimum;                ///< stored optimum of the dense solution
  std::vector<double> binds_at;  ///< times at which the row y >= hull_y[0] is active, s

  friend void PrintTo(const Instance& instance, std::ostream* out) { *out << instance.name; }
};

// ICUB-1 with another push, hull and impact; all other data are unchanged.
StepRecovery icub_1_but(double lateral_speed, double hull_edge, double impact,
                        double wrench_change = 0.0) {
  StepRecovery s;
  s.velocity[1] = lateral_speed;
  s.hull_y[0] = hull_edge;
  s.impact = impact;
  s.wrench_change = wrench_change;
  return s;
}

const std::vector<Instance> instances{
    {"Original", icub_1_but(-0.35, -0.15, 0.06), 0.969874238, {}},
    {"FasterInSmallerHull", icub_1_but(-0.5, -0.09, 0.06), 1.7608026520309, {0.06, 0.07, 0.15}},
    {"LaterInSmallerHull",
     icub_1_but(-0.5, -0.09, 0.10),
     2.7306528562567,
     {0.10, 0.11, 0.12, 0.15}},
    {"TwiceAsFast", icub_1_but(-0.7, -0.15, 0.06), 3.9274370958304, {0.06, 0.15}},
    {"BetweenTwoNodes", icub_1_but(-0.5, -0.09, 0.0637), 1.8138277330938, {0.0637, 0.07, 0.15}},
    {"BetweenTwoNodesWithDifferences",
     icub_1_but(-0.5, -0.09, 0.0637, 1e-4),
     2.4958793209712,
     {0.0637, 0.15}},
};

// The same data as a problem of the framework.
MultipleShooting transcribe(const StepRecovery& s) {
  Model model;
  model.mass = s.mass;
  robots::ContactCone::Options contact;
  contact.friction = s.friction;
  contact.edges = 4;
  contact.pyramid = robots::ContactCone::Pyramid::circumscribed;
  contact.foot = {between(s.foot_x[0], s.foot_x[1]), between(s.foot_y[0], s.foot_y[1])};
  contact.torsional_friction = s.torsion;
  contact.normal_force = at_least(s.normal_min);
  model.left_contact = model.right_contact = contact;
  model.step = s.step;
  model.intervals = s.intervals;

  const auto constant = [](double value) { return Vec<double, 3>::Constant(value); };
  Weights weights;
  weights.gamma << s.com_weight, s.velocity_weight, constant(s.momentum_weight);
  weights.gamma_impact << constant(s.com_impact_weight), constant(s.velocity_impact_weight),
      constant(s.momentum_impact_weight);
  weights.wrench << s.force_weight, constant(s.torque_weight);
  weights.wrench_change = s.wrench_change;
  weights.capture_point = Vec<double, 2>::Constant(s.capture_point_weight);
  weights.capture_point_penalty = 0.0;

  Tick<double> data;
  data.com = s.com;
  data.force = s.force;
  data.omega = std::sqrt(s.gravity / s.com[2]);
  data.left_foot = s.left_foot;
  data.right_foot = s.right_foot;
  data.gamma_desired.head<3>() = s.com_desired;
  data.capture_point_desired = s.com_desired.head<2>();
  Mat<double, 4, 2> corners;
  corners << s.hull_x[0], s.hull_y[0], s.hull_x[1], s.hull_y[0], s.hull_x[1], s.hull_y[1],
      s.hull_x[0], s.hull_y[1];
  data.set_hull(robots::SupportPolygon::hull(corners).half_planes(hull_rows));

  OptimalControlProblem ocp = problem(model, weights, data, walking::one_foot_then_two(s.impact));
  VectorXd start(9);
  start << s.com, s.velocity, Vec<double, 3>::Zero();
  ocp.start_at(start);
  MultipleShooting shooting(std::move(ocp),
                            {.intervals_per_phase = s.intervals, .integrator = zero_order_hold()});
  VectorXd before = VectorXd::Zero(12);
  before.head<3>() = s.force;
  shooting.set_previous_input(before);
  return shooting;
}

// Multipliers of the lower edge in y, summed over the rows that repeat it. The key is the time in
// microseconds.
std::map<long, double> edge_multipliers(MultipleShooting& shooting, const VectorXd& lambda) {
  std::map<long, double> result;
  NonlinearProgram& nlp = shooting.nlp();
  const std::string term = "phase 'step', term 'capture point in hull', row ";
  for (int row = 0; row < nlp.rows(); ++row) {
    const std::string what = nlp.describe_row(row);
    if (what.compare(0, term.size(), term) != 0 || std::isinf(nlp.row_upper()[row])) continue;
    int edge = 0;
    double time = 0.0;
    EXPECT_EQ(std::sscanf(what.c_str() + term.size(), "%d at t = %lf s", &edge, &time), 2) << what;
    EXPECT_GT(lambda[row], -1e-7) << what;  // upper bounds; accuracy of Ipopt
    // Rows of the box follow one another counter-clockwise and repeat; y min is the first.
    if (edge % 4 == 0) result[std::lround(1e6 * time)] += lambda[row];
  }
  EXPECT_FALSE(result.empty());
  return result;
}

class BindingRows : public ::testing::TestWithParam<Instance> {};

TEST_P(BindingRows, AgreeWithADenseSolution) {
  const StepRecovery& s = GetParam().data;
  const DenseStepRecovery dense = build(s);
  const DenseQpResult expected = saltus::testing::solve(dense.qp);
  ASSERT_TRUE(expected.optimal) << expected.residual;
  EXPECT_NEAR(expected.cost, GetParam().optimum, 1e-8 * GetParam().optimum);  // stored value

  MultipleShooting shooting = transcribe(s);
  // The sum of 700 complementarity gaps is below the required accuracy of the cost.
  const auto solver = make_ipopt({.tolerance = 1e-11});
  const Solution solution = solve(shooting, *solver);
  // The test compares rows at the nodes; between nodes the violation reaches 2e-5.
  ASSERT_TRUE(solution.ok() || solution.status == SolveStatus::coarse_grid) << solution.message;
  EXPECT_NEAR(solution.cost, expected.cost, 1e-8 * expected.cost);

  const auto& pieces = solution.trajectory.pieces();
  ASSERT_EQ(static_cast<int>(pieces.size()), dense.nodes() - 1);
  double state_error = 0.0, wrench_error = 0.0;
  for (int k = 0; k + 1 < dense.nodes(); ++k) {
    EXPECT_NEAR(pieces[k].start, dense.times[k], 1e-12);
    state_error =
        std::max(state_error,
                 (pieces[k].state - expected.z.segment(dense.state(k), 9)).cwiseAbs().maxCoeff());
    wrench_error = std::max(
        wrench_error,
        (pieces[k].coefficients - expected.z.segment(dense.input(k), 12)).cwiseAbs().maxCoeff());
  }
  state_error = std::max(state_error, (solution.trajectory.final_state() -
                                       expected.z.segment(dense.state(dense.nodes() - 1), 9))
                                          .cwiseAbs()
                                          .maxCoeff());
  EXPECT_LT(state_error, 1e-6);   // m, m/s, Nms
  EXPECT_LT(wrench_error, 1e-2);  // N, Nm

  // The same rows are active, with the same multipliers.
  const std::map<long, double> multipliers = edge_multipliers(shooting, solution.point.lambda);
  std::vector<double> binding;
  double multiplier_error = 0.0, largest_multiplier = 0.0;
  for (int node = 0; node < dense.nodes(); ++node) {
    if (dense.hull_row[node] < 0) continue;
    const double multiplier = expected.w[dense.hull_row[node] + 3];
    EXPECT_GE(multiplier, 0.0);
    if (multiplier > 0.0) binding.push_back(dense.times[node]);
    ASSERT_TRUE(multipliers.contains(std::lround(1e6 * dense.times[node]))) << dense.times[node];
    multiplier_error =
        std::max(multiplier_error,
                 std::abs(multipliers.at(std::lround(1e6 * dense.times[node])) - multiplier));
    largest_multiplier = std::max(largest_multiplier, multiplier);
  }
  ASSERT_EQ(binding.size(), GetParam().binds_at.size());
  for (std::size_t i = 0; i < binding.size(); ++i)
    EXPECT_NEAR(binding[i], GetParam().binds_at[i], 1e-12);
  EXPECT_LT(multiplier_error, 1e-5 * std::max(1.0, largest_multiplier));
  const auto record = [](const char* what, double value) {
    RecordProperty(what, fmt::format("{:.3g}", value));
  };
  record("relative_cost_error", solution.cost / expected.cost - 1.0);
  record("state_error", state_error);
  record("wrench_error", wrench_error);
  record("multiplier_error", multiplier_error);
  record("largest_multiplier", largest_multiplier);
}

INSTANTIATE_TEST_SUITE_P(Instances, BindingRows, ::testing::ValuesIn(instances),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace saltus::push_recovery
