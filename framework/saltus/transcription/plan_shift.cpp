#include "saltus/transcription/plan_shift.hpp"

#include <algorithm>
#include <cmath>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

namespace {

// True for the same variables in the same units, no jump, and a border that moves with the horizon.
bool is_continuation(const OptimalControlProblem& problem, int next) {
  const PhaseDefinition& a = problem.phases()[next - 1];
  const PhaseDefinition& b = problem.phases()[next];
  return a.sizes.nx == b.sizes.nx && a.sizes.nu == b.sizes.nu && !problem.jumps()[next].map &&
         !a.has_free_duration() && !b.has_free_duration() && a.input_shape() == b.input_shape() &&
         a.nominal_state == b.nominal_state && a.nominal_input == b.nominal_input;
}

}  // namespace

PlanShift::PlanShift(const ShootingProgram& program) {
  const Grid& grid = program.grid();
  for (int j = 0; j < grid.phases(); ++j) {
    first_instance_.push_back(j == 0 ? 0 : first_instance_.back() + grid.intervals(j - 1));
    continues_after_.push_back(j + 1 < grid.phases() && is_continuation(program.problem(), j + 1));
    old_.emplace_back(grid.intervals(j));
  }
  new_ = old_;
  const std::vector<RowInstance>& instances = program.row_instances();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const RowInstance& s = instances[i];
    const bool by_node = s.block.point.interval < 0;
    const Term& term = program.problem().phases()[s.phase].terms[s.term];
    if (term.domain != Term::Domain::running) continue;  // at an end of the phase: keeps its node
    const auto same = [&](const Family& f) {
      const RowInstance& first = instances[f.instances.front()];
      return first.phase == s.phase && first.term == s.term &&
             first.block.point.at_end == s.block.point.at_end;
    };
    auto family = std::find_if(families_.begin(), families_.end(), same);
    if (family == families_.end()) family = families_.insert(family, Family{s.phase, by_node, {}});
    family->instances.push_back(static_cast<int>(i));
  }
}

void PlanShift::fill_times(const ShootingProgram& program, const VectorXd& w,
                           std::vector<std::vector<Interval>>& times) {
  const Grid& grid = program.grid();
  for (int j = 0; j < grid.phases(); ++j) {
    const double start = program.start_of(j, &w), T = program.duration_of(j, &w);
    for (int k = 0; k < grid.intervals(j); ++k) {
      const Grid::Interval& interval = grid.interval(j, k);
      times[j][k] = {start + interval.offset(T), interval.is_empty() ? 0.0 : interval.length(T)};
    }
  }
}

void PlanShift::remember(const ShootingProgram& program, const VectorXd& w) {
  fill_times(program, w, old_);
  bounds_ = program.bounds_revision();
}

bool PlanShift::is_same_horizon(const ShootingProgram& program, const VectorXd& w) {
  if (bounds_ != program.bounds_revision()) return false;
  fill_times(program, w, new_);
  const double later = new_.front().front().start - old_.front().front().start;
  for (std::size_t j = 0; j < old_.size(); ++j)
    for (std::size_t k = 0; k < old_[j].size(); ++k)
      if (std::abs(new_[j][k].start - old_[j][k].start - later) > same_instant ||
          std::abs(new_[j][k].length - old_[j][k].length) > same_instant)
        return false;
  return true;
}

// Looks up t in the phase, or in the phase that covered this time before.
PlanShift::Spot PlanShift::find_across(int phase, double t, bool from_left) const {
  const double rounding = 1e-9;  // s, as below
  while (continues_after_[phase] && t > old_[phase].back().end() + rounding) ++phase;
  while (phase > 0 && continues_after_[phase - 1] && t < old_[phase].front().start - rounding)
    --phase;
  return find(phase, t, from_left);
}

// At a node, finds the interval that starts there, or with `from_left` the one that ends there.
PlanShift::Spot PlanShift::find(int phase, double t, bool from_left) const {
  const std::vector<Interval>& intervals = old_[phase];
  const double rounding = 1e-9;  // s; far below the distance of two nodes
  Spot spot{phase, -1, 0.0};
  for (int k = 0; k < static_cast<int>(intervals.size()); ++k) {
    if (intervals[k].length == 0.0) continue;
    const bool begun =
        from_left ? intervals[k].start < t - rounding : intervals[k].start <= t + rounding;
    if (spot.interval >= 0 && !begun) break;
    spot.interval = k;
  }
  if (spot.interval < 0) return {phase, 0, 0.0};
  const Interval& i = intervals[spot.interval];
  spot.fraction = std::clamp((t - i.start) / i.length, 0.0, 1.0);
  return spot;
}

// Of several nodes at one instant, finds the last one, which counts.
int PlanShift::nearest_node(int phase, double t) const {
  const Spot spot = find(phase, t, false);
  const std::vector<Interval>& intervals = old_[phase];
  if (spot.fraction < 0.5) return spot.interval;
  int node = spot.interval + 1;
  while (node < static_cast<int>(intervals.size()) && intervals[node].length == 0.0) ++node;
  return node;
}

