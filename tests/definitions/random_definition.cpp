#include "tests/definitions/random_definition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "tests/definitions/draw.hpp"

namespace saltus::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The only mistake in an otherwise sound problem. The framework accepts a few of them (bounds that
// no trajectory can satisfy). Those must end with a status.
enum class Mistake {
  none,
  start_size,
  start_nan,
  no_start,
  no_phase,
  bounds_reversed,
  bounds_nan,
  component,
  window_reversed,
  unknown_event,
  unknown_mode,
  weight_negative,
  weight_nan,
  weight_size,
  penalty_negative,
  penalty_nan,
  duration_negative,
  duration_nan,
  duration_reversed,
  total_time,
  schedule_order,
  schedule_names,
  nominal_zero,
  nominal_size,
  guess_size,
  guess_nan,
  data_size,
  rows_and_bounds,
  integral_magnitude,
  link_to_nobody,
  formula_nan,
  formula_throws,
  unreachable,
  count
};

const char* const names_of_mistakes[] = {"",
                                         "start of the wrong size",
                                         "start is NaN",
                                         "no start",
                                         "no phase",
                                         "bounds reversed",
                                         "bounds are NaN",
                                         "component that does not exist",
                                         "window reversed",
                                         "unknown event",
                                         "unknown mode",
                                         "negative weight",
                                         "weight is NaN",
                                         "weights of the wrong size",
                                         "negative penalty",
                                         "penalty is NaN",
                                         "negative duration",
                                         "duration is NaN",
                                         "duration reversed",
                                         "total time that phases cannot have",
                                         "events out of order",
                                         "events of one name",
                                         "nominal magnitude zero",
                                         "nominal magnitudes of the wrong size",
                                         "guess of the wrong size",
                                         "guess is NaN",
                                         "data of the wrong size",
                                         "more bounds than rows",
                                         "integral of magnitude zero",
                                         "link to a phase that does not exist",
                                         "formula gives NaN",
                                         "formula throws",
                                         "end that cannot be reached"};
static_assert(std::size(names_of_mistakes) == static_cast<std::size_t>(Mistake::count));

// rows = constant + time t + X x + U u + P p, plus a sine in the last row if `bend` is nonzero.
struct Coefficients {
  VectorXd constant, time;
  MatrixXd X, U, P;
  double bend = 0.0;
  Mistake mistake = Mistake::none;
};

template <int rows, int nx, int nu, int np>
struct Formula {
  std::shared_ptr<const Coefficients> c;

  template <class S>
  Vec<S, rows> sum(const S& t, const Vec<S, nx>& x) const {
    if (c->mistake == Mistake::formula_throws) throw FormulaIsOutOfOrder();
    Vec<S, rows> value;
    for (int i = 0; i < rows; ++i) {
      value[i] = c->constant[i] + c->time[i] * t;
      if (c->mistake == Mistake::formula_nan) value[i] += nan;
      for (int j = 0; j < nx; ++j) value[i] += c->X(i, j) * x[j];
    }
    using std::sin;
    if (c->bend != 0.0) value[rows - 1] += c->bend * sin(2.0 * x[0] + x[nx - 1]);
    return value;
  }
  // Reads states only, for ends and guards.
  template <class S>
  Vec<S, rows> operator()(const S& t, const Vec<S, nx>& x) const {
    return sum(t, x);
  }
  template <class S>
  Vec<S, rows> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u) const
    requires(np == 0)
  {
    Vec<S, rows> value = sum(t, x);
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < nu; ++j) value[i] += c->U(i, j) * u[j];
    if (c->bend != 0.0) value[0] += c->bend * u[0] * x[0];
    return value;
  }
  template <class S>
  Vec<S, rows> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u,
                          const Vec<S, np>& p) const
    requires(np > 0)
  {
    Vec<S, rows> value = sum(t, x);
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < nu; ++j) value[i] += c->U(i, j) * u[j];
      for (int j = 0; j < np; ++j) value[i] += c->P(i, j) * p[j];
    }
    if (c->bend != 0.0) value[0] += c->bend * u[0] * x[0];
    return value;
  }
};

// The same as a formula of states only, since terms at an end must not read inputs.
template <int rows, int nx>
struct EndFormula {
  Formula<rows, nx, 0, 0> whole;
  template <class S>
  Vec<S, rows> operator()(const S& t, const Vec<S, nx>& x) const {
    return whole.sum(t, x);
  }
};

template <int nx>
struct Scalar {
  EndFormula<1, nx> row;
  template <class S>
  S operator()(const S& t, const Vec<S, nx>& x) const {
    return row(t, x)[0];
  }
};

