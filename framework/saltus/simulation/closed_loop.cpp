#include "saltus/simulation/closed_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <optional>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

// The answer of any controller to a measurement.
struct Answer {
  const HeldInput* input = nullptr;
  std::optional<LoopLog::Tick> tick = LoopLog::Tick{};  // empty: not recorded
};
struct ControlCalls {
  std::string name;
  double period = 0.0;
  std::function<Answer(double t, const VectorRef& measured)> answer;
  std::function<LoopLog::Plan()> plan = {};    ///< returns the last plan; empty: no plans
  std::function<void(double t)> prepare = {};  ///< work before the measurement
  std::function<double()> end = {};            ///< end of the motion, s
  MissRecord* misses = nullptr;                ///< set if the problem is known
  std::function<bool(const HybridEvent&)> ends_phase = {};  ///< empty: every event does
};

// Fraction of a period. If less time is left to the end, the tick is skipped: its inputs could no
// longer correct an error, and a least-time plan would delay the end.
constexpr double too_late = 0.01;

// The input of the plant from time `start` until the next command.
struct Command {
  double start = 0.0;
  VectorXd input;
};

// White Gaussian noise, independent of the standard library: the Box-Muller formula with the
// Mersenne twister.
class GaussianNoise {
 public:
  // Equal seeds give equal numbers.
  explicit GaussianNoise(std::uint64_t seed) : random_(seed) {}
  // Returns a number with standard deviation 1.
  double operator()() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const auto uniform = [this] { return random_.uniform(0.0, 1.0) + 0x1.0p-53; };  // in (0, 1]
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  Random random_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

class Loop {
 public:
  Loop(ControlCalls controller, LoopPlant& plant, const LoopOptions& options)
      : controller_(std::move(controller)),
        plant_(plant),
        options_(options),
        disturbances_(options.disturbances),
        noise_(options.disturbances.seed),
        start_(plant.time()) {
    check();
    log_.controller = controller_.name;
    log_.plant = plant_.name();
    log_.period = controller_.period;
    log_.recording.state_names = options_.state_names;
    log_.recording.input_names = options_.input_names;
    const VectorXd first = disturbances_.first_input.size() > 0
                               ? disturbances_.first_input
                               : VectorXd(VectorXd::Zero(plant_.inputs()));
    commands_.push_back({start_, first});
    if (!disturbances_.pulses.empty() && !plant_.take_pulses(disturbances_.pulses)) {
      for (const Pulse& pulse : disturbances_.pulses)
        if (pulse.direction.size() != plant_.state().size())
          throw DefinitionError(
              fmt::format("closed loop: the direction of a pulse has {} entries, expected {}, one "
                          "per state of the plant",
                          pulse.direction.size(), plant_.state().size()));
      pulses_ = disturbances_.pulses;
    }
  }

  LoopLog run() {
    constexpr double rounding = 1e-9;  // relative to a period
    const double ticks = std::ceil(options_.duration / controller_.period - rounding);
    log_.completed = true;
    log_.message = "the closed loop reached its end";
    if (controller_.misses != nullptr)
      controller_.misses->begin(start_, plant_.state(), commands_.front().input);
    for (long k = 0; static_cast<double>(k) < ticks && log_.completed; ++k) {
      disturb_state();
      if (!tick(k) || !move_on(k)) break;
      show_progress();
      if (options_.until && options_.until(plant_.time(), plant_.state())) {
        log_.message = fmt::format("ended at t = {:.4g} s, because `until` was met", plant_.time());
        break;
      }
    }
    add_sample();
    if (controller_.misses != nullptr) log_.misses = controller_.misses->misses();
    return std::move(log_);
  }

