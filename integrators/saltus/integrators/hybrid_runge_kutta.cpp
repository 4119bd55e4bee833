// The flow of one mode by an explicit Runge-Kutta scheme on the fixed grid of the interval.
//
// Dense output as in restarted_stepper.hpp: y(s) = Phi(y_n, s_n, L), L = s - s_n. With e_i = s_n +
// c_i L, at fixed s, dL = -ds_n and de_i = (1 - c_i) ds_n:
//   dX_i = dx_n + sum_j a_ij (L dF_j + F_j dL),   dF_i = F_x dX_i + F_w + F_s de_i,
// and the slope B = dPhi/dL has dX_i = sum_j a_ij (F_j + L dF_j), dF_i = F_x dX_i + c_i F_s. These
// are the derivatives of the discrete map, including event times.
#include <algorithm>
#include <utility>

#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/restarted_stepper.hpp"

namespace saltus {
namespace {

class RungeKuttaStepper final : public RestartedStepper {
 public:
  RungeKuttaStepper(const IntervalProblem& problem, ButcherTableau tableau, int steps,
                    int directions, int entries)
      : RestartedStepper(steps, problem.arguments.nx, problem.arguments.nx + problem.nq(),
                         directions),
        tableau_(std::move(tableau)),
        stage_(ny_),
        rates_(ny_ * tableau_.stages()),
        explicit_(ny_),
        slope_rates_(ny_ * tableau_.stages()),
        slope_stage_(ny_),
        z_(problem.arguments.size()),
        phi_(ny_),
        entries_(entries),
        stage_sensitivity_(nx_, directions),
        rate_sensitivity_(tableau_.stages(), RowMajorMatrix(ny_, directions)) {}

 private:
  IntegrationStatus advance(double s, double* y) override {
    const double length = s - start_;
    if (length == 0.0) {
      std::copy(y_.begin(), y_.end(), y);
      return IntegrationStatus::success;
    }
    const double h = field_->length();
    for (int i = 0; i < tableau_.stages(); ++i) {
      stage_state(i, length);
      field_->argument(start_ + tableau_.c[i] * length, stage_.data(), z_.data());
      field_->value(z_.data(), rate(i));
      for (int r = 0; r < ny_; ++r) rate(i)[r] *= h;
    }
    std::copy(y_.begin(), y_.end(), y);
    for (int i = 0; i < tableau_.stages(); ++i) {
      const double b = tableau_.b[i] * length;
      for (int r = 0; r < ny_; ++r) y[r] += b * rate(i)[r];
    }
    return IntegrationStatus::success;
  }

  double* rate(int stage) { return rates_.data() + stage * ny_; }
  double* slope_rate(int stage) { return slope_rates_.data() + stage * ny_; }

  void stage_state(int i, double length) {
    std::copy_n(y_.begin(), nx_, stage_.begin());
    for (int j = 0; j < i; ++j) {
      const double a = tableau_.a(i, j) * length;
      if (a == 0.0) continue;
      for (int r = 0; r < nx_; ++r) stage_[r] += a * rate(j)[r];
    }
  }

  IntegrationStatus propagate(double s, RowMajorMatrix& result, double* slope) override {
    const double length = s - start_, h = field_->length();
    for (int i = 0; i < tableau_.stages(); ++i) {
      const double c = tableau_.c[i], at = start_ + c * length;
      stage_state(i, length);
      stage_sensitivities(i, length);
      field_->argument(at, stage_.data(), z_.data());
      field_->jacobian(z_.data(), phi_.data(), entries_.data());
      field_->rate_sensitivity(at, phi_.data(), entries_.data(), stage_sensitivity_,
                               rate_sensitivity_[i].data());
      field_->explicit_rate(entries_.data(), explicit_.data());
      for (int r = 0; r < ny_; ++r) rate(i)[r] = h * phi_[r];
      if (moving_)
        for (int r = 0; r < ny_; ++r)
          for (int d = 0; d < nd_; ++d)
            rate_sensitivity_[i](r, d) += explicit_[r] * (1.0 - c) * start_slope_[d];
      if (slope == nullptr) continue;
      // Direction 0 is a state: no other argument varies with it.
      field_->rate_sensitivity(at, phi_.data(), entries_.data(), 0, slope_stage_.data(),
                               slope_rate(i));
      for (int r = 0; r < ny_; ++r) slope_rate(i)[r] += c * explicit_[r];
    }
    result = sensitivity_;
    if (slope != nullptr) std::fill_n(slope, ny_, 0.0);
    for (int i = 0; i < tableau_.stages(); ++i) {
      const double b = tableau_.b[i];
      if (b == 0.0) continue;
      for (int r = 0; r < ny_; ++r) {
        for (int d = 0; d < nd_; ++d) result(r, d) += b * length * rate_sensitivity_[i](r, d);
        if (moving_)
          for (int d = 0; d < nd_; ++d) result(r, d) -= b * rate(i)[r] * start_slope_[d];
        if (slope != nullptr) slope[r] += b * (rate(i)[r] + length * slope_rate(i)[r]);
      }
    }
    return all_finite(result.data(), static_cast<int>(result.size()))
               ? IntegrationStatus::success
               : IntegrationStatus::not_finite;
  }

  void stage_sensitivities(int i, double length) {
    std::copy_n(sensitivity_.data(), nx_ * nd_, stage_sensitivity_.data());
    std::fill(slope_stage_.begin(), slope_stage_.end(), 0.0);
    for (int j = 0; j < i; ++j) {
      const double a = tableau_.a(i, j);
      if (a == 0.0) continue;
      for (int r = 0; r < nx_; ++r) {
        for (int d = 0; d < nd_; ++d)
          stage_sensitivity_(r, d) += a * length * rate_sensitivity_[j](r, d);
        if (moving_)
          for (int d = 0; d < nd_; ++d)
            stage_sensitivity_(r, d) -= a * rate(j)[r] * start_slope_[d];
        slope_stage_[r] += a * (rate(j)[r] + length * slope_rate(j)[r]);
      }
    }
  }

  ButcherTableau tableau_;
  std::vector<double> stage_, rates_, explicit_, slope_rates_, slope_stage_;
  std::vector<double> z_, phi_, entries_;
  RowMajorMatrix stage_sensitivity_;
  std::vector<RowMajorMatrix> rate_sensitivity_;
};

}  // namespace

std::unique_ptr<Integrator> hybrid_runge_kutta(const IntervalProblem& problem,
                                               const ButcherTableau& tableau, int steps) {
  return std::make_unique<HybridIntegrator>(
      problem,
      [&](const IntervalProblem& checked, const HybridModes& modes) {
        return std::make_unique<RungeKuttaStepper>(
            checked, tableau, steps, modes[0].field->directions(), modes.largest_entry_count());
      },
      OneStepScheme{tableau, steps});
}

}  // namespace saltus
