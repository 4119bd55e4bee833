// Random small graphs in which each feature of a mode, of a transition and of the end may depend on
// every argument of its formula. A search over a single sequence must agree with solve() of that
// sequence in cost and feasibility.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/model/function.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/sequences/sequence_search.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

constexpr double sample = 0.25;  // s

// a + b t + c'x + d'u + e p, in which each argument appears at random. A quadratic cost is half its
// square.
struct Affine {
  double a = 0.0, t = 0.0, p = 0.0;
  Vec<double, 2> x = Vec<double, 2>::Zero();
  double u = 0.0;

  template <class S>
  S at(const S& time, const Vec<S, 2>& state) const {
    return a + t * time + x[0] * state[0] + x[1] * state[1];
  }
  template <class S>
  S at(const S& time, const Vec<S, 2>& state, const Vec<S, 1>& input, const Vec<S, 1>& data) const {
    return at(time, state) + u * input[0] + p * data[0];
  }
};

// Arguments that a formula may take, and how often it depends on time.
struct Reads {
  bool x = true, u = true, p = true;
  double time = 0.15;
};

Affine draw(Random& random, const Reads& may) {
  Affine f;
  f.a = random.uniform(-0.5, 0.5);
  if (random.chance(may.time)) f.t = random.uniform(-1.0, 1.0);
  if (may.x && random.chance(0.8)) f.x = Vec<double, 2>(random.vector(2));
  if (may.u && random.chance(0.7)) f.u = random.uniform(-1.0, 1.0);
  if (may.p && random.chance(0.5)) f.p = random.uniform(-1.0, 1.0);
  return f;
}

auto row(const Affine& f) {
  return
      [f](const auto& t, const auto& x, const auto& u, const auto& p) { return f.at(t, x, u, p); };
}
auto half_square(const Affine& f) {
  return [f](const auto& t, const auto& x, const auto& u, const auto& p) {
    const auto value = f.at(t, x, u, p);
    return std::decay_t<decltype(value)>(0.5 * value * value);
  };
}
auto row_of_state(const Affine& f) {
  return [f](const auto& t, const auto& x) { return f.at(t, x); };
}
auto half_square_of_state(const Affine& f) {
  return [f](const auto& t, const auto& x) {
    const auto value = f.at(t, x);
    return std::decay_t<decltype(value)>(0.5 * value * value);
  };
}

Bounds sides(Random& random) {
  switch (random.integer(0, 3)) {
    case 0:
      return at_most(random.uniform(0.0, 2.0));
    case 1:
      return at_least(random.uniform(-2.0, 0.0));
    case 2:
      return between(random.uniform(-2.0, -0.5), random.uniform(0.5, 2.0));
    default:
      return between(-3.0, 3.0);
  }
}

Window window(Random& random) {
  if (random.chance(0.94)) return {};
  Window w;
  w.clock = random.chance(0.5) ? Clock::absolute : Clock::phase;
  const double offset = w.clock == Clock::absolute ? 1.0 + sample * random.integer(1, 2) : 0.0;
  if (random.chance(0.5))
    w.from = offset;
  else
    w.to = offset + sample;
  return w;
}

Penalty penalty(Random& random, const std::string& name) {
  return soft(name, random.log_uniform(0.1, 100.0), random.chance(0.5) ? Penalty::L1 : Penalty::L2);
}

