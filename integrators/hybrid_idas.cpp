// In intervals with events z is eliminated from every field and guard: a mode that slides has no
// equations of its own.
#include "saltus/integrators/hybrid_multistep.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/idas_memory.hpp"

namespace saltus {

std::unique_ptr<Integrator> hybrid_idas(const IntervalProblem& problem,
                                        const IdasOptions& options) {
  return std::make_unique<HybridIntegrator>(
      problem, [&](const IntervalProblem& checked, const HybridModes& modes) {
        return std::make_unique<MultistepStepper<sundials::IdasMemory>>(
            checked, options, *modes[0].field, modes.largest_entry_count());
      });
}

}  // namespace saltus
