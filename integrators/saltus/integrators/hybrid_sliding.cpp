#include "saltus/integrators/hybrid_sliding.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace saltus {
namespace {

// A function with dense Jacobian, its own workspace and no second derivatives. Not re-entrant,
// because only one integrator uses it.
class FirstOrderBody : public FunctionBody {
 public:
  FirstOrderBody(int inputs, int outputs) : FunctionBody(inputs, outputs) {
    jacobian_pattern_ = SparsityPattern::dense(outputs, inputs);
    hessian_pattern_ = SparsityPattern(inputs, inputs);
  }
  int degree(int, const std::vector<char>&) const override { return 3; }
  void hessian(const double*, const double*, double*, Curvature) const override {}
};

// r = g_t + g_x f and dr/dz = H_g (1 | f | 0) + f_z' g_x.
class Rate {
 public:
  Rate(const Arguments& sizes, Function guard, Function dynamics)
      : sizes_(sizes),
        guard_(std::move(guard)),
        dynamics_(std::move(dynamics)),
        f_(sizes.nx),
        guard_entries_(guard_.jacobian_pattern().entries()),
        dynamics_entries_(dynamics_.jacobian_pattern().entries()),
        curvature_(guard_.hessian_pattern().entries()),
        weights_(sizes.nx) {}

  double value(const double* z) {
    double g = 0.0;
    guard_.jacobian(z, &g, guard_entries_.data());
    dynamics_.value(z, f_.data());
    return combine();
  }

  double jacobian(const double* z, double* gradient) {
    double g = 0.0;
    guard_.jacobian(z, &g, guard_entries_.data());
    dynamics_.jacobian(z, f_.data(), dynamics_entries_.data());
    const double one = 1.0;
    guard_.hessian(z, &one, curvature_.data());
    std::fill_n(gradient, sizes_.size(), 0.0);
    std::fill(weights_.begin(), weights_.end(), 0.0);
    guard_.jacobian_pattern().for_each([&](int, int col, int e) {
      if (is_state(col)) weights_[col - 1] = guard_entries_[e];
    });
    dynamics_.jacobian_pattern().for_each(
        [&](int row, int col, int e) { gradient[col] += weights_[row] * dynamics_entries_[e]; });
    guard_.hessian_pattern().for_each([&](int i, int j, int e) {
      gradient[i] += curvature_[e] * motion(j);
      if (i != j) gradient[j] += curvature_[e] * motion(i);
    });
    return combine();
  }

 private:
  bool is_state(int col) const { return col >= 1 && col <= sizes_.nx; }
  // dz/dt along the field for constant inputs and parameters.
  double motion(int col) const { return col == 0 ? 1.0 : is_state(col) ? f_[col - 1] : 0.0; }
  double combine() const {
    double r = 0.0;
    guard_.jacobian_pattern().for_each(
        [&](int, int col, int e) { r += guard_entries_[e] * motion(col); });
    return r;
  }

  Arguments sizes_;
  Function guard_, dynamics_;
  std::vector<double> f_, guard_entries_, dynamics_entries_, curvature_, weights_;
};

class GuardRateBody final : public FirstOrderBody {
 public:
  GuardRateBody(const Arguments& sizes, Function guard, Function dynamics, double sign)
      : FirstOrderBody(sizes.size(), 1),
        rate_(sizes, std::move(guard), std::move(dynamics)),
        sign_(sign) {}

  void value(const double* z, double* y) const override { *y = sign_ * rate_.value(z); }
  void jacobian(const double* z, double* y, double* entries) const override {
    *y = sign_ * rate_.jacobian(z, entries);
    for (int i = 0; i < inputs(); ++i) entries[i] *= sign_;
  }

 private:
  mutable Rate rate_;
  double sign_;
};

class SlidingMixBody final : public FirstOrderBody {
 public:
  SlidingMixBody(const Arguments& sizes, const Function& guard, Function dynamics_below,
                 Function dynamics_above, Function below, Function above)
      : FirstOrderBody(sizes.size(), below.outputs()),
        rate_below_(sizes, guard, std::move(dynamics_below)),
        rate_above_(sizes, guard, std::move(dynamics_above)),
        below_(std::move(below)),
        above_(std::move(above)),
        value_below_(outputs()),
        value_above_(outputs()),
        entries_below_(below_.jacobian_pattern().entries()),
        entries_above_(above_.jacobian_pattern().entries()),
        gradient_below_(sizes.size()),
        gradient_above_(sizes.size()) {}

  void value(const double* z, double* y) const override {
    const double r_below = rate_below_.value(z), r_above = rate_above_.value(z);
    const double a = r_below / (r_below - r_above);
    below_.value(z, value_below_.data());
    above_.value(z, value_above_.data());
    for (int i = 0; i < outputs(); ++i) y[i] = (1.0 - a) * value_below_[i] + a * value_above_[i];
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    const double r_below = rate_below_.jacobian(z, gradient_below_.data());
    const double r_above = rate_above_.jacobian(z, gradient_above_.data());
    const double gap = r_below - r_above;
    const double a = r_below / gap;
    below_.jacobian(z, value_below_.data(), entries_below_.data());
    above_.jacobian(z, value_above_.data(), entries_above_.data());
    const int n = inputs();
    for (int i = 0; i < outputs(); ++i) {
      const double difference = value_above_[i] - value_below_[i];
      y[i] = value_below_[i] + a * difference;
      for (int j = 0; j < n; ++j)  // da = (r_below dr_above - r_above dr_below) / gap^2
        entries[i * n + j] = difference *
                             (r_below * gradient_above_[j] - r_above * gradient_below_[j]) /
                             (gap * gap);
    }
    below_.jacobian_pattern().for_each(
        [&](int r, int c, int e) { entries[r * n + c] += (1.0 - a) * entries_below_[e]; });
    above_.jacobian_pattern().for_each(
        [&](int r, int c, int e) { entries[r * n + c] += a * entries_above_[e]; });
  }

 private:
  mutable Rate rate_below_, rate_above_;
  Function below_, above_;
  mutable std::vector<double> value_below_, value_above_, entries_below_, entries_above_;
  mutable std::vector<double> gradient_below_, gradient_above_;
};

}  // namespace

Function surface_rate(const Arguments& sizes, Function guard, Function dynamics, double sign) {
  return Function(
      std::make_shared<GuardRateBody>(sizes, std::move(guard), std::move(dynamics), sign));
}

Function sliding_mix(const Arguments& sizes, Function guard, Function dynamics_below,
                     Function dynamics_above, Function below, Function above) {
  return Function(std::make_shared<SlidingMixBody>(sizes, guard, std::move(dynamics_below),
                                                   std::move(dynamics_above), std::move(below),
                                                   std::move(above)));
}

}  // namespace saltus
