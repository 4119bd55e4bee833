#include "saltus/model/algebraic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

// Newton's method converges quadratically: after a correction this small, only rounding remains.
// The correction must be this small relative to both nominal + |z| and |z|, because |z| may be far
// below its nominal value. If z converges to zero or loses digits to cancellation, one of two other
// criteria ends the iteration: the correction is at rounding level of the largest z so far, or
// corrections no longer decrease.
constexpr double converged_correction = 1e-9;
constexpr double rounding = 1e-15;
constexpr int max_corrections = 100;
constexpr double shortest_step = 1e-6;

bool finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

void spoil(double* values, int count) {
  std::fill_n(values, count, std::numeric_limits<double>::quiet_NaN());
}

// Index of an entry of (t | x z | u | p) in (t | x | u | p), or -1 for an entry of z.
int reduced(const Arguments& sizes, int nz, int column) {
  const int first = 1 + sizes.nx;
  if (column < first) return column;
  return column < first + nz ? -1 : column - nz;
}

}  // namespace

AlgebraicEquations::Solution::Solution(int equations, int arguments, int entry_count)
    : argument(arguments),
      entries(entry_count),
      slope(equations),
      direct(equations * (arguments - equations)),
      residual(equations),
      step(equations),
      next_step(equations),
      before(equations),
      largest(equations) {}

AlgebraicEquations::AlgebraicEquations(const Arguments& sizes, Function equations, VectorXd start)
    : sizes_(sizes), equations_(std::move(equations)), start_(std::move(start)) {
  const int nz = count();
  if (equations_.inputs() != extended().size() || equations_.outputs() != nz)
    throw DefinitionError(
        fmt::format("{} algebraic equations are given for {} algebraic states; they take {} "
                    "arguments, expected {}.",
                    equations_.outputs(), nz, equations_.inputs(), extended().size()));
  if (!start_.allFinite())
    throw DefinitionError("the guess of the algebraic states is not finite.");
  nominal_ = start_.cwiseAbs();
  for (double& magnitude : nominal_)
    if (magnitude == 0.0) magnitude = 1.0;
  affine_ = is_affine_in(equations_, 1 + sizes_.nx, nz);
  find_dependencies();
}

// Matches each equation with an entry of z that it contains, along augmenting paths. If no complete
// matching exists, g_z is structurally singular. Otherwise z_j depends on the arguments of its
// equation and on the other entries of z in that equation.
void AlgebraicEquations::find_dependencies() {
  const int nz = count(), first = 1 + sizes_.nx;
  const SparsityPattern& pattern = equations_.jacobian_pattern();
  std::vector<int> equation_of(nz, -1);
  std::vector<char> visited;
  const auto match = [&](const auto& self, int equation) -> bool {
    for (int e = pattern.row_begin(equation); e < pattern.row_end(equation); ++e) {
      const int j = pattern.col(e) - first;
      if (j < 0 || j >= nz || visited[j]) continue;
      visited[j] = 1;
      if (equation_of[j] >= 0 && !self(self, equation_of[j])) continue;
      equation_of[j] = equation;
      return true;
    }
    return false;
  };
  for (int equation = 0; equation < nz; ++equation) {
    visited.assign(nz, 0);
    if (match(match, equation)) continue;
    const bool reads_z = std::any_of(visited.begin(), visited.end(), [](char v) { return v != 0; });
    throw DefinitionError(fmt::format(
        "algebraic equation {} of {}, counted from 0, {}: g_z is singular and the index exceeds 1; "
        "replace the equation by its time derivative.",
        equation, nz,
        reads_z ? "contains no algebraic state that earlier equations leave undetermined"
                : "contains no algebraic state"));
  }
  depends_.assign(nz, std::vector<char>(sizes_.size(), 0));
  for (int j = 0; j < nz; ++j) {
    std::vector<char> reached(nz, 0);
    std::vector<int> open = {j};
    reached[j] = 1;
    while (!open.empty()) {
      const int equation = equation_of[open.back()];
      open.pop_back();
      for (int e = pattern.row_begin(equation); e < pattern.row_end(equation); ++e) {
        const int argument = reduced(sizes_, nz, pattern.col(e));
        if (argument >= 0) {
          depends_[j][argument] = 1;
        } else if (const int k = pattern.col(e) - first; !reached[k]) {
          reached[k] = 1;
          open.push_back(k);
        }
      }
    }
  }
}

std::shared_ptr<const AlgebraicEquations> AlgebraicEquations::separate(
    const std::shared_ptr<const AlgebraicEquations>& equations) {
  const Function own = equations->equations_.separate();
  if (!own) return nullptr;
  if (own.is(equations->equations_)) return equations;
  const auto separated = std::make_shared<AlgebraicEquations>(*equations);
  separated->equations_ = own;
  return separated;
}