 private:
  void check() const {
    const auto complain = [](const std::string& what) {
      throw DefinitionError("closed loop: " + what);
    };
    const auto nx = plant_.state().size();
    const double period = controller_.period;
    if (!(period > 0.0 && std::isfinite(period)))
      complain(fmt::format("the period is {} s, expected more than 0", period));
    if (!(options_.duration > 0.0 && (std::isfinite(options_.duration) || options_.until)))
      complain(fmt::format("the duration is {} s, expected more than 0, and finite without `until`",
                           options_.duration));
    if (options_.samples_per_tick < 1)
      complain(fmt::format("{} samples per tick, expected 1 or more", options_.samples_per_tick));
    for (const VectorXd* deviations :
         {&disturbances_.state_noise, &disturbances_.measurement_noise})
      if (deviations->size() != 0 &&
          (deviations->size() != nx || !deviations->allFinite() || deviations->minCoeff() < 0.0))
        complain(fmt::format("noise has {} entries, expected {} numbers of at least 0",
                             deviations->size(), nx));
    const VectorXd& first = disturbances_.first_input;
    if (first.size() != 0 && (first.size() != plant_.inputs() || !first.allFinite()))
      complain(fmt::format("the first input has {} entries, expected {} numbers", first.size(),
                           plant_.inputs()));
    const double late = disturbances_.measurement_delay / period;
    if (!(late >= 0.0 && std::isfinite(late)) || std::abs(late - std::round(late)) > 1e-6)
      complain(fmt::format("the measurement delay is {} s, expected a multiple of {} s",
                           disturbances_.measurement_delay, period));
    if (!(disturbances_.input_delay >= 0.0 && std::isfinite(disturbances_.input_delay)))
      complain(
          fmt::format("the input delay is {} s, expected at least 0", disturbances_.input_delay));
    for (const Pulse& pulse : disturbances_.pulses)
      if (!(pulse.duration > 0.0 && std::isfinite(pulse.end()) && std::isfinite(pulse.impulse) &&
            pulse.direction.allFinite()))
        complain(
            fmt::format("the pulse of {} at {} s lasts {} s, expected a duration of more than "
                        "0 and finite numbers, also in its direction",
                        pulse.impulse, pulse.start, pulse.duration));
  }

  // Smaller differences of times are rounding errors.
  double instant() const { return 1e-9 * controller_.period; }

  // --- before the tick

  // A later phase of the plant may have fewer states. Noise of the others is ignored.
  void add_noise(VectorXd& x, const VectorXd& deviations) {
    for (Eigen::Index i = 0; i < deviations.size(); ++i) {
      const double noise = deviations[i] * noise_();
      if (i < x.size()) x[i] += noise;
    }
  }

  void disturb_state() {
    if (!disturbances_.state && disturbances_.state_noise.size() == 0) return;
    const VectorXd x = plant_.state();
    VectorXd change = VectorXd::Zero(x.size());
    if (disturbances_.state) disturbances_.state(plant_.time(), x, change);
    add_noise(change, disturbances_.state_noise);
    if (change.isZero(0.0)) return;
    if (!commands_.empty() && !log_.recording.samples.empty()) add_sample();  // records the jump
    plant_.disturb(change);
  }

  VectorXd measure() {
    VectorXd x = plant_.state();
    add_noise(x, disturbances_.measurement_noise);
    measured_.push_back(std::move(x));
    const auto late =
        static_cast<std::size_t>(std::lround(disturbances_.measurement_delay / controller_.period));
    while (measured_.size() > late + 1) measured_.pop_front();
    return measured_.front();  // at the beginning: the oldest one
  }

  // --- the tick

  bool tick(long k) {
    const double t = start_ + static_cast<double>(k) * controller_.period;
    if (controller_.prepare) controller_.prepare(t);
    const VectorXd measured = measure();
    if (options_.before_tick) options_.before_tick(t, measured);
    Answer answer;
    try {
      answer = controller_.answer(t, measured);
    } catch (...) {
      return stop(
          fmt::format("{} threw at t = {:.4g} s: {}", controller_.name, t, describe_exception()));
    }
    if (answer.tick) note(std::move(*answer.tick), t, measured);
    if (!answer.input->all_finite())
      return stop(fmt::format("the controller's input at t = {:.4g} s is not finite", t));
    while (!commands_.empty() && commands_.back().start >= t + disturbances_.input_delay)
      commands_.pop_back();
    for (const HeldInput::Piece& piece : *answer.input)
      commands_.push_back({piece.start + disturbances_.input_delay, piece.input()});
    if (controller_.plan && options_.plan_every > 0 && k % options_.plan_every == 0) {
      try {
        LoopLog::Plan plan = controller_.plan();
        if (!plan.samples.empty()) log_.plans.push_back(std::move(plan));
      } catch (...) {  // a formula threw, as in the tick: no plan
      }
    }
    return true;
  }

