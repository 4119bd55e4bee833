#include "saltus/solver/optimum_system.hpp"

#include <fmt/format.h>

#include <Eigen/KLUSupport>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/solver/gradient_differences.hpp"
#include "saltus/solver/optimum_check.hpp"

namespace saltus {
namespace {

// For the scaled matrix, whose entries are at most 1. The shift keeps the factors of a singular
// matrix finite; refinement with the unshifted matrix corrects it.
constexpr double shift = 1e-10;
// A direction that the matrix scales below this is undetermined: the cost is flat along it, or a
// row is dependent. Two digits above the shift.
constexpr double undecided = 1e-8;
// Shift for counting signs: elimination without pivoting loses about as many digits.
constexpr double inertia_shift = 1e-8;
constexpr int newton_steps = 12;
constexpr int changes_of_sides = 6;
// Multipliers relative to the largest (at most 1) and distances in scaled variables below this do
// not decide whether a side is active. Refinement leaves about 1e-12 in both.
constexpr double weak = 1e-6;
constexpr double violated = 1e-9;
// Scaled KKT errors above which the point is not optimal, before and after refinement.
constexpr double near_optimal = 1e-4;
constexpr double optimal = 1e-7;
constexpr char no_optimum[] = "the point is not optimal: its scaled KKT error is {:.2g}";

using Sparse = Eigen::SparseMatrix<double>;

double largest(const VectorXd& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; }

// Deterministic pseudorandom numbers of magnitude 0.5 to 1.5 and either sign.
VectorXd scattered(Eigen::Index size) {
  VectorXd numbers(size);
  unsigned state = 12345;
  for (double& x : numbers) {
    state = state * 1664525u + 1013904223u;
    x = 2.0 * (state >> 8) / (1u << 24) - 1.0;
    x += x > 0.0 ? 0.5 : -0.5;
  }
  return numbers;
}

int side_of(double multiplier, double value, double lower, double upper) {
  if (lower == upper) return 1;
  const double room = multiplier > 0.0 ? upper - value : value - lower;
  if (!std::isfinite(room) || multiplier == 0.0 || std::abs(multiplier) < room) return 0;
  return multiplier > 0.0 ? 1 : -1;
}

}  // namespace

struct OptimumSystem::Factors {
  Sparse matrix;   // scaled on both sides
  VectorXd scale;  // scale factors of rows and columns
  Eigen::KLU<Sparse> lu;

