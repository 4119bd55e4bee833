// Let xi = (x | u | delta | 1) with delta = c1 - c0 for linear inputs (absent for constant ones).
// The interval in scaled time s in [0, 1] is linear and autonomous:
//        [ hA  hB  0  ha ]
//   M =  [  0   0  I   0 ]      xi(0) = v = (x0 | c0 | c1 - c0 | 1)
//        [  0   0  0   0 ]
//        [  0   0  0   0 ]
// x(h) = T v, where T is the first nx rows of exp(M). L = xi' Q xi with Q from value, gradient and
// Hessian of the cost at the origin; q = v' G v, G = int exp(Ms)' hQ exp(Ms) ds. affine_flow.hpp
// has the exponential; see also framework/design/integrators.md.
#include "saltus/integrators/zero_order_hold.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/affine_flow.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {
namespace {

constexpr int cached_discretisations = 4;  // two for a split interval and two for whole intervals

std::string entry_name(const Arguments& sizes, int i) {
  if (i == sizes.t()) return "t";
  if (i < sizes.u()) return fmt::format("x[{}]", i - sizes.x());
  if (i < sizes.p()) return fmt::format("u[{}]", i - sizes.u());
  return fmt::format("p[{}]", i - sizes.p());
}

// Checks the form of f and L at set-up.
class StructureCheck {
 public:
  explicit StructureCheck(const IntervalProblem& problem) : problem_(problem) {
    const Arguments& sizes = problem.arguments;
    refuse_time(problem.dynamics, "dynamics", ".");
    problem.dynamics.hessian_pattern().for_each([&](int r, int c, int) {
      if (r < sizes.p() && c < sizes.p())
        throw DefinitionError(needs() +
                              "dynamics that are affine in state and input, but they "
                              "have a second derivative with respect to " +
                              entry_name(sizes, r) + " and " + entry_name(sizes, c) + ".");
    });
    if (!jacobian_is_constant())
      throw DefinitionError(needs() +
                            "dynamics that are affine in state and input, but their "
                            "Jacobian differs between two points.");
    if (!problem.running_cost) return;
    refuse_time(problem.running_cost, "running costs", remedy);
    const int output = cost_with_varying_hessian();
    if (output >= 0)
      throw DefinitionError(
          needs() +
          fmt::format("running costs that are at most quadratic in state and input, but the "
                      "Hessian of cost {} differs between two points{}",
                      output, remedy));
  }

 private:
  // Constant derivatives at arguments of order one agree to this accuracy.
  static constexpr double rounding = 1e-10;
  static constexpr int points = 6;
  static constexpr const char* remedy =
      "; runge_kutta4() integrates such costs, and costs(CostRule::nodes) sums them at the nodes.";

  static std::string needs() { return "the exact zero-order hold needs "; }

  void refuse_time(const Function& function, const char* what, const char* end) const {
    for (int r = 0; r < function.outputs(); ++r)
      if (function.jacobian_pattern().contains(r, problem_.arguments.t()))
        throw DefinitionError(
            needs() +
            fmt::format("{} that do not depend on time, but output {} does{}", what, r, end));
  }

  VectorXd random_point(const VectorXd& parameters) {
    const Arguments& sizes = problem_.arguments;
    VectorXd z(sizes.size());
    std::normal_distribution<double> normal;
    for (int i = 0; i < sizes.p(); ++i) z[i] = normal(random_);
    z.tail(sizes.np) = parameters;
    return z;
  }

  VectorXd random_parameters() {
    // Positive and of order one, like masses, lengths and stiffnesses.
    std::uniform_real_distribution<double> uniform(0.5, 1.5);
    VectorXd p(problem_.arguments.np);
    for (double& value : p) value = uniform(random_);
    return p;
  }