  void note(LoopLog::Tick tick, double t, const VectorXd& measured) {
    tick.time = t;
    tick.measured = measured;
    if (tick.provenance) {
      log_.statistics.latency[static_cast<std::size_t>(*tick.provenance)].add(tick.seconds);
      log_.statistics.preparation.add(tick.preparation);
      if (tick.check > 0.0) log_.statistics.check.add(tick.check);
    }
    log_.ticks.push_back(std::move(tick));
  }

  // --- after the tick

  bool move_on(long k) {
    const double begin = start_ + static_cast<double>(k) * controller_.period;
    double end = start_ + static_cast<double>(k + 1) * controller_.period;
    if (controller_.end && controller_.end() < end + too_late * controller_.period)
      end = std::max(end, controller_.end());
    int sample = 1;
    while (plant_.time() < end - instant()) {
      const double now = plant_.time();
      while (commands_.size() > 1 && commands_[1].start <= now + instant()) commands_.pop_front();
      double next = begin + controller_.period * sample / options_.samples_per_tick;
      if (sample >= options_.samples_per_tick) next = end;
      if (next <= now + instant()) {
        ++sample;
        continue;
      }
      if (commands_.size() > 1) next = std::min(next, commands_[1].start);
      if (!advance(next)) return false;
    }
    return true;
  }

  bool advance(double until) {
    for (const Pulse& pulse : pulses_) {
      const VectorXd rate = pulse.mean(plant_.time(), until);
      if (!rate.isZero(0.0)) plant_.disturb(rate * (until - plant_.time()));
    }
    input_ = commands_.front().input;
    if (disturbances_.input) {
      VectorXd added = VectorXd::Zero(input_.size());
      disturbances_.input(plant_.time(), plant_.state(), added);
      input_ += added;
    }
    add_sample();
    const VectorXd& command = commands_.front().input;  // bounds do not apply to the disturbance
    MissRecord* const misses = controller_.misses;
    const double from = plant_.time();
    if (misses != nullptr) misses->look(from, plant_.state(), command);
    bool moved = false;
    try {
      moved = plant_.advance(input_, until - from);
    } catch (...) {
      return stop(fmt::format("the plant threw at t = {:.4g} s: {}", from, describe_exception()));
    }
    for (HybridEvent& event : plant_.take_events()) {
      if (options_.record) {
        log_.recording.samples.push_back({event.time, event.before, input_, event.mode_before});
        log_.recording.samples.push_back({event.time, event.after, input_, event.mode_after});
      }
      if (misses != nullptr) {
        misses->look(event.time, event.before, command);
        if (!controller_.ends_phase || controller_.ends_phase(event))
          misses->end_phase(event, command);
      }
      if (options_.on_event) options_.on_event(event);
      if (options_.record) log_.recording.events.push_back(std::move(event));
    }
    if (misses != nullptr && moved) misses->look(plant_.time(), plant_.state(), command);
    return moved || stop(plant_.failure());
  }

  void show_progress() {
    constexpr double pause = 0.5;  // s
    if (options_.live_folder.empty() || seconds_since(shown_) < pause) return;
    log_.recording.write(options_.live_folder);
    shown_ = WallClock::now();
  }

  bool stop(std::string sentence) {
    log_.completed = false;
    log_.message = std::move(sentence);
    return false;
  }

  void add_sample() {
    if (!options_.record) return;
    if (input_.size() == 0 && !commands_.empty()) input_ = commands_.front().input;
    log_.recording.samples.push_back({plant_.time(), plant_.state(), input_, plant_.mode()});
  }

