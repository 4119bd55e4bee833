#include "saltus/integrators/sundials.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "saltus/integrators/algebraic_field.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/idas_memory.hpp"
#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {
namespace {

class Idas final : public Integrator {
 public:
  Idas(const IntervalProblem& definition, const IdasOptions& options)
      : Integrator(definition),
        extended_(with_algebraic_states(problem())),
        field_(extended_),
        memory_(problem(), options, field_, field_.entries(), problem().algebraic.equations.get()),
        extended_w_(arguments().size() + field_.states() - arguments().nx),
        rates_(field_.outputs()),
        quadrature_(gauss_legendre_tableau(4)) {}

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    if (field_.length() == 0.0) return finish(IDA_SUCCESS, end);
    int code = memory_.begin(0.0, w, false);
    double reached = 0.0;
    if (code >= 0) code = memory_.advance(sundials::IdasMemory::until_end, reached);
    return finish(code, end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    if (field_.length() == 0.0) return at_length_zero(end, derivative);
    const int nx = arguments().nx, nz = field_.states() - nx;
    for (int d = 0; d < memory_.directions(); ++d) {
      std::fill_n(memory_.sensitivity(d), field_.outputs(), 0.0);
      if (d < nx) memory_.sensitivity(d)[d] = 1.0;
    }
    int code = memory_.begin(0.0, w, true);
    double reached = 0.0;
    if (code >= 0) code = memory_.advance(sundials::IdasMemory::until_end, reached);
    if (code >= 0) code = memory_.read_sensitivity();
    const IntegrationStatus status = finish(code, end);
    derivative.setZero();
    for (int d = 0; d < memory_.directions(); ++d) {
      const int column = d < nx ? d : field_.column(d + nz) - nz;
      for (int r = 0; r < outputs(); ++r)
        derivative(r, column) = memory_.sensitivity(d)[r < nx ? r : r + nz];
    }
    if (status == IntegrationStatus::success && !derivative.allFinite())
      return IntegrationStatus::not_finite;
    return status;
  }

 private:
  // The identity, plus the mean of f and L along the input ramp. With a constant state, IDAS would
  // stay at order 1.
  IntegrationStatus at_length_zero(double* end, MatrixXd& derivative) {
    const int nx = arguments().nx, nz = field_.states() - nx;
    derivative.setZero();
    derivative.topLeftCorner(nx, nx).setIdentity();
    if (field_.differentiates_time()) {
      constexpr int pieces = 16;  // each of order 8
      for (int k = 0; k < pieces; ++k)
        for (int i = 0; i < quadrature_.stages(); ++i) {
          const double s = (k + quadrature_.c[i]) / pieces;
          if (memory_.begin(s, nullptr, false) < 0) return IntegrationStatus::not_finite;
          memory_.rates_at(s, rates_.data());
          for (int r = 0; r < outputs(); ++r)
            derivative(r, arguments().h()) +=
                quadrature_.b[i] / pieces * rates_[r < nx ? r : r + nz];
        }
    }
    const IntegrationStatus status = finish(IDA_SUCCESS, end);
    return derivative.allFinite() ? status : IntegrationStatus::not_finite;
  }

  void start(const double* w) {
    const int nx = arguments().nx, nz = field_.states() - nx;
    std::copy_n(w, nx, extended_w_.begin());
    std::fill_n(extended_w_.begin() + nx, nz, 0.0);  // z has no entries in w
    std::copy(w + nx, w + arguments().size(), extended_w_.begin() + nx + nz);
    field_.load(extended_w_.data());
    std::copy_n(w, nx, memory_.state());
    std::fill_n(memory_.state() + nx, outputs() - nx + nz, 0.0);
  }

  IntegrationStatus finish(int code, double* end) const {
    const int nx = arguments().nx;
    std::copy_n(memory_.state(), nx, end);
    std::copy_n(memory_.state() + memory_.first_cost(), outputs() - nx, end + nx);
    const IntegrationStatus status = sundials::status_of_ida(code);
    if (status == IntegrationStatus::success && !all_finite(end, outputs()))
      return IntegrationStatus::not_finite;
    return status;
  }

  IntervalProblem extended_;
  IntervalField field_;
  sundials::IdasMemory memory_;
  std::vector<double> extended_w_, rates_;
  ButcherTableau quadrature_;
};

class IdasScheme final : public IntegratorScheme {
 public:
  explicit IdasScheme(const IdasOptions& options) : options_(options) {
    sundials::check_options("IDAS", options.tolerance, options.absolute_tolerance,
                            options.max_steps);
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    if (!problem.switching.empty()) return hybrid_idas(problem, options_);
    return std::make_unique<Idas>(problem, options_);
  }
  std::string name() const override {
    char text[64];
    std::snprintf(text, sizeof text, "IDAS, tolerance %.0e", options_.tolerance);
    return text;
  }

 private:
  IdasOptions options_;
};

}  // namespace

IntegratorChoice idas(IdasOptions options) { return std::make_shared<IdasScheme>(options); }

}  // namespace saltus
