// Errors of public values that are empty or moved from, or that are accessed with an invalid index
// or a NaN time. Each access throws a DefinitionError, except for a tick, which never throws and
// uses the fallback.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/simulation/plants.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Expects a DefinitionError of one sentence that contains this word.
template <class Access>
void expect_refused(const char* word, const Access& access) {
  expect_error<DefinitionError>(access, {word});
  EXPECT_LT(error_of<DefinitionError>(access).size(), 200u) << word;
}

OptimalControlProblem integrator() {
  Phase<1, 1> phase{
      "drive",
      [](const auto&, const auto& x, const auto& u) { return std::decay_t<decltype(x)>(u[0]); },
      exactly(1.0)};
  phase
      .reach(
          "end", [](const auto&, const auto& x) { return x[0]; }, exactly(1.0))
      .track(
          "effort", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{1.0});
  OptimalControlProblem problem("drive");
  problem.start_at({0.0}).then(phase);
  return problem;
}

OptimalControlProblem two_phases() {
  Phase<1, 1> first{
      "first",
      [](const auto&, const auto& x, const auto& u) { return std::decay_t<decltype(x)>(u[0]); },
      exactly(0.5)};
  first.track(
      "effort", [](const auto&, const auto&, const auto& u) { return u; }, Vec<double, 1>{1.0});
  Phase<1, 1> second = first;
  OptimalControlProblem problem("two");
  problem.start_at({0.0}).then(first).then(second);
  return problem;
}

MultipleShooting shooting_of(OptimalControlProblem problem) {
  return {std::move(problem), {.intervals_per_phase = 5, .integrator = runge_kutta4()}};
}
RecedingHorizonController controller() { return {shooting_of(integrator()), {.period = 0.02}}; }
ShrinkingHorizonController shrinking() {
  const OptimalControlProblem problem = two_phases();
  return {problem, remaining_controllers(
                       problem, {.intervals_per_phase = 5, .integrator = runge_kutta4()},
                       [](MultipleShooting rest) {
                         return RecedingHorizonController(std::move(rest), {.period = 0.02});
                       })};
}

void expect_empty(const Trajectory& empty) {
  EXPECT_TRUE(empty.empty());
  expect_refused("empty", [&] { empty.state(0.0); });
  expect_refused("empty", [&] { empty.state_before(0.0); });
  expect_refused("empty", [&] { empty.input(0.0); });
  expect_refused("empty", [&] { empty.algebraic(0.0); });
  expect_refused("empty", [&] { empty.piece_at(0.0); });
  expect_refused("empty", [&] { empty.start_time(); });
  expect_refused("empty", [&] { empty.end_time(); });
  expect_refused("empty", [&] { empty.final_state(); });
  expect_refused("0 phases", [&] { empty.after(0); });
  expect_refused("phase 0", [&] { empty.state_in({}, 0.0); });
  expect_refused("phase 0", [&] { empty.input_in({}, 0.0); });
  std::ostringstream text;
  empty.write_csv(text);
  EXPECT_EQ(text.str(), "t,phase\n");
}

TEST(EmptyTrajectory, RejectsEveryAccess) {
  expect_empty(Trajectory());
  Solution solution = solve(integrator());
  ASSERT_TRUE(solution.ok()) << solution.message;
  const Solution taken = std::move(solution);
  expect_empty(solution.trajectory);  // NOLINT(bugprone-use-after-move): tested here
  Trajectory plan = taken.trajectory;
  const Trajectory other = std::move(plan);
  expect_empty(plan);  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(other.state(0.3), taken.trajectory.state(0.3));
  expect_empty(Solution().trajectory);
}

