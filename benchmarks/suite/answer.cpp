#include "benchmarks/suite/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <istream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <utility>

#include "benchmarks/latency_output.hpp"
#include "benchmarks/suite/flat_qp.hpp"
#include "benchmarks/suite/nonlinear_problems.hpp"
#include "benchmarks/suite/qp_file.hpp"
#include "benchmarks/suite/qp_problems.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/version.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::bench {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
T wanted(const nlohmann::json& request, const char* key) {
  const auto at = request.find(key);
  if (at == request.end()) throw InputError(fmt::format("the request needs '{}'", key));
  try {
    return at->get<T>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(fmt::format("'{}' must not be {}", key, at->dump().substr(0, 40)));
  }
}

struct Solved {
  qp::QpResult result;
  PrimalDualPoint point;
  double microseconds = 0.0, setup_microseconds = 0.0;
};

template <class Solve>
void timed(double& microseconds, Solve&& solve) {
  const double begin = thread_microseconds();
  solve();
  microseconds = thread_microseconds() - begin;
}

Solved solve_in_stages(const QpProblem& problem, const QpInstance& instance, bool warm,
                       double tolerance) {
  Solved s;
  qp::RiccatiOptions options = problem.options;
  options.tolerance = tolerance;
  const qp::StageQp& qp = *instance.stages;
  std::unique_ptr<qp::StageQpSolver> solver;
  timed(s.setup_microseconds,
        [&] { solver = qp::make_riccati_solver(qp, options, problem.kernels); });
  const qp::StagePoint& start = warm ? *instance.warm : instance.guess;
  qp::StagePoint point = start;
  solver->solve(qp, point, warm);  // new memory, cold caches
  point = start;
  timed(s.microseconds, [&] { s.result = solver->solve(qp, point, warm); });
  s.point = flatten(qp, point);
  return s;
}

Solved solve_sparse(const QpInstance& instance, bool warm, double tolerance) {
  Solved s;
  const qp::SparseQp& qp = instance.flat;
  qp::QpOptions options;
  options.tolerance = tolerance;
  std::unique_ptr<qp::QpSolver> solver;
  timed(s.setup_microseconds,
        [&] { solver = qp::make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern, options); });
  PrimalDualPoint start{VectorXd::Zero(qp.variables()), VectorXd::Zero(qp.row_pattern.rows()),
                        VectorXd::Zero(qp.variables())};
  if (warm) start = flatten(*instance.stages, *instance.warm);
  s.point = start;
  solver->solve(qp, s.point, warm);
  s.point = start;
  timed(s.microseconds, [&] { s.result = solver->solve(qp, s.point, warm); });
  return s;
}

bool is_nonlinear(const std::string& name) { return name.starts_with(library_prefix); }

}  // namespace

struct Answerer::State {
  std::vector<QpProblem> problems = qp_problems();
  std::map<std::pair<std::string, int>, QpInstance> instances;
  std::map<std::string, QpInstance> files;
  std::map<std::string, std::unique_ptr<NonlinearProblem>> nonlinear;

  NonlinearProblem& nonlinear_problem(const std::string& name) {
    std::unique_ptr<NonlinearProblem>& at = nonlinear[name];
    if (!at) at = std::make_unique<NonlinearProblem>(nonlinear_case(name));
    return *at;
  }

  const QpInstance& instance(const QpProblem& problem, int number) {
    if (number < 1 || (problem.instances > 0 && number > problem.instances))
      throw InputError(fmt::format("'{}' has no instance {}", problem.name, number));
    const auto key = std::pair(problem.name, number);
    const auto at = instances.find(key);
    if (at != instances.end()) return at->second;
    return instances.emplace(key, problem.instance(number)).first->second;
  }

  Json describe() const {
    Json list = Json::array();
    for (const QpProblem& p : problems)
      list.push_back({{"name", p.name},
                      {"about", p.about},
                      {"instances", p.instances},
                      {"horizon", p.horizon},
                      {"warm", p.has_warm_start}});
    for (const std::string& name : nonlinear_names()) {
      NonlinearProblem problem(nonlinear_case(name));
      list.push_back({{"name", name},
                      {"about", problem.reference().summary},
                      {"instances", 1},
                      {"horizon", problem.intervals()},
                      {"warm", false},
                      {"kind", "nonlinear"}});
    }
    // The head of every report: processor, compiler, flags.
    const Json head = to_json(LatencyReport{});
    return {{"version", version()},
            {"commit", commit()},
            {"machine", head.at("machine")},
            {"build", head.at("build")},
            {"problems", list},
            {"solvers", {"riccati", "sparse", "ipopt"}}};
  }

  // The program of a file, if one is given.
  std::pair<QpProblem, const QpInstance*> asked_for(const nlohmann::json& request) {
    if (!request.contains("file")) {
      const auto name = wanted<std::string>(request, "problem");
      const QpProblem& problem = find_problem(problems, name);
      return {problem, &instance(problem, wanted<int>(request, "instance"))};
    }
    const auto file = wanted<std::string>(request, "file");
    auto at = files.find(file);
    if (at == files.end()) at = files.emplace(file, read_program(file)).first;
    QpProblem problem;
    problem.name = file;
    return {problem, &at->second};
  }