void PlanShift::apply(const ShootingProgram& program, const PrimalDualPoint& plan,
                      PrimalDualPoint& guess) {
  guess.w = plan.w;
  guess.lambda = plan.lambda;
  guess.z = plan.z;
  const bool dual = plan.lambda.size() == program.rows() && plan.z.size() == program.variables();
  const Grid& grid = program.grid();
  const Layout& layout = program.layout();

  // Free phases keep the end times of the plan.
  double start = program.start_of(0, &plan.w);
  for (int j = 0; j < grid.phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    double T = grid.reference_duration(j);
    if (layout.duration(j) >= 0) {
      const Bounds& bounds = program.data().duration_bounds[j];
      T = std::clamp(old_[j].back().end() - start, bounds.lower, bounds.upper);
      guess.w[layout.duration(j)] = T / phase.nominal_duration;
    }
    start += T;
  }
  fill_times(program, guess.w, new_);

  for (const IntervalInstance& instance : program.interval_instances()) {
    const int j = instance.phase, k = instance.interval;
    const PhaseDefinition& phase = program.problem().phases()[j];
    const int nx = phase.sizes.nx;
    const Interval& now = new_[j][k];
    const auto interpolate_state = [&](int node, const Spot& spot) {
      const int first = layout.state(spot.phase, spot.interval);
      const int last = layout.state(spot.phase, spot.interval + 1);
      const int to = layout.state(j, node), near = spot.fraction < 0.5 ? first : last;
      for (int i = 0; i < nx; ++i) {
        guess.w[to + i] =
            (1.0 - spot.fraction) * plan.w[first + i] + spot.fraction * plan.w[last + i];
        if (dual) guess.z[to + i] = plan.z[near + i];
      }
    };
    interpolate_state(k, find_across(j, now.start, false));
    const Spot end = find_across(j, now.end(), true);
    if (k + 1 == grid.intervals(j)) interpolate_state(k + 1, end);

    const Spot middle = find_across(j, now.start + 0.5 * now.length, false);
    const int nc = (phase.input_shape() == InputShape::linear ? 2 : 1) * phase.sizes.nu;
    const double longer = now.length / std::max(old_[middle.phase][middle.interval].length, 1e-12);
    for (int i = 0; i < nc; ++i) {
      const int from = layout.input(middle.phase, middle.interval) + i, to = layout.input(j, k) + i;
      guess.w[to] = plan.w[from];
      if (dual) guess.z[to] = longer * plan.z[from];  // costs are per unit of time
    }
    if (!dual) continue;

    // The costate of node k + 1 is in the rows of interval k.
    const auto old_instance = [&](const Spot& spot) {
      return program.interval_instances()[first_instance_[spot.phase] + spot.interval];
    };
    const auto interpolate_costate = [&](int row, const Spot& spot) {
      const int before = spot.interval > 0 ? old_instance({spot.phase, spot.interval - 1}).first_row
                         : spot.phase == 0 ? program.start_row()
                                           : program.jump_row(spot.phase);
      const int after = old_instance(spot).first_row;
      for (int i = 0; i < nx; ++i)
        guess.lambda[row + i] = (1.0 - spot.fraction) * plan.lambda[before + i] +
                                spot.fraction * plan.lambda[after + i];
    };
    interpolate_costate(instance.first_row, end);
    if (k == 0)
      interpolate_costate(j == 0 ? program.start_row() : program.jump_row(j),
                          find_across(j, now.start, false));
    const int continuity = old_instance(middle).continuity_row;
    if (instance.continuity_row >= 0 && continuity >= 0)
      for (int i = 0; i < phase.sizes.nu; ++i)
        guess.lambda[instance.continuity_row + i] = plan.lambda[continuity + i];
  }

  const std::vector<RowInstance>& instances = program.row_instances();
  for (const Family& family : families_)
    for (std::size_t n = 0; n < family.instances.size(); ++n) {
      const RowInstance& to = instances[family.instances[n]];
      const auto& intervals = new_[family.phase];
      int source = 0;
      double longer = 1.0;
      if (family.by_node) {
        const int node = to.block.point.node;
        const double t = node < static_cast<int>(intervals.size()) ? intervals[node].start
                                                                   : intervals.back().end();
        source = nearest_node(family.phase, t);
      } else {
        const Interval& now = intervals[to.block.point.interval];
        source = find(family.phase, now.start + 0.5 * now.length, false).interval;
        longer = now.length / std::max(old_[family.phase][source].length, 1e-12);
      }
      const RowInstance& from = instances[family.instances[source]];
      for (std::size_t i = 0; i < to.slack_below.size(); ++i) {
        if (dual)
          guess.lambda[to.first_row + static_cast<int>(i)] =
              longer * plan.lambda[from.first_row + static_cast<int>(i)];
        for (const auto slacks :
             {&RowInstance::slack_below, &RowInstance::slack_above, &RowInstance::slack_free}) {
          const int slack = (to.*slacks)[i];
          if (slack < 0) continue;
          guess.w[slack] = plan.w[(from.*slacks)[i]];
          if (dual) guess.z[slack] = plan.z[(from.*slacks)[i]];
        }
      }
    }

  // Clip to the present bounds, which may have changed.
  guess.w = guess.w.cwiseMax(program.lower()).cwiseMin(program.upper());
  if (!dual) return;
  const auto drop = [](double& multiplier, double lower, double upper) {
    if (multiplier > 0.0 ? std::isinf(upper) : std::isinf(lower)) multiplier = 0.0;
  };
  for (int i = 0; i < program.variables(); ++i)
    drop(guess.z[i], program.lower()[i], program.upper()[i]);
  for (int i = 0; i < program.rows(); ++i)
    drop(guess.lambda[i], program.row_lower()[i], program.row_upper()[i]);
}

}  // namespace saltus
