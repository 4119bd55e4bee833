// A quadratic program in stages: the form in which optimal control problems are solved fastest.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::qp {

/// Rows lower <= M v[columns] <= upper of one stage, v = (x, u). Rows with equal sides are
/// equalities. A group is hard or soft as a whole. In a soft group a violation s >= 0 of a side
/// costs l1 s + l2/2 s^2, and the rows never make a problem infeasible.
///
/// Convex penalties of a violation that the rows of a stage can express:
///
///     linear, exact (L1)    l1 = w, l2 = 0
///     quadratic (L2)        l1 = 0, l2 = w
///     both, an elastic net  l1 = w, l2 = c
///     Huber: c/2 s^2 up to s = w/c, then w s - w^2/(2c). It is the minimum of c/2 a^2 + w b over
///     a + b = s, a >= 0, b >= 0. b is an additional input of the stage with bounds [0, inf) and
///     the linear cost w b; the row subtracts it (a lower side adds it). a is the violation of the
///     row with l1 = 0, l2 = c.
///
/// Penalties that are not convex, such as a saturated penalty, have no such form.
///
/// Sizes may change between solves within the capacity: the leading `rows` rows on the first
/// `columns.size()` columns are active.
struct RowGroup {
  int rows = 0;              ///< number of active rows
  std::vector<int> columns;  ///< ascending indices into v: state i is i, input i is nx + i
  MatrixXd M;                ///< coefficients, at least rows x columns
  VectorXd lower, upper;     ///< may be infinite
  bool soft = false;         ///< may be violated at a cost
  VectorXd l1, l2;           ///< penalty weights per row, read if soft; >= 0 and not both zero
};

/// One stage: state x, input u, cost 1/2 x'Qx + u'Sx + 1/2 u'Ru + q'x + r'u + constant, and the map
/// to the next state, A x + B u + b. Matrices have at least the current size and only their leading
/// parts are read. Sizes may thus change within the capacity without allocation.
struct Stage {
  int nx = 0, nu = 0;     ///< numbers of active states and inputs
  MatrixXd A, B;          ///< next nx x nx, next nx x nu; unused in the last stage
  VectorXd b;             ///< next nx
  MatrixXd Q, S, R;       ///< symmetric nx x nx; nu x nx; symmetric nu x nu
  VectorXd q, r;          ///< linear part of the cost: nx, nu
  double constant = 0.0;  ///< constant part of the cost
  VectorXd x_lower, x_upper, u_lower, u_upper;  ///< may be infinite; x bounds of a fixed start are
                                                ///< not read
  std::vector<RowGroup> groups;  ///< rows on (x, u), in groups that are hard or soft together
  /// Declares that the inputs form nu / resultant_size groups of this size that act on the next
  /// state through a common resultant, B_i = B_1 T_i with T_i invertible, and share neither cost
  /// nor rows. Solvers check the declaration and may ignore it. 0: nothing is declared.
  int resultant_size = 0;
};

/// Capacity of a stage.
struct StageCapacity {
  /// Capacity of a group of rows.
  struct RowGroup {
    int rows = 0, columns = 0;  ///< maximum sizes
    bool soft = false;          ///< may be violated at a cost
  };

  int nx = 0, nu = 0;            ///< states and inputs
  std::vector<RowGroup> groups;  ///< capacities in the order of Stage::groups
};

/// min sum_k cost_k(x_k, u_k) subject to x_(k+1) = A_k x_k + B_k u_k + b_k, k < N, and the bounds
/// and rows of every stage. The last stage N may have inputs and rows but no successor.
struct StageQp {
  /// First-order optimality residuals: largest absolute entries, zero at the optimum.
  struct Residual {
    double stationarity = 0.0;     ///< gradient of the Lagrangian
    double feasibility = 0.0;      ///< dynamics, start, hard rows and bounds
    double complementarity = 0.0;  ///< |multiplier| x distance to its side, and wrong signs
    /// The largest of the three.
    double largest() const;
  };

  std::vector<Stage> stages;  ///< N + 1 stages
  bool fixed_start = true;    ///< x_0 = start; otherwise x_0 is free within its bounds and rows
  VectorXd start;             ///< x_0 if it is fixed

  StageQp() = default;
  /// Zero cost and dynamics, no bounds, no active rows, all sizes at their capacity.
  explicit StageQp(const std::vector<StageCapacity>& capacity);

  /// Number of intervals, N.
  int intervals() const { return static_cast<int>(stages.size()) - 1; }
};

/// A primal-dual point. Multipliers are positive if the upper side of their row or bound is active,
/// negative if the lower side is. Vectors have at least the current size.
struct StagePoint {
  /// The part of the point that belongs to one stage.
  struct AtStage {
    VectorXd x, u;  ///< primal values
    /// Multiplier of x_(k+1) = A x + B u + b: derivative of the optimal cost with respect to b.
    VectorXd costate;
    VectorXd x_bound, u_bound;    ///< multipliers of the bounds
    std::vector<VectorXd> group;  ///< multipliers of the rows
  };
  std::vector<AtStage> stages;  ///< one per stage of the program