bool AlgebraicEquations::evaluate(AlgebraicEquations::Solution& s) const {
  equations_.jacobian(s.argument.data(), s.residual.data(), s.entries.data());
  return finite(s.residual);
}

double AlgebraicEquations::size_of(const std::vector<double>& step,
                                   const AlgebraicEquations::Solution& s) const {
  const double* z = s.argument.data() + 1 + sizes_.nx;
  double size = 0.0;
  for (int j = 0; j < count(); ++j) {
    const double relative = std::abs(step[j]) / (nominal_[j] + std::abs(z[j]));
    size = relative > size || std::isnan(relative) ? relative : size;
  }
  return size;
}

bool AlgebraicEquations::is_last(const AlgebraicEquations::Solution& s) const {
  const double* z = s.argument.data() + 1 + sizes_.nx;
  for (int j = 0; j < count(); ++j)
    if (std::abs(s.step[j]) >
        std::max(converged_correction * std::abs(z[j]), rounding * s.largest[j]))
      return false;
  return true;
}

AlgebraicEquations::Status AlgebraicEquations::solve(const double* argument,
                                                     AlgebraicEquations::Solution& s) const {
  const int nz = count(), first = 1 + sizes_.nx;
  double* z = s.argument.data() + first;
  std::copy_n(argument, first, s.argument.begin());
  std::copy(start_.begin(), start_.end(), z);
  std::copy_n(argument + first, sizes_.size() - first, s.argument.begin() + first + nz);
  s.equation = -1;
  const auto worst_equation = [&] {
    for (int i = 0; i < nz; ++i)
      if (s.equation < 0 || !std::isfinite(s.residual[i]) ||
          std::abs(s.residual[i]) > std::abs(s.residual[s.equation]))
        s.equation = i;
  };
  if (!evaluate(s)) {
    worst_equation();
    return AlgebraicEquations::Status::not_finite;
  }
  std::fill(s.largest.begin(), s.largest.end(), 0.0);
  bool is_small = false;
  for (int k = 0; k < max_corrections; ++k) {
    if (const AlgebraicEquations::Status status = factor(s);
        status != AlgebraicEquations::Status::solved)
      return status;
    s.step = s.residual;
    s.slope.solve(s.step.data());
    const double size = size_of(s.step, s);
    std::copy_n(z, nz, s.before.begin());
    for (int j = 0; j < nz; ++j) s.largest[j] = std::max(s.largest[j], std::abs(z[j]));
    // Damping: shortens the step until the next correction with the same factors is shorter. This
    // measures progress in z, independent of the scaling of the equations.
    double fraction = 1.0;
    for (;; fraction *= 0.5) {
      for (int j = 0; j < nz; ++j) z[j] = s.before[j] - fraction * s.step[j];
      const bool evaluated = evaluate(s);
      is_small = evaluated && size <= converged_correction;
      if (evaluated && (affine_ || (is_small && is_last(s))))
        return AlgebraicEquations::Status::solved;
      if (evaluated) {
        s.next_step = s.residual;
        s.slope.solve(s.next_step.data());
        if (size_of(s.next_step, s) <= (1.0 - 0.25 * fraction) * size) break;
      }
      if (fraction < shortest_step) {
        if (is_small) return AlgebraicEquations::Status::solved;
        worst_equation();
        return evaluated ? AlgebraicEquations::Status::no_solution
                         : AlgebraicEquations::Status::not_finite;
      }
    }
  }
  if (is_small) return AlgebraicEquations::Status::solved;
  worst_equation();
  return AlgebraicEquations::Status::no_solution;
}

AlgebraicEquations::Status AlgebraicEquations::factor(AlgebraicEquations::Solution& s) const {
  const int nz = count(), first = 1 + sizes_.nx;
  for (int i = 0; i < nz; ++i) std::fill_n(s.slope.row(i), nz, 0.0);
  equations_.jacobian_pattern().for_each([&](int i, int column, int e) {
    if (column >= first && column < first + nz) s.slope.row(i)[column - first] = s.entries[e];
  });
  if (s.slope.factor()) return AlgebraicEquations::Status::solved;
  s.equation = s.slope.singular_row();
  return s.equation < 0 ? AlgebraicEquations::Status::not_finite
                        : AlgebraicEquations::Status::singular;
}

