#include "saltus/model/make_function.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/error.hpp"

namespace saltus {
namespace {

std::string describe(const FormulaName& name) {
  std::string text = name.phase.empty() ? "" : fmt::format("phase '{}', ", name.phase);
  text += name.what.empty() ? "a formula" : name.what;
  if (!name.name.empty()) text += fmt::format(" '{}'", name.name);
  return text;
}

// "there are 2 states, x[0] to x[1]"
std::string describe_argument(char symbol, const char* what, int size) {
  if (size == 0) return fmt::format("there are no {}s", what);
  if (size == 1) return fmt::format("there is 1 {}, {}[0]", what, symbol);
  return fmt::format("there are {} {}s, {}[0] to {}[{}]", size, what, symbol, symbol, size - 1);
}

std::string describe(const detail::IndexError& e, const Arguments& sizes) {
  const long size = e.rows * e.cols;
  struct Argument {
    char symbol;
    const char* what;
    int first, size;
  };
  const Argument arguments[] = {{'x', "state", sizes.x(), sizes.nx},
                                {'u', "input", sizes.u(), sizes.nu},
                                {'p', "parameter", sizes.p(), sizes.np}};
  for (const Argument& a : arguments)
    if (e.cols == 1 && size > 0 && a.first == e.first_input && a.size == size)
      return fmt::format("it uses {}[{}], but {}", a.symbol, e.row,
                         describe_argument(a.symbol, a.what, a.size));
  if (size == 0) {
    std::string none;
    for (const Argument& a : arguments)
      if (a.size == 0) none += fmt::format("{}{}", none.empty() ? "" : " or ", a.symbol);
    return fmt::format("it uses entry {} of {}, which has none", e.row,
                       none.empty() ? "a vector" : none);
  }
  if (e.cols == 1)
    return fmt::format("it uses entry {} of a vector of {}, counted from 0", e.row, size);
  return fmt::format("it uses entry ({}, {}) of a {} x {} matrix, counted from 0", e.row, e.col,
                     e.rows, e.cols);
}

}  // namespace

detail::FormulaStructure detail::traced_structure(const FormulaName& name, const Arguments& sizes,
                                                  int outputs, const detail::TraceFormula& trace,
                                                  FormulaSteps& steps) {
  StepRecorder recorder;
  std::vector<Tracer> z, y(outputs);
  for (int i = 0; i < sizes.size(); ++i) z.push_back(Tracer::input(i));
  detail::was_written_beyond();  // reset
  try {
    trace(z.data(), y.data());
  } catch (const detail::IndexError& e) {
    throw DefinitionError(fmt::format("{}: {}", describe(name), describe(e, sizes)));
  }
  if (detail::was_written_beyond())
    throw DefinitionError(
        fmt::format("{}: it writes beyond the end of a vector through data()", describe(name)));
  for (int i = 0; i < outputs; ++i)
    if (!y[i].is_written())
      throw DefinitionError(
          fmt::format("{}: entry {} of its result is never written, or depends on a number that is "
                      "never written",
                      describe(name), i));
  steps = recorder.end(sizes.size(), y);
  return detail::structure_of(sizes.size(), y);
}

Function detail::checked_function(Function function, const Arguments& sizes,
                                  const FormulaName& name) {
  if (!function) throw DefinitionError(fmt::format("{}: the function is empty", describe(name)));
  const int n = function.inputs(), m = function.outputs();
  if (n != sizes.size())
    throw DefinitionError(
        fmt::format("{}: the function has {} inputs, but (t, x, u, p) has 1 + {} + {} + {} = {} "
                    "entries",
                    describe(name), n, sizes.nx, sizes.nu, sizes.np, sizes.size()));
  const SparsityPattern& jacobian = function.jacobian_pattern();
  if (jacobian.rows() != m || jacobian.cols() != n)
    throw DefinitionError(
        fmt::format("{}: the pattern of the function's Jacobian is {} x {}, but it has {} outputs "
                    "and {} inputs",
                    describe(name), jacobian.rows(), jacobian.cols(), m, n));
  const SparsityPattern& hessian = function.hessian_pattern();
  if (hessian.rows() != n || hessian.cols() != n)
    throw DefinitionError(
        fmt::format("{}: the pattern of the function's Hessian is {} x {}, but it has {} inputs",
                    describe(name), hessian.rows(), hessian.cols(), n));
  hessian.for_each([&](int row, int col, int) {
    if (col > row)
      throw DefinitionError(
          fmt::format("{}: the pattern of the function's Hessian has entry ({}, {}), but it must "
                      "hold the lower triangle",
                      describe(name), row, col));
  });
  return function;
}

}  // namespace saltus
