#include "benchmarks/suite/qp_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "benchmarks/data_file.hpp"
#include "benchmarks/suite/flat_qp.hpp"
#include "saltus/core/error.hpp"

namespace saltus::bench {
namespace {

using Json = nlohmann::ordered_json;

Json matrix(const SparsityPattern& pattern, const VectorXd& values) {
  Json row = Json::array(), col = Json::array();
  pattern.for_each([&](int i, int j, int) {
    row.push_back(i);
    col.push_back(j);
  });
  return {{"row", row}, {"col", col}, {"value", json_list(values)}};
}

VectorXd sides_of(const nlohmann::json& list, double absent) {
  VectorXd v(list.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    v[static_cast<int>(i)] = list[i].is_null() ? absent : list[i].get<double>();
  return v;
}

struct Entries {
  std::vector<int> row, col;
  std::vector<double> value;

  explicit Entries(const nlohmann::json& json)
      : row(json.at("row").get<std::vector<int>>()),
        col(json.at("col").get<std::vector<int>>()),
        value(json.at("value").get<std::vector<double>>()) {
    if (row.size() != value.size() || col.size() != value.size())
      throw DefinitionError("row, col and value of a matrix differ in length");
  }

  SparsityPattern pattern(int rows, int cols) const {
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t e = 0; e < value.size(); ++e) {
      if (row[e] < 0 || row[e] >= rows || col[e] < 0 || col[e] >= cols)
        throw DefinitionError(fmt::format("entry {} is outside its matrix", e));
      pairs.emplace_back(row[e], col[e]);
    }
    return SparsityPattern::from_pairs(rows, cols, std::move(pairs));
  }
  void put(const SparsityPattern& pattern, VectorXd& values) const {
    for (std::size_t e = 0; e < value.size(); ++e) values[pattern.find(row[e], col[e])] += value[e];
  }
};

qp::SparseQp program_of(const nlohmann::json& json) {
  if (json.at("format") != "saltus-qp 1") throw DefinitionError("its format is not 'saltus-qp 1'");
  const int n = json.at("variables").get<int>(), rows = json.at("rows").get<int>();
  // Before allocating: the sizes must agree with the lists.
  const auto count = [&](const char* key) { return static_cast<int>(json.at(key).size()); };
  if (n != count("gradient") || n != count("lower") || n != count("upper") ||
      rows != count("row_lower") || rows != count("row_upper"))
    throw DefinitionError("a list does not have one entry per variable or row");
  const Entries hessian(json.at("hessian")), jacobian(json.at("jacobian"));
  qp::SparseQp qp(hessian.pattern(n, n), jacobian.pattern(rows, n));
  hessian.put(qp.hessian_pattern, qp.hessian);
  jacobian.put(qp.row_pattern, qp.rows);
  qp.gradient = sides_of(json.at("gradient"), 0.0);
  qp.constant = json.at("constant").get<double>();
  qp.lower = sides_of(json.at("lower"), -infinity);
  qp.upper = sides_of(json.at("upper"), infinity);
  qp.row_lower = sides_of(json.at("row_lower"), -infinity);
  qp.row_upper = sides_of(json.at("row_upper"), infinity);
  return qp;
}

}  // namespace

Json json_list(const VectorXd& v) { return std::vector<double>(v.begin(), v.end()); }

Json json_sides(const VectorXd& v) {
  Json all = Json::array();
  for (const double side : v) all.push_back(std::isfinite(side) ? Json(side) : Json());
  return all;
}

Json point_json(const PrimalDualPoint& point) {
  return {
      {"w", json_list(point.w)}, {"lambda", json_list(point.lambda)}, {"z", json_list(point.z)}};
}

Json program_json(const QpProblem& problem, int number, const QpInstance& instance) {
  const qp::SparseQp& qp = instance.flat;
  Json stages = Json::array();
  if (instance.stages)
    for (const StageSizes& s : stage_sizes(*instance.stages))
      stages.push_back({s.nx, s.nu, s.rows});
  Json json{{"format", "saltus-qp 1"},
            {"problem", problem.name},
            {"instance", number},
            {"variables", qp.variables()},
            {"rows", qp.row_pattern.rows()},
            {"hessian", matrix(qp.hessian_pattern, qp.hessian)},
            {"jacobian", matrix(qp.row_pattern, qp.rows)},
            {"gradient", json_list(qp.gradient)},
            {"constant", qp.constant},
            {"lower", json_sides(qp.lower)},
            {"upper", json_sides(qp.upper)},
            {"row_lower", json_sides(qp.row_lower)},
            {"row_upper", json_sides(qp.row_upper)},
            {"stages", stages}};
  if (instance.guess) json["guess"] = json_list(*instance.guess);
  if (instance.warm) json["warm"] = point_json(*instance.warm);
  return json;
}

QpInstance read_program(const std::filesystem::path& file) try {
  QpInstance instance;
  const nlohmann::json json = read_json(file);
  instance.flat = program_of(json);
  const auto list = [&](const nlohmann::json& from, const char* key, int count) {
    const auto values = from.at(key).get<std::vector<double>>();
    if (static_cast<int>(values.size()) != count)
      throw DefinitionError(
          fmt::format("the start '{}' has {} entries, not {}", key, values.size(), count));
    return VectorXd(Eigen::Map<const VectorXd>(values.data(), count));
  };
  const int n = instance.flat.variables(), rows = instance.flat.row_pattern.rows();
  if (json.contains("guess")) instance.guess = list(json, "guess", n);
  if (const auto warm = json.find("warm"); warm != json.end())
    instance.warm = {list(*warm, "w", n), list(*warm, "lambda", rows), list(*warm, "z", n)};
  std::vector<StageSizes> sizes;
  for (const nlohmann::json& s : json.at("stages"))
    sizes.push_back({s.at(0).get<int>(), s.at(1).get<int>(), s.at(2).get<int>()});
  if (sizes.empty()) return instance;
  instance.stages = in_stages(instance.flat, sizes);
  return instance;
} catch (const DefinitionError& error) {
  throw InputError(fmt::format("'{}' is not a valid program: {}", file.string(), error.what()));
} catch (const nlohmann::json::exception& error) {
  throw InputError(fmt::format("'{}' is not a valid program: {}", file.string(), error.what()));
}

}  // namespace saltus::bench
