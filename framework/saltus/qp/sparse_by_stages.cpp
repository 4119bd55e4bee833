// Converts the program to stages, solves it, and converts the solution back: see stage_map.hpp.
#include "saltus/qp/stage_qp.hpp"

#include <utility>

#include "saltus/qp/stage_map.hpp"

namespace saltus::qp {
namespace {

class StagedSolver final : public QpSolver {
 public:
  StagedSolver(const SparseQp& patterns, StageStructure structure, const MakeStageSolver& make)
      : map_(patterns, std::move(structure)), point_(map_.stages()), solver_(make(map_.stages())) {}

  QpResult solve(const SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept override {
    QpResult result;
    if (point.w.size() != qp.variables()) return result;
    const StageFill fill = map_.fill(qp);
    if (fill != StageFill::filled) {
      result.status =
          fill == StageFill::infeasible ? QpStatus::infeasible : QpStatus::invalid_problem;
      return result;
    }
    map_.convert(qp, point, point_);
    result = solver_->solve(map_.stages(), point_, warm);
    if (result.status != QpStatus::invalid_problem) map_.convert(qp, point_, point);
    return result;
  }
  void set_deadline(WallClock::time_point deadline) override { solver_->set_deadline(deadline); }
  std::string name() const override { return "stages"; }

 private:
  StageMap map_;
  StagePoint point_;
  std::unique_ptr<StageQpSolver> solver_;
};

}  // namespace

std::unique_ptr<QpSolver> make_sparse_solver_by_stages(const SparseQp& patterns,
                                                       StageStructure structure,
                                                       const MakeStageSolver& make) {
  return std::make_unique<StagedSolver>(patterns, std::move(structure), make);
}

}  // namespace saltus::qp