  ControlCalls controller_;
  LoopPlant& plant_;
  const LoopOptions& options_;
  const Disturbances& disturbances_;
  std::vector<Pulse> pulses_;  // those that the plant does not apply itself
  GaussianNoise noise_;
  double start_;
  LoopLog log_;
  WallClock::time_point shown_ = WallClock::now();
  std::deque<VectorXd> measured_;
  std::deque<Command> commands_;  // the first one is active
  VectorXd input_;                // current input, with its disturbance
};

void expect_fit(const PhaseDefinition& phase, const LoopPlant& plant) {
  if (phase.sizes.nx != plant.state().size())
    throw DefinitionError(fmt::format("closed loop: the plant has {} states, the controller {}",
                                      plant.state().size(), phase.sizes.nx));
  if (phase.sizes.nu != plant.inputs())
    throw DefinitionError(fmt::format("closed loop: the plant has {} inputs, the controller {}",
                                      plant.inputs(), phase.sizes.nu));
}

Answer answer_of(const ControlTick& tick) {
  return {&tick.input, LoopLog::Tick{tick.time,
                                     {},
                                     tick.provenance,
                                     tick.status,
                                     {},
                                     tick.iterations,
                                     tick.objective,
                                     tick.kkt,
                                     tick.violation,
                                     tick.seconds,
                                     tick.preparation,
                                     tick.check}};
}

// Called between ticks, and only after a failed one.
void keep_unmet(const ControlTick& tick, const MultipleShooting& shooting,
                const LoopOptions& options, std::vector<LoopLog::UnmetTick>& unmet) {
  if (tick.status == SolveStatus::infeasible && static_cast<int>(unmet.size()) < options.keep_unmet)
    unmet.push_back({tick.time, current_problem(shooting), shooting.options()});
}

void tell_misses(LoopLog& log) {
  if (log.misses.empty()) return;
  log.message += "; " + describe(log.misses.front());
  if (log.misses.size() > 1) log.message += fmt::format(", and {} more", log.misses.size() - 1);
}

// States and inputs at the nodes.
LoopLog::Plan plan_of(const ControlTick& tick, const OptimalControlProblem& problem,
                      const Solution& solution) {
  return {tick.time, record(problem, solution.trajectory, 1).samples};
}

}  // namespace

LoopLog simulate_closed_loop(RecedingHorizonController& controller, LoopPlant& plant,
                             const LoopOptions& options) {
  expect_fit(controller.problem().phases().front(), plant);
  const ControlTick* last = nullptr;
  std::vector<LoopLog::UnmetTick> unmet;
  const auto answer = [&](double t, const VectorRef& measured) {
    last = &controller.tick(t, measured);
    keep_unmet(*last, controller.shooting(), options, unmet);
    return answer_of(*last);
  };
  MissRecord misses(
      controller.problem(), options.tolerance,
      [&](int phase) { return controller.shooting().data().parameters[phase]; }, true);
  const auto prepare = [&](double t) { controller.prepare(t); };
  const auto plan = [&] {
    return last->provenance == Provenance::fallback
               ? LoopLog::Plan{}
               : plan_of(*last, controller.problem(), controller.report());
  };
  LoopLog log =
      Loop({controller.solver_name(), controller.period(), answer, plan, prepare, {}, &misses},
           plant, options)
          .run();
  log.unmet = std::move(unmet);
  tell_misses(log);
  return log;
}

namespace {

// A user-defined plant, followed through the phases of the controller's problem.
class FollowedPlant final : public LoopPlant {
 public:
  FollowedPlant(ShrinkingHorizonController& controller, LoopPlant& plant)
      : controller_(controller),
        plant_(plant),
        ends_(controller.whole().phases().size(), infinity),
        phase_(controller.phase()),
        entered_(controller.entered_at()) {}

  double time() const override { return plant_.time() + idle_; }
  VectorXd state() const override { return plant_.state(); }
  int inputs() const override { return plant_.inputs(); }
  std::string failure() const override { return failure_.empty() ? plant_.failure() : failure_; }
  std::string mode() const override {
    const std::string own = plant_.mode();
    return own.empty() ? definition().name : own;
  }
  std::vector<HybridEvent> take_events() override { return std::exchange(events_, {}); }
  void disturb(const VectorRef& change) override { plant_.disturb(change); }
  std::string name() const override { return plant_.name(); }