void AlgebraicEquations::differentiate(AlgebraicEquations::Solution& s) const {
  const int columns = sizes_.size();
  std::fill(s.direct.begin(), s.direct.end(), 0.0);
  equations_.jacobian_pattern().for_each([&](int i, int column, int e) {
    if (const int argument = reduced(sizes_, count(), column); argument >= 0)
      s.direct[i * columns + argument] = -s.entries[e];
  });
  s.slope.solve(s.direct.data(), columns);
}

namespace {

// F(t, x, Z(t, x, u, p), u, p). With a = (t | x | u | p), T = da (x, z) / da = (I | Z_a), and mu
// the solution of g_z' mu = -F_z' lambda:
//   dF = F_a + F_z Z_a,     d2 (lambda' F) = T' (lambda' F + mu' g)'' T.
class Eliminated final : public FunctionBody {
 public:
  Eliminated(Function extended, std::shared_ptr<const AlgebraicEquations> equations,
             detail::Lending lending = detail::Lending::shared)
      : FunctionBody(equations->sizes().size(), extended.outputs()),
        extended_(std::move(extended)),
        equations_(std::move(equations)),
        first_(1 + equations_->sizes().nx),
        nz_(equations_->count()),
        workspaces_(lending) {
    if (extended_.inputs() != equations_->extended().size())
      throw DefinitionError(
          fmt::format("a function of (t, x, z, u, p) must take {} arguments, but takes {}.",
                      equations_->extended().size(), extended_.inputs()));
    for (int j = 0; j < nz_; ++j) reads_z_ = reads_z_ || extended_.reads(first_ + j);
    find_patterns();
    workspaces_.add(new_workspace());
  }

  AlgebraicPart part() const { return {extended_, equations_}; }

  int degree(int output, const std::vector<char>& variable) const override {
    std::vector<char> moves(extended_.inputs(), 0);
    bool z_moves = false;
    for (int c = 0; c < extended_.inputs(); ++c) {
      const int a = reduced(equations_->sizes(), nz_, c);
      for (int i = 0; a < 0 && i < inputs(); ++i)
        if (variable[i] && equations_->depends(c - first_, i)) moves[c] = 1;
      if (a >= 0) moves[c] = variable[a];
      z_moves = z_moves || (a < 0 && moves[c] && depends_on(extended_, output, c));
    }
    if (z_moves)
      for (int i = 0; i < nz_; ++i)
        if (equations_->equations().degree(i, moves) > 1) return 3;
    return extended_.degree(output, moves);
  }

  bool is_reentrant() const override {
    return workspaces_.is_shared() && extended_.is_reentrant() &&
           equations_->equations().is_reentrant();
  }
  std::shared_ptr<const FunctionBody> separate() const override {
    const Function extended = extended_.separate();
    const auto equations = AlgebraicEquations::separate(equations_);
    return extended && equations
               ? std::make_shared<Eliminated>(extended, equations, detail::Lending::exclusive)
               : nullptr;
  }

  bool reads(int input) const override {
    const int column = input < first_ ? input : input + nz_;
    return extended_.reads(column) || (reads_z_ && equations_->equations().reads(column));
  }

  void value(const double* a, double* y) const override {
    const Pool::Loan work = lend();
    AlgebraicEquations::Solution& s = work->solution;
    if (!place(a, s)) return spoil(y, outputs());
    extended_.value(s.argument.data(), y);
  }

  void jacobian(const double* a, double* y, double* entries) const override {
    const Pool::Loan work = lend();
    AlgebraicEquations::Solution& s = work->solution;
    if (!differentiate(a, s)) {
      spoil(y, outputs());
      return spoil(entries, jacobian_pattern_.entries());
    }
    const SparsityPattern& pattern = extended_.jacobian_pattern();
    extended_.jacobian(s.argument.data(), y, work->values.data());
    for (int r = 0; r < outputs(); ++r) {
      double* row = work->product.data();
      std::fill_n(row, inputs(), 0.0);
      for (int e = pattern.row_begin(r); e < pattern.row_end(r); ++e)
        add_row(s, pattern.col(e), work->values[e], row);
      for (int e = jacobian_pattern_.row_begin(r); e < jacobian_pattern_.row_end(r); ++e)
        entries[e] = row[jacobian_pattern_.col(e)];
    }
  }

