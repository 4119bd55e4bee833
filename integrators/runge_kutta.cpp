// In scaled time (interval_field.hpp), step = 1 / steps, y = (x | q):
//   Y_i = y_n + step sum_{j<i} a_ij F_j,   F_i = F(s_n + c_i step, X_i),
//   y_{n+1} = y_n + step sum_i b_i F_i.
// First order: the same recursion for dY_i, dF_i. Second order, weighted with lambda at the end:
// the adjoints of the stage rates, backward over steps and stages,
//   Fbar_i = step (b_i lambda_{n+1} + sum_{j>i} a_ji Xbar_j),  Xbar_i = h phi_x' Fbar_i,
//   lambda_n = lambda_{n+1} + sum_i Xbar_i   (state rows; lambda of q is constant),
// and the Hessian is the sum over all stages of the second differential of Fbar_i' F_i along the
// first-order stage sensitivities; see framework/design/integrators.md.
#include "saltus/integrators/runge_kutta.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/explicit_steps.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {
namespace {

class RungeKutta final : public Integrator {
 public:
  RungeKutta(const IntervalProblem& problem, ButcherTableau tableau, int steps)
      : Integrator(problem),
        field_(this->problem()),
        tableau_(std::move(tableau)),
        steps_(steps),
        ny_(field_.outputs()),
        nz_(field_.arguments()),
        ne_(field_.entries()),
        y_(ny_),
        stage_(ny_),
        rates_(ny_ * tableau_.stages()),
        z_(nz_),
        entries_(ne_),
        sensitivity_(ny_, field_.directions()),
        stage_sensitivity_(field_.states(), field_.directions()),
        rate_sensitivity_(tableau_.stages(), RowMajorMatrix(ny_, field_.directions())) {
    const int records = steps_ * tableau_.stages();
    record_z_.resize(records * nz_);
    record_phi_.resize(records * ny_);
    record_entries_.resize(records * ne_);
    record_adjoint_.resize(records * ny_);
    record_gradient_.resize(records * nz_);
    costate_.resize(ny_);
    along_.resize(field_.directions());
    curvature_.resize(field_.directions(), field_.directions());
  }

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    const double h = field_.length();
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < tableau_.stages(); ++i) {
        stage_state(i);
        field_.argument(stage_time(n, i), stage_.data(), z_.data());
        field_.value(z_.data(), rate(i));
        for (int r = 0; r < ny_; ++r) rate(i)[r] *= h;
      }
      advance_state();
    }
    return finish(end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    start_sensitivity();
    const double h = field_.length();
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < tableau_.stages(); ++i) {
        const double s = stage_time(n, i);
        stage_state(i);
        stage_sensitivity(i);
        field_.argument(s, stage_.data(), z_.data());
        field_.jacobian(z_.data(), rate(i), entries_.data());
        field_.rate_sensitivity(s, rate(i), entries_.data(), stage_sensitivity_,
                                rate_sensitivity_[i]);
        for (int r = 0; r < ny_; ++r) rate(i)[r] *= h;
      }
      advance_state();
      advance_sensitivity();
    }
    field_.scatter(sensitivity_, derivative);
    const IntegrationStatus status = finish(end);
    if (status == IntegrationStatus::success &&
        !all_finite(sensitivity_.data(), static_cast<int>(sensitivity_.size())))
      return IntegrationStatus::not_finite;
    return status;
  }

  bool has_hessian() const override { return true; }

  IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                            Curvature curvature) override {
    record_forward(w);
    record_backward(weights);
    start_sensitivity();
    curvature_.setZero();
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < tableau_.stages(); ++i) {
        const double s = stage_time(n, i);
        const int k = n * tableau_.stages() + i;
        stage_sensitivity(i);
        field_.rate_sensitivity(s, &record_phi_[k * ny_], &record_entries_[k * ne_],
                                stage_sensitivity_, rate_sensitivity_[i]);
        field_.add_curvature(s, &record_z_[k * nz_], &record_adjoint_[k * ny_], stage_sensitivity_,
                             curvature, curvature_);
        if (curvature == Curvature::exact && field_.differentiates_time()) {
          field_.pull_back(s, &record_gradient_[k * nz_], stage_sensitivity_, along_.data());
          const int last = field_.h_direction();  // h is the last direction
          for (int d = 0; d < last; ++d) curvature_(last, d) += along_[d];
          curvature_(last, last) += 2.0 * along_[last];
        }
      }
      advance_sensitivity();
    }
    field_.scatter_symmetric(curvature_, hessian);
    return all_finite(curvature_.data(), static_cast<int>(curvature_.size()))
               ? IntegrationStatus::success
               : IntegrationStatus::not_finite;
  }

 private:
  double stage_time(int step, int stage) const { return (step + tableau_.c[stage]) / steps_; }
  double* rate(int stage) { return rates_.data() + stage * ny_; }

  void start(const double* w) {
    field_.load(w);
    std::copy_n(w, field_.states(), y_.begin());
    std::fill(y_.begin() + field_.states(), y_.end(), 0.0);
  }

  void start_sensitivity() {
    sensitivity_.setZero();
    for (int i = 0; i < field_.states(); ++i) sensitivity_(i, i) = 1.0;
  }

  void stage_state(int i) {
    std::copy_n(y_.begin(), field_.states(), stage_.begin());
    for (int j = 0; j < i; ++j) {
      const double a = tableau_.a(i, j) / steps_;
      if (a == 0.0) continue;
      for (int r = 0; r < field_.states(); ++r) stage_[r] += a * rate(j)[r];
    }
  }

  void stage_sensitivity(int i) {
    const int count = field_.states() * field_.directions();
    double* out = stage_sensitivity_.data();
    std::copy_n(sensitivity_.data(), count, out);
    for (int j = 0; j < i; ++j) {
      const double a = tableau_.a(i, j) / steps_;
      if (a == 0.0) continue;
      const double* slope = rate_sensitivity_[j].data();
      for (int k = 0; k < count; ++k) out[k] += a * slope[k];
    }
  }

  void advance_state() {
    for (int i = 0; i < tableau_.stages(); ++i) {
      const double b = tableau_.b[i] / steps_;
      if (b == 0.0) continue;
      for (int r = 0; r < ny_; ++r) y_[r] += b * rate(i)[r];
    }
  }

  void advance_sensitivity() {
    const int count = static_cast<int>(sensitivity_.size());
    for (int i = 0; i < tableau_.stages(); ++i) {
      const double b = tableau_.b[i] / steps_;
      if (b == 0.0) continue;
      const double* slope = rate_sensitivity_[i].data();
      for (int k = 0; k < count; ++k) sensitivity_.data()[k] += b * slope[k];
    }
  }

  IntegrationStatus finish(double* end) const {
    std::copy(y_.begin(), y_.end(), end);
    return all_finite(end, ny_) ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  // Argument, rates and Jacobian entries of every stage.
  void record_forward(const double* w) {
    start(w);
    const double h = field_.length();
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < tableau_.stages(); ++i) {
        const int k = n * tableau_.stages() + i;
        stage_state(i);
        field_.argument(stage_time(n, i), stage_.data(), &record_z_[k * nz_]);
        field_.jacobian(&record_z_[k * nz_], &record_phi_[k * ny_], &record_entries_[k * ne_]);
        for (int r = 0; r < ny_; ++r) rate(i)[r] = h * record_phi_[k * ny_ + r];
      }
      advance_state();
    }
  }

  // Adjoints Fbar of the stage rates and phi_z' Fbar.
  void record_backward(const double* weights) {
    const double h = field_.length();
    const int nx = field_.states();
    const int stages = tableau_.stages();
    std::copy_n(weights, ny_, costate_.begin());
    for (int n = steps_ - 1; n >= 0; --n) {
      for (int i = stages - 1; i >= 0; --i) {
        double* adjoint = &record_adjoint_[(n * stages + i) * ny_];
        for (int r = 0; r < ny_; ++r) adjoint[r] = tableau_.b[i] / steps_ * costate_[r];
        for (int j = i + 1; j < stages; ++j) {
          const double a = tableau_.a(j, i) / steps_;
          if (a == 0.0) continue;
          const double* gradient = &record_gradient_[(n * stages + j) * nz_];
          for (int r = 0; r < nx; ++r) adjoint[r] += a * h * gradient[1 + r];
        }
        field_.adjoint(&record_entries_[(n * stages + i) * ne_], adjoint,
                       &record_gradient_[(n * stages + i) * nz_]);
      }
      for (int i = 0; i < stages; ++i)
        for (int r = 0; r < nx; ++r)
          costate_[r] += h * record_gradient_[(n * stages + i) * nz_ + 1 + r];
    }
  }

  IntervalField field_;
  ButcherTableau tableau_;
  int steps_, ny_, nz_, ne_;
  std::vector<double> y_, stage_, rates_, z_, entries_;  // rates_: F = h phi per stage
  RowMajorMatrix sensitivity_, stage_sensitivity_;
  std::vector<RowMajorMatrix> rate_sensitivity_;
  std::vector<double> record_z_, record_phi_, record_entries_, record_adjoint_, record_gradient_;
  std::vector<double> costate_, along_;
  RowMajorMatrix curvature_;
};

