#include "tests/faults/loop.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"

namespace saltus::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double slow = 1.0, fast = 3.0;  // N

}  // namespace

// Atomic because another thread may evaluate the formulas of a plan.
struct FaultyLoop::Switches {
  std::atomic<bool> dynamics_nan = false, dynamics_throw = false, cost_throws = false,
                    solver_gives_up = false, solver_gives_nan = false, deadline_missed = false,
                    sender_throws = false, fallback_throws = false;

  void set(Fault fault) {
    dynamics_nan = fault == Fault::dynamics_nan;
    dynamics_throw = fault == Fault::dynamics_throw;
    cost_throws = fault == Fault::cost_throws;
    solver_gives_up = fault == Fault::solver_gives_up;
    solver_gives_nan = fault == Fault::solver_gives_nan;
    deadline_missed = fault == Fault::deadline_missed || fault == Fault::fallback_throws;
    sender_throws = fault == Fault::sender_throws;
    fallback_throws = fault == Fault::fallback_throws;
  }
};

namespace {

template <class Switches>
struct Mass {
  const Switches* now;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>&) const {
    if (now->dynamics_throw) throw std::runtime_error("no dynamics today");
    Vec<S, 2> rate{x[1], u[0] - 0.5 * x[0] - 0.05 * x[0] * x[0] * x[0]};
    if (now->dynamics_nan) rate[1] += nan;
    return rate;
  }
};

template <class Switches>
struct Miss {
  const Switches* now;
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>&, const Vec<S, 1>& p) const {
    if (now->cost_throws) throw 42;
    return {x[0] - p[0], x[1]};
  }
};

// The real-time iteration, or a solver that fails on demand.
template <class Switches>
class FailingSolver : public RealTimeSolver {
 public:
  FailingSolver(std::unique_ptr<RealTimeSolver> solver, const Switches* now)
      : solver_(std::move(solver)), now_(now) {}
  void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept override {
    solver_->prepare(program, guess);
  }
  RealTimeSolver::Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                                  WallClock::time_point deadline) noexcept override {
    if (now_->deadline_missed) deadline = WallClock::now();
    RealTimeSolver::Result result = solver_->feedback(program, point, warm, deadline);
    if (now_->solver_gives_up) result.status = SolveStatus::numerical_failure;
    if (now_->solver_gives_up) result.violation = infinity;
    if (now_->solver_gives_nan) point.w.setConstant(nan);
    return result;
  }
  std::string name() const override { return solver_->name(); }

 private:
  std::unique_ptr<RealTimeSolver> solver_;
  const Switches* now_;
};

Schedule first_schedule() { return Schedule({"slow", "fast"}, {{"e0", 2.0}}).reserve(6); }

template <class Switches>
RecedingHorizonController make_controller(const Switches* now) {
  Phase<2, 1, 1> phase("mass", Mass<Switches>{now}, exactly(1.0));
  phase.bound_input(0, between(-slow, slow), during("slow"))
      .bound_input(0, between(-fast, fast), during("fast"))
      .track("miss", Miss<Switches>{now}, Vec<double, 2>{10.0, 1.0})
      .track(
          "force", [](const auto&, const auto&, const auto& u, const auto&) { return u; },
          Vec<double, 1>{0.1})
      .data("aim", VectorXd::Zero(1))
      .penalise_change(Vec<double, 1>{0.01});
  OptimalControlProblem ocp("faulty");
  ocp.schedule(first_schedule()).start_at({0.5, 0.0}).then(phase);
  MultipleShooting shooting(std::move(ocp),
                            {.intervals_per_phase = 14, .integrator = runge_kutta4()});
  ControllerOptions options;
  options.period = FaultyLoop::period;
  // A plan shifted by 1.4 intervals is interpolated: one step leaves an error of 1e-6.
  options.optimality = options.feasibility = 1e-5;
  options.fallback = [now](double, const VectorRef&, VectorOut input) {
    if (now->fallback_throws) throw std::runtime_error("no fallback today");
    input.setZero();
  };
  options.send = [now](const ControlTick&) {
    if (now->sender_throws) throw std::runtime_error("nobody listens");
  };
  auto solver = std::make_unique<FailingSolver<Switches>>(
      make_real_time_iteration(shooting.nlp(), {.curvature = Curvature::exact}), now);
  return {std::move(shooting), std::move(solver), std::move(options)};
}

}  // namespace

const char* describe(Fault fault) {
  static const char* const words[] = {"none",
                                      "measurement is NaN",
                                      "measurement is infinite",
                                      "measurement is frozen",
                                      "measurement is three ticks late",
                                      "measurements arrive out of order",
                                      "measurements are outliers",
                                      "clock jumps 5 s ahead",
                                      "clock goes back by 5 s",
                                      "clock stops",
                                      "clock is NaN",
                                      "deadline is missed",
                                      "dynamics return NaN",
                                      "dynamics throw",
                                      "a cost throws",
                                      "solver fails",
                                      "solver returns NaN",
                                      "data are NaN",
                                      "previous input is infinite",
                                      "event is retimed to NaN",
                                      "edit of the schedule is impossible",
                                      "send callback throws",
                                      "deadline is missed, fallback throws"};
  static_assert(std::size(words) == static_cast<std::size_t>(Fault::count));
  return words[static_cast<std::size_t>(fault)];
}

