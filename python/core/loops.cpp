// Controllers, plants and closed loops.
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "core.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/mpc/shrinking_horizon.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/simulation/plants.hpp"

namespace saltus::python {
namespace {

using Release = py::gil_scoped_release;

// The solver of the ticks: the real-time iteration with these options, or a full solve.
using TickSolver = std::variant<std::monostate, RealTimeIterationOptions, std::shared_ptr<Solver>>;

RecedingHorizonController make_receding(MultipleShooting shooting, const TickSolver& solver,
                                        ControllerOptions options) {
  if (const auto* full = std::get_if<std::shared_ptr<Solver>>(&solver); full != nullptr && *full)
    return {std::move(shooting), make_real_time_solver(std::make_unique<SharedSolver>(*full)),
            std::move(options)};
  if (const auto* iteration = std::get_if<RealTimeIterationOptions>(&solver)) {
    auto steps = make_real_time_iteration(shooting.nlp(), *iteration);
    return {std::move(shooting), std::move(steps), std::move(options)};
  }
  return {std::move(shooting), std::move(options)};
}

// A function of (t, state) that returns a vector, as one that writes it.
template <class Returned>
auto writer_of(py::handle function) {
  return [f = function.cast<std::function<Returned(double, VectorXd)>>()](
             double t, const VectorRef& state, VectorOut out) {
    const Returned value = f(t, state);
    if (value.size() != out.size())
      throw DefinitionError(fmt::format("a function of (t, x) returned {} entries, expected {}",
                                        value.size(), out.size()));
    out = value;
  };
}

void add_options(py::module_& m) {
  py::enum_<Provenance>(m, "Provenance", "Source of the input of a tick.")
      .value("optimal", Provenance::optimal)
      .value("feasible", Provenance::feasible)
      .value("shifted", Provenance::shifted)
      .value("fallback", Provenance::fallback)
      .value("step", Provenance::step);
  Struct<ControllerOptions>(m, "ControllerOptions", "Options of a controller.")
      .field("period", &ControllerOptions::period)
      .field("deadline", &ControllerOptions::deadline)
      .field("optimality", &ControllerOptions::optimality)
      .field("feasibility", &ControllerOptions::feasibility)
      .field("longest_shift", &ControllerOptions::longest_shift)
      .field("send", &ControllerOptions::send)
      .field("fallback_input", &ControllerOptions::fallback_input)
      .field("fallback",
             [](ControllerOptions& o, py::handle to) { o.fallback = writer_of<VectorXd>(to); })
      .from_keywords();
  Struct<RealTimeIterationOptions>(m, "RealTimeIterationOptions",
                                   "Options of the real-time iteration.")
      .field("tolerance", &RealTimeIterationOptions::tolerance)
      .field("max_iterations", &RealTimeIterationOptions::max_iterations)
      .field("curvature", &RealTimeIterationOptions::curvature)
      .field("convexity_floor", &RealTimeIterationOptions::convexity_floor)
      .from_keywords();
  py::enum_<PulseShape>(m, "PulseShape", "Shape of a pulse over time.")
      .value("rectangle", PulseShape::rectangle)
      .value("half_sine", PulseShape::half_sine)
      .value("triangle", PulseShape::triangle);
  Struct<Pulse>(m, "Pulse", "An impulse that is spread over a limited time.")
      .field("impulse", &Pulse::impulse)
      .field("direction", &Pulse::direction)
      .field("start", &Pulse::start)
      .field("duration", &Pulse::duration)
      .field("shape", &Pulse::shape)
      .from_keywords();
  Struct<Disturbances>(m, "Disturbances",
                       "Noise, delays, pulses and other disturbances. `input` and `state` are "
                       "functions of (t, x) that return what is added.")
      .field("input", [](Disturbances& d, py::handle to) { d.input = writer_of<VectorXd>(to); })
      .field("state", [](Disturbances& d, py::handle to) { d.state = writer_of<VectorXd>(to); })
      .field("pulses", &Disturbances::pulses)
      .field("state_noise", &Disturbances::state_noise)
      .field("measurement_noise", &Disturbances::measurement_noise)
      .field("seed", &Disturbances::seed)
      .field("measurement_delay", &Disturbances::measurement_delay)
      .field("input_delay", &Disturbances::input_delay)
      .field("first_input", &Disturbances::first_input)
      .from_keywords();
  const auto of_state = [](auto field, auto result) {
    using Result = decltype(result);
    return [field](LoopOptions& o, py::handle to) {
      o.*field = [f = to.cast<std::function<Result(double, VectorXd)>>()](
                     double t, const VectorRef& x) { return f(t, x); };
    };
  };
  Struct<LoopOptions>(m, "LoopOptions", "Options of a closed-loop run and its log.")
      .field("duration", &LoopOptions::duration)
      .field("period", &LoopOptions::period)
      .field("samples_per_tick", &LoopOptions::samples_per_tick)
      .field("record", &LoopOptions::record)
      .field("plan_every", &LoopOptions::plan_every)
      .field("keep_unmet", &LoopOptions::keep_unmet)
      .field("disturbances", &LoopOptions::disturbances)
      .field("state_names", &LoopOptions::state_names)
      .field("input_names", &LoopOptions::input_names)
      .field("before_tick",
             [](LoopOptions& o, py::handle to) {
               o.before_tick = [f = to.cast<std::function<void(double, VectorXd)>>()](
                                   double t, const VectorRef& x) { f(t, x); };
             })
      .field("on_event", &LoopOptions::on_event)
      .field("until", of_state(&LoopOptions::until, bool()))
      .from_keywords();
}

void add_controllers(py::module_& m) {
  py::class_<HeldInput::Piece>(m, "InputPiece", "A constant input during a part of a tick.")
      .def_readonly("start", &HeldInput::Piece::start)
      .def_readonly("length", &HeldInput::Piece::length)
      .def_property_readonly("input",
                             [](const HeldInput::Piece& p) { return VectorXd(p.input()); });
  py::class_<ControlTick>(m, "ControlTick", "Result of one tick.")
      .def_readonly("time", &ControlTick::time)
      .def_readonly("provenance", &ControlTick::provenance, "Source of the input.")
      .def_property_readonly(
          "input",
          [](const ControlTick& t) {
            return std::vector<HeldInput::Piece>(t.input.begin(), t.input.end());
          },
          "Pieces that cover the tick.")
      .def_property_readonly(
          "u", [](const ControlTick& t) { return VectorXd(t.input[0].input()); },
          "The input at the start of the tick.")
      .def_readonly("status", &ControlTick::status)
      .def_readonly("iterations", &ControlTick::iterations)
      .def_readonly("objective", &ControlTick::objective)
      .def_readonly("kkt", &ControlTick::kkt)
      .def_readonly("violation", &ControlTick::violation)
      .def_readonly("preparation", &ControlTick::preparation)
      .def_readonly("feedback", &ControlTick::feedback)
      .def_readonly("seconds", &ControlTick::seconds)
      .def_readonly("check", &ControlTick::check);
  py::class_<LatencyHistogram>(m, "LatencyHistogram", "Histogram of latencies in seconds.")
      .def_property_readonly("count", &LatencyHistogram::count)
      .def("quantile", &LatencyHistogram::quantile, "fraction"_a)
      .def("median", &LatencyHistogram::median)
      .def("p99", &LatencyHistogram::p99)
      .def("max", &LatencyHistogram::max);
  py::class_<LoopStatistics>(m, "LoopStatistics", "Counts and latencies of the ticks.")
      .def("count", &LoopStatistics::count, "provenance"_a)
      .def("all", &LoopStatistics::all)
      .def_readonly("feedback", &LoopStatistics::feedback)
      .def_readonly("preparation", &LoopStatistics::preparation)
      .def_readonly("prepared_ahead", &LoopStatistics::prepared_ahead);

  using Receding = RecedingHorizonController;
  py::class_<Receding>(m, "RecedingHorizonController",
                       "Model predictive controller whose horizon starts at the present.")
      .def(py::init([](MultipleShooting& shooting, const TickSolver& solver,
                       const py::kwargs& keywords) {
             ControllerOptions options;
             set_fields(keywords, options);
             return make_receding(std::move(shooting), solver, std::move(options));
           }),
           "shooting"_a, "solver"_a = py::none(),
           "Takes over the transcription. `solver` is RealTimeIterationOptions (default) or a "
           "Solver for full solves. Options: those of ControllerOptions.")
      .def_property_readonly("period", &Receding::period)
      .def_property_readonly("solver_name", &Receding::solver_name)
      .def_property_readonly("problem",
                             [](const Receding& c) { return OptimalControlProblem(c.problem()); })
      .def(
          "set_data",
          [](Receding& c, const std::string& name, const Numbers& values) {
            c.set_entries(name, vector_of(values), {});
          },
          "name"_a, "values"_a, "Sets data by the name of a block.")
      .def("retime", &Receding::retime, "event"_a, "time"_a)
      .def("set_schedule", &Receding::set_schedule, "schedule"_a)
      .def("set_previous_input", &Receding::set_previous_input, "input"_a)
      .def("adopt_plan", &Receding::adopt_plan, "t"_a, "plan"_a)
      .def("prepare", &Receding::prepare, "t"_a, py::call_guard<Release>(),
           "Does all work for the tick at time t that does not need the measurement.")
      .def(
          "feedback",
          [](Receding& c, const VectorRef& state) {
            Release release;
            return ControlTick(c.feedback(state));
          },
          "state"_a, "Runs the tick at the prepared time.")
      .def(
          "tick",
          [](Receding& c, double t, const VectorRef& state) {
            Release release;
            return ControlTick(c.tick(t, state));
          },
          "t"_a, "state"_a, "Calls prepare(t) and feedback(state).")
      .def("follows_plan", &Receding::follows_plan)
      .def_property_readonly("statistics", &Receding::statistics,
                             py::return_value_policy::reference_internal)
      .def("end_of_phase", &Receding::end_of_phase, "phase"_a)
      .def("report", &Receding::report, "The plan of the last tick with costs and residuals.");

  using Shrinking = ShrinkingHorizonController;
  py::class_<Shrinking>(m, "ShrinkingHorizonController",
                        "Controller of a motion with an end: plans the remaining phases.")
      .def(py::init([](const OptimalControlProblem& problem, const TickSolver& solver,
                       const py::kwargs& keywords) {
             ShootingOptions grid;
             grid.integrator = runge_kutta4({.steps = 2});
             ControllerOptions options;
             set_fields(keywords, options, grid);
             Release release;
             return Shrinking(problem,
                              remaining_controllers(problem, grid, [&](MultipleShooting r) {
                                return make_receding(std::move(r), solver, options);
                              }));
           }),
           "problem"_a, "solver"_a = py::none(),
           "Options: those of ControllerOptions and ShootingOptions.")
      .def_property_readonly("period", &Shrinking::period)
      .def_property_readonly("phase", &Shrinking::phase)
      .def("adopt_plan", &Shrinking::adopt_plan, "plan"_a)
      .def("enter", &Shrinking::enter, "phase"_a, "t"_a)
      .def(
          "tick",
          [](Shrinking& c, double t, const VectorRef& state) {
            Release release;
            return ControlTick(c.tick(t, state));
          },
          "t"_a, "state"_a)
      .def("end_of_phase", &Shrinking::end_of_phase, "phase"_a)
      .def("report", &Shrinking::report);
}

// Plants that users write in Python.
class PythonPlant : public LoopPlant {
 public:
  double time() const override { PYBIND11_OVERRIDE_PURE(double, LoopPlant, time, ); }
  VectorXd state() const override { PYBIND11_OVERRIDE_PURE(VectorXd, LoopPlant, state, ); }
  int inputs() const override { PYBIND11_OVERRIDE_PURE(int, LoopPlant, inputs, ); }
  bool advance(const VectorRef& input, double length) override {
    return call_advance(VectorXd(input), length);
  }
  std::string failure() const override { PYBIND11_OVERRIDE(std::string, LoopPlant, failure, ); }
  std::string mode() const override { PYBIND11_OVERRIDE(std::string, LoopPlant, mode, ); }
  std::string name() const override { PYBIND11_OVERRIDE(std::string, LoopPlant, name, ); }
  void enter_phase(int phase) override { PYBIND11_OVERRIDE(void, LoopPlant, enter_phase, phase); }

