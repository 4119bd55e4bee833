// Turns a user's formula, a template over the scalar, into a Function with exact derivatives and
// exact sparsity. No other code knows the type of the formula.
//
// A formula is a functor with a const operator() or a generic lambda. It is called as f(t, x), f(t,
// x, u) or f(t, x, u, p), where t is a scalar S and x, u, p are Vec<S, nx>, Vec<S, nu>, Vec<S, np>.
// It returns a scalar (one output) or a Vec<S, m>. The Function stores a copy, which must not
// change.
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/autodiff/dual.hpp"
#include "saltus/autodiff/math.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

namespace detail {

// Compression of sparse Jacobians and Hessians: inputs share directions of differentiation, so that
// few evaluations give all entries.
//
// Columns of a Jacobian without a common row can share one direction: every entry of their sum
// belongs to one column. A lane of a dual number is one direction, and a pass is one evaluation
// with all lanes (Curtis, Powell and Reid 1974). A Hessian entry (i, j) follows from outer
// direction j and lane i, or vice versa. The outer directions therefore need to touch every pair
// only once: they form a small vertex cover of the pairs.

/// Seeds d z[input] / d lane = 1.
struct Seed {
  int input;  ///< index in z
  int lane;   ///< direction
};
/// entries[entry] is the factor of `lane` in output `row`. For a Hessian, row 0 is the weighted
/// sum.
struct Reading {
  int row;    ///< output
  int lane;   ///< direction
  int entry;  ///< index in the order of the pattern
};

/// One evaluation for entries of a Jacobian.
struct JacobianPass {
  std::vector<Seed> seeds;        ///< inputs seeded per lane
  std::vector<Reading> readings;  ///< entries read after the evaluation
  std::vector<double> tangents;   ///< the seeds as numbers, `lanes` per input
};
/// Passes of at most `lanes` directions for a Jacobian. Inputs without entries are not seeded.
std::vector<JacobianPass> jacobian_passes(const SparsityPattern& jacobian, int lanes);

/// A direction of a Hessian: the product of the Hessian and the sum of unit vectors.
struct HessianDirection {
  std::vector<int> inputs;                    ///< inputs of the direction
  std::vector<std::pair<int, int>> readings;  ///< row of the product and index of its entry
};
/// Directions whose products contain all entries of a lower-triangular pattern.
std::vector<HessianDirection> hessian_directions(const SparsityPattern& hessian);

/// One evaluation for entries of a Hessian.
struct HessianPass {
  std::vector<int> outer;              ///< inputs of the outer direction
  std::vector<Seed> seeds;             ///< inputs seeded per lane
  std::vector<Reading> readings;       ///< entries read after the evaluation
  std::vector<double> tangents;        ///< the seeds as numbers, `lanes` per input
  std::vector<double> outer_tangents;  ///< the outer direction, one number per input
};
/// Passes of one outer and at most `lanes` inner directions for a lower-triangular pattern.
std::vector<HessianPass> hessian_passes(const SparsityPattern& hessian, int lanes);

}  // namespace detail

// Structural properties of a function from its sparsity: dependence on inputs and affinity.

namespace detail {

/// Sparsity patterns of a formula, found by one trace.
struct FormulaStructure {
  SparsityPattern jacobian;                ///< outputs x inputs
  SparsityPattern hessian;                 ///< inputs x inputs, lower triangle, of any output
  std::vector<SparsityPattern> curvature;  ///< per output: its part of `hessian`
};
/// Patterns of traced outputs.
FormulaStructure structure_of(int inputs, const std::vector<Tracer>& outputs);

}  // namespace detail

/// True if any output may depend on the input.
bool depends_on(const Function& function, int input);
/// True if this output may depend on the input.
bool depends_on(const Function& function, int output, int input);
/// True if any output may depend on one of the inputs z[first .. first + count).
bool depends_on_any(const Function& function, int first, int count);

/// True if all outputs are jointly affine in z[first .. first + count) with the other inputs fixed,
/// i.e. no second derivatives within this range. The slopes may depend on the other inputs.
bool is_affine_in(const Function& function, int first, int count);

// Traces a formula once where it is defined, to find its structure or an out-of-range access.

