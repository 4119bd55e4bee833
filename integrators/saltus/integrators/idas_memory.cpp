// IDAS: A. Hindmarsh, R. Serban and others, User Documentation for IDAS, LLNL.
#include "saltus/integrators/idas_memory.hpp"

#include <idas/idas_ls.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>

namespace saltus::sundials {

IntegrationStatus status_of_ida(int code) {
  if (code >= 0) return IntegrationStatus::success;  // includes IDA_TSTOP_RETURN
  switch (code) {
    case IDA_TOO_MUCH_WORK:
      return IntegrationStatus::too_many_steps;
    case IDA_TOO_MUCH_ACC:
    case IDA_ERR_FAIL:
    case IDA_CONV_FAIL:
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      return IntegrationStatus::step_too_small;
    case IDA_RES_FAIL:
    case IDA_FIRST_RES_FAIL:
    case IDA_REP_RES_ERR:
    case IDA_SRES_FAIL:
    case IDA_REP_SRES_ERR:
      return IntegrationStatus::not_finite;
    default:
      return IntegrationStatus::library_failure;
  }
}

namespace {

// Tolerances of (x | z | q).
std::vector<double> tolerances(const IntervalProblem& problem, double relative_to_nominal,
                               const AlgebraicEquations* algebraic) {
  std::vector<double> result = absolute_tolerances(problem, relative_to_nominal);
  if (algebraic == nullptr) return result;
  const int nx = problem.arguments.nx;
  for (int j = 0; j < algebraic->count(); ++j) {
    const double magnitude = std::abs(algebraic->start()[j]);
    result.insert(result.begin() + nx + j,
                  relative_to_nominal * (magnitude > 0.0 ? magnitude : 1.0));
  }
  return result;
}

}  // namespace

IdasMemory::IdasMemory(const IntervalProblem& problem, const IdasOptions& options,
                       const IntervalField& field, int entries, const AlgebraicEquations* algebraic)
    : problem_(problem),
      options_(options),
      field_(&field),
      algebraic_(algebraic),
      nz_(algebraic == nullptr ? 0 : algebraic->count()),
      nx_(field.states() - nz_),
      outputs_(field.outputs()),
      directions_(field.directions() - nz_),
      absolute_(tolerances(problem, options.absolute_tolerance, algebraic)),
      y_(outputs_, context_),
      slope_(outputs_, context_),
      inside_(outputs_, context_),
      sensitivity_(directions_, y_),
      sensitivity_slope_(directions_, y_),
      sensitivity_tolerance_(directions_, y_),
      sensitivity_scale_(directions_, 1.0),
      z_(field.arguments()),
      phi_(outputs_),
      entries_(entries),
      dense_(outputs_ * outputs_),
      reduced_(problem.arguments.size()),
      algebraic_slope_(nz_),
      stacked_(RowMajorMatrix::Zero(field.states(), field.directions())),
      rates_(outputs_, field.directions()),
      algebraic_rates_(nz_, field.directions()) {
  if (algebraic_ != nullptr) {
    first_algebraic_entry_ = problem.algebraic.dynamics.jacobian_pattern().entries();
    solution_ = algebraic_->new_solution();
  }
  create_state_solver();
  create_sensitivity_solver();
}

void IdasMemory::create_state_solver() {
  memory_.reset(IDACreate(context_));
  require(memory_.get(), "IDACreate");
#if SUNDIALS_VERSION_MAJOR < 7
  require(IDASetErrHandlerFn(
              memory_.get(), [](int, const char*, const char*, char*, void*) {}, nullptr),
          "IDASetErrHandlerFn");
#endif
  require(IDAInit(memory_.get(), residual, 0.0, y_, slope_), "IDAInit");
  require(IDASetUserData(memory_.get(), this), "IDASetUserData");
  Vector tolerances(outputs_, context_), differential(outputs_, context_);
  std::copy(absolute_.begin(), absolute_.end(), tolerances.data());
  for (int r = 0; r < outputs_; ++r) differential.data()[r] = is_algebraic(r) ? 0.0 : 1.0;
  require(IDASVtolerances(memory_.get(), options_.tolerance, tolerances), "IDASVtolerances");
  require(IDASetMaxNumSteps(memory_.get(), options_.max_steps), "IDASetMaxNumSteps");
  require(IDASetId(memory_.get(), differential), "IDASetId");
  require(IDASetSuppressAlg(memory_.get(), nz_ > 0 ? SUNTRUE : SUNFALSE), "IDASetSuppressAlg");
  matrix_.reset(SUNDenseMatrix(outputs_, outputs_, context_));
  require(matrix_.get(), "SUNDenseMatrix");
  linear_.reset(SUNLinSol_Dense(y_, matrix_.get(), context_));
  require(linear_.get(), "SUNLinSol_Dense");
  require(IDASetLinearSolver(memory_.get(), linear_.get(), matrix_.get()), "IDASetLinearSolver");
  require(IDASetJacFn(memory_.get(), jacobian), "IDASetJacFn");
}

void IdasMemory::create_sensitivity_solver() {
  for (int d = 0; d < directions_; ++d)
    std::copy(absolute_.begin(), absolute_.end(), sensitivity_tolerance_.data(d));
  require(IDASensInit(memory_.get(), directions_, IDA_STAGGERED, sensitivity_residual, sensitivity_,
                      sensitivity_slope_),
          "IDASensInit");
  require(IDASensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_),
          "IDASensSVtolerances");
  require(IDASetSensErrCon(memory_.get(), SUNTRUE), "IDASetSensErrCon");
}

