// Several starts of one problem, and searches over sequences of modes.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

#include "definitions.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus::python {
namespace {

using Release = py::gil_scoped_release;

std::vector<Guess> guesses_of(py::handle list) {
  std::vector<Guess> all;
  for (const AnyGuess& guess : list.cast<std::vector<AnyGuess>>()) all.push_back(guess_of(guess));
  return all;
}

// Solvers that a Python callable makes, one for each thread.
class Factory {
 public:
  explicit Factory(std::function<std::shared_ptr<Solver>()> make) : make_(std::move(make)) {}

  std::unique_ptr<Solver> operator()() {
    auto solver = make_();
    if (!solver) throw DefinitionError("solve_from: make_solver returned no solver");
    const std::scoped_lock lock(*mutex_);
    if (std::find(made_.begin(), made_.end(), solver) != made_.end())
      throw DefinitionError(
          "solve_from: make_solver returned the same solver twice; it must make a new one for "
          "every start");
    made_.push_back(solver);
    return std::make_unique<SharedSolver>(std::move(solver));
  }

 private:
  std::function<std::shared_ptr<Solver>()> make_;
  std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();
  std::vector<std::shared_ptr<Solver>> made_;
};

// Ctrl-C ends all solves of a call, on all threads. The calling thread checks for it.
class Interrupt {
 public:
  bool is_requested() {
    if (!is_requested_ && std::this_thread::get_id() == caller_) {
      py::gil_scoped_acquire hold;
      if (PyErr_CheckSignals() != 0) is_requested_ = true;
    }
    return is_requested_;
  }
  /// Raises the exception of the signal. Call it with the lock of the interpreter.
  void rethrow() const {
    if (is_requested_) throw py::error_already_set();
  }

 private:
  std::thread::id caller_ = std::this_thread::get_id();
  std::atomic<bool> is_requested_ = false;
};

void add_several_starts(py::module_& m) {
  py::class_<SeveralSolutions> several(m, "SeveralSolutions", "Result of solve_from().");
  several.def_readonly("optima", &SeveralSolutions::optima, "Distinct optima, lowest cost first.")
      .def_readonly("optimum_of", &SeveralSolutions::optimum_of,
                    "Per start: index in `optima`, or -1.")
      .def_readonly("failed", &SeveralSolutions::failed, "Results of the other starts, in order.")
      .def("ok", &SeveralSolutions::ok, "True if any start led to an optimum.")
      .def("__bool__", &SeveralSolutions::ok);
  using Start = SeveralSolutions::Start;
  Struct<Start>(several, "Start",
                "One start. Empty fields use the guess of the problem. Fields: durations, states, "
                "inputs (one entry per phase), trajectory.")
      .field("durations", &Start::durations)
      .field("states", [](Start& s, py::handle to) { s.states = guesses_of(to); })
      .field("inputs", [](Start& s, py::handle to) { s.inputs = guesses_of(to); })
      .field("trajectory", &Start::trajectory)
      .from_keywords();
  using Options = SeveralSolutions::Options;
  Struct<Options>(several, "Options", "Options of solve_from().")
      .field("intervals_per_phase", &Options::intervals_per_phase)
      .field("intervals", &Options::intervals)
      .field("integrator",
             [](Options& o, py::handle to) {
               o.integrator = to.is_none() ? IntegratorChoice() : to.cast<Integrator>().choice;
             })
      .field("make_solver",
             [](Options& o, py::handle to) {
               o.make_solver = Factory(to.cast<std::function<std::shared_ptr<Solver>()>>());
             })
      .field("threads", &Options::threads)
      .field("same_point", &Options::same_point)
      .field("same_cost", &Options::same_cost)
      .from_keywords();
  m.def(
      "solve_from",
      [](const OptimalControlProblem& problem,
         const std::vector<std::variant<Start, py::dict>>& starts, const py::kwargs& keywords) {
        Options options;
        set_fields(keywords, options);
        std::vector<Start> all;
        for (const auto& start : starts) {
          if (const Start* given = std::get_if<Start>(&start)) {
            all.push_back(*given);
            continue;
          }
          all.emplace_back();
          set_fields(py::kwargs(std::get<py::dict>(start)), all.back());
        }
        Interrupt interrupt;
        options.make_solver = [&interrupt, make = std::move(options.make_solver)] {
          std::unique_ptr<Solver> solver = make ? make() : make_native_solver();
          solver->set_observer({.should_stop = [&interrupt] { return interrupt.is_requested(); }});
          return solver;
        };
        SeveralSolutions found = [&] {
          Release release;
          return solve_from(problem, all, options);
        }();
        interrupt.rethrow();
        return found;
      },
      "problem"_a, "starts"_a,
      "Solves from several starts, in parallel, and returns the distinct optima. A start is a "
      "SeveralSolutions.Start or a dict of its fields. Options: intervals_per_phase = 30, "
      "intervals, integrator, make_solver (a callable that returns a new solver), threads, "
      "same_point, same_cost.");
}

void add_schedules(py::module_& m) {
  py::class_<JointSchedule>(m, "JointSchedule",
                            "Several schedules that run at the same time, such as one per leg.")
      .def(py::init<std::vector<Schedule>, int>(), "parts"_a, "capacity"_a,
           "`capacity` is the maximum number of events of the joint schedule.")
      .def_property_readonly("parts", &JointSchedule::parts, "Number of parts.")
      .def("part", py::overload_cast<int>(&JointSchedule::part), "i"_a,
           py::return_value_policy::reference_internal, "The schedule of part i, for editing.")
      .def("during", &JointSchedule::during, "i"_a, "mode"_a,
           "Window in which part i is in this mode, for any modes of the other parts.")
      .def(
          "join",
          [](JointSchedule& s, double from, double to) { return Schedule(s.join(from, to)); },
          "from_"_a, "to"_a, "The joint schedule of (from_, to].")
      .def(
          "joined", [](const JointSchedule& s) { return Schedule(s.joined()); },
          "The result of the last join().");
}

// A ModeGraph that takes the sizes of formulas from its modes.
struct Graph {
  ModeGraph graph;