  void hessian(const double* a, const double* weights, double* entries,
               Curvature curvature) const override {
    if (hessian_pattern_.entries() == 0) return;
    const Pool::Loan work = lend();
    AlgebraicEquations::Solution& s = work->solution;
    if (!differentiate(a, s)) return spoil(entries, hessian_pattern_.entries());
    const int n = inputs();
    double *values = work->values.data(), *product = work->product.data();
    std::fill_n(product, (n + nz_) * n, 0.0);
    const auto add = [&](const Function& f) {  // product += f'' T
      f.hessian_pattern().for_each([&](int r, int c, int e) {
        add_row(s, c, values[e], product + r * n);
        if (r != c) add_row(s, r, values[e], product + c * n);
      });
    };
    if (reads_z_ && curvature == Curvature::exact) {
      find_multipliers(weights, *work);
      equations_->equations().hessian(s.argument.data(), work->multipliers.data(), values);
      add(equations_->equations());
    }
    extended_.hessian(s.argument.data(), weights, values, curvature);
    add(extended_);
    hessian_pattern_.for_each([&](int i, int j, int e) {
      double sum = product[(i < first_ ? i : i + nz_) * n + j];
      for (int k = 0; reads_z_ && k < nz_; ++k)
        sum += s.direct[k * n + i] * product[(first_ + k) * n + j];
      entries[e] = sum;
    });
  }

 private:
  struct Workspace {
    AlgebraicEquations::Solution solution;
    std::vector<double> values;       // entries of derivatives of F or g
    std::vector<double> product;      // F'' T, rows of (t | x z | u | p); or a row of F'
    std::vector<double> multipliers;  // mu
    std::vector<double> outputs;      // F
  };
  using Pool = detail::WorkspacePool<Workspace>;

  std::unique_ptr<Workspace> new_workspace() const {
    const int entries =
        std::max({extended_.jacobian_pattern().entries(), extended_.hessian_pattern().entries(),
                  equations_->equations().hessian_pattern().entries()});
    return std::make_unique<Workspace>(
        Workspace{equations_->new_solution(), std::vector<double>(entries),
                  std::vector<double>((inputs() + nz_) * inputs()), std::vector<double>(nz_),
                  std::vector<double>(outputs())});
  }
  Pool::Loan lend() const {
    return workspaces_.lend([this] { return new_workspace(); });
  }

  void find_patterns() {
    const int n = inputs();
    std::vector<std::pair<int, int>> first, second;
    const auto for_each_reached = [&](int column, const auto& visit) {
      if (const int a = reduced(equations_->sizes(), nz_, column); a >= 0) return visit(a);
      for (int i = 0; i < n; ++i)
        if (equations_->depends(column - first_, i)) visit(i);
    };
    extended_.jacobian_pattern().for_each(
        [&](int r, int c, int) { for_each_reached(c, [&](int i) { first.emplace_back(r, i); }); });
    const auto add = [&](const Function& f) {
      f.hessian_pattern().for_each([&](int a, int b, int) {
        for_each_reached(a, [&](int i) {
          for_each_reached(b, [&](int j) { second.emplace_back(std::max(i, j), std::min(i, j)); });
        });
      });
    };
    add(extended_);
    if (reads_z_) add(equations_->equations());
    jacobian_pattern_ = SparsityPattern::from_pairs(outputs(), n, std::move(first));
    hessian_pattern_ = SparsityPattern::from_pairs(n, n, std::move(second));
  }

  // Writes (t | x z | u | p). If z is not read, it keeps its guess.
  bool place(const double* a, AlgebraicEquations::Solution& s) const {
    if (reads_z_) return equations_->solve(a, s) == AlgebraicEquations::Status::solved;
    std::copy_n(a, first_, s.argument.begin());
    std::copy_n(equations_->start().data(), nz_, s.argument.begin() + first_);
    std::copy_n(a + first_, inputs() - first_, s.argument.begin() + first_ + nz_);
    return true;
  }

  bool differentiate(const double* a, AlgebraicEquations::Solution& s) const {
    if (!place(a, s)) return false;
    if (!reads_z_) return true;
    if (equations_->factor(s) != AlgebraicEquations::Status::solved) return false;
    equations_->differentiate(s);
    return true;
  }

  // row += factor * (derivative of entry `column` of (t | x z | u | p)).
  void add_row(const AlgebraicEquations::Solution& s, int column, double factor,
               double* row) const {
    if (const int a = reduced(equations_->sizes(), nz_, column); a >= 0) {
      row[a] += factor;
      return;
    }
    const double* direct = s.direct.data() + (column - first_) * inputs();
    for (int i = 0; i < inputs(); ++i) row[i] += factor * direct[i];
  }

  void find_multipliers(const double* weights, Workspace& work) const {
    const AlgebraicEquations::Solution& s = work.solution;
    extended_.jacobian(s.argument.data(), work.outputs.data(), work.values.data());
    std::fill(work.multipliers.begin(), work.multipliers.end(), 0.0);
    extended_.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (c >= first_ && c < first_ + nz_)
        work.multipliers[c - first_] -= weights[r] * work.values[e];
    });
    s.slope.solve_transposed(work.multipliers.data());
  }

  Function extended_;
  std::shared_ptr<const AlgebraicEquations> equations_;
  int first_, nz_;
  bool reads_z_ = false;
  Pool workspaces_;
};

