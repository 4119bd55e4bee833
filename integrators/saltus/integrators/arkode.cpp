// Equations in scaled time (interval_field.hpp): y' = F(s, y), optionally with the sensitivities
// S_j' = F_y S_j + F_theta_j in one vector (y | S_1 | ... | S_m). The Newton matrix of this system
// is block lower triangular with equal diagonal blocks I - gamma F_y. The blocks below (second
// derivatives times S_j) are omitted. One factorisation of size ny then solves all columns, and
// Newton's iteration converges linearly to the same solution. ARKODE: D. Reynolds and others, User
// Documentation for ARKODE, LLNL.
#include "saltus/integrators/sundials.hpp"

#include <fmt/format.h>

#include <arkode/arkode_arkstep.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>

#include "saltus/core/error.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/interval_field.hpp"
#include "saltus/integrators/sundials_support.hpp"

namespace saltus {
namespace {

using sundials::callback_recoverable;
using sundials::callback_success;
using sundials::require;

// Since version 7.1, common functions serve all steppers, and the old names are deprecated.
#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#define SALTUS_ARKODE(call) ARKode##call
#else
#define SALTUS_ARKODE(call) ARKStep##call
#endif

// Fraction of the tolerance at which Newton's iteration stops, so that its error is negligible.
constexpr double newton_fraction = 1e-2;
// The sensitivities converge linearly, and fixed steps cannot be shortened.
constexpr int newton_iterations = 30;
// Robertson's kinetics over long times needs a fresh Jacobian in every step and more attempts per
// step than the library's limits of 7 and 10.
constexpr int attempts = 30;

// Explicit table names, because defaults per order differ between versions of the library.
ARKODE_ERKTableID explicit_table(int order) {
  switch (order) {
    case 2:
      return ARKODE_HEUN_EULER_2_1_2;
    case 3:
      return ARKODE_BOGACKI_SHAMPINE_4_2_3;
    case 4:
      return ARKODE_ZONNEVELD_5_3_4;
    case 5:
      return ARKODE_DORMAND_PRINCE_7_4_5;
    case 6:
      return ARKODE_VERNER_8_5_6;
    case 8:
      return ARKODE_FEHLBERG_13_7_8;
    default:
      return ARKODE_ERK_NONE;
  }
}

// L-stable and stiffly accurate, with stage order 2 from order 3 on.
ARKODE_DIRKTableID implicit_table(int order) {
  switch (order) {
    case 2:
      return ARKODE_SDIRK_2_1_2;
    case 3:
      return ARKODE_ESDIRK325L2SA_5_2_3;
    case 4:
      return ARKODE_ESDIRK437L2SA_7_3_4;
    case 5:
      return ARKODE_ESDIRK547L2SA2_7_4_5;
    default:
      return ARKODE_DIRK_NONE;
  }
}

IntegrationStatus status_of(int code) {
  if (code >= 0) return IntegrationStatus::success;  // ARK_TSTOP_RETURN is the normal end
  switch (code) {
    case ARK_TOO_MUCH_WORK:
      return IntegrationStatus::too_many_steps;
    case ARK_TOO_MUCH_ACC:
    case ARK_ERR_FAILURE:
    case ARK_CONV_FAILURE:
    case ARK_LSETUP_FAIL:
    case ARK_LSOLVE_FAIL:
      return IntegrationStatus::step_too_small;
    case ARK_RHSFUNC_FAIL:
    case ARK_FIRST_RHSFUNC_ERR:
    case ARK_REPTD_RHSFUNC_ERR:
    case ARK_UNREC_RHSFUNC_ERR:
      return IntegrationStatus::not_finite;
    default:
      return IntegrationStatus::library_failure;
  }
}

struct FreeArkode {
  void operator()(void* memory) const { SALTUS_ARKODE(Free)(&memory); }
};

// Solves all columns of the vector with one factorisation of the ny x ny matrix.
class SharedFactorSolver {
 public:
  SharedFactorSolver(int size, int columns, const sundials::Context& context)
      : factor_(size), right_hand_side_(size, columns), solver_(SUNLinSolNewEmpty(context)) {
    require(solver_.get(), "SUNLinSolNewEmpty");
    solver_->content = this;
    solver_->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    solver_->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    solver_->ops->setup = setup;
    solver_->ops->solve = solve;
    solver_->ops->free = [](SUNLinearSolver solver) {
      solver->content = nullptr;  // SUNDIALS must not free it
      SUNLinSolFreeEmpty(solver);
      return 0;
    };
  }
  SUNLinearSolver handle() const { return solver_.get(); }