  static bool agree(const MatrixXd& a, const MatrixXd& b) {
    if (!a.allFinite() || !b.allFinite() || a.size() == 0) return true;  // nothing to compare
    const double scale = std::max({1.0, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
    return (a - b).cwiseAbs().maxCoeff() <= rounding * scale;
  }

  bool jacobian_is_constant() {
    const int n = problem_.arguments.p();
    for (int k = 0; k < points; ++k) {
      const VectorXd p = random_parameters();
      const MatrixXd a = problem_.dynamics.dense_jacobian(random_point(p)).leftCols(n);
      const MatrixXd b = problem_.dynamics.dense_jacobian(random_point(p)).leftCols(n);
      if (!agree(a, b)) return false;
    }
    return true;
  }

  int cost_with_varying_hessian() {
    const Function& cost = problem_.running_cost;
    const int n = problem_.arguments.p();
    for (int i = 0; i < cost.outputs(); ++i) {
      const VectorXd weights = VectorXd::Unit(cost.outputs(), i);
      for (int k = 0; k < points; ++k) {
        const VectorXd p = random_parameters();
        const VectorXd from = random_point(p), to = random_point(p);
        const MatrixXd a = cost.dense_hessian(from, weights).topLeftCorner(n, n);
        const MatrixXd b = cost.dense_hessian(to, weights).topLeftCorner(n, n);
        // A kink does not change the Hessian but makes the gradient nonlinear.
        const VectorXd slope_change =
            (cost.dense_jacobian(to) - cost.dense_jacobian(from)).row(i).head(n).transpose();
        if (!agree(a, b) || !agree(slope_change, a * (to - from).head(n))) return i;
      }
    }
    return -1;
  }

  const IntervalProblem& problem_;
  std::mt19937 random_{20240229};  // fixed seed
};

// The matrices of one pair (h, p).
struct Discretisation {
  bool valid = false;
  std::vector<double> key;                 // p, h
  RowMajorMatrix flow;                     // F
  std::vector<RowMajorMatrix> integral;    // G per cost
  std::vector<RowMajorMatrix> flow_slope;  // per extra direction (p..., h)
  std::vector<std::vector<RowMajorMatrix>> integral_slope;
  RowMajorMatrix flow_curvature;  // second derivative in h
  std::vector<RowMajorMatrix> integral_curvature;
};

class ZeroOrderHold final : public Integrator {
 public:
  explicit ZeroOrderHold(const IntervalProblem& definition)
      : Integrator(definition),
        field_(problem()),
        sizes_(problem().arguments),
        place_(arguments()),
        nx_(sizes_.nx),
        nu_(sizes_.nu),
        nq_(problem().nq()),
        linear_(problem().shape == InputShape::linear),
        size_(nx_ + (linear_ ? 2 : 1) * nu_ + 1),
        work_(nx_, size_, nq_) {
    StructureCheck{problem()};
    for (int i = 0; i < sizes_.np; ++i)
      if (problem().differentiate_parameter[i]) parameters_.push_back(i);
    const int directions = static_cast<int>(parameters_.size()) + time();
    model_.resize(nx_, sizes_);
    model_slope_.resize(parameters_.size());
    for (Model& slope : model_slope_) slope.resize(nx_, sizes_);
    cost_.resize(nq_);
    cost_slope_.resize(parameters_.size());
    const int n = sizes_.nx + sizes_.nu + 1;
    for (RowMajorMatrix& form : cost_) form.setZero(n, n);
    for (auto& slopes : cost_slope_) slopes.assign(nq_, RowMajorMatrix::Zero(n, n));
    for (Discretisation& d : cache_) {
      d.key.resize(sizes_.np + 1);
      d.flow.setZero(size_, size_);
      d.integral.assign(nq_, d.flow);
      d.flow_slope.assign(directions, d.flow);
      d.integral_slope.assign(directions, d.integral);
      d.flow_curvature = d.flow;
      d.integral_curvature = d.integral;
    }
    key_.resize(sizes_.np + 1);
    read_.resize(sizes_.np);
    z_.setZero(sizes_.size());
    outputs_.resize(std::max(nx_, nq_));
    int entries = problem().dynamics.jacobian_pattern().entries();
    if (nq_ > 0) {
      entries = std::max(entries, problem().running_cost.jacobian_pattern().entries());
      hessian_entries_.resize(problem().running_cost.hessian_pattern().entries());
    }
    entries_.resize(entries);
    unit_.setZero(nq_);
    v_.setZero(size_);
    gradient_.setZero(size_);
    curvature_.setZero(size_, size_);
    end_.setZero(nx_ + nq_);
  }

  IntegrationStatus value(const double* w, double* end) override {
    const Discretisation* d = discretise(w);
    if (d == nullptr) return fail(end);
    load_start(w);
    return finish(*d, end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    const Discretisation* d = discretise(w);
    derivative.setZero();
    if (d == nullptr) return fail(end);
    load_start(w);
    for (int r = 0; r < nx_; ++r) {
      gradient_ = d->flow.row(r).transpose();
      place_row(gradient_, [&](int column, double g) { derivative(r, column) = g; });
    }
    for (int i = 0; i < nq_; ++i) {
      gradient_.noalias() = 2.0 * d->integral[i].lazyProduct(v_);
      place_row(gradient_, [&](int column, double g) { derivative(nx_ + i, column) = g; });
    }
    for (int k = 0; k < static_cast<int>(d->flow_slope.size()); ++k) {
      const int column = direction_column(k);
      for (int r = 0; r < nx_; ++r) derivative(r, column) = d->flow_slope[k].row(r).dot(v_);
      for (int i = 0; i < nq_; ++i) derivative(nx_ + i, column) = form(d->integral_slope[k][i]);
    }
    return finish(*d, end);
  }

  bool follows_running_costs() const override { return false; }  // quadratic forms are stored
  bool has_hessian() const override { return parameters_.empty(); }

  IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                            Curvature curvature) override {
    if (!has_hessian()) return IntegrationStatus::library_failure;
    const Discretisation* d = discretise(w);
    hessian.setZero();
    if (d == nullptr) return IntegrationStatus::not_finite;
    load_start(w);
    curvature_.setZero();
    for (int i = 0; i < nq_; ++i) curvature_ += (2.0 * weights[nx_ + i]) * d->integral[i];
    // Map the rows of v, then its columns, to w.
    for (int row = 0; row + 1 < size_; ++row) {
      gradient_ = curvature_.row(row).transpose();
      place_row(gradient_, [&](int column, double g) {
        place_entry(row, [&](int target, double sign) { hessian(target, column) += sign * g; });
      });
    }
    // The two triangles were summed in different order: make them equal.
    for (int row = 0; row < hessian.rows(); ++row)
      for (int column = 0; column < row; ++column) hessian(column, row) = hessian(row, column);
    if (time() == 0 || curvature == Curvature::gauss_newton) return IntegrationStatus::success;

    const int h = place_.h();
    gradient_.setZero();
    double second = 0.0;
    for (int r = 0; r < nx_; ++r) {
      gradient_ += weights[r] * d->flow_slope.back().row(r).transpose();
      second += weights[r] * d->flow_curvature.row(r).dot(v_);
    }
    for (int i = 0; i < nq_; ++i) {
      gradient_ += (2.0 * weights[nx_ + i]) * d->integral_slope.back()[i].lazyProduct(v_);
      second += weights[nx_ + i] * form(d->integral_curvature[i]);
    }
    place_row(gradient_,
              [&](int column, double g) { hessian(h, column) = hessian(column, h) = g; });
    hessian(h, h) = second;
    return IntegrationStatus::success;
  }

 private:
  // x' = A x + B u + a as one block row over (x | u | 1).
  struct Model {
    RowMajorMatrix rows;
    void resize(int nx, const Arguments& sizes) { rows.setZero(nx, sizes.nx + sizes.nu + 1); }
  };

  int time() const { return problem().differentiate_time ? 1 : 0; }
  int direction_column(int k) const {
    return k < static_cast<int>(parameters_.size()) ? place_.p(parameters_[k]) : place_.h();
  }

  void load_start(const double* w) {
    for (int i = 0; i < nx_; ++i) v_[i] = w[place_.x(i)];
    for (int i = 0; i < nu_; ++i) {
      v_[nx_ + i] = w[place_.c(i)];
      if (linear_) v_[nx_ + nu_ + i] = w[place_.c(nu_ + i)] - w[place_.c(i)];
    }
    v_[size_ - 1] = 1.0;
  }

  // Calls put(column of w, factor) for every entry of w on which entry `i` of v depends.
  template <class Put>
  void place_entry(int i, Put&& put) const {
    if (i < nx_ + nu_) {
      put(i, 1.0);  // states and first coefficients are first in w, too
    } else {
      put(i, 1.0);
      put(i - nu_, -1.0);  // delta = c1 - c0
    }
  }

  // Maps a gradient in v to one in (x0 | c): put(column of w, value).
  template <class Put>
  void place_row(const VectorXd& gradient, Put&& put) const {
    for (int i = 0; i < nx_; ++i) put(i, gradient[i]);
    for (int i = 0; i < nu_; ++i) {
      const int c0 = nx_ + i, c1 = nx_ + nu_ + i;
      put(c0, linear_ ? gradient[c0] - gradient[c1] : gradient[c0]);
      if (linear_) put(c1, gradient[c1]);
    }
  }

  double form(const RowMajorMatrix& g) const {
    double sum = 0.0;
    for (int i = 0; i < size_; ++i) sum += v_[i] * g.row(i).dot(v_);
    return sum;
  }

  IntegrationStatus fail(double* end) const {
    std::fill_n(end, nx_ + nq_, std::nan(""));
    return IntegrationStatus::not_finite;
  }

  IntegrationStatus finish(const Discretisation& d, double* end) const {
    for (int r = 0; r < nx_; ++r) end[r] = d.flow.row(r).dot(v_);
    for (int i = 0; i < nq_; ++i) end[nx_ + i] = form(d.integral[i]);
    return all_finite(end, nx_ + nq_) ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  const Discretisation* discretise(const double* w) {
    std::copy_n(w + place_.p(), sizes_.np, key_.begin());
    key_.back() = w[place_.h()];
    for (const Discretisation& d : cache_)
      if (d.valid && d.key == key_) return &d;
    Discretisation& d = cache_[oldest_];
    oldest_ = (oldest_ + 1) % cached_discretisations;
    d.valid = false;
    d.key = key_;
    const double h = key_.back();
    read_model();

    // One evaluation per extra direction. Each also computes the undifferentiated matrices.
    const int np = static_cast<int>(parameters_.size());
    const int runs = np + time();
    for (int k = 0; k < std::max(runs, 1); ++k) {
      const bool by_length = runs > 0 && k == np;
      const int order = runs == 0 ? 0 : by_length ? 2 : 1;
      work_.generator.set_zero(order);
      fill_generator(h, model_.rows, work_.generator[0], true);
      for (int i = 0; i < nq_; ++i) {
        work_.forms[i].set_zero(order);
        fill_form(h, cost_[i], work_.forms[i][0]);
      }
      if (by_length) {
        fill_generator(1.0, model_.rows, work_.generator[1], false);
        for (int i = 0; i < nq_; ++i) fill_form(1.0, cost_[i], work_.forms[i][1]);
      } else if (runs > 0) {
        fill_generator(h, model_slope_[k].rows, work_.generator[1], false);
        for (int i = 0; i < nq_; ++i) fill_form(h, cost_slope_[k][i], work_.forms[i][1]);
      }
      if (!work_.compute(order)) return nullptr;
      d.flow = work_.flow[0];
      for (int i = 0; i < nq_; ++i) d.integral[i] = work_.integrals[i][0];
      if (order == 0) continue;
      d.flow_slope[k] = work_.flow[1];
      for (int i = 0; i < nq_; ++i) d.integral_slope[k][i] = work_.integrals[i][1];
      if (order == 1) continue;
      d.flow_curvature = work_.flow[2];
      for (int i = 0; i < nq_; ++i) d.integral_curvature[i] = work_.integrals[i][2];
    }
    d.valid = true;
    return &d;
  }

  // Writes scale [A B 0 a] and, with `ramp`, the identity that makes u grow by delta.
  void fill_generator(double scale, const RowMajorMatrix& rows, RowMajorMatrix& m,
                      bool ramp) const {
    for (int r = 0; r < nx_; ++r) {
      for (int c = 0; c < nx_ + nu_; ++c) m(r, c) = scale * rows(r, c);
      m(r, size_ - 1) = scale * rows(r, nx_ + nu_);
    }
    if (ramp && linear_)
      for (int i = 0; i < nu_; ++i) m(nx_ + i, nx_ + nu_ + i) = 1.0;
  }

  // Writes a form over (x | u | 1) into one over xi.
  void fill_form(double scale, const RowMajorMatrix& form, RowMajorMatrix& q) const {
    const int n = nx_ + nu_;
    for (int r = 0; r <= n; ++r)
      for (int c = 0; c <= n; ++c)
        q(r == n ? size_ - 1 : r, c == n ? size_ - 1 : c) = scale * form(r, c);
  }

  // Reads values, slopes and curvatures of f and L at the origin, and their parameter derivatives.
  // Derivatives at the origin and at unit points determine an affine or quadratic function. The
  // model does not depend on the length.
  void read_model() {
    if (knows_model_ && std::equal(read_.begin(), read_.end(), key_.begin())) return;
    knows_model_ = false;  // in case a formula throws
    read_model_here();
    std::copy_n(key_.begin(), sizes_.np, read_.begin());
    knows_model_ = true;
  }

  void read_model_here() {
    const int n = nx_ + nu_;
    z_.setZero();
    std::copy_n(key_.begin(), sizes_.np, z_.data() + sizes_.p());
    read_dynamics(-1);
    read_costs(-1);
    if (parameters_.empty()) return;
    for (int i = 0; i < n; ++i) {
      z_[1 + i] = 1.0;
      read_dynamics(i);
      if (nq_ > 0) read_costs(i);
      z_[1 + i] = 0.0;
    }
  }

  // at = -1: the origin, otherwise the unit point of entry `at` of (x | u).
  void read_dynamics(int at) {
    const int n = nx_ + nu_;
    const Function& f = problem().dynamics;
    f.jacobian(z_.data(), outputs_.data(), entries_.data());
    if (at < 0)
      for (int r = 0; r < nx_; ++r) model_.rows(r, n) = outputs_[r];
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      RowMajorMatrix& slope = model_slope_[k].rows;
      if (at < 0)
        slope.setZero();
      else
        slope.col(at) = -slope.col(n);
    }
    f.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (c >= 1 && c < sizes_.p()) {
        if (at < 0) model_.rows(r, c - 1) = entries_[e];
        return;
      }
      for (std::size_t k = 0; k < parameters_.size(); ++k)
        if (c == sizes_.p(parameters_[k])) model_slope_[k].rows(r, at < 0 ? n : at) += entries_[e];
    });
  }

