#include "tests/corpus/outside.hpp"

#include <cvodes/cvodes.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace saltus::corpus {
namespace {

void require(bool done, const char* call) {
  if (!done) throw std::runtime_error(std::string("the judge's integrator: ") + call + " failed");
}

double running_cost(const OutsidePhase& phase, const double* z) {
  double cost = 0.0;
  for (const OutsideFormula& f : phase.running_costs) {
    double value = 0.0;
    f.value(z, &value);
    cost += value;
  }
  return cost;
}

std::vector<double> argument(const OutsidePhase& phase, double t, const VectorXd& x,
                             const VectorXd& u) {
  std::vector<double> z{t};
  z.insert(z.end(), x.data(), x.data() + phase.nx);
  z.insert(z.end(), u.data(), u.data() + phase.nu);
  return z;
}

struct RightSide {
  const OutsidePhase* phase;
  const PlanPiece* piece;
  std::vector<double> z;
};

int right_side(sunrealtype t, N_Vector y, N_Vector rate, void* user) {
  RightSide& r = *static_cast<RightSide*>(user);
  const OutsidePhase& phase = *r.phase;
  r.z[0] = t;
  std::copy_n(N_VGetArrayPointer(y), phase.nx, r.z.data() + 1);
  const double s = (t - r.piece->start) / r.piece->length;
  for (int i = 0; i < phase.nu; ++i) {
    r.z[1 + phase.nx + i] =
        r.piece->first_input[i] + s * (r.piece->last_input[i] - r.piece->first_input[i]);
  }
  double* dx = N_VGetArrayPointer(rate);
  phase.field.value(r.z.data(), dx);
  dx[phase.nx] = running_cost(phase, r.z.data());
  return std::all_of(dx, dx + phase.nx + 1, [](double v) { return std::isfinite(v); }) ? 0 : 1;
}

// CVODE with Adams' method and fixed-point iteration for (x | cost). One object per interval.
class Cvode {
 public:
  Cvode(const OutsidePhase& phase, const PlanPiece& piece, const VectorXd& start,
        const VectorXd& sizes, double tolerance)
      : size_(phase.nx + 1), user_{&phase, &piece, std::vector<double>(1 + phase.nx + phase.nu)} {
#if SUNDIALS_VERSION_MAJOR >= 7
    require(SUNContext_Create(SUN_COMM_NULL, &context_) == 0, "SUNContext_Create");
#else
    require(SUNContext_Create(nullptr, &context_) == 0, "SUNContext_Create");
#endif
    y_ = N_VNew_Serial(size_, context_);
    inside_ = N_VNew_Serial(size_, context_);
    std::copy_n(start.data(), size_, N_VGetArrayPointer(y_));
    memory_ = CVodeCreate(CV_ADAMS, context_);
    require(memory_ != nullptr, "CVodeCreate");
    require(CVodeInit(memory_, right_side, piece.start, y_) == CV_SUCCESS, "CVodeInit");
    tolerances_ = N_VNew_Serial(size_, context_);
    for (int i = 0; i < size_; ++i) N_VGetArrayPointer(tolerances_)[i] = tolerance * sizes[i];
    require(CVodeSVtolerances(memory_, tolerance, tolerances_) == CV_SUCCESS, "CVodeSVtolerances");
    iteration_ = SUNNonlinSol_FixedPoint(y_, 0, context_);
    require(CVodeSetNonlinearSolver(memory_, iteration_) == CV_SUCCESS, "CVodeSetNonlinearSolver");
    require(CVodeSetUserData(memory_, &user_) == CV_SUCCESS, "CVodeSetUserData");
    require(CVodeSetMaxNumSteps(memory_, 200000) == CV_SUCCESS, "CVodeSetMaxNumSteps");
    require(CVodeSetStopTime(memory_, piece.start + piece.length) == CV_SUCCESS,
            "CVodeSetStopTime");
    if (phase.max_step < piece.length) {
      require(CVodeSetMaxStep(memory_, phase.max_step) == CV_SUCCESS, "CVodeSetMaxStep");
    }
    CVodeSetErrFile(memory_, nullptr);
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;
  ~Cvode() {
    CVodeFree(&memory_);
    SUNNonlinSolFree(iteration_);
    N_VDestroy(y_);
    N_VDestroy(inside_);
    N_VDestroy(tolerances_);
    SUNContext_Free(&context_);
  }

  // One internal step to time `t`. Returns false on failure.
  bool step(double end, double& t) { return CVode(memory_, end, y_, &t, CV_ONE_STEP) >= 0; }
  // Dense output within the last step.
  void at(double t, double* x) {
    CVodeGetDky(memory_, t, 0, inside_);
    std::copy_n(N_VGetArrayPointer(inside_), size_, x);
  }
  VectorXd state() const { return Eigen::Map<VectorXd>(N_VGetArrayPointer(y_), size_); }

 private:
  int size_;
  RightSide user_;
  SUNContext context_ = nullptr;
  N_Vector y_ = nullptr, inside_ = nullptr, tolerances_ = nullptr;
  SUNNonlinearSolver iteration_ = nullptr;
  void* memory_ = nullptr;
};

double violation(const Bounds& bounds, double value) {
  return std::isnan(value) ? infinity : std::max({0.0, bounds.lower - value, value - bounds.upper});
}

// Keeps the largest violation relative to its tolerance.
void note(Miss& worst, double amount, double tolerance, const std::string& what) {
  if (amount / tolerance > worst.relative()) worst = {what, amount, tolerance};
}

// Largest violation of a row over [from, to]: samples, then golden-section search around the
// largest sample.
double largest_within(double from, double to, const std::function<double(double)>& excess,
                      double& when) {
  constexpr int samples = 9;
  int best = 0;
  double values[samples];
  for (int k = 0; k < samples; ++k) {
    values[k] = excess(from + (to - from) * k / (samples - 1));
    if (values[k] > values[best]) best = k;
  }
  double low = from + (to - from) * std::max(0, best - 1) / (samples - 1);
  double high = from + (to - from) * std::min(samples - 1, best + 1) / (samples - 1);
  double largest = values[best];
  when = from + (to - from) * best / (samples - 1);
  constexpr double golden = 0.6180339887498949;
  for (int k = 0; k < 30 && high > low; ++k) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    const double fa = excess(a), fb = excess(b);
    if (fa > largest) largest = fa, when = a;
    if (fb > largest) largest = fb, when = b;
    (fa > fb ? high : low) = fa > fb ? b : a;
  }
  return largest;
}

void check_path(const OutsidePhase& phase, const PlanPiece& piece, double phase_start, double from,
                double to, const std::function<void(double, double*)>& at, Miss& worst) {
  std::vector<double> z(1 + phase.nx + 1 + phase.nu), y;
  for (const OutsideRow& row : phase.path) {
    if (row.nodes_only) continue;
    const double a = std::max(from, phase_start + row.from);
    const double b = std::min(to, phase_start + row.to);
    if (!(a <= b)) continue;
    for (int i = 0; i < row.formula.rows; ++i) {
      if (row.bounds[i].is_free()) continue;
      y.resize(row.formula.rows);
      const auto excess = [&](double t) {
        z[0] = t;
        at(t, z.data() + 1);  // its last entry is the cost, which the input overwrites
        const VectorXd u = piece.input((t - piece.start) / piece.length);
        std::copy_n(u.data(), phase.nu, z.data() + 1 + phase.nx);
        row.formula.value(z.data(), y.data());
        if (std::isnan(y[i])) return infinity;
        return std::max(row.bounds[i].lower - y[i], y[i] - row.bounds[i].upper);
      };
      double when = a;
      const double amount = largest_within(a, b, excess, when);
      if (amount > 0.0) {
        note(worst, amount, row.tolerance(i),
             fmt::format("'{}' of '{}' at {:.6g} s", row.name, phase.name, when));
      }
    }
  }
}

void check_inputs(const OutsidePhase& phase, const PlanPiece& piece, Miss& worst) {
  for (int i = 0; i < phase.nu; ++i) {
    const Bounds& b = phase.input_bounds[i];
    double largest = 1.0;
    for (const double side : {b.lower, b.upper})
      if (std::isfinite(side)) largest = std::max(largest, std::abs(side));
    for (const double value : {piece.first_input[i], piece.last_input[i]}) {
      note(worst, violation(b, value), 1e-6 * largest,
           fmt::format("input {} of '{}' at {:.6g} s", i, phase.name, piece.start));
    }
  }
}

// Rows that are promised at the nodes only.
void check_node(const OutsidePhase& phase, const PlanPiece& piece, Miss& worst) {
  VectorXd z(1 + phase.nx + phase.nu);
  z << piece.start, piece.state, piece.first_input;
  for (const OutsideRow& row : phase.path) {
    if (!row.nodes_only) continue;
    VectorXd y(row.formula.rows);
    row.formula.value(z.data(), y.data());
    for (int i = 0; i < row.formula.rows; ++i) {
      note(worst, violation(row.bounds[i], y[i]), row.tolerance(i),
           fmt::format("'{}' of '{}' at the node at {:.6g} s", row.name, phase.name, piece.start));
    }
  }
}

// End conditions of a phase at x. Adds the end costs.
double check_end(const OutsidePhase& phase, const PlanPiece& piece, const VectorXd& x,
                 Miss& worst) {
  VectorXd z = VectorXd::Zero(1 + phase.nx + phase.nu);
  z[0] = piece.start + piece.length;
  z.segment(1, phase.nx) = x.head(phase.nx);
  z.tail(phase.nu) = piece.last_input;
  for (const OutsideRow& row : phase.ends) {
    VectorXd y(row.formula.rows);
    row.formula.value(z.data(), y.data());
    for (int i = 0; i < row.formula.rows; ++i) {
      note(worst, violation(row.bounds[i], y[i]), row.tolerance(i),
           fmt::format("'{}' at the end of '{}'", row.name, phase.name));
    }
  }
  double cost = 0.0;
  for (const OutsideFormula& f : phase.end_costs) {
    double value = 0.0;
    f.value(z.data(), &value);
    cost += value;
  }
  return cost;
}

VectorXd entered(const OutsidePhase& phase, double t, const VectorXd& before) {
  if (!phase.entry.value) return before;
  VectorXd z(1 + before.size()), after(phase.entry.rows);
  z << t, before;
  phase.entry.value(z.data(), after.data());
  return after;
}

}  // namespace

