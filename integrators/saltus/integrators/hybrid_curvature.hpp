// Second derivatives of an interval with events, for one-step schemes.
//
// The map from start to end is a chain of equations: stages and ends of steps, g = 0 at events, and
// resets. Step lengths vary where a step begins or ends at an event. The Hessian of weights' end is
// the second differential of these equations, each weighted with its multiplier, along the
// first-order solution (integrators.md). framework/design/events.md has the formulas.
#pragma once

#include <deque>
#include <vector>

#include "saltus/integrators/hybrid_modes.hpp"
#include "saltus/integrators/implicit_stages.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// A flow of a HybridIntegrator, or the event after it.
struct HybridPiece {
  int mode = 0;
  int guard = -1;        ///< guard of an event; -1: a flow
  bool located = false;  ///< the instant of the event is defined by g = 0, not by the start
  double begin = 0.0, end = 0.0;    ///< s; equal for an event
  double rate = 0.0;                ///< dg/ds along the flow
  VectorXd state;                   ///< (x | q) at `begin`; for an event before its jump
  RowMajorMatrix total;             ///< derivative of `state`, including motion of the instant
  VectorXd begin_moves, end_moves;  ///< d begin, d end
  VectorXd slope;                   ///< dy/ds before an event
};

/// The pieces of one interval in order. Reuses its memory.
class HybridTape {
 public:
  void clear() { count_ = 0; }
  HybridPiece& add() {
    if (count_ == static_cast<int>(pieces_.size())) pieces_.emplace_back();
    return pieces_[count_++];
  }
  HybridPiece& back() { return pieces_[count_ - 1]; }
  int count() const { return count_; }
  const HybridPiece& operator[](int i) const { return pieces_[i]; }

 private:
  std::deque<HybridPiece> pieces_;
  int count_ = 0;
};

/// A scheme on a grid of equal steps.
struct OneStepScheme {
  ButcherTableau tableau;
  int steps = 1;
};

class HybridCurvature {
 public:
  HybridCurvature(const IntervalProblem& problem, const HybridModes& modes, OneStepScheme scheme);

  /// sum = Hessian of weights' (x | q) at the end, directions x directions. Allocates only if an
  /// interval has more steps than all previous ones.
  IntegrationStatus hessian(const HybridTape& tape, const VectorXd& weights, Curvature curvature,
                            RowMajorMatrix& sum);

 private:
  struct Step {
    Step(int stages, const IntervalField& field, int entries);
    const IntervalField* field = nullptr;
    double begin = 0.0, length = 0.0;
    VectorXd begin_moves, length_moves;
    ImplicitStep at;
    std::vector<RowMajorMatrix> dz, rates;  // per stage: dz, dF
  };

  IntegrationStatus find_steps(const HybridPiece& flow);
  IntegrationStatus differentiate(Step& step);
  void sweep_back(Step& step, Curvature curvature, RowMajorMatrix& sum);
  void add_event(const HybridPiece& event, Curvature curvature, RowMajorMatrix& sum);
  void add_second(const Function& function, const double* weight, const HybridPiece& event,
                  RowMajorMatrix& sum);

  const HybridModes& modes_;
  int steps_, nx_, ny_, nd_, entries_;
  StageSolver solver_;
  std::deque<Step> pool_;
  int used_ = 0;
  std::vector<int> first_step_;  // index of the first step of each piece
  VectorXd y_, lambda_, multipliers_, explicit_, along_, gradient_, moves_, scaled_, z_;
  double start_multiplier_ = 0.0;  // d (weights' end) / d begin of the last swept flow
  std::vector<double> jacobian_, hessian_, value_;
  RowMajorMatrix total_, right_, direct_, dz_;
};

}  // namespace saltus
