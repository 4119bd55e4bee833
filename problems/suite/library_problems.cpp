#include "problems/suite/library_problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "problems/library/c01_mpc_qps.hpp"
#include "problems/library/catalogue.hpp"
#include "problems/library/run_case.hpp"
#include "problems/suite/integrator_names.hpp"
#include "problems/suite/library_loop.hpp"
#include "problems/suite/run_files.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/simulation/explanation_json.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* scheme_doc =
    "integrator: the case's own, Runge-Kutta of order 4 or 8, CVODES, ARKODE, or the exact "
    "zero-order hold";

void finish(const RunContext& context, Json summary, bool pictures, const std::string& text) {
  const OutputFolder& output = context.output;
  output.write("config.yaml", std::string_view(context.effective_config));
  output.write("summary.json", summary);
  const bool drawn =
      pictures && run_python_module("saltus.plot_trajectory", output.path(), "picture");
  fmt::print("{}results in {}: trajectory and events (.csv), summary.json{}\n", text,
             output.path().string(), drawn ? ", pictures (.png)" : "");
}

template <class Config>
ProblemEntry entry_of(const std::string& id, const std::string& name, std::string summary,
                      const char* kind, void (*declare)(Settings&, Config&),
                      std::function<ExitStatus(const Config&, const RunContext&)> run) {
  ProblemEntry entry = problem_entry<Config>(lower_case(id) + "_" + name, std::move(summary),
                                             declare, std::move(run));
  entry.aliases = {id, name};
  entry.kind = kind;
  return entry;
}

// ---- optimal control ----------------------------------------------------------------------------

struct OptimalControlConfig {
  SolverChoice solver = SolverChoice::ipopt;
  int intervals = 0;
  bool refine = true;
  bool explain = false;
  double explain_limit = 20.0;  // s
  bool monitor = false;
  Scheme integrator = Scheme::own;
  double integrator_tolerance = 1e-9;
  int samples = 8;
  bool pictures = true;
  LoopConfig loop = {};
};

void declare_optimal_control(Settings& s, OptimalControlConfig& c) {
  s.choice("solver", c.solver, solver_choices(), "solver of the optimal control problem");
  s.integer("intervals", c.intervals, "", "intervals per phase; 0: the case's own grid",
            between(0, 2000));
  s.flag("refine", c.refine,
         "split the intervals in which the plan violates a path constraint between the nodes");
  s.flag("explain", c.explain,
         "explain in any case which constraints are violated and what would help; by default only "
         "if the constraints cannot be met");
  s.number("explain_limit_s", c.explain_limit, "s",
           "time limit for the explanation; 0: no explanation", between(0.0, 3600.0));
  s.renamed("explain_limit", "explain_limit_s", "0.4");
  s.flag("monitor", c.monitor, "print every iteration of the solver");
  s.choice<Scheme>("integrator", c.integrator, schemes(), scheme_doc);
  s.number("integrator_tolerance", c.integrator_tolerance, "", "tolerance of CVODES and ARKODE",
           between(1e-14, 1e-2));
  s.integer("samples", c.samples, "", "rows of the table per interval", between(1, 1000));
  s.flag("pictures", c.pictures, "draw the picture at the end (needs python3 with matplotlib)");
  declare_loop(s, c.loop);
}

// Repeats the header every ten rows.
SolveObserver observer_of(const OptimalControlConfig& config) {
  SolveObserver observer{.should_stop = [] { return DeferSignals::received() != 0; }};
  if (config.monitor)
    observer.report = table_of_iterations([](const std::string& line) {
      fmt::print("{}\n", line);
      std::fflush(stdout);
    });
  return observer;
}

// True if the status means, or may mean, that the constraints are infeasible.
std::optional<Explanation> explain_case(const ReferenceCase& c, const Solution& solution,
                                        const OptimalControlConfig& config) {
  const bool may_be_infeasible = solution.status == SolveStatus::infeasible ||
                                 solution.status == SolveStatus::iteration_limit ||
                                 solution.status == SolveStatus::numerical_failure;
  if (config.explain_limit == 0.0 || (!config.explain && !may_be_infeasible)) return std::nullopt;
  return explain(c.problem(),
                 {.shooting = c.options,
                  .time_limit = config.explain_limit,
                  .guess = solution.trajectory.empty() ? std::optional<Trajectory>()
                                                       : std::optional(solution.trajectory)});
}

// One line per violated soft term, if no explanation was requested.
std::string soft_text(const Solution& solution) {
  constexpr double hardly = 1e-6;  // in units of the terms
  std::string text;
  for (const Solution::SoftViolation& soft : solution.soft_violations)
    if (soft.largest > hardly)
      text += fmt::format(
          "  the soft term '{}' of phase '{}' is violated by {:.4g} at t = {:.4g} s; --explain "
          "gives the reason\n",
          soft.term, soft.phase, soft.largest, soft.time);
  return text;
}

ExitStatus refuse_loop(const std::string& id, const std::string& name, const std::string& why) {
  fmt::print(stderr, "saltus: {} {} cannot run in closed loop: {}\n", id, name, why);
  return ExitStatus::not_applicable;
}