  void read_costs(int at) {
    if (nq_ == 0) return;
    const int n = nx_ + nu_;
    const Function& cost = problem().running_cost;
    if (at < 0) {
      cost.jacobian(z_.data(), outputs_.data(), entries_.data());
      for (int i = 0; i < nq_; ++i) {
        cost_[i].setZero();
        cost_[i](n, n) = outputs_[i];
        for (auto& slopes : cost_slope_) slopes[i].setZero();
      }
      cost.jacobian_pattern().for_each([&](int r, int c, int e) {
        if (c >= 1 && c < sizes_.p()) {
          cost_[r](c - 1, n) = cost_[r](n, c - 1) = 0.5 * entries_[e];
          return;
        }
        for (std::size_t k = 0; k < parameters_.size(); ++k)
          if (c == sizes_.p(parameters_[k])) cost_slope_[k][r](n, n) = entries_[e];
      });
    }
    for (int i = 0; i < nq_; ++i) {
      unit_.setZero();
      unit_[i] = 1.0;
      cost.hessian(z_.data(), unit_.data(), hessian_entries_.data(), Curvature::exact);
      if (at >= 0)  // column `at` of the curvature's slope, as a difference from the origin
        for (auto& slopes : cost_slope_)
          for (int c = 0; c < n; ++c) slopes[i](c, at) = -slopes[i](c, n);
      cost.hessian_pattern().for_each([&](int r, int c, int e) {
        // Lower triangle with r >= c. Parameters come last.
        if (c < 1 || c >= sizes_.p()) return;
        if (r < sizes_.p()) {
          if (at < 0) cost_[i](r - 1, c - 1) = cost_[i](c - 1, r - 1) = 0.5 * hessian_entries_[e];
          return;
        }
        for (std::size_t k = 0; k < parameters_.size(); ++k) {
          if (r != sizes_.p(parameters_[k])) continue;
          RowMajorMatrix& slope = cost_slope_[k][i];
          if (at < 0)
            slope(c - 1, n) = slope(n, c - 1) = 0.5 * hessian_entries_[e];
          else
            slope(c - 1, at) += 0.5 * hessian_entries_[e];
        }
      });
    }
  }