// A mode with its dynamics and a random selection of features.
Phase<2, 1, 1> draw_mode(Random& random, const std::string& name, double data, double time) {
  const Reads all{.time = time};
  const Affine first = draw(random, all), second = draw(random, all);
  Phase<2, 1, 1> mode{
      name,
      [first, second](const auto& t, const auto& x, const auto& u, const auto& p) {
        return std::decay_t<decltype(x)>{first.at(t, x, u, p), second.at(t, x, u, p)};
      },
      exactly(sample)};
  mode.data("p", VectorXd{{data}}).bound_input(0, between(-2.0, 2.0), window(random));
  mode.track(
      "effort", [](const auto&, const auto&, const auto& u) { return u; },
      VectorXd::Constant(1, random.log_uniform(0.1, 10.0)));
  const auto maybe = [&](double chance, auto&& declare) {
    if (random.chance(chance)) declare();
  };
  maybe(0.6, [&] { mode.minimise("running", half_square(draw(random, all)), window(random)); });
  maybe(0.3, [&] { mode.minimise("slope", row(draw(random, all))); });
  maybe(0.3, [&] { mode.minimise_at_end("end cost", half_square(draw(random, {.u = false}))); });
  maybe(0.3, [&] { mode.keep("keep", row(draw(random, all)), sides(random), window(random)); });
  maybe(0.15, [&] {
    mode.keep("data alone", row(draw(random, {.x = false, .u = false, .time = time})),
              sides(random));
  });
  maybe(0.2, [&] {
    mode.keep("soft", row(draw(random, all)), at_most(0.1), {}, penalty(random, name + " soft"));
  });
  maybe(0.2,
        [&] { mode.reach("reach", row(draw(random, {.u = false, .time = time})), sides(random)); });
  maybe(0.15, [&] {
    mode.reach("soft reach", row(draw(random, {.u = false, .time = time})), exactly(0.3),
               penalty(random, name + " soft reach"));
  });
  maybe(0.2, [&] {
    mode.begin_with("begin", row(draw(random, {.u = false, .time = time})), sides(random));
  });
  maybe(0.3, [&] { mode.bound_state(0, between(-2.0, 2.0), window(random)); });
  maybe(0.2, [&] { mode.bound_state(1, between(-3.0, 3.0)); });
  return mode;
}

struct Ends {
  std::vector<std::pair<Affine, Bounds>> rows;
  std::vector<Affine> costs;
};

Ends draw_ends(Random& random) {
  const Reads may{.u = false, .p = false, .time = 0.6};
  Ends ends;
  if (random.chance(0.6)) ends.costs.push_back(draw(random, may));
  if (random.chance(0.4)) ends.rows.emplace_back(draw(random, may), sides(random));
  if (random.chance(0.15)) {  // depends on time alone; true or false at the end of the horizon
    Affine clock;
    clock.t = 1.0;
    ends.rows.emplace_back(clock, at_least(random.chance(0.7) ? 1.7 : 1.8));
  }
  return ends;
}

void add_ends(const Ends& ends, ModeGraph& graph) {
  int i = 0;
  for (const Affine& f : ends.costs)
    graph.minimise_at_end<2>("end cost " + std::to_string(++i), half_square_of_state(f));
  for (const auto& [f, bounds] : ends.rows)
    graph.reach_at_end<2>("end row " + std::to_string(++i), row_of_state(f), bounds);
}

struct Tally {
  int convex = 0, enumerated = 0, feasible = 0, infeasible = 0, refused = 0;
};

