#include "saltus/solve/remedies.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/solve/sensitivities.hpp"

namespace saltus {
namespace {

using Kind = ProblemChange::Kind;

constexpr int most_candidates = 8, most_trials = 6, max_events = 4;
constexpr int event_trial = 2;  // first trial step of an event, in intervals
// Relative margins beyond the limit of feasibility, so that the solution has room.
constexpr double margins[] = {0.01, 0.05, 0.2};

struct Trial {
  double by = 0.0, amount = 0.0;
};
// Secant extrapolation to a vanishing relaxation.
double secant(const Trial& before, const Trial& last) {
  return -last.amount * (last.by - before.by) / (last.amount - before.amount);
}

// Rounds to three digits away from zero.
double rounded_up(double by) {
  if (by == 0.0) return by;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(by))) - 2.0);
  return std::copysign(std::ceil(std::abs(by) / unit - 1e-9) * unit, by);
}

class RemedySearch {
 public:
  RemedySearch(const OptimalControlProblem& problem, LeastRelaxation& relaxed,
               const RelaxedConstraints& gives, SolveBudget& solves)
      : problem_(problem),
        relaxed_(relaxed),
        gives_(gives),
        solves_(solves),
        motion_(relaxed.trajectory()) {}

  std::vector<Explanation::Remedy> run(int most) {
    candidates_ = find_candidates(problem_, relaxed_, [this] { return solves_.is_late(); });
    try_events();
    std::erase_if(candidates_,
                  [this](const Candidate& c) { return !solves_.may_change(c.change); });
    std::ranges::stable_sort(candidates_, {}, [](const Candidate& c) { return c.effort(); });
    // The shortages themselves are verified first, while there is time, and listed last.
    if (gives_.can_change) carry_out(gives_.changes, 0.0);
    const std::size_t given = remedies_.size();
    int tried = 0;
    for (Candidate& candidate : candidates_) {
      const auto found = static_cast<int>(remedies_.size() - given);
      if (found >= most || tried >= most_candidates || solves_.is_late()) break;
      if (is_given(candidate.change)) continue;
      ++tried;
      if (find_amount(candidate) && !only_exploits_grid(candidate.change))
        carry_out({candidate.change}, candidate.effort());
    }
    std::rotate(remedies_.begin(), remedies_.begin() + static_cast<std::ptrdiff_t>(given),
                remedies_.end());
    return std::move(remedies_);
  }

 private:
  bool is_given(const ProblemChange& c) const {
    if (gives_.changes.size() != 1) return false;
    const ProblemChange& given = gives_.changes.front();
    return given.kind == c.kind && given.phase == c.phase && given.name == c.name &&
           given.component == c.component;
  }

  // An event moves nodes and rows, so that only one-sided derivatives exist: it is tried by a
  // solve. Events beyond the end of the motion are skipped.
  void try_events() {
    const double length = event_trial * relaxed_.shooting->grid().nominal_length(0);
    int asked = 0;
    for (const Event& event : problem_.schedule().events()) {
      if (!std::isfinite(event.time) || event.time > motion_.end_time() || ++asked > max_events)
        continue;
      for (const double by : {-length, length}) {
        const ProblemChange change{
            .kind = Kind::event, .name = std::string(event.name.view()), .by = by};
        const double amount = amount_with(change);
        if (amount < relaxed_.amount)
          add_candidate(problem_, change, (amount - relaxed_.amount) / by, length, relaxed_.amount,
                        candidates_);
      }
    }
  }

  bool leaves(const ProblemChange& change) const {
    return change.kind == Kind::event && problem_.schedule().time_of(change.name) + change.by >=
                                             motion_.end_time() - same_instant;
  }

  // Relaxation of the changed problem; infinite if unknown.
  double amount_with(const ProblemChange& change) {
    if (solves_.is_late() || leaves(change)) return infinity;
    try {
      return solves_.relax(changed(problem_, change), &motion_).amount;
    } catch (const DefinitionError&) {
      return infinity;
    }
  }