  // Replaces x by the inverse of the unscaled matrix times x.
  bool solve(VectorXd& x) {
    const VectorXd b = scale.cwiseProduct(x);
    VectorXd y = lu.solve(b), residual = b - matrix * y;
    // each step reduces the error of the shift by a factor of at least 100
    for (int i = 0; i < 20; ++i) {
      const VectorXd better = y + lu.solve(residual);
      const VectorXd left = b - matrix * better;
      if (!(left.norm() < 0.5 * residual.norm())) break;
      y = better;
      residual = left;
    }
    x = scale.cwiseProduct(y);
    constexpr double solved = 1e-7;  // a row without a solution leaves a residual of size one
    return x.allFinite() && largest(residual) <= solved * largest(b);
  }
};

OptimumSystem::~OptimumSystem() = default;
OptimumSystem::OptimumSystem(OptimumSystem&&) noexcept = default;
OptimumSystem& OptimumSystem::operator=(OptimumSystem&&) noexcept = default;

OptimumSystem::OptimumSystem(NonlinearProgram& program, const NlpPoint& optimum,
                             SparsityPattern curvature)
    : program_(&program), point_(optimum), pattern_(std::move(curvature)) {
  if (program.supports(Curvature::exact)) pattern_ = program.hessian_pattern();
  // A Gauss-Newton Hessian would suffice for solving, but its optimum moves differently.
  hessian_name_ = program.supports(Curvature::exact) ? "exact" : "differences of gradients";
  if (point_.z.size() != program.variables()) point_.z = VectorXd::Zero(program.variables());
  residual_ = kkt_residual(program, point_).scaled();
  row_sides_.assign(program.rows(), 0);
  bound_sides_.assign(program.variables(), 0);
  if (!evaluate()) {
    message_ = "the program cannot be evaluated at the solution";
    return;
  }
  if (!(residual_ <= near_optimal)) {  // refinement would lead to another optimum
    message_ = fmt::format(no_optimum, residual_);
    return;
  }
  classify();
  double last = infinity;
  State best{point_, row_sides_, bound_sides_};
  int changes = 0;
  for (int step = 0; step < newton_steps; ++step) {
    if (!evaluate()) break;
    if (step > 0 && changes < changes_of_sides && change_sides()) {
      ++changes;
      last = infinity;
      evaluate();
    }
    const double now = defect();
    if (!(now < 0.5 * last)) break;
    best = {point_, row_sides_, bound_sides_};
    last = now;
    if (!factor() || !newton_step()) break;
  }
  point_ = std::move(best.point);
  row_sides_ = std::move(best.row_sides);
  bound_sides_ = std::move(best.bound_sides);
  if (!evaluate() || !factor()) {
    factors_.reset();
    message_ = "the KKT matrix of the solution has entries that are not finite";
    return;
  }
  for (int i = 0; i < program.variables(); ++i)
    point_.z[i] = bound_sides_[i] != 0 ? -stationarity_[i] : 0.0;
  check();
}

// --- active sides --------------------------------------------------------------------------------

void OptimumSystem::classify() {
  const NonlinearProgram& p = *program_;
  row_sides_.resize(p.rows());
  bound_sides_.resize(p.variables());
  for (int r = 0; r < p.rows(); ++r)
    row_sides_[r] = side_of(point_.lambda[r], g_[r], p.row_lower()[r], p.row_upper()[r]);
  for (int i = 0; i < p.variables(); ++i)
    bound_sides_[i] = side_of(point_.z[i], point_.w[i], p.lower()[i], p.upper()[i]);
  for (int r = 0; r < p.rows(); ++r)
    if (row_sides_[r] == 0) point_.lambda[r] = 0.0;
}

double OptimumSystem::row_gap(int row) const {
  return g_[row] - (row_sides_[row] > 0 ? program_->row_upper() : program_->row_lower())[row];
}

double OptimumSystem::bound_gap(int variable) const {
  return point_.w[variable] -
         (bound_sides_[variable] > 0 ? program_->upper() : program_->lower())[variable];
}

// Releases sides whose multiplier has the wrong sign and activates violated sides.
bool OptimumSystem::change_sides() {
  const NonlinearProgram& p = *program_;
  bool changed = false;
  const auto revise = [&](int& side, double multiplier, double value, double lower, double upper) {
    if (lower == upper) return;
    const int before = side;
    if (side != 0 && side * multiplier < -violated) side = 0;
    if (side == 0 && before == 0 && value > upper + violated) side = 1;
    if (side == 0 && before == 0 && value < lower - violated) side = -1;
    changed = changed || side != before;
  };
  for (int r = 0; r < p.rows(); ++r) {
    revise(row_sides_[r], point_.lambda[r], g_[r], p.row_lower()[r], p.row_upper()[r]);
    if (row_sides_[r] == 0) point_.lambda[r] = 0.0;
  }
  for (int i = 0; i < p.variables(); ++i)
    revise(bound_sides_[i], -stationarity_[i], point_.w[i], p.lower()[i], p.upper()[i]);
  return changed;
}

// --- the system ---------------------------------------------------------------------------------

bool OptimumSystem::evaluate() {
  NonlinearProgram& p = *program_;
  gradient_.resize(p.variables());
  g_.resize(p.rows());
  jacobian_.resize(p.jacobian_pattern().entries());
  if (!p.gradient(point_.w.data(), gradient_.data()) ||
      !p.constraints(point_.w.data(), g_.data()) || !p.jacobian(point_.w.data(), jacobian_.data()))
    return false;
  stationarity_ = gradient_;
  p.jacobian_pattern().for_each(
      [&](int r, int c, int e) { stationarity_[c] += point_.lambda[r] * jacobian_[e]; });
  return stationarity_.allFinite() && g_.allFinite();
}

double OptimumSystem::defect() const {
  double dual = 0.0, primal = 0.0;
  for (std::size_t i = 0; i < bound_sides_.size(); ++i)
    if (bound_sides_[i] == 0)
      dual = std::max(dual, std::abs(stationarity_[i]));
    else
      primal = std::max(primal, std::abs(bound_gap(static_cast<int>(i))));
  for (std::size_t r = 0; r < row_sides_.size(); ++r)
    if (row_sides_[r] != 0) primal = std::max(primal, std::abs(row_gap(static_cast<int>(r))));
  return std::max(primal, dual / (1.0 + largest(point_.lambda)));
}

bool OptimumSystem::factor() {
  NonlinearProgram& p = *program_;
  curvature_.resize(pattern_.entries());
  const bool known = p.supports(Curvature::exact)
                         ? p.hessian(point_.w.data(), 1.0, point_.lambda.data(), curvature_.data(),
                                     Curvature::exact)
                         : difference_gradients(p, point_, pattern_, curvature_);
  if (!known) return false;

  unknown_of_.assign(p.variables(), -1);
  free_ = 0;
  for (int i = 0; i < p.variables(); ++i)
    if (bound_sides_[i] == 0) unknown_of_[i] = free_++;
  // A row whose variables are all at bounds does not determine the others.
  std::vector<char> moves(p.rows(), 0);
  p.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (unknown_of_[c] >= 0 && jacobian_[e] != 0.0) moves[r] = 1;
  });
  row_of_.clear();
  unknown_of_row_.assign(p.rows(), -1);
  for (int r = 0; r < p.rows(); ++r)
    if (row_sides_[r] != 0 && moves[r]) {
      unknown_of_row_[r] = free_ + static_cast<int>(row_of_.size());
      row_of_.push_back(r);
    }
  const int size = free_ + static_cast<int>(row_of_.size());

  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j, double value) {
    entries.emplace_back(i, j, value);
    if (i != j) entries.emplace_back(j, i, value);
  };
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, 0.0);
  pattern_.for_each([&](int r, int c, int e) {
    if (unknown_of_[r] >= 0 && unknown_of_[c] >= 0)
      add(unknown_of_[r], unknown_of_[c], curvature_[e]);
  });
  p.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (unknown_of_row_[r] >= 0 && unknown_of_[c] >= 0)
      add(unknown_of_row_[r], unknown_of_[c], jacobian_[e]);
  });
  factors_ = std::make_unique<Factors>();
  Factors& f = *factors_;
  f.matrix.resize(size, size);
  f.matrix.setFromTriplets(entries.begin(), entries.end());

  // Scales rows and columns alike until their largest entries are about 1 (Ruiz).
  f.scale = VectorXd::Ones(size);
  for (int round = 0; round < 6; ++round) {
    VectorXd size_of = VectorXd::Zero(size);
    for (int j = 0; j < size; ++j)
      for (Sparse::InnerIterator e(f.matrix, j); e; ++e)
        size_of[j] = std::max(size_of[j], std::abs(e.value()));
    for (double& s : size_of) s = s > 0.0 ? 1.0 / std::sqrt(s) : 1.0;
    f.matrix = (size_of.asDiagonal() * f.matrix * size_of.asDiagonal()).eval();
    f.scale = f.scale.cwiseProduct(size_of);
  }
  if (!f.scale.allFinite()) return false;
  Sparse shifted = f.matrix;
  for (int i = 0; i < size; ++i) shifted.coeffRef(i, i) += i < free_ ? shift : -shift;
  f.lu.compute(shifted);
  return f.lu.info() == Eigen::Success;
}

