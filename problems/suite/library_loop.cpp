#include "problems/suite/library_loop.hpp"

#include <algorithm>
#include <utility>

#include "problems/library/run_case.hpp"

namespace saltus {
namespace {

bool depends_on_time(const Function& f) {
  bool depends = false;
  f.jacobian_pattern().for_each([&](int, int column, int) { depends = depends || column == 0; });
  return depends;
}

// Range of each state along the plan, the unit of disturbances.
VectorXd ranges_of(const Trajectory& plan, Eigen::Index states) {
  VectorXd lowest = VectorXd::Constant(states, infinity), highest = -lowest;
  const auto look_at = [&](const VectorXd& x) {
    const Eigen::Index n = std::min(states, x.size());
    lowest.head(n) = lowest.head(n).cwiseMin(x.head(n));
    highest.head(n) = highest.head(n).cwiseMax(x.head(n));
  };
  for (const Trajectory::Piece& piece : plan.pieces()) {
    look_at(piece.state);
    look_at(piece.end_state);
  }
  return highest - lowest;
}

ControllerOptions controller_options(const LoopConfig& config, double period) {
  ControllerOptions options;
  options.period = period;
  if (config.deadline > 0.0) options.deadline = config.deadline;
  return options;
}

// The switches are those of the plan.
void end_phases_as_planned(PhasedPlant& plant, const Trajectory& plan) {
  for (const Trajectory::Piece& piece : plan.pieces()) plant.end_phase_at(piece.phase, piece.end());
}

}  // namespace

const char* describe(Horizon horizon) {
  switch (horizon) {
    case Horizon::fitting:
      return "fitting";
    case Horizon::shrinking:
      return "shrinking";
    case Horizon::receding:
      return "receding";
    case Horizon::plan:
      return "plan";
  }
  return "unknown";
}

void declare_loop(Settings& s, LoopConfig& loop) {
  s.flag("loop.run", loop.run, "simulate a closed loop with a plant instead of one solve");
  s.alias("loop", "loop.run");
  s.choice<Horizon>(
      "loop.horizon", loop.horizon,
      {{"fitting", Horizon::fitting},
       {"shrinking", Horizon::shrinking},
       {"receding", Horizon::receding},
       {"plan", Horizon::plan}},
      "shrinking: to the problem's end; receding: of constant length; plan: follow the first plan "
      "without feedback; fitting: receding for time-invariant regulators, otherwise shrinking");
  s.choice("loop.method", loop.method, tick_methods(),
           "one step of the real-time iteration per tick, or a solve to the optimum (always with "
           "Ipopt)");
  s.number("loop.period", loop.period, "s", "control period; 0: 1/50 of the plan's duration",
           at_least(0.0));
  s.number(
      "loop.duration", loop.duration, "s",
      "duration of the run; 0: to the problem's end, or twice the plan with a receding horizon",
      at_least(0.0));
  s.number("loop.deadline_s", loop.deadline, "s", "time limit per tick (wall clock); 0: none",
           at_least(0.0));
  s.renamed("loop.deadline", "loop.deadline_s", "0.4");
  s.number("loop.disturbance", loop.disturbance, "",
           "standard deviation of the disturbance of the plant's state at every tick, as a "
           "fraction of the range of each state along the plan",
           between(0.0, 1.0));
  s.number("loop.noise", loop.noise, "",
           "standard deviation of the measurement noise, as a fraction of the same range",
           between(0.0, 1.0));
  s.integer("loop.seed", loop.seed, "", "seed of disturbance and noise", at_least(0.0));
  s.choice("loop.integrator", loop.integrator, schemes(),
           "integrator of the plant; own: that of the controller's model");
  s.number("loop.integrator_tolerance", loop.integrator_tolerance, "",
           "tolerance of the plant's CVODES or ARKODE", between(1e-14, 1e-2));
  s.integer("loop.plan_every", loop.plan_every, "",
            "a plan is stored every this many ticks; 0: none", between(0.0, 1e6));
}

std::string why_no_loop(const OptimalControlProblem& problem) {
  bool decides = false;
  for (const PhaseDefinition& phase : problem.phases()) {
    if (!phase.switching.empty())
      return "its phase '" + phase.name +
             "' has events inside, whose times these controllers cannot choose";
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
      if (block.unknown) return "it has unknown parameters, which are fixed before the start";
    if (!phase.integrals.empty())
      return "it limits the integral '" + phase.integrals.front().name +
             "', whose value so far a controller does not know";
    decides = decides || phase.sizes.nu > 0 || phase.has_free_duration();
  }
  if (!decides) return "it has no input and no free duration, only a free start";
  if (!problem.links().empty())
    return "its link '" + problem.links().front().name + "' couples past and future phases";
  if (problem.start_time_bounds())
    return "its start time is free, but a plant starts at a given time";
  if (problem.closing()) return "it is periodic, so its start depends on its end";
  for (const Bounds& b : problem.start_bounds())
    if (!b.is_equality()) return "its start is free, but a plant starts from a given state";
  return {};
}

Horizon fitting_horizon(const OptimalControlProblem& problem) {
  const PhaseDefinition& only = problem.phases().front();
  bool recedes = problem.phases().size() == 1 && !only.has_free_duration() &&
                 problem.schedule().events().empty() && !depends_on_time(only.dynamics);
  for (const Term& term : only.terms) {
    const bool is_end_condition =
        term.kind == Term::Kind::constraint && term.domain == Term::Domain::phase_end;
    const bool is_target = term.kind == Term::Kind::cost && term.domain == Term::Domain::phase_end;
    recedes = recedes && !is_end_condition && !is_target && term.window.is_whole() &&
              !term.reference.varies() && !depends_on_time(term.function);
  }
  return recedes ? Horizon::receding : Horizon::shrinking;
}

LibraryLoop close_loop(const ReferenceCase& c, const Solution& plan, SolverChoice solver,
                       const LoopConfig& config) {
  const OptimalControlProblem problem = c.problem();
  LibraryLoop result;
  result.horizon = config.horizon == Horizon::fitting ? fitting_horizon(problem) : config.horizon;
  const double length = plan.trajectory.end_time() - plan.trajectory.start_time();
  const double period = config.period > 0.0 ? config.period : length / 50.0;

  const IntegratorChoice scheme = make_scheme(config.integrator, config.integrator_tolerance);
  PhasedPlant plant(problem, scheme ? scheme : c.options.integrator);
  const VectorXd ranges = ranges_of(plan.trajectory, plant.state().size());
  LoopOptions options;
  options.samples_per_tick = 4;
  options.plan_every = config.plan_every;
  options.keep_unmet = 1;
  options.live_folder = config.live_folder;
  options.state_names = c.states;
  options.input_names = c.inputs;
  options.disturbances.seed = static_cast<std::uint64_t>(config.seed);
  if (config.disturbance > 0.0) options.disturbances.state_noise = config.disturbance * ranges;
  if (config.noise > 0.0) options.disturbances.measurement_noise = config.noise * ranges;

  const RealTimeChoice choice{
      .solver = solver, .method = config.method, .tolerance = library_solver_tolerance};
  const ControllerOptions controls = controller_options(config, period);
  // With a free end a disturbed motion may take longer than planned, within a limit.
  options.duration = config.duration > 0.0 ? config.duration : 2.0 * length;
  if (result.horizon == Horizon::receding) {
    RecedingHorizonController controller =
        make_controller(MultipleShooting(problem, c.options), choice, controls);
    controller.adopt_plan(problem.start_time(), plan.trajectory);
    result.log = simulate_closed_loop(controller, plant, options);
  } else if (result.horizon == Horizon::shrinking) {
    ShrinkingHorizonController controller = make_controller(problem, c.options, choice, controls);
    controller.adopt_plan(plan.trajectory);
    result.log = simulate_closed_loop(controller, plant, options);
  } else {
    end_phases_as_planned(plant, plan.trajectory);
    options.period = period;
    options.until = [&](double, const VectorRef&) { return plant.is_over(); };
    const FeedbackLaw as_planned = [&](double t, const VectorRef&, VectorOut input) {
      const VectorXd u = plan.trajectory.input(t + 0.5 * period);
      input.head(u.size()) = u;
    };
    result.log = simulate_closed_loop(as_planned, plant, options);
  }
  result.cost = plant.cost();
  result.end_misses = plant.end_misses();
  result.path_misses = plant.path_misses();
  if (plant.is_over()) result.over_since = plant.over_since();
  return result;
}

PlanRunOut run_out(const ReferenceCase& c, const Solution& plan, const IntegratorChoice& scheme) {
  PhasedPlant plant(c.problem(), scheme ? scheme : c.options.integrator);
  end_phases_as_planned(plant, plan.trajectory);
  PlanRunOut result;
  for (const Trajectory::Piece& piece : plan.trajectory.pieces()) {
    const bool is_ramp = piece.coefficients.size() > plant.inputs();
    // steps in place of ramps: the error of the cost is 1 / 16^2 of a ramp's
    const int steps = is_ramp ? 16 : 1;
    const double h = piece.length / steps;
    for (int s = 0; s < steps && result.failure.empty(); ++s)
      if (!plant.advance(plan.trajectory.input(piece.start + (s + 0.5) * h), h))
        result.failure = plant.failure();
  }
  result.cost = plant.cost();
  result.end_misses = plant.end_misses();
  return result;
}

}  // namespace saltus