TEST(Trajectory, RejectsNanTimesAndMissingPhases) {
  const Solution solution = solve(integrator());
  const Trajectory& plan = solution.trajectory;
  expect_refused("NaN", [&] { plan.state(nan); });
  expect_refused("NaN", [&] { plan.state_before(nan); });
  expect_refused("NaN", [&] { plan.input(nan); });
  expect_refused("NaN", [&] { plan.algebraic(nan); });
  expect_refused("NaN", [&] { plan.piece_at(nan); });
  expect_refused("NaN", [&] { plan.state_in(plan.pieces().front(), nan); });
  expect_refused("NaN", [&] { plan.input_in(plan.pieces().front(), nan); });
  EXPECT_EQ(plan.state(infinity), plan.final_state());
  EXPECT_EQ(plan.state(-infinity), plan.pieces().front().state);
  EXPECT_EQ(plan.state_before(infinity), plan.final_state());
  EXPECT_EQ(plan.input(-infinity), plan.pieces().front().coefficients);
  for (const int phases : {-1, 1, 100000})
    expect_refused("none remains", [&] { plan.after(phases); });
  Trajectory::Piece foreign = plan.pieces().front();
  for (const int phase : {-1, 1, 100000}) {
    foreign.phase = phase;
    expect_refused("phase", [&] { plan.state_in(foreign, 0.1); });
    expect_refused("phase", [&] { plan.input_in(foreign, 0.1); });
    expect_refused("phase", [&] { (void)Trajectory(plan.phases(), {foreign}); });
  }
}

TEST(Trajectory, IsCheckedAtConstruction) {
  const Solution solution = solve(integrator());
  const std::vector<Trajectory::PhaseInfo> phases = solution.trajectory.phases();
  const Trajectory::Piece piece = solution.trajectory.pieces().front();
  const auto refuse = [&](const char* word, const auto& edit) {
    std::vector<Trajectory::PhaseInfo> other = phases;
    Trajectory::Piece wrong = piece;
    edit(other.front(), wrong);
    expect_refused(word, [&] { (void)Trajectory(other, {wrong}); });
  };
  refuse("integrator", [](auto& phase, auto&) { phase.integrator.reset(); });
  refuse("parameters", [](auto& phase, auto&) { phase.parameters = VectorXd::Zero(3); });
  refuse("state", [](auto&, auto& p) { p.state = VectorXd(); });
  refuse("end state", [](auto&, auto& p) { p.end_state = VectorXd(); });
  refuse("input", [](auto&, auto& p) { p.coefficients = VectorXd::Zero(2); });
  expect_refused("scheme", [&] {
    (void)ReentrantIntegrator(phases.front().integrator->problem(), IntegratorChoice());
  });
}

// Times of a plan may be NaN after a failed solve. The plan then returns NaN.
TEST(Trajectory, NanPointGivesNan) {
  Phase<1, 1> phase{
      "free",
      [](const auto&, const auto& x, const auto& u) { return std::decay_t<decltype(x)>(u[0]); },
      between(0.5, 2.0)};
  phase.minimise_at_end("time", [](const auto& t, const auto&) { return t; });
  OptimalControlProblem problem("free");
  problem.start_at({0.0}).then(phase);
  MultipleShooting shooting = shooting_of(problem);
  const VectorXd w = VectorXd::Constant(shooting.nlp().variables(), nan);
  const Trajectory plan = shooting.trajectory(w);
  EXPECT_TRUE(plan.state(nan).hasNaN());
  EXPECT_TRUE(plan.input(0.3).hasNaN());
  shooting.guess_from(plan);
  NlpResult failed;
  failed.status = SolveStatus::numerical_failure;
  failed.point.w = w;
  EXPECT_FALSE(shooting.interpret(failed, 3).ok());
}

TEST(Replay, RejectsAPlanOfAnotherProblem) {
  const Solution solution = solve(integrator());
  expect_refused("phases", [&] { replay(integrator(), Trajectory(), runge_kutta4()); });
  expect_refused("phases", [&] { replay(two_phases(), solution.trajectory, runge_kutta4()); });
}

