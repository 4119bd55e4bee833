// The flow of one mode by a multistep method of SUNDIALS, step by step, with the method's
// interpolant inside a step.
//
// The root finding of the libraries is not used: it detects only guards that differ in sign between
// the ends of a step. It misses a pair of crossings inside and a root exactly at the stop time.
// EventLocator searches the same interpolants instead.
#pragma once

#include <algorithm>
#include <vector>

#include "saltus/integrators/hybrid_stepper.hpp"
#include "saltus/integrators/interval_field.hpp"

namespace saltus {

// Fraction of the interval. The libraries refuse to start this close to the end. One Euler step
// replaces them, with an error of the order of the square of this fraction.
inline constexpr double too_close = 1e-12;

/// Memory is CvodesMemory or IdasMemory.
template <class Memory>
class MultistepStepper final : public FlowStepper {
 public:
  template <class Options>
  MultistepStepper(const IntervalProblem& problem, const Options& options,
                   const IntervalField& any_field, int entries)
      : memory_(problem, options, any_field, entries),
        max_steps_(options.max_steps),
        ny_(any_field.outputs()),
        w_(IntervalArguments{problem.arguments.nx, problem.coefficients(), problem.arguments.np}
               .size()),
        y_(ny_),
        rates_(ny_) {}

  void load(const double* w) override {
    std::copy_n(w, w_.size(), w_.begin());
    steps_ = 0;
  }

  IntegrationStatus begin(const IntervalField& field, double s, const double* y,
                          const RowMajorMatrix* sensitivity, const double* start_slope) override {
    memory_.use(field);
    start_ = reached_ = s;
    stepped_ = false;
    std::copy_n(y, ny_, y_.begin());
    std::copy_n(y, ny_, memory_.state());
    if (!memory_.evaluate(s, y, rates_.data())) return IntegrationStatus::not_finite;
    if (sensitivity != nullptr)
      for (int d = 0; d < memory_.directions(); ++d)
        for (int r = 0; r < ny_; ++r)
          memory_.sensitivity(d)[r] = (*sensitivity)(r, d) - rates_[r] * start_slope[d];
    if (1.0 - s < too_close) return IntegrationStatus::success;
    return Memory::status_of(memory_.begin(s, w_.data(), sensitivity != nullptr));
  }

  IntegrationStatus step() override {
    if (++steps_ > max_steps_) return IntegrationStatus::too_many_steps;
    start_ = reached_;
    if (!stepped_ && 1.0 - start_ < too_close) {
      reached_ = 1.0;
      return IntegrationStatus::success;
    }
    stepped_ = true;
    return Memory::status_of(memory_.advance(Memory::one_step, reached_));
  }

  double step_start() const override { return start_; }
  double step_end() const override { return reached_; }

  void state_at(double s, double* y) override {
    if (!stepped_) {
      for (int r = 0; r < ny_; ++r) y[r] = y_[r] + (s - start_) * rates_[r];
    } else if (s == reached_) {
      std::copy_n(memory_.state(), ny_, y);
    } else {
      memory_.interpolate(s, y);  // fails only outside the step
    }
  }

  IntegrationStatus sensitivity_at(double s, RowMajorMatrix& sensitivity, double* slope) override {
    state_at(s, y_.data());
    if (!memory_.evaluate(s, y_.data(), slope)) return IntegrationStatus::not_finite;
    if (stepped_) {
      const int code = memory_.interpolate_sensitivity(s);
      if (code < 0) return Memory::status_of(code);
    }
    for (int d = 0; d < memory_.directions(); ++d)
      for (int r = 0; r < ny_; ++r) sensitivity(r, d) = memory_.sensitivity(d)[r];
    return all_finite(sensitivity.data(), static_cast<int>(sensitivity.size()))
               ? IntegrationStatus::success
               : IntegrationStatus::not_finite;
  }

  int parts_per_step() const override { return 2; }
  bool restarts_freely() const override { return false; }

 private:
  Memory memory_;
  long max_steps_, steps_ = 0;
  int ny_;
  double start_ = 0.0, reached_ = 0.0;  // ends of the last step
  bool stepped_ = false;
  std::vector<double> w_, y_, rates_;
};

}  // namespace saltus