/// Name of a formula in messages: "phase 'motion', term 'lane'".
struct FormulaName {
  std::string_view phase = {};  ///< empty: no phase
  std::string_view what = {};   ///< kind: "term", "the dynamics"
  std::string_view name = {};   ///< name of the formula, if any
};

namespace detail {

/// Computes y = formula(z) with tracers, one entry of z per input.
using TraceFormula = std::function<void(const Tracer* z, Tracer* y)>;

/// Finds the patterns and records the steps of the formula. Throws DefinitionError with the formula
/// and the entry if the formula accesses an entry out of range or returns an unwritten entry.
FormulaStructure traced_structure(const FormulaName& name, const Arguments& sizes, int outputs,
                                  const TraceFormula& trace, FormulaSteps& steps);

/// Returns the function. Throws DefinitionError with the name if it is empty, if its argument is
/// not z = (t | x | u | p) of these sizes, or if its patterns do not have the sizes of its
/// derivatives.
Function checked_function(Function function, const Arguments& sizes, const FormulaName& name);

}  // namespace detail

}  // namespace saltus

namespace saltus::detail {

// Common base of the bodies of all formulas: traced patterns, the passes that fill them, and the
// steps of the formula. Compiled once, not with every formula.

class TracedBody : public FunctionBody {
 public:
  ~TracedBody() override;
  int degree(int output, const std::vector<char>& variable) const override;
  bool is_reentrant() const override { return true; }
  const FormulaSteps* steps() const override { return steps_.get(); }

 protected:
  TracedBody(int inputs, int outputs);
  /// Finds patterns and passes. Call it at the end of the derived constructor. Throws
  /// DefinitionError with the formula, see traced_structure().
  void find_structure(const FormulaName& name, const Arguments& sizes, int jacobian_lanes,
                      int hessian_lanes);
  /// Computes y = formula(z) with inputs() and outputs() entries.
  virtual void trace(const Tracer* z, Tracer* y) const = 0;

  std::vector<JacobianPass> jacobian_passes_;
  std::vector<HessianPass> hessian_passes_;

 private:
  friend Function cheapest_function(std::unique_ptr<const TracedBody> formula);

  std::unique_ptr<const FormulaSteps> steps_;
};

/// A function that evaluates the formula on dual numbers, or the derivatives from its recorded
/// steps where that takes fewer operations.
Function cheapest_function(std::unique_ptr<const TracedBody> formula);

}  // namespace saltus::detail

namespace saltus {

/// The argument z = (t | x | u | p) as the formula takes it.
template <class S, int nx, int nu, int np>
struct FormulaArguments {
  S t;           ///< time, s
  Vec<S, nx> x;  ///< states
  Vec<S, nu> u;  ///< inputs
  Vec<S, np> p;  ///< parameters