TEST(MovedFromMultipleShooting, RejectsEveryAccess) {
  MultipleShooting shooting = shooting_of(integrator());
  const VectorXd w = shooting.initial_guess().w;
  expect_refused("variables", [&] { shooting.trajectory(VectorXd()); });
  const MultipleShooting other = std::move(shooting);
  // NOLINTBEGIN(bugprone-use-after-move)
  expect_refused("moved from", [&] { shooting.nlp(); });
  expect_refused("moved from", [&] { shooting.problem(); });
  expect_refused("moved from", [&] { shooting.data(); });
  expect_refused("moved from", [&] { shooting.grid(); });
  expect_refused("moved from", [&] { shooting.layout(); });
  expect_refused("moved from", [&] { shooting.program(); });
  expect_refused("moved from", [&] { shooting.editable_program(); });
  expect_refused("moved from", [&] { shooting.stages(); });
  expect_refused("moved from", [&] { shooting.start_at(0.0, VectorXd::Zero(1)); });
  expect_refused("moved from", [&] { shooting.start_time(0.0); });
  expect_refused("moved from", [&] { shooting.set_remaining({}, {}); });
  expect_refused("moved from", [&] { shooting.set_data("d", VectorXd::Zero(1)); });
  expect_refused("moved from", [&] { shooting.retime("e", 0.0); });
  expect_refused("moved from", [&] { shooting.set_schedule({}); });
  expect_refused("moved from", [&] { shooting.set_previous_input(VectorXd::Zero(1)); });
  expect_refused("moved from", [&] { shooting.set_penalty_weight("w", 1.0); });
  expect_refused("moved from", [&] { shooting.initial_guess(); });
  expect_refused("moved from", [&] { shooting.guess_from(Trajectory()); });
  expect_refused("moved from", [&] { shooting.trajectory(w); });
  expect_refused("moved from", [&] { shooting.interpret({}); });
  expect_refused("moved from", [&] { current_problem(shooting); });
  expect_refused("moved from", [&] { (void)RecedingHorizonController(std::move(shooting), {}); });
  // NOLINTEND(bugprone-use-after-move)
}

TEST(Controller, RejectsMissingPhases) {
  RecedingHorizonController c = controller();
  c.tick(0.0, VectorXd::Zero(1));
  EXPECT_NEAR(c.end_of_phase(0), 1.0, 1e-12);
  for (const int phase : {-1, 1, 7, 100000})
    expect_refused("phase", [&] { (void)c.end_of_phase(phase); });
  expect_refused("empty", [&] { c.adopt_plan(0.0, Trajectory()); });
  EXPECT_TRUE(is_of_this_tick(c.tick(0.02, VectorXd::Zero(1)).provenance));
}

TEST(Controller, MovedFromControllerReturnsAnEmptyInput) {
  RecedingHorizonController c = controller();
  c.tick(0.0, VectorXd::Zero(1));
  const RecedingHorizonController other = std::move(c);
  // NOLINTBEGIN(bugprone-use-after-move)
  for (const ControlTick* tick :
       {&c.tick(0.02, VectorXd::Zero(1)), &c.feedback(VectorXd::Zero(1))}) {
    EXPECT_EQ(tick->provenance, Provenance::fallback);
    EXPECT_EQ(tick->status, SolveStatus::invalid_problem);
    EXPECT_TRUE(tick->input.empty());
  }
  c.prepare(0.1);
  expect_refused("moved from", [&] { c.shooting(); });
  expect_refused("moved from", [&] { c.problem(); });
  expect_refused("moved from", [&] { (void)c.solver_name(); });
  expect_refused("moved from", [&] { (void)c.end_of_phase(0); });
  expect_refused("moved from", [&] { c.report(); });
  expect_refused("moved from", [&] { c.set_data("d", VectorXd::Zero(1)); });
  expect_refused("moved from", [&] { c.retime("e", 0.0); });
  expect_refused("moved from", [&] { c.set_schedule({}); });
  expect_refused("moved from", [&] { c.set_previous_input(VectorXd::Zero(1)); });
  expect_refused("moved from", [&] { c.set_remaining({}, {}); });
  // NOLINTEND(bugprone-use-after-move)
}

TEST(ShrinkingController, RejectsPastAndMissingPhases) {
  ShrinkingHorizonController c = shrinking();
  c.tick(0.0, VectorXd::Zero(1));
  EXPECT_NEAR(c.end_of_phase(1), 1.0, 1e-12);
  for (const int phase : {-1, 2, 100000})
    expect_refused("phase", [&] { (void)c.end_of_phase(phase); });
  for (const int phase : {-1, 2, 100000})
    expect_refused("phase", [&] { (void)c.parameters_of(phase); });
  for (const int phase : {-1, 0, 2, 100000}) expect_refused("phase", [&] { c.enter(phase, 0.5); });
  expect_refused("phase", [&] { c.enter(1, nan); });
  expect_refused("empty", [&] { c.adopt_plan(Trajectory()); });
  c.enter(1, 0.5);
  c.tick(0.5, VectorXd::Zero(1));
  expect_refused("phase", [&] { (void)c.end_of_phase(0); });
  EXPECT_NEAR(c.end_of_phase(1), 1.0, 1e-12);
  expect_refused("0 controllers",
                 [&] { (void)ShrinkingHorizonController(OptimalControlProblem("none"), {}); });
}