  StagePoint() = default;
  /// Zeros, sized for the capacity of the program.
  explicit StagePoint(const StageQp& qp);
};

/// Cost at the point, including penalties of violated soft rows.
double objective(const StageQp& qp, const StagePoint& point);

/// Computes the residual from the data of the program alone. Does not allocate.
StageQp::Residual kkt_residual(const StageQp& qp, const StagePoint& point);

// Interface of solvers of quadratic programs in stages.

/// A solver for programs within the capacity of the one it was made for. It does not allocate after
/// construction.
class StageQpSolver {
 public:
  virtual ~StageQpSolver() = default;
  /// `point` is the start and receives the solution. With `warm`, its multipliers are used too.
  virtual QpResult solve(const StageQp& qp, StagePoint& point, bool warm) noexcept = 0;
  /// Does the work on a program that does not need the values of its start.
  virtual void prepare(const StageQp&) noexcept {}
  /// Like solve(), for the program of the last prepare(). Only a fixed start may have changed.
  virtual QpResult solve_prepared(const StageQp& qp, StagePoint& point, bool warm) noexcept {
    return solve(qp, point, warm);
  }
  /// Later solves stop at this time; time_point::max(): no deadline.
  virtual void set_deadline(WallClock::time_point deadline) = 0;
};

// The structured real-time solver: an interior-point method whose steps are Riccati sweeps.

struct RiccatiKernel;

/// Options of the solver for quadratic programs in stages.
struct RiccatiOptions : QpOptions {
  /// True: a cold start replaces the states of the given point by a roll-out of its inputs.
  bool roll_out = false;
  /// Maximum number of active-set factorisations of a warm start, each counted as an iteration; 0
  /// disables them. They start from the active set that the multipliers indicate and succeed close
  /// to the optimum. If they fail, the interior-point method starts from the result of the first
  /// one.
  int active_set_rounds = 6;
};

/// `capacity` is a program of the largest sizes to be solved. `kernels` of fixed sizes (see
/// riccati_kernels.hpp: riccati_kernel<nx, nu, next nx>()) are used for the stages that they fit. A
/// fixed start has nx = 0 in its stage. Inputs with a common resultant count once.
std::unique_ptr<StageQpSolver> make_riccati_solver(const StageQp& capacity,
                                                   const RiccatiOptions& options = {},
                                                   std::span<const RiccatiKernel> kernels = {});

// Adapter that solves sparse programs with known stages by a stage solver.

/// Makes a stage solver for programs within the given capacity.
using MakeStageSolver = std::function<std::unique_ptr<StageQpSolver>(const StageQp&)>;

/// For programs with the patterns of `patterns`. Throws DefinitionError if the structure does not
/// fit them and names the mismatch. Values that cannot be staged (see StageFill) give the status
/// invalid_problem. Residual and violation of a result refer to the program in stages.
std::unique_ptr<QpSolver> make_sparse_solver_by_stages(const SparseQp& patterns,
                                                       StageStructure structure,
                                                       const MakeStageSolver& make);

}  // namespace saltus::qp

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using RowGroup [[deprecated("use qp::RowGroup; removed in 0.4")]] = qp::RowGroup;
/// Deprecated name.
using Stage [[deprecated("use qp::Stage; removed in 0.4")]] = qp::Stage;
/// Deprecated name.
using StageCapacity [[deprecated("use qp::StageCapacity; removed in 0.4")]] = qp::StageCapacity;
/// Deprecated name.
using StageQp [[deprecated("use qp::StageQp; removed in 0.4")]] = qp::StageQp;
/// Deprecated name.
using StagePoint [[deprecated("use qp::StagePoint; removed in 0.4")]] = qp::StagePoint;
/// Deprecated name.
using StageQpSolver [[deprecated("use qp::StageQpSolver; removed in 0.4")]] = qp::StageQpSolver;
/// Deprecated name.
using RiccatiOptions [[deprecated("use qp::RiccatiOptions; removed in 0.4")]] = qp::RiccatiOptions;
/// Deprecated name.
using MakeStageSolver [[deprecated("use qp::MakeStageSolver; removed in 0.4")]] =
    qp::MakeStageSolver;
/// Deprecated name.
using RowGroupCapacity [[deprecated("use qp::StageCapacity::RowGroup; removed in 0.4")]] =
    qp::StageCapacity::RowGroup;
/// Deprecated name.
using StageQpResidual [[deprecated("use qp::StageQp::Residual; removed in 0.4")]] =
    qp::StageQp::Residual;
using qp::make_riccati_solver;           ///< deprecated name
using qp::make_sparse_solver_by_stages;  ///< deprecated name
}  // namespace saltus