ExitStatus run_loop(const ReferenceCase& c, const Solution& plan,
                    const OptimalControlConfig& config, const RunContext& context) {
  if (!plan.ok() && plan.status != SolveStatus::coarse_grid) {
    fmt::print(stderr, "saltus: the initial plan failed: {}\n", plan.message);
    return ExitStatus::solver_failed;
  }
  LoopConfig with_view = config.loop;
  with_view.live_folder = context.output.path().string();
  const LibraryLoop loop = close_loop(c, plan, config.solver, with_view);
  const PlanRunOut planned =
      run_out(c, plan, make_scheme(config.loop.integrator, config.loop.integrator_tolerance));

  write_recording(context.output, loop.log.recording);
  const std::string ticks = loop.log.ticks_csv(), plans = loop.log.plans_csv();
  context.output.write("ticks.csv", std::string_view(ticks));
  if (!loop.log.plans.empty()) context.output.write("plans.csv", std::string_view(plans));
  Json summary = loop_json(c, plan, loop, planned);
  std::string unmet;
  if (!loop.log.unmet.empty() && config.explain_limit > 0.0) {
    const LoopLog::UnmetTick& first = loop.log.unmet.front();
    const Explanation explanation =
        explain(first.problem, {.shooting = first.shooting, .time_limit = config.explain_limit});
    summary["unmet"] = {{"t_s", first.time},
                        {"explanation", Json::parse(explanation_json(explanation))}};
    unmet = fmt::format("the first infeasible tick, at t = {:.4g} s: {}", first.time,
                        explanation.text());
  }
  summary["solver"] = name_of(config.solver);
  finish(context, summary, config.pictures, loop_text(c, loop, planned) + unmet);
  return loop.log.completed ? ExitStatus::ok : ExitStatus::solver_failed;
}

ExitStatus run_optimal_control(const ReferenceCase& known, const OptimalControlConfig& config,
                               const RunContext& context) {
  ReferenceCase c = known;
  if (config.intervals > 0) {
    c.options.intervals.clear();
    c.options.meshes.clear();
    c.options.intervals_per_phase = config.intervals;
  }
  if (const IntegratorChoice scheme = make_scheme(config.integrator, config.integrator_tolerance))
    c.options.integrator = scheme;
  if (config.loop.run) {
    const std::string why = why_no_loop(c.problem());
    return why.empty()
               ? run_loop(c, solve_case(c, config.solver, observer_of(config)), config, context)
               : refuse_loop(c.id, c.name, why);
  }
  int signal = 0;
  const RefinedSolution refined = [&] {
    const DeferSignals note;
    RefinedSolution result = solve_case_refined(
        c, config.solver, config.refine ? RefinementOptions{}.rounds : 1, observer_of(config));
    signal = DeferSignals::received();
    return result;
  }();
  const Solution& solution = refined.solution;
  const std::optional<Explanation> explanation =
      signal == 0 ? explain_case(c, solution, config) : std::nullopt;
  const CaseOutcome outcome = check_case(c, refined);
  Recording recording = record(c.problem(), solution.trajectory, config.samples);
  recording.state_names = c.states;
  recording.input_names = c.inputs;
  write_recording(context.output, recording);
  if (!solution.multipliers.empty()) {
    const std::string multipliers = multipliers_csv(solution);
    context.output.write("multipliers.csv", std::string_view(multipliers));
  }

  Json summary = summary_head(outcome, c.summary);
  summary.update(solution_json(solution, recording));
  summary["iterations"] = outcome.iterations;
  summary["seconds"] = outcome.seconds;
  summary["refinements"] = outcome.refinements;
  summary["reference"] = c.optimum;
  summary["solver"] = name_of(config.solver);
  summary["integrator"] = c.options.integrator->name();
  summary["checked"] = checked_json(outcome);
  summary["states"] = recording.state_columns();
  summary["inputs"] = recording.input_columns();
  summary["tables"] = {"trajectory.csv"};
  summary["interrupted"] = signal != 0;
  if (explanation) summary["explanation"] = Json::parse(explanation_json(*explanation));
  const bool is_broken = outcome.between_nodes && *outcome.between_nodes > c.between_nodes;
  const char* remedy = config.refine || !is_broken
                           ? ""
                           : "  --refine splits the intervals in which it is violated\n";
  finish(context, summary, config.pictures,
         fmt::format("{} {}: {}{}{}", c.id, c.name, verdict_text(outcome), remedy,
                     explanation ? explanation->text() : soft_text(solution)));
  if (signal != 0) {
    fmt::print("interrupted: results so far\n");
    std::fflush(nullptr);
    std::raise(signal);
  }
  return solution.ok() ? ExitStatus::ok : ExitStatus::solver_failed;
}

// ---- simulations --------------------------------------------------------------------------------

struct SimulationConfig {
  Scheme integrator = Scheme::own;
  double integrator_tolerance = 1e-9;
  bool pictures = true;
  bool loop = false;
};

void declare_loop_to_refuse(Settings& s, bool& loop) {
  s.flag("loop", loop, "not available: this case has nothing to control");
}

