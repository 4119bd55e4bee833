#include "saltus/ocp/cost_functions.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "saltus/core/workspace_pool.hpp"

namespace saltus {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

void append(Pairs& pairs, const SparsityPattern& pattern) {
  pattern.for_each([&](int r, int c, int) { pairs.emplace_back(r, c); });
}

// Index in `whole` of every entry of `part`, a sub-pattern with the same coordinates.
std::vector<int> positions(const SparsityPattern& part, const SparsityPattern& whole) {
  std::vector<int> result(part.entries());
  part.for_each([&](int r, int c, int e) { result[e] = whole.find(r, c); });
  return result;
}

class LeastSquares final : public FunctionBody {
 public:
  LeastSquares(const Function& residual, const MatrixXd& weight, const Reference& reference,
               detail::Lending lending = detail::Lending::shared)
      : FunctionBody(residual.inputs(), 1),
        residual_(residual),
        weight_(weight),
        reference_(reference),
        workspaces_(lending) {
    Pairs rows;
    append(rows, residual.jacobian_pattern());
    if (reference.varies())
      for (int i = 0; i < residual.outputs(); ++i) rows.emplace_back(i, 0);
    shifted_ = SparsityPattern::from_pairs(residual.outputs(), inputs(), rows);
    to_shifted_ = positions(residual.jacobian_pattern(), shifted_);

    Pairs gradient, hessian;
    append(hessian, residual.hessian_pattern());
    for_each_product([&](int i, int j, int ei, int ej) {
      (void)i, (void)j;
      gradient.emplace_back(0, shifted_.col(ei));
      gradient.emplace_back(0, shifted_.col(ej));
      hessian.emplace_back(shifted_.col(ei), shifted_.col(ej));
    });
    jacobian_pattern_ = SparsityPattern::from_pairs(1, inputs(), gradient);
    hessian_pattern_ = SparsityPattern::from_pairs(inputs(), inputs(), hessian);
    to_hessian_ = positions(residual.hessian_pattern(), hessian_pattern_);
    for_each_product([&](int i, int j, int ei, int ej) {
      products_.push_back(
          {ei, ej, hessian_pattern_.find(shifted_.col(ei), shifted_.col(ej)), weight_(i, j)});
    });
    workspaces_.add(new_workspace());
  }

  bool is_reentrant() const override { return residual_.is_reentrant() && workspaces_.is_shared(); }

  int degree(int, const std::vector<char>& variable) const override {
    if (reference_.varies() && variable[0]) return 3;
    int most = 0;
    for (int i = 0; i < residual_.outputs(); ++i)
      most = std::max(most, residual_.degree(i, variable));
    return most > 1 ? 3 : 2 * most;
  }

  std::shared_ptr<const FunctionBody> separate() const override {
    const Function residual = residual_.separate();
    return residual ? std::make_shared<LeastSquares>(residual, weight_, reference_,
                                                     detail::Lending::exclusive)
                    : nullptr;
  }

  void value(const double* z, double* y) const override {
    const Pool::Loan s = lend();
    residual_.value(z, s->r.data());
    shift(z, s->r);
    s->weighted.noalias() = weight_ * s->r;
    y[0] = 0.5 * s->r.dot(s->weighted);
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    const Pool::Loan s = lend();
    evaluate_residual(z, *s);
    y[0] = 0.5 * s->r.dot(s->weighted);
    std::fill_n(entries, jacobian_pattern_.entries(), 0.0);
    shifted_.for_each([&](int i, int col, int e) {
      const int position = jacobian_pattern_.find(0, col);
      if (position >= 0) entries[position] += s->weighted[i] * s->shifted[e];
    });
  }

  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    const Pool::Loan s = lend();
    evaluate_residual(z, *s);
    std::fill_n(entries, hessian_pattern_.entries(), 0.0);
    for (const Product& p : products_)
      entries[p.position] += weights[0] * p.weight * s->shifted[p.ei] * s->shifted[p.ej];
    if (curvature == Curvature::gauss_newton || s->curvature.empty()) return;
    s->weighted *= weights[0];
    residual_.hessian(z, s->weighted.data(), s->curvature.data(), curvature);
    for (std::size_t e = 0; e < s->curvature.size(); ++e)
      entries[to_hessian_[e]] += s->curvature[e];
  }

