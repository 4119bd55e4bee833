// CVODES: A. Hindmarsh, R. Serban and others, User Documentation for CVODES, LLNL.
#include "saltus/integrators/cvodes_memory.hpp"

#include <cvodes/cvodes_ls.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>

namespace saltus::sundials {

IntegrationStatus status_of_cvode(int code) {
  if (code >= 0) return IntegrationStatus::success;  // includes CV_TSTOP_RETURN
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

CvodesMemory::CvodesMemory(const IntervalProblem& problem, const CvodesOptions& options,
                           const IntervalField& field, int entries)
    : problem_(problem),
      options_(options),
      field_(&field),
      outputs_(field.outputs()),
      directions_(field.directions()),
      absolute_(absolute_tolerances(problem, options.absolute_tolerance)),
      y_(outputs_, context_),
      inside_(outputs_, context_),
      sensitivity_(directions_, y_),
      sensitivity_tolerance_(directions_, y_),
      sensitivity_scale_(directions_, 1.0),
      z_(field.arguments()),
      phi_(outputs_),
      entries_(entries) {
  create_state_solver();
  create_sensitivity_solver();
}

void CvodesMemory::create_state_solver() {
  const bool stiff = options_.method == CvodesOptions::Method::Bdf;
  memory_.reset(CVodeCreate(stiff ? CV_BDF : CV_ADAMS, context_));
  require(memory_.get(), "CVodeCreate");
#if SUNDIALS_VERSION_MAJOR < 7
  require(CVodeSetErrHandlerFn(
              memory_.get(), [](int, const char*, const char*, char*, void*) {}, nullptr),
          "CVodeSetErrHandlerFn");
#endif
  require(CVodeInit(memory_.get(), rate, 0.0, y_), "CVodeInit");
  require(CVodeSetUserData(memory_.get(), this), "CVodeSetUserData");
  Vector tolerances(outputs_, context_);
  std::copy(absolute_.begin(), absolute_.end(), tolerances.data());
  require(CVodeSVtolerances(memory_.get(), options_.tolerance, tolerances), "CVodeSVtolerances");
  require(CVodeSetMaxNumSteps(memory_.get(), options_.max_steps), "CVodeSetMaxNumSteps");
  require(CVodeSetMaxHnilWarns(memory_.get(), -1), "CVodeSetMaxHnilWarns");
  if (stiff) {
    matrix_.reset(SUNDenseMatrix(outputs_, outputs_, context_));
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

void CvodesMemory::create_sensitivity_solver() {
  const int count = field_->directions();
  for (int d = 0; d < count; ++d)
    std::copy(absolute_.begin(), absolute_.end(), sensitivity_tolerance_.data(d));
  require(CVodeSensInit(memory_.get(), count, sensitivity_method(), sensitivity_rate, sensitivity_),
          "CVodeSensInit");
  require(CVodeSensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_),
          "CVodeSensSVtolerances");
  require(CVodeSetSensErrCon(memory_.get(), SUNTRUE), "CVodeSetSensErrCon");
  if (options_.method == CvodesOptions::Method::Bdf)
    return;  // CVODES creates a Newton solver itself
  if (options_.sensitivity == CvodesOptions::Sensitivity::staggered) {
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

int CvodesMemory::sensitivity_method() const {
  return options_.sensitivity == CvodesOptions::Sensitivity::staggered ? CV_STAGGERED
                                                                       : CV_SIMULTANEOUS;
}

// Returns true if they changed: CVODES allocates when it copies new tolerances.
bool CvodesMemory::update_sensitivity_tolerances(const double* w) {
  bool changed = false;
  for (int d = 0; d < field_->directions(); ++d) {
    const double scale = direction_scale(problem_, w, field_->column(d));
    if (scale == sensitivity_scale_[d]) continue;
    changed = true;
    sensitivity_scale_[d] = scale;
    for (int r = 0; r < outputs_; ++r) sensitivity_tolerance_.data(d)[r] = absolute_[r] / scale;
  }
  return changed;
}

int CvodesMemory::rate(sunrealtype s, N_Vector y, N_Vector rates, void* user) {
  CvodesMemory& self = *static_cast<CvodesMemory*>(user);
  return self.exception_.keep([&] {
    return self.evaluate(s, N_VGetArrayPointer(y), N_VGetArrayPointer(rates))
               ? callback_success
               : callback_recoverable;
  });
}

int CvodesMemory::state_jacobian(sunrealtype s, N_Vector y, N_Vector, SUNMatrix matrix, void* user,
                                 N_Vector, N_Vector, N_Vector) {
  CvodesMemory& self = *static_cast<CvodesMemory*>(user);
  return self.exception_.keep([&] {
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    self.field_->scaled_state_jacobian(self.entries_.data(), SUNDenseMatrix_Data(matrix));
    return callback_success;
  });
}

int CvodesMemory::sensitivity_rate(int count, sunrealtype s, N_Vector y, N_Vector,
                                   N_Vector* sensitivity, N_Vector* rates, void* user, N_Vector,
                                   N_Vector) {
  CvodesMemory& self = *static_cast<CvodesMemory*>(user);
  return self.exception_.keep([&] {
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    for (int d = 0; d < count; ++d)
      self.field_->rate_sensitivity(s, self.phi_.data(), self.entries_.data(), d,
                                    N_VGetArrayPointer(sensitivity[d]),
                                    N_VGetArrayPointer(rates[d]));
    return callback_success;
  });
}

bool CvodesMemory::evaluate_jacobian(double s, const double* x) {
  field_->argument(s, x, z_.data());
  field_->jacobian(z_.data(), phi_.data(), entries_.data());
  return all_finite(entries_.data(), field_->entries());
}

int CvodesMemory::begin(double s, const double* w, bool sensitivities) {
  int code = CVodeReInit(memory_.get(), s, y_);
  if (sensitivities) {
    if (code >= 0) code = CVodeSensReInit(memory_.get(), sensitivity_method(), sensitivity_);
    if (code >= 0 && update_sensitivity_tolerances(w))
      code = CVodeSensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_);
  } else if (code >= 0) {
    code = CVodeSensToggleOff(memory_.get());
  }
  // The stop time prevents function calls beyond the end. CVODES discards it after reaching it.
  return code >= 0 ? CVodeSetStopTime(memory_.get(), 1.0) : code;
}

int CvodesMemory::advance(int task, double& reached) {
  const int code = CVode(memory_.get(), 1.0, y_, &reached, task);
  exception_.rethrow();
  // A step that underflows to zero ends with a success and the state of the start.
  double own_time = 0.0;
  if (code >= 0) CVodeGetCurrentTime(memory_.get(), &own_time);
  return code >= 0 && own_time < reached ? CV_ERR_FAILURE : code;
}

int CvodesMemory::read_sensitivity() {
  double reached = 0.0;
  return CVodeGetSens(memory_.get(), &reached, sensitivity_);
}

int CvodesMemory::interpolate(double s, double* y) {
  const int code = CVodeGetDky(memory_.get(), s, 0, inside_);
  std::copy_n(inside_.data(), outputs_, y);
  return code;
}

int CvodesMemory::interpolate_sensitivity(double s) {
  return CVodeGetSensDky(memory_.get(), s, 0, sensitivity_);
}

bool CvodesMemory::evaluate(double s, const double* y, double* rates) {
  field_->argument(s, y, z_.data());
  field_->value(z_.data(), rates);
  for (int r = 0; r < outputs_; ++r) rates[r] *= field_->length();
  return all_finite(rates, outputs_);
}

}  // namespace saltus::sundials
