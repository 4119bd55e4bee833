// A program derived from another one. Slacks behind its variables relax the rows at equal cost, and
// a quadratic term selects the solution near w0:
//
//     min  weight sum(s) + zeta/2 |D (w - w0)|^2,   D = 1 / max(1, |w0|),   s >= 0
//
// The rows are those of the other program, and further ones behind them, plus constant multiples of
// variables. Derived classes define these rows and the active bounds.
#pragma once

#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Objective and derivatives of a program with slacks.
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
  /// A constant entry of the Jacobian in addition to those of the other program.
  struct Constant {
    int row = 0;         ///< row of this program
    int column = 0;      ///< column of this program
    double value = 0.0;  ///< value of the entry
  };
  /// `program` must outlive this object.
  SlackProgram(NonlinearProgram& program, int slacks, double weight);
  /// Must be called once by the constructor of a derived class.
  void set_pattern(int rows, const std::vector<Constant>& constants);
  /// Copies the current bounds of the other program and sets the reference w0.
  void start_from(const VectorXd& w0, double zeta);

  NonlinearProgram& program_;  ///< the other program
  const int n_;                ///< its number of variables
  const int m_;                ///< its number of rows
  VectorXd lower_;             ///< lower bounds of all variables; slacks: 0
  VectorXd upper_;             ///< upper bounds of all variables; slacks: infinite

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
