// A formula is traced once, where it is defined: its structure, or a sentence on what it does
// beyond the vectors that it has.
#pragma once

#include <functional>
#include <string_view>

#include "saltus/autodiff/tracer.hpp"
#include "saltus/model/arguments.hpp"
#include "saltus/model/structure.hpp"

namespace saltus {

/// What a formula is called in messages: "phase 'motion', term 'lane'".
struct FormulaName {
  std::string_view phase = {};  ///< empty: of none
  std::string_view what = {};   ///< "term", "the dynamics"
  std::string_view name = {};   ///< of it, if it has one
};

/// y = formula(z), z an entry for each of its inputs.
using TraceFormula = std::function<void(const Tracer* z, Tracer* y)>;

/// Throws DefinitionError that names the formula and the entry, when it uses one that a vector does
/// not have or returns one that was never written.
FormulaStructure traced_structure(const FormulaName& name, const Arguments& sizes, int outputs,
                                  const TraceFormula& trace);

}  // namespace saltus
