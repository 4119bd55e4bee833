// Options, integrators, solvers and results of solves.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>

#include "core.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/simulation/loop_log.hpp"
#include "saltus/solve/check.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/solve.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/between_nodes.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#ifdef SALTUS_PYTHON_SUNDIALS
#include "saltus/integrators/sundials.hpp"
#endif
#ifdef SALTUS_PYTHON_IPOPT
#include "saltus/solver/ipopt.hpp"
#endif

namespace saltus::python {
namespace {

using Release = py::gil_scoped_release;

// Ctrl-C ends a solve with KeyboardInterrupt.
class Interruptible {
 public:
  explicit Interruptible(SolveObserver observer) : observer_(std::move(observer)) {}
  SolveObserver observer() {
    SolveObserver watched = observer_;
    watched.should_stop = [this] {
      py::gil_scoped_acquire hold;
      if (interrupted_ || PyErr_CheckSignals() != 0) return interrupted_ = true;
      return observer_.wants_stop();
    };
    return watched;
  }
  /// Raises the exception of the signal. Call it with the lock of the interpreter.
  void rethrow() const {
    if (interrupted_) throw py::error_already_set();
  }

 private:
  SolveObserver observer_;
  bool interrupted_ = false;
};

template <class Run>
auto released(SolveObserver observer, const Run& run) {
  Interruptible watch(std::move(observer));
  const SolveObserver watched = watch.observer();
  auto result = [&] {
    Release release;
    return run(watched);
  }();
  watch.rethrow();
  return result;
}

// The problem of a plan as arrays: one row per sample, NaN where a phase has no such column.
py::dict samples_of(const Trajectory& trajectory, int samples_per_interval) {
  int nx = 0, nu = 0, nz = 0;
  for (const Trajectory::PhaseInfo& phase : trajectory.phases()) {
    const IntervalProblem& problem = phase.integrator->problem();
    nx = std::max(nx, problem.arguments.nx);
    nu = std::max(nu, problem.arguments.nu);
    if (problem.algebraic) nz = std::max(nz, problem.algebraic.equations->count());
  }
  const int samples = std::max(1, samples_per_interval);
  const auto& pieces = trajectory.pieces();
  std::vector<double> times;
  std::vector<int> phases;
  std::vector<VectorXd> rows;
  {
    Release release;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const Trajectory::Piece& piece = pieces[k];
      const bool closes = k + 1 == pieces.size() || pieces[k + 1].phase != piece.phase;
      for (int s = 0; s < samples + (closes ? 1 : 0); ++s) {
        const double t = s == samples ? piece.end() : piece.start + piece.length * s / samples;
        VectorXd row = VectorXd::Constant(nx + nu + nz, std::numeric_limits<double>::quiet_NaN());
        const VectorXd x = trajectory.state_in(piece, t), u = trajectory.input_in(piece, t);
        row.head(x.size()) = x;
        row.segment(nx, u.size()) = u;
        if (nz > 0) {
          const VectorXd z = trajectory.algebraic(t);
          row.segment(nx + nu, z.size()) = z;
        }
        times.push_back(t);
        phases.push_back(piece.phase);
        rows.push_back(std::move(row));
      }
    }
  }
  const auto block = [&](int first, int count) {
    py::array_t<double> all({rows.size(), static_cast<std::size_t>(count)});
    auto entries = all.mutable_unchecked<2>();
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (int j = 0; j < count; ++j) entries(static_cast<py::ssize_t>(i), j) = rows[i][first + j];
    return all;
  };
  py::dict table;
  table["t"] = py::array_t<double>(static_cast<py::ssize_t>(times.size()), times.data());
  table["phase"] = py::array_t<int>(static_cast<py::ssize_t>(phases.size()), phases.data());
  table["x"] = block(0, nx);
  table["u"] = block(nx, nu);
  if (nz > 0) table["z"] = block(nx + nu, nz);
  return table;
}

// One row per time.
template <class Value>
py::array_t<double> at_times(const VectorXd& times, const Value& value) {
  std::vector<VectorXd> rows;
  {
    Release release;
    for (const double t : times) rows.push_back(value(t));
  }
  Eigen::Index columns = 0;
  for (const VectorXd& row : rows) columns = std::max(columns, row.size());
  py::array_t<double> all({times.size(), columns});
  auto entries = all.mutable_unchecked<2>();
  for (Eigen::Index i = 0; i < times.size(); ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      entries(i, j) = j < rows[i].size() ? rows[i][j] : std::numeric_limits<double>::quiet_NaN();
  return all;
}

// A value at a number, or one row per entry of an array.
template <class Value>
py::object at(const Numbers& t, const Value& value) {
  if (const double* time = std::get_if<double>(&t)) return py::cast(VectorXd(value(*time)));
  return at_times(std::get<VectorXd>(t), value);
}

void add_options(py::module_& m) {
  Struct<SolveObserver> observer(m, "SolveObserver", "Callbacks of a solve.");
  py::class_<SolveObserver::Iteration>(observer, "Iteration", "State of a solve.")
      .def_readonly("number", &SolveObserver::Iteration::number)
      .def_readonly("is_restoring", &SolveObserver::Iteration::is_restoring)
      .def_readonly("cost", &SolveObserver::Iteration::cost)
      .def_readonly("violation", &SolveObserver::Iteration::violation)
      .def_readonly("stationarity", &SolveObserver::Iteration::stationarity)
      .def_readonly("barrier", &SolveObserver::Iteration::barrier)
      .def_readonly("step", &SolveObserver::Iteration::step)
      .def_readonly("regularisation", &SolveObserver::Iteration::regularisation)
      .def_readonly("step_length", &SolveObserver::Iteration::step_length);
  observer.field("report", &SolveObserver::report)
      .field("should_stop", &SolveObserver::should_stop);
  observer.from_keywords();

  py::enum_<Curvature>(m, "Curvature", "Terms included in a Hessian.")
      .value("exact", Curvature::exact)
      .value("gauss_newton", Curvature::gauss_newton);
  Struct<GridAccuracy>(m, "GridAccuracy", "Required accuracy of a plan.")
      .field("verify", &GridAccuracy::verify)
      .field("rows", &GridAccuracy::rows)
      .field("between_nodes", &GridAccuracy::between_nodes)
      .field("defect", &GridAccuracy::defect)
      .field("integration", &GridAccuracy::integration)
      .field("cost", &GridAccuracy::cost)
      .field("open_loop", &GridAccuracy::open_loop)
      .field("crossing", &GridAccuracy::crossing)
      .from_keywords();
  py::class_<Mesh>(m, "Mesh", "Division of a phase into intervals.")
      .def(py::init([](int intervals, std::vector<double> nodes) {
             return Mesh{intervals, std::move(nodes), {}};
           }),
           "intervals"_a = 30, "nodes"_a = std::vector<double>{})
      .def_readonly("intervals", &Mesh::intervals)
      .def_readonly("nodes", &Mesh::nodes);
  m.def("graded_mesh", &graded_mesh, "intervals"_a, "ratio"_a,
        "Intervals whose lengths grow geometrically.");
  m.def("mesh_graded_to_both_ends", &mesh_graded_to_both_ends, "intervals"_a, "ratio"_a,
        "Short intervals at both ends.");
  const auto integrator = [](auto& options, py::handle to) {
    options.integrator = to.is_none() ? IntegratorChoice() : to.cast<Integrator>().choice;
  };
  Struct<ShootingOptions>(m, "ShootingOptions", "Options of the transcription.")
      .field("intervals_per_phase", &ShootingOptions::intervals_per_phase)
      .field("intervals", &ShootingOptions::intervals)
      .field("meshes", &ShootingOptions::meshes)
      .field("integrator", [=](ShootingOptions& o, py::handle to) { integrator(o, to); })
      .field("accuracy", &ShootingOptions::accuracy)
      .field("threads", &ShootingOptions::threads)
      .field("automatic_scale", &ShootingOptions::automatic_scale)
      .from_keywords();
  Struct<SolveOptions>(m, "SolveOptions", "Options of solve().")
      .field("intervals_per_phase", &SolveOptions::intervals_per_phase)
      .field("intervals", &SolveOptions::intervals)
      .field("integrator", [=](SolveOptions& o, py::handle to) { integrator(o, to); })
      .field("threads", &SolveOptions::threads)
      .field("solver", &SolveOptions::solver)
      .field("guess", &SolveOptions::guess)
      .field("observer", &SolveOptions::observer)
      .from_keywords();
  Struct<RefinementOptions>(m, "RefinementOptions", "Options of solve_refined().")
      .field("tolerance", &RefinementOptions::tolerance)
      .field("integration", &RefinementOptions::integration)
      .field("hold_inputs", &RefinementOptions::hold_inputs)
      .field("rounds", &RefinementOptions::rounds)
      .field("most_intervals", &RefinementOptions::most_intervals)
      .from_keywords();
  Struct<ExplainOptions>(m, "ExplainOptions", "Options of explain().")
      .field("remedies", &ExplainOptions::remedies)
      .field("time_limit", &ExplainOptions::time_limit)
      .field("guess", &ExplainOptions::guess)
      .field("soft_terms", &ExplainOptions::soft_terms)
      .from_keywords();
}

// def_choice<Options>(m, "runge_kutta4", make): an integrator made from keywords.
template <class Options, class Make>
void add_integrator(py::module_& m, const char* name, Make make, const char* doc) {
  m.def(
      name,
      [make](const py::kwargs& keywords) {
        Options options;
        set_fields(keywords, options);
        return Integrator{make(options)};
      },
      doc);
}

void add_integrators(py::module_& m) {
  py::class_<Integrator>(m, "Integrator", "A numerical integrator of the dynamics.")
      .def("__repr__", [](const Integrator& i) { return "<" + i.choice->name() + ">"; });
  Struct<RungeKuttaOptions>(m, "RungeKuttaOptions", "Options of explicit methods.")
      .field("steps", &RungeKuttaOptions::steps)
      .from_keywords();
  Struct<ImplicitRungeKuttaOptions>(m, "ImplicitRungeKuttaOptions", "Options of implicit methods.")
      .field("stages", &ImplicitRungeKuttaOptions::stages)
      .field("steps", &ImplicitRungeKuttaOptions::steps)
      .from_keywords();
  Struct<ImplicitMidpointOptions>(m, "ImplicitMidpointOptions", "Options of implicit_midpoint().")
      .field("steps", &ImplicitMidpointOptions::steps)
      .from_keywords();
  add_integrator<RungeKuttaOptions>(m, "runge_kutta4", &runge_kutta4,
                                    "The classical method of order 4. Option: steps.");
  add_integrator<RungeKuttaOptions>(m, "runge_kutta8", &runge_kutta8,
                                    "A method of order 8. Option: steps.");
  add_integrator<ImplicitRungeKuttaOptions>(m, "gauss_legendre", &gauss_legendre,
                                            "Gauss-Legendre collocation. Options: stages, steps.");
  add_integrator<ImplicitRungeKuttaOptions>(m, "radau_iia", &radau_iia,
                                            "Radau IIA collocation. Options: stages, steps.");
  add_integrator<ImplicitMidpointOptions>(m, "implicit_midpoint", &implicit_midpoint,
                                          "The implicit midpoint rule. Option: steps.");
  m.def(
      "zero_order_hold", [] { return Integrator{zero_order_hold()}; },
      "Exact for dynamics that are affine in state and input.");
#ifdef SALTUS_PYTHON_SUNDIALS
  Struct<CvodesOptions>(m, "CvodesOptions", "Options of cvodes().")
      .field("tolerance", &CvodesOptions::tolerance)
      .field("absolute_tolerance", &CvodesOptions::absolute_tolerance)
      .field("max_steps", &CvodesOptions::max_steps)
      .from_keywords();
  Struct<ArkodeOptions>(m, "ArkodeOptions", "Options of arkode().")
      .field("order", &ArkodeOptions::order)
      .field("tolerance", &ArkodeOptions::tolerance)
      .field("absolute_tolerance", &ArkodeOptions::absolute_tolerance)
      .field("fixed_steps", &ArkodeOptions::fixed_steps)
      .field("max_steps", &ArkodeOptions::max_steps)
      .from_keywords();
  Struct<IdasOptions>(m, "IdasOptions", "Options of idas().")
      .field("tolerance", &IdasOptions::tolerance)
      .field("absolute_tolerance", &IdasOptions::absolute_tolerance)
      .field("max_steps", &IdasOptions::max_steps)
      .from_keywords();
  add_integrator<CvodesOptions>(m, "cvodes", &cvodes,
                                "CVODES of SUNDIALS. Options: tolerance, absolute_tolerance, "
                                "max_steps.");
  add_integrator<ArkodeOptions>(m, "arkode", &arkode,
                                "ARKODE of SUNDIALS. Options: order, tolerance, "
                                "absolute_tolerance, fixed_steps, max_steps.");
  add_integrator<IdasOptions>(m, "idas", &idas,
                              "IDAS of SUNDIALS. Options: tolerance, absolute_tolerance, "
                              "max_steps.");
#endif
}

void add_solvers(py::module_& m) {
  py::class_<Solver, std::shared_ptr<Solver>>(m, "Solver", "A solver of nonlinear programs.")
      .def_property_readonly("name", &Solver::name)
      .def_property_readonly("tolerance", &Solver::tolerance);
  const auto algebra = [](NativeSolverOptions& options, py::handle to) {
    const auto name = to.cast<std::string>();
    if (name != "sparse" && name != "riccati")
      throw DefinitionError("there is no linear algebra '" + name +
                            "'; the choices are 'sparse' and 'riccati'");
    options.qp = name == "sparse" ? sparse_qp() : riccati_qp();
  };
  Struct<NativeSolverOptions>(m, "NativeSolverOptions", "Options of the native solver.")
      .field("tolerance", &NativeSolverOptions::tolerance)
      .field("max_iterations", &NativeSolverOptions::max_iterations)
      .field("time_limit", &NativeSolverOptions::time_limit)
      .field("curvature", &NativeSolverOptions::curvature)
      .field("convexity_floor", &NativeSolverOptions::convexity_floor)
      .field("initial_trust_radius", &NativeSolverOptions::initial_trust_radius)
      .field("qp", algebra)
      .from_keywords();
  m.def(
      "make_native_solver",
      [](const py::kwargs& keywords) -> std::shared_ptr<Solver> {
        NativeSolverOptions options;
        set_fields(keywords, options);
        return make_native_solver(options);
      },
      "The native solver. Options: tolerance, max_iterations, time_limit, curvature, "
      "convexity_floor, initial_trust_radius, qp ('sparse' or 'riccati').");
#ifdef SALTUS_PYTHON_IPOPT
  Struct<IpoptOptions>(m, "IpoptOptions", "Options of Ipopt.")
      .field("tolerance", &IpoptOptions::tolerance)
      .field("max_iterations", &IpoptOptions::max_iterations)
      .field("time_limit", &IpoptOptions::time_limit)
      .field("curvature", &IpoptOptions::curvature)
      .field("bound_relaxation", &IpoptOptions::bound_relaxation)
      .field("mehrotra", &IpoptOptions::mehrotra)
      .field("adaptive_barrier", &IpoptOptions::adaptive_barrier)
      .field("warm_start_barrier", &IpoptOptions::warm_start_barrier)
      .field("print_level", &IpoptOptions::print_level)
      .field("blas_threads", &IpoptOptions::blas_threads)
      .field("named", &IpoptOptions::named)
      .from_keywords();
  m.def(
      "make_ipopt",
      [](const py::kwargs& keywords) -> std::shared_ptr<Solver> {
        IpoptOptions options;
        set_fields(keywords, options);
        return make_ipopt(options);
      },
      "Ipopt. Options: tolerance, max_iterations, time_limit, curvature, print_level, named, ...");
#endif
}

void add_results(py::module_& m) {
  py::enum_<SolveStatus> status(m, "SolveStatus", "Reason why a solve ended.");
  for (int i = 0; i <= static_cast<int>(SolveStatus::invalid_problem); ++i) {
    static const char* const names[] = {
        "optimal",           "acceptable",        "feasible",       "step_taken",
        "coarse_grid",       "wrong_crossing",    "no_minimum",     "infeasible",
        "unbounded",         "iteration_limit",   "time_limit",     "interrupted",
        "evaluation_failed", "numerical_failure", "invalid_problem"};
    status.value(names[i], static_cast<SolveStatus>(i));
  }
  m.def(
      "describe", [](SolveStatus s) { return describe(s); }, "status"_a,
      "Describes the status in one sentence.");

  py::class_<Trajectory> trajectory(m, "Trajectory", "States and inputs of a plan over time.");
  trajectory.def_property_readonly("empty", &Trajectory::empty)
      .def_property_readonly("start_time", &Trajectory::start_time)
      .def_property_readonly("end_time", &Trajectory::end_time)
      .def_property_readonly("final_state", &Trajectory::final_state)
      .def_property_readonly(
          "phases",
          [](const Trajectory& t) {
            std::vector<std::string> names;
            for (const auto& phase : t.phases()) names.push_back(phase.name);
            return names;
          },
          "Names of the phases.")
      .def(
          "parameters_of",
          [](const Trajectory& t, int phase) {
            if (phase < 0 || phase >= static_cast<int>(t.phases().size()))
              throw DefinitionError(fmt::format("trajectory: there is no phase {}", phase));
            return t.phases()[phase].parameters;
          },
          "phase"_a, "Data and unknowns of a phase.")
      .def(
          "state",
          [](const Trajectory& t, const Numbers& time) {
            return at(time, [&](double s) { return t.state(s); });
          },
          "t"_a, "State at a time, or one row per time.")
      .def(
          "state_before",
          [](const Trajectory& t, const Numbers& time) {
            return at(time, [&](double s) { return t.state_before(s); });
          },
          "t"_a, "Left limit of the state.")
      .def(
          "input",
          [](const Trajectory& t, const Numbers& time) {
            return at(time, [&](double s) { return t.input(s); });
          },
          "t"_a, "Input at a time, or one row per time.")
      .def(
          "algebraic",
          [](const Trajectory& t, const Numbers& time) {
            return at(time, [&](double s) { return t.algebraic(s); });
          },
          "t"_a, "Algebraic states at a time, or one row per time.")
      .def("after", &Trajectory::after, "phases"_a, "Without its first phases.")
      .def("samples", &samples_of, "samples_per_interval"_a = 1,
           "Arrays t, phase, x, u (and z) with one row per sample; an event has two rows.")
      .def(
          "csv",
          [](const Trajectory& t, int samples) {
            std::ostringstream out;
            t.write_csv(out, samples);
            return out.str();
          },
          "samples_per_interval"_a = 1, "Text of a CSV table.");

  py::class_<Solution> solution(m, "Solution", "The solution of a problem.");
  const auto names = [](const auto& all, auto value) {
    py::dict table;
    for (const auto& one : all)
      table[py::make_tuple(one.phase, value(one).first)] = value(one).second;
    return table;
  };
  solution.def_readonly("status", &Solution::status, "Outcome of the solve.")
      .def_readonly("message", &Solution::message, "One sentence.")
      .def_readonly("warnings", &Solution::warnings, "Possible mistakes in the definition.")
      .def_readonly("cost", &Solution::cost, "Optimal cost.")
      .def_readonly("trajectory", &Solution::trajectory, "States and inputs over time.")
      .def_property_readonly(
          "durations",
          [](const Solution& s) {
            return py::array_t<double>(static_cast<py::ssize_t>(s.durations.size()),
                                       s.durations.data());
          },
          "Duration of each phase, s.")
      .def_property_readonly(
          "costs",
          [=](const Solution& s) {
            return names(s.costs, [](const auto& c) { return std::pair(c.term, c.value); });
          },
          "Contributions by phase and term.")
      .def_property_readonly(
          "integrals",
          [=](const Solution& s) {
            return names(s.integrals, [](const auto& c) { return std::pair(c.integral, c.value); });
          },
          "Values of integral constraints by phase and name.")
      .def_property_readonly(
          "soft_violations",
          [=](const Solution& s) {
            return names(s.soft_violations,
                         [](const auto& c) { return std::pair(c.term, c.largest); });
          },
          "Largest violations of soft terms by phase and term.")
      .def_property_readonly(
          "multipliers",
          [](const Solution& s) {
            py::dict table;
            for (const Solution::Multiplier& curve : s.multipliers)
              table[py::make_tuple(curve.phase, curve.term, curve.row)] = py::make_tuple(
                  py::array(py::cast(curve.times)), py::array(py::cast(curve.values)));
            return table;
          },
          "Multipliers by phase, term and row: pairs of times and derivatives of the cost with "
          "respect to the active bound.")
      .def_readonly("crossings", &Solution::crossings,
                    "Zero crossings of guards at ends of phases.")
      .def_readonly("verification", &Solution::verification, "Result of the verifier, or None.")
      .def_readonly("predicted_gain", &Solution::predicted_gain)
      .def_readonly("iterations", &Solution::iterations)
      .def_readonly("seconds", &Solution::seconds, "Wall-clock time of the solver.")
      .def_readonly("method", &Solution::method, "Integrator, cost rule, Hessian.")
      .def_readonly("point", &Solution::point, "Primal-dual point for warm starts.")
      .def_readonly("start_multipliers", &Solution::start_multipliers, "d cost / d start.")
      .def("ok", &Solution::ok, "True if it is optimal to the requested tolerance.")
      .def("__bool__", &Solution::ok)
      .def("__repr__", [](const Solution& s) {
        return fmt::format("<Solution: {}>", s.message.empty() ? describe(s.status) : s.message);
      });
  py::class_<Solution::GuardCrossing>(solution, "GuardCrossing", "Zero crossing of a guard.")
      .def_readonly("phase", &Solution::GuardCrossing::phase)
      .def_readonly("event", &Solution::GuardCrossing::event)
      .def_readonly("declared", &Solution::GuardCrossing::declared)
      .def_readonly("time", &Solution::GuardCrossing::time)
      .def_readonly("rate", &Solution::GuardCrossing::rate)
      .def_readonly("grazes", &Solution::GuardCrossing::grazes)
      .def("is_as_declared", &Solution::GuardCrossing::is_as_declared);
  py::class_<NlpPoint> point(m, "PrimalDualPoint", "A point of a program with multipliers.");
  point.def(py::init<>());
  const auto copied = [&point](const char* name, VectorXd NlpPoint::*part, const char* doc) {
    point.def_property(
        name, [part](const NlpPoint& p) { return VectorXd(p.*part); },
        [part](NlpPoint& p, const VectorXd& to) { p.*part = to; }, doc);
  };
  copied("w", &NlpPoint::w, "Variables.");
  copied("multipliers", &NlpPoint::lambda, "Multipliers of the rows.");
  copied("z", &NlpPoint::z, "Multipliers of the bounds.");

  py::class_<Verification> verification(m, "Verification", "Result of the verifier.");
  py::class_<Verification::Miss>(verification, "Miss", "The largest violation of one kind.")
      .def_readonly("phase", &Verification::Miss::phase)
      .def_readonly("term", &Verification::Miss::term)
      .def_readonly("time", &Verification::Miss::time)
      .def_readonly("amount", &Verification::Miss::amount)
      .def_readonly("tolerance", &Verification::Miss::tolerance)
      .def("is_beyond", &Verification::Miss::is_beyond);
  verification.def_readonly("between_nodes", &Verification::between_nodes)
      .def_readonly("at_nodes", &Verification::at_nodes)
      .def_property_readonly("largest_defect",
                             [](const Verification& v) { return v.defect.largest; })
      .def_property_readonly("open_loop", [](const Verification& v) { return v.open_loop.states; })
      .def_property_readonly("cost", [](const Verification& v) { return v.cost.value; })
      .def_readonly("not_verified", &Verification::not_verified);

  py::class_<ProblemCheck> check_page(m, "ProblemCheck", "A page of verdicts on a problem.");
  py::enum_<ProblemCheck::Verdict>(check_page, "Verdict")
      .value("good", ProblemCheck::Verdict::good)
      .value("doubtful", ProblemCheck::Verdict::doubtful)
      .value("unknown", ProblemCheck::Verdict::unknown);
  py::class_<ProblemCheck::Line>(check_page, "Line", "One aspect of a problem.")
      .def_readonly("aspect", &ProblemCheck::Line::aspect)
      .def_readonly("verdict", &ProblemCheck::Line::verdict)
      .def_readonly("text", &ProblemCheck::Line::text);
  check_page.def_readonly("problem", &ProblemCheck::problem)
      .def_readonly("lines", &ProblemCheck::lines)
      .def("ok", &ProblemCheck::ok)
      .def("line", &ProblemCheck::line, "aspect"_a)
      .def("text", &ProblemCheck::text)
      .def("__str__", &ProblemCheck::text)
      .def("__repr__", &ProblemCheck::text);

  py::class_<Explanation> explanation(m, "Explanation", "Result of explain().");
  py::class_<Explanation::Shortage>(explanation, "Shortage", "Shortage of one side of a term.")
      .def_readonly("kind", &Explanation::Shortage::kind)
      .def_readonly("phase", &Explanation::Shortage::phase)
      .def_readonly("term", &Explanation::Shortage::term)
      .def_readonly("amount", &Explanation::Shortage::amount)
      .def_readonly("time", &Explanation::Shortage::time)
      .def_readonly("is_certain", &Explanation::Shortage::is_certain)
      .def("text", &Explanation::Shortage::text);
  py::class_<Explanation::Remedy>(explanation, "Remedy", "Changes that make a problem feasible.")
      .def_readonly("text", &Explanation::Remedy::text)
      .def_readonly("status", &Explanation::Remedy::status)
      .def_readonly("cost", &Explanation::Remedy::cost)
      .def_readonly("effort", &Explanation::Remedy::effort);
  explanation.def_readonly("status", &Explanation::status)
      .def_readonly("relaxation", &Explanation::relaxation)
      .def_readonly("shortages", &Explanation::shortages)
      .def_readonly("remedies", &Explanation::remedies)
      .def_readonly("trajectory", &Explanation::trajectory)
      .def_readonly("seconds", &Explanation::seconds)
      .def("ok", &Explanation::ok)
      .def("is_infeasible", &Explanation::is_infeasible)
      .def("text", &Explanation::text)
      .def("__str__", &Explanation::text)
      .def("__repr__", &Explanation::text);
}

void add_calls(py::module_& m) {
  py::class_<MultipleShooting>(m, "MultipleShooting",
                               "Transcription of a problem for many solves with different data.")
      .def(py::init([](const OptimalControlProblem& problem, const py::kwargs& keywords) {
             ShootingOptions options;
             options.integrator = runge_kutta4({.steps = 2});
             set_fields(keywords, options);
             Release release;
             return MultipleShooting(problem, options);
           }),
           "problem"_a)
      .def("start_at", &MultipleShooting::start_at, "t"_a, "state"_a)
      .def(
          "set_data",
          [](MultipleShooting& s, const std::string& name, const Numbers& values) {
            s.set_entries(name, vector_of(values), {});
          },
          "name"_a, "values"_a, "Sets data by the name of a block.")
      .def("retime", &MultipleShooting::retime, "event"_a, "time"_a)
      .def("set_schedule", &MultipleShooting::set_schedule, "schedule"_a)
      .def("set_previous_input", &MultipleShooting::set_previous_input, "input"_a)
      .def("set_penalty_weight", &MultipleShooting::set_penalty_weight, "weight_name"_a, "weight"_a)
      .def("initial_guess", &MultipleShooting::initial_guess)
      .def("guess_from", &MultipleShooting::guess_from, "trajectory"_a)
      .def("trajectory", &MultipleShooting::trajectory, "w"_a)
      .def("current_problem", [](const MultipleShooting& s) { return current_problem(s); });

  m.def(
      "solve",
      [](const OptimalControlProblem& problem, const py::kwargs& keywords) {
        SolveOptions options;
        set_fields(keywords, options);
        return released(options.observer, [&](const SolveObserver& observer) {
          options.observer = observer;
          return solve(problem, options);
        });
      },
      "problem"_a,
      "Solves a problem. Options: intervals_per_phase = 30, intervals, integrator, threads, "
      "solver, guess, observer. A solve that does not converge returns its status and message.");
  m.def(
      "solve",
      [](MultipleShooting& shooting, Solver& solver, const NlpPoint* start) {
        return released(solver.observer(), [&](const SolveObserver& observer) {
          const SolveObserver own = solver.observer();
          solver.set_observer(observer);
          struct Restore {
            Solver& solver;
            const SolveObserver& own;
            ~Restore() { solver.set_observer(own); }
          } restore{solver, own};
          return start != nullptr ? solve(shooting, solver, *start) : solve(shooting, solver);
        });
      },
      "shooting"_a, "solver"_a, "start"_a = py::none(),
      "Solves a transcription with the current data, from a point if one is given.");

  py::class_<RefinedSolution>(m, "RefinedSolution", "Result of solve_refined().")
      .def_property_readonly(
          "shooting", [](RefinedSolution& r) -> MultipleShooting& { return r.shooting; },
          py::return_value_policy::reference_internal)
      .def_readonly("solution", &RefinedSolution::solution)
      .def_readonly("intervals", &RefinedSolution::intervals)
      .def_readonly("violations", &RefinedSolution::violations)
      .def_readonly("iterations", &RefinedSolution::iterations)
      .def_readonly("seconds", &RefinedSolution::seconds)
      .def_readonly("reached", &RefinedSolution::reached)
      .def_readonly("message", &RefinedSolution::message);
  m.def(
      "solve_refined",
      [](const OptimalControlProblem& problem, std::shared_ptr<Solver> solver,
         const py::kwargs& keywords) {
        ShootingOptions options;
        options.integrator = runge_kutta4({.steps = 2});
        RefinementOptions refinement;
        set_fields(keywords, options, refinement);
        Release release;
        if (!solver) solver = make_native_solver();
        return solve_refined(problem, options, *solver, refinement);
      },
      "problem"_a, "solver"_a = std::shared_ptr<Solver>(),
      "Solves and cuts intervals until the plan is accurate between the nodes. Options: those of "
      "ShootingOptions and RefinementOptions.");
  m.def(
      "check",
      [](const OptimalControlProblem& problem, const py::kwargs& keywords) {
        ShootingOptions options;
        set_fields(keywords, options);
        Release release;
        return check(problem, options);
      },
      "problem"_a, "Checks a problem: one page with a verdict per line.");
  m.def(
      "explain",
      [](const OptimalControlProblem& problem, const py::kwargs& keywords) {
        ExplainOptions options;
        set_fields(keywords, options, options.shooting);
        Release release;
        return explain(problem, options);
      },
      "problem"_a,
      "Explains why a problem is infeasible and which changes would help. Options: remedies, "
      "time_limit, guess, soft_terms and those of ShootingOptions.");
  m.def(
      "save",
      [](const OptimalControlProblem& problem, const std::variant<Trajectory, Solution>& plan,
         const std::string& folder, std::vector<std::string> state_names,
         std::vector<std::string> input_names) {
        std::visit(
            [&](const auto& saved) {
              save(problem, saved, folder, std::move(state_names), std::move(input_names));
            },
            plan);
      },
      "problem"_a, "plan"_a, "folder"_a, "state_names"_a = std::vector<std::string>{},
      "input_names"_a = std::vector<std::string>{},
      "Writes trajectory.csv and events.csv, which `saltus plot FOLDER` draws; of a Solution also "
      "summary.json and multipliers.csv for `saltus view FOLDER`.");
  m.def("multipliers_csv", &multipliers_csv, "plan"_a,
        "Text of a CSV table of the multipliers of a Solution over time.");
  m.def("summary_json", &summary_json, "name"_a, "plan"_a,
        "Text of summary.json: status, cost and its terms, multipliers and violations.");
}

}  // namespace

void add_solves(py::module_& m) {
  add_results(m);
  add_integrators(m);
  add_solvers(m);
  add_options(m);
  add_calls(m);
}

}  // namespace saltus::python
