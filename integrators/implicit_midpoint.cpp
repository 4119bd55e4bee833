// In scaled time (interval_field.hpp), D = 1 / steps, s the middle of step n, y = (x | q):
//   X = x_n + D/2 F_x(s, X),   y_{n+1} = y_n + D F(s, X).
// First order: (I - D/2 F_xX) dX = dx_n + D/2 F_theta dtheta, and the differential of y_{n+1}.
// Second order, weighted with lambda at the end: the multiplier Fbar of F = F(s, X) solves
//   (I - D/2 F_xX') Fbar_x = D lambda_x + D/2 F_qX' Fbar_q,   Fbar_q = D lambda_q,
//   lambda_n = lambda_{n+1} + F_X' Fbar   (rows of x),
// and the Hessian is the sum over all steps of the second differential of Fbar' F along dX; see
// framework/design/integrators.md. E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
// Integration, 2nd ed., sec. II.1 and IV.2.
#include "saltus/integrators/implicit_midpoint.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {
namespace {

// Newton's method converges quadratically: a correction this small is followed by rounding.
constexpr double last_correction = 1e-10;  // relative to 1 + |X|
constexpr int most_corrections = 25;

class ImplicitMidpoint final : public Integrator {
 public:
  ImplicitMidpoint(const IntervalProblem& problem, int steps)
      : Integrator(problem),
        field_(this->problem()),
        nx_(field_.states()),
        ny_(field_.outputs()),
        y_(ny_),
        middle_(nx_),
        residual_(nx_),
        correction_(nx_),
        slope_(ny_, ny_),
        matrix_(nx_, nx_),
        sensitivity_(ny_, field_.directions()),
        middle_sensitivity_(nx_, field_.directions()),
        right_side_(nx_, field_.directions()),
        rate_sensitivity_(ny_, field_.directions()),
        costate_(ny_),
        along_(field_.directions()),
        curvature_(field_.directions(), field_.directions()),
        steps_(steps, Step(field_)) {}

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    for (Step& step : steps_)
      if (!advance(step)) return status_;
    return finish(end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    start_sensitivity();
    for (Step& step : steps_) {
      if (!advance(step)) return status_;
      sensitivity_at_the_middle(step);
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
    for (Step& step : steps_)
      if (!advance(step)) return status_;
    sweep_back(weights);
    start_sensitivity();
    curvature_.setZero();
    for (const Step& step : steps_) {
      sensitivity_at_the_middle(step);
      field_.add_curvature(time_of(step), step.z.data(), step.adjoint.data(), middle_sensitivity_,
                           curvature, curvature_);
      if (curvature == Curvature::exact && field_.differentiates_time()) {
        field_.pull_back(time_of(step), step.gradient.data(), middle_sensitivity_, along_.data());
        const int last = field_.h_direction();  // h is the last direction
        curvature_.row(last) += along_.transpose();
        curvature_(last, last) += along_[last];
      }
      advance_sensitivity();
    }
    field_.scatter_symmetric(curvature_, hessian);
    return curvature_.allFinite() ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

 private:
  // What is known at the middle of a step.
  struct Step {
    explicit Step(const IntervalField& field)
        : z(field.arguments()),
          phi(field.outputs()),
          entries(field.entries()),
          adjoint(field.outputs()),
          gradient(field.arguments()),
          factors(field.states()) {}
    VectorXd z, phi, entries;               // argument, rates and entries of the Jacobian
    VectorXd adjoint;                       // Fbar
    VectorXd gradient;                      // phi_z' Fbar
    Eigen::PartialPivLU<MatrixXd> factors;  // of I - D/2 F_xX
  };

  double step_length() const { return 1.0 / static_cast<double>(steps_.size()); }
  double time_of(const Step& step) const {
    return (static_cast<double>(&step - steps_.data()) + 0.5) * step_length();
  }

  void start(const double* w) {
    field_.load(w);
    std::copy_n(w, nx_, y_.data());
    y_.tail(ny_ - nx_).setZero();
  }

  // Evaluates at middle_ and factors the matrix of its equation.
  void evaluate(Step& step) {
    field_.argument(time_of(step), middle_.data(), step.z.data());
    field_.jacobian(step.z.data(), step.phi.data(), step.entries.data());
    field_.scaled_state_jacobian(step.entries.data(), slope_.data());
    matrix_ = -0.5 * step_length() * slope_.topLeftCorner(nx_, nx_);
    matrix_.diagonal().array() += 1.0;
    step.factors.compute(matrix_);
  }

  bool advance(Step& step) {
    middle_ = y_.head(nx_);
    for (int k = 0;; ++k) {
      evaluate(step);
      residual_ = middle_ - y_.head(nx_);
      residual_ -= 0.5 * step_length() * field_.length() * step.phi.head(nx_);
      correction_ = step.factors.solve(residual_);
      if (!correction_.allFinite()) return fail(IntegrationStatus::not_finite);
      middle_ -= correction_;
      const double size = correction_.lpNorm<Eigen::Infinity>();
      if (size <= last_correction * (1.0 + middle_.lpNorm<Eigen::Infinity>())) break;
      if (k == most_corrections) return fail(IntegrationStatus::step_too_small);
    }
    evaluate(step);
    y_ += step_length() * field_.length() * step.phi;
    return true;
  }

  bool fail(IntegrationStatus status) {
    status_ = status;
    return false;
  }

  IntegrationStatus finish(double* end) const {
    std::copy_n(y_.data(), ny_, end);
    return y_.allFinite() ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  void start_sensitivity() {
    sensitivity_.setZero();
    for (int i = 0; i < nx_; ++i) sensitivity_(i, i) = 1.0;
  }

  void sensitivity_at_the_middle(const Step& step) {
    middle_sensitivity_.setZero();
    field_.rate_sensitivity(time_of(step), step.phi.data(), step.entries.data(),
                            middle_sensitivity_, rate_sensitivity_);
    right_side_ = sensitivity_.topRows(nx_) + 0.5 * step_length() * rate_sensitivity_.topRows(nx_);
    middle_sensitivity_ = step.factors.solve(right_side_);
    field_.rate_sensitivity(time_of(step), step.phi.data(), step.entries.data(),
                            middle_sensitivity_, rate_sensitivity_);
  }

  void advance_sensitivity() { sensitivity_ += step_length() * rate_sensitivity_; }

  void sweep_back(const double* weights) {
    const int nq = ny_ - nx_;
    const double D = step_length();
    costate_ = Eigen::Map<const VectorXd>(weights, ny_);
    for (auto it = steps_.rbegin(); it != steps_.rend(); ++it) {
      Step& step = *it;
      field_.scaled_state_jacobian(step.entries.data(), slope_.data());
      step.adjoint.tail(nq) = D * costate_.tail(nq);
      residual_ = D * costate_.head(nx_);
      residual_.noalias() +=
          0.5 * D * slope_.bottomLeftCorner(nq, nx_).transpose() * step.adjoint.tail(nq);
      solve_transposed(step.factors, step.adjoint);
      field_.adjoint(step.entries.data(), step.adjoint.data(), step.gradient.data());
      costate_.head(nx_) += field_.length() * step.gradient.segment(1, nx_);
    }
  }

  // adjoint.head(nx) = (P' L U)'^-1 residual_; that of Eigen allocates.
  void solve_transposed(const Eigen::PartialPivLU<MatrixXd>& factors, VectorXd& adjoint) {
    const MatrixXd& LU = factors.matrixLU();
    LU.triangularView<Eigen::Upper>().transpose().solveInPlace(residual_);
    LU.triangularView<Eigen::UnitLower>().transpose().solveInPlace(residual_);
    adjoint.head(nx_) = factors.permutationP().transpose() * residual_;
  }

  IntervalField field_;
  int nx_, ny_;
  VectorXd y_, middle_, residual_, correction_;
  MatrixXd slope_, matrix_;
  RowMajorMatrix sensitivity_, middle_sensitivity_, right_side_, rate_sensitivity_;
  VectorXd costate_, along_;
  RowMajorMatrix curvature_;
  std::vector<Step> steps_;
  IntegrationStatus status_ = IntegrationStatus::success;
};

class ImplicitMidpointScheme final : public IntegratorScheme {
 public:
  explicit ImplicitMidpointScheme(ImplicitMidpointOptions options) : options_(options) {
    if (options_.steps < 1)
      throw DefinitionError(fmt::format(
          "the implicit midpoint rule needs at least one step per interval, but steps = {}.",
          options_.steps));
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    refuse_events(problem, "The implicit midpoint rule");
    return std::make_unique<ImplicitMidpoint>(problem, options_.steps);
  }
  IntegratorChoice refined() const override {
    return implicit_midpoint({.steps = 2 * options_.steps});
  }
  std::string name() const override {
    return fmt::format("implicit midpoint, {} step{}", options_.steps,
                       options_.steps == 1 ? "" : "s");
  }

 private:
  ImplicitMidpointOptions options_;
};

}  // namespace

IntegratorChoice implicit_midpoint(ImplicitMidpointOptions options) {
  return std::make_shared<ImplicitMidpointScheme>(options);
}

}  // namespace saltus