TEST(ShrinkingController, MovedFromControllerReturnsAnEmptyInput) {
  ShrinkingHorizonController c = shrinking();
  const ShrinkingHorizonController other = std::move(c);
  // NOLINTBEGIN(bugprone-use-after-move)
  const ControlTick& tick = c.tick(0.0, VectorXd::Zero(1));
  EXPECT_EQ(tick.provenance, Provenance::fallback);
  EXPECT_TRUE(tick.input.empty());
  expect_refused("moved from", [&] { (void)c.period(); });
  expect_refused("moved from", [&] { (void)c.solver_name(); });
  expect_refused("moved from", [&] { c.definition(); });
  expect_refused("moved from", [&] { c.shooting(); });
  expect_refused("moved from", [&] { c.report(); });
  expect_refused("moved from", [&] { c.rest(); });
  expect_refused("moved from", [&] { c.adopt_plan(Trajectory()); });
  expect_refused("phase", [&] { c.enter(1, 0.5); });
  expect_refused("moved from", [&] { (void)c.end_of_phase(0); });
  // NOLINTEND(bugprone-use-after-move)
}

TEST(Function, RejectsAnEmptyHandleAndAShortArgument) {
  const Function full = integrator().phases()[0].dynamics, none;
  for (const auto& evaluate : std::vector<std::function<void(const Function&, const VectorXd&)>>{
           [](const Function& f, const VectorXd& z) { f(z); },
           [](const Function& f, const VectorXd& z) { f.dense_jacobian(z); },
           [](const Function& f, const VectorXd& z) { f.dense_hessian(z, VectorXd::Ones(1)); }}) {
    expect_refused("empty", [&] { evaluate(none, VectorXd::Zero(3)); });
    expect_refused("3 inputs", [&] { evaluate(full, VectorXd::Zero(2)); });
    evaluate(full, VectorXd::Zero(3));
  }
  expect_refused("no trajectory", [] { (void)Guess().at(0.5); });
  for (const int i : {-1, 0, 7})
    expect_refused("0 parameters", [&] { (void)integrator().phases()[0].nominal_parameter(i); });
}

TEST(HeldInput, RejectsMissingPieces) {
  const ControlTick none;
  expect_refused("piece", [&] { none.input[0]; });
  expect_refused("piece", [&] { none.input.back(); });
  RecedingHorizonController c = controller();
  ControlTick tick = c.tick(0.0, VectorXd::Zero(1));
  expect_refused("piece", [&] { tick.input[tick.input.size()]; });
  const ControlTick other = std::move(tick);
  EXPECT_TRUE(tick.input.empty());  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(tick.input.begin(), tick.input.end());
  HeldInput held(1, 1);
  expect_refused("piece", [&] { held.last(); });
  held.add();
  expect_refused("piece", [&] { held.add(); });
}

TEST(LoopLogWithoutSamples, HasNoFinalState) {
  const LoopLog log;
  expect_refused("sample", [&] { log.final_state(); });
  EXPECT_NE(log.summary_json().find("\"final_state\": []"), std::string::npos);
  EXPECT_FALSE(log.ticks_csv().empty());
  EXPECT_FALSE(log.plans_csv().empty());
}

TEST(ScheduleAccess, RejectsInvalidModesAndTimes) {
  Schedule schedule = Schedule({"a", "b"}, {{"on", 0.5}}).reserve(4);
  for (const int i : {-1, 2, 4, 100000}) {
    expect_refused("no mode", [&] { schedule.mode(i); });
    expect_refused("no mode", [&] { (void)schedule.number_of_mode(i); });
  }
  EXPECT_EQ(schedule.number_of_mode(1), 1);
  expect_refused("NaN", [&] { schedule.mode_at(nan); });
  const Schedule other = std::move(schedule);
  // NOLINTBEGIN(bugprone-use-after-move)
  EXPECT_TRUE(schedule.events().empty());
  EXPECT_TRUE(schedule.known_modes().empty());
  EXPECT_EQ(schedule.capacity(), 0);
  expect_refused("no mode", [&] { schedule.mode(0); });
  expect_refused("no mode", [&] { schedule.mode_at(0.0); });
  expect_refused("no mode", [&] { (void)schedule.number_of_mode(0); });
  expect_refused("no event", [&] { (void)schedule.time_of("on"); });
  expect_refused("no mode", [&] { schedule.replace_first("a"); });
  expect_refused("no mode", [&] { schedule.reserve(2); });
  schedule.declare({"c"});
  EXPECT_TRUE(schedule == Schedule());
  schedule = other;
  EXPECT_EQ(schedule.mode(1), "b");
  // NOLINTEND(bugprone-use-after-move)
}

