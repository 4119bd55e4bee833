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
#include "benchmarks/suite/nonlinear_file.hpp"
#include "benchmarks/suite/nonlinear_problems.hpp"
#include "benchmarks/suite/qp_file.hpp"
#include "benchmarks/suite/qp_problems.hpp"
#include "benchmarks/suite/timed.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/version.hpp"
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
  SolveTimes times;
};

// The starts that a program can have. The same ones are offered to other solvers.
constexpr const char* own_start = "own start";
constexpr const char* guess_start = "guess";
constexpr const char* rolled_out_start = "guess rolled out";
constexpr const char* warm_start = "warm";

PrimalDualPoint zero_point(const qp::SparseQp& qp) {
  return {VectorXd::Zero(qp.variables()), VectorXd::Zero(qp.row_pattern.rows()),
          VectorXd::Zero(qp.variables())};
}

// The starting point of this name. Throws InputError if the program does not have it.
PrimalDualPoint start_of(const QpInstance& instance, const std::string& start) {
  if (start == own_start) return zero_point(instance.flat);
  if (start == warm_start && instance.warm) return *instance.warm;
  const bool is_guess = start == guess_start || start == rolled_out_start;
  if (is_guess && instance.guess && (start == guess_start || instance.stages)) {
    PrimalDualPoint point = zero_point(instance.flat);
    point.w =
        start == guess_start ? *instance.guess : rolled_out(*instance.stages, *instance.guess);
    return point;
  }
  throw InputError(
      fmt::format("the program has no start '{}'; a start is 'own start', 'guess', 'guess rolled "
                  "out' or 'warm', as the program has them",
                  start));
}

qp::QpOptions::Start kind_of(const std::string& start) {
  return start == own_start ? qp::QpOptions::Start::least_squares : qp::QpOptions::Start::guess;
}

Solved solve_in_stages(std::span<const qp::RiccatiKernel> kernels, const QpInstance& instance,
                       const std::string& start, double tolerance) {
  Solved s;
  qp::RiccatiOptions options;
  options.tolerance = tolerance;
  options.start = kind_of(start);
  const qp::StageQp& qp = *instance.stages;
  const bool warm = start == warm_start;
  const qp::StagePoint given = in_stages(qp, start_of(instance, start));
  std::unique_ptr<qp::StageQpSolver> solver;
  s.times.setup = timed([&] { solver = qp::make_riccati_solver(qp, options, kernels); });
  qp::StagePoint point = given;
  timed_twice(s.times, [&] {
    point = given;
    s.result = solver->solve(qp, point, warm);
  });
  s.point = flatten(qp, point);
  return s;
}

Solved solve_sparse(const QpInstance& instance, const std::string& start, double tolerance) {
  Solved s;
  const qp::SparseQp& qp = instance.flat;
  qp::QpOptions options;
  options.tolerance = tolerance;
  options.start = kind_of(start);
  const PrimalDualPoint given = start_of(instance, start);
  std::unique_ptr<qp::QpSolver> solver;
  s.times.setup = timed(
      [&] { solver = qp::make_sparse_qp_solver(qp.hessian_pattern, qp.row_pattern, options); });
  timed_twice(s.times, [&] {
    s.point = given;
    s.result = solver->solve(qp, s.point, start == warm_start);
  });
  return s;
}

Json times_json(const SolveTimes& times) {
  return {{"setup_us", times.setup.wall},
          {"first_us", times.first.wall},
          {"wall_us", times.repeated.wall},
          {"cpu_us", times.repeated.cpu}};
}

bool is_nonlinear(const std::string& name) { return name.starts_with(library_prefix); }

SolverChoice choice_of(const nlohmann::json& request) {
  const auto name = wanted<std::string>(request, "solver");
  for (const auto& [known, choice] : solver_choices())
    if (known == name) return choice;
  throw InputError(
      fmt::format("the solvers of Saltus are ipopt, sparse and riccati, not '{}'", name));
}