  int phase() const { return phase_; }
  int phases() const { return static_cast<int>(ends_.size()); }
  double entered_at() const { return entered_; }
  void end_phase_at(int phase, double t) { ends_[phase] = t; }
  double end() const { return phase_ + 1 == phases() ? planned_end() : infinity; }
  bool is_over() const { return over_since_.has_value(); }
  double over_since() const { return *over_since_; }
  bool is_end_of_phase(const HybridEvent& event) const {
    return std::ranges::any_of(phase_ends_, [&](const auto& end) {
      return end.first == event.time && end.second == event.name;
    });
  }

  bool advance(const VectorRef& input, double length) override {
    const double until = time() + length;
    while (!is_over() && time() < until) {
      const double stop = std::min(until, std::max(time(), planned_end()));
      const bool was_inside = has_guard() && guard() < 0.0;
      VectorXd fitted = VectorXd::Zero(inputs());  // a phase may begin within a piece
      const Eigen::Index common = std::min(fitted.size(), input.size());
      fitted.head(common) = input.head(common);
      if (stop > time() && !plant_.advance(fitted, stop - time())) return false;
      HybridEvent end;
      end.time = time();
      end.name = "switch";
      end.before = state();
      bool ends = !has_guard() && time() >= planned_end() - same_instant;
      for (HybridEvent& event : plant_.take_events()) {
        const bool is_guard = has_guard() && event.name == definition().end_guards.front().event;
        if (is_guard && !ends) {
          ends = true;
          end = std::move(event);
        } else {
          events_.push_back(std::move(event));
        }
      }
      if (!ends && was_inside && guard() >= 0.0) {
        ends = true;
        end.name = definition().end_guards.front().event;
      }
      if (ends && !end_phase(std::move(end))) return false;
    }
    if (time() < until) idle_ += until - time();  // the motion ends before the tick
    return true;
  }

 private:
  const PhaseDefinition& definition() const { return controller_.whole().phases()[phase_]; }
  bool has_guard() const { return !definition().end_guards.empty(); }
  double planned_end() const { return has_guard() ? infinity : ends_[phase_]; }
  double guard() const {  // negative inside the phase; it reads no input
    const EndGuard& g = definition().end_guards.front();
    VectorXd z(definition().sizes.size());
    z << time(), state(), VectorXd::Zero(definition().sizes.nu), controller_.parameters_of(phase_);
    return crossing_sign(g.crossing) * g.guard(z)[0];
  }
  bool end_phase(HybridEvent event) {
    event.mode_before = event.mode_after = definition().name;
    if (phase_ + 1 == phases()) {
      over_since_ = event.time;
      if (!has_guard()) event.name = "end";
    } else {
      plant_.enter_phase(++phase_);
      entered_ = event.time;
      event.mode_after = definition().name;
      const Arguments& sizes = definition().sizes;
      if (sizes.nx != state().size() || sizes.nu != inputs())
        failure_ = fmt::format(
            "the plant has {} states and {} inputs at t = {:.6g} s, where phase '{}' of the "
            "controller begins, which has {} and {}: change them in enter_phase()",
            state().size(), inputs(), time(), definition().name, sizes.nx, sizes.nu);
    }
    event.after = state();
    phase_ends_.emplace_back(event.time, event.name);
    events_.push_back(std::move(event));
    return failure_.empty();
  }

