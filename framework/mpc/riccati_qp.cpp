#include "saltus/mpc/riccati_qp.hpp"

#include <utility>

#include "saltus/qp/sparse_by_stages.hpp"

namespace saltus {

QpSolverFactory riccati_qp_solver(const MultipleShooting& shooting, RiccatiOptions options,
                                  std::span<const qp::RiccatiKernel> kernels) {
  return [structure = shooting.stages(), options, kernels](
             const SparsityPattern& hessian, const SparsityPattern& rows, const QpOptions& asked) {
    RiccatiOptions all = options;
    all.tolerance = asked.tolerance;
    all.max_iterations = asked.max_iterations;
    all.convex = asked.convex;
    return make_sparse_solver_by_stages(SparseQp(hessian, rows), structure,
                                        [all, kernels](const StageQp& capacity) {
                                          return make_riccati_solver(capacity, all, kernels);
                                        });
  };
}

}  // namespace saltus