Json residual_json(NonlinearProgram& program, const NlpPoint& point) {
  double objective = std::numeric_limits<double>::quiet_NaN();
  if (point.w.size() == program.variables()) program.objective(point.w.data(), objective);
  const KktCheck::Residual kkt = kkt_residual(program, point);
  return {{"objective", objective},
          {"kkt",
           {{"stationarity", kkt.stationarity / kkt.multiplier_scale},
            {"feasibility", kkt.feasibility},
            {"complementarity", kkt.complementarity / kkt.multiplier_scale}}}};
}

Json solution_json(const NlpResult& result, const SolveTimes& times) {
  return {{"claimed", saltus::describe(result.status)},
          {"solved", is_success(result.status)},
          {"iterations", result.iterations},
          {"times", times_json(times)}};
}

}  // namespace

struct Answerer::State {
  std::vector<QpProblem> problems = qp_problems();
  std::map<std::pair<std::string, int>, QpInstance> instances;
  std::map<std::string, QpInstance> files;
  std::map<std::string, std::unique_ptr<NonlinearProblem>> nonlinear;
  std::map<std::string, std::unique_ptr<NonlinearFile>> nonlinear_files;

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
            {"solvers", {"riccati", "riccati-generic", "sparse", "ipopt"}}};
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
    if (name != "riccati" && name != "riccati-generic" && name != "sparse")
      throw InputError(
          fmt::format("the solvers of Saltus for quadratic programs are riccati, riccati-generic "
                      "and sparse, not '{}'",
                      name));
    if (name != "sparse" && !one.stages) return {{"not_applicable", "it has no stages"}};
    if (name == "riccati" && problem.kernels.empty())
      return {{"not_applicable", "its sizes are not compiled in; see riccati-generic"}};
    const Solved s = name == "sparse"
                         ? solve_sparse(one, start, tolerance)
                         : solve_in_stages(name == "riccati" ? problem.kernels
                                                             : std::span<const qp::RiccatiKernel>(),
                                           one, start, tolerance);
    const qp::SparseQp::Residual kkt = kkt_residual(one.flat, s.point);
    return {{"claimed", qp::describe(s.result.status)},
            {"solved", s.result.status == qp::QpStatus::optimal},
            {"iterations", s.result.iterations},
            {"times", times_json(s.times)},
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
    const SolverChoice choice = choice_of(request);
    NonlinearProblem::Solved s;
    try {
      s = problem.solve(choice, wanted<double>(request, "tolerance"));
    } catch (const DefinitionError& why) {
      return {{"not_applicable", why.what()}};
    }
    Json answer = judged(problem, s.result.point);
    answer.update(solution_json(s.result, s.times));
    return answer;
  }

  // A nonlinear program in a file. It has no stages.
  Json solve_nonlinear_file(const nlohmann::json& request) {
    const auto file = wanted<std::string>(request, "file");
    const SolverChoice choice = choice_of(request);
    if (choice == SolverChoice::riccati) return {{"not_applicable", "it has no stages"}};
    std::unique_ptr<NonlinearFile>& program = nonlinear_files[file];
    if (!program) program = std::make_unique<NonlinearFile>(file);
    const NonlinearFile::Solved s = program->solve(choice, wanted<double>(request, "tolerance"));
    Json answer = residual_json(*program, s.result.point);
    answer.update(solution_json(s.result, s.times));
    answer["point"] = point_json(s.result.point);
    return answer;
  }

  // Judges a point of any origin from the program alone.
  static Json judged(NonlinearProblem& problem, const NlpPoint& point) {
    Json answer = residual_json(problem.shooting().nlp(), point);
    const ReferenceCase& reference = problem.reference();
    answer["optimum"] = reference.optimum;
    answer["margin"] = reference.tolerance * (1.0 + std::abs(reference.optimum));
    return answer;
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
  if (what == "version") return {{"version", version()}, {"commit", commit()}};
  if (what == "export") return state_->write(request);
  if (what == "judge") return state_->judge(request);
  if (what == "solve" && request.value("kind", "") == "nonlinear file")
    return state_->solve_nonlinear_file(request);
  if (what == "solve")
    return is_nonlinear(request.value("problem", "")) ? state_->solve_nonlinear(request)
                                                      : state_->solve(request);
  throw InputError(
      fmt::format("a request must be describe, version, export, solve or judge, not '{}'", what));
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
