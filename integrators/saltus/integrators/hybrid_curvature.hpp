// Second derivatives of an interval through its events, for one-step schemes.
//
// Everything between start and end is a chain of equations: stages and ends of steps, whose lengths
// change where an event ends or begins them, g = 0 at events, resets. As in integrators.md the
// Hessian of weights' end is the second differential of these equations alone, each weighted with
// its multiplier, along the first-order solution; framework/design/events.md has the formulas.
#pragma once

#include <deque>
#include <vector>

#include "saltus/integrators/hybrid_modes.hpp"
#include "saltus/integrators/implicit_stages.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// What HybridIntegrator leaves of a flow, or of the event behind it.
struct HybridPiece {
  int mode = 0;
  int guard = -1;                   ///< of an event; -1: a flow
  bool located = false;             ///< the event's instant is that of g = 0, not the start
  double begin = 0.0, end = 0.0;    ///< s; of an event both are its instant
  double rate = 0.0;                ///< dg/ds along the motion
  VectorXd state;                   ///< (x | q) at `begin`; of an event before it
  RowMajorMatrix total;             ///< its derivative, the motion of the instant included
  VectorXd begin_moves, end_moves;  ///< d begin, d end
  VectorXd slope;                   ///< dy/ds before an event
};

/// The pieces of one interval in their order. Keeps its memory.
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

  /// sum = the Hessian of weights' (x | q) at the end, directions x directions. Allocates where an
  /// interval has more steps than any before.
  IntegrationStatus hessian(const HybridTape& tape, const VectorXd& weights, Curvature curvature,
                            RowMajorMatrix& sum);

 private:
  struct Step {
    Step(int stages, const IntervalField& field, int entries);
    const IntervalField* field = nullptr;
    double begin = 0.0, length = 0.0;
    VectorXd begin_moves, length_moves;
    ImplicitStep at;
    std::vector<RowMajorMatrix> dz, rates;  // of the stages: dz, dF
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
  std::vector<int> first_step_;  // of the pieces
  VectorXd y_, lambda_, multipliers_, explicit_, along_, gradient_, moves_, scaled_, z_;
  double start_multiplier_ = 0.0;  // d (weights' end) / d begin of the flow last swept
  std::vector<double> jacobian_, hessian_, value_;
  RowMajorMatrix total_, right_, direct_, dz_;
};

}  // namespace saltus