double OutsideRow::tolerance(int i) const {
  double largest = 1.0;
  for (const double side : {bounds[i].lower, bounds[i].upper})
    if (std::isfinite(side)) largest = std::max(largest, std::abs(side));
  return 1e-6 * largest;
}

bool flow(
    const OutsidePhase& phase, const PlanPiece& piece, VectorXd& x,
    const std::function<void(double, double, const std::function<void(double, double*)>&)>& visit) {
  if (!(piece.length > 0.0)) return piece.length == 0.0;
  const std::vector<double> z = argument(phase, piece.start, x, piece.first_input);
  // Errors are relative to the size of each state within the interval. Cost errors are relative to
  // the rate of the cost.
  VectorXd sizes(phase.nx + 1), rate(phase.nx);
  phase.field.value(z.data(), rate.data());
  for (int i = 0; i < phase.nx; ++i)
    sizes[i] =
        std::max({std::abs(x[i]), std::abs(piece.end_state[i]), std::abs(rate[i]) * piece.length});
  sizes[phase.nx] = std::abs(running_cost(phase, z.data())) * piece.length + 1e-30;
  if (!sizes.allFinite()) return false;
  const double largest = std::max(1e-6, sizes.head(phase.nx).maxCoeff());
  for (double& size : sizes)
    if (size == 0.0) size = 1e-3 * largest;  // the state stays at zero
  Cvode cvode(phase, piece, x, sizes, 1e-11);
  const double end = piece.start + piece.length;
  double t = piece.start;
  while (t < end) {
    const double before = t;
    if (!cvode.step(end, t)) return false;
    if (visit) {
      visit(before, std::min(t, end), [&](double when, double* state) { cvode.at(when, state); });
    }
    if (!(t > before)) return false;
  }
  x = cvode.state();
  return true;
}