// A graph with one mode per position, which contains a single path.
void expect_agreement(int seed, Tally& tally) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  constexpr int phases = 3;
  Random random(seed);
  const double data = random.uniform(-1.0, 1.0), time = random.chance(0.3) ? 0.15 : 0.0;
  ModeGraph graph("chain");
  std::vector<int> path;
  for (int k = 0; k < phases; ++k) {
    const std::string name = std::string("mode ") + static_cast<char>('a' + k);
    graph.mode(draw_mode(random, name, data, time));
    if (k > 0) {
      const std::string before = std::string("mode ") + static_cast<char>('a' + k - 1);
      if (time > 0.0 && random.chance(0.2))
        graph.transition(before, name, jump<2>("jump", [](const auto& t, const auto& x) {
                           return std::decay_t<decltype(x)>{x[0] + 0.1 * t, -0.5 * x[1]};
                         }));
      else
        graph.transition(before, name);
    }
    path.push_back(k);
  }
  graph.begin_in({"mode a"}).end_in({"mode c"}).start_time(1.0);
  graph.start_at(VectorXd(random.vector(2)));
  if (random.chance(0.5)) graph.costs(CostRule::integrated);
  add_ends(draw_ends(random), graph);

  const SequenceResult fast = search(graph, {.phases = phases, .intervals_per_phase = 1});
  const bool is_convex = fast.message.find("not convex in sampled time") == std::string::npos;
  MultipleShooting shooting(
      graph.problem(path),
      {.intervals_per_phase = 1,
       .integrator = is_convex ? zero_order_hold() : runge_kutta4({.steps = 2})});
  const auto solver = make_native_solver();
  const Solution slow = solve(shooting, *solver);
  ++(is_convex ? tally.convex : tally.enumerated);
  EXPECT_NE(fast.guarantee, SequenceResult::Guarantee::contradicted) << fast.message;
  // An optimum of the samples. The search makes no promise between them.
  const bool is_optimum = slow.ok() || (is_convex && slow.status == SolveStatus::coarse_grid);
  if (is_optimum) {
    ++tally.feasible;
    ASSERT_TRUE(fast.found()) << fast.message << "; but solve(): " << slow.message << " "
                              << slow.cost;
    EXPECT_NEAR(fast.cost, slow.cost, 1e-6 * std::max(1.0, std::abs(slow.cost))) << fast.message;
    if (is_convex) {
      EXPECT_EQ(fast.guarantee, SequenceResult::Guarantee::optimal) << fast.message;
      EXPECT_LE(fast.lower_bound, slow.cost + 1e-7 * std::max(1.0, std::abs(slow.cost)));
    }
  } else if (slow.status == SolveStatus::infeasible) {
    ++tally.infeasible;
    EXPECT_FALSE(fast.found()) << fast.message << " " << fast.cost << "; but " << slow.message;
    EXPECT_TRUE(fast.guarantee == SequenceResult::Guarantee::infeasible ||
                fast.guarantee == SequenceResult::Guarantee::inconclusive)
        << fast.message;
  } else {
    ++tally.refused;
    EXPECT_EQ(slow.status, SolveStatus::coarse_grid) << slow.message;
  }
}

TEST(SearchFeatures, SearchAgreesWithTheProblemForEveryFeature) {
  Tally tally;
  for (int seed = 1; seed <= 400; ++seed) expect_agreement(seed, tally);
  EXPECT_GE(tally.convex, 100);
  EXPECT_GE(tally.enumerated, 50);
  EXPECT_GE(tally.feasible, 100);
  EXPECT_GE(tally.infeasible, 30);
  EXPECT_LE(tally.refused, 12);
  std::printf("convex %d, enumerated %d, feasible %d, infeasible %d, not decided by solve() %d\n",
              tally.convex, tally.enumerated, tally.feasible, tally.infeasible, tally.refused);
}

// Solves every sequence of two modes separately. The search finds the cheapest, and its bound is
// below all of them. Costs may be negative.
TEST(SearchFeatures, SearchMatchesEnumeration) {
  constexpr int phases = 3;
  int compared = 0, infeasible = 0;
  for (int seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(1000 + seed);
    const double data = random.uniform(-1.0, 1.0);
    ModeGraph graph("pair");
    graph.mode(draw_mode(random, "a", data, 0.0)).mode(draw_mode(random, "b", data, 0.0));
    graph.all_transitions().start_time(1.0).start_at(VectorXd(random.vector(2)));
    add_ends(draw_ends(random), graph);
    const SequenceResult found = search(graph, {.phases = phases});
    if (found.message.find("not convex in sampled time") != std::string::npos) continue;
    double best = infinity;
    for (int bits = 0; bits < 1 << phases; ++bits) {
      const std::vector<int> path{bits & 1, (bits >> 1) & 1, (bits >> 2) & 1};
      MultipleShooting shooting(graph.problem(path),
                                {.intervals_per_phase = 1, .integrator = zero_order_hold()});
      const auto solver = make_native_solver();
      const Solution s = solve(shooting, *solver);
      if (s.ok() || s.status == SolveStatus::coarse_grid) best = std::min(best, s.cost);
    }
    ++(best < infinity ? compared : infeasible);
    if (best == infinity) {
      EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::infeasible) << found.message;
      continue;
    }
    const double size = std::max(1.0, std::abs(best));
    EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::optimal)
        << found.message << " gap " << found.gap();
    EXPECT_NEAR(found.cost, best, 2e-6 * size) << found.message;
    EXPECT_LE(found.lower_bound, best + 1e-7 * size);
  }
  std::printf("compared %d, infeasible %d\n", compared, infeasible);
  EXPECT_GE(compared, 40);
  EXPECT_GE(infeasible, 3);
}