 private:
  static SharedFactorSolver& self(SUNLinearSolver solver) {
    return *static_cast<SharedFactorSolver*>(solver->content);
  }
  static int setup(SUNLinearSolver solver, SUNMatrix matrix) {
    SharedFactorSolver& it = self(solver);
    const Eigen::Index n = it.right_hand_side_.rows();
    it.factor_.compute(Eigen::Map<const MatrixXd>(SUNDenseMatrix_Data(matrix), n, n));
    const bool regular = (it.factor_.matrixLU().diagonal().array() != 0.0).all();
    return regular ? callback_success : callback_recoverable;
  }
  static int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
    SharedFactorSolver& it = self(solver);
    MatrixXd& rhs = it.right_hand_side_;
    const Eigen::Map<const MatrixXd> from(N_VGetArrayPointer(b), rhs.rows(), rhs.cols());
    rhs.noalias() = it.factor_.permutationP() * from;
    it.factor_.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(rhs);
    it.factor_.matrixLU().triangularView<Eigen::Upper>().solveInPlace(rhs);
    std::copy_n(rhs.data(), rhs.size(), N_VGetArrayPointer(x));
    return callback_success;
  }

  Eigen::PartialPivLU<MatrixXd> factor_;
  MatrixXd right_hand_side_;
  sundials::LinearSolver solver_;
};

// ARKODE's memory for the state alone (columns = 1) or with its sensitivities.
class Stepper {
 public:
  Stepper(IntervalField& field, const ArkodeOptions& options, int columns,
          const sundials::Context& context)
      : field_(field),
        options_(options),
        ny_(field.outputs()),
        columns_(columns),
        y_(ny_ * columns, context),
        tolerances_(ny_ * columns, context),
        z_(field.arguments()),
        phi_(ny_),
        entries_(field.entries()) {
    const bool implicit = options.method == ArkodeOptions::Method::DiagonallyImplicit;
    memory_.reset(
        ARKStepCreate(implicit ? nullptr : rate, implicit ? rate : nullptr, 0.0, y_, context));
    require(memory_.get(), "ARKStepCreate");
#if SUNDIALS_VERSION_MAJOR < 7
    require(ARKStepSetErrHandlerFn(
                memory_.get(), [](int, const char*, const char*, char*, void*) {}, nullptr),
            "ARKStepSetErrHandlerFn");
#endif
    require(SALTUS_ARKODE(SetUserData)(memory_.get(), this), "ARKodeSetUserData");
    require(ARKStepSetTableNum(memory_.get(),
                               implicit ? implicit_table(options.order) : ARKODE_DIRK_NONE,
                               implicit ? ARKODE_ERK_NONE : explicit_table(options.order)),
            "ARKStepSetTableNum");
    require(SALTUS_ARKODE(SetMaxErrTestFails)(memory_.get(), attempts), "ARKodeSetMaxErrTestFails");
    require(SALTUS_ARKODE(SetMaxNumSteps)(memory_.get(), options.max_steps),
            "ARKodeSetMaxNumSteps");
    require(SALTUS_ARKODE(SetMaxHnilWarns)(memory_.get(), -1), "ARKodeSetMaxHnilWarns");
    if (options.fixed_steps > 0)
      require(SALTUS_ARKODE(SetFixedStep)(memory_.get(), 1.0 / options.fixed_steps),
              "ARKodeSetFixedStep");
    if (!implicit) return;
    matrix_.reset(SUNDenseMatrix(ny_, ny_, context));
    require(matrix_.get(), "SUNDenseMatrix");
    linear_ = std::make_unique<SharedFactorSolver>(ny_, columns, context);
    require(SALTUS_ARKODE(SetLinearSolver)(memory_.get(), linear_->handle(), matrix_.get()),
            "ARKodeSetLinearSolver");
    require(SALTUS_ARKODE(SetJacFn)(memory_.get(), state_jacobian), "ARKodeSetJacFn");
    require(SALTUS_ARKODE(SetMaxConvFails)(memory_.get(), attempts), "ARKodeSetMaxConvFails");
    require(SALTUS_ARKODE(SetLSetupFrequency)(memory_.get(), 1), "ARKodeSetLSetupFrequency");
    require(SALTUS_ARKODE(SetJacEvalFrequency)(memory_.get(), 1), "ARKodeSetJacEvalFrequency");
    require(SALTUS_ARKODE(SetMaxNonlinIters)(memory_.get(), newton_iterations),
            "ARKodeSetMaxNonlinIters");
    require(SALTUS_ARKODE(SetNonlinConvCoef)(memory_.get(), newton_fraction),
            "ARKodeSetNonlinConvCoef");
  }