  /// entry(i) is entry i of z, of type S or convertible to it.
  template <class Entry>
  static FormulaArguments from(const Entry& entry) {
    FormulaArguments a;
    a.t = entry(0);
    for (int i = 0; i < nx; ++i) a.x.data()[i] = entry(1 + i);
    for (int i = 0; i < nu; ++i) a.u.data()[i] = entry(1 + nx + i);
    for (int i = 0; i < np; ++i) a.p.data()[i] = entry(1 + nx + nu + i);
    return a;
  }
  /// Arguments from numbers z, which get zero derivatives, or from scalars S.
  template <class Number>
  static FormulaArguments constant(const Number* z) {
    return from([z](int i) { return z[i]; });
  }
};

template <class F, class S, int nx>
concept FormulaOfState = requires(const F& f, const S& t, const Vec<S, nx>& x) { f(t, x); };
template <class F, class S, int nx, int nu>
concept FormulaOfInput =
    requires(const F& f, const S& t, const Vec<S, nx>& x, const Vec<S, nu>& u) { f(t, x, u); };
template <class F, class S, int nx, int nu, int np>
concept FormulaOfParameters = requires(const F& f, const S& t, const Vec<S, nx>& x,
                                       const Vec<S, nu>& u, const Vec<S, np>& p) { f(t, x, u, p); };
template <class F, class S, int nx, int nu, int np>
concept Formula = FormulaOfState<F, S, nx> || FormulaOfInput<F, S, nx, nu> ||
                  FormulaOfParameters<F, S, nx, nu, np>;

namespace detail {

template <class F, class S, int nx, int nu, int np>
  requires Formula<F, S, nx, nu, np>
decltype(auto) call(const F& formula, const FormulaArguments<S, nx, nu, np>& z) {
  if constexpr (FormulaOfParameters<F, S, nx, nu, np>) {
    return formula(z.t, z.x, z.u, z.p);
  } else if constexpr (FormulaOfInput<F, S, nx, nu>) {
    return formula(z.t, z.x, z.u);
  } else {
    return formula(z.t, z.x);
  }
}

template <class R>
concept EigenResult = std::derived_from<R, Eigen::EigenBase<R>>;

// True if the result owns its numbers, as a matrix or Vec<S, 3>::Zero() does.
template <class R>
struct OwnsItsNumbers : std::is_base_of<Eigen::PlainObjectBase<R>, R> {};
template <class Op, class Plain>
struct OwnsItsNumbers<Eigen::CwiseNullaryOp<Op, Plain>> : std::true_type {};

template <class R>
constexpr int rows_of_result() {
  if constexpr (EigenResult<R>) {
    static_assert(
        R::ColsAtCompileTime == 1 && R::RowsAtCompileTime != Eigen::Dynamic,
        "a formula must return a scalar or a column vector whose size is known at compile "
        "time, Vec<S, m>");
    return R::RowsAtCompileTime == Eigen::Dynamic ? 1 : R::RowsAtCompileTime;
  } else {
    return 1;
  }
}

template <class F, class S, int nx, int nu, int np>
using ResultOf = std::remove_cvref_t<decltype(call(
    std::declval<const F&>(), std::declval<const FormulaArguments<S, nx, nu, np>&>()))>;

}  // namespace detail

/// Number of outputs of a formula.
template <int nx, int nu, int np, class F>
inline constexpr int outputs_of =
    detail::rows_of_result<detail::ResultOf<F, Dual<double, 0>, nx, nu, np>>();

/// True if a formula returns this number of rows. Also true for a type that is not a formula, which
/// make_function() reports.
template <class F, int rows, int nx, int nu, int np>
concept ReturnsRows = !Formula<F, Dual<double, 0>, nx, nu, np> || outputs_of<nx, nu, np, F> == rows;

namespace detail {

/// Computes y = formula(z) for any scalar.
template <class F, class S, int nx, int nu, int np>
void evaluate(const F& formula, const FormulaArguments<S, nx, nu, np>& z, S* y) {
  using Result = ResultOf<F, S, nx, nu, np>;
  if constexpr (EigenResult<Result>) {
    static_assert(OwnsItsNumbers<Result>::value,
                  "a formula must not return an unevaluated Eigen expression, which refers to "
                  "variables that no longer exist: state the return type Vec<S, m> or end the "
                  "expression with .eval()");
    // Copies entry by entry: each further Eigen type adds compile time per formula and scalar.
    const Result result = call(formula, z);
    for (int r = 0; r < rows_of_result<Result>(); ++r) y[r] = S(result.coeff(r));
  } else {
    static_assert(std::convertible_to<Result, S>,
                  "a formula must return a scalar or a vector of the scalar type S it is called "
                  "with");
    *y = S(call(formula, z));
  }
}

inline namespace SALTUS_LANES_ABI {  // depends on the width of passes

template <int nx, int nu, int np, class F>
class FormulaBody final : public TracedBody {
  static constexpr int inputs_count = Arguments{nx, nu, np}.size();
  static constexpr int outputs_count = outputs_of<nx, nu, np, F>;
  // Short passes: inputs that can share a direction leave few directions, and a dual of one pack
  // stays in registers (design/decisions.md, "Width of dual numbers").
  static constexpr int jacobian_lanes = native_lanes;
  static constexpr int hessian_lanes = std::min(native_lanes, 4);
  using First = Dual<double, jacobian_lanes>;
  using Second = Dual<Dual<double, hessian_lanes>, 1>;
  template <class S>
  using Argument = FormulaArguments<S, nx, nu, np>;

 public:
  FormulaBody(F formula, const FormulaName& name)
      : TracedBody(inputs_count, outputs_count), formula_(std::move(formula)) {
    find_structure(name, {nx, nu, np}, jacobian_lanes, hessian_lanes);
  }

  void value(const double* z, double* y) const override {
    // Uses a Dual without directions instead of a double. Argument-dependent lookup then finds abs,
    // min and select, and never the integer abs of the C library.
    using S = Dual<double, 0>;
    Argument<S> argument = Argument<S>::constant(z);
    S result[outputs_count];
    evaluate(formula_, argument, result);
    for (int r = 0; r < outputs_count; ++r) y[r] = result[r].value;
  }

  void jacobian(const double* z, double* y, double* entries) const override {
    if (jacobian_passes_.empty()) return value(z, y);  // constant
    First result[outputs_count];
    for (const JacobianPass& pass : jacobian_passes_) {
      const double* tangents = pass.tangents.data();
      const auto seeded = [=](int i) {
        return First(z[i], First::Tangent::load(tangents + i * jacobian_lanes));
      };
      evaluate(formula_, Argument<First>::from(seeded), result);
      for (const Reading& r : pass.readings) entries[r.entry] = result[r.row].tangent[r.lane];
    }
    for (int r = 0; r < outputs_count; ++r) y[r] = result[r].value;
  }

  void hessian(const double* z, const double* weights, double* entries, Curvature) const override {
    if (hessian_passes_.empty()) return;  // affine
    using Inner = decltype(Second::value);
    Second result[outputs_count];
    for (const HessianPass& pass : hessian_passes_) {
      const double* tangents = pass.tangents.data();
      const double* outer = pass.outer_tangents.data();
      const auto seeded = [=](int i) {
        return Second(Inner(z[i], Inner::Tangent::load(tangents + i * hessian_lanes)),
                      {{Inner(outer[i])}});
      };
      evaluate(formula_, Argument<Second>::from(seeded), result);
      auto sum = weights[0] * result[0].tangent[0].tangent;
      for (int r = 1; r < outputs_count; ++r) sum += weights[r] * result[r].tangent[0].tangent;
      for (const Reading& r : pass.readings) entries[r.entry] = sum[r.lane];
    }
  }

 private:
  // Called at set-up only, so it need not be optimised.
  [[gnu::cold, gnu::noinline]] void trace(const Tracer* z, Tracer* y) const override {
    evaluate(formula_, Argument<Tracer>::constant(z), y);
  }

  F formula_;
};

}  // namespace SALTUS_LANES_ABI

}  // namespace detail

/// Erases a formula of nx states, nu inputs and np parameters. Each size may be 0. Evaluation does
/// not allocate. Both kinds of Curvature give the full Hessian: only compositions drop terms.
/// Throws DefinitionError with the name if the formula accesses an entry out of range or returns an
/// unwritten entry.
///
/// A Function of z = (t | x | u | p) is returned as it is, after its sizes are checked. Phases,
/// automata, jumps and plants therefore take a Function where they take a formula.
template <int nx, int nu, int np, class F>
Function make_function(F formula, const FormulaName& name = {}) {
  static_assert(nx >= 0 && nu >= 0 && np >= 0, "sizes cannot be negative");
  if constexpr (std::same_as<F, Function>) {
    return detail::checked_function(std::move(formula), {nx, nu, np}, name);
  } else if constexpr (Formula<F, Dual<double, 0>, nx, nu, np>) {
    return detail::cheapest_function(std::unique_ptr<const detail::TracedBody>(
        new detail::FormulaBody<nx, nu, np, F>(std::move(formula), name)));
  } else {
    static_assert(Formula<F, Dual<double, 0>, nx, nu, np>,
                  "a formula must be callable through a const operator() as f(t, x), f(t, x, u) or "
                  "f(t, x, u, p), with t a scalar S and x, u, p of type Vec<S, nx>, Vec<S, nu>, "
                  "Vec<S, np> of the declared sizes, for every scalar S; call functions of <cmath> "
                  "without std::, as in sin(x[0])");
    return {};
  }
}

}  // namespace saltus
