#include "problems/biped/survival/map.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <numbers>

#include "problems/biped/report/scripts.hpp"
#include "problems/biped/survival/map_file.hpp"
#include "problems/biped/survival/pendulum_bound.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/app/process_pool.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "saltus/robots/walking/robot_choice.hpp"

namespace saltus::robots::walking {
namespace {

// Time limit of a run, s. A whole-body run takes a few seconds, and ten times as long with Ipopt.
constexpr double run_time_limit = 600.0;
constexpr double report_period = 30.0;  // without a terminal, s
constexpr double live_period = 0.5;     // on a terminal, s

std::string duration_text(double seconds) {
  const long s = std::lround(seconds);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

class MapProgress {
 public:
  MapProgress(const MapPlan& plan, int jobs) : plan_(plan), jobs_(jobs) {}

  void show() {
    if (seconds_since(last_) < (live_ ? live_period : report_period)) return;
    last_ = WallClock::now();
    const std::optional<double> left = plan_.seconds_left(jobs_);
    fmt::print("{}{} of {} cells, {} so far, about {} left{}", live_ ? "\r" : "", plan_.known(),
               plan_.cells(), duration_text(seconds_since(begin_)),
               left ? duration_text(*left) : std::string("?"), live_ ? "   " : "\n");
    std::fflush(stdout);
    shown_ = live_;
  }
  // Ends the progress line on the terminal.
  void end_line() {
    if (shown_) fmt::print("\n");
    shown_ = false;
  }
  double elapsed() const { return seconds_since(begin_); }

 private:
  const MapPlan& plan_;
  int jobs_;
  bool live_ = ::isatty(::fileno(stdout)) != 0;
  bool shown_ = false;
  WallClock::time_point begin_ = WallClock::now(), last_ = begin_;
};

// Checks the settings common to all runs before any file is written.
RobotDescription checked_robot(const BipedSettings& settings) {
  RobotDescription robot = robot_of(settings);
  if (settings.plant.is_whole_body()) {
    const UrdfModel model = UrdfModel::read(urdf_of_body(settings.robot));
    pushed_frame(floating_robot(model, robot), model, settings.push.link);
  }
  return robot;
}

class MapRun {
 public:
  explicit MapRun(const MapRequest& request)
      : request_(request),
        robot_(checked_robot(request.problem->settings())),
        bound_(pendulum_bound(request.problem->settings().push, request.problem->settings().step,
                              request.problem->settings().scene, robot_,
                              request.problem->step_bounds(robot_))),
        plan_(request.grid, [this](const MapCell& cell) { return bound(cell); }),
        file_(request.out, settings()),
        pool_(request.jobs, run_time_limit) {
    for (const MapRow& row : file_.rows()) plan_.restore(row);
    restored_ = plan_.known();
    for (const MapRow& row : file_.rows())
      if (row.outcome == MapOutcome::not_run) given_up_before_.insert(row.cell);
  }

  ExitStatus run() {
    fmt::print("robot: {}, {:.2f} kg ({})\n", robot_.name, robot_.mass, robot_.source);
    fmt::print("{} cells, {} of them known, {} in parallel; results in {}\n", plan_.cells(),
               restored_, request_.jobs, request_.out.string());
    std::fflush(stdout);
    keep(plan_.resume());
    MapProgress progress(plan_, request_.jobs);
    int signal = 0;
    {
      DeferSignals note;
      work(progress);
      signal = DeferSignals::received();
    }
    progress.end_line();
    fmt::print("{}: {} of {} cells known, {} of them run now, in {}\n",
               signal != 0 ? "interrupted" : "done", plan_.known(), plan_.cells(), runs_,
               duration_text(progress.elapsed()));
    if (failed_solves_ > 0)
      fmt::print("in {} runs a solve of the controller failed; see failed_solves\n",
                 failed_solves_);
    if (signal != 0) {
      fmt::print("the same command continues from here\n");
      std::fflush(nullptr);
      std::raise(signal);
    }
    if (request_.pictures) draw(request_.out, "picture (it needs matplotlib)", "plot_map");
    fmt::print("\n{}", map_summary(plan_));
    return failures_ > 0 ? ExitStatus::solver_failed : ExitStatus::ok;
  }

  const MapPlan& plan() const { return plan_; }

 private:
  // The settings that identify the map. The outcome also depends on the robot.
  std::string settings() const {
    return fmt::format("# Robot: {}, {} kg ({})\n{}", robot_.name, robot_.mass, robot_.source,
                       request_.settings);
  }

  double bound(const MapCell& cell) const {
    const double angle = cell.direction * std::numbers::pi / 180.0;
    if (cell.controller == MapController::none) return bound_.largest_impulse(angle, {});
    if (bound_.steps) return bound_.largest_impulse_in(angle, bound_.steps->most);
    return bound_.largest_impulse(angle, cell.step_time);
  }

  // Runs a cell in the child process.
  std::string run_cell(const MapCell& cell) const {
    const std::unique_ptr<ConfigurableBiped> problem = request_.problem->clone();
    problem->settings() = with_cell(problem->settings(), cell);
    const auto begin = WallClock::now();
    const RunLog log = simulate(*problem, robot_);
    MapRow row = map_row(cell, bound(cell), problem->settings().push, log, problem->judge(log));
    row.seconds = seconds_since(begin);
    return to_line(row);
  }

  void work(MapProgress& progress) {
    long id = 0;
    while (DeferSignals::received() == 0) {
      while (!pool_.is_full()) {
        const std::optional<MapCell> cell = plan_.next();
        if (!cell) break;
        under_way_[id] = *cell;
        pool_.start(id++, [this, cell] { return run_cell(*cell); });
      }
      if (pool_.is_idle()) break;
      for (const WorkResult& work : pool_.wait(live_period)) take(work, progress);
      progress.show();
    }
    pool_.stop();
  }

  void take(const WorkResult& work, MapProgress& progress) {
    using End = WorkResult::End;
    // If the first run is rejected, all runs would be rejected.
    if (work.end == End::refused && runs_ == 0) throw InputError(work.text);
    const auto found = under_way_.find(work.id);
    const MapCell cell = found->second;
    under_way_.erase(found);
    std::optional<MapRow> row;
    if (work.end == End::done) row = from_line(work.text);
    if (!row) {
      row.emplace();
      row->cell = cell;
      row->outcome = MapOutcome::failed;
      row->bound = bound(cell);
      row->reason = work.end == End::done ? "its result cannot be read" : work.text;
    }
    ++runs_;
    if (row->failed_solves > 0) ++failed_solves_;
    if (row->outcome == MapOutcome::failed) {
      ++failures_;
      progress.end_line();
      fmt::print("failed: {}, step {} s, {} deg, {} N s: {}\n", name_of(cell.controller),
                 cell.step_time, cell.direction, cell.impulse, row->reason);
    }
    keep(plan_.finish(*row));
  }

  void keep(const std::vector<MapRow>& rows) {
    for (const MapRow& row : rows)
      if (row.outcome != MapOutcome::not_run || given_up_before_.insert(row.cell).second)
        file_.append(row);
  }

  const MapRequest& request_;
  RobotDescription robot_;
  PendulumBound bound_;
  MapPlan plan_;
  MapFile file_;
  ProcessPool pool_;
  std::map<long, MapCell> under_way_;
  std::set<MapCell> given_up_before_;
  int restored_ = 0, runs_ = 0, failures_ = 0, failed_solves_ = 0;
};

}  // namespace

ExitStatus run_map(const MapRequest& request, std::string* json) {
  MapRun map(request);
  const ExitStatus status = map.run();
  if (json != nullptr) *json = map_json(map.plan());
  return status;
}

}  // namespace saltus::robots::walking