  double* column(int k) { return y_.data() + k * ny_; }
  double* tolerance(int k) { return tolerances_.data() + k * ny_; }

  // Integrates from the start values in column(). ARKODE discards the stop time after reaching it.
  // A target beyond the stop time returns the last step instead of an interpolated value.
  int integrate() {
    const bool implicit = options_.method == ArkodeOptions::Method::DiagonallyImplicit;
    int code =
        ARKStepReInit(memory_.get(), implicit ? nullptr : rate, implicit ? rate : nullptr, 0.0, y_);
    if (code >= 0)
      code = SALTUS_ARKODE(SVtolerances)(memory_.get(), options_.tolerance, tolerances_);
    if (code >= 0) code = SALTUS_ARKODE(SetStopTime)(memory_.get(), 1.0);
    double reached = 0.0;
    if (code >= 0) code = SALTUS_ARKODE(Evolve)(memory_.get(), 2.0, y_, &reached, ARK_NORMAL);
    exception_.rethrow();
    // As in CvodesMemory::advance(): a step of zero is not a success.
    double own_time = 0.0;
    if (code >= 0) SALTUS_ARKODE(GetCurrentTime)(memory_.get(), &own_time);
    return code >= 0 && own_time < reached ? ARK_ERR_FAILURE : code;
  }

 private:
  static int rate(sunrealtype s, N_Vector y, N_Vector rates, void* user) {
    Stepper& self = *static_cast<Stepper*>(user);
    return self.exception_.keep(
        [&] { return self.rate_of(s, N_VGetArrayPointer(y), N_VGetArrayPointer(rates)); });
  }

  int rate_of(double s, const double* in, double* out) {
    field_.argument(s, in, z_.data());
    if (columns_ == 1) {
      field_.value(z_.data(), phi_.data());
    } else {
      field_.jacobian(z_.data(), phi_.data(), entries_.data());
      for (int k = 1; k < columns_; ++k)
        field_.rate_sensitivity(s, phi_.data(), entries_.data(), k - 1, in + k * ny_,
                                out + k * ny_);
    }
    for (int r = 0; r < ny_; ++r) out[r] = field_.length() * phi_[r];
    return all_finite(out, ny_ * columns_) ? callback_success : callback_recoverable;
  }

  static int state_jacobian(sunrealtype s, N_Vector y, N_Vector, SUNMatrix matrix, void* user,
                            N_Vector, N_Vector, N_Vector) {
    Stepper& self = *static_cast<Stepper*>(user);
    return self.exception_.keep([&] {
      self.field_.argument(s, N_VGetArrayPointer(y), self.z_.data());
      self.field_.jacobian(self.z_.data(), self.phi_.data(), self.entries_.data());
      if (!all_finite(self.entries_.data(), static_cast<int>(self.entries_.size())))
        return callback_recoverable;
      self.field_.scaled_state_jacobian(self.entries_.data(), SUNDenseMatrix_Data(matrix));
      return callback_success;
    });
  }

  IntervalField& field_;
  const ArkodeOptions& options_;
  int ny_, columns_;
  sundials::Vector y_, tolerances_;
  sundials::Matrix matrix_;
  std::unique_ptr<SharedFactorSolver> linear_;
  std::unique_ptr<void, FreeArkode> memory_;
  std::vector<double> z_, phi_, entries_;
  sundials::StoredException exception_;
};

class Arkode final : public Integrator {
 public:
  Arkode(const IntervalProblem& definition, const ArkodeOptions& options)
      : Integrator(definition),
        field_(problem()),
        options_(options),
        absolute_(sundials::absolute_tolerances(problem(), options.absolute_tolerance)),
        state_(field_, options_, 1, context_),
        augmented_(field_, options_, 1 + field_.directions(), context_),
        end_sensitivity_(field_.outputs(), field_.directions()) {
    std::copy(absolute_.begin(), absolute_.end(), state_.tolerance(0));
    std::copy(absolute_.begin(), absolute_.end(), augmented_.tolerance(0));
  }

