#include "saltus/mpc/real_time_solver.hpp"

#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

class FullSolve final : public RealTimeSolver {
 public:
  FullSolve(std::unique_ptr<Solver> solver, bool use_multipliers)
      : solver_(std::move(solver)), use_multipliers_(use_multipliers) {}

  void prepare(NonlinearProgram&, const NlpPoint&) noexcept override {}

  TickResult feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                      WallClock::time_point deadline) noexcept override try {
    solver_->set_deadline(deadline);
    NlpResult r = solver_->solve(program, point, warm && use_multipliers_);
    point = std::move(r.point);
    return {r.status, r.iterations, r.objective, r.kkt.scaled(), r.kkt.feasibility};
  } catch (const DefinitionError&) {
    return {};     // an invalid problem
  } catch (...) {  // a formula
    TickResult failed;
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