  IntervalField field_;  // checks the sizes of the functions before their first use
  Arguments sizes_;
  IntervalArguments place_;
  int nx_, nu_, nq_;
  bool linear_;
  int size_;  // size of xi
  AffineFlow work_;
  std::vector<int> parameters_;  // indices of parameters with derivatives
  Model model_;
  std::vector<Model> model_slope_;
  std::vector<RowMajorMatrix> cost_;                     // Q over (x | u | 1)
  std::vector<std::vector<RowMajorMatrix>> cost_slope_;  // [parameter][cost]
  std::array<Discretisation, cached_discretisations> cache_;
  int oldest_ = 0;
  std::vector<double> read_;  // parameters of the current model
  bool knows_model_ = false;
  std::vector<double> key_, outputs_, entries_, hessian_entries_;
  VectorXd z_, unit_, v_, gradient_, end_;
  RowMajorMatrix curvature_;
};

class ZeroOrderHoldScheme final : public IntegratorScheme {
 public:
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    throw_no_event_support(problem, "the exact zero-order hold");
    return std::make_unique<ZeroOrderHold>(problem);
  }
  std::string name() const override { return "exact zero-order hold"; }
};

}  // namespace

IntegratorChoice zero_order_hold() { return std::make_shared<ZeroOrderHoldScheme>(); }

}  // namespace saltus