void declare_simulation(Settings& s, SimulationConfig& c) {
  s.choice<Scheme>("integrator", c.integrator, schemes(), scheme_doc);
  s.number("integrator_tolerance", c.integrator_tolerance, "", "tolerance of CVODES and ARKODE",
           between(1e-14, 1e-2));
  s.flag("pictures", c.pictures, "draw the picture at the end (needs python3 with matplotlib)");
  declare_loop_to_refuse(s, c.loop);
}

ExitStatus run_simulation(const SimulationCase& c, const SimulationConfig& config,
                          const RunContext& context) {
  if (config.loop) return refuse_loop(c.id, c.name, "it is a simulation without inputs");
  const std::vector<Motion> motions =
      c.motions(make_scheme(config.integrator, config.integrator_tolerance));
  const CaseOutcome outcome = run_case(c);
  Json summary = summary_head(outcome, c.summary), described = Json::array(),
       tables = Json::array();
  bool completed = true;
  std::string text = fmt::format("{} {}: {}", c.id, c.name, verdict_text(outcome));
  for (const Motion& m : motions) {
    write_recording(context.output, m.recording, m.name);
    tables.push_back("trajectory" + (m.name.empty() ? "" : "_" + m.name) + ".csv");
    Json events = Json::array();
    for (const HybridEvent& e : m.recording.events)
      events.push_back({{"t_s", e.time}, {"event", e.name}, {"kind", describe(e.kind)}});
    described.push_back({{"name", m.name},
                         {"completed", m.failure.empty()},
                         {"message", m.failure},
                         {"integrator", m.integrator},
                         {"events", events}});
    completed = completed && m.failure.empty();
    if (!m.failure.empty()) text += "  " + m.failure + "\n";
  }
  summary["completed"] = completed;
  summary["motions"] = described;
  summary["seconds"] = outcome.seconds;
  summary["checked"] = checked_json(outcome);
  if (!motions.empty()) {
    summary["integrator"] = motions.front().integrator;
    summary["states"] = motions.front().recording.state_columns();
    summary["inputs"] = motions.front().recording.input_columns();
    summary["plane"] = motions.front().plane;
    summary["logarithmic_time"] = motions.front().logarithmic_time;
  }
  summary["tables"] = tables;
  finish(context, summary, config.pictures, text);
  return completed ? ExitStatus::ok : ExitStatus::solver_failed;
}

// ---- quadratic programs -------------------------------------------------------------------------

struct QuadraticConfig {
  SolverChoice solver = SolverChoice::ipopt;
  bool loop = false;
};

void declare_quadratic(Settings& s, QuadraticConfig& c) {
  s.choice("solver", c.solver, solver_choices(), "solver of the quadratic programs");
  declare_loop_to_refuse(s, c.loop);
}

ExitStatus run_quadratic(const QuadraticConfig& config, const RunContext& context) {
  if (config.loop)
    return refuse_loop(library::mpc_qps_id, library::mpc_qps_name,
                       "its quadratic programs have no plants");
  const CaseOutcome outcome = library::run_mpc_qps(config.solver);
  if (outcome.verdict == Verdict::skipped || outcome.verdict == Verdict::not_applicable)
    throw InputError(outcome.status);
  Json summary = summary_head(outcome, outcome.exercises);
  summary["kind"] = "quadratic programs";
  summary["iterations"] = outcome.iterations;
  summary["seconds"] = outcome.seconds;
  summary["checked"] = checked_json(outcome);
  context.output.write("config.yaml", std::string_view(context.effective_config));
  context.output.write("summary.json", summary);
  fmt::print("{} {}: {}results in {}: summary.json\n", outcome.id, outcome.name,
             verdict_text(outcome), context.output.path().string());
  return outcome.verdict == Verdict::failed ? ExitStatus::solver_failed : ExitStatus::ok;
}

}  // namespace

std::vector<ProblemEntry> library_problems() {
  std::vector<ProblemEntry> entries;
  for (const ReferenceCase& c : reference_cases())
    entries.push_back(entry_of<OptimalControlConfig>(
        c.id, c.name, c.summary,
        why_no_loop(c.problem()).empty() ? "optimal control, --loop" : "optimal control",
        declare_optimal_control,
        [&c](const OptimalControlConfig& config, const RunContext& context) {
          return run_optimal_control(c, config, context);
        }));
  for (const SimulationCase& c : simulation_cases())
    entries.push_back(
        entry_of<SimulationConfig>(c.id, c.name, c.summary, "simulation", declare_simulation,
                                   [&c](const SimulationConfig& config, const RunContext& context) {
                                     return run_simulation(c, config, context);
                                   }));
  entries.push_back(entry_of<QuadraticConfig>(
      library::mpc_qps_id, library::mpc_qps_name,
      "Quadratic programs of walking robots, from files of reference data.", "quadratic programs",
      declare_quadratic, run_quadratic));
  std::stable_sort(entries.begin(), entries.end(),
                   [](const ProblemEntry& a, const ProblemEntry& b) { return a.name < b.name; });
  return entries;
}

}  // namespace saltus