// --- the time of the end -------------------------------------------------------------------------

ModeGraph chased(double reach_offset) {
  const auto field = [](const auto&, const auto&, const auto& u) { return u; };
  ModeGraph graph("chase");
  for (const char* name : {"m", "n"}) {
    Phase<1, 1> mode{name, field, exactly(0.5)};
    mode.bound_input(0, between(-1.0, 1.0))
        .track(
            "u", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
    graph.mode(mode);
  }
  graph.all_transitions().start_at({0.0}).reach_at_end<1>(
      "moving target", [=](const auto& t, const auto& x) { return x[0] - reach_offset + 2.0 * t; },
      exactly(0.0));
  return graph;
}

// After 4 phases of 0.5 s the target is at the start. After 1 s it would be out of reach.
TEST(SearchFeatures, EndIsAtTheEndOfTheHorizon) {
  const SequenceResult found = search(chased(4.0), {.phases = 4});
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::optimal) << found.message;
  EXPECT_NEAR(found.cost, 0.0, 1e-9);
  EXPECT_LE(found.lower_bound, 1e-9);
  const SequenceResult none = search(chased(0.0), {.phases = 4});  // at x = -4
  EXPECT_EQ(none.guarantee, SequenceResult::Guarantee::infeasible) << none.message;
}