// Returns true if they changed: IDAS allocates when it copies new tolerances.
bool IdasMemory::update_sensitivity_tolerances(const double* w) {
  bool changed = false;
  for (int d = 0; d < directions_; ++d) {
    int column = field_->column(direction_of(d));
    if (d >= nx_) column -= nz_;  // w has no entries for z
    const double scale = direction_scale(problem_, w, column);
    if (scale == sensitivity_scale_[d]) continue;
    changed = true;
    sensitivity_scale_[d] = scale;
    for (int r = 0; r < outputs_; ++r) sensitivity_tolerance_.data(d)[r] = absolute_[r] / scale;
  }
  return changed;
}

bool IdasMemory::evaluate(double s, const double* y, double* rates) {
  field_->argument(s, y, z_.data());
  field_->value(z_.data(), rates);
  for (int r = 0; r < outputs_; ++r)
    if (!is_algebraic(r)) rates[r] *= field_->length();
  return all_finite(rates, outputs_);
}

void IdasMemory::rates_at(double s, double* rates) {
  field_->argument(s, y_.data(), z_.data());
  field_->value(z_.data(), rates);
}

bool IdasMemory::evaluate_jacobian(double s, const double* y) {
  field_->argument(s, y, z_.data());
  field_->jacobian(z_.data(), phi_.data(), entries_.data());
  return all_finite(entries_.data(), field_->entries());
}

// Right-hand sides of all sensitivities in stacked_. Rows of z have their algebraic equations.
void IdasMemory::sensitivity_rates(double s) {
  field_->rate_sensitivity(s, phi_.data(), entries_.data(), stacked_, rates_.data());
  if (nz_ > 0)
    field_->differential(algebraic_->equations().jacobian_pattern(),
                         entries_.data() + first_algebraic_entry_, s, stacked_, algebraic_rates_);
}

// Computes consistent z with sensitivities, and all slopes except those of the sensitivities of z.
bool IdasMemory::make_consistent(double s, bool sensitivities) {
  AlgebraicEquations::Solution* const solution = nz_ > 0 ? &*solution_ : nullptr;
  if (nz_ > 0) {
    const int first = 1 + nx_;
    field_->argument(s, y_.data(), z_.data());
    std::copy_n(z_.begin(), first, reduced_.begin());
    std::copy(z_.begin() + first + nz_, z_.end(), reduced_.begin() + first);
    if (algebraic_->solve(reduced_.data(), *solution) != AlgebraicEquations::Status::solved ||
        algebraic_->factor(*solution) != AlgebraicEquations::Status::solved)
      return false;
    std::copy_n(solution->argument.begin() + first, nz_, y_.data() + nx_);
  }
  if (!evaluate_jacobian(s, y_.data())) return false;
  for (int r = 0; r < outputs_; ++r)
    slope_.data()[r] = is_algebraic(r) ? 0.0 : field_->length() * phi_[r];
  if (!all_finite(slope_.data(), outputs_)) return false;
  if (nz_ > 0) {  // g_z z' = -(dg/ds at fixed x + g_x x')
    const SparsityPattern& pattern = algebraic_->equations().jacobian_pattern();
    const double* entries = entries_.data() + first_algebraic_entry_;
    field_->explicit_slope(pattern, entries, algebraic_slope_.data());
    pattern.for_each([&](int r, int column, int e) {
      if (column >= 1 && column <= nx_)
        algebraic_slope_[r] += entries[e] * slope_.data()[column - 1];
    });
    solution->slope.solve(algebraic_slope_.data());
    for (int j = 0; j < nz_; ++j) slope_.data()[nx_ + j] = -algebraic_slope_[j];
  }
  if (!sensitivities) return true;
  for (int d = 0; d < directions_; ++d)
    for (int r = 0; r < nx_ + nz_; ++r)
      stacked_(r, direction_of(d)) = is_algebraic(r) ? 0.0 : sensitivity_.data(d)[r];
  if (nz_ > 0) {
    sensitivity_rates(s);
    solution->slope.solve(algebraic_rates_.data(), static_cast<int>(algebraic_rates_.cols()));
    for (int d = 0; d < directions_; ++d)
      for (int j = 0; j < nz_; ++j)
        stacked_(nx_ + j, direction_of(d)) = sensitivity_.data(d)[nx_ + j] =
            -algebraic_rates_(j, direction_of(d));
  }
  sensitivity_rates(s);
  for (int d = 0; d < directions_; ++d)
    for (int r = 0; r < outputs_; ++r)
      sensitivity_slope_.data(d)[r] = is_algebraic(r) ? 0.0 : rates_(r, direction_of(d));
  return true;
}

