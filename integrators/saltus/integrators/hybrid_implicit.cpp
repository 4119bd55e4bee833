// The flow of one mode by an implicit Runge-Kutta scheme on the fixed grid of the interval.
//
// Dense output as in restarted_stepper.hpp: y(s) = Phi(y_n, s_n, L), L = s - s_n, stable for every
// step length. With e_i = s_n + c_i L, at fixed s, dL = -ds_n, de_i = (1 - c_i) ds_n and M_ij = I
// delta_ij - L a_ij F_Xj:
//   sum_j M_ij dX_j = dx_n + sum_j a_ij (L (F_theta,j dtheta + F_s,j de_j) + F_j dL),
// and the slope dPhi/dL has sum_j M_ij X'_j = sum_j a_ij (F_j + L c_j F_s,j).
#include <algorithm>
#include <utility>
#include <vector>

#include "saltus/integrators/hybrid_schemes.hpp"
#include "saltus/integrators/implicit_stages.hpp"
#include "saltus/integrators/restarted_stepper.hpp"

namespace saltus {
namespace {

class ImplicitStepper final : public RestartedStepper {
 public:
  ImplicitStepper(const IntervalProblem& problem, ButcherTableau tableau, int steps,
                  const IntervalField& any_field, int entries)
      : RestartedStepper(steps, any_field.states(), any_field.outputs(), any_field.directions()),
        solver_(std::move(tableau), problem.nominal_state, nx_, ny_),
        step_(solver_.count(), any_field, entries),
        explicit_(ny_),
        right_(solver_.count() * nx_, nd_ + 1),
        zero_(RowMajorMatrix::Zero(nx_, nd_)),
        rates_(solver_.count(), RowMajorMatrix(ny_, nd_ + 1)),
        rate_sensitivity_(ny_, nd_) {}

 private:
  IntegrationStatus advance(double s, double* y) override {
    const double length = s - start_;
    std::copy(y_.begin(), y_.end(), y);
    if (length == 0.0) return IntegrationStatus::success;
    const IntegrationStatus status = solver_.find(*field_, start_, length, y_.data(), step_);
    if (status != IntegrationStatus::success) return status;
    for (int i = 0; i < solver_.count(); ++i)
      for (int r = 0; r < nx_; ++r)
        y[r] += solver_.end_weights()[i] * (solver_.state(i)[r] - y_[r]);
    if (ny_ == nx_) return IntegrationStatus::success;
    solver_.evaluate_rates(*field_, start_, length, step_);
    for (int i = 0; i < solver_.count(); ++i) {
      const double b = length * field_->length() * solver_.tableau().b[i];
      for (int r = nx_; r < ny_; ++r) y[r] += b * step_.stages[i].phi[r];
    }
    return IntegrationStatus::success;
  }

  // Rates of a stage through arguments other than its state, in all directions and, in the last
  // column, along L.
  void find_direct_rates(int j, double length) {
    const ImplicitStep::Stage& stage = step_.stages[j];
    const double c = solver_.tableau().c[j];
    field_->rate_sensitivity(start_ + c * length, stage.phi.data(), stage.entries.data(), zero_,
                             rate_sensitivity_.data());
    field_->explicit_rate(stage.entries.data(), explicit_.data());
    for (int r = 0; r < ny_; ++r) {
      const double rate = field_->length() * stage.phi[r];
      for (int d = 0; d < nd_; ++d)
        rates_[j](r, d) =
            length * (rate_sensitivity_(r, d) + explicit_[r] * (1.0 - c) * start_slope_[d]) -
            rate * start_slope_[d];
      rates_[j](r, nd_) = rate + length * c * explicit_[r];
    }
  }

  IntegrationStatus propagate(double s, RowMajorMatrix& result, double* slope) override {
    const double length = s - start_;
    const ButcherTableau& tableau = solver_.tableau();
    IntegrationStatus status = solver_.find(*field_, start_, length, y_.data(), step_);
    if (status == IntegrationStatus::success)
      status = solver_.evaluate_slopes(*field_, start_, length, step_);
    if (status != IntegrationStatus::success) return status;
    for (int j = 0; j < solver_.count(); ++j) find_direct_rates(j, length);
    for (int i = 0; i < solver_.count(); ++i)
      for (int r = 0; r < nx_; ++r) {
        auto row = right_.row(i * nx_ + r);
        row.head(nd_) = sensitivity_.row(r);
        row[nd_] = 0.0;
        for (int j = 0; j < solver_.count(); ++j) row += tableau.a(i, j) * rates_[j].row(r);
      }
    step_.matrix.solve(right_.data(), nd_ + 1);

    result = sensitivity_;
    if (slope != nullptr) std::fill_n(slope, ny_, 0.0);
    for (int i = 0; i < solver_.count(); ++i) {
      const double d = solver_.end_weights()[i];
      for (int r = 0; r < nx_; ++r) {
        const auto row = right_.row(i * nx_ + r);
        result.row(r) += d * (row.head(nd_) - sensitivity_.row(r));
        if (slope != nullptr) slope[r] += d * row[nd_];
      }
    }
    if (ny_ > nx_) add_costs(length, result, slope);
    return all_finite(result.data(), static_cast<int>(result.size()))
               ? IntegrationStatus::success
               : IntegrationStatus::not_finite;
  }

  // dq = sum_i b_i (L L_x dX_i + direct terms).
  void add_costs(double length, RowMajorMatrix& result, double* slope) {
    for (int i = 0; i < solver_.count(); ++i) {
      const ImplicitStep::Stage& stage = step_.stages[i];
      const double b = solver_.tableau().b[i];
      for (int r = nx_; r < ny_; ++r) {
        result.row(r) += b * rates_[i].row(r).head(nd_);
        if (slope != nullptr) slope[r] += b * rates_[i](r, nd_);
      }
      field_->for_each_state_entry([&](int r, int x, int e) {
        if (r < nx_) return;
        const double weight = b * length * field_->length() * stage.entries[e];
        const auto row = right_.row(i * nx_ + x);
        result.row(r) += weight * row.head(nd_);
        if (slope != nullptr) slope[r] += weight * row[nd_];
      });
    }
  }

  StageSolver solver_;
  ImplicitStep step_;
  std::vector<double> explicit_;
  RowMajorMatrix right_;  // stages stacked vertically; the last column is along L
  RowMajorMatrix zero_;
  std::vector<RowMajorMatrix> rates_;
  RowMajorMatrix rate_sensitivity_;
};

}  // namespace

std::unique_ptr<Integrator> hybrid_implicit(const IntervalProblem& problem,
                                            const ButcherTableau& tableau, int steps) {
  return std::make_unique<HybridIntegrator>(
      problem,
      [&](const IntervalProblem& checked, const HybridModes& modes) {
        return std::make_unique<ImplicitStepper>(checked, tableau, steps, *modes[0].field,
                                                 modes.largest_entry_count());
      },
      OneStepScheme{tableau, steps});
}

}  // namespace saltus