// The input is bounded from the third phase on, or in the first two phases only; the modes are the
// same. A mode alone, counted from the start, never contains the start or end of the window.
TEST(SearchFeatures, BoundWindowsAreRelativeToTheSequenceStart) {
  const double third = 1.0 + 2.0 * sample;
  for (const bool late : {true, false}) {
    Phase<1, 1> mode{"only", [](const auto&, const auto&, const auto& u) { return u; },
                     exactly(sample)};
    Window window{.clock = Clock::absolute};
    (late ? window.from : window.to) = third;
    mode.bound_input(0, between(-1.0, 1.0), window)
        .track(
            "u", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
    ModeGraph graph("window");
    graph.mode(mode).all_transitions().start_at({0.0}).start_time(1.0).reach_at_end<1>(
        "far", [](const auto&, const auto& x) { return x[0]; }, exactly(3.0));
    const SequenceResult found = search(graph, {.phases = 3, .intervals_per_phase = 1});
    ASSERT_TRUE(found.found()) << found.message;
    EXPECT_NE(found.guarantee, SequenceResult::Guarantee::contradicted) << found.message;
    // Inputs of 5.5, 5.5 and 1, or of 1, 1 and 10, for a quarter of a second each.
    EXPECT_NEAR(found.cost, 0.5 * sample * (late ? 61.5 : 102.0), 1e-5) << found.message;
  }
}

// The end moves later in every tick.
TEST(SearchFeatures, EndMovesWithEachTick) {
  ModeGraph graph = chased(4.0);
  SequenceSearch loop(graph, {.phases = 4}), fresh(graph, {.phases = 4});
  SequenceResult next = loop.solve(graph.start());
  for (int tick = 1; tick < 3; ++tick) {
    const VectorXd x = next.states[1];
    next = loop.solve_next(x);
    EXPECT_EQ(loop.time(), 0.5 * tick);
    const SequenceResult alone = fresh.solve(x, loop.before(), loop.time());
    ASSERT_EQ(next.guarantee, alone.guarantee) << next.message << "; " << alone.message;
    if (!next.found()) break;
    EXPECT_NEAR(next.cost, alone.cost, 1e-6 * std::max(1.0, alone.cost));
  }
}

// --- certificates --------------------------------------------------------------------------------

// Quadratic costs times any factor give the same sequence and the same relative gap.
TEST(Certificates, AreIndependentOfCostUnits) {
  std::vector<int> sequence;
  double cost = 0.0;
  for (const double unit : {1.0, 1e-6, 1e-3, 1e3, 1e6}) {
    ModeGraph graph("scaled");
    for (const double push : {0.0, 1.0, -1.0}) {
      Phase<1, 1> mode{push == 0.0  ? "rest"
                       : push > 0.0 ? "up"
                                    : "down",
                       [push](const auto&, const auto& x, const auto& u) {
                         return std::decay_t<decltype(x)>(0.3 * x + u + Vec<double, 1>(push));
                       },
                       exactly(0.3)};
      mode.bound_input(0, between(-0.2, 0.2))
          .bound_state(0, between(-3.0, 3.0))
          .minimise("off", [push, unit](const auto&, const auto& x, const auto& u) {
            return unit * (x[0] * x[0] + 0.1 * u[0] * u[0] + 0.02 * push * push);
          });
      graph.mode(mode);
    }
    graph.all_transitions().start_at({0.8});
    const SequenceResult found = search(graph, {.phases = 6});
    ASSERT_EQ(found.guarantee, SequenceResult::Guarantee::optimal) << unit << ": " << found.message;
    if (sequence.empty()) sequence = found.modes, cost = found.cost;
    EXPECT_EQ(found.modes, sequence) << unit;
    EXPECT_NEAR(found.cost / unit, cost, 1e-6 * cost) << unit;
    EXPECT_LE(found.lower_bound / unit, cost * (1.0 + 1e-9)) << unit;
    EXPECT_LE(found.gap(), 1.1e-6) << unit;
  }
}

// Inputs and states have no bounds. The curvature of the cost provides the lower bounds.
TEST(Certificates, HoldWithoutStateAndInputBounds) {
  ModeGraph graph("free");
  for (const double push : {0.0, 2.0}) {
    Phase<2, 1> mode{push == 0.0 ? "rest" : "push",
                     [push](const auto&, const auto& x, const auto& u) {
                       return std::decay_t<decltype(x)>{x[1], u[0] + push};
                     },
                     exactly(0.2)};
    mode.track(
            "x", [](const auto&, const auto& x) { return x; }, VectorXd::Ones(2))
        .track(
            "u", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
    graph.mode(mode);
  }
  graph.all_transitions().start_at({-1.0, 0.3});
  const SequenceResult found = search(graph, {.phases = 5});
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::optimal)
      << found.message << " gap " << found.gap();
}

// A row whose limit changes unnoticed by the search, like a formula with hidden state.
class Moving final : public FunctionBody {
 public:
  explicit Moving(std::shared_ptr<double> shift) : FunctionBody(3, 1), shift_(std::move(shift)) {
    jacobian_pattern_ = SparsityPattern::from_pairs(1, 3, {{0, 1}});
    hessian_pattern_ = SparsityPattern::from_pairs(3, 3, {});
  }
  int degree(int, const std::vector<char>& variable) const override { return variable[1] ? 1 : 0; }
  bool reads(int input) const override { return input == 1; }
  void value(const double* z, double* y) const override { y[0] = z[1] - *shift_; }
  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    entries[0] = 1.0;
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  std::shared_ptr<double> shift_;
};

SequenceSearch moving_search(const std::shared_ptr<double>& shift) {
  Phase<1, 1> mode{"only", [](const auto&, const auto&, const auto& u) { return u; }, exactly(0.5)};
  mode.bound_input(0, between(-1.0, 1.0))
      .track(
          "u", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1))
      .keep("beyond",
            Function(std::unique_ptr<const FunctionBody>(std::make_unique<Moving>(shift))),
            at_least(0.0));
  ModeGraph graph("moving");
  graph.mode(mode).all_transitions().start_at({1.0});
  return SequenceSearch(graph, {.phases = 3});
}

