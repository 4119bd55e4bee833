// RAII wrappers of SUNDIALS objects, return codes, and differences between versions 6 and 7.
//
// A negative code at set-up throws std::runtime_error with the name of the call, because it means a
// bug or lack of memory. During an integration, codes become an IntegrationStatus. The messages of
// the library are disabled, so nothing prints.
#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_types.h>
#include <sundials/sundials_version.h>

#include <exception>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus::sundials {

/// Throws std::runtime_error if a set-up call failed.
void require(int code, const char* call);
void require(const void* object, const char* call);

/// The context shared by all objects of one integrator. Each integrator has a separate one, so
/// integrators share no state.
class Context {
 public:
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  operator SUNContext() const { return context_; }

 private:
  SUNContext context_ = nullptr;
};

/// A serial vector of fixed length with fused operations.
class Vector {
 public:
  Vector(int size, const Context& context);
  ~Vector();
  Vector(const Vector&) = delete;
  Vector& operator=(const Vector&) = delete;
  operator N_Vector() const { return vector_; }
  double* data() const { return N_VGetArrayPointer(vector_); }

 private:
  N_Vector vector_ = nullptr;
};

/// An array of vectors like a given one, as SUNDIALS requires for sensitivities.
class VectorArray {
 public:
  VectorArray(int count, const Vector& like);
  ~VectorArray();
  VectorArray(const VectorArray&) = delete;
  VectorArray& operator=(const VectorArray&) = delete;
  operator N_Vector*() const { return vectors_; }
  double* data(int i) const { return N_VGetArrayPointer(vectors_[i]); }

 private:
  int count_ = 0;
  N_Vector* vectors_ = nullptr;
};

struct DestroyMatrix {
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
};
struct FreeLinearSolver {
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
};
struct FreeNonlinearSolver {
  void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
};
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, DestroyMatrix>;
using LinearSolver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, FreeLinearSolver>;
using NonlinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, FreeNonlinearSolver>;

/// Return values of callbacks. After a recoverable failure, SUNDIALS tries a smaller step.
inline constexpr int callback_success = 0;
inline constexpr int callback_recoverable = 1;
inline constexpr int callback_failed = -1;

/// Passes exceptions of formulas through C code. A callback runs between C frames that exceptions
/// must not cross. keep() stores the exception and returns a failure, and rethrow() rethrows it
/// after the library call.
class StoredException {
 public:
  template <class F>
  int keep(F&& call_back) noexcept {
    try {
      return call_back();
    } catch (...) {
      kept_ = std::current_exception();
      return callback_failed;
    }
  }
  void rethrow() {
    if (kept_) std::rethrow_exception(std::exchange(kept_, nullptr));
  }

 private:
  std::exception_ptr kept_;
};

/// Throws DefinitionError for a tolerance outside (0, 1), a negative absolute one, or no steps.
void check_options(const char* integrator, double tolerance, double absolute_tolerance,
                   long max_steps);

/// Absolute tolerances of (x | q): `relative_to_nominal` times nominal_state, with nominal 1 for q.
/// Throws DefinitionError if a nominal value is not positive or their number is wrong.
std::vector<double> absolute_tolerances(const IntervalProblem& problem, double relative_to_nominal);

/// Magnitude of an entry of w, which divides the absolute tolerance of its sensitivity: |p| for
/// parameters and |h| for the length, both at least 1e-3, and nominal_state for initial states. It
/// is 1 for all other entries and instead of zero. Rounded to a power of two, so that it rarely
/// changes between calls.
double direction_scale(const IntervalProblem& problem, const double* w, int column);

}  // namespace saltus::sundials