class RungeKuttaScheme final : public IntegratorScheme {
 public:
  RungeKuttaScheme(ButcherTableau tableau, RungeKuttaOptions options)
      : tableau_(std::move(tableau)), options_(options) {
    if (options_.steps < 1)
      throw DefinitionError(fmt::format("{} needs at least one step per interval, but steps = {}.",
                                        tableau_.name, options_.steps));
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    if (!problem.switching.empty()) return hybrid_runge_kutta(problem, tableau_, options_.steps);
    return std::make_unique<RungeKutta>(problem, tableau_, options_.steps);
  }
  IntegratorChoice refined() const override {
    return std::make_shared<RungeKuttaScheme>(tableau_,
                                              RungeKuttaOptions{.steps = 2 * options_.steps});
  }
  ExplicitSteps parts() const { return {tableau_, options_.steps}; }
  std::string name() const override {
    return fmt::format("{}, {} step{}", tableau_.name, options_.steps,
                       options_.steps == 1 ? "" : "s");
  }

 private:
  ButcherTableau tableau_;
  RungeKuttaOptions options_;
};

void check(const ButcherTableau& tableau) {
  // Rounding of sums of a dozen coefficients of order one.
  constexpr double rounding = 1e-12;
  const int stages = tableau.stages();
  const auto fail = [&](const std::string& why) {
    throw DefinitionError(fmt::format("the Butcher tableau '{}' {}.", tableau.name, why));
  };
  if (stages < 1 || tableau.a.rows() != stages || tableau.a.cols() != stages ||
      tableau.c.size() != stages)
    fail(fmt::format("needs a square a and a c of the length of b, which is {}", stages));
  for (int i = 0; i < stages; ++i)
    for (int j = i; j < stages; ++j)
      if (tableau.a(i, j) != 0.0) fail("is not explicit: a has an entry on or above the diagonal");
  const VectorXd row_sums = tableau.a.rowwise().sum();
  if (!((row_sums - tableau.c).cwiseAbs().maxCoeff() < rounding))
    fail("is not consistent: c differs from the row sums of a");
  if (!(std::abs(tableau.b.sum() - 1.0) < rounding)) fail("is not consistent: b does not sum to 1");
}

}  // namespace

std::optional<ExplicitSteps> explicit_steps(const IntegratorScheme& scheme) {
  const auto* const own = dynamic_cast<const RungeKuttaScheme*>(&scheme);
  return own == nullptr ? std::optional<ExplicitSteps>() : own->parts();
}

IntegratorChoice runge_kutta(ButcherTableau tableau, RungeKuttaOptions options) {
  check(tableau);
  return std::make_shared<RungeKuttaScheme>(std::move(tableau), options);
}

IntegratorChoice runge_kutta4(RungeKuttaOptions options) {
  return runge_kutta(classical_runge_kutta(), options);
}

IntegratorChoice runge_kutta8(RungeKuttaOptions options) {
  return runge_kutta(cooper_verner(), options);
}

}  // namespace saltus