TEST(ProblemAccess, RejectsInvalidIndices) {
  OptimalControlProblem problem = integrator();
  for (const int j : {-1, 1, 100000}) {
    expect_refused("phase", [&] { problem.editable_phase(j); });
    expect_refused("link", [&] { problem.editable_link(j); });
    expect_refused("phase", [&] { (void)problem.cost_rule(j); });
    expect_refused("phase", [&] { problem.after(j); });
  }
  OptimalControlProblem other = std::move(problem);
  // NOLINTBEGIN(bugprone-use-after-move)
  expect_refused("no phase", [&] { problem.check(); });
  expect_refused("no phase", [&] { problem.editable_phase(0); });
  expect_refused("phase", [&] { (void)problem.phase_index("drive"); });
  expect_refused("none remains", [&] { problem.after(0); });
  expect_refused("no phase", [&] { shooting_of(problem); });
  expect_refused("no phase", [&] { solve(problem); });
  EXPECT_FALSE(problem.set_penalty_weight("w", 1.0));
  expect_refused("no mode", [&] { problem.schedule().mode(0); });
  // NOLINTEND(bugprone-use-after-move)
  PhaseDefinition::ParameterBlock unknown;
  unknown.name = "p";
  unknown.value = VectorXd::Zero(1);
  unknown.unknown = true;
  unknown.bounds = {Bounds{}};
  other.editable_phase(0).parameters.push_back(unknown);
  for (const int i : {-1, 1, 100000})
    expect_refused("entry", [&] { (void)other.bounds_of_unknown("p", i); });
}

TEST(PlantAccess, RejectsInvalidPhasesAndMovedPlants) {
  PhasedPlant phased(integrator(), runge_kutta4());
  for (const int j : {-1, 1, 100000}) {
    expect_refused("phase", [&] { (void)phased.parameters_of(j); });
    expect_refused("phase", [&] { phased.end_phase_at(j, 1.0); });
  }
  expect_refused("NaN", [&] { phased.end_phase_at(0, nan); });
  expect_refused("not ended", [&] { (void)phased.over_since(); });
  const PhasedPlant other = std::move(phased);
  IntegratorPlant plant = nominal_plant(integrator(), runge_kutta4());
  const IntegratorPlant another = std::move(plant);
  const VectorXd input = VectorXd::Zero(other.inputs());
  // NOLINTBEGIN(bugprone-use-after-move)
  expect_refused("phase", [&] { (void)phased.inputs(); });
  expect_refused("phase", [&] { (void)phased.mode(); });
  expect_refused("phase", [&] { phased.advance(input, 0.1); });
  expect_refused("moved", [&] { (void)plant.inputs(); });
  expect_refused("moved", [&] { (void)plant.mode(); });
  expect_refused("moved", [&] { plant.advance(input, 0.1); });
  // NOLINTEND(bugprone-use-after-move)
}

TEST(ReferenceAccess, RejectsInvalidEntriesAndReturnsNanAtNan) {
  const Reference moving({0.0, 1.0}, MatrixXd{{0.0, 2.0}});
  for (const int i : {-1, 1, 100000}) {
    expect_refused("entry", [&] { (void)moving.at(0.5, i); });
    expect_refused("entry", [&] { (void)moving.rate(0.5, i); });
  }
  EXPECT_TRUE(std::isnan(moving.at(nan, 0)));
  EXPECT_TRUE(std::isnan(moving.rate(nan, 0)));
  EXPECT_EQ(moving.at(-infinity, 0), 0.0);
  EXPECT_EQ(moving.at(infinity, 0), 2.0);
}

TEST(SequenceResultOfNothing, HasNoGapAndNoPlan) {
  const SequenceResult none;
  EXPECT_FALSE(none.found());
  EXPECT_EQ(none.gap(), infinity);
  expect_empty(none.solution.trajectory);
}

}  // namespace
}  // namespace saltus