bool OptimumSystem::solve(const OptimumRates& rates, OptimumMovement& moved) const {
  const NonlinearProgram& p = *program_;
  moved.w = VectorXd::Zero(p.variables());
  moved.lambda = VectorXd::Zero(p.rows());
  if (factors_ == nullptr) return false;
  VectorXd x = VectorXd::Zero(factors_->scale.size());
  for (int i = 0; i < p.variables(); ++i)
    if (unknown_of_[i] < 0)
      moved.w[i] = rates.bounds[i];
    else
      x[unknown_of_[i]] = -rates.gradient[i];
  for (std::size_t k = 0; k < row_of_.size(); ++k)
    x[free_ + static_cast<int>(k)] = -rates.rows[row_of_[k]];
  pattern_.for_each([&](int r, int c, int e) {
    if (unknown_of_[r] >= 0 && unknown_of_[c] < 0) x[unknown_of_[r]] -= curvature_[e] * moved.w[c];
    if (unknown_of_[c] >= 0 && unknown_of_[r] < 0) x[unknown_of_[c]] -= curvature_[e] * moved.w[r];
  });
  p.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (unknown_of_row_[r] >= 0 && unknown_of_[c] < 0)
      x[unknown_of_row_[r]] -= jacobian_[e] * moved.w[c];
  });
  if (!factors_->solve(x)) return false;
  for (int i = 0; i < p.variables(); ++i)
    if (unknown_of_[i] >= 0) moved.w[i] = x[unknown_of_[i]];
  for (std::size_t k = 0; k < row_of_.size(); ++k)
    moved.lambda[row_of_[k]] = x[free_ + static_cast<int>(k)];
  moved.one_sided = one_sided(rates, moved);
  return true;
}