template <int nx, int nu, int np>
class Generator {
 public:
  Generator(Draw& draw, Mistake mistake, bool is_convex) : d_(draw), m_(mistake) {
    result_.is_convex = is_convex;
    result_.mistake = names_of_mistakes[static_cast<std::size_t>(mistake)];
  }

  RandomDefinition make() {
    times_are_free_ = !is_convex() && d_.chance(0.5);
    p_is_unknown_ = !is_convex() && d_.chance(0.5);
    const int phases = made(Mistake::no_phase) ? 0 : d_.whole(1, 3);
    wrong_phase_ = d_.whole(0, std::max(0, phases - 1));
    OptimalControlProblem& problem = result_.problem;
    add_start(problem);
    if (d_.chance(0.7) || made(Mistake::unknown_event) || made(Mistake::unknown_mode) ||
        made(Mistake::schedule_order) || made(Mistake::schedule_names))
      add_schedule(problem);
    for (int j = 0; j < phases; ++j) {
      const Phase<nx, nu, np> phase = make_phase(j);
      if (j > 0 && d_.chance(0.4))
        problem.then(phase,
                     jump<nx>("jump" + std::to_string(j), EndFormula<nx, nx>{{near_identity()}}));
      else
        problem.then(phase);
      last_ = phase;
    }
    if (last_ && (made(Mistake::link_to_nobody) || d_.chance(0.1))) add_link(problem);
    if (made(Mistake::total_time)) problem.total_time(between(90.0, 100.0));
    if (d_.chance(0.4)) problem.costs(CostRule::integrated);
    return std::move(result_);
  }

 private:
  bool made(Mistake mistake) const { return m_ == mistake; }
  bool made_here(Mistake mistake) const { return m_ == mistake && is_wrong_phase_; }
  bool is_convex() const { return result_.is_convex; }

  std::shared_ptr<Coefficients> coefficients(int rows, double size, bool may_be_wrong = false) {
    auto c = std::make_shared<Coefficients>();
    c->constant = d_.vector(rows, 0.3 * size);
    c->time = d_.chance(0.2) ? d_.vector(rows, 0.2 * size) : VectorXd(VectorXd::Zero(rows));
    c->X = d_.matrix(rows, nx, size);
    c->U = d_.matrix(rows, nu, size);
    c->P = d_.matrix(rows, np, size);
    if (!is_convex() && d_.chance(0.6)) c->bend = d_.real(-0.5, 0.5);
    if (may_be_wrong && is_wrong_phase_ && m_ >= Mistake::formula_nan &&
        m_ <= Mistake::formula_throws)
      c->mistake = m_;
    return c;
  }
  std::shared_ptr<Coefficients> near_identity() {
    auto c = coefficients(nx, 0.1);
    c->X += MatrixXd::Identity(nx, nx);
    c->time.setZero();
    return c;
  }

  void add_start(OptimalControlProblem& problem) {
    VectorXd start = d_.vector(made(Mistake::start_size) ? nx + 1 : nx, 1.0);
    if (made(Mistake::start_nan)) start[0] = nan;
    if (made(Mistake::no_start)) return;
    if (d_.chance(0.8)) {
      problem.start_at(start);
    } else {
      std::vector<Bounds> bounds(static_cast<std::size_t>(start.size()));
      for (int i = 0; i < start.size(); ++i)
        bounds[static_cast<std::size_t>(i)] = between(start[i] - 0.5, start[i] + 0.5);
      problem.start_within(bounds, start);
    }
    if (d_.chance(0.2)) problem.start_time(d_.real(-1.0, 1.0));
  }

  void add_schedule(OptimalControlProblem& problem) {
    const int events =
        d_.whole(made(Mistake::schedule_order) || made(Mistake::schedule_names) ? 2 : 1, 3);
    std::vector<std::string> modes{"a"};
    std::vector<Event> list;
    double time = d_.real(-0.5, 0.6);
    for (int i = 0; i < events; ++i) {
      modes.push_back(d_.chance(0.5) ? "a" : "b");
      list.push_back(
          {ShortName("e" + std::to_string(made(Mistake::schedule_names) ? 0 : i)), time});
      time += made(Mistake::schedule_order) ? -0.3 : d_.real(0.0, 0.7);
    }
    if (std::find(modes.begin(), modes.end(), "b") == modes.end()) modes.back() = "b";
    problem.schedule(Schedule(modes, list));
    events_ = events;
  }