  // Finds the change at which the relaxation vanishes by the secant method. Returns false if it
  // diverges.
  bool find_amount(Candidate& candidate) {
    ProblemChange& change = candidate.change;
    Trial before{0.0, relaxed_.amount}, failed = before;
    for (int trial = 0; trial < most_trials; ++trial) {
      const double amount = amount_with(change);
      if (!std::isfinite(amount)) return false;
      if (amount <= smallest_relaxation) {
        tighten(change, before, failed);
        return true;
      }
      if (amount >= failed.amount) return false;
      before = std::exchange(failed, {change.by, amount});
      const double step = std::clamp(secant(before, failed) / change.by, 0.02, 3.0);
      change.by *= 1.0 + 1.02 * step;
      if (!candidate.is_credible()) return false;
    }
    return false;
  }

  // True if the change only exploits the grid. A longer phase has wider intervals. A remedy that
  // only delays the first nodes fails on a grid with the original interval length.
  bool only_exploits_grid(const ProblemChange& change) {
    const bool is_length = change.kind == Kind::duration || change.kind == Kind::total_time;
    if (!is_length || !(change.by > 0.0) || !solves_.grid().meshes.empty()) return false;
    const double longer = 1.0 + change.by / value_before(problem_, change);
    ShootingOptions finer = solves_.grid();
    if (finer.intervals.empty())
      finer.intervals.assign(problem_.phases().size(), finer.intervals_per_phase);
    for (std::size_t j = 0; j < finer.intervals.size(); ++j)
      if (change.kind == Kind::total_time || static_cast<int>(j) == change.phase)
        finer.intervals[j] = static_cast<int>(std::ceil(longer * finer.intervals[j]));
    constexpr double hardly = 0.1;  // fraction of the relaxation: additional nodes add constraints
    return solves_.relax(changed(problem_, change), &motion_, finer).amount >
           hardly * relaxed_.amount;
  }

  // A sufficient change may be too large: reduces it to within 1 % of the smallest one.
  void tighten(ProblemChange& change, Trial before, Trial failed) {
    for (int trial = 0; trial < most_trials; ++trial) {
      const double gap = change.by - failed.by;
      if (std::abs(gap) <= margins[0] * std::abs(change.by)) return;
      double by = failed.by + 0.5 * gap;
      if (trial == 0 && failed.by == 0.0) {
        by = (1.0 - margins[0]) * change.by;  // for a nearly linear problem
      } else if (failed.by != before.by) {
        const double estimate = failed.by + 1.005 * secant(before, failed);
        if ((estimate - failed.by) / gap < 0.95) by = estimate;
      }
      ProblemChange less = change;
      less.by = by;
      const double amount = amount_with(less);
      if (amount <= smallest_relaxation) {
        change.by = by;
        before = failed;  // the secant was successful
      } else {
        before = std::exchange(failed, {by, amount});
      }
    }
  }

  // Solves the problem with the changes plus a margin.
  void carry_out(const std::vector<ProblemChange>& changes, double effort) {
    for (const double margin : margins) {
      if (solves_.is_late()) return;
      Explanation::Remedy remedy;
      remedy.effort = effort;
      OptimalControlProblem better = problem_;
      try {
        for (ProblemChange change : changes) {
          change.by = rounded_up((1.0 + margin) * change.by);
          better = changed(better, change);
          remedy.text += (remedy.text.empty() ? "" : " and ") + saltus::describe(problem_, change);
          remedy.changes.push_back(std::move(change));
        }
        MultipleShooting shooting(better, solves_.grid());
        const Solution plan = solves_.plan(shooting, motion_);
        remedy.status = plan.status;
        remedy.cost = plan.cost;
        if (!is_plan(plan)) continue;
        remedies_.push_back(std::move(remedy));
        return;
      } catch (const DefinitionError&) {
        return;
      }
    }
  }

  const OptimalControlProblem& problem_;
  LeastRelaxation& relaxed_;
  const RelaxedConstraints& gives_;
  SolveBudget& solves_;
  Trajectory motion_;  // trajectory of the least relaxation
  std::vector<Candidate> candidates_;
  std::vector<Explanation::Remedy> remedies_;
};

}  // namespace

std::vector<Explanation::Remedy> find_remedies(const OptimalControlProblem& problem,
                                               LeastRelaxation& relaxed,
                                               const RelaxedConstraints& gives, int most,
                                               SolveBudget& solves) {
  return RemedySearch(problem, relaxed, gives, solves).run(most);
}

}  // namespace saltus
