// A program that a solver makes of another one: slacks behind its variables let rows give, and cost
// the same each; of many solutions it seeks the one near w0.
//
//     min  weight sum(s) + zeta/2 |D (w - w0)|^2,   D = 1 / max(1, |w0|),   s >= 0
//
// The rows are those of the other program, and further ones behind them, plus constant multiples of
// variables. What they are, and which bounds hold, is for who derives from it.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Objective and derivatives of such a program.
class SlackProgram : public NonlinearProgram {
 public:
  int variables() const final { return n_ + slacks_; }
  const VectorXd& lower() const final { return lower_; }
  const VectorXd& upper() const final { return upper_; }
  const SparsityPattern& jacobian_pattern() const final { return jacobian_pattern_; }
  const SparsityPattern& hessian_pattern() const final { return hessian_pattern_; }
  bool supports(Curvature curvature) const final { return program_.supports(curvature); }

  bool objective(const double* w, double& f) final;
  bool gradient(const double* w, double* gradient) final;
  bool jacobian(const double* w, double* entries) final;
  bool hessian(const double* w, double sigma, const double* lambda, double* entries,
               Curvature curvature) final;

 protected:
  /// A constant entry of the Jacobian beyond those of the other program.
  struct Constant {
    int row = 0;         ///< of this program
    int column = 0;      ///< likewise
    double value = 0.0;  ///< of the entry
  };
  /// `program` must outlive this one.
  SlackProgram(NonlinearProgram& program, int slacks, double weight);
  /// To be called once by the constructor of who derives.
  void set_pattern(int rows, const std::vector<Constant>& constants);
  /// The bounds of the other program as they are now, and what to stay near.
  void start_from(const VectorXd& w0, double zeta);

  NonlinearProgram& program_;  ///< the other program
  const int n_;                ///< its variables
  const int m_;                ///< its rows
  VectorXd lower_;             ///< of all variables; of slacks 0
  VectorXd upper_;             ///< of all variables; of slacks none

 private:
  struct Entry {
    int position = 0;
    double value = 0.0;
  };
  int slacks_;
  double weight_, zeta_ = 0.0;
  SparsityPattern jacobian_pattern_, hessian_pattern_;
  std::vector<int> jacobian_position_, hessian_position_, diagonal_position_;
  std::vector<Entry> constants_;
  std::vector<double> jacobian_entries_, hessian_entries_;
  VectorXd w0_, d_;
};

}  // namespace saltus