FaultyLoop::FaultyLoop()
    : switches_(std::make_shared<Switches>()),
      schedule_(first_schedule()),
      controller_(make_controller(switches_.get())) {
  past_.fill(state_);
}
FaultyLoop::~FaultyLoop() = default;

Vec<double, 2> FaultyLoop::measured(Fault fault) {
  std::uniform_real_distribution<double> noise(-1e-4, 1e-4);
  const Vec<double, 2> now{state_[0] + noise(random_), state_[1] + noise(random_)};
  std::rotate(past_.begin(), past_.end() - 1, past_.end());
  past_[0] = now;
  if (fault != Fault::measurement_frozen) frozen_ = now;
  switch (fault) {
    case Fault::measurement_nan:
      return {now[0], nan};
    case Fault::measurement_infinite:
      return {infinity, now[1]};
    case Fault::measurement_frozen:
      return frozen_;
    case Fault::measurement_late:
      return past_[3];
    case Fault::measurements_out_of_order:
      return past_[static_cast<std::size_t>(random_() % past_.size())];
    case Fault::measurement_outliers:
      return {now[0] + (random_() % 2 == 0 ? 1e3 : -1e3), now[1]};
    default:
      return now;
  }
}

double FaultyLoop::clock(Fault fault) {
  switch (fault) {
    case Fault::clock_ahead:
      return time_ + 5.0;
    case Fault::clock_back:
      return time_ - 5.0;
    case Fault::clock_stands:
      return std::floor(time_);
    case Fault::clock_nan:
      return nan;
    default:
      return time_;
  }
}

// Updates the controller's schedule first. If that throws, the loop's schedule stays unchanged too.
void FaultyLoop::edit_schedule() {
  std::uniform_real_distribution<double> when(0.2, 0.9);
  Schedule edited = schedule_;
  edited.forget_until(time_ - period);
  if (edited.events().size() >= 3) edited.erase(edited.events().back().name.view());
  const std::string name = "e" + std::to_string(++events_ % 100);
  const double time = time_ + when(random_);
  if (edited.contains(name)) return;
  for (const Event& e : edited.events())
    if (std::abs(e.time - time) < 0.15) return;  // one interval has room for one event
  edited.insert(random_() % 2 == 0 ? "slow" : "fast", name, time);
  controller_.set_schedule(edited);
  schedule_ = std::move(edited);
}

void FaultyLoop::aim(double position) { controller_.set_data("aim", Vec<double, 1>{position}); }

void FaultyLoop::strike(double speed) { state_[1] += speed; }

const ControlTick& FaultyLoop::tick(Fault fault) {
  switches_->set(fault);
  try {
    if (fault == Fault::data_nan) controller_.set_data("aim", Vec<double, 1>{nan});
    if (fault == Fault::previous_input_infinite)
      controller_.set_previous_input(Vec<double, 1>{infinity});
    if (fault == Fault::event_at_nan)
      controller_.retime(schedule_.events().back().name.view(), nan);
    if (fault == Fault::schedule_impossible) controller_.retime("nobody", time_);
  } catch (const DefinitionError&) {
    ++refused_;
  }
  if (ticks_ > 0 && fault != Fault::previous_input_infinite)
    controller_.set_previous_input(last_input_);
  const ControlTick& tick = controller_.tick(clock(fault), measured(fault));
  last_input_[0] = tick.input.back().values[0];
  switches_->set(Fault::none);
  check_input(tick);
  move_plant(tick);
  time_ = period * static_cast<double>(++ticks_);
  return tick;
}

void FaultyLoop::check_input(const ControlTick& tick) {
  double covered = 0.0;
  input_is_sound_ = !tick.input.empty();
  for (const HeldInput::Piece& piece : tick.input) {
    covered += piece.length;
    const double force = piece.size == 1 ? piece.values[0] : nan;
    const bool is_slow = schedule_.mode_at(piece.start + 0.5 * piece.length) == "slow";
    // Bounds hold up to the rounding of scaled inputs.
    input_is_sound_ = input_is_sound_ && std::abs(force) <= (is_slow ? slow : fast) * (1.0 + 1e-12);
  }
  input_is_sound_ = input_is_sound_ && std::abs(covered - period) < 1e-9;
}

// Integrates piece by piece. The mass stays within 10 m, as if between walls.
void FaultyLoop::move_plant(const ControlTick& tick) {
  for (const HeldInput::Piece& piece : tick.input) {
    constexpr int steps = 4;
    const double h = piece.length / steps;
    for (int i = 0; i < steps; ++i) {
      const double x = state_[0];
      state_[1] += h * (piece.values[0] - 0.5 * x - 0.05 * x * x * x);
      state_[0] += h * state_[1];
    }
  }
  state_[0] = std::clamp(state_[0], -10.0, 10.0);
  state_[1] = std::clamp(state_[1], -10.0, 10.0);
}

}  // namespace saltus::test
