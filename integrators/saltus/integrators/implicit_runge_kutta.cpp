// In scaled time (interval_field.hpp), D = 1 / steps, y = (x | q), for a tableau with regular a:
//   X_i = x_n + D sum_j a_ij F_j,   F_j = F(s_n + c_j D, X_j),
//   x_{n+1} = x_n + sum_i d_i (X_i - x_n),  d = a^-T b,   q_{n+1} = q_n + D sum_i b_i F_qi,
// where d instead of b avoids the rounding of stiff rates. With M_ij = I delta_ij - D a_ij F_Xj:
//   first order:   sum_j M_ij dX_j = dx_n + D sum_j a_ij F_theta,j dtheta,
//   second order:  weighted with lambda at the end, the multipliers xi of the stage equations,
//     sum_i M_ij' xi_i = D b_j F_Xj' lambda,   Fbar_j = D (b_j lambda + sum_i a_ij xi_i),
//     lambda_n = lambda_{n+1} + sum_j xi_j     (rows of x; lambda of q is constant),
// and the Hessian is the sum over all stages of the second differential of Fbar_j' F_j along dX_j.
// See framework/design/integrators.md. E. Hairer, G. Wanner, Solving Ordinary Differential
// Equations II, 2nd ed., sec. IV.5 and IV.8.
#include "saltus/integrators/runge_kutta.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/explicit_steps.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/implicit_stages.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {
namespace {

class ImplicitRungeKutta final : public Integrator {
 public:
  ImplicitRungeKutta(const IntervalProblem& problem, ButcherTableau tableau, int steps)
      : Integrator(problem),
        field_(this->problem()),
        nx_(field_.states()),
        ny_(field_.outputs()),
        nd_(field_.directions()),
        solver_(std::move(tableau), this->problem().nominal_state, nx_, ny_),
        tableau_(solver_.tableau()),
        stages_(solver_.count()),
        end_weights_(solver_.end_weights()),
        y_(ny_),
        before_(nx_),
        multipliers_(stages_ * nx_),
        costate_(ny_),
        weighted_(ny_),
        along_(nd_),
        sensitivity_(ny_, nd_),
        stacked_(stages_ * nx_, nd_),
        stage_sensitivity_(stages_, RowMajorMatrix(nx_, nd_)),
        rate_sensitivity_(stages_, RowMajorMatrix(ny_, nd_)),
        zero_(RowMajorMatrix::Zero(nx_, nd_)),
        curvature_(nd_, nd_),
        steps_(steps, ImplicitStep(stages_, field_, field_.entries())) {}

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    for (int n = 0; n < steps(); ++n)
      if (!advance(n, Wanted::value)) return status_;
    return finish(end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    start_sensitivity();
    for (int n = 0; n < steps(); ++n) {
      if (!advance(n, Wanted::derivatives)) return status_;
      find_stage_sensitivity(n);
      advance_sensitivity();
    }
    field_.scatter(sensitivity_, derivative);
    const IntegrationStatus status = finish(end);
    return status == IntegrationStatus::success && !sensitivity_.allFinite()
               ? IntegrationStatus::not_finite
               : status;
  }

  bool has_hessian() const override { return true; }

  IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                            Curvature curvature) override {
    start(w);
    for (int n = 0; n < steps(); ++n)
      if (!advance(n, Wanted::derivatives)) return status_;
    sweep_back(weights);
    start_sensitivity();
    curvature_.setZero();
    for (int n = 0; n < steps(); ++n) {
      find_stage_sensitivity(n);
      for (int i = 0; i < stages_; ++i) {
        const ImplicitStep::Stage& stage = steps_[n].stages[i];
        field_.add_curvature(time_of(n, i), stage.z.data(), stage.adjoint.data(),
                             stage_sensitivity_[i], curvature, curvature_);
        if (curvature != Curvature::exact || !field_.differentiates_time()) continue;
        field_.pull_back(time_of(n, i), stage.gradient.data(), stage_sensitivity_[i],
                         along_.data());
        const int last = field_.h_direction();  // h is the last direction
        curvature_.row(last) += along_.transpose();
        curvature_(last, last) += along_[last];
      }
      advance_sensitivity();
    }
    field_.scatter_symmetric(curvature_, hessian);
    return curvature_.allFinite() ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  std::string failure() const override {
    if (failed_step_ < 0) return {};
    return fmt::format(
        "Newton's method failed in step {} of {}, which begins at t = {:.6g} s; try more steps or "
        "shorter intervals",
        failed_step_ + 1, steps(), failed_time_);
  }

 private:
  enum class Wanted { value, derivatives };

  int steps() const { return static_cast<int>(steps_.size()); }
  double step_length() const { return 1.0 / steps(); }
  double time_of(int n, int stage) const { return (n + tableau_.c[stage]) * step_length(); }

  void start(const double* w) {
    field_.load(w);
    start_time_ = w[arguments().t0()];
    failed_step_ = -1;
    std::copy_n(w, nx_, y_.data());
    y_.tail(ny_ - nx_).setZero();
  }

  // --- the stages of a step ------------------------------------------------------------------
  bool advance(int n, Wanted wanted) {
    ImplicitStep& step = steps_[n];
    before_ = y_.head(nx_);
    const double s = n * step_length();
    IntegrationStatus status = solver_.find(field_, s, step_length(), before_.data(), step);
    if (status != IntegrationStatus::success) return fail(n, status);
    if (wanted == Wanted::derivatives) {
      status = solver_.evaluate_slopes(field_, s, step_length(), step);
      if (status != IntegrationStatus::success) return fail(n, status);
    } else if (ny_ > nx_) {
      solver_.evaluate_rates(field_, s, step_length(), step);
    }
    for (int i = 0; i < stages_; ++i)
      for (int r = 0; r < nx_; ++r) y_[r] += end_weights_[i] * (solver_.state(i)[r] - before_[r]);
    for (int i = 0; i < stages_; ++i)
      for (int r = nx_; r < ny_; ++r)
        y_[r] += step_length() * tableau_.b[i] * field_.length() * step.stages[i].phi[r];
    return true;
  }

  bool fail(int n, IntegrationStatus status) {
    status_ = status;
    if (status == IntegrationStatus::step_too_small) {
      failed_step_ = n;
      failed_time_ = start_time_ + n * step_length() * field_.length();
    }
    return false;
  }

  IntegrationStatus finish(double* end) const {
    std::copy_n(y_.data(), ny_, end);
    return y_.allFinite() ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  // --- first order ---------------------------------------------------------------------------
  void start_sensitivity() {
    sensitivity_.setZero();
    for (int i = 0; i < nx_; ++i) sensitivity_(i, i) = 1.0;
  }

  void find_stage_sensitivity(int n) {
    const ImplicitStep& step = steps_[n];
    for (int j = 0; j < stages_; ++j)
      field_.rate_sensitivity(time_of(n, j), step.stages[j].phi.data(),
                              step.stages[j].entries.data(), zero_, rate_sensitivity_[j].data());
    const int count = nx_ * nd_;
    for (int i = 0; i < stages_; ++i) {
      double* right_side = stacked_.data() + i * count;
      std::copy_n(sensitivity_.data(), count, right_side);
      for (int j = 0; j < stages_; ++j) {
        const double a = step_length() * tableau_.a(i, j);
        const double* direct = rate_sensitivity_[j].data();
        for (int k = 0; k < count; ++k) right_side[k] += a * direct[k];
      }
    }
    step.matrix.solve(stacked_.data(), nd_);
    for (int i = 0; i < stages_; ++i)
      std::copy_n(stacked_.data() + i * count, count, stage_sensitivity_[i].data());
    if (ny_ == nx_) return;
    for (int j = 0; j < stages_; ++j)
      field_.rate_sensitivity(time_of(n, j), step.stages[j].phi.data(),
                              step.stages[j].entries.data(), stage_sensitivity_[j],
                              rate_sensitivity_[j].data());
  }

  void advance_sensitivity() {
    const int count = nx_ * nd_;
    double* end = sensitivity_.data();
    const double kept = 1.0 - end_weights_.sum();
    for (int k = 0; k < count; ++k) end[k] *= kept;
    for (int i = 0; i < stages_; ++i) {
      const double* stage = stage_sensitivity_[i].data();
      for (int k = 0; k < count; ++k) end[k] += end_weights_[i] * stage[k];
      const double b = step_length() * tableau_.b[i];
      const double* rate = rate_sensitivity_[i].data();
      for (int k = count; k < ny_ * nd_; ++k) end[k] += b * rate[k];
    }
  }

  // --- second order --------------------------------------------------------------------------
  void sweep_back(const double* weights) {
    const double D = step_length(), h = field_.length();
    costate_ = Eigen::Map<const VectorXd>(weights, ny_);
    for (int n = steps() - 1; n >= 0; --n) {
      ImplicitStep& step = steps_[n];
      for (int j = 0; j < stages_; ++j) {
        ImplicitStep::Stage& stage = step.stages[j];
        weighted_ = D * tableau_.b[j] * costate_;
        field_.adjoint(stage.entries.data(), weighted_.data(), stage.gradient.data());
        for (int r = 0; r < nx_; ++r) multipliers_[j * nx_ + r] = h * stage.gradient[1 + r];
      }
      step.matrix.solve_transposed(multipliers_.data());
      for (int j = 0; j < stages_; ++j) {
        ImplicitStep::Stage& stage = step.stages[j];
        stage.adjoint = D * tableau_.b[j] * costate_;
        for (int i = 0; i < stages_; ++i)
          for (int r = 0; r < nx_; ++r)
            stage.adjoint[r] += D * tableau_.a(i, j) * multipliers_[i * nx_ + r];
        field_.adjoint(stage.entries.data(), stage.adjoint.data(), stage.gradient.data());
      }
      for (int j = 0; j < stages_; ++j)
        for (int r = 0; r < nx_; ++r) costate_[r] += multipliers_[j * nx_ + r];
    }
  }

  IntervalField field_;
  int nx_, ny_, nd_;
  StageSolver solver_;
  const ButcherTableau& tableau_;
  int stages_;
  const VectorXd& end_weights_;  // d
  VectorXd y_, before_;          // (x | q), and x at the start of the step
  VectorXd multipliers_, costate_, weighted_, along_;
  RowMajorMatrix sensitivity_, stacked_;  // stacked_: stage sensitivities, stacked vertically
  std::vector<RowMajorMatrix> stage_sensitivity_, rate_sensitivity_;
  RowMajorMatrix zero_, curvature_;
  std::vector<ImplicitStep> steps_;
  IntegrationStatus status_ = IntegrationStatus::success;
  int failed_step_ = -1;
  double start_time_ = 0.0, failed_time_ = 0.0;
};

class ImplicitRungeKuttaScheme final : public IntegratorScheme {
 public:
  ImplicitRungeKuttaScheme(ButcherTableau tableau, int steps)
      : tableau_(std::move(tableau)), steps_(steps) {
    check_steps(tableau_.name, steps_);
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    if (!problem.switching.empty()) return hybrid_implicit(problem, tableau_, steps_);
    return std::make_unique<ImplicitRungeKutta>(problem, tableau_, steps_);
  }
  std::string name() const override {
    return fmt::format("{}, {} step{}", tableau_.name, steps_, steps_ == 1 ? "" : "s");
  }

 private:
  ButcherTableau tableau_;
  int steps_;
};

}  // namespace

IntegratorChoice gauss_legendre(ImplicitRungeKuttaOptions options) {
  return std::make_shared<ImplicitRungeKuttaScheme>(gauss_legendre_tableau(options.stages),
                                                    options.steps);
}

IntegratorChoice radau_iia(ImplicitRungeKuttaOptions options) {
  return std::make_shared<ImplicitRungeKuttaScheme>(radau_iia_tableau(options.stages),
                                                    options.steps);
}

IntegratorChoice implicit_midpoint(ImplicitMidpointOptions options) {
  ButcherTableau tableau = gauss_legendre_tableau(1);
  tableau.name = "implicit midpoint";
  return std::make_shared<ImplicitRungeKuttaScheme>(std::move(tableau), options.steps);
}

}  // namespace saltus
