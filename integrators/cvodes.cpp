// Equations: dy/ds = F(s, y), dS_j/ds = F_y S_j + F_theta_j in scaled time, interval_field.hpp.
// Absolute tolerances of S_j: those of y divided by the magnitude of w_j.
// CVODES: A. Hindmarsh, R. Serban and others, User Documentation for CVODES, LLNL.
#include "integrators/cvodes.hpp"

#include <cvodes/cvodes.h>
#include <cvodes/cvodes_ls.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cstdio>

#include "framework/core/error.hpp"
#include "integrators/interval_field.hpp"
#include "integrators/sundials_support.hpp"

namespace saltus {
namespace {

using sundials::callback_recoverable;
using sundials::callback_success;
using sundials::require;

IntegrationStatus status_of(int code) {
  if (code >= 0) return IntegrationStatus::success;  // CV_TSTOP_RETURN included
  switch (code) {
    case CV_TOO_MUCH_WORK:
      return IntegrationStatus::too_many_steps;
    case CV_TOO_MUCH_ACC:
    case CV_ERR_FAILURE:
    case CV_CONV_FAILURE:
    case CV_NLS_FAIL:
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
      return IntegrationStatus::step_too_small;
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
    case CV_SRHSFUNC_FAIL:
    case CV_FIRST_SRHSFUNC_ERR:
    case CV_REPTD_SRHSFUNC_ERR:
    case CV_UNREC_SRHSFUNC_ERR:
      return IntegrationStatus::not_finite;
    default:
      return IntegrationStatus::library_failure;
  }
}

struct FreeCvode {
  void operator()(void* memory) const { CVodeFree(&memory); }
};

class Cvodes final : public Integrator {
 public:
  Cvodes(const IntervalProblem& definition, const CvodesOptions& options)
      : Integrator(definition),
        field_(problem()),
        options_(options),
        absolute_(sundials::absolute_tolerances(problem(), options.absolute_tolerance)),
        y_(field_.outputs(), context_),
        sensitivity_(field_.directions(), y_),
        sensitivity_tolerance_(field_.directions(), y_),
        sensitivity_scale_(field_.directions(), 1.0),
        z_(field_.arguments()),
        phi_(field_.outputs()),
        entries_(field_.entries()),
        end_sensitivity_(field_.outputs(), field_.directions()) {
    create_state_solver();
    create_sensitivity_solver();
  }

  IntegrationStatus value(const double* w, double* end) override {
    start(w);
    int code = CVodeReInit(memory_.get(), 0.0, y_);
    if (code >= 0) code = CVodeSensToggleOff(memory_.get());
    if (code >= 0) code = integrate();
    return finish(code, end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w);
    start_sensitivity();
    int code = CVodeReInit(memory_.get(), 0.0, y_);
    if (code >= 0) code = CVodeSensReInit(memory_.get(), sensitivity_method(), sensitivity_);
    if (code >= 0 && update_sensitivity_tolerances(w))
      code = CVodeSensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_);
    if (code >= 0) code = integrate();
    if (code >= 0) {
      double reached = 0.0;
      code = CVodeGetSens(memory_.get(), &reached, sensitivity_);
    }
    for (int d = 0; d < field_.directions(); ++d)
      for (int r = 0; r < field_.outputs(); ++r) end_sensitivity_(r, d) = sensitivity_.data(d)[r];
    field_.scatter(end_sensitivity_, derivative);
    const IntegrationStatus status = finish(code, end);
    if (status == IntegrationStatus::success &&
        !all_finite(end_sensitivity_.data(), static_cast<int>(end_sensitivity_.size())))
      return IntegrationStatus::not_finite;
    return status;
  }

