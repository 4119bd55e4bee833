#include "saltus/transcription/dependent_rows.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <algorithm>
#include <vector>

namespace saltus {

using namespace shooting;

namespace {

constexpr std::size_t rows_named = 3;

// Equations in the order in which they are taken: what comes later is what is superfluous. First
// the start and the dynamics, then what the user added.
std::vector<int> equations(const ShootingProgram& program) {
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
      if (is_term[r] == of_terms && program.row_lower()[r] == program.row_upper()[r])
        rows.push_back(r);
  return rows;
}

}  // namespace

std::string name_dependent_rows(ShootingProgram& program, const VectorXd& w) {
  const std::vector<int> rows = equations(program);
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
  // A column of J' that depends on those before it is put last.
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
