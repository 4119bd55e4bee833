#include "saltus/qp/stage_qp.hpp"

#include <cmath>

#include "saltus/qp/interior_point.hpp"
#include "saltus/qp/riccati_system.hpp"

namespace saltus::qp {
namespace {

bool is_finite(const Stage& s, int next) {
  const int nx = s.nx, nu = s.nu;
  if (next > 0 && !(s.A.topLeftCorner(next, nx).allFinite() &&
                    s.B.topLeftCorner(next, nu).allFinite() && s.b.head(next).allFinite()))
    return false;
  for (const RowGroup& g : s.groups) {
    if (!g.M.topLeftCorner(g.rows, static_cast<int>(g.columns.size())).allFinite()) return false;
    if (g.soft && !(g.l1.head(g.rows).allFinite() && g.l2.head(g.rows).allFinite())) return false;
  }
  return s.Q.topLeftCorner(nx, nx).allFinite() && s.S.topLeftCorner(nu, nx).allFinite() &&
         s.R.topLeftCorner(nu, nu).allFinite() && s.q.head(nx).allFinite() &&
         s.r.head(nu).allFinite() && std::isfinite(s.constant);
}

bool is_finite(const StageQp& qp) {
  const int stages = static_cast<int>(qp.stages.size());
  for (int k = 0; k < stages; ++k)
    if (!is_finite(qp.stages[k], k + 1 < stages ? qp.stages[k + 1].nx : 0)) return false;
  return !qp.fixed_start || qp.start.head(qp.stages.front().nx).allFinite();
}

class RiccatiSolver final : public StageQpSolver {
 public:
  RiccatiSolver(const StageQp& capacity, const RiccatiOptions& options,
                std::span<const RiccatiKernel> kernels)
      : options_(options),
        system_(capacity, kernels),
        method_(system_.packed().capacity.variables, system_.packed().capacity.equalities,
                system_.packed().capacity.sides, options.active_set_rounds) {}

  QpResult solve(const StageQp& qp, StagePoint& point, bool warm) noexcept override {
    prepare(qp);
    return is_valid_ ? solve_packed(qp, point, warm) : QpResult{};
  }

  void prepare(const StageQp& qp) noexcept override { is_valid_ = system_.pack(qp); }

  QpResult solve_prepared(const StageQp& qp, StagePoint& point, bool warm) noexcept override {
    // The contradiction may have come from the start, which has changed.
    if (!is_valid_ || system_.packed().contradiction) return solve(qp, point, warm);
    system_.pack_start(qp);
    return solve_packed(qp, point, warm);
  }

  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }

 private:
  QpResult solve_packed(const StageQp& qp, StagePoint& point, bool warm) {
    QpResult result;
    if (system_.packed().contradiction) {
      result.status = QpStatus::infeasible;
      return result;
    }
    Iterate& iterate = method_.point();
    pack_point(qp, point, system_.packed(), warm, iterate.v.data(), iterate.y.data(),
               iterate.lambda.data());
    if (!warm && options_.roll_out) system_.roll_out(iterate.v.data());
    result = method_.solve(system_, options_, deadline_, warm);
    unpack_point(qp, system_.packed(), iterate.v.data(), iterate.y.data(), iterate.lambda.data(),
                 point);
    result.objective = objective(qp, point);
    // Checks for non-finite data only if there is no optimum.
    if ((result.status != QpStatus::optimal || !std::isfinite(result.objective)) && !is_finite(qp))
      result.status = QpStatus::invalid_problem;
    // An optimum has evaluated residuals; other iterates may have extrapolated ones.
    if (result.status != QpStatus::optimal) {
      const StageQp::Residual residual = kkt_residual(qp, point);
      result.residual = residual.largest();
      result.violation = residual.feasibility;
    }
    return result;
  }

  RiccatiOptions options_;
  RiccatiSystem system_;
  InteriorPoint<RiccatiSystem> method_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
  bool is_valid_ = false;  // result of the last pack()
};

}  // namespace

std::unique_ptr<StageQpSolver> make_riccati_solver(const StageQp& capacity,
                                                   const RiccatiOptions& options,
                                                   std::span<const RiccatiKernel> kernels) {
  return std::make_unique<RiccatiSolver>(capacity, options, kernels);
}

}  // namespace saltus::qp
