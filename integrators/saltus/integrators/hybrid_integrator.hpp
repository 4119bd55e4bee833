// Integration of an interval with state-triggered events and its derivatives through them.
//
// Consider an event at s* of guard g. A is the derivative of y(s) at fixed s, and B = dy/ds before
// the event. Then
//   ds* = -(g_x A + g_w) / (g_x B + g_s),   dy- = A + B ds*,   dx+ = R_x dx- + R_w + R_s ds*,
// The flow continues from the moving instant: A+ = dy+ - F+ ds*. This is the saltation matrix in
// chain-rule form. Start, length and inputs act through g_w, R_w and the derivatives in s.
// framework/design/events.md has the derivation and all conventions.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "saltus/integrators/hybrid_curvature.hpp"
#include "saltus/integrators/hybrid_locator.hpp"
#include "saltus/integrators/hybrid_modes.hpp"
#include "saltus/integrators/hybrid_stepper.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// Creates the stepper for a problem and its modes.
using MakeStepper =
    std::function<std::unique_ptr<FlowStepper>(const IntervalProblem&, const HybridModes&)>;

/// Maximum number of events in one interval. More count as accumulation.
inline constexpr int max_events = 1000;

class HybridIntegrator final : public EventIntegrator {
 public:
  /// With a `scheme`, which must be that of the steppers, second derivatives are available, except
  /// where the trajectory slides.
  HybridIntegrator(const IntervalProblem& problem, const MakeStepper& make_stepper,
                   const std::optional<OneStepScheme>& scheme = {});

  IntegrationStatus value(const double* w, double* end) override;
  IntegrationStatus jacobian(const double* w, double* end, MatrixXd& derivative) override;
  bool has_hessian() const override { return curvature_.has_value(); }
  IntegrationStatus hessian(const double* w, const double* weights, MatrixXd& hessian,
                            Curvature curvature) override;
  IntegrationStatus derivatives(const double* w, const double* weights, double* end,
                                MatrixXd& derivative, MatrixXd& hessian,
                                Curvature curvature) override;
  std::string failure() const override;

  void record(std::vector<HybridEvent>* events) override { recorded_ = events; }
  void start_in(int mode) override { given_mode_ = mode; }
  int end_mode() const override { return mode_; }
  const std::string& mode_name(int mode) const override { return modes_[mode].name; }

 private:
  // State at the current instant s_: y_. With sensitivities also its total derivative total_ and
  // the derivative moving_ of s_.
  IntegrationStatus run(const double* w, bool sensitivities);
  void reset_to_start(const double* w);  // resets to the start of the interval
  IntegrationStatus choose_mode();
  IntegrationStatus fire_overdue_event();
  bool is_on_surface(int sliding);
  IntegrationStatus judge_start(int mode);
  IntegrationStatus settle(bool after_jump, int partner, bool left_sliding, int fired);
  IntegrationStatus flow(bool& finished);
  IntegrationStatus fire(int guard);
  IntegrationStatus pass(int guard);
  IntegrationStatus enter_sliding(int guard);
  void hold_instant();
  void remember();
  IntegrationStatus record_run(const double* w);
  IntegrationStatus second_order(const double* weights, MatrixXd& hessian, Curvature curvature);
  void record_flow();
  void record_event(int guard, bool located, double rate);
  bool leaves_guard(int mode, int guard);
  IntegrationStatus project();
  IntegrationStatus watch_accumulation(const OutgoingGuard& guard);
  IntegrationStatus fail(IntegrationStatus status, int guard = -1);
  double time_at(double s) const { return t0_ + s * h_; }
  int states() const { return problem().arguments.nx; }

  struct Failure {
    IntegrationStatus status = IntegrationStatus::success;
    double time = 0.0;
    int mode = -1, guard = -1;
  };
  // Firing times of one guard, to detect accumulation.
  struct Repetition {
    double last = -1.0, gap = -1.0, ratio = -1.0;
    int regular = 0;
  };

  HybridModes modes_;
  GuardEvaluator guards_;
  std::unique_ptr<FlowStepper> stepper_;
  EventLocator locator_;
  std::vector<GuardSide> sides_;
  std::vector<GuardSample> samples_;
  std::vector<HybridEvent>* recorded_ = nullptr;
  HybridTape tape_;
  bool taping_ = false, remembered_ = false;
  std::optional<HybridCurvature> curvature_;
  int given_mode_ = -1;

  double t0_ = 0.0, h_ = 0.0, s_ = 0.0;
  int mode_ = 0, events_ = 0;
  bool sensitivities_ = false;
  Failure failure_;
  std::vector<std::vector<Repetition>> repetitions_;  // per mode and guard
  std::vector<double> y_, ahead_, slope_, z_, phi_, entries_, reset_slope_, guard_slope_;
  std::vector<double> moving_;
  RowMajorMatrix total_, held_, guard_row_, reset_rows_, second_;
  VectorXd weights_;
};

}  // namespace saltus
