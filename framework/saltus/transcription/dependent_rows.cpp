#include "saltus/transcription/dependent_rows.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>
#include <vector>

namespace saltus {

using namespace shooting;

namespace {

constexpr std::size_t rows_named = 3;
constexpr double held = 1e-9;  // tolerance of an equation with terms of size 1

// Equations in order: start and dynamics first, then those of the user, so that dependent rows are
// those of the user. Omits equations that have no unknowns and hold.
std::vector<int> equations(ShootingProgram& program, const VectorXd& w) {
  std::vector<char> has_unknown(program.rows(), 0);
  program.jacobian_pattern().for_each([&](int r, int c, int) {
    if (program.lower()[c] < program.upper()[c]) has_unknown[r] = 1;
  });
  VectorXd values(program.rows());
  if (!program.constraints(w.data(), values.data())) return {};
  std::vector<char> is_term(program.rows(), 0);
  for (const RowInstance& instance : program.row_instances()) {
    const Term& term = program.problem().phases()[instance.phase].terms[instance.term];
    std::fill_n(is_term.begin() + instance.first_row, term.function.outputs(), 1);
  }
  for (const LimitInstance& instance : program.limit_instances())
    std::fill_n(is_term.begin() + instance.first_row, instance.count, 1);
  std::vector<int> rows;
  for (const char of_terms : {0, 1})
    for (int r = 0; r < program.rows(); ++r)
      if (is_term[r] == of_terms && program.row_lower()[r] == program.row_upper()[r] &&
          (has_unknown[r] || std::abs(values[r] - program.row_lower()[r]) > held))
        rows.push_back(r);
  return rows;
}

}  // namespace

std::string describe_dependent_rows(ShootingProgram& program, const VectorXd& w) {
  const std::vector<int> rows = equations(program, w);
  std::vector<int> unknown(program.variables(), -1), equation(program.rows(), -1);
  int unknowns = 0;
  for (int i = 0; i < program.variables(); ++i)
    if (program.lower()[i] < program.upper()[i]) unknown[i] = unknowns++;
  for (std::size_t e = 0; e < rows.size(); ++e) equation[rows[e]] = static_cast<int>(e);

  const SparsityPattern& pattern = program.jacobian_pattern();
  std::vector<double> entries(pattern.entries());
  if (!program.jacobian(w.data(), entries.data())) return {};
  std::vector<Eigen::Triplet<double>> transposed;
  pattern.for_each([&](int r, int c, int e) {
    if (equation[r] >= 0 && unknown[c] >= 0)
      transposed.emplace_back(unknown[c], equation[r], entries[e]);
  });
  // Normalises each equation, so that the test does not depend on units.
  VectorXd length = VectorXd::Zero(static_cast<int>(rows.size()));
  for (const auto& entry : transposed) length[entry.col()] += entry.value() * entry.value();
  for (auto& entry : transposed)
    if (length[entry.col()] > 0.0)
      entry = {entry.row(), entry.col(), entry.value() / std::sqrt(length[entry.col()])};
  // QR puts a column of J' that depends on previous ones last.
  Eigen::SparseMatrix<double> J(unknowns, static_cast<int>(rows.size()));
  J.setFromTriplets(transposed.begin(), transposed.end());
  J.makeCompressed();
  Eigen::SparseQR<Eigen::SparseMatrix<double>, Eigen::NaturalOrdering<int>> qr(J);
  if (qr.info() != Eigen::Success || qr.rank() == J.cols()) return {};

  std::string text =
      fmt::format("{} equations for {} free unknowns", rows.size(), static_cast<int>(unknowns));
  const auto& order = qr.colsPermutation().indices();
  const std::size_t dependent = rows.size() - static_cast<std::size_t>(qr.rank());
  for (std::size_t i = 0; i < std::min(dependent, rows_named); ++i)
    text += fmt::format("{}{}", i == 0 ? "; " : ", ",
                        program.describe_row(rows[order[qr.rank() + static_cast<int>(i)]], &w));
  if (dependent > rows_named) text += fmt::format(" and {} more", dependent - rows_named);
  return text + (dependent == 1 ? " follows from the other equations or contradicts them"
                                : " follow from the other equations or contradict them");
}

}  // namespace saltus