 private:
  struct Workspace {
    VectorXd r, weighted;  // r - ref(t), W (r - ref(t))
    // Jacobians of r and of r - ref(t), and second derivatives of r.
    std::vector<double> entries, shifted, curvature;
  };
  using Pool = detail::WorkspacePool<Workspace>;

  std::unique_ptr<Workspace> new_workspace() const {
    const int m = residual_.outputs();
    return std::make_unique<Workspace>(Workspace{
        VectorXd(m), VectorXd(m), std::vector<double>(residual_.jacobian_pattern().entries()),
        std::vector<double>(shifted_.entries()),
        std::vector<double>(residual_.hessian_pattern().entries())});
  }
  Pool::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }

  // A product W(i, j) r_i' r_j' of the lower triangle, with entries of the rows of the shifted
  // residual.
  struct Product {
    int ei, ej, position;
    double weight;
  };

  template <class Visit>
  void for_each_product(Visit&& visit) const {
    for (int i = 0; i < shifted_.rows(); ++i)
      for (int j = 0; j < shifted_.rows(); ++j) {
        if (weight_(i, j) == 0.0) continue;
        for (int ei = shifted_.row_begin(i); ei < shifted_.row_end(i); ++ei)
          for (int ej = shifted_.row_begin(j); ej < shifted_.row_end(j); ++ej)
            if (shifted_.col(ei) >= shifted_.col(ej)) visit(i, j, ei, ej);
      }
  }

  void shift(const double* z, VectorXd& r) const {
    if (reference_.is_zero()) return;
    for (int i = 0; i < r.size(); ++i) r[i] -= reference_.at(z[0], i);
  }

  void evaluate_residual(const double* z, Workspace& s) const {
    residual_.jacobian(z, s.r.data(), s.entries.data());
    shift(z, s.r);
    s.weighted.noalias() = weight_ * s.r;
    std::fill(s.shifted.begin(), s.shifted.end(), 0.0);
    for (std::size_t e = 0; e < s.entries.size(); ++e) s.shifted[to_shifted_[e]] = s.entries[e];
    if (reference_.varies())
      for (int i = 0; i < s.r.size(); ++i)
        s.shifted[shifted_.find(i, 0)] -= reference_.rate(z[0], i);
  }

  Function residual_;
  MatrixXd weight_;
  Reference reference_;
  SparsityPattern shifted_;  // Jacobian of r - ref(t)
  std::vector<int> to_shifted_, to_hessian_;
  std::vector<Product> products_;
  Pool workspaces_;
};

class Stack final : public FunctionBody {
 public:
  // A null `wanted` evaluates all functions.
  explicit Stack(const std::vector<Function>& functions,
                 std::shared_ptr<const std::vector<char>> wanted = nullptr,
                 detail::Lending lending = detail::Lending::shared)
      : FunctionBody(functions.front().inputs(), count_outputs(functions)),
        functions_(functions),
        wanted_(std::move(wanted)),
        max_curvature_entries_(most_curvature(functions)),
        workspaces_(lending) {
    Pairs rows, hessian;
    int first_row = 0;
    for (const Function& f : functions_) {
      f.jacobian_pattern().for_each(
          [&](int r, int c, int) { rows.emplace_back(first_row + r, c); });
      append(hessian, f.hessian_pattern());
      first_row += f.outputs();
    }
    jacobian_pattern_ = SparsityPattern::from_pairs(outputs(), inputs(), rows);
    hessian_pattern_ = SparsityPattern::from_pairs(inputs(), inputs(), hessian);
    for (const Function& f : functions_)
      to_hessian_.push_back(positions(f.hessian_pattern(), hessian_pattern_));
    workspaces_.add(new_workspace());
  }