TEST(Certificates, ReportsContradictionsWithoutCertificate) {
  const auto shift = std::make_shared<double>(1.0);  // at x >= 1: no input, no cost
  SequenceSearch holds = moving_search(shift);
  EXPECT_EQ(holds.solve(VectorXd{{1.0}}).guarantee, SequenceResult::Guarantee::optimal);
  *shift = 1.2;  // the sequence from the search is now infeasible
  const SequenceResult wrong = holds.solve(VectorXd{{1.0}});
  EXPECT_EQ(wrong.guarantee, SequenceResult::Guarantee::contradicted) << wrong.message;
  EXPECT_EQ(wrong.lower_bound, -infinity);
  EXPECT_NE(wrong.message.find("found a cost of"), std::string::npos) << wrong.message;

  *shift = 4.0;  // out of reach
  SequenceSearch excludes = moving_search(shift);
  EXPECT_EQ(excludes.solve(VectorXd{{1.0}}).guarantee, SequenceResult::Guarantee::infeasible);
  *shift = 0.5;
  const SequenceResult excluded = excludes.solve(VectorXd{{1.0}});
  EXPECT_EQ(excluded.guarantee, SequenceResult::Guarantee::contradicted) << excluded.message;
  EXPECT_NE(excluded.message.find("when solved separately"), std::string::npos);
}

// A failure of a local solver does not prove that no plan exists.
TEST(Certificates, LocalSolverFailureIsInconclusive) {
  Phase<1, 1> mode{"only",
                   [](const auto&, const auto& x, const auto& u) {
                     return std::decay_t<decltype(x)>(u[0] + 0.0 * x[0]);
                   },
                   exactly(1.0)};
  mode.bound_input(0, between(-3.0, 3.0))
      .reach(
          "far away", [](const auto&, const auto& x) { return x[0] * x[0] * (x[0] - 2.0); },
          exactly(50.0))
      .track(
          "u", [](const auto&, const auto&, const auto& u) { return u; }, VectorXd::Ones(1));
  ModeGraph graph("nonconvex");
  graph.mode(mode).all_transitions().start_at({0.0});
  const SequenceResult none = search(graph, {.phases = 1, .intervals_per_phase = 2});
  EXPECT_FALSE(none.found());
  EXPECT_EQ(none.guarantee, SequenceResult::Guarantee::inconclusive) << none.message;
}

// The assumption of nonnegative costs, which allows pruning, is checked where possible.
TEST(Certificates, ReportsNegativeCostsDespiteTheOption) {
  Phase<1, 1> mode{"only",
                   [](const auto&, const auto& x, const auto& u) {
                     return std::decay_t<decltype(x)>(u[0] - x[0] * x[0] * x[0]);
                   },
                   exactly(0.3)};
  mode.bound_input(0, between(-1.0, 1.0))
      .minimise("u", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  ModeGraph graph("promise");
  graph.mode(mode).all_transitions().start_at({0.8}).minimise_at_end<1>(
      "bonus", [](const auto&, const auto& x) { return x[0] * x[0] - 100.0; });
  const SequenceResult found =
      search(graph, {.phases = 2, .intervals_per_phase = 3, .costs_are_nonnegative = true});
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::contradicted) << found.message;
  EXPECT_NE(found.message.find("costs_are_nonnegative is set"), std::string::npos) << found.message;
}

}  // namespace
}  // namespace saltus