  IntegrationStatus value(const double* w, double* end) override {
    start(w, state_);
    return finish(state_.integrate(), state_, end);
  }

  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override {
    start(w, augmented_);
    for (int d = 0; d < field_.directions(); ++d) {
      std::fill_n(augmented_.column(1 + d), field_.outputs(), 0.0);
      if (d < field_.states()) augmented_.column(1 + d)[d] = 1.0;
      const double scale = sundials::direction_scale(problem(), w, field_.column(d));
      for (int r = 0; r < field_.outputs(); ++r)
        augmented_.tolerance(1 + d)[r] = absolute_[r] / scale;
    }
    const IntegrationStatus status = finish(augmented_.integrate(), augmented_, end);
    for (int d = 0; d < field_.directions(); ++d)
      for (int r = 0; r < field_.outputs(); ++r)
        end_sensitivity_(r, d) = augmented_.column(1 + d)[r];
    field_.scatter(end_sensitivity_, derivative);
    if (status == IntegrationStatus::success &&
        !all_finite(end_sensitivity_.data(), static_cast<int>(end_sensitivity_.size())))
      return IntegrationStatus::not_finite;
    return status;
  }

 private:
  void start(const double* w, Stepper& stepper) {
    field_.load(w);
    std::copy_n(w, field_.states(), stepper.column(0));
    std::fill_n(stepper.column(0) + field_.states(), field_.outputs() - field_.states(), 0.0);
  }

  IntegrationStatus finish(int code, Stepper& stepper, double* end) const {
    std::copy_n(stepper.column(0), field_.outputs(), end);
    const IntegrationStatus status = status_of(code);
    if (status == IntegrationStatus::success && !all_finite(end, field_.outputs()))
      return IntegrationStatus::not_finite;
    return status;
  }

  sundials::Context context_;  // outlives everything created in it
  IntervalField field_;
  ArkodeOptions options_;
  std::vector<double> absolute_;
  Stepper state_, augmented_;
  RowMajorMatrix end_sensitivity_;
};

class ArkodeScheme final : public IntegratorScheme {
 public:
  explicit ArkodeScheme(const ArkodeOptions& options) : options_(options) {
    const bool implicit = options.method == ArkodeOptions::Method::DiagonallyImplicit;
    const auto fail = [](const std::string& why) { throw DefinitionError("ARKODE " + why + "."); };
    const bool known = implicit ? implicit_table(options.order) != ARKODE_DIRK_NONE
                                : explicit_table(options.order) != ARKODE_ERK_NONE;
    if (!known)
      fail(fmt::format("has {}, but order = {}",
                       implicit ? "diagonally implicit methods of order 2, 3, 4 and 5"
                                : "explicit methods of order 2, 3, 4, 5, 6 and 8",
                       options.order));
    sundials::check_options("ARKODE", options.tolerance, options.absolute_tolerance,
                            options.max_steps);
    if (options.fixed_steps < 0)
      fail(fmt::format("cannot take fixed_steps = {}", options.fixed_steps));
  }
  std::unique_ptr<Integrator> make(const IntervalProblem& problem) const override {
    throw_no_event_support(problem, "ARKODE");
    return std::make_unique<Arkode>(problem, options_);
  }
  std::string name() const override {
    char text[96];
    const char* kind =
        options_.method == ArkodeOptions::Method::Explicit ? "explicit" : "diagonally implicit";
    if (options_.fixed_steps > 0)
      std::snprintf(text, sizeof text, "ARKODE %s, order %d, %d steps", kind, options_.order,
                    options_.fixed_steps);
    else
      std::snprintf(text, sizeof text, "ARKODE %s, order %d, tolerance %.0e", kind, options_.order,
                    options_.tolerance);
    return text;
  }

 private:
  ArkodeOptions options_;
};

}  // namespace

IntegratorChoice arkode(ArkodeOptions options) { return std::make_shared<ArkodeScheme>(options); }

}  // namespace saltus