int IdasMemory::residual(sunrealtype s, N_Vector y, N_Vector slope, N_Vector result, void* user) {
  IdasMemory& self = *static_cast<IdasMemory*>(user);
  return self.exception_.keep([&] {
    double* out = N_VGetArrayPointer(result);
    const double* dy = N_VGetArrayPointer(slope);
    if (!self.evaluate(s, N_VGetArrayPointer(y), out)) return callback_recoverable;
    for (int r = 0; r < self.outputs_; ++r)
      if (!self.is_algebraic(r)) out[r] = dy[r] - out[r];
    return callback_success;
  });
}

int IdasMemory::jacobian(sunrealtype s, sunrealtype cj, N_Vector y, N_Vector, N_Vector,
                         SUNMatrix matrix, void* user, N_Vector, N_Vector, N_Vector) {
  IdasMemory& self = *static_cast<IdasMemory*>(user);
  return self.exception_.keep([&] {
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    const int n = self.outputs_;
    double* dense = SUNDenseMatrix_Data(matrix);
    self.field_->scaled_state_jacobian(self.entries_.data(), dense);
    for (int c = 0; c < n; ++c)
      for (int r = 0; r < n; ++r)
        dense[c * n + r] = self.is_algebraic(r) ? 0.0 : (r == c ? cj : 0.0) - dense[c * n + r];
    if (self.nz_ == 0) return callback_success;
    const double* entries = self.entries_.data() + self.first_algebraic_entry_;
    self.algebraic_->equations().jacobian_pattern().for_each([&](int r, int column, int e) {
      if (column >= 1 && column <= self.nx_ + self.nz_)
        dense[(column - 1) * n + self.nx_ + r] = entries[e];
    });
    return callback_success;
  });
}

int IdasMemory::sensitivity_residual(int count, sunrealtype s, N_Vector y, N_Vector, N_Vector,
                                     N_Vector* sensitivity, N_Vector* slope, N_Vector* result,
                                     void* user, N_Vector, N_Vector, N_Vector) {
  IdasMemory& self = *static_cast<IdasMemory*>(user);
  return self.exception_.keep([&] {
    if (!self.evaluate_jacobian(s, N_VGetArrayPointer(y))) return callback_recoverable;
    for (int d = 0; d < count; ++d)
      for (int r = 0; r < self.nx_ + self.nz_; ++r)
        self.stacked_(r, self.direction_of(d)) = N_VGetArrayPointer(sensitivity[d])[r];
    self.sensitivity_rates(s);
    for (int d = 0; d < count; ++d) {
      double* out = N_VGetArrayPointer(result[d]);
      const double* dS = N_VGetArrayPointer(slope[d]);
      const int column = self.direction_of(d);
      for (int r = 0; r < self.outputs_; ++r)
        out[r] = self.is_algebraic(r) ? self.algebraic_rates_(r - self.nx_, column)
                                      : dS[r] - self.rates_(r, column);
    }
    return callback_success;
  });
}

int IdasMemory::begin(double s, const double* w, bool sensitivities) {
  if (!make_consistent(s, sensitivities)) return IDA_FIRST_RES_FAIL;
  int code = IDAReInit(memory_.get(), s, y_, slope_);
  if (sensitivities) {
    if (code >= 0)
      code = IDASensReInit(memory_.get(), IDA_STAGGERED, sensitivity_, sensitivity_slope_);
    if (code >= 0 && update_sensitivity_tolerances(w))
      code = IDASensSVtolerances(memory_.get(), options_.tolerance, sensitivity_tolerance_);
  } else if (code >= 0) {
    code = IDASensToggleOff(memory_.get());
  }
  return code >= 0 ? IDASetStopTime(memory_.get(), 1.0) : code;
}

int IdasMemory::advance(int task, double& reached) {
  const int code = IDASolve(memory_.get(), 1.0, &reached, y_, slope_, task);
  exception_.rethrow();
  // As in CvodesMemory::advance(): a step of zero is not a success.
  double own_time = 0.0;
  if (code >= 0) IDAGetCurrentTime(memory_.get(), &own_time);
  return code >= 0 && own_time < reached ? IDA_ERR_FAIL : code;
}

int IdasMemory::read_sensitivity() {
  double reached = 0.0;
  return IDAGetSens(memory_.get(), &reached, sensitivity_);
}

int IdasMemory::interpolate(double s, double* y) {
  const int code = IDAGetDky(memory_.get(), s, 0, inside_);
  std::copy_n(inside_.data(), outputs_, y);
  return code;
}

int IdasMemory::interpolate_sensitivity(double s) {
  return IDAGetSensDky(memory_.get(), s, 0, sensitivity_);
}

}  // namespace saltus::sundials
