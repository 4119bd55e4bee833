// One run of the barrier method from a start to its termination. It solves
//
//     min f(w) - mu sum log(distances to the sides)   subject to   g_e(w) = b,  g_i(w) - s = 0
//
// for a decreasing sequence of barrier parameters mu. Each linearisation gives one Newton step on
// the primal-dual equations. The step is cut to stay inside the bounds and shortened until a filter
// of violation and barrier cost accepts it. Second-order corrections and a watchdog avoid short
// steps. If no step is accepted, a restoration phase reduces the violation
// (restoration_program.hpp).
//
// The constants are those of Waechter and Biegler, On the implementation of an interior-point
// filter line-search algorithm for large-scale nonlinear programming, Math. Program. 106, 2006.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/solver/barrier_step.hpp"
#include "saltus/solver/cycle_watch.hpp"
#include "saltus/solver/filter.hpp"
#include "saltus/solver/restoration_program.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Data that depend only on the patterns and are kept between runs.
struct BarrierEngine {
  BarrierEngine(const NonlinearProgram& program, std::unique_ptr<qp::NewtonSystem> newton);
  /// Hessian pattern with the whole diagonal, as Newton systems require.
  static SparsityPattern full_hessian(const NonlinearProgram& program);

  qp::SparseQp qp;              ///< H and J of the last evaluation, and the sides of the program
  std::vector<int> position;    ///< positions of the program's Hessian entries
  std::vector<double> hessian;  ///< Hessian entries in the program's pattern
  std::unique_ptr<qp::NewtonSystem> newton;
  std::unique_ptr<BarrierEngine> restoration;  ///< created when first needed
};

class BarrierRun;

struct BarrierOptions {
  double tolerance = 1e-8;  ///< scaled KKT error
  int max_iterations = 500;
  WallClock::time_point deadline = WallClock::time_point::max();
  double first_barrier = 0.1;
  double push = 1e-2;       ///< relative distance to which the start is moved away from its sides
  bool is_central = false;  ///< true: initial side multipliers are mu / distance, not 1
  bool can_restore = true;
  /// Called after each step with w and the slacks of the rows; true ends the run.
  std::function<bool(const VectorXd& w, const VectorXd& slacks)> suffices = {};
  std::function<void(const BarrierRun&)> report = {};
  const SolveObserver* observer = nullptr;  ///< must outlive the run; null: none
  int first_number = 0;                     ///< number of the first iteration that it reports
};

class BarrierRun {
 public:
  BarrierRun(NonlinearProgram& program, Curvature curvature, BarrierEngine& engine,
             BarrierOptions options);

  SolveStatus solve(const NlpPoint& start);
  /// The last iterate, or the best one if progress stopped.
  NlpPoint point() const;
  VectorXd slacks() const { return now_.x.tail(m_); }
  int iterations() const { return iterations_; }
  std::string describe() const;

 private:
  // Variables w, then slacks s of the inequality rows.
  struct Trial {
    VectorXd x;
    VectorXd rows;  ///< residuals
    double cost = 0.0, violation = 0.0, barrier_cost = 0.0;
  };
  // Values against which progress is measured.
  struct Reference {
    double violation = 0.0, barrier_cost = 0.0, slope = 0.0;
  };
  // Watchdog: full steps that are not yet accepted, and the iterate to return to.
  struct Watch {
    bool active = false;
    int trials = 0;
    Trial now;
    VectorXd lambda, z_lower, z_upper, dx, dlambda, dz_lower, dz_upper;
    Reference from;
    double longest = 1.0;
  };

  // The iterate with the smallest error that meets the looser tolerance.
  struct Best {
    double error = infinity;
    int iteration = 0;
    Trial now;
    VectorXd lambda, z_lower, z_upper, stationarity;
  };

  SolveObserver::Iteration iteration() const;
  bool timed_out() const { return WallClock::now() >= options_.deadline; }
  bool begin(const NlpPoint& start);
  void relax_rows();
  double bound_room_of(int i, double bound) const;
  void relax_bounds();
  bool tighten_bounds();
  void push_inside(int first, int last, VectorXd& x) const;
  VectorXd estimate_multipliers(double most);
  void shrink_multipliers();
  double barrier_cost(const VectorXd& x, double cost) const;
  double barrier_slope(int i) const;
  bool evaluate(Trial& trial);
  bool linearise();
  void compute_stationarity();
  double error(double mu) const;
  double least_barrier() const;
  void lower_barrier();
  bool compute_step(const VectorXd& rows);
  bool solve_or_correct(const VectorXd& rows);
  bool solve_step(const VectorXd& rows, VectorXd& dx, VectorXd& dlambda);
  double longest_step(const VectorXd& x, const VectorXd& dx, double most = 1.0) const;
  double longest_dual_step() const;
  double slope() const;
  bool is_cost_step(const Reference& from, double alpha) const;
  bool has_sufficient_decrease(const Reference& from, const Trial& trial, double alpha) const;
  bool is_acceptable(const Reference& from, const Trial& trial, double alpha) const;
  bool search();
  void restore_watchdog();
  void lengthen(const Reference& from);
  bool correct_second_order(const Reference& from, double alpha);
  void add_to_filter(const Reference& from);
  void accept(Trial& trial, double alpha, double dual_alpha);
  SolveStatus restore();
  void keep_inside(VectorXd& x) const;
  void keep(double error);
  bool return_to_best();

  static constexpr int watch_after_ = 4, watch_steps = 3;

  NonlinearProgram& program_;
  Curvature curvature_;
  BarrierEngine& engine_;
  BarrierOptions options_;
  BarrierStep step_;
  int n_, m_;
  enum class Row : char { free, equality, inequality };
  std::vector<Row> row_kind_;
  VectorXd lower_, upper_;  // sides of (w, s); infinite if there is none
  VectorXd lambda_, z_lower_, z_upper_;
  VectorXd gradient_, stationarity_;
  VectorXd dx_, dlambda_, dz_lower_, dz_upper_;
  VectorXd weights_, weights_work_, row_weights_, rw_, rs_, rr_;
  Trial now_, trial_;
  Filter filter_;
  Watch watch_;
  CycleWatch cycle_;  // watches the iterates at one barrier parameter
  Best best_;
  double mu_ = 0.1, tau_ = 0.99;
  double least_violation_ = 0.0, largest_violation_ = 0.0;
  double alpha_ = 0.0, dual_alpha_ = 0.0;
  int iterations_ = 0;
  int shortened_ = 0;   // consecutive shortened steps
  int tiny_ = 0;        // consecutive steps of the size of rounding
  int acceptable_ = 0;  // consecutive points that meet the looser tolerance
  bool evaluation_failed_ = false, was_restored_ = false;
};

}  // namespace saltus