  int states(const std::string& mode, const std::string& where) const {
    for (int i = 0; i < graph.size(); ++i)
      if (graph.mode(i).name == mode) return graph.mode(i).sizes.nx;
    throw DefinitionError(
        fmt::format("{}: add mode '{}' before it, which gives the number of states", where, mode));
  }
  Jump jump(const PendingJump* jump, const std::string& from) const {
    if (jump == nullptr) return {};
    states(from, fmt::format("jump '{}'", jump->name));
    return jump->after(graph.mode(graph.number_of(from)));
  }
  Function of_end(const std::string& name, const py::object& formula, const char* rule) const {
    const std::string where = fmt::format("term '{}'", name);
    if (graph.size() == 0)
      throw DefinitionError(where + ": add the modes before it, which give the number of states");
    const int nx = graph.mode(0).sizes.nx;
    Function function = function_of(formula, {nx, 0, 0, 0}, where);
    require_rows(function, 1, where, rule);
    detail::checked_function(function, {nx, 0, 0}, {{}, where});
    return function;
  }
};

void add_graph(py::module_& m) {
  py::class_<Graph> graph(m, "ModeGraph",
                          "A problem with a free sequence of modes: modes, allowed transitions and "
                          "conditions at the end. Every method returns the graph.");
  graph
      .def(py::init([](const std::string& name) { return Graph{ModeGraph(name)}; }),
           "name"_a = "modes")
      .def_property_readonly("name", [](const Graph& g) { return g.graph.name(); })
      .def("__len__", [](const Graph& g) { return g.graph.size(); })
      .def(
          "validate", [](const Graph& g, bool limited_phases) { g.graph.check(limited_phases); },
          "limited_phases"_a = true, "Checks the graph; raises DefinitionError.")
      .def(
          "problem",
          [](const Graph& g, const std::vector<std::string>& sequence) {
            std::vector<int> path;
            for (const std::string& mode : sequence) path.push_back(g.graph.number_of(mode));
            return g.graph.problem(path);
          },
          "sequence"_a, "The problem of this sequence of modes.");
  // Every method changes the graph and returns it.
  const auto chained = [&graph](const char* name, auto change, auto&&... extra) {
    graph.def(name, change, std::forward<decltype(extra)>(extra)...,
              py::return_value_policy::reference_internal);
  };
  chained(
      "mode",
      [](Graph& g, const Phase& phase) -> Graph& {
        g.graph.mode(ErasedPhase(phase.d));
        return g;
      },
      "phase"_a, "Appends a mode: a copy of the phase.");
  chained(
      "transition",
      [](Graph& g, const std::string& from, const std::string& to,
         const PendingJump* jump) -> Graph& {
        g.graph.transition(from, to, g.jump(jump, from));
        return g;
      },
      "from_"_a, "to"_a, "jump"_a = py::none(), "Allows `to` after `from_`.");
  chained(
      "transition_when",
      [](Graph& g, const std::string& from, const std::string& to, const std::string& event,
         const py::object& guard, Crossing crossing, const PendingJump* jump) -> Graph& {
        const std::string where = fmt::format("phase '{}', the guard of event '{}'", from, event);
        const int nx = g.states(from, where);
        Function zero = function_of(guard, {nx, 0, 0, 0}, where);
        require_rows(zero, 1, where, rule_of_guards);
        detail::checked_function(zero, {nx, 0, 0}, {{}, where});
        g.graph.transition_when(from, to, event, std::move(zero), crossing, g.jump(jump, from));
        return g;
      },
      "from_"_a, "to"_a, "event"_a, "guard"_a, "crossing"_a, "jump"_a = py::none(),
      "Allows `to` after `from_` where the guard of (t, x) crosses zero.");
  chained(
      "all_transitions",
      [](Graph& g) -> Graph& {
        g.graph.all_transitions();
        return g;
      },
      "Allows all transitions without a jump, including each mode to itself.");
  chained(
      "no_transition",
      [](Graph& g, const std::string& from, const std::string& to) -> Graph& {
        g.graph.no_transition(from, to);
        return g;
      },
      "from_"_a, "to"_a, "Excludes a transition.");
  chained(
      "begin_in",
      [](Graph& g, const std::vector<std::string>& modes) -> Graph& {
        g.graph.begin_in(modes);
        return g;
      },
      "modes"_a, "Modes that may be the first one.");
  chained(
      "end_in",
      [](Graph& g, const std::vector<std::string>& modes) -> Graph& {
        g.graph.end_in(modes);
        return g;
      },
      "modes"_a, "Modes that may be the last one.");
  chained(
      "dwell",
      [](Graph& g, const std::string& mode, int phases) -> Graph& {
        g.graph.dwell(mode, phases);
        return g;
      },
      "mode"_a, "phases"_a, "Minimum number of phases of the mode after each entry.");
  chained(
      "enter_at_most",
      [](Graph& g, const std::string& mode, int times) -> Graph& {
        g.graph.enter_at_most(mode, times);
        return g;
      },
      "mode"_a, "times"_a, "Maximum number of entries into the mode.");
  chained(
      "start_at",
      [](Graph& g, const VectorXd& state) -> Graph& {
        g.graph.start_at(state);
        return g;
      },
      "state"_a, "Fixes the state at the start.");
  chained(
      "start_time",
      [](Graph& g, double t) -> Graph& {
        g.graph.start_time(t);
        return g;
      },
      "t"_a, "Sets the absolute start time, s.");
  chained(
      "total_time",
      [](Graph& g, const Bounds& bounds) -> Graph& {
        g.graph.total_time(bounds);
        return g;
      },
      "bounds"_a, "Bounds the sum of all durations, s.");
  chained(
      "costs",
      [](Graph& g, CostRule rule) -> Graph& {
        g.graph.costs(rule);
        return g;
      },
      "rule"_a, "Sets the rule for running costs of all modes.");
  chained(
      "minimise_at_end",
      [](Graph& g, const std::string& name, const py::object& formula) -> Graph& {
        g.graph.minimise_at_end(name, g.of_end(name, formula, "a cost must return a scalar"));
        return g;
      },
      "name"_a, "formula"_a, "Adds a cost of (t, x) at the end of the last mode.");
  chained(
      "reach_at_end",
      [](Graph& g, const std::string& name, const py::object& formula,
         const Bounds& bounds) -> Graph& {
        g.graph.reach_at_end(
            name, g.of_end(name, formula, "the formula of reach_at_end() must return a scalar"),
            bounds);
        return g;
      },
      "name"_a, "formula"_a, "bounds"_a,
      "Adds a constraint of (t, x) at the end of the last mode.");
}

void add_search(py::module_& m) {
  using Options = SearchOptions;
  Struct<Options>(m, "SearchOptions", "Options of search().")
      .field("phases", &Options::phases)
      .field("at_most", &Options::at_most)
      .field("gap", &Options::gap)
      .field("least_cost", &Options::least_cost)
      .field("deadline", &Options::deadline)
      .field("max_nodes", &Options::max_nodes)
      .field("tolerance", &Options::tolerance)
      .field("warm", &Options::warm)
      .field("confirm", &Options::confirm)
      .field("intervals_per_phase", &Options::intervals_per_phase)
      .field("integrator",
             [](Options& o, py::handle to) {
               o.integrator = to.is_none() ? IntegratorChoice() : to.cast<Integrator>().choice;
             })
      .field("costs_are_nonnegative", &Options::costs_are_nonnegative)
      .from_keywords();
  using Result = SequenceResult;
  using Guarantee = Result::Guarantee;
  py::class_<Result> result(m, "SequenceResult", "Result of a search over sequences of modes.");
  py::enum_<Guarantee>(result, "Guarantee", "Guarantee for the best sequence.")
      .value("optimal", Guarantee::optimal)
      .value("bounded", Guarantee::bounded)
      .value("enumerated", Guarantee::enumerated)
      .value("incomplete", Guarantee::incomplete)
      .value("infeasible", Guarantee::infeasible)
      .value("inconclusive", Guarantee::inconclusive)
      .value("contradicted", Guarantee::contradicted);
  result.def_readonly("guarantee", &Result::guarantee)
      .def_readonly("sequence", &Result::sequence, "Names of the modes; empty: none was found.")
      .def_readonly("modes", &Result::modes, "Indices of the modes.")
      .def_readonly("cost", &Result::cost)
      .def_readonly("lower_bound", &Result::lower_bound,
                    "No allowed sequence costs less; convex problems only.")
      .def_readonly("least_cost", &Result::least_cost)
      .def_readonly("message", &Result::message, "One sentence.")
      .def_readonly("solution", &Result::solution, "Plan of the sequence.")
      .def_readonly("states", &Result::states)
      .def_readonly("inputs", &Result::inputs)
      .def_readonly("nodes", &Result::nodes, "Number of programs solved.")
      .def_readonly("infeasible", &Result::infeasible)
      .def_readonly("unresolved", &Result::unresolved)
      .def_readonly("reused", &Result::reused)
      .def_readonly("iterations", &Result::iterations)
      .def_readonly("seconds", &Result::seconds)
      .def_readonly("cpu_seconds", &Result::cpu_seconds)
      .def_readonly("solver_seconds", &Result::solver_seconds)
      .def("found", &Result::found, "True if a sequence was found.")
      .def("gap", &Result::gap, "Gap relative to the cost.")
      .def("__bool__", &Result::found)
      .def("__repr__", [](const Result& r) { return "<SequenceResult: " + r.message + ">"; });
  m.def(
      "describe", [](Guarantee g) { return describe(g); }, "guarantee"_a,
      "Describes the guarantee in one sentence.");
  m.def(
      "search",
      [](const Graph& graph, const py::kwargs& keywords) {
        Options options;
        set_fields(keywords, options);
        Release release;
        return search(graph.graph, options);
      },
      "graph"_a,
      "Finds the best sequence of modes with its times. Set phases, or at_most for modes of free "
      "duration. Options: those of SearchOptions.");
}

}  // namespace

void add_searches(py::module_& m) {
  add_several_starts(m);
  add_schedules(m);
  add_graph(m);
  add_search(m);
}

}  // namespace saltus::python