// Selected entries of z as a function of (t | x | u | p).
class AlgebraicEntries final : public FunctionBody {
 public:
  AlgebraicEntries(const Arguments& extended, int first, int count)
      : FunctionBody(extended.size(), count), first_(first) {
    std::vector<std::pair<int, int>> pairs;
    pairs.reserve(count);
    for (int j = 0; j < count; ++j) pairs.emplace_back(j, first + j);
    jacobian_pattern_ = SparsityPattern::from_pairs(count, inputs(), std::move(pairs));
    hessian_pattern_ = SparsityPattern(inputs(), inputs());
  }
  int degree(int output, const std::vector<char>& variable) const override {
    return variable[first_ + output] ? 1 : 0;
  }
  bool is_reentrant() const override { return true; }
  void value(const double* a, double* y) const override { std::copy_n(a + first_, outputs(), y); }
  void jacobian(const double* a, double* y, double* entries) const override {
    value(a, y);
    std::fill_n(entries, outputs(), 1.0);
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  int first_;
};

}  // namespace

Function eliminate(Function extended, std::shared_ptr<const AlgebraicEquations> equations) {
  return Function(std::unique_ptr<const FunctionBody>(
      std::make_unique<Eliminated>(std::move(extended), std::move(equations))));
}

AlgebraicPart dae_before_elimination(const Function& function) {
  const auto* body = static_cast<const FunctionBody*>(function.identity());
  const auto* eliminated = dynamic_cast<const Eliminated*>(body);
  return eliminated == nullptr ? AlgebraicPart{} : eliminated->part();
}

Function algebraic_states(std::shared_ptr<const AlgebraicEquations> equations) {
  Function entries(std::unique_ptr<const FunctionBody>(std::make_unique<AlgebraicEntries>(
      equations->extended(), 1 + equations->sizes().nx, equations->count())));
  return eliminate(std::move(entries), std::move(equations));
}

Function algebraic_state(std::shared_ptr<const AlgebraicEquations> equations, int entry) {
  Function one(std::unique_ptr<const FunctionBody>(std::make_unique<AlgebraicEntries>(
      equations->extended(), 1 + equations->sizes().nx + entry, 1)));
  return eliminate(std::move(one), std::move(equations));
}

ConsistentStart consistent_start(const AlgebraicEquations& equations, const VectorRef& argument) {
  if (argument.size() != equations.sizes().size())
    throw DefinitionError(
        fmt::format("consistent_start() takes (t, x, u, p) with {} entries, but {} are given.",
                    equations.sizes().size(), argument.size()));
  AlgebraicEquations::Solution s = equations.new_solution();
  const VectorXd given = argument;
  ConsistentStart result;
  result.status = equations.solve(given.data(), s);
  if (result.found()) result.status = equations.factor(s);
  const int nz = equations.count();
  result.z = Eigen::Map<const VectorXd>(s.argument.data() + 1 + equations.sizes().nx, nz);
  result.residual = Eigen::Map<const VectorXd>(s.residual.data(), nz);
  result.equation = result.found() ? -1 : s.equation;
  const double t = given[0];
  const std::string which =
      fmt::format("algebraic equation {} of {}, counted from 0,", std::max(0, result.equation), nz);
  switch (result.status) {
    case AlgebraicEquations::Status::solved: {
      int moved = 0;
      (result.z - equations.start()).cwiseAbs().maxCoeff(&moved);
      result.message = fmt::format(
          "the algebraic equations are satisfied at t = {:.6g} s; algebraic state {} differs most "
          "from its guess: {:.6g} instead of {:.6g}",
          t, moved, result.z[moved], equations.start()[moved]);
      break;
    }
    case AlgebraicEquations::Status::not_finite:
      result.message = fmt::format("{} is not finite at t = {:.6g} s", which, t);
      break;
    case AlgebraicEquations::Status::singular:
      result.message = fmt::format(
          "{} does not determine an algebraic state at t = {:.6g} s: g_z is singular there, so the "
          "index exceeds 1",
          which, t);
      break;
    case AlgebraicEquations::Status::no_solution:
      result.message = fmt::format(
          "the algebraic equations have no solution near the guess at t = {:.6g} s: {} has the "
          "residual {:.3g}",
          t, which, std::abs(result.residual[std::max(0, result.equation)]));
      break;
  }
  return result;
}

}  // namespace saltus
