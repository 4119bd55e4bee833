#include "framework/qp/stage_qp.hpp"

namespace saltus {

StageQp::StageQp(const std::vector<StageCapacity>& capacity) {
  for (std::size_t k = 0; k < capacity.size(); ++k) {
    const StageCapacity& c = capacity[k];
    const int next = k + 1 < capacity.size() ? capacity[k + 1].nx : 0;
    Stage& s = stages.emplace_back();
    s.nx = c.nx;
    s.nu = c.nu;
    s.A = MatrixXd::Zero(next, c.nx);
    s.B = MatrixXd::Zero(next, c.nu);
    s.b = VectorXd::Zero(next);
    s.Q = MatrixXd::Zero(c.nx, c.nx);
    s.S = MatrixXd::Zero(c.nu, c.nx);
    s.R = MatrixXd::Zero(c.nu, c.nu);
    s.q = VectorXd::Zero(c.nx);
    s.r = VectorXd::Zero(c.nu);
    s.x_lower = VectorXd::Constant(c.nx, -infinity);
    s.x_upper = VectorXd::Constant(c.nx, infinity);
    s.u_lower = VectorXd::Constant(c.nu, -infinity);
    s.u_upper = VectorXd::Constant(c.nu, infinity);
    for (const RowGroupCapacity& g : c.groups) {
      RowGroup& group = s.groups.emplace_back();
      group.columns.reserve(g.columns);
      group.M = MatrixXd::Zero(g.rows, g.columns);
      group.lower = VectorXd::Constant(g.rows, -infinity);
      group.upper = VectorXd::Constant(g.rows, infinity);
      group.soft = g.soft;
      group.l1 = VectorXd::Zero(g.rows);
      group.l2 = VectorXd::Zero(g.rows);
    }
  }
  if (!stages.empty()) start = VectorXd::Zero(stages.front().nx);
}

StagePoint::StagePoint(const StageQp& qp) {
  for (const Stage& s : qp.stages) {
    AtStage& p = stages.emplace_back();
    p.x = p.x_bound = VectorXd::Zero(s.q.size());
    p.u = p.u_bound = VectorXd::Zero(s.r.size());
    p.costate = VectorXd::Zero(s.b.size());
    for (const RowGroup& g : s.groups) p.group.push_back(VectorXd::Zero(g.M.rows()));
  }
}

}  // namespace saltus