  // Within the shortest duration of the phase. Events and absolute times are used only with fixed
  // durations, where they are valid.
  Window window() {
    if (made_here(Mistake::window_reversed)) return {.from = 0.2, .to = 0.1};
    if (made_here(Mistake::unknown_event)) return {.from = event("e9")};
    if (made_here(Mistake::unknown_mode)) return during("c");
    const double early = d_.real(0.0, 0.4) * shortest_, late = d_.real(0.5, 1.0) * shortest_;
    switch (d_.whole(0, times_are_free_ ? 3 : events_ > 0 ? 5 : 4)) {
      case 1:
        return {.from = early};
      case 2:
        return {.to = late};
      case 3:
        return {.from = early, .to = late};
      case 4:
        return {.from = early, .clock = Clock::absolute};
      case 5:
        return d_.chance(0.5) ? during("b") : Window{.to = event("e0")};
      default:
        return {};
    }
  }

  Bounds bounds(double half) {
    if (made_here(Mistake::bounds_reversed)) return {half, -half};
    if (made_here(Mistake::bounds_nan)) return {-half, nan};
    switch (d_.whole(0, 3)) {
      case 0:
        return at_least(-half);
      case 1:
        return at_most(half);
      default:
        return between(-half, half);
    }
  }

  Penalty penalty() {
    double weight = d_.real(1.0, 100.0);
    if (made_here(Mistake::penalty_negative)) weight = -weight;
    if (made_here(Mistake::penalty_nan)) weight = nan;
    switch (d_.whole(0, 2)) {
      case 0:
        return soft("soft", weight, Penalty::L1);
      case 1:
        return soft("soft", weight, Penalty::L2);
      default:
        return huber("soft", weight, d_.real(0.01, 0.3));
    }
  }

  VectorXd weights(int size) {
    VectorXd w = VectorXd::Constant(size, d_.real(0.1, 2.0));
    if (made_here(Mistake::weight_negative)) w[0] = -1.0;
    if (made_here(Mistake::weight_nan)) w[0] = nan;
    if (made_here(Mistake::weight_size)) w = VectorXd::Ones(size + 1);
    return w;
  }

  Bounds duration() {
    if (made_here(Mistake::duration_negative)) return exactly(-0.5);
    if (made_here(Mistake::duration_nan)) return exactly(nan);
    if (made_here(Mistake::duration_reversed)) return between(0.8, 0.4);
    const double length = d_.real(0.3, 1.0);
    shortest_ = times_are_free_ ? 0.5 * length : length;
    return times_are_free_ ? between(shortest_, 1.5 * length) : exactly(length);
  }

  Phase<nx, nu, np> make_phase(int j) {
    is_wrong_phase_ = j == wrong_phase_;
    const bool has_mistake = is_wrong_phase_;  // its terms are always present
    Phase<nx, nu, np> phase("phase" + std::to_string(j),
                            Formula<nx, nx, nu, np>{coefficients(nx, 0.8, true)}, duration());
    add_parameters(phase);
    // Makes the optimum unique.
    phase
        .track(
            "state", [](const auto&, const auto& x) { return x; }, weights(nx))
        .track(
            "input", [](const auto&, const auto&, const auto& u) { return u; }, weights(nu));
    const int component = made_here(Mistake::component) ? nu + 2 : d_.whole(0, nu - 1);
    if (has_mistake || d_.chance(0.7))
      phase.bound_input(component, bounds(d_.real(0.5, 2.0)), window());
    if (d_.chance(0.3)) phase.bound_state(d_.whole(0, nx - 1), bounds(d_.real(1.0, 3.0)), window());
    if (d_.chance(0.3))
      phase.keep("kept", Formula<1, nx, nu, np>{coefficients(1, 0.5)}, bounds(d_.real(1.0, 3.0)),
                 window());
    if (made_here(Mistake::rows_and_bounds))
      phase.keep("kept twice", Formula<1, nx, nu, np>{coefficients(1, 0.5)},
                 std::vector<Bounds>(2, at_most(9.0)));
    if (has_mistake || d_.chance(0.4))
      phase.keep("soft", Formula<1, nx, nu, np>{coefficients(1, 0.8)}, bounds(d_.real(0.1, 1.0)),
                 window(), penalty());
    if (d_.chance(0.3))
      phase.reach("reached", EndFormula<1, nx>{{coefficients(1, 0.7)}}, bounds(d_.real(0.2, 1.0)));
    if (made_here(Mistake::unreachable))
      phase.bound_input(0, between(-0.1, 0.1))
          .reach(
              "far", [](const auto&, const auto& x) { return x[0]; }, exactly(1e4));
    if (d_.chance(0.1))
      phase.begin_with("begun", EndFormula<1, nx>{{coefficients(1, 0.5)}},
                       at_most(d_.real(0.5, 3.0)));
    if (made_here(Mistake::integral_magnitude) || d_.chance(0.15))
      phase.bound_integral("used", Scalar<nx>{{{coefficients(1, 0.5)}}}, at_most(d_.real(0.2, 2.0)),
                           made_here(Mistake::integral_magnitude) ? 0.0 : 1.0);
    if (d_.chance(0.2)) phase.minimise_at_end("end", Scalar<nx>{{{coefficients(1, 0.3)}}});
    if (d_.chance(0.2)) phase.penalise_change(weights(nu));
    add_events(phase);
    add_scales_and_guesses(phase);
    return phase;
  }

