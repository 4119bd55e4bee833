#include "framework/qp/riccati_solver.hpp"

#include "framework/qp/interior_point.hpp"
#include "framework/qp/riccati_system.hpp"

namespace saltus {
namespace {

class RiccatiSolver final : public StageQpSolver {
 public:
  RiccatiSolver(const StageQp& capacity, const RiccatiOptions& options,
                std::span<const qp::RiccatiKernel> kernels)
      : options_(options),
        system_(capacity, kernels),
        method_(system_.max_variables(), system_.max_equalities(), system_.max_sides()) {}

  QpResult solve(const StageQp& qp, StagePoint& point, bool warm) noexcept override {
    QpResult result;
    if (!system_.pack(qp)) return result;
    if (system_.contradicts_itself()) {
      result.status = QpStatus::infeasible;
      return result;
    }
    qp::Iterate& iterate = method_.point();
    system_.pack_point(qp, point, warm, iterate.v.data(), iterate.y.data(), iterate.lambda.data());
    if (!warm && options_.roll_out) system_.roll_out(iterate.v.data());
    result = method_.solve(system_, options_, deadline_, warm);
    system_.unpack_point(qp, iterate.v.data(), iterate.y.data(), iterate.lambda.data(), point);
    result.objective = objective(qp, point);
    // At an optimum the method has seen them; on its way there it may have taken them for granted.
    if (result.status != QpStatus::optimal) {
      const StageQpResidual residual = kkt_residual(qp, point);
      result.residual = residual.largest();
      result.violation = residual.feasibility;
    }
    return result;
  }

  void set_deadline(QpClock::time_point deadline) override { deadline_ = deadline; }

 private:
  RiccatiOptions options_;
  qp::RiccatiSystem system_;
  qp::InteriorPoint<qp::RiccatiSystem> method_;
  QpClock::time_point deadline_ = QpClock::time_point::max();
};

}  // namespace

std::unique_ptr<StageQpSolver> make_riccati_solver(const StageQp& capacity,
                                                   const RiccatiOptions& options,
                                                   std::span<const qp::RiccatiKernel> kernels) {
  return std::make_unique<RiccatiSolver>(capacity, options, kernels);
}

}  // namespace saltus