 private:
  bool call_advance(const VectorXd& input, double length) {
    PYBIND11_OVERRIDE_PURE_NAME(bool, LoopPlant, "advance", advance, input, length);
  }
};

void add_plants(py::module_& m) {
  py::class_<HybridEvent> event(m, "HybridEvent", "A recorded event.");
  event.def_readonly("time", &HybridEvent::time)
      .def_readonly("name", &HybridEvent::name)
      .def_readonly("mode_before", &HybridEvent::mode_before)
      .def_readonly("mode_after", &HybridEvent::mode_after)
      .def_readonly("before", &HybridEvent::before)
      .def_readonly("after", &HybridEvent::after)
      .def("__repr__",
           [](const HybridEvent& e) { return fmt::format("<'{}' at {} s>", e.name, e.time); });
  py::class_<LoopPlant, PythonPlant>(m, "LoopPlant",
                                     "Derive from this class to use your own simulator: time(), "
                                     "state(), inputs() and advance(input, length).")
      .def(py::init<>())
      .def_property_readonly("plant_name", &LoopPlant::name)
      .def("time", &LoopPlant::time)
      .def("state", &LoopPlant::state)
      .def("inputs", &LoopPlant::inputs)
      .def(
          "advance",
          [](LoopPlant& p, const VectorXd& input, double length) {
            Release release;
            return p.advance(input, length);
          },
          "input"_a, "length"_a, "Advances under a constant input. False on failure.")
      .def("failure", &LoopPlant::failure)
      .def("mode", &LoopPlant::mode)
      .def("name", &LoopPlant::name)
      .def(
          "disturb", [](LoopPlant& p, const VectorXd& change) { p.disturb(change); }, "change"_a);
  py::class_<IntegratorPlant, LoopPlant>(m, "IntegratorPlant", "A plant given by its dynamics.")
      .def(
          "set_parameters",
          [](IntegratorPlant& p, const VectorXd& parameters) { p.set_parameters(parameters); },
          "parameters"_a, "Sets the parameters from now on.");
  py::class_<PhasedPlant, LoopPlant>(m, "PhasedPlant", "A plant that runs through phases.")
      .def(py::init([](const OptimalControlProblem& problem, const Integrator& scheme) {
             return PhasedPlant(problem, scheme.choice);
           }),
           "problem"_a, "scheme"_a)
      .def_property_readonly("phase", &PhasedPlant::phase)
      .def_property_readonly("cost", &PhasedPlant::cost)
      .def("end_phase_at", &PhasedPlant::end_phase_at, "phase"_a, "t"_a)
      .def("is_over", &PhasedPlant::is_over);
  m.def(
      "nominal_plant",
      [](const OptimalControlProblem& problem, const Integrator& scheme) {
        return nominal_plant(problem, scheme.choice);
      },
      "problem"_a, "scheme"_a,
      "The nominal model: dynamics, parameters, events and start of the first phase.");
  m.def(
      "make_plant",
      [](const py::object& dynamics, const Integrator& scheme, VectorXd start, VectorXd parameters,
         int nu) {
        IntervalProblem problem;
        problem.arguments = {static_cast<int>(start.size()), nu,
                             static_cast<int>(parameters.size())};
        const FormulaSizes sizes{problem.arguments.nx, nu, problem.arguments.np, 0};
        problem.dynamics = function_of(dynamics, sizes, "the dynamics of a plant");
        require_rows(problem.dynamics, sizes.nx, "a plant",
                     "the dynamics must return one row per state");
        return IntegratorPlant(std::move(problem), scheme.choice, std::move(start),
                               std::move(parameters));
      },
      "dynamics"_a, "scheme"_a, "start"_a, "parameters"_a = VectorXd(), "nu"_a = 0,
      "A plant for dynamics that are a formula.");
}

py::dict table_of(const std::vector<Sample>& samples) {
  Eigen::Index nx = 0, nu = 0;
  for (const Sample& s : samples) {
    nx = std::max(nx, s.state.size());
    nu = std::max(nu, s.input.size());
  }
  const auto count = static_cast<py::ssize_t>(samples.size());
  py::array_t<double> t(count), x({count, static_cast<py::ssize_t>(nx)}),
      u({count, static_cast<py::ssize_t>(nu)});
  py::list modes;
  auto times = t.mutable_unchecked<1>();
  auto states = x.mutable_unchecked<2>(), inputs = u.mutable_unchecked<2>();
  const auto entry = [](const VectorXd& v, Eigen::Index j) {
    return j < v.size() ? v[j] : std::numeric_limits<double>::quiet_NaN();
  };
  for (py::ssize_t i = 0; i < count; ++i) {
    const Sample& s = samples[static_cast<std::size_t>(i)];
    times(i) = s.time;
    for (Eigen::Index j = 0; j < nx; ++j) states(i, j) = entry(s.state, j);
    for (Eigen::Index j = 0; j < nu; ++j) inputs(i, j) = entry(s.input, j);
    modes.append(s.mode);
  }
  py::dict table;
  table["t"] = t;
  table["mode"] = modes;
  table["x"] = x;
  table["u"] = u;
  return table;
}

void add_logs(py::module_& m) {
  py::class_<LoopMiss>(m, "LoopMiss", "A violated hard constraint with its largest violation.")
      .def_readonly("phase", &LoopMiss::phase)
      .def_readonly("term", &LoopMiss::term)
      .def_readonly("time", &LoopMiss::time)
      .def_readonly("amount", &LoopMiss::amount)
      .def_readonly("tolerance", &LoopMiss::tolerance)
      .def("__repr__", [](const LoopMiss& miss) { return describe(miss); });
  py::class_<Recording>(m, "Recording", "A recorded run.")
      .def_property_readonly("state_names", &Recording::state_columns)
      .def_property_readonly("input_names", &Recording::input_columns)
      .def_readonly("events", &Recording::events)
      .def(
          "samples", [](const Recording& r) { return table_of(r.samples); },
          "Arrays t, mode, x, u with one row per sample; an event has two rows.");
  m.def(
      "record",
      [](const OptimalControlProblem& problem, const Trajectory& trajectory, int samples) {
        return record(problem, trajectory, samples);
      },
      "problem"_a, "trajectory"_a, "samples_per_interval"_a = 8, "Samples a plan.");
  py::class_<LoopLog> log(m, "LoopLog", "Result of a closed-loop run.");
  py::class_<LoopLog::Tick>(log, "Tick", "A tick: its measurement and its answer.")
      .def_readonly("time", &LoopLog::Tick::time)
      .def_readonly("measured", &LoopLog::Tick::measured)
      .def_readonly("provenance", &LoopLog::Tick::provenance)
      .def_readonly("status", &LoopLog::Tick::status)
      .def_readonly("message", &LoopLog::Tick::message)
      .def_readonly("iterations", &LoopLog::Tick::iterations)
      .def_readonly("objective", &LoopLog::Tick::objective)
      .def_readonly("kkt", &LoopLog::Tick::kkt)
      .def_readonly("violation", &LoopLog::Tick::violation)
      .def_readonly("seconds", &LoopLog::Tick::seconds)
      .def_readonly("preparation", &LoopLog::Tick::preparation)
      .def_readonly("check", &LoopLog::Tick::check);
  log.def_readonly("completed", &LoopLog::completed)
      .def_readonly("message", &LoopLog::message)
      .def_readonly("controller", &LoopLog::controller)
      .def_readonly("plant", &LoopLog::plant)
      .def_readonly("period", &LoopLog::period)
      .def_readonly("recording", &LoopLog::recording)
      .def_readonly("ticks", &LoopLog::ticks)
      .def_property_readonly(
          "plans",
          [](const LoopLog& l) {
            py::list plans;
            for (const LoopLog::Plan& plan : l.plans)
              plans.append(py::make_tuple(plan.made_at, table_of(plan.samples)));
            return plans;
          },
          "Pairs of the time of a tick and the nodes of its plan.")
      .def_property_readonly(
          "unmet",
          [](const LoopLog& l) {
            py::list all;
            for (const LoopLog::UnmetTick& tick : l.unmet)
              all.append(py::make_tuple(tick.time, tick.problem));
            return all;
          },
          "Pairs of time and problem of ticks with unsatisfied constraints.")
      .def_readonly("statistics", &LoopLog::statistics)
      .def_readonly("misses", &LoopLog::misses)
      .def_readonly("reached_end", &LoopLog::reached_end)
      .def_property_readonly("final_state", &LoopLog::final_state)
      .def("ok", &LoopLog::ok)
      .def("count", &LoopLog::count, "provenance"_a)
      .def("ticks_csv", &LoopLog::ticks_csv)
      .def("summary_json", &LoopLog::summary_json)
      .def("write", &LoopLog::write, "folder"_a)
      .def("__repr__", [](const LoopLog& l) { return "<LoopLog: " + l.message + ">"; });

  const auto options_of = [](const py::kwargs& keywords) {
    LoopOptions options;
    set_fields(keywords, options);
    return options;
  };
  const char* doc = "Runs a controller or a law u(t, x) on a plant. Options: those of LoopOptions.";
  const auto add = [&](auto call) {
    m.def("simulate_closed_loop", call, "controller"_a, "plant"_a, doc);
  };
  add([=](RecedingHorizonController& c, LoopPlant& plant, const py::kwargs& keywords) {
    const LoopOptions options = options_of(keywords);
    Release release;
    return simulate_closed_loop(c, plant, options);
  });
  add([=](ShrinkingHorizonController& c, PhasedPlant& plant, const py::kwargs& keywords) {
    const LoopOptions options = options_of(keywords);
    Release release;
    return simulate_closed_loop(c, plant, options);
  });
  add([=](ShrinkingHorizonController& c, LoopPlant& plant, const py::kwargs& keywords) {
    const LoopOptions options = options_of(keywords);
    Release release;
    return simulate_closed_loop(c, plant, options);
  });
  add([=](const py::function& law, LoopPlant& plant, const py::kwargs& keywords) {
    const LoopOptions options = options_of(keywords);
    const FeedbackLaw feedback = writer_of<VectorXd>(law);
    Release release;
    if (auto* phased = dynamic_cast<PhasedPlant*>(&plant))
      return simulate_closed_loop(feedback, *phased, options);
    return simulate_closed_loop(feedback, plant, options);
  });
}

}  // namespace

void add_loops(py::module_& m) {
  add_options(m);
  add_controllers(m);
  add_plants(m);
  add_logs(m);
}

}  // namespace saltus::python