  bool is_reentrant() const override {
    return !wanted_ && workspaces_.is_shared() &&
           std::all_of(functions_.begin(), functions_.end(),
                       [](const Function& f) { return f.is_reentrant(); });
  }

  int degree(int output, const std::vector<char>& variable) const override {
    for (const Function& f : functions_) {
      if (output < f.outputs()) return f.degree(output, variable);
      output -= f.outputs();
    }
    return 3;
  }

  std::shared_ptr<const FunctionBody> separate() const override {
    std::vector<Function> parts;
    for (const Function& f : functions_) {
      parts.push_back(f.separate());
      if (!parts.back()) return nullptr;
    }
    return std::make_shared<Stack>(parts, wanted_, detail::Lending::exclusive);
  }

  void value(const double* z, double* y) const override {
    for (std::size_t i = 0; i < functions_.size(); ++i) {
      const Function& f = functions_[i];
      if (is_wanted(i))
        f.value(z, y);
      else
        std::fill_n(y, f.outputs(), 0.0);
      y += f.outputs();
    }
  }

  // Rows are concatenated, so their entries are too.
  void jacobian(const double* z, double* y, double* entries) const override {
    for (std::size_t i = 0; i < functions_.size(); ++i) {
      const Function& f = functions_[i];
      const int count = f.jacobian_pattern().entries();
      if (is_wanted(i)) {
        f.jacobian(z, y, entries);
      } else {
        std::fill_n(y, f.outputs(), 0.0);
        std::fill_n(entries, count, 0.0);
      }
      y += f.outputs();
      entries += count;
    }
  }

  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    std::fill_n(entries, hessian_pattern_.entries(), 0.0);
    const auto part = workspaces_.lend([this] { return new_workspace(); });
    for (std::size_t i = 0; i < functions_.size(); ++i) {
      if (is_wanted(i)) {
        functions_[i].hessian(z, weights, part->data(), curvature);
        for (std::size_t e = 0; e < to_hessian_[i].size(); ++e)
          entries[to_hessian_[i][e]] += (*part)[e];
      }
      weights += functions_[i].outputs();
    }
  }

 private:
  static int count_outputs(const std::vector<Function>& functions) {
    int n = 0;
    for (const Function& f : functions) n += f.outputs();
    return n;
  }

  static int most_curvature(const std::vector<Function>& functions) {
    int most = 0;
    for (const Function& f : functions) most = std::max(most, f.hessian_pattern().entries());
    return most;
  }

  using Workspace = std::vector<double>;  // second derivatives of one part
  std::unique_ptr<Workspace> new_workspace() const {
    return std::make_unique<Workspace>(max_curvature_entries_);
  }
  bool is_wanted(std::size_t i) const { return !wanted_ || (*wanted_)[i] != 0; }

  std::vector<Function> functions_;
  std::shared_ptr<const std::vector<char>> wanted_;
  std::vector<std::vector<int>> to_hessian_;
  int max_curvature_entries_;  // largest number of second derivatives of a part
  detail::WorkspacePool<Workspace> workspaces_;
};

class TimesLength final : public FunctionBody {
 public:
  explicit TimesLength(const Function& cost) : FunctionBody(cost.inputs() + 1, 1), cost_(cost) {
    const int h = cost.inputs();
    Pairs gradient, hessian;
    append(gradient, cost.jacobian_pattern());
    append(hessian, cost.hessian_pattern());
    for (int e = 0; e < cost.jacobian_pattern().entries(); ++e)
      hessian.emplace_back(h, cost.jacobian_pattern().col(e));
    gradient.emplace_back(0, h);
    jacobian_pattern_ = SparsityPattern::from_pairs(1, inputs(), gradient);
    hessian_pattern_ = SparsityPattern::from_pairs(inputs(), inputs(), hessian);
  }

  bool is_reentrant() const override { return cost_.is_reentrant(); }

  int degree(int, const std::vector<char>& variable) const override {
    const std::vector<char> of_cost(variable.begin(), variable.end() - 1);
    return std::min(3, cost_.degree(0, of_cost) + (variable.back() ? 1 : 0));
  }