OutsideCheck check_outside(const std::vector<OutsidePhase>& phases,
                           const std::vector<PlanPiece>& plan) {
  OutsideCheck check;
  VectorXd open = plan.front().state;
  double phase_start = plan.front().start;
  VectorXd size = VectorXd::Zero(16);
  for (const PlanPiece& piece : plan)
    size.head(piece.state.size()) = size.head(piece.state.size()).cwiseMax(piece.state.cwiseAbs());
  for (std::size_t k = 0; k < plan.size(); ++k) {
    const PlanPiece& piece = plan[k];
    const OutsidePhase& phase = phases[piece.phase];
    if (k > 0 && plan[k - 1].phase != piece.phase) {
      phase_start = piece.start;
      open = entered(phase, piece.start, open);
      const VectorXd from = entered(phase, piece.start, plan[k - 1].end_state);
      for (int i = 0; i < phase.nx; ++i) {
        note(check.defect, std::abs(piece.state[i] - from[i]), 1e-6 * std::max(1.0, size[i]),
             fmt::format("state {} at the jump into '{}'", i, phase.name));
      }
    } else if (k > 0) {
      for (int i = 0; i < phase.nx; ++i) {
        note(check.defect, std::abs(piece.state[i] - plan[k - 1].end_state[i]),
             1e-6 * std::max(1.0, size[i]), fmt::format("state {} at {:.6g} s", i, piece.start));
      }
    }
    VectorXd x(phase.nx + 1), free(phase.nx + 1);
    x << piece.state, 0.0;
    free << open, 0.0;
    check_inputs(phase, piece, check.path);
    check_node(phase, piece, check.path);
    const bool followed = flow(phase, piece, x, [&](double a, double b, const auto& at) {
      check_path(phase, piece, phase_start, a, b, at, check.path);
    });
    if (!followed || !flow(phase, piece, free)) {
      check.simulated = false;
      return check;
    }
    open = free.head(phase.nx);
    check.cost += x[phase.nx];
    for (int i = 0; i < phase.nx; ++i) {
      // Accuracy that the framework states for an integration: 1e-3 of the state's size.
      const double off = std::abs(x[i] - piece.end_state[i]);
      const std::string where =
          fmt::format("state {} of '{}' in the interval from {:.6g} s", i, phase.name, piece.start);
      note(check.defect, off, 1e-3 * std::max(1e-3, size[i]), where);
      // Accuracy that the framework requires of itself: 1e-4 of the state's size in the interval.
      const double local = std::max(
          {std::min(1.0, size[i]), std::abs(piece.state[i]), std::abs(piece.end_state[i])});
      note(check.stated_defect, off, std::max(1e-8, 1e-4 * local), where);
    }
    if (k + 1 == plan.size() || plan[k + 1].phase != piece.phase) {
      check.cost += check_end(phase, piece, piece.end_state, check.end);
      check_end(phase, piece, open, check.open_loop_end);
    }
  }
  check.largest_state = size.maxCoeff();
  return check;
}

}  // namespace saltus::corpus
