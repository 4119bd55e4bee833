#include "saltus/integrators/sundials.hpp"

#include <algorithm>
#include <cstdio>

#include "saltus/integrators/cvodes_memory.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {
namespace {

class Cvodes final : public Integrator {
 public:
  Cvodes(const IntervalProblem& definition, const CvodesOptions& options)
      : Integrator(definition),
        field_(problem()),
        memory_(problem(), options, field_, field_.entries()),
        end_sensitivity_(field_.outputs(), field_.directions()) {}

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    int code = memory_.begin(0.0, w, false);
    double reached = 0.0;
    if (code >= 0) code = memory_.advance(CV_NORMAL, reached);
    return finish(code, end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    for (int d = 0; d < field_.directions(); ++d) {
      std::fill_n(memory_.sensitivity(d), field_.outputs(), 0.0);
      if (d < field_.states()) memory_.sensitivity(d)[d] = 1.0;
    }
    int code = memory_.begin(0.0, w, true);
    double reached = 0.0;
    if (code >= 0) code = memory_.advance(CV_NORMAL, reached);
    if (code >= 0) code = memory_.read_sensitivity();
    for (int d = 0; d < field_.directions(); ++d)
      for (int r = 0; r < field_.outputs(); ++r) end_sensitivity_(r, d) = memory_.sensitivity(d)[r];
    field_.scatter(end_sensitivity_, derivative);
    const IntegrationStatus status = finish(code, end);
    if (status == IntegrationStatus::success &&
        !all_finite(end_sensitivity_.data(), static_cast<int>(end_sensitivity_.size())))
      return IntegrationStatus::not_finite;
    return status;
  }

 private:
  void start(const double* w) {
    field_.load(w);
    std::copy_n(w, field_.states(), memory_.state());
    std::fill_n(memory_.state() + field_.states(), field_.outputs() - field_.states(), 0.0);
  }

  IntegrationStatus finish(int code, double* end) const {
    std::copy_n(memory_.state(), field_.outputs(), end);
    const IntegrationStatus status = sundials::status_of_cvode(code);
    if (status == IntegrationStatus::success && !all_finite(end, field_.outputs()))
      return IntegrationStatus::not_finite;
    return status;
  }

  IntervalField field_;
  sundials::CvodesMemory memory_;
  RowMajorMatrix end_sensitivity_;
};

class CvodesScheme final : public IntegratorScheme {
 public:
  explicit CvodesScheme(const CvodesOptions& options) : options_(options) {
    sundials::check_options("CVODES", options.tolerance, options.absolute_tolerance,
                            options.max_steps);
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    if (!problem.switching.empty()) return hybrid_cvodes(problem, options_);
    return std::make_unique<Cvodes>(problem, options_);
  }
  std::string name() const override {
    char text[64];
    std::snprintf(text, sizeof text, "CVODES %s, tolerance %.0e",
                  options_.method == CvodesOptions::Method::Bdf ? "BDF" : "Adams",
                  options_.tolerance);
    return text;
  }

 private:
  CvodesOptions options_;
};

}  // namespace

IntegratorChoice cvodes(CvodesOptions options) { return std::make_shared<CvodesScheme>(options); }

}  // namespace saltus
