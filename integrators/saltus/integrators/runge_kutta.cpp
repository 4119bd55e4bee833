// In scaled time (interval_field.hpp), step = 1 / steps, y = (x | q):
//   Y_i = y_n + step sum_{j<i} a_ij F_j,   F_i = F(s_n + c_i step, X_i),
//   y_{n+1} = y_n + step sum_i b_i F_i.
// First order: the same recursion for dY_i, dF_i. Second order, weighted with lambda at the end:
// adjoints of the stage rates, backward over steps and stages,
//   Fbar_i = step (b_i lambda_{n+1} + sum_{j>i} a_ji Xbar_j),  Xbar_i = h phi_x' Fbar_i,
//   lambda_n = lambda_{n+1} + sum_i Xbar_i   (state rows; lambda of q is constant),
// and the Hessian is the sum over all stages of the second differential of Fbar_i' F_i along the
// stage sensitivities. The forward sweep stores these, so the Hessian includes the Jacobian at no
// extra cost. See framework/design/integrators.md.
#include "saltus/integrators/runge_kutta.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/explicit_steps.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/rows.hpp"

namespace saltus {
namespace {

using rows::padded;
using rows::Weighted;

class RungeKutta final : public Integrator {
 public:
  RungeKutta(const IntervalProblem& problem, const ButcherTableau& tableau, int steps)
      : Integrator(problem),
        field_(this->problem()),
        stages_(tableau.stages()),
        steps_(steps),
        nx_(field_.states()),
        ny_(field_.outputs()),
        columns_(field_.padded_directions()),
        c_(tableau.c),
        before_(stages_),
        after_(stages_),
        y_(padded(ny_)),
        stage_(padded(nx_)),
        rates_(stages_ * padded(ny_)),
        z_(field_.arguments()),
        sensitivity_(RowMajorMatrix::Zero(ny_, columns_)),
        rate_sensitivity_(stages_ * ny_ * columns_),
        records_(steps_ * stages_, Record(field_)),
        adjoint_(padded(ny_)),
        costate_(ny_),
        gradient_(field_.arguments()),
        scaled_gradients_(stages_ * padded(nx_)),
        along_(columns_),
        curvature_(field_.directions(), columns_) {
    const double step = 1.0 / steps_;
    for (int i = 0; i < stages_; ++i) {
      for (int j = 0; j < stages_; ++j) {
        if (tableau.a(i, j) != 0.0) before_[i].push_back({j, step * tableau.a(i, j)});
        if (tableau.a(j, i) != 0.0) after_[i].push_back({j, step * tableau.a(j, i)});
      }
      if (tableau.b[i] != 0.0) end_.push_back({i, step * tableau.b[i]});
      end_weights_.push_back(step * tableau.b[i]);
    }
  }

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < stages_; ++i) {
        find_stage(n, i, z_.data());
        field_.value(z_.data(), rate(i));
        scale_rate(i);
      }
      advance_state();
    }
    return finish(end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    sweep_forward([this](int, int) -> Record& { return records_.front(); });
    return finish(end, derivative);
  }

  bool has_hessian() const override { return true; }

  IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                            Curvature curvature) override {
    start(w);
    sweep_forward([this](int n, int i) -> Record& { return record(n, i); });
    return sweep_back(weights, hessian, curvature);
  }

  IntegrationStatus derivatives(const double* w, const double* weights, double* end,
                                MatrixXd& derivative, MatrixXd& hessian,
                                Curvature curvature) override {
    start(w);
    sweep_forward([this](int n, int i) -> Record& { return record(n, i); });
    const IntegrationStatus status = finish(end, derivative);
    return status == IntegrationStatus::success ? sweep_back(weights, hessian, curvature) : status;
  }

 private:
  // Data of a stage for the backward sweep.
  struct Record {
    explicit Record(const IntervalField& field)
        : z(field.arguments()),
          entries(field.entries()),
          sensitivity(RowMajorMatrix::Zero(field.states(), field.padded_directions())) {}
    std::vector<double> z, entries;
    RowMajorMatrix sensitivity;  // sensitivity of the state
  };

  double stage_time(int step, int stage) const { return (step + c_[stage]) / steps_; }
  double* rate(int stage) { return rates_.data() + stage * padded(ny_); }
  Record& record(int step, int stage) { return records_[step * stages_ + stage]; }

  void start(const double* w) {
    field_.load(w);
    std::copy_n(w, nx_, y_.begin());
    std::fill(y_.begin() + nx_, y_.end(), 0.0);
  }

  // Computes the argument at a stage from the rates of earlier stages.
  void find_stage(int n, int i, double* z) {
    rows::weighted_sum(padded(nx_), y_.data(), before_[i], rates_.data(), padded(ny_),
                       stage_.data());
    field_.argument(stage_time(n, i), stage_.data(), z);
  }

  void scale_rate(int i) {
    const double h = field_.length();
    for (int r = 0; r < padded(ny_); ++r) rate(i)[r] *= h;
  }

  void advance_state() {
    rows::weighted_sum(padded(ny_), y_.data(), end_, rates_.data(), padded(ny_), y_.data());
  }

  // Propagates state and sensitivity to the end. record_of(step, stage) stores the data of a stage.
  template <class RecordOf>
  void sweep_forward(const RecordOf& record_of) {
    const int count = ny_ * columns_;
    sensitivity_.setZero();
    for (int i = 0; i < nx_; ++i) sensitivity_(i, i) = 1.0;
    for (int n = 0; n < steps_; ++n) {
      for (int i = 0; i < stages_; ++i) {
        Record& r = record_of(n, i);
        find_stage(n, i, r.z.data());
        rows::weighted_sum(nx_ * columns_, sensitivity_.data(), before_[i],
                           rate_sensitivity_.data(), count, r.sensitivity.data());
        field_.jacobian(r.z.data(), rate(i), r.entries.data());
        field_.rate_sensitivity(stage_time(n, i), rate(i), r.entries.data(), r.sensitivity,
                                rate_sensitivity_.data() + i * count);
        scale_rate(i);
      }
      advance_state();
      rows::weighted_sum(count, sensitivity_.data(), end_, rate_sensitivity_.data(), count,
                         sensitivity_.data());
    }
  }

  IntegrationStatus finish(double* end) const {
    std::copy_n(y_.begin(), ny_, end);
    return all_finite(end, ny_) ? IntegrationStatus::success : IntegrationStatus::not_finite;
  }

  IntegrationStatus finish(double* end, MatrixXd& derivative) const {
    field_.scatter(sensitivity_, derivative);
    const IntegrationStatus status = finish(end);
    return all_finite(sensitivity_.data(), static_cast<int>(sensitivity_.size()))
               ? status
               : IntegrationStatus::not_finite;
  }

  // Computes the adjoints Fbar of the stage rates and phi_z' Fbar, and adds their curvature.
  IntegrationStatus sweep_back(const double* weights, MatrixXd& hessian, Curvature curvature) {
    const double h = field_.length();
    const bool lengths_matter = curvature == Curvature::exact && field_.differentiates_time();
    curvature_.setZero();
    std::copy_n(weights, ny_, costate_.begin());
    for (int n = steps_ - 1; n >= 0; --n) {
      for (int i = stages_ - 1; i >= 0; --i) {
        const Record& at = record(n, i);
        for (int r = 0; r < ny_; ++r) adjoint_[r] = end_weights_[i] * costate_[r];
        rows::weighted_sum(padded(nx_), adjoint_.data(), after_[i], scaled_gradients_.data(),
                           padded(nx_), adjoint_.data());
        field_.adjoint(at.entries.data(), adjoint_.data(), gradient_.data());
        double* scaled = scaled_gradients_.data() + i * padded(nx_);
        for (int r = 0; r < nx_; ++r) scaled[r] = h * gradient_[1 + r];
        field_.add_curvature(stage_time(n, i), at.z.data(), adjoint_.data(), at.sensitivity,
                             curvature, curvature_);
        if (lengths_matter) add_length(stage_time(n, i), at);
      }
      for (int i = 0; i < stages_; ++i)
        for (int r = 0; r < nx_; ++r) costate_[r] += scaled_gradients_[i * padded(nx_) + r];
    }
    field_.scatter_symmetric(curvature_, hessian);
    return all_finite(curvature_.data(), static_cast<int>(curvature_.size()))
               ? IntegrationStatus::success
               : IntegrationStatus::not_finite;
  }

  // The length multiplies every rate. h is the last direction.
  void add_length(double s, const Record& at) {
    field_.pull_back(s, gradient_.data(), at.sensitivity, along_.data());
    const int last = field_.h_direction();
    for (int d = 0; d < last; ++d) curvature_(last, d) += along_[d];
    curvature_(last, last) += 2.0 * along_[last];
  }

  IntervalField field_;
  int stages_, steps_, nx_, ny_, columns_;
  VectorXd c_;
  // Step times tableau: weights of earlier stages, of later stages, and of the end.
  std::vector<std::vector<Weighted>> before_, after_;
  std::vector<Weighted> end_;
  std::vector<double> end_weights_;
  std::vector<double> y_, stage_, rates_, z_;  // rates_: F = h phi per stage
  RowMajorMatrix sensitivity_;
  std::vector<double> rate_sensitivity_;  // per stage
  std::vector<Record> records_;
  std::vector<double> adjoint_, costate_, gradient_, scaled_gradients_, along_;
  RowMajorMatrix curvature_;
};

class RungeKuttaScheme final : public IntegratorScheme {
 public:
  RungeKuttaScheme(ButcherTableau tableau, RungeKuttaOptions options)
      : tableau_(std::move(tableau)), options_(options) {
    check_steps(tableau_.name, options_.steps);
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    if (!problem.switching.empty()) return hybrid_runge_kutta(problem, tableau_, options_.steps);
    return std::make_unique<RungeKutta>(problem, tableau_, options_.steps);
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
  // Rounding error of sums of a dozen coefficients of order one.
  constexpr double rounding = 1e-12;
  const int stages = tableau.stages();
  const auto fail = [&](const std::string& why) {
    throw DefinitionError(fmt::format("the Butcher tableau '{}' {}.", tableau.name, why));
  };
  if (stages < 1 || tableau.a.rows() != stages || tableau.a.cols() != stages ||
      tableau.c.size() != stages)
    fail(fmt::format("needs a square matrix a and a vector c of the length of b, which is {}",
                     stages));
  for (int i = 0; i < stages; ++i)
    for (int j = i; j < stages; ++j)
      if (tableau.a(i, j) != 0.0) fail("is not explicit: a has an entry on or above the diagonal");
  const VectorXd row_sums = tableau.a.rowwise().sum();
  if (!((row_sums - tableau.c).cwiseAbs().maxCoeff() < rounding))
    fail("is not consistent: c differs from the row sums of a");
  if (!(std::abs(tableau.b.sum() - 1.0) < rounding)) fail("is not consistent: b does not sum to 1");
}

}  // namespace

void check_steps(const std::string& scheme, int steps) {
  constexpr int most = 1'000'000;
  if (steps < 1 || steps > most)
    throw DefinitionError(
        fmt::format("{} needs 1 to {} steps per interval, but steps = {}.", scheme, most, steps));
}

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
