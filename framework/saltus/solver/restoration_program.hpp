// Restoration phase: the nearest point that satisfies the rows.
//
//     min weight sum(p + q) + zeta/2 |D (w - w0)|^2
//     subject to   lower <= w <= upper,  row_lower <= g(w) - p + q <= row_upper,  p, q >= 0,
//
// D = 1 / max(1, |w0|). At a solution with p + q > 0 the rows cannot be met near w0.
// Waechter and Biegler, Math. Program. 106, 2006, sec. 3.3.
#pragma once

#include <string>

#include "saltus/solver/slack_program.hpp"

namespace saltus {

class RestorationProgram final : public SlackProgram {
 public:
  /// `program` must outlive this object; its data may change. Its variables come first, then p and
  /// q.
  explicit RestorationProgram(NonlinearProgram& program);

  /// Restarts with the current bounds of the program and the reference w0.
  void restart(const VectorXd& w0, double zeta) { start_from(w0, zeta); }
  static constexpr double weight = 1000.0;

  int rows() const override { return m_; }
  const VectorXd& row_lower() const override { return program_.row_lower(); }
  const VectorXd& row_upper() const override { return program_.row_upper(); }

  bool constraints(const double* w, double* g) override;

  std::string describe_variable(int i) const override;
  std::string describe_row(int i) const override { return program_.describe_row(i); }
};

}  // namespace saltus
