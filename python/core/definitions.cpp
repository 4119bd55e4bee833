// Phases and problems as Python defines them: the calls of Phase and OptimalControlProblem with
// sizes at run time.
#include "definitions.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>

namespace saltus::python {
namespace {

Limits limits_of(const std::variant<Limits, Bounds, std::vector<Bounds>>& limits) {
  if (const Limits* all = std::get_if<Limits>(&limits)) return *all;
  if (const Bounds* all = std::get_if<Bounds>(&limits)) return {*all};
  return {std::get<std::vector<Bounds>>(limits)};
}
using AnyLimits = std::variant<Limits, Bounds, std::vector<Bounds>>;

Reference reference_of(const std::variant<Reference, Numbers>& value) {
  if (const Reference* reference = std::get_if<Reference>(&value)) return *reference;
  return {vector_of(std::get<Numbers>(value))};
}
using AnyReference = std::variant<Reference, Numbers>;

std::optional<Instant> instant_of(const std::variant<std::monostate, double, Instant>& instant) {
  if (const double* seconds = std::get_if<double>(&instant)) return Instant(*seconds);
  if (const Instant* named = std::get_if<Instant>(&instant)) return *named;
  return std::nullopt;
}
using AnyInstant = std::variant<std::monostate, double, Instant>;

using Problem = OptimalControlProblem;

struct End {
  std::string phase;
  bool is_end;
  int nx, np;
};

Link link_of(const std::string& name, const py::object& formula, Limits limits,
             const py::args& ends) {
  Link link{name, {}, {}, std::move(limits), false};
  py::list sizes;
  int values = 0;
  for (const py::handle end : ends) {
    const End& e = end.cast<const End&>();
    link.ends.push_back({e.phase, e.is_end, e.nx, e.np});
    sizes.append(py::make_tuple(e.nx, e.np));
    values += link.ends.back().size();
  }
  const std::string where = fmt::format("link '{}'", name);
  link.function = py::module_::import("saltus._formulas")
                      .attr("link_function")(formula, sizes, where)
                      .cast<Function>();
  detail::checked_function(link.function, {values, 0, 0}, {{}, where});
  return link;
}

Schedule make_schedule(const std::vector<std::string>& modes,
                       const std::vector<std::pair<std::string, double>>& events) {
  std::vector<Event> all;
  for (const auto& [name, time] : events) all.push_back({ShortName(name), time});
  return {modes, std::move(all)};
}

void add_small_types(py::module_& m) {
  m.attr("infinity") = infinity;
  py::class_<Bounds>(m, "Bounds", "A closed interval. Equal sides make an equality constraint.")
      .def(py::init([](double lower, double upper) {
             return Bounds{lower, upper};
           }),
           "lower"_a = -infinity, "upper"_a = infinity)
      .def_readwrite("lower", &Bounds::lower, "-infinity if there is no lower bound.")
      .def_readwrite("upper", &Bounds::upper, "infinity if there is no upper bound.")
      .def("__eq__", [](const Bounds& a, const Bounds& b) { return a == b; })
      .def("__repr__",
           [](const Bounds& b) { return fmt::format("Bounds({}, {})", b.lower, b.upper); });
  m.def(
      "exactly", [](double value) { return exactly(value); }, "value"_a,
      "Bounds that allow only this value; for a sequence, one Bounds per row.");
  m.def(
      "exactly", [](const VectorXd& values) { return exactly(values); }, "values"_a);
  m.def("between", &between, "lower"_a, "upper"_a, "Bounds from lower to upper, both included.");
  m.def("at_least", &at_least, "lower"_a, "Lower bound only.");
  m.def("at_most", &at_most, "upper"_a, "Upper bound only.");
  m.def("unbounded", &unbounded, "No bounds.");

  py::enum_<Crossing>(m, "Crossing", "Direction in which a guard crosses zero.")
      .value("rising", Crossing::rising)
      .value("falling", Crossing::falling);
  py::enum_<CostRule>(m, "CostRule", "How running costs are accumulated over an interval.")
      .value("integrated", CostRule::integrated)
      .value("nodes", CostRule::nodes);
  py::enum_<InputParametrisation>(m, "InputParametrisation",
                                  "Shape of the inputs within an interval.")
      .value("piecewise_constant", InputParametrisation::piecewise_constant)
      .value("piecewise_linear", InputParametrisation::piecewise_linear)
      .value("piecewise_linear_continuous", InputParametrisation::piecewise_linear_continuous);
  py::enum_<Clock>(m, "Clock", "Origin of the seconds of a window.")
      .value("phase", Clock::phase)
      .value("absolute", Clock::absolute);

  py::class_<Instant>(m, "Instant", "A number of seconds or a named event of the schedule.")
      .def(py::init<double>(), "seconds"_a);
  m.def("event", &event, "name"_a, "The instant of the named event. It moves with the event.");
  py::class_<Window>(m, "Window",
                     "The half-open interval [start, end) in which a term acts; empty sides are "
                     "those of the phase. In C++ the sides are `from` and `to`.")
      .def(py::init([](const AnyInstant& from, const AnyInstant& to, Clock clock,
                       std::vector<std::string> modes) {
             return Window{instant_of(from), instant_of(to), clock, std::move(modes)};
           }),
           "from_"_a = py::none(), "to"_a = py::none(), "clock"_a = Clock::phase,
           "modes"_a = std::vector<std::string>{});
  m.def(
      "during",
      [](const py::args& modes) { return Window{.modes = modes.cast<std::vector<std::string>>()}; },
      "Window in which one of these modes is active.");

  py::class_<Penalty> penalty(m, "Penalty", "A penalty on the violation of a soft constraint.");
  py::enum_<Penalty::Kind>(penalty, "Kind")
      .value("L1", Penalty::L1)
      .value("L2", Penalty::L2)
      .value("Huber", Penalty::Huber)
      .export_values();
  m.def("soft", &soft, "name"_a, "weight"_a, "kind"_a = Penalty::L1,
        "A penalty with a name, so that its weight can be changed between solves.");
  m.def("huber", &huber, "name"_a, "weight"_a, "threshold"_a,
        "A Huber penalty: quadratic up to the threshold, linear above.");
  py::class_<Limits>(m, "Limits", "Bounds on every row; with a penalty, violations are charged.")
      .def(py::init([](const Rows& rows, std::optional<Penalty> charged) {
             Limits limits(list_of(rows));
             limits.soft = std::move(charged);
             return limits;
           }),
           "bounds"_a, "penalty"_a = py::none());
  py::class_<Reference>(m, "Reference", "Reference of a least-squares term: constant or samples.")
      .def(py::init<VectorXd>(), "value"_a)
      .def(py::init([](std::vector<double> times, const MatrixXd& values) {
             return Reference(std::move(times), values.transpose());
           }),
           "times"_a, "values"_a, "Samples at increasing times, one row of `values` per time.");
  py::class_<Guess>(m, "Guess", "Initial guess of a phase over the fraction of its duration.")
      .def_static("constant", &Guess::constant, "value"_a, "A constant value.")
      .def_static("interpolate", &Guess::interpolate, "first"_a, "last"_a, "A straight line.")
      .def_static("trajectory", &Guess::trajectory, "f"_a, "A function of the fraction, 0 to 1.")
      .def_static("simulate", &Guess::simulate, "For states only: integrates the dynamics.");

  py::class_<Schedule>(m, "Schedule", "Modes in order and the events between them.")
      .def(py::init(&make_schedule), "modes"_a, "events"_a,
           "Events are pairs of name and time in seconds.")
      .def("declare", &Schedule::declare, "modes"_a, py::return_value_policy::reference_internal)
      .def("reserve", &Schedule::reserve, "events"_a, py::return_value_policy::reference_internal)
      .def("insert", &Schedule::insert, "mode"_a, "event"_a, "time"_a)
      .def("erase", &Schedule::erase, "event"_a)
      .def("replace", &Schedule::replace, "event"_a, "mode"_a)
      .def("replace_first", &Schedule::replace_first, "mode"_a)
      .def("forget_until", &Schedule::forget_until, "t"_a)
      .def("retime", &Schedule::retime, "event"_a, "time"_a)
      .def("retime_from", &Schedule::retime_from, "event"_a, "time"_a)
      .def("confirm", &Schedule::confirm, "event"_a, "time"_a)
      .def("hold", &Schedule::hold, "event"_a, "now"_a, "lead"_a)
      .def("shift", &Schedule::shift, "elapsed"_a)
      .def("time_of", &Schedule::time_of, "event"_a)
      .def("mode_at", &Schedule::mode_at, "t"_a)
      .def("contains", &Schedule::contains, "event"_a)
      .def_property_readonly("events", [](const Schedule& s) {
        std::vector<std::pair<std::string, double>> all;
        for (const Event& event : s.events()) all.emplace_back(event.name.str(), event.time);
        return all;
      });
}

void add_phase(py::module_& m) {
  const auto same = py::return_value_policy::reference_internal;
  py::class_<Automaton>(m, "Automaton", "Modes and events inside a phase.")
      .def(py::init<int, int, int, int, const py::object&, const std::optional<VectorXd>&>(),
           "nx"_a, "nu"_a = 0, "np"_a = 0, "nz"_a = 0, "equations"_a = py::none(),
           "guess"_a = py::none())
      .def("mode", &Automaton::mode, "name"_a, "dynamics"_a, same, "Adds a mode.")
      .def("event", &Automaton::event, "name"_a, "from_"_a, "to"_a, "guard"_a, "crossing"_a,
           "reset"_a = py::none(), same, "Adds an event between two modes.")
      .def("surface", &Automaton::surface, "name"_a, "below"_a, "above"_a, "guard"_a, same,
           "Adds a switching surface.")
      .def("store_mode_in", &Automaton::store_mode_in, "i"_a, same,
           "Declares hysteresis: state i holds the index of the mode.");

  const Window whole;
  const std::optional<Penalty> hard;
  py::class_<Phase> phase(
      m, "Phase",
      "One continuous mode with nx states, nu inputs and np parameters. Formulas are callables of "
      "(t, x), (t, x, u) or (t, x, u, p), traced once. With nz algebraic states they take z after "
      "x. Every method returns the phase.");
  phase
      .def(py::init<const std::string&, const Automaton&, const Bounds&>(), "name"_a, "automaton"_a,
           "duration"_a)
      .def(py::init<const std::string&, const py::object&, const Bounds&, int, int, int, int,
                    const py::object&, const std::optional<VectorXd>&>(),
           "name"_a, "dynamics"_a, "duration"_a, "nx"_a, "nu"_a = 0, "np"_a = 0, "nz"_a = 0,
           "equations"_a = py::none(), "guess"_a = py::none(),
           "`dynamics` returns dx/dt. `duration` is in seconds; exactly(T) fixes it.")
      .def_property_readonly("name", [](const Phase& p) { return p.d.name; });
  // Every method changes the phase and returns it.
  const auto chained = [&phase, same](const char* name, auto change, auto&&... extra) {
    phase.def(name, change, std::forward<decltype(extra)>(extra)..., same);
  };
  chained(
      "switch_at",
      [](Phase& p, const std::string& event, const py::object& guard,
         const py::object& above) -> Phase& {
        Function crossing =
            p.formulas.erased("the guard of event", event, guard, 1, rule_of_guards);
        add_surface(p.d, event, std::move(crossing),
                    p.formulas.erased("the dynamics above event", event, above, p.d.sizes.nx,
                                      "the dynamics of switch_at() must return one row per state"));
        return p;
      },
      "event"_a, "guard"_a, "above"_a,
      "The dynamics are active where the guard is negative, `above` where it is positive.");
  chained(
      "on",
      [](Phase& p, const std::string& event, const py::object& guard, Crossing crossing,
         const py::object& reset) -> Phase& {
        Function zero = p.formulas.erased("the guard of event", event, guard, 1, rule_of_guards);
        add_reset(
            p.d, event, std::move(zero), crossing,
            p.formulas.erased("the reset of event", event, reset, p.d.sizes.nx, rule_of_resets));
        return p;
      },
      "event"_a, "guard"_a, "crossing"_a, "reset"_a,
      "Resets the state where the guard crosses zero. The phase continues.");
  for (const bool is_input : {true, false})
    chained(
        is_input ? "bound_input" : "bound_state",
        [is_input](Phase& p, int i, const Bounds& bounds, Window window,
                   std::optional<Penalty> penalty) -> Phase& {
          const Arguments& sizes = p.d.sizes;
          if (penalty)
            add_soft_bounds(p.d, is_input ? "input" : "state", is_input ? sizes.u() : sizes.x(),
                            is_input ? sizes.nu : sizes.nx, i, bounds, std::move(window),
                            std::move(*penalty));
          else
            add_bounds(is_input ? p.d.input_bounds : p.d.state_bounds, i, bounds,
                       std::move(window));
          return p;
        },
        "i"_a, "bounds"_a, "window"_a = whole, "penalty"_a = hard,
        is_input ? "Bounds input i in a window." : "Bounds state i in a window.");
  chained(
      "bound_algebraic",
      [](Phase& p, int i, const Bounds& bounds, Window window,
         std::optional<Penalty> penalty) -> Phase& {
        add_algebraic_bounds(p.d, i, bounds, std::move(window), std::move(penalty));
        return p;
      },
      "i"_a, "bounds"_a, "window"_a = whole, "penalty"_a = hard,
      "Bounds algebraic state i in a window.");
  chained(
      "keep",
      [](Phase& p, const std::string& name, const py::object& formula, const Rows& bounds,
         const Window& window, const std::optional<Penalty>& penalty) -> Phase& {
        p.constrain(Term::Domain::running, name, formula, bounds, window, penalty);
        return p;
      },
      "name"_a, "formula"_a, "bounds"_a, "window"_a = whole, "penalty"_a = hard,
      "Keeps the formula within bounds during the window.");
  chained(
      "allow",
      [](Phase& p, std::string term, double between_nodes, double at_nodes) -> Phase& {
        add_allowance(p.d, std::move(term), between_nodes, at_nodes);
        return p;
      },
      "term"_a, "between_nodes"_a, "at_nodes"_a = 0.0,
      "Sets tolerances of a path constraint in its units.");
  chained(
      "reach",
      [](Phase& p, const std::string& name, const py::object& formula, const Rows& bounds,
         const std::optional<Penalty>& penalty) -> Phase& {
        p.constrain(Term::Domain::phase_end, name, formula, bounds, {}, penalty);
        return p;
      },
      "name"_a, "formula"_a, "bounds"_a, "penalty"_a = hard,
      "Constraint at the end of the phase, before the jump.");
  chained(
      "begin_with",
      [](Phase& p, const std::string& name, const py::object& formula, const Rows& bounds,
         const std::optional<Penalty>& penalty) -> Phase& {
        p.constrain(Term::Domain::phase_start, name, formula, bounds, {}, penalty);
        return p;
      },
      "name"_a, "formula"_a, "bounds"_a, "penalty"_a = hard,
      "Constraint at the start of the phase, after the jump.");
  chained(
      "bound_integral",
      [](Phase& p, std::string name, const py::object& formula, const AnyLimits& limits,
         double magnitude) -> Phase& {
        Function function = p.formulas.erased(
            "integral", name, formula, 1, "the formula of bound_integral() must return a scalar");
        add_integral(p.d, std::move(name), std::move(function), limits_of(limits), magnitude);
        return p;
      },
      "name"_a, "formula"_a, "limits"_a, "magnitude"_a = 1.0,
      "Limits the integral of the scalar formula at the end of the phase.");
  chained(
      "ends_when",
      [](Phase& p, std::string event, const py::object& guard, Crossing crossing) -> Phase& {
        Function zero = p.formulas.erased("the guard of event", event, guard, 1, rule_of_guards);
        add_end_guard(p.d, std::move(event), std::move(zero), crossing);
        return p;
      },
      "event"_a, "guard"_a, "crossing"_a,
      "Ends the phase where the guard crosses zero in this direction.");
  chained(
      "minimise",
      [](Phase& p, const std::string& name, const py::object& formula,
         const Window& window) -> Phase& {
        p.minimise(Term::Domain::running, name, formula, window);
        return p;
      },
      "name"_a, "formula"_a, "window"_a = whole,
      "Adds the integral of the scalar formula over the window to the cost.");
  chained(
      "track",
      [](Phase& p, const std::string& name, const py::object& residual, const Numbers& weights,
         const Window& window, const AnyReference& reference) -> Phase& {
        p.track(Term::Domain::running, name, residual, weights, window, reference_of(reference));
        return p;
      },
      "name"_a, "residual"_a, "weights"_a, "window"_a = whole, "reference"_a = Reference(),
      "Adds the integral of 1/2 |residual - reference|^2_W, W = diag(weights). A number is the "
      "weight of every row.");
  for (const auto& [suffix, domain] :
       {std::pair{"_at_end", Term::Domain::phase_end}, {"_at_start", Term::Domain::phase_start}}) {
    const Term::Domain where = domain;
    chained((std::string("minimise") + suffix).c_str(),
            [where](Phase& p, const std::string& name, const py::object& formula) -> Phase& {
              p.minimise(where, name, formula, {});
              return p;
            },
            "name"_a, "formula"_a, "Adds the scalar formula at one end of the phase to the cost.");
    chained((std::string("track") + suffix).c_str(),
            [where](Phase& p, const std::string& name, const py::object& residual,
                    const Numbers& weights, const AnyReference& reference) -> Phase& {
              p.track(where, name, residual, weights, {}, reference_of(reference));
              return p;
            },
            "name"_a, "residual"_a, "weights"_a, "reference"_a = Reference(),
            "Adds 1/2 |residual - reference|^2_W at one end of the phase.");
  }
  chained(
      "penalise_change",
      [](Phase& p, const Numbers& weights) -> Phase& {
        p.d.input_change_weight = vector_of(weights, p.d.sizes.nu);
        return p;
      },
      "weights"_a, "Adds 1/2 |u_k - u_(k-1)|^2_W between neighbouring intervals.");
  chained(
      "inputs",
      [](Phase& p, InputParametrisation parametrisation) -> Phase& {
        p.d.input_parametrisation = parametrisation;
        return p;
      },
      "parametrisation"_a, "Shape of the inputs over an interval.");
  chained(
      "common_resultant",
      [](Phase& p, std::vector<int> firsts, int size) -> Phase& {
        p.d.resultants = std::move(firsts);
        p.d.resultant_size = size;
        return p;
      },
      "firsts"_a, "size"_a, "Groups of inputs act only through a common resultant.");
  chained(
      "data",
      [](Phase& p, std::string name, const Numbers& value) -> Phase& {
        add_parameter(p.d, std::move(name), vector_of(value), {});
        return p;
      },
      "name"_a, "value"_a, "Adds a block of data to p, in order of declaration.");
  chained(
      "unknown",
      [](Phase& p, std::string name, const Numbers& guess, const Bounds& bounds,
         double magnitude) -> Phase& {
        add_parameter(p.d, std::move(name), vector_of(guess), {});
        make_unknown(p.d, bounds, magnitude);
        return p;
      },
      "name"_a, "guess"_a, "bounds"_a, "magnitude"_a = 1.0,
      "Adds a parameter that the solver determines.");
  chained(
      "nominal",
      [](Phase& p, const Numbers& state, const Numbers& input) -> Phase& {
        p.d.nominal_state = vector_of(state, p.d.sizes.nx);
        p.d.nominal_input = vector_of(input, p.d.sizes.nu);
        p.d.has_nominal = true;
        return p;
      },
      "state"_a, "input"_a = 1.0, "Magnitudes that scale variables and defects.");
  chained(
      "nominal_duration",
      [](Phase& p, double seconds) -> Phase& {
        p.d.nominal_duration = seconds;
        p.d.has_nominal_duration = true;
        return p;
      },
      "seconds"_a, "Magnitude of a free duration.");
  chained(
      "guess_state",
      [](Phase& p, const AnyGuess& guess) -> Phase& {
        p.d.state_guess = guess_of(guess);
        return p;
      },
      "guess"_a, "Initial guess of the states; a vector is constant.");
  chained(
      "guess_input",
      [](Phase& p, const AnyGuess& guess) -> Phase& {
        p.d.input_guess = guess_of(guess);
        return p;
      },
      "guess"_a, "Initial guess of the inputs; a vector is constant.");
  chained(
      "guess_duration",
      [](Phase& p, double seconds) -> Phase& {
        p.d.duration_guess = seconds;
        return p;
      },
      "seconds"_a, "Initial guess of a free duration.");
}

void add_problem(py::module_& m) {
  const auto same = py::return_value_policy::reference_internal;
  py::class_<PendingJump>(m, "Jump", "A reset of the state between two phases.")
      .def(py::init<std::string, py::object>(), "name"_a, "formula"_a)
      .def_readonly("name", &PendingJump::name);
  m.def(
      "jump",
      [](std::string name, py::object formula) {
        return PendingJump{std::move(name), std::move(formula)};
      },
      "name"_a, "formula"_a,
      "x+ = formula(t, x-) or formula(t, x-, u, p) with an empty u, between two phases.");
  py::class_<End>(m, "PhaseEnd", "One end of a phase, for links.");
  for (const bool is_end : {false, true})
    m.def(
        is_end ? "end_of" : "start_of",
        [is_end](const Phase& p) {
          return End{p.d.name, is_end, p.d.sizes.nx, p.d.sizes.np};
        },
        "phase"_a, is_end ? "The end of a phase." : "The start of a phase.");

  py::class_<Problem> problem(m, "OptimalControlProblem",
                              "Hybrid optimal control problem: one or more phases in order.");
  const auto chained = [&problem, same](const char* name, auto change, auto&&... extra) {
    problem.def(name, change, std::forward<decltype(extra)>(extra)..., same);
  };
  problem.def(py::init<std::string>(), "name"_a = "problem");
  problem.def("__copy__", [](const Problem& p) { return Problem(p); });
  problem.def_property_readonly("name", &Problem::name);
  chained(
      "start_at", [](Problem& p, const VectorXd& state) -> Problem& { return p.start_at(state); },
      "state"_a, "Fixes the state at the start.");
  chained(
      "start_within",
      [](Problem& p, std::vector<Bounds> bounds, VectorXd guess) -> Problem& {
        return p.start_within(std::move(bounds), std::move(guess));
      },
      "bounds"_a, "guess"_a, "Frees the state at the start within bounds.");
  chained(
      "start_time",
      [](Problem& p, const std::variant<double, Bounds>& t, double guess) -> Problem& {
        if (const double* fixed = std::get_if<double>(&t)) return p.start_time(*fixed);
        return p.start_time(std::get<Bounds>(t), guess);
      },
      "t"_a, "guess"_a = 0.0, "Fixes the absolute start time, or frees it within bounds.");
  chained(
      "then",
      [](Problem& p, const Phase& phase, const PendingJump* jump) -> Problem& {
        if (jump == nullptr) return p.then(phase.d);
        if (p.phases().empty())
          throw DefinitionError(fmt::format("jump '{}': there is no phase before it", jump->name));
        return p.then(phase.d, jump->after(p.phases().back()));
      },
      "phase"_a, "jump"_a = py::none(),
      "Appends a copy of the phase, entered through the jump. Later changes have no effect.");
  chained(
      "close",
      [](Problem& p, const PendingJump* jump) -> Problem& {
        if (jump == nullptr) return p.close();
        if (p.phases().empty())
          throw DefinitionError(fmt::format("jump '{}': there is no phase before it", jump->name));
        return p.close(jump->after(p.phases().back()));
      },
      "jump"_a = py::none(), "Makes the problem periodic.");
  chained(
      "link",
      [](Problem& p, const std::string& name, const py::object& formula, const AnyLimits& limits,
         const py::args& ends) -> Problem& {
        return p.link(link_of(name, formula, limits_of(limits), ends));
      },
      "name"_a, "formula"_a, "limits"_a,
      "Constrains a formula of ends of phases, which have t, duration, x and p.");
  chained(
      "track_link",
      [](Problem& p, const std::string& name, const py::object& formula, double weight,
         const py::args& ends) -> Problem& {
        return p.link(
            link_of(name, formula, Limits(exactly(0.0), soft(name, weight, Penalty::L2)), ends));
      },
      "name"_a, "formula"_a, "weight"_a, "Adds weight/2 |formula|^2 to the cost.");
  chained(
      "minimise_link",
      [](Problem& p, const std::string& name, const py::object& formula,
         const py::args& ends) -> Problem& {
        Link cost = link_of(name, formula, Limits(), ends);
        cost.is_cost = true;
        return p.link(std::move(cost));
      },
      "name"_a, "formula"_a, "Adds a scalar formula of ends of phases to the cost.");
  chained(
      "schedule",
      [](Problem& p, const Schedule& schedule) -> Problem& { return p.schedule(schedule); },
      "schedule"_a, "Sets the events and modes to which windows refer by name.");
  chained(
      "costs", [](Problem& p, CostRule rule) -> Problem& { return p.costs(rule); }, "rule"_a,
      "Sets the rule for running costs.");
  chained(
      "total_time",
      [](Problem& p, const Bounds& bounds) -> Problem& { return p.total_time(bounds); }, "bounds"_a,
      "Bounds the sum of all durations.");
  problem.def("after", &Problem::after, "phases"_a, "The problem without its first phases.")
      .def("set_penalty_weight", &Problem::set_penalty_weight, "weight_name"_a, "weight"_a,
           "Sets every penalty weight of this name.")
      .def("editable_schedule", &Problem::editable_schedule, same, "The schedule, to move events.")
      .def("validate", &Problem::check, "Checks every size; raises DefinitionError.")
      .def("warnings", &Problem::warnings, "Valid definitions that look like mistakes.")
      .def_property_readonly(
          "phases",
          [](const Problem& p) {
            std::vector<std::string> names;
            for (const PhaseDefinition& phase : p.phases()) names.push_back(phase.name);
            return names;
          },
          "Names of the phases.")
      .def("__repr__", [](const Problem& p) {
        return fmt::format("<OptimalControlProblem '{}' with {} phases>", p.name(),
                           p.phases().size());
      });
}

}  // namespace

void add_definitions(py::module_& m) {
  add_small_types(m);
  add_phase(m);
  add_problem(m);
}

}  // namespace saltus::python