// The multiplier of w_i = const acts as a force along w_i; its size is that which moves w_i by one.
bool OptimumSystem::hold(int variable, OptimumMovement& moved) const {
  OptimumRates rates = no_rates();
  if (bound_sides_[variable] != 0) {
    rates.bounds[variable] = 1.0;
    return solve(rates, moved);
  }
  rates.gradient[variable] = 1.0;
  if (!solve(rates, moved) || moved.w[variable] == 0.0) return false;
  moved.lambda /= moved.w[variable];
  moved.w /= moved.w[variable];
  if (!moved.w.allFinite()) return false;
  // If rows determine the variable, nothing moves and the divisor is rounding error.
  VectorXd along = VectorXd::Zero(program_->rows()), size = along;
  program_->jacobian_pattern().for_each([&](int r, int c, int e) {
    if (unknown_of_row_[r] < 0) return;
    along[r] += jacobian_[e] * moved.w[c];
    size[r] += std::abs(jacobian_[e] * moved.w[c]);
  });
  constexpr double kept = 1e-6;
  return (along.array().abs() <= kept * (size.array() + kept)).all();
}

OptimumRates OptimumSystem::no_rates() const {
  const VectorXd none = VectorXd::Zero(program_->variables());
  return {none, VectorXd::Zero(program_->rows()), none};
}

bool OptimumSystem::newton_step() {
  OptimumRates defect = no_rates();
  defect.gradient = stationarity_;
  for (int i = 0; i < program_->variables(); ++i)
    if (bound_sides_[i] != 0) defect.bounds[i] = -bound_gap(i);
  for (const int r : row_of_) defect.rows[r] = row_gap(r);
  OptimumMovement step;
  if (!solve(defect, step)) return false;
  point_.w += step.w;
  point_.lambda += step.lambda;
  return true;
}

// --- reliability ---------------------------------------------------------------------------------

