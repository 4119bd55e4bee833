#include "saltus/solver/native_solver.hpp"

#include "saltus/qp/riccati_newton.hpp"
#include "saltus/qp/sparse_newton.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus {

QpMethod sparse_qp() {
  return {[](const NonlinearProgram&, const SparsityPattern& hessian, const SparsityPattern& rows,
             const qp::QpOptions& options) {
            return qp::make_sparse_qp_solver(hessian, rows, options);
          },
          [](const NonlinearProgram&, const SparsityPattern& hessian, const SparsityPattern& rows) {
            return qp::make_sparse_newton(hessian, rows);
          }};
}

QpMethod riccati_qp(qp::RiccatiOptions options, std::span<const qp::RiccatiKernel> kernels) {
  QpMethod method{
      [options, kernels](const NonlinearProgram& program, const SparsityPattern& hessian,
                         const SparsityPattern& rows, const qp::QpOptions& asked) {
        qp::RiccatiOptions all = options;
        all.tolerance = asked.tolerance;
        all.max_iterations = asked.max_iterations;
        all.convex = asked.convex;
        return qp::make_sparse_solver_by_stages(qp::SparseQp(hessian, rows), program.stages(),
                                                [all, kernels](const qp::StageQp& capacity) {
                                                  return qp::make_riccati_solver(capacity, all,
                                                                                 kernels);
                                                });
      },
      [kernels](const NonlinearProgram& program, const SparsityPattern& hessian,
                const SparsityPattern& rows) {
        return qp::make_riccati_newton(hessian, rows, program.stages(), kernels);
      }};
  method.by_stages = true;
  return method;
}

}  // namespace saltus