  Json solve(const nlohmann::json& request) {
    const auto [problem, asked] = asked_for(request);
    const QpInstance& one = *asked;
    const auto name = wanted<std::string>(request, "solver");
    const auto start = wanted<std::string>(request, "start");
    const auto tolerance = wanted<double>(request, "tolerance");
    if (start != "cold" && start != "warm")
      throw InputError(fmt::format("'start' must be cold or warm, not '{}'", start));
    const bool warm = start == "warm";
    if (warm && !one.warm) throw InputError(fmt::format("'{}' has no warm start", problem.name));
    if (name != "riccati" && name != "sparse")
      throw InputError(fmt::format(
          "the solvers of Saltus for quadratic programs are riccati and sparse, not '{}'", name));
    if (name == "riccati" && !one.stages) return {{"not_applicable", "it has no stages"}};
    const Solved s = name == "riccati" ? solve_in_stages(problem, one, warm, tolerance)
                                       : solve_sparse(one, warm, tolerance);
    const qp::SparseQp::Residual kkt = kkt_residual(one.flat, s.point);
    return {{"claimed", qp::describe(s.result.status)},
            {"solved", s.result.status == qp::QpStatus::optimal},
            {"iterations", s.result.iterations},
            {"cpu_us", s.microseconds},
            {"setup_us", s.setup_microseconds},
            {"objective", objective(one.flat, s.point.w)},
            {"kkt",
             {{"stationarity", kkt.stationarity},
              {"feasibility", kkt.feasibility},
              {"complementarity", kkt.complementarity}}},
            {"point", point_json(s.point)}};
  }

  Json write(const nlohmann::json& request) {
    const auto name = wanted<std::string>(request, "problem");
    const std::filesystem::path file = wanted<std::string>(request, "file");
    const OutputFolder folder(file.has_parent_path() ? file.parent_path() : ".");
    Json content;
    if (is_nonlinear(name)) {
      try {
        content = nonlinear_problem(name).file();
      } catch (const DefinitionError& why) {
        return {{"not_applicable", why.what()}};
      }
    } else {
      const QpProblem& problem = find_problem(problems, name);
      const int number = wanted<int>(request, "instance");
      content = program_json(problem, number, instance(problem, number));
    }
    folder.write(file.filename().string(), std::string_view(content.dump() + "\n"));
    return {{"written", file.string()}};
  }

  Json solve_nonlinear(const nlohmann::json& request) {
    NonlinearProblem& problem = nonlinear_problem(wanted<std::string>(request, "problem"));
    const auto name = wanted<std::string>(request, "solver");
    const auto& choices = solver_choices();
    const auto at = std::find_if(choices.begin(), choices.end(),
                                 [&](const auto& choice) { return choice.first == name; });
    if (at == choices.end())
      throw InputError(
          fmt::format("the solvers of Saltus are ipopt, sparse and riccati, not '{}'", name));
    NonlinearProblem::Solved s;
    try {
      s = problem.solve(at->second, wanted<double>(request, "tolerance"));
    } catch (const DefinitionError& why) {
      return {{"not_applicable", why.what()}};
    }
    Json answer = judged(problem, s.result.point);
    answer.update({{"claimed", saltus::describe(s.result.status)},
                   {"solved", is_success(s.result.status)},
                   {"iterations", s.result.iterations},
                   {"cpu_us", s.microseconds},
                   {"setup_us", 0.0}});
    return answer;
  }

  // Judges a point of any origin from the program alone.
  static Json judged(NonlinearProblem& problem, const NlpPoint& point) {
    NonlinearProgram& program = problem.shooting().nlp();
    double objective = std::numeric_limits<double>::quiet_NaN();
    if (point.w.size() == program.variables()) program.objective(point.w.data(), objective);
    const KktCheck::Residual kkt = kkt_residual(program, point);
    const ReferenceCase& reference = problem.reference();
    return {{"objective", objective},
            {"optimum", reference.optimum},
            {"margin", reference.tolerance * (1.0 + std::abs(reference.optimum))},
            {"kkt",
             {{"stationarity", kkt.stationarity / kkt.multiplier_scale},
              {"feasibility", kkt.feasibility},
              {"complementarity", kkt.complementarity / kkt.multiplier_scale}}}};
  }

  Json judge(const nlohmann::json& request) {
    NonlinearProblem& problem = nonlinear_problem(wanted<std::string>(request, "problem"));
    const auto entries = [&](const char* key) {
      const auto values = wanted<std::vector<double>>(request, key);
      return VectorXd(Eigen::Map<const VectorXd>(values.data(), values.size()));
    };
    return judged(problem, {entries("w"), entries("lambda"), entries("z")});
  }
};

Answerer::Answerer() : state_(std::make_unique<State>()) {}
Answerer::~Answerer() = default;

Json Answerer::answer(const nlohmann::json& request) try {
  if (!request.is_object()) throw InputError("a request must be one JSON object per line");
  const auto what = wanted<std::string>(request, "do");
  if (what == "describe") return state_->describe();
  if (what == "export") return state_->write(request);
  if (what == "judge") return state_->judge(request);
  if (what == "solve")
    return is_nonlinear(request.value("problem", "")) ? state_->solve_nonlinear(request)
                                                      : state_->solve(request);
  throw InputError(
      fmt::format("a request must be describe, export, solve or judge, not '{}'", what));
} catch (const std::exception& error) {
  return {{"error", error.what()}};
}

void answer_requests(std::istream& in, std::ostream& out) {
  Answerer answerer;
  for (std::string line; std::getline(in, line);)
    out << answerer.answer(nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false)).dump()
        << std::endl;
}

}  // namespace saltus::bench
