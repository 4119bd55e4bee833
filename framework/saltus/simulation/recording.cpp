#include "saltus/simulation/loop_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/temporary_file.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {
namespace {

std::vector<std::string> filled_up(std::vector<std::string> names, const char* letter,
                                   std::size_t count) {
  while (names.size() < count) names.push_back(fmt::format("{}{}", letter, names.size()));
  return names;
}

std::span<const double> span_of(const VectorXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

// Events inside a shooting interval of a phase with events. `mode` is the mode at its start; -1:
// determined by the state.
std::vector<HybridEvent> events_inside(EventIntegrator& integrator, const Trajectory::Piece& piece,
                                       const VectorXd& parameters, int mode) {
  VectorXd w(integrator.arguments().size()), end(integrator.outputs());
  w << piece.state, piece.coefficients, parameters, piece.start, piece.length;
  std::vector<HybridEvent> events;
  integrator.record(&events);
  integrator.start_in(mode);
  integrator.value(w.data(), end.data());
  integrator.record(nullptr);
  integrator.start_in(-1);
  return events;
}

// Modes after the declared ones slide on a surface.
bool is_sliding(const EventIntegrator& integrator, int mode) {
  return mode >= static_cast<int>(integrator.problem().switching.modes.size());
}

HybridEvent end_of_phase(const OptimalControlProblem& problem, int phase, double time,
                         const VectorXd& before, const VectorXd& after) {
  const PhaseDefinition& ended = problem.phases()[phase];
  const Jump& jump = problem.jumps()[phase + 1];
  const std::string& next = problem.phases()[phase + 1].name;
  std::string name = ended.end_guards.empty() ? "" : ended.end_guards.front().event;
  if (name.empty()) name = jump.map ? jump.name : "switch";
  return {time,  jump.map ? HybridEvent::Kind::jumps : HybridEvent::Kind::crosses,
          name,  ended.name,
          next,  before,
          after, {}};
}

}  // namespace

std::vector<std::string> Recording::state_columns() const {
  std::size_t count = state_names.size();
  for (const Sample& s : samples) count = std::max(count, static_cast<std::size_t>(s.state.size()));
  return filled_up(state_names, "x", count);
}

std::vector<std::string> Recording::input_columns() const {
  std::size_t count = input_names.size();
  for (const Sample& s : samples) count = std::max(count, static_cast<std::size_t>(s.input.size()));
  return filled_up(input_names, "u", count);
}

std::string Recording::trajectory_csv() const {
  const std::vector<std::string> states = state_columns(), inputs = input_columns();
  const std::size_t nx = states.size(), nu = inputs.size();
  const bool has_modes =
      std::any_of(samples.begin(), samples.end(), [](const Sample& s) { return !s.mode.empty(); });
  std::vector<std::string> columns{"t [s]"};
  if (has_modes) columns.emplace_back("mode");
  columns.insert(columns.end(), states.begin(), states.end());
  columns.insert(columns.end(), inputs.begin(), inputs.end());
  CsvTable table(columns);
  for (const Sample& s : samples) {
    table.number(s.time);
    if (has_modes) table.word(s.mode);
    table.numbers(span_of(s.state), nx).numbers(span_of(s.input), nu).end_row();
  }
  return table.text();
}

std::string Recording::events_csv() const {
  CsvTable table({"t [s]", "event", "kind", "mode before", "mode after"});
  for (const HybridEvent& e : events) {
    table.number(e.time).word(e.name).word(describe(e.kind)).word(e.mode_before);
    table.word(e.mode_after).end_row();
  }
  return table.text();
}

void Recording::write(const std::string& path) const {
  const std::filesystem::path folder(path);
  write_atomically(folder / "trajectory.csv", trajectory_csv());
  write_atomically(folder / "events.csv", events_csv());
}

void save(const OptimalControlProblem& problem, const Trajectory& plan, const std::string& folder,
          std::vector<std::string> state_names, std::vector<std::string> input_names) {
  Recording recording = record(problem, plan);
  const auto check = [](const char* what, const auto& names, std::size_t columns) {
    if (!names.empty() && names.size() != columns)
      throw DefinitionError(fmt::format("save: {} names of {} were given, but the plan has {} {}",
                                        names.size(), what, columns, what));
  };
  check("states", state_names, recording.state_columns().size());
  check("inputs", input_names, recording.input_columns().size());
  recording.state_names = std::move(state_names);
  recording.input_names = std::move(input_names);
  recording.write(folder);
}

void save(const OptimalControlProblem& problem, const Solution& plan, const std::string& folder,
          std::vector<std::string> state_names, std::vector<std::string> input_names) {
  save(problem, plan.trajectory, folder, std::move(state_names), std::move(input_names));
  const std::filesystem::path path(folder);
  write_atomically(path / "summary.json", summary_json(problem.name(), plan));
  write_atomically(path / "multipliers.csv", multipliers_csv(plan));
}

Recording record(const OptimalControlProblem& problem, const Trajectory& trajectory,
                 int samples_per_interval) {
  Recording recording;
  const std::vector<Trajectory::Piece>& pieces = trajectory.pieces();
  const Schedule& schedule = problem.schedule();
  const bool has_schedule = !schedule.events().empty();
  const auto scheduled_mode = [&](double t) {
    // Evaluated slightly later, so that at an event the new mode is active, even if rounding puts a
    // node before the event.
    return has_schedule ? schedule.mode_at(t + same_instant) : std::string();
  };
  const auto add = [&](double t, VectorXd state, const VectorXd& input, const std::string& mode) {
    // Ends and starts of neighbours differ by rounding.
    if (!recording.samples.empty()) t = std::max(t, recording.samples.back().time);
    recording.samples.push_back({t, std::move(state), input, mode});
  };
  // One per phase, created when needed; null: the phase has no inner events.
  std::vector<std::unique_ptr<Integrator>> integrators(trajectory.phases().size());
  const auto event_integrator = [&](int phase) {
    std::unique_ptr<Integrator>& made = integrators[phase];
    const ReentrantIntegrator& integrator = *trajectory.phases()[phase].integrator;
    if (!made && !integrator.problem().switching.empty()) made = integrator.make();
    return dynamic_cast<EventIntegrator*>(made.get());
  };
  int sliding = -1;  // sliding mode at the end of the previous piece; -1: none
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Trajectory::Piece& piece = pieces[k];
    const Trajectory::PhaseInfo& phase = trajectory.phases()[piece.phase];
    EventIntegrator* const hybrid = event_integrator(piece.phase);
    std::vector<HybridEvent> inside;
    const bool is_new_phase = k == 0 || pieces[k - 1].phase != piece.phase;
    if (hybrid != nullptr) {
      inside = events_inside(*hybrid, piece, phase.parameters, is_new_phase ? -1 : sliding);
      sliding = is_sliding(*hybrid, hybrid->end_mode()) ? hybrid->end_mode() : -1;
    }
    std::string mode = phase.name;
    if (hybrid != nullptr)
      mode = !inside.empty() ? inside.front().mode_before
             : is_new_phase  ? hybrid->mode_name(hybrid->end_mode())
                             : recording.samples.back().mode;
    else if (has_schedule)
      mode = trajectory.phases().size() == 1 ? scheduled_mode(piece.start)
                                             : phase.name + ", " + scheduled_mode(piece.start);
    const double last = piece.end();
    const auto add_at = [&](double t, const VectorXd& state) {
      add(t, state, trajectory.input_in(piece, t), mode);
    };
    add_at(piece.start, piece.state);
    std::size_t next = 0;
    for (int s = 1; s <= samples_per_interval; ++s) {
      const bool closes = s == samples_per_interval;
      const double t = closes ? last : piece.start + piece.length * s / samples_per_interval;
      for (; next < inside.size() && (closes || inside[next].time <= t); ++next) {
        const HybridEvent& e = inside[next];
        mode = e.mode_before;
        add_at(e.time, e.before);
        mode = e.mode_after;
        add_at(e.time, e.after);
        recording.events.push_back(e);
      }
      add_at(t, closes ? piece.end_state : trajectory.state_in(piece, t));
    }
    if (k + 1 < pieces.size())
      for (int j = piece.phase; j < pieces[k + 1].phase; ++j)
        recording.events.push_back(
            end_of_phase(problem, j, last, piece.end_state, pieces[k + 1].state));
  }
  if (has_schedule && !pieces.empty())
    for (std::size_t i = 0; i < schedule.events().size(); ++i) {
      const Event& event = schedule.events()[i];
      if (event.time < trajectory.start_time() || event.time > trajectory.end_time()) continue;
      const VectorXd state = trajectory.state(event.time);
      recording.events.push_back({event.time,
                                  HybridEvent::Kind::crosses,
                                  std::string(std::string_view(event.name)),
                                  schedule.mode(static_cast<int>(i)),
                                  schedule.mode(static_cast<int>(i) + 1),
                                  state,
                                  state,
                                  {}});
    }
  std::stable_sort(recording.events.begin(), recording.events.end(),
                   [](const HybridEvent& a, const HybridEvent& b) { return a.time < b.time; });
  return recording;
}

}  // namespace saltus
