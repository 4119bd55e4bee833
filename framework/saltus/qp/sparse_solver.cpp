#include "saltus/qp/sparse_qp.hpp"

#include <algorithm>

#include "saltus/qp/interior_point.hpp"
#include "saltus/qp/sparse_system.hpp"

namespace saltus::qp {
namespace {

class SparseQpSolver : public QpSolver {
 public:
  SparseQpSolver(const SparsityPattern& hessian, const SparsityPattern& rows,
                 const QpOptions& options)
      : options_(options),
        system_(hessian, rows),
        method_(system_.max_variables(), system_.max_equalities(), system_.max_sides()) {}

  QpResult solve(const SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept override {
    if (!system_.load(qp) || point.w.size() != qp.variables() || !point.w.allFinite()) return {};
    Iterate& iterate = method_.point();
    system_.load_point(point, iterate.v.data(), iterate.y.data(), iterate.lambda.data());
    // In the units of the system. For large costs the last digits exceed double precision.
    QpOptions options = options_;
    options.tolerance =
        std::max(options_.tolerance / system_.cost_unit(), std::min(options_.tolerance, finest));
    options.warm_barrier = std::max(options_.warm_barrier, warm_barrier) / system_.cost_unit();
    QpResult result = method_.solve(system_, options, deadline_, warm);
    system_.unload_point(qp, iterate.v.data(), iterate.y.data(), iterate.lambda.data(), point);
    const SparseQp::Residual residual = kkt_residual(qp, point);
    result.objective = objective(qp, point.w);
    result.residual = residual.largest();
    result.violation = residual.feasibility;
    return result;
  }
  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }
  std::string name() const override { return "sparse"; }

 private:
  static constexpr double finest = 1e-12;
  // For rows of any unit and size. With less, warm starts took more iterations than cold ones in
  // the live schedule.
  static constexpr double warm_barrier = 3e-3;

  QpOptions options_;
  SparseSystem system_;
  InteriorPoint<SparseSystem> method_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
};

}  // namespace

std::unique_ptr<QpSolver> make_sparse_qp_solver(const SparsityPattern& hessian,
                                                const SparsityPattern& rows,
                                                const QpOptions& options) {
  return std::make_unique<SparseQpSolver>(hessian, rows, options);
}

}  // namespace saltus::qp