// By Sylvester's law, a matrix with as many negative pivots as rows has a Hessian that is positive
// definite on the tangent space of the rows.
bool OptimumSystem::has_positive_curvature() const {
  Sparse shifted = factors_->matrix;
  for (int i = 0; i < shifted.rows(); ++i)
    shifted.coeffRef(i, i) += i < free_ ? inertia_shift : -inertia_shift;
  Eigen::SimplicialLDLT<Sparse> ldl(shifted);
  return ldl.info() == Eigen::Success &&
         (ldl.vectorD().array() < 0.0).count() == static_cast<Eigen::Index>(row_of_.size());
}

void OptimumSystem::check() {
  NonlinearProgram& p = *program_;
  residual_ = kkt_residual(p, point_).scaled();
  if (!(residual_ <= optimal)) {
    message_ = fmt::format(no_optimum, residual_);
    return;
  }
  if (factors_->scale.size() > 0) {
    VectorXd probe = factors_->lu.solve(scattered(factors_->scale.size()));
    Eigen::Index worst = 0;
    if (!(probe.cwiseAbs().maxCoeff(&worst) * undecided < 1.0)) {
      if (worst >= free_) {
        message_ = fmt::format("active constraints are linearly dependent, among them {}",
                               p.describe_row(row_of_[worst - free_]));
      } else {
        const auto variable =
            std::find(unknown_of_.begin(), unknown_of_.end(), static_cast<int>(worst));
        message_ =
            fmt::format("the solution is not unique to second order: nothing determines {}",
                        p.describe_variable(static_cast<int>(variable - unknown_of_.begin())));
      }
      return;
    }
    if (!has_positive_curvature()) {
      message_ = fmt::format(
          "the {} Hessian is not positive definite on the tangent space of the active constraints",
          hessian_name_);
      return;
    }
  }
  const double scale = std::min(1.0, std::max(largest(point_.lambda), largest(point_.z)));
  const auto is_weak = [&](int side, double multiplier, double value, double lower, double upper) {
    if (lower == upper) return false;
    if (side != 0) return std::abs(multiplier) <= weak * scale;
    return upper - value < weak || value - lower < weak;
  };
  for (int r = 0; r < p.rows(); ++r)
    if (is_weak(row_sides_[r], point_.lambda[r], g_[r], p.row_lower()[r], p.row_upper()[r]))
      weak_rows_.push_back(r);
  for (int i = 0; i < p.variables(); ++i)
    if (is_weak(bound_sides_[i], point_.z[i], point_.w[i], p.lower()[i], p.upper()[i]))
      weak_bounds_.push_back(i);
}

// The multiplier of an active weak side must not change, and neither must the distance to an
// inactive one: either change would be possible for one sign of theta only.
std::string OptimumSystem::one_sided(const OptimumRates& rates,
                                     const OptimumMovement& moved) const {
  const NonlinearProgram& p = *program_;
  if (weak_rows_.empty() && weak_bounds_.empty()) return {};
  VectorXd rows = rates.rows;  // rate of g - side
  VectorXd gradient = rates.gradient;
  p.jacobian_pattern().for_each([&](int r, int c, int e) {
    rows[r] += jacobian_[e] * moved.w[c];
    gradient[c] += jacobian_[e] * moved.lambda[r];
  });
  pattern_.for_each([&](int r, int c, int e) {
    gradient[r] += curvature_[e] * moved.w[c];
    if (r != c) gradient[c] += curvature_[e] * moved.w[r];
  });
  const double size = 1.0 + std::max(largest(moved.w), largest(moved.lambda));
  constexpr double still = 1e-7;  // rounding error of the solves and of differences
  const auto sentence = [](const std::string& who) {
    return "an active bound has no multiplier, so the derivatives in both directions differ: " +
           who;
  };
  for (const int r : weak_rows_)
    if (std::abs(row_sides_[r] != 0 ? moved.lambda[r] : rows[r]) > still * size)
      return sentence(p.describe_row(r));
  for (const int i : weak_bounds_)
    if (std::abs(bound_sides_[i] != 0 ? gradient[i] : moved.w[i] - rates.bounds[i]) > still * size)
      return sentence(p.describe_variable(i));
  return {};
}

}  // namespace saltus
