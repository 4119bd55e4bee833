// The step is the solution of a quadratic program in stages without bounds:
//
//     min 1/2 dw'(H + diag(weights)) dw + rw'dw + sum_i W_i/2 (J_i dw + rr_i)^2
//     subject to   J_e dw = -re,
//
// with i the inequality rows and e the equalities. Slacks of soft rows are eliminated first. Let h
// be H plus the weight of the slack, and c its entry in the row. Then c dsigma = -(c r_sigma + c^2
// dlambda) / h, so that 1/W of the row grows by c^2 / h and its right-hand side by -c r_sigma / h.
//
// The recursion treats equality rows as penalties and eliminates the stages in a fixed order. If
// that loses too many digits, the sparse factorisation computes the step.
#include "saltus/qp/riccati_newton.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/qp/riccati_system.hpp"
#include "saltus/qp/sparse_newton.hpp"
#include "saltus/qp/stage_map.hpp"

namespace saltus::qp {
namespace {

constexpr double least_weight = 1e-20;

class RiccatiNewton final : public NewtonSystem {
 public:
  RiccatiNewton(const SparsityPattern& hessian, const SparsityPattern& rows,
                StageStructure structure, std::span<const RiccatiKernel> kernels)
      : structure_(structure),
        step_(hessian, rows),
        map_(step_, std::move(structure)),
        system_(map_.stages(), kernels),
        stage_point_(map_.stages()),
        diagonal_(VectorXd::Zero(rows.cols())),
        row_weights_(VectorXd::Zero(rows.rows())),
        condensed_(VectorXd::Zero(rows.rows())),
        start_part_(VectorXd::Zero(rows.rows())),
        soft_(rows.rows(), 0),
        is_fixed_(rows.cols(), 0) {
    const PackedQp::Capacity& most = system_.packed().capacity;
    for (AlignedArray* of_v : {&v_, &gradient_}) *of_v = AlignedArray(most.variables);
    for (AlignedArray* of_y : {&y_, &equality_}) *of_y = AlignedArray(most.equalities);
    for (AlignedArray* of_sides : {&weights_, &zero_side_}) *of_sides = AlignedArray(most.sides);
    for (int i = 0; i < rows.cols(); ++i) diagonal_slot_.push_back(hessian.find(i, i));
    for (const StageStructure::SoftRow& soft : structure_.soft_rows) {
      soft_[soft.row] = 1;
      for (const int variable : {soft.below, soft.above})
        if (variable >= 0) slacks_.push_back({soft.row, variable, rows.find(soft.row, variable)});
    }
    find_start();
    point_ = {VectorXd::Zero(rows.cols()), VectorXd::Zero(rows.rows()),
              VectorXd::Zero(rows.cols())};
  }

  void restart() override {
    if (sparse_ != nullptr) sparse_->restart();
  }

  bool load(const SparseQp& qp) override {
    if (!qp.hessian.allFinite() || !qp.rows.allFinite()) return false;
    qp_ = &qp;
    is_first_ = true;
    step_.hessian = qp.hessian;
    step_.rows = qp.rows;
    const int n = qp.variables(), m = static_cast<int>(qp.row_lower.size());
    for (int i = 0; i < n; ++i) {
      is_fixed_[i] = qp.lower[i] == qp.upper[i];
      step_.lower[i] = is_fixed_[i] ? 0.0 : -infinity;
      step_.upper[i] = is_fixed_[i] ? 0.0 : infinity;
      diagonal_[i] = qp.hessian[diagonal_slot_[i]];
    }
    for (const Slack& s : slacks_) step_.lower[s.variable] = 0.0;
    is_equality_.assign(m, 0);
    for (int i = 0; i < m; ++i) {
      is_equality_[i] = qp.row_lower[i] == qp.row_upper[i] && !soft_[i];
      step_.row_lower[i] = qp.row_lower[i] > -infinity ? -1.0 : -infinity;
      step_.row_upper[i] = qp.row_upper[i] < infinity ? 1.0 : infinity;
      if (is_equality_[i]) step_.row_lower[i] = step_.row_upper[i] = 0.0;
    }
    // Inequalities of the start enter as weights of its states; as rows they would be bounds.
    for (const int row : structure_.start_rows)
      if (!is_equality_[row]) {
        step_.row_lower[row] = -infinity;
        step_.row_upper[row] = infinity;
      }
    return true;
  }

  bool factor(const VectorXd& variable_weights, const VectorXd& row_weights) override {
    given_variable_weights_ = variable_weights;
    given_row_weights_ = row_weights;
    by_sparse_ = false;
    const bool is_first = std::exchange(is_first_, false);
    if (factor_by_stages(variable_weights, row_weights)) return true;
    // If equality rows are penalties, a negative pivot may be rounding error.
    return is_first && system_.packed().has_equality_rows && factor_sparse();
  }

