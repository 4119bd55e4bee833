#include "saltus/mpc/real_time_iteration.hpp"

#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/solver/presolve.hpp"
#include "saltus/solver/solve_in_scale.hpp"
#include "saltus/transcription/quantities.hpp"

namespace saltus {
namespace {

Quantities quantities_of(const NonlinearProgram& program) {
  const auto* shooting = dynamic_cast<const ShootingProgram*>(&program);
  return shooting != nullptr ? undeclared_quantities(*shooting) : Quantities{};
}

class FullSolve final : public RealTimeSolver {
 public:
  FullSolve(std::unique_ptr<Solver> solver, bool use_multipliers)
      : solver_(std::move(solver)), use_multipliers_(use_multipliers) {}

  void prepare(NonlinearProgram&, const NlpPoint&) noexcept override {}

  RealTimeSolver::Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                                  WallClock::time_point deadline) noexcept override try {
    solver_->set_deadline(deadline);
    const Quantities quantities = quantities_of(program);
    ScaledResult r = solve_presolved(*solver_, program, point, [&](NonlinearProgram& reduced) {
      return solve_scaled_tick(*solver_, reduced, point, warm && use_multipliers_, quantities);
    });
    // A result that meets the tolerance only in the units of the program is not optimal.
    if (r.is_doubtful) r.nlp.status = SolveStatus::feasible;
    point = std::move(r.nlp.point);
    return {r.nlp.status, r.nlp.iterations, r.nlp.objective, r.in_scale.scaled(),
            r.in_scale.feasibility};
  } catch (const DefinitionError&) {
    return {};     // an invalid problem
  } catch (...) {  // exception of a formula
    RealTimeSolver::Result failed;
    failed.status = SolveStatus::evaluation_failed;
    return failed;
  }

  std::string name() const override { return solver_->name(); }

 private:
  std::unique_ptr<Solver> solver_;
  bool use_multipliers_;
};

}  // namespace

std::unique_ptr<RealTimeSolver> make_real_time_solver(std::unique_ptr<Solver> solver,
                                                      bool use_multipliers) {
  return std::make_unique<FullSolve>(std::move(solver), use_multipliers);
}

}  // namespace saltus