  ShrinkingHorizonController& controller_;
  LoopPlant& plant_;
  std::vector<double> ends_;  // planned, s
  int phase_;
  double entered_;     // s
  double idle_ = 0.0;  // s, since the end of the motion
  std::optional<double> over_since_;
  std::string failure_;
  std::vector<HybridEvent> events_;
  std::vector<std::pair<double, std::string>> phase_ends_;
};

// `plant` keeps its current phase.
template <class Plant>
LoopLog run_shrinking(ShrinkingHorizonController& controller, Plant& plant,
                      const LoopOptions& options,
                      std::function<bool(const HybridEvent&)> ends_phase) {
  expect_fit(controller.definition(), plant);
  const ControlTick* last = nullptr;
  std::vector<LoopLog::UnmetTick> unmet;
  const auto answer = [&](double t, const VectorRef& measured) {
    if (plant.phase() != controller.phase()) controller.enter(plant.phase(), plant.entered_at());
    last = &controller.tick(t, measured);
    keep_unmet(*last, controller.shooting(), options, unmet);
    for (int j = plant.phase(); j < plant.phases(); ++j)
      plant.end_phase_at(j, controller.end_of_phase(j));
    return answer_of(*last);
  };
  const auto plan = [&] {
    return last->provenance == Provenance::fallback
               ? LoopLog::Plan{}
               : plan_of(*last, controller.rest(), controller.report());
  };
  LoopOptions until_over = options;
  bool asked_to_end = false;
  until_over.until = [&](double t, const VectorRef& state) {
    asked_to_end = !plant.is_over() && options.until && options.until(t, state);
    return plant.is_over() || asked_to_end;
  };
  MissRecord misses(
      controller.whole(), options.tolerance,
      [&](int phase) { return controller.parameters_of(phase); }, false);
  const auto end = [&] { return plant.end(); };
  LoopLog log = Loop({controller.solver_name(),
                      controller.period(),
                      answer,
                      plan,
                      {},
                      end,
                      &misses,
                      std::move(ends_phase)},
                     plant, until_over)
                    .run();
  log.unmet = std::move(unmet);
  log.reached_end = plant.is_over() || asked_to_end;
  if (log.completed && plant.is_over())
    log.message = fmt::format("the last phase ended at t = {:.6g} s", plant.over_since());
  else if (log.completed && !log.reached_end)
    log.message = fmt::format(
        "the run ended at t = {:.6g} s, before the end of the motion, so its end conditions were "
        "not checked; increase LoopOptions::duration",
        plant.time());
  tell_misses(log);
  return log;
}

}  // namespace

LoopLog simulate_closed_loop(ShrinkingHorizonController& controller, PhasedPlant& plant,
                             const LoopOptions& options) {
  return run_shrinking(controller, plant, options, {});
}

LoopLog simulate_closed_loop(ShrinkingHorizonController& controller, LoopPlant& plant,
                             const LoopOptions& options) {
  if (auto* const phased = dynamic_cast<PhasedPlant*>(&plant))
    return simulate_closed_loop(controller, *phased, options);
  FollowedPlant followed(controller, plant);
  return run_shrinking(controller, followed, options, [&followed](const HybridEvent& event) {
    return followed.is_end_of_phase(event);
  });
}

LoopLog simulate_closed_loop(LoopController& controller, LoopPlant& plant,
                             const LoopOptions& options) {
  const auto answer = [&](double t, const VectorRef& measured) {
    const HeldInput& input = controller.tick(t, measured);
    return Answer{&input, controller.last_tick()};
  };
  return Loop({controller.name(), controller.period(), answer}, plant, options).run();
}

namespace {

LoopLog simulate_law(const FeedbackLaw& law, LoopPlant& plant, const LoopOptions& options,
                     MissRecord* misses) {
  if (!law) throw DefinitionError("closed loop: the feedback law is empty");
  HeldInput held;
  const auto answer = [&](double t, const VectorRef& measured) {
    held = HeldInput(1, plant.inputs());  // a later phase may have more inputs
    HeldInput::Piece& piece = held.add();
    piece.start = t;
    piece.length = options.period;
    piece.size = plant.inputs();
    law(t, measured, piece.values);
    return Answer{&held};
  };
  LoopLog log =
      Loop({"feedback law", options.period, answer, {}, {}, {}, misses}, plant, options).run();
  tell_misses(log);
  return log;
}

}  // namespace

LoopLog simulate_closed_loop(const FeedbackLaw& law, LoopPlant& plant, const LoopOptions& options) {
  return simulate_law(law, plant, options, nullptr);
}

LoopLog simulate_closed_loop(const FeedbackLaw& law, PhasedPlant& plant,
                             const LoopOptions& options) {
  MissRecord misses(
      plant.problem(), options.tolerance, [&](int phase) { return plant.parameters_of(phase); },
      false);
  return simulate_law(law, plant, options, &misses);
}

}  // namespace saltus
