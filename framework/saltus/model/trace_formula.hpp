// Traces a formula once where it is defined, to find its structure or an out-of-range access.
#pragma once

#include <functional>
#include <string_view>

#include "saltus/autodiff/tracer.hpp"
#include "saltus/model/arguments.hpp"
#include "saltus/model/structure.hpp"

namespace saltus {

/// Name of a formula in messages: "phase 'motion', term 'lane'".
struct FormulaName {
  std::string_view phase = {};  ///< empty: no phase
  std::string_view what = {};   ///< kind: "term", "the dynamics"
  std::string_view name = {};   ///< name of the formula, if any
};

/// Computes y = formula(z) with tracers, one entry of z per input.
using TraceFormula = std::function<void(const Tracer* z, Tracer* y)>;

/// Throws DefinitionError with the formula and the entry if the formula accesses an entry out of
/// range or returns an unwritten entry.
FormulaStructure traced_structure(const FormulaName& name, const Arguments& sizes, int outputs,
                                  const TraceFormula& trace);

}  // namespace saltus