 private:
  void create_state_solver() {
    const bool stiff = options_.method == CvodesMethod::Bdf;
    memory_.reset(CVodeCreate(stiff ? CV_BDF : CV_ADAMS, context_));
    require(memory_.get(), "CVodeCreate");
#if SUNDIALS_VERSION_MAJOR < 7
    require(CVodeSetErrHandlerFn(
                memory_.get(), [](int, const char*, const char*, char*, void*) {}, nullptr),
            "CVodeSetErrHandlerFn");
#endif
    require(CVodeInit(memory_.get(), rate, 0.0, y_), "CVodeInit");
    require(CVodeSetUserData(memory_.get(), this), "CVodeSetUserData");
    sundials::Vector tolerances(field_.outputs(), context_);
    std::copy(absolute_.begin(), absolute_.end(), tolerances.data());
    require(CVodeSVtolerances(memory_.get(), options_.tolerance, tolerances), "CVodeSVtolerances");
    require(CVodeSetMaxNumSteps(memory_.get(), options_.max_steps), "CVodeSetMaxNumSteps");
    require(CVodeSetMaxHnilWarns(memory_.get(), -1), "CVodeSetMaxHnilWarns");
    if (stiff) {
      matrix_.reset(SUNDenseMatrix(field_.outputs(), field_.outputs(), context_));
      require(matrix_.get(), "SUNDenseMatrix");
      linear_.reset(SUNLinSol_Dense(y_, matrix_.get(), context_));
      require(linear_.get(), "SUNLinSol_Dense");
      require(CVodeSetLinearSolver(memory_.get(), linear_.get(), matrix_.get()),
              "CVodeSetLinearSolver");
      require(CVodeSetJacFn(memory_.get(), state_jacobian), "CVodeSetJacFn");
    } else {
      nonlinear_.reset(SUNNonlinSol_FixedPoint(y_, 0, context_));
      require(nonlinear_.get(), "SUNNonlinSol_FixedPoint");
      require(CVodeSetNonlinearSolver(memory_.get(), nonlinear_.get()), "CVodeSetNonlinearSolver");
    }
  }

  void create_sensitivity_solver() {
    const int count = field_.directions();
    for (int d = 0; d < count; ++d)
      std::copy(absolute_.begin(), absolute_.end(), sensitivity_tolerance_.data(d));
    require(
        CVodeSensInit(memory_.get(), count, sensitivity_method(), sensitivity_rate, sensitivity_),
        "CVodeSensInit");
    require(CVodeSensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_),
            "CVodeSensSVtolerances");
    require(CVodeSetSensErrCon(memory_.get(), SUNTRUE), "CVodeSetSensErrCon");
    if (options_.method == CvodesMethod::Bdf) return;  // CVODES made a Newton solver itself
    if (options_.sensitivity == CvodesSensitivity::staggered) {
      sensitivity_nonlinear_.reset(SUNNonlinSol_FixedPointSens(count, y_, 0, context_));
      require(sensitivity_nonlinear_.get(), "SUNNonlinSol_FixedPointSens");
      require(CVodeSetNonlinearSolverSensStg(memory_.get(), sensitivity_nonlinear_.get()),
              "CVodeSetNonlinearSolverSensStg");
    } else {
      sensitivity_nonlinear_.reset(SUNNonlinSol_FixedPointSens(count + 1, y_, 0, context_));
      require(sensitivity_nonlinear_.get(), "SUNNonlinSol_FixedPointSens");
      require(CVodeSetNonlinearSolverSensSim(memory_.get(), sensitivity_nonlinear_.get()),
              "CVodeSetNonlinearSolverSensSim");
    }
  }

  int sensitivity_method() const {
    return options_.sensitivity == CvodesSensitivity::staggered ? CV_STAGGERED : CV_SIMULTANEOUS;
  }

  void start(const double* w) {
    field_.load(w);
    std::copy_n(w, field_.states(), y_.data());
    std::fill_n(y_.data() + field_.states(), field_.outputs() - field_.states(), 0.0);
  }

  void start_sensitivity() {
    for (int d = 0; d < field_.directions(); ++d) {
      N_VConst(0.0, sensitivity_[d]);
      if (d < field_.states()) sensitivity_.data(d)[d] = 1.0;
    }
  }

  // Whether they changed: CVODES allocates when it takes over new ones.
  bool update_sensitivity_tolerances(const double* w) {
    bool changed = false;
    for (int d = 0; d < field_.directions(); ++d) {
      const double scale = sundials::direction_scale(problem(), w, field_.column(d));
      if (scale == sensitivity_scale_[d]) continue;
      changed = true;
      sensitivity_scale_[d] = scale;
      for (int r = 0; r < field_.outputs(); ++r)
        sensitivity_tolerance_.data(d)[r] = absolute_[r] / scale;
    }
    return changed;
  }

