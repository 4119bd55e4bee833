// Meshes of unequal intervals, and nodes across which an input is held.
#include "saltus/transcription/grid.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using namespace testing_support;

OptimalControlProblem cart(Bounds duration, Window window = {},
                           InputParametrisation inputs = InputParametrisation::piecewise_constant) {
  Phase<2, 1> phase{"cart", Cart{}, duration};
  phase.inputs(inputs)
      .minimise("effort", effort)
      .minimise_at_end("time", [](auto t, const auto&) { return 0.1 * t; })
      .keep("speed limit", speed, at_most(20.0), window)
      .reach("there", position, exactly(1.0))
      .reach("at rest", speed, exactly(0.0));
  phase.guess_duration(1.0);
  OptimalControlProblem ocp("cart");
  ocp.start_at({0, 0}).then(phase).costs(CostRule::integrated);
  return ocp;
}
ShootingOptions on(std::vector<Mesh> meshes) {
  return {.meshes = std::move(meshes), .integrator = runge_kutta4()};
}

TEST(Mesh, DivisionKeepsNodesAndHoldsOnRequest) {
  const Mesh mesh{.intervals = 3};
  const Mesh finer = mesh.divided({{}, {.pieces = 2}, {}});
  EXPECT_EQ(finer.intervals, 4);
  EXPECT_EQ(finer.nodes,
            (std::vector<double>{0.0, 1.0 / 3, 1.0 / 3 + (2.0 / 3 - 1.0 / 3) / 2, 2.0 / 3, 1.0}));
  EXPECT_TRUE(finer.holds.empty());
  const Mesh held = mesh.divided({{}, {2, true}, {}});
  EXPECT_EQ(held.holds, (std::vector<char>{0, 0, 1, 0, 0}));
  ASSERT_EQ(held.input_intervals().size(), 3u);
  EXPECT_EQ(held.input_intervals()[1].count, 2);
  const Mesh again = held.divided({{.pieces = 2}, {4, true}, {}});  // the second into four
  EXPECT_EQ(again.holds, (std::vector<char>{0, 0, 0, 1, 1, 1, 0, 0}));
  EXPECT_DOUBLE_EQ(again.nodes[3], 1.0 / 3 + 1.0 / 12);
}

TEST(Mesh, GradedGrowsByOneFactor) {
  const Mesh mesh = graded_mesh(5, 16.0);
  mesh.check("phase");
  const auto length = [](const Mesh& m, int k) { return m.nodes[k + 1] - m.nodes[k]; };
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(length(mesh, k + 1) / length(mesh, k), 2.0, 1e-12);
  const Mesh both = mesh_graded_to_both_ends(9, 16.0);
  both.check("phase");
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(length(both, k), length(both, 8 - k), 1e-15);
  EXPECT_NEAR(length(both, 4) / length(both, 0), 16.0, 1e-11);
  for (const int n : {1, 2, 3, 4}) {
    graded_mesh(n, 0.1).check("phase");
    mesh_graded_to_both_ends(n, 10.0).check("phase");
  }
  EXPECT_THROW(graded_mesh(0, 2.0), DefinitionError);
  EXPECT_THROW(graded_mesh(3, -2.0), DefinitionError);
}

TEST(Mesh, NodesFollowTheMeshAndEvents) {
  const Mesh mesh{4, {0.0, 0.1, 0.2, 0.6, 1.0}, {}};
  MultipleShooting shooting(cart(exactly(2.0), {.from = 0.5, .to = 1.2}), on({mesh}));
  const Grid& grid = shooting.grid();
  ASSERT_EQ(grid.intervals(0), 5);  // 1.2 s is a node already
  const double expected[] = {0.0, 0.2, 0.4, 0.5, 1.2, 2.0};
  for (int i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(grid.node_offset(0, i), expected[i]) << i;
  EXPECT_TRUE(grid.is_event(0, 3));
  EXPECT_TRUE(grid.is_event(0, 4));
  EXPECT_FALSE(grid.is_event(0, 2));
}

TEST(Mesh, StretchesWithAFreeDuration) {
  const Mesh mesh{4, {0.0, 0.1, 0.2, 0.6, 1.0}, {}};
  MultipleShooting shooting(cart(between(0.5, 4.0)), on({mesh}));
  const Solution s = solve(shooting, *make_ipopt());
  ASSERT_TRUE(s.ok()) << s.message;
  ASSERT_EQ(s.trajectory.pieces().size(), 4u);
  const double T = s.durations[0];
  EXPECT_GT(T, 1.5);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(s.trajectory.pieces()[k].start, mesh.nodes[k] * T, 1e-12 * T);
  EXPECT_THROW(MultipleShooting(cart(between(0.5, 4.0), {.from = 0.1}), on({mesh})),
               DefinitionError);
}

// Held inputs add no freedom, so the optimum is that of the coarser mesh, with every solver.
TEST(Mesh, HeldInputsMatchTheCoarseMesh) {
  const Mesh coarse{.intervals = 5};
  MultipleShooting below(cart(exactly(1.0)), on({coarse}));
  const Solution expected = solve(below, *make_ipopt({.tolerance = 1e-11}));
  ASSERT_TRUE(expected.ok()) << expected.message;
  const Mesh held = coarse.divided({{}, {3, true}, {}, {2, true}, {}});
  MultipleShooting shooting(cart(exactly(1.0)), on({held}));
  for (const QpMethod& qp : {sparse_qp(), riccati_qp()}) {
    const Solution s = solve(shooting, *make_native_solver({.tolerance = 1e-10, .qp = qp}));
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.cost, expected.cost, 1e-8 * expected.cost);
    ASSERT_EQ(s.trajectory.pieces().size(), 8u);
    for (const Trajectory::Piece& p : s.trajectory.pieces())
      EXPECT_NEAR(p.coefficients[0], expected.trajectory.input(p.start + 0.5 * p.length)[0], 1e-7);
  }
  // Without holding, the inputs have more freedom.
  MultipleShooting freer(cart(exactly(1.0)), on({coarse.divided({{}, {3}, {}, {2}, {}})}));
  EXPECT_LT(solve(freer, *make_ipopt()).cost, expected.cost * (1.0 - 1e-4));
}

