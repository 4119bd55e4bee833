#include "saltus/integrators/sundials_support.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <sundials/sundials_context.h>

#include <cmath>
#include <stdexcept>

#include "saltus/core/error.hpp"

namespace saltus::sundials {

void require(int code, const char* call) {
  if (code < 0) throw std::runtime_error(fmt::format("{} failed with code {}.", call, code));
}

void require(const void* object, const char* call) {
  if (object == nullptr) throw std::runtime_error(fmt::format("{} returned no object.", call));
}

#if SUNDIALS_VERSION_MAJOR >= 7
namespace {
void ignore_error(int, const char*, const char*, const char*, SUNErrCode, void*, SUNContext) {}
}  // namespace
#endif

Context::Context() {
#if SUNDIALS_VERSION_MAJOR >= 7
  require(SUNContext_Create(SUN_COMM_NULL, &context_), "SUNContext_Create");
  SUNContext_ClearErrHandlers(context_);
  SUNContext_PushErrHandler(context_, ignore_error, nullptr);
#else
  require(SUNContext_Create(nullptr, &context_), "SUNContext_Create");
#endif
}

Context::~Context() { SUNContext_Free(&context_); }

Vector::Vector(int size, const Context& context) : vector_(N_VNew_Serial(size, context)) {
  require(vector_, "N_VNew_Serial");
  require(N_VEnableFusedOps_Serial(vector_, SUNTRUE), "N_VEnableFusedOps_Serial");
  N_VConst(0.0, vector_);
}

Vector::~Vector() { N_VDestroy(vector_); }

VectorArray::VectorArray(int count, const Vector& like)
    : count_(count), vectors_(N_VCloneVectorArray(count, like)) {
  require(vectors_, "N_VCloneVectorArray");
  for (int i = 0; i < count; ++i) N_VConst(0.0, vectors_[i]);
}

VectorArray::~VectorArray() { N_VDestroyVectorArray(vectors_, count_); }

void check_options(const char* integrator, double tolerance, double absolute_tolerance,
                   long max_steps) {
  if (!(tolerance > 0.0 && tolerance < 1.0))
    throw DefinitionError(
        fmt::format("the relative tolerance of {} must lie between 0 and 1, but is {}.", integrator,
                    tolerance));
  if (!(absolute_tolerance >= 0.0 && std::isfinite(absolute_tolerance)))
    throw DefinitionError(
        fmt::format("the absolute tolerance of {} must be finite and not negative, but is {}.",
                    integrator, absolute_tolerance));
  if (max_steps < 1)
    throw DefinitionError(
        fmt::format("{} needs at least one step, but max_steps = {}.", integrator, max_steps));
}

std::vector<double> absolute_tolerances(const IntervalProblem& problem,
                                        double relative_to_nominal) {
  const int nx = problem.arguments.nx;
  const VectorXd& nominal = problem.nominal_state;
  if (nominal.size() != 0 && nominal.size() != nx)
    throw DefinitionError(
        fmt::format("nominal_state has {} entries for {} states.", nominal.size(), nx));
  std::vector<double> tolerances(nx + problem.nq(), relative_to_nominal);
  for (int i = 0; i < nominal.size(); ++i) {
    if (!(nominal[i] > 0.0) || !std::isfinite(nominal[i]))
      throw DefinitionError(fmt::format(
          "nominal_state must be positive and finite, but entry {} is {}.", i, nominal[i]));
    tolerances[i] *= nominal[i];
  }
  return tolerances;
}

// For a parameter of 1e-8, the tolerance of its sensitivity would otherwise be 1e8 times that of
// states, more than the sensitivity itself.
constexpr double smallest_scale = 1e-3;

double direction_scale(const IntervalProblem& problem, const double* w, int column) {
  const IntervalArguments index{problem.arguments.nx, problem.coefficients(), problem.arguments.np};
  double scale = 1.0;
  if (column < index.c()) {
    if (problem.nominal_state.size() > 0) scale = problem.nominal_state[column];
  } else if ((column >= index.p() && column < index.t0()) || column == index.h()) {
    scale = w[column] == 0.0 ? 1.0 : std::max(smallest_scale, std::abs(w[column]));
  }
  return scale > 0.0 && std::isfinite(scale) ? std::exp2(std::round(std::log2(scale))) : 1.0;
}

}  // namespace saltus::sundials