  bool factor_with_fallback() override {
    return by_sparse_ ? sparse_->factor_with_fallback() : factor_sparse();
  }

  void solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) override {
    if (by_sparse_)
      sparse_->solve(rw, rr, dw, dlambda);
    else
      solve_by_stages(rw, rr, dw, dlambda);
  }

 private:
  struct Slack {
    int row, variable, entry;
  };
  struct RowEntry {
    int row, entry;
  };
  struct Start {
    int row, state, entry;
    std::vector<RowEntry> met_by;  // rows of the groups of the first stage with this state
  };

  void find_start() {
    const SparsityPattern& rows = step_.row_pattern;
    const StageStructure::Stage& first = structure_.stages.front();
    for (std::size_t i = 0; i < structure_.start_rows.size(); ++i) {
      const int row = structure_.start_rows[i], v = first.states[i];
      Start& start = start_.emplace_back(Start{row, v, rows.find(row, v), {}});
      for (const std::vector<int>& group : first.groups)
        for (const int r : group)
          if (const int e = rows.find(r, v); e >= 0) start.met_by.push_back({r, e});
    }
  }

  bool factor_sparse() {
    if (sparse_ == nullptr) sparse_ = make_sparse_newton(step_.hessian_pattern, step_.row_pattern);
    by_sparse_ =
        sparse_->load(*qp_) && (sparse_->factor(given_variable_weights_, given_row_weights_) ||
                                sparse_->factor_with_fallback());
    return by_sparse_;
  }

  bool factor_by_stages(const VectorXd& variable_weights, const VectorXd& row_weights) {
    const int n = step_.variables(), m = static_cast<int>(step_.row_lower.size());
    for (int i = 0; i < n; ++i)
      step_.hessian[diagonal_slot_[i]] = diagonal_[i] + variable_weights[i];
    slack_curvature_.resize(slacks_.size());
    for (int i = 0; i < m; ++i) condensed_[i] = 1.0 / std::max(row_weights[i], least_weight);
    for (std::size_t k = 0; k < slacks_.size(); ++k) {
      const Slack& s = slacks_[k];
      const double h = step_.hessian[diagonal_slot_[s.variable]], c = step_.rows[s.entry];
      if (!(h > 0.0)) return false;
      slack_curvature_[k] = h;
      if (!is_fixed_[s.variable]) condensed_[s.row] += c * c / h;
      step_.hessian[diagonal_slot_[s.variable]] = 0.0;
    }
    condensed_ = condensed_.cwiseInverse();
    for (const Start& s : start_) {
      if (is_equality_[s.row]) continue;
      const double c = step_.rows[s.entry];
      step_.hessian[diagonal_slot_[s.state]] += condensed_[s.row] * c * c;
    }
    step_.gradient.setZero();
    cost_slacks();
    // Rows whose variables are all fixed do not affect the step.
    if (map_.fill(step_) == StageFill::not_staged || !system_.pack(map_.stages())) return false;
    // Weights are passed as multipliers, with the sign of an existing side.
    point_.w.setZero();
    point_.z.setZero();
    for (int i = 0; i < m; ++i)
      point_.lambda[i] = is_equality_[i]                 ? 0.0
                         : step_.row_upper[i] < infinity ? condensed_[i]
                                                         : -condensed_[i];
    for (const int row : structure_.start_rows) point_.lambda[row] = 0.0;
    map_.convert(step_, point_, stage_point_);
    pack_point(map_.stages(), stage_point_, system_.packed(), true, v_.data(), y_.data(),
               weights_.data());
    system_.expect_convex(false);
    system_.set_shift(0.0);
    return system_.factor(weights_.data());
  }

