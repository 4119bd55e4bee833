#include "saltus/integrators/cvodes_memory.hpp"
#include "saltus/integrators/hybrid_multistep.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"

namespace saltus {

std::unique_ptr<Integrator> hybrid_cvodes(const IntervalProblem& problem,
                                          const CvodesOptions& options) {
  return std::make_unique<HybridIntegrator>(
      problem, [&](const IntervalProblem& checked, const HybridModes& modes) {
        return std::make_unique<MultistepStepper<sundials::CvodesMemory>>(
            checked, options, *modes[0].field, modes.largest_entry_count());
      });
}

}  // namespace saltus
