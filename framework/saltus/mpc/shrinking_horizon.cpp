#include "saltus/mpc/shrinking_horizon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/ocp/windows_of.hpp"

namespace saltus {
namespace {

// Minimum remaining duration: a program needs a positive length.
constexpr double least = 10.0 * same_instant;  // s

Bounds remaining_duration(const Bounds& duration, double elapsed) {
  return {std::max(duration.lower - elapsed, least), std::max(duration.upper - elapsed, least)};
}

// True if the window starts or ends within the phase by the clock of the phase.
bool starts_with_phase(const Window& window) {
  return window.clock == Clock::phase && (is_after_start(window.from) || is_number(window.to));
}

}  // namespace

std::vector<RecedingHorizonController> remaining_controllers(
    const OptimalControlProblem& problem, ShootingOptions options,
    const std::function<RecedingHorizonController(MultipleShooting)>& controller_of) {
  const std::size_t phases = problem.phases().size();
  const auto refuse = [&](const std::string& what) {
    throw DefinitionError(
        fmt::format("controller: problem '{}' has the {}, whose value so far is not known "
                    "within a phase; make it a state",
                    problem.name(), what));
  };
  for (const PhaseDefinition& phase : problem.phases()) {
    if (!phase.integrals.empty()) refuse("integral '" + phase.integrals.front().name + "'");
    for_each_window(phase, [&](const Window& window, const auto& describe) {
      if (!starts_with_phase(window)) return;
      throw DefinitionError(fmt::format(
          "controller: problem '{}', phase '{}', {}: its window counts from the start of the "
          "phase, which moves with every tick; give its limits as events or on Clock::absolute, "
          "or make it a separate phase",
          problem.name(), phase.name, describe()));
    });
  }
  if (!problem.links().empty()) refuse("link '" + problem.links().front().name + "'");
  if (options.intervals.empty()) options.intervals.assign(phases, options.intervals_per_phase);
  std::vector<RecedingHorizonController> rests;
  for (std::size_t j = 0; j < phases; ++j) {
    rests.push_back(controller_of(MultipleShooting(problem.after(static_cast<int>(j)), options)));
    options.intervals.erase(options.intervals.begin());
    if (!options.meshes.empty()) options.meshes.erase(options.meshes.begin());
  }
  return rests;
}

ShrinkingHorizonController::ShrinkingHorizonController(const OptimalControlProblem& problem,
                                                       std::vector<RecedingHorizonController> rests)
    : rests_(std::move(rests)),
      total_time_(problem.total_time()),
      start_(problem.start_time()),
      entered_(problem.start_time()) {
  for (const PhaseDefinition& phase : problem.phases()) durations_.push_back(phase.duration);
  if (rests_.empty() || rests_.size() != durations_.size())
    throw DefinitionError(fmt::format("controller: problem '{}' has {} phases, but {} controllers",
                                      problem.name(), durations_.size(), rests_.size()));
}

const RecedingHorizonController& ShrinkingHorizonController::present() const {
  if (rests_.empty()) throw DefinitionError("controller: it has been moved from");
  return rests_[phase_];
}

RecedingHorizonController& ShrinkingHorizonController::present() {
  return const_cast<RecedingHorizonController&>(std::as_const(*this).present());
}

void ShrinkingHorizonController::adopt_plan(const Trajectory& plan) {
  present();
  rests_.front().adopt_plan(start_, plan);
}

const PhaseDefinition& ShrinkingHorizonController::definition() const {
  return rest().phases().front();
}

void ShrinkingHorizonController::enter(int phase, double t) {
  if (phase <= phase_ || phase >= static_cast<int>(rests_.size()))
    throw DefinitionError(
        fmt::format("controller: phase {} cannot follow phase {}", phase, phase_));
  if (!std::isfinite(t))
    throw DefinitionError(
        fmt::format("controller: phase {} is entered at {} s, expected a finite time", phase, t));
  Trajectory plan;
  try {
    if (rests_[phase_].follows_plan())
      plan = rests_[phase_].report().trajectory.after(phase - phase_);
  } catch (...) {  // exception of a formula: there is no plan to take over
  }
  phase_ = phase;
  entered_ = t;
  if (!plan.empty()) rests_[phase_].adopt_plan(t, plan);
}

const ControlTick& ShrinkingHorizonController::tick(double t, const VectorRef& state) noexcept {
  if (rests_.empty()) return moved_from_;
  RecedingHorizonController& rest = rests_[phase_];
  try {
    rest.set_remaining(remaining_duration(durations_[phase_], t - entered_),
                       {total_time_.lower - (t - start_), total_time_.upper - (t - start_)});
  } catch (...) {  // invalid time: the tick continues with its plan
  }
  return rest.tick(t, state);
}

const OptimalControlProblem& ShrinkingHorizonController::whole() const {
  present();
  return rests_.front().problem();
}

VectorXd ShrinkingHorizonController::parameters_of(int phase) {
  present();
  if (const int phases = static_cast<int>(durations_.size()); phase < 0 || phase >= phases)
    throw DefinitionError(
        fmt::format("controller: it has {} phases, so there is no phase {}", phases, phase));
  const int from = std::min(phase, phase_);
  return rests_[from].shooting().data().parameters[phase - from];
}

double ShrinkingHorizonController::end_of_phase(int phase) const {
  if (phase < phase_ || phase - phase_ >= static_cast<int>(present().problem().phases().size()))
    throw DefinitionError(
        fmt::format("controller: phase {} is over or does not exist; the active one is {} of {}",
                    phase, phase_, durations_.size()));
  return rests_[phase_].end_of_phase(phase - phase_);
}

}  // namespace saltus