  void add_parameters(Phase<nx, nu, np>& phase) {
    if constexpr (np > 0) {
      const VectorXd value = d_.vector(made_here(Mistake::data_size) ? np + 1 : np, 1.0);
      if (p_is_unknown_)
        phase.unknown("p", value, between(-2.0, 2.0))
            .minimise_at_end("p small", [](const auto&, const auto& x, const auto&, const auto& p) {
              return x[0] * 0.0 + p[0] * p[0];
            });
      else
        phase.data("p", value);
    } else if (made_here(Mistake::data_size)) {
      phase.data("p", VectorXd::Ones(1));
    }
  }

  void add_events(Phase<nx, nu, np>& phase) {
    if (is_convex()) return;
    const Crossing crossing = d_.chance(0.5) ? Crossing::rising : Crossing::falling;
    if (times_are_free_ && d_.chance(0.3))
      phase.ends_when("over", Scalar<nx>{{{coefficients(1, 0.8)}}}, crossing);
    if (d_.chance(0.15)) {
      const auto guard = Scalar<nx>{{{coefficients(1, 0.8)}}};
      if (d_.chance(0.5))
        phase.on("hit", guard, crossing, EndFormula<nx, nx>{{near_identity()}});
      else
        phase.switch_at("switch", guard, Formula<nx, nx, nu, np>{coefficients(nx, 0.8)});
    }
  }

  void add_scales_and_guesses(Phase<nx, nu, np>& phase) {
    if (made_here(Mistake::nominal_zero)) phase.nominal(VectorXd::Zero(nx), VectorXd::Ones(nu));
    if (made_here(Mistake::nominal_size)) phase.nominal(VectorXd::Ones(nx + 1), VectorXd::Ones(nu));
    if (made_here(Mistake::guess_size)) phase.guess_state(Guess::constant(VectorXd::Ones(nx + 2)));
    if (made_here(Mistake::guess_nan))
      phase.guess_state(Guess::constant(VectorXd::Constant(nx, nan)));
    if (d_.chance(0.2)) phase.guess_input(Guess::constant(d_.vector(nu, 0.5)));
  }

  void add_link(OptimalControlProblem& problem) {
    const Phase<nx, nu, np> nobody("nobody", Formula<nx, nx, nu, np>{coefficients(nx, 0.1)},
                                   exactly(1.0));
    const auto& phase = made(Mistake::link_to_nobody) ? nobody : *last_;
    problem.link(
        "linked", [](const auto& from, const auto& to) { return to.x[0] - from.x[0]; },
        between(-2.0, 2.0), start_of(phase), end_of(phase));
  }

  Draw& d_;
  Mistake m_;
  RandomDefinition result_;
  std::optional<Phase<nx, nu, np>> last_;
  int wrong_phase_ = 0, events_ = 0;
  double shortest_ = 1.0;  // shortest duration of the current phase, s
  bool is_wrong_phase_ = false, times_are_free_ = false, p_is_unknown_ = false;
};

}  // namespace

RandomDefinition draw_definition(std::uint32_t seed) {
  Draw draw(seed);
  const bool is_convex = draw.chance(0.5);
  const Mistake mistake =
      draw.chance(0.25) ? static_cast<Mistake>(draw.whole(1, static_cast<int>(Mistake::count) - 1))
                        : Mistake::none;
  switch (draw.whole(0, 2)) {
    case 0:
      return Generator<1, 1, 0>(draw, mistake, is_convex).make();
    case 1:
      return Generator<2, 1, 1>(draw, mistake, is_convex).make();
    default:
      return Generator<3, 2, 0>(draw, mistake, is_convex).make();
  }
}

}  // namespace saltus::test
