// Integrates modes with algebraic equations with z as unknowns. z is eliminated in guards, resets
// and sliding modes, which have no algebraic equations.
#include <algorithm>
#include <memory>
#include <vector>

#include "saltus/integrators/algebraic_field.hpp"
#include "saltus/integrators/hybrid_multistep.hpp"
#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/idas_memory.hpp"
#include "saltus/model/algebraic.hpp"

namespace saltus {
namespace {

// The equations of one mode: those of its problem over (x | z | q), or its field over (x | q).
struct ModeEquations {
  ModeEquations(const IntervalProblem& of_mode, const IdasOptions& options,
                const IntervalField& eliminated, int entries)
      : problem(of_mode),
        field(with_algebraic_states(problem)),
        memory(problem, options, problem.algebraic ? field : eliminated,
               std::max(entries, field.entries()), problem.algebraic.equations.get()) {
    memory.use(problem.algebraic ? field : eliminated);
  }
  IntervalProblem problem;
  IntervalField field;
  sundials::IdasMemory memory;
};

struct ModesOptions : IdasOptions {
  const HybridModes* modes = nullptr;
};

// Adapter for MultistepStepper with (x | q) instead of (x | z | q).
class ModesMemory {
 public:
  ModesMemory(const IntervalProblem& problem, const ModesOptions& options,
              const IntervalField& any_field, int entries)
      : nx_(any_field.states()),
        ny_(any_field.outputs()),
        state_(ny_),
        z_(any_field.arguments()),
        sensitivity_(any_field.directions(), std::vector<double>(ny_)) {
    for (int m = 0; m < options.modes->count(); ++m) {
      const bool declared = m < options.modes->declared();
      IntervalProblem of_mode = problem;
      of_mode.switching = {};
      of_mode.algebraic = {};
      if (declared) {
        const SwitchingSystem::Mode& mode = problem.switching.modes[m];
        of_mode.dynamics = mode.dynamics;
        if (mode.running_cost) of_mode.running_cost = mode.running_cost;
        of_mode.algebraic = dae_before_elimination(mode.dynamics);
      }
      fields_.push_back((*options.modes)[m].field.get());
      modes_.push_back(std::make_unique<ModeEquations>(of_mode, options, *fields_.back(), entries));
    }
    wide_.resize(ny_ + most_algebraic());
    w_.resize(
        IntervalArguments{nx_ + most_algebraic(), problem.coefficients(), problem.arguments.np}
            .size());
    use(*fields_.front());
  }

  void use(const IntervalField& field) {
    field_ = &field;
    mode_ = modes_[std::find(fields_.begin(), fields_.end(), &field) - fields_.begin()].get();
  }

  double* state() { return state_.data(); }
  double* sensitivity(int direction) { return sensitivity_[direction].data(); }
  int directions() const { return static_cast<int>(sensitivity_.size()); }

  int begin(double s, const double* w, bool sensitivities) {
    sundials::IdasMemory& memory = mode_->memory;
    if (const int nz = memory.first_cost() - nx_; nz > 0) {
      const IntervalArguments index{nx_, mode_->problem.coefficients(),
                                    mode_->problem.arguments.np};
      std::copy_n(w, nx_, w_.begin());
      std::fill_n(w_.begin() + nx_, nz, 0.0);  // z has no entries in w
      std::copy(w + nx_, w + index.size(), w_.begin() + nx_ + nz);
      mode_->field.load(w_.data());
    }
    widen(state_.data(), memory.state());
    if (sensitivities)
      for (int d = 0; d < directions(); ++d) widen(sensitivity(d), memory.sensitivity(d));
    return memory.begin(s, w, sensitivities);
  }
  int advance(int task, double& reached) {
    const int code = mode_->memory.advance(task, reached);
    narrow(mode_->memory.state(), state_.data());
    return code;
  }
  int interpolate(double s, double* y) {
    const int code = mode_->memory.interpolate(s, wide_.data());
    narrow(wide_.data(), y);
    return code;
  }
  int interpolate_sensitivity(double s) {
    const int code = mode_->memory.interpolate_sensitivity(s);
    for (int d = 0; d < directions(); ++d) narrow(mode_->memory.sensitivity(d), sensitivity(d));
    return code;
  }
  // (h f | h L) at (s, y) with z eliminated.
  bool evaluate(double s, const double* y, double* rates) {
    field_->argument(s, y, z_.data());
    field_->value(z_.data(), rates);
    for (int r = 0; r < ny_; ++r) rates[r] *= field_->length();
    return all_finite(rates, ny_);
  }

  static IntegrationStatus status_of(int code) { return sundials::status_of_ida(code); }
  static constexpr int one_step = sundials::IdasMemory::one_step;

 private:
  int most_algebraic() const {
    int most = 0;
    for (const auto& mode : modes_) most = std::max(most, mode->memory.first_cost() - nx_);
    return most;
  }
  void widen(const double* narrow, double* wide) const {
    std::copy_n(narrow, nx_, wide);
    std::copy_n(narrow + nx_, ny_ - nx_, wide + mode_->memory.first_cost());
  }
  void narrow(const double* wide, double* narrow) const {
    std::copy_n(wide, nx_, narrow);
    std::copy_n(wide + mode_->memory.first_cost(), ny_ - nx_, narrow + nx_);
  }

  int nx_, ny_;
  std::vector<const IntervalField*> fields_;  // per mode, with z eliminated
  std::vector<std::unique_ptr<ModeEquations>> modes_;
  const IntervalField* field_ = nullptr;
  ModeEquations* mode_ = nullptr;
  std::vector<double> state_, wide_, w_, z_;
  std::vector<std::vector<double>> sensitivity_;
};

}  // namespace

std::unique_ptr<Integrator> hybrid_idas(const IntervalProblem& problem,
                                        const IdasOptions& options) {
  return std::make_unique<HybridIntegrator>(
      problem, [&](const IntervalProblem& checked, const HybridModes& modes) {
        ModesOptions of_modes;
        static_cast<IdasOptions&>(of_modes) = options;
        of_modes.modes = &modes;
        return std::make_unique<MultistepStepper<ModesMemory>>(checked, of_modes, *modes[0].field,
                                                               modes.largest_entry_count());
      });
}

}  // namespace saltus