  std::shared_ptr<const FunctionBody> separate() const override {
    const Function cost = cost_.separate();
    return cost ? std::make_shared<TimesLength>(cost) : nullptr;
  }

  void value(const double* z, double* y) const override {
    cost_.value(z, y);
    y[0] *= z[cost_.inputs()];
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    const double h = z[cost_.inputs()];
    cost_.jacobian(z, y, entries);
    const int n = cost_.jacobian_pattern().entries();
    for (int e = 0; e < n; ++e) entries[e] *= h;
    entries[n] = y[0];  // h is the last argument
    y[0] *= h;
  }

  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    const double weight = weights[0] * z[cost_.inputs()];
    cost_.hessian(z, &weight, entries, curvature);  // the row of h is the last
    double y;
    double* row = entries + cost_.hessian_pattern().entries();
    cost_.jacobian(z, &y, row);
    for (int e = 0; e < cost_.jacobian_pattern().entries(); ++e) row[e] *= weights[0];
  }

 private:
  Function cost_;
};

class ChangeCosts final : public FunctionBody {
 public:
  explicit ChangeCosts(VectorXd weights)
      : FunctionBody(2 * static_cast<int>(weights.size()), static_cast<int>(weights.size())),
        weights_(std::move(weights)) {
    const int n = outputs();
    Pairs gradient, hessian;
    for (int i = 0; i < n; ++i) {
      if (weights_[i] == 0.0) continue;
      gradient.insert(gradient.end(), {{i, i}, {i, n + i}});
      hessian.insert(hessian.end(), {{i, i}, {n + i, i}, {n + i, n + i}});
    }
    jacobian_pattern_ = SparsityPattern::from_pairs(n, inputs(), gradient);
    hessian_pattern_ = SparsityPattern::from_pairs(inputs(), inputs(), hessian);
  }

  int degree(int, const std::vector<char>&) const override { return 2; }
  bool is_reentrant() const override { return true; }

  void value(const double* z, double* y) const override {
    for (int i = 0; i < outputs(); ++i) y[i] = 0.5 * weights_[i] * change(z, i) * change(z, i);
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    value(z, y);
    jacobian_pattern_.for_each([&](int i, int col, int e) {
      entries[e] = (col < outputs() ? -1.0 : 1.0) * weights_[i] * change(z, i);
    });
  }

  void hessian(const double*, const double* weights, double* entries, Curvature) const override {
    hessian_pattern_.for_each([&](int row, int col, int e) {
      const int i = row % outputs();
      entries[e] = (row == col ? 1.0 : -1.0) * weights[i] * weights_[i];
    });
  }

 private:
  double change(const double* z, int i) const { return z[outputs() + i] - z[i]; }
  VectorXd weights_;
};

}  // namespace

Function least_squares_cost(const Function& residual, const MatrixXd& weight,
                            const Reference& reference) {
  return Function(std::make_shared<LeastSquares>(residual, weight, reference));
}

Function stack(const std::vector<Function>& functions) {
  return Function(std::make_shared<Stack>(functions));
}

SelectiveStack::SelectiveStack(std::vector<Function> parts)
    : parts_(std::move(parts)),
      wanted_(std::make_shared<std::vector<char>>(parts_.size(), 1)),
      function_(std::make_shared<Stack>(parts_, wanted_)) {}

SelectiveStack SelectiveStack::separate() const {
  std::vector<Function> parts;
  for (const Function& f : parts_) {
    parts.push_back(f.separate());
    if (!parts.back()) return {};
  }
  return SelectiveStack(std::move(parts));
}

Function times_length(const Function& cost) {
  return Function(std::make_shared<TimesLength>(cost));
}

Function change_costs(const VectorXd& weights) {
  return Function(std::make_shared<ChangeCosts>(weights));
}

Function cost_function(const Term& term) {
  return term.kind == Term::Kind::least_squares
             ? least_squares_cost(term.function, term.weight, term.reference)
             : term.function;
}

}  // namespace saltus