  // The stop time keeps the functions from being called beyond the end; CVODES forgets it once
  // it was reached.
  int integrate() {
    const int code = CVodeSetStopTime(memory_.get(), 1.0);
    if (code < 0) return code;
    double reached = 0.0;
    return CVode(memory_.get(), 1.0, y_, &reached, CV_NORMAL);
  }

  IntegrationStatus finish(int code, double* end) const {
    std::copy_n(y_.data(), field_.outputs(), end);
    const IntegrationStatus status = status_of(code);
    if (status == IntegrationStatus::success && !all_finite(end, field_.outputs()))
      return IntegrationStatus::not_finite;
    return status;
  }

  static int rate(sunrealtype s, N_Vector y, N_Vector rates, void* user) {
    Cvodes& self = *static_cast<Cvodes*>(user);
    self.field_.argument(s, N_VGetArrayPointer(y), self.z_.data());
    double* out = N_VGetArrayPointer(rates);
    self.field_.value(self.z_.data(), out);
    for (int r = 0; r < self.field_.outputs(); ++r) out[r] *= self.field_.length();
    return all_finite(out, self.field_.outputs()) ? callback_success : callback_recoverable;
  }

  static int state_jacobian(sunrealtype s, N_Vector y, N_Vector, SUNMatrix matrix, void* user,
                            N_Vector, N_Vector, N_Vector) {
    Cvodes& self = *static_cast<Cvodes*>(user);
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    self.field_.scaled_state_jacobian(self.entries_.data(), SUNDenseMatrix_Data(matrix));
    return callback_success;
  }

  static int sensitivity_rate(int count, sunrealtype s, N_Vector y, N_Vector, N_Vector* sensitivity,
                              N_Vector* rates, void* user, N_Vector, N_Vector) {
    Cvodes& self = *static_cast<Cvodes*>(user);
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    for (int d = 0; d < count; ++d)
      self.field_.rate_sensitivity(s, self.phi_.data(), self.entries_.data(), d,
                                   N_VGetArrayPointer(sensitivity[d]),
                                   N_VGetArrayPointer(rates[d]));
    return callback_success;
  }

  bool evaluate_jacobian(double s, const double* x) {
    field_.argument(s, x, z_.data());
    field_.jacobian(z_.data(), phi_.data(), entries_.data());
    return all_finite(entries_.data(), static_cast<int>(entries_.size()));
  }

  sundials::Context context_;  // outlives everything made in it
  IntervalField field_;
  CvodesOptions options_;
  std::vector<double> absolute_;
  sundials::Vector y_;
  sundials::VectorArray sensitivity_, sensitivity_tolerance_;
  std::vector<double> sensitivity_scale_;
  sundials::Matrix matrix_;
  sundials::LinearSolver linear_;
  sundials::NonlinearSolver nonlinear_, sensitivity_nonlinear_;
  std::unique_ptr<void, FreeCvode> memory_;
  std::vector<double> z_, phi_, entries_;
  RowMajorMatrix end_sensitivity_;
};

class CvodesScheme final : public IntegratorScheme {
 public:
  explicit CvodesScheme(const CvodesOptions& options) : options_(options) {
    if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
      throw DefinitionError("the relative tolerance of CVODES must lie between 0 and 1, but is " +
                            std::to_string(options.tolerance) + ".");
    if (!(options.absolute_tolerance >= 0.0))
      throw DefinitionError("the absolute tolerance of CVODES must not be negative, but is " +
                            std::to_string(options.absolute_tolerance) + ".");
    if (options.max_steps < 1)
      throw DefinitionError("CVODES needs at least one step, but max_steps = " +
                            std::to_string(options.max_steps) + ".");
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    return std::make_unique<Cvodes>(problem, options_);
  }
  std::string name() const override {
    char text[64];
    std::snprintf(text, sizeof text, "CVODES %s, tolerance %.0e",
                  options_.method == CvodesMethod::Bdf ? "BDF" : "Adams", options_.tolerance);
    return text;
  }

 private:
  CvodesOptions options_;
};

}  // namespace

IntegratorChoice cvodes(CvodesOptions options) { return std::make_shared<CvodesScheme>(options); }

}  // namespace saltus