TEST(Mesh, HeldRampsContinue) {
  OptimalControlProblem ramps = cart(exactly(1.0), {}, InputParametrisation::piecewise_linear);
  const Mesh coarse{.intervals = 4};
  MultipleShooting below(ramps, on({coarse}));
  const Solution expected = solve(below, *make_ipopt({.tolerance = 1e-11}));
  ASSERT_TRUE(expected.ok()) << expected.message;
  MultipleShooting shooting(ramps, on({coarse.divided({{}, {3, true}, {2, true}, {}})}));
  const Solution s = solve(shooting, *make_native_solver({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, expected.cost, 1e-8 * expected.cost);
  EXPECT_THROW(shooting.stages(), DefinitionError);
}

TEST(Mesh, RampsContinueOverHeldNodesOnly) {
  // All intervals have the same length.
  const Mesh mesh = Mesh{.intervals = 3}.divided({{2, true}, {2, true}, {2, true}});
  MultipleShooting shooting(cart(exactly(1.0), {}, InputParametrisation::piecewise_linear),
                            on({mesh}));
  const NonlinearProgram& nlp = shooting.nlp();
  int found = 0;
  for (int row = 0; row < nlp.rows(); ++row)
    for (int node = 1; node < 6; ++node)
      for (const char* what : {"slope", "continuity"}) {
        const std::string name = fmt::format("{} at node {},", what, node);
        if (nlp.describe_row(row).find(name) == std::string::npos) continue;
        ++found;
        EXPECT_EQ(nlp.row_upper()[row], node % 2 == 1 ? 0.0 : infinity) << name;
        EXPECT_EQ(nlp.row_lower()[row], -nlp.row_upper()[row]) << name;
      }
  EXPECT_EQ(found, 10);
}

TEST(Mesh, HoldsInputsOfAFreePhaseForAnyNodes) {
  for (const std::vector<double>& nodes :
       {std::vector<double>{}, std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0}}) {
    MultipleShooting shooting(cart(between(0.5, 2.0)),
                              on({Mesh{.intervals = 4, .nodes = nodes, .holds = {0, 1, 0, 1, 0}}}));
    for (int node = 0; node <= 4; ++node)
      EXPECT_EQ(shooting.grid().holds_input(0, node), node % 2 == 1) << nodes.size() << " " << node;
  }
}

TEST(Mesh, EventEndsAHold) {
  const Mesh held = Mesh{.intervals = 2}.divided({{2, true}, {2, true}});
  OptimalControlProblem ocp = cart(exactly(1.0), {.from = 0.25});
  MultipleShooting shooting(ocp, on({held}));
  EXPECT_FALSE(shooting.grid().holds_input(0, 1));  // the event is at this node
  EXPECT_TRUE(shooting.grid().holds_input(0, 3));
}

TEST(Mesh, RejectsCountsThatCannotBeAllocated) {
  for (const int count : {Mesh::most_intervals + 1, 2000000000}) {
    const std::string number = std::to_string(count);
    expect_error<DefinitionError>([&] { Mesh{.intervals = count}.check("ride"); },
                                  {"phase 'ride'", number, "1000000"});
    expect_error<DefinitionError>([&] { graded_mesh(count, 2.0); }, {"graded mesh", number});
    expect_error<DefinitionError>([&] { mesh_graded_to_both_ends(count, 2.0); },
                                  {"graded mesh", number});
    expect_error<DefinitionError>([&] { runge_kutta4({.steps = count}); }, {number, "steps"});
    expect_error<DefinitionError>([&] { radau_iia({.steps = count}); }, {number, "steps"});
  }
}

TEST(Mesh, RejectsInvalidMeshes) {
  const auto refusal = [](const Mesh& mesh) {
    return error_of<DefinitionError>([&] { MultipleShooting(cart(exactly(1.0)), on({mesh})); });
  };
  EXPECT_NE(refusal({.intervals = 0}).find("phase 'cart': it has 0 intervals"), std::string::npos);
  EXPECT_NE(refusal({2, {0.0, 1.0}, {}}).find("2 nodes for 2 intervals, expected 3"),
            std::string::npos);
  EXPECT_NE(refusal({2, {0.0, 0.5, 0.9}, {}}).find("expected from 0 to 1"), std::string::npos);
  EXPECT_NE(refusal({3, {0.0, 0.5, 0.5, 1.0}, {}}).find("expected increasing fractions"),
            std::string::npos);
  EXPECT_NE(refusal({2, {}, {0, 1}}).find("2 hold flags"), std::string::npos);
  EXPECT_THROW(MultipleShooting(cart(exactly(1.0)), on({Mesh{}, Mesh{}})), DefinitionError);
}

}  // namespace
}  // namespace saltus