  void solve_by_stages(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) {
    const int n = step_.variables(), m = static_cast<int>(step_.row_lower.size());
    const SparsityPattern& rows = step_.row_pattern;
    VectorXd& condensed_rr = row_weights_;
    condensed_rr = rr;
    for (std::size_t k = 0; k < slacks_.size(); ++k) {
      const Slack& s = slacks_[k];
      if (!is_fixed_[s.variable])
        condensed_rr[s.row] -= step_.rows[s.entry] * rw[s.variable] / slack_curvature_[k];
    }
    step_.gradient = rw;
    add_start_to(condensed_rr);
    for (int i = 0; i < m; ++i) {
      if (is_equality_[i]) {
        step_.row_lower[i] = step_.row_upper[i] = -condensed_rr[i];
        continue;
      }
      const double pull = condensed_[i] * condensed_rr[i];
      for (int e = rows.row_begin(i); e < rows.row_end(i); ++e)
        step_.gradient[rows.col(e)] += step_.rows[e] * pull;
    }
    cost_slacks();
    map_.fill(step_, false);
    system_.pack_vectors(map_.stages());
    system_.constants(gradient_.data(), equality_.data());
    system_.solve(gradient_.data(), equality_.data(), v_.data(), y_.data());
    unpack_point(map_.stages(), system_.packed(), v_.data(), y_.data(), zero_side_.data(),
                 stage_point_);
    map_.convert_part(step_, stage_point_, point_);
    dw = point_.w;
    for (int i = 0; i < n; ++i)
      if (is_fixed_[i]) dw[i] = 0.0;
    for (const Slack& s : slacks_) dw[s.variable] = 0.0;
    for (int i = 0; i < m; ++i) {
      dlambda[i] = is_equality_[i] ? point_.lambda[i] : 0.0;
      if (is_equality_[i]) continue;
      double change = condensed_rr[i] - start_part_[i];
      for (int e = rows.row_begin(i); e < rows.row_end(i); ++e)
        change += step_.rows[e] * dw[rows.col(e)];
      dlambda[i] = condensed_[i] * change;
    }
    for (std::size_t k = 0; k < slacks_.size(); ++k) {
      const Slack& s = slacks_[k];
      if (!is_fixed_[s.variable])
        dw[s.variable] =
            -(rw[s.variable] + step_.rows[s.entry] * dlambda[s.row]) / slack_curvature_[k];
    }
    give_start_multipliers(rw, dw, dlambda);
  }

  // Rows with a free violation would have no weight, so every slack gets a cost.
  void cost_slacks() {
    for (const Slack& s : slacks_) step_.gradient[s.variable] = 1.0;
  }

  // The step of a given start is known and not a variable of the recursion. Its contribution to the
  // first rows moves to their right-hand sides.
  void add_start_to(VectorXd& rr) {
    start_part_.setZero();
    if (!map_.stages().fixed_start || map_.stages().stages.size() != structure_.stages.size())
      return;
    for (const Start& s : start_) {
      const double dx = -rr[s.row] / step_.rows[s.entry];
      for (const RowEntry& of : s.met_by)
        if (!is_equality_[of.row]) start_part_[of.row] += step_.rows[of.entry] * dx;
    }
    rr += start_part_;
  }

  // The multipliers of the start balance the stationarity of its states.
  void give_start_multipliers(const VectorXd& rw, const VectorXd& dw, VectorXd& dlambda) {
    for (const int row : structure_.start_rows)
      if (is_equality_[row]) dlambda[row] = 0.0;
    VectorXd& lacking = step_.gradient;
    lacking = rw;
    step_.hessian_pattern.for_each([&](int i, int j, int e) {
      lacking[i] += step_.hessian[e] * dw[j];
      if (i != j) lacking[j] += step_.hessian[e] * dw[i];
    });
    step_.row_pattern.for_each(
        [&](int i, int j, int e) { lacking[j] += step_.rows[e] * dlambda[i]; });
    for (const Start& s : start_)
      if (is_equality_[s.row]) dlambda[s.row] = -lacking[s.state] / step_.rows[s.entry];
  }

  const SparseQp* qp_ = nullptr;
  VectorXd given_variable_weights_, given_row_weights_;
  bool is_first_ = true;  // first factor since load()
  bool by_sparse_ = false;
  std::unique_ptr<NewtonSystem> sparse_;  // created when first needed
  StageStructure structure_;
  SparseQp step_;
  StageMap map_;
  RiccatiSystem system_;
  StagePoint stage_point_;
  PrimalDualPoint point_;
  VectorXd diagonal_;     // diagonal of H
  VectorXd row_weights_;  // work space
  VectorXd condensed_;    // weights of the rows, slacks eliminated
  VectorXd start_part_;   // contribution of the step of a given start to J dw
  std::vector<char> soft_, is_fixed_, is_equality_;
  std::vector<Slack> slacks_;
  std::vector<Start> start_;
  std::vector<double> slack_curvature_;
  std::vector<int> diagonal_slot_;
  AlignedArray v_, y_, gradient_, equality_, weights_, zero_side_;
};

}  // namespace

std::unique_ptr<NewtonSystem> make_riccati_newton(const SparsityPattern& hessian,
                                                  const SparsityPattern& rows,
                                                  StageStructure structure,
                                                  std::span<const RiccatiKernel> kernels) {
  return std::make_unique<RiccatiNewton>(hessian, rows, std::move(structure), kernels);
}

}  // namespace saltus::qp
