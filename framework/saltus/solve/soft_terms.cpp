#include "saltus/solve/soft_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/solve/remedies.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

using Side = ProblemChange::Side;

constexpr double smallest_price_fraction = 1e-3;  // fraction of the cost of all soft terms together
// Weights above the largest multiplier make a penalty exact; the margin covers rounding.
constexpr double room = 1.02;

// A program row of a soft term with its slack variables (-1: none).
struct SoftRow {
  Explanation::Shortage name;  // kind, phase, term, component
  const Penalty* penalty = nullptr;
  int row = 0;
  int below = -1, above = -1, free = -1;
  shooting::GridPoint point;
};

template <class Instance>
SoftRow soft_row(const Instance& instance, int i, Explanation::Shortage name,
                 const Penalty* penalty, const shooting::GridPoint& point) {
  name.component = i;
  return {std::move(name),
          penalty,
          instance.first_row + i,
          instance.slack_below[i],
          instance.slack_above[i],
          instance.slack_free[i],
          point};
}

// In the order of the instances, which does not depend on which terms are soft.
std::vector<SoftRow> soft_rows(const ShootingProgram& program) {
  std::vector<SoftRow> rows;
  const OptimalControlProblem& problem = program.problem();
  for (const shooting::RowInstance& instance : program.row_instances()) {
    const PhaseDefinition& phase = problem.phases()[instance.phase];
    const Term& term = phase.terms[instance.term];
    if (!term.soft) continue;
    for (int i = 0; i < static_cast<int>(instance.slack_below.size()); ++i)
      rows.push_back(soft_row(instance, i, {.kind = "term", .phase = phase.name, .term = term.name},
                              &*term.soft, instance.block.point));
  }
  for (const shooting::LimitInstance& instance : program.limit_instances()) {
    const Limits& limits = program.limits_of(instance);
    if (!limits.soft) continue;
    const PhaseDefinition& phase = problem.phases()[instance.phase];
    Explanation::Shortage name;
    if (instance.link >= 0)
      name = {.kind = "link", .term = problem.links()[instance.link].name};
    else
      name = {
          .kind = "integral", .phase = phase.name, .term = phase.integrals[instance.integral].name};
    for (int i = 0; i < instance.count; ++i)
      rows.push_back(soft_row(instance, i, name, &*limits.soft, instance.point));
  }
  return rows;
}

bool is_same_term(const Explanation::Shortage& a, const Explanation::Shortage& b) {
  return a.kind == b.kind && a.phase == b.phase && a.term == b.term;
}
bool is_same_row(const Explanation::Shortage& a, const Explanation::Shortage& b) {
  return is_same_term(a, b) && a.component == b.component;
}

// Change of each row at w for nominal changes of the variables without slacks.
VectorXd nominal_rows(ShootingProgram& program, const std::vector<SoftRow>& rows,
                      const VectorXd& w) {
  std::vector<bool> is_slack(static_cast<std::size_t>(program.variables()), false);
  for (const SoftRow& row : rows)
    for (const int slack : {row.below, row.above, row.free})
      if (slack >= 0) is_slack[slack] = true;
  VectorXd nominal = VectorXd::Zero(program.rows());
  std::vector<double> entries(program.jacobian_pattern().entries());
  if (program.jacobian(w.data(), entries.data()))
    program.jacobian_pattern().for_each([&](int r, int c, int e) {
      if (!is_slack[c] && std::isfinite(entries[e]))
        nominal[r] = std::max(nominal[r], std::abs(entries[e]));
    });
  for (double& n : nominal)
    if (n == 0.0) n = 1.0;
  return nominal;
}

// Rows that repeat each other, as in hulls of fixed size, are violated alike: they are listed once
// with the price of all.
void merge_repeats(std::vector<Explanation::SoftShortage>& all) {
  std::vector<Explanation::SoftShortage> merged;
  for (Explanation::SoftShortage& s : all) {
    const auto twin = std::ranges::find_if(merged, [&](const Explanation::SoftShortage& other) {
      return is_same_term(s.missed, other.missed) && s.missed.side == other.missed.side &&
             s.missed.time == other.missed.time && s.missed.bound == other.missed.bound &&
             s.missed.amount > 0.0 &&
             std::abs(s.missed.amount - other.missed.amount) <=
                 smallest_relaxation * s.missed.nominal;
    });
    if (twin == merged.end())
      merged.push_back(std::move(s));
    else
      twin->price += s.price;
  }
  all = std::move(merged);
}

// ---- problem with other penalties ---------------------------------------------------------------

// Calls edit(penalty or none) for every term in `soft`.
template <class Edit>
OptimalControlProblem with_penalties(const OptimalControlProblem& problem,
                                     const std::vector<Explanation::SoftShortage>& soft,
                                     const Edit& edit) {
  OptimalControlProblem result = problem;
  const auto visit = [&](std::optional<Penalty>& penalty, const Explanation::Shortage& name) {
    for (const Explanation::SoftShortage& s : soft)
      if (penalty && is_same_term(s.missed, name)) edit(penalty, s);
  };
  for (int j = 0; j < static_cast<int>(problem.phases().size()); ++j) {
    PhaseDefinition& phase = result.editable_phase(j);
    for (Term& term : phase.terms)
      visit(term.soft, {.kind = "term", .phase = phase.name, .term = term.name});
    for (IntegralConstraint& integral : phase.integrals)
      visit(integral.limits.soft, {.kind = "integral", .phase = phase.name, .term = integral.name});
  }
  for (int l = 0; l < static_cast<int>(problem.links().size()); ++l) {
    Link& link = result.editable_link(l);
    visit(link.limits.soft, {.kind = "link", .term = link.name});
  }
  return result;
}

// ---- explanation --------------------------------------------------------------------------------

// The cost that increases most if all violated terms are held.
std::string largest_cost_increase(const Solution& free, const Solution& held) {
  std::map<std::pair<std::string, std::string>, double> grown;
  for (const Solution::CostContribution& c : held.costs) grown[{c.phase, c.term}] += c.value;
  for (const Solution::CostContribution& c : free.costs)
    if (const auto other = grown.find({c.phase, c.term}); other != grown.end())
      other->second -= c.value;
  const auto most = std::ranges::max_element(grown, {}, [](const auto& g) { return g.second; });
  if (most == grown.end() || !(most->second > 0.0)) return {};
  return fmt::format("phase '{}', '{}'", most->first.first, most->first.second);
}

// The weight with a margin, rounded up to three digits.
double with_room(double weight) {
  const double unit = std::pow(10.0, std::floor(std::log10(weight)) - 2.0);
  return std::ceil(room * weight / unit) * unit;
}

class SoftTerms {
 public:
  SoftTerms(const OptimalControlProblem& problem, SolveBudget& solves, Explanation& explanation)
      : problem_(problem),
        solves_(solves),
        explanation_(explanation),
        soft_(explanation.gives_way),
        shooting_(problem, solves.grid()) {}

  void run(int most_remedies) {
    const std::vector<SoftRow> rows = soft_rows(shooting_.program());
    if (rows.empty() || solves_.is_late()) return;
    const Solution plan = solves_.plan(shooting_, explanation_.trajectory);
    if (!is_plan(plan)) return;
    explanation_.cost = plan.cost;
    soft_ = soft_shortages(shooting_, plan);
    if (soft_.empty()) return;
    explanation_.trajectory = plan.trajectory;
    const OptimalControlProblem held = with_hard_terms(problem_, soft_);
    // Hard terms stay hard: only the violated soft terms are relaxed.
    solves_.is_negotiable = [&](const NegotiableConstraint& asked) {
      const Explanation::Shortage name{
          .kind = asked.kind,
          .phase = asked.has_phase ? held.phases()[asked.phase].name : "",
          .term = asked.name};
      return std::ranges::any_of(soft_,
                                 [&](const auto& s) { return is_same_term(s.missed, name); });
    };
    LeastRelaxation relaxed = solves_.relax(held, &plan.trajectory);
    if (!relaxed.ok()) return;
    const RelaxedConstraints gives =
        relaxed.is_needed() ? relaxed_constraints(relaxed) : RelaxedConstraints{};
    for (Explanation::SoftShortage& s : soft_) s.least = 0.0;
    for (const Explanation::Shortage& shortage : gives.shortages)
      for (Explanation::SoftShortage& s : soft_)
        if (is_same_row(s.missed, shortage)) s.least = std::max(*s.least, shortage.amount);
    if (!relaxed.is_needed())
      ask_for_the_price(held, plan);
    else if (most_remedies > 0)
      explanation_.remedies = find_remedies(held, relaxed, gives, most_remedies, solves_);
  }

 private:
  void ask_for_the_price(const OptimalControlProblem& held, const Solution& plan) {
    MultipleShooting hard(held, solves_.grid());
    const Solution other = solves_.plan(hard, plan.trajectory);
    if (!is_plan(other)) return;
    for (Explanation::SoftShortage& s : soft_) s.cost_if_held = other.cost;
    explanation_.gives_way_to = largest_cost_increase(plan, other);
    find_weights(hard.program(), other, plan.point.w);
  }

  // An exact penalty permits no violation if its weight exceeds the largest multiplier of its hard
  // rows.
  void find_weights(const ShootingProgram& hard, const Solution& held, const VectorXd& w) {
    std::vector<double> needed(soft_.size(), 0.0);
    VectorXd one = w;
    const auto ask = [&](const SoftRow& row, int hard_row) {
      for (std::size_t k = 0; k < soft_.size(); ++k) {
        if (!is_same_term(soft_[k].missed, row.name)) continue;
        if (!is_exact(*row.penalty)) needed[k] = std::nan("");
        for (const int slack : {row.below, row.above}) {
          if (slack < 0) continue;
          const double before = std::exchange(one[slack], 1.0);
          const double price = shooting_.editable_program().slack_cost(slack, one);
          one[slack] = before;
          if (price > 0.0)
            needed[k] = std::max(
                needed[k], row.penalty->weight * std::abs(held.point.lambda[hard_row]) / price);
        }
      }
    };
    // Soft rows belong to instances that exist in both programs.
    const std::vector<SoftRow> rows = soft_rows(shooting_.program());
    std::size_t next = 0;
    const auto ask_instances = [&](const auto& mine, const auto& others, const auto& is_soft) {
      for (std::size_t i = 0; i < mine.size(); ++i) {
        if (!is_soft(mine[i])) continue;
        for (int c = 0; c < static_cast<int>(mine[i].slack_below.size()); ++c)
          ask(rows[next++], others[i].first_row + c);
      }
    };
    const ShootingProgram& program = shooting_.program();
    ask_instances(program.row_instances(), hard.row_instances(), [&](const auto& instance) {
      return problem_.phases()[instance.phase].terms[instance.term].soft.has_value();
    });
    ask_instances(program.limit_instances(), hard.limit_instances(), [&](const auto& instance) {
      return program.limits_of(instance).soft.has_value();
    });
    for (double& weight : needed) {
      if (!std::isfinite(weight) || weight <= 0.0) return;
      weight = with_room(weight);
    }
    if (!holds_with(needed, held)) return;
    for (std::size_t k = 0; k < soft_.size(); ++k) soft_[k].weight_that_holds = needed[k];
  }

  bool holds_with(const std::vector<double>& weights, const Solution& held) {
    if (solves_.is_late()) return false;
    const OptimalControlProblem dearer =
        with_penalties(problem_, soft_, [&](std::optional<Penalty>& penalty, const auto& s) {
          penalty->weight = std::max(penalty->weight, weights[&s - soft_.data()]);
        });
    MultipleShooting shooting(dearer, solves_.grid());
    const Solution plan = solves_.plan(shooting, held.trajectory);
    if (!is_plan(plan)) return false;
    const std::vector<Explanation::SoftShortage> still = soft_shortages(shooting, plan);
    return std::ranges::none_of(still, [&](const Explanation::SoftShortage& a) {
      return std::ranges::any_of(soft_, [&](const Explanation::SoftShortage& b) {
        return is_same_term(a.missed, b.missed);
      });
    });
  }

  const OptimalControlProblem& problem_;
  SolveBudget& solves_;
  Explanation& explanation_;
  std::vector<Explanation::SoftShortage>& soft_;
  MultipleShooting shooting_;
};

}  // namespace

std::vector<Explanation::SoftShortage> soft_shortages(MultipleShooting& shooting,
                                                      const Solution& solution) {
  ShootingProgram& program = shooting.editable_program();
  const VectorXd& w = solution.point.w;
  const std::vector<SoftRow> rows = soft_rows(program);
  const VectorXd nominal = nominal_rows(program, rows, w);
  std::vector<Explanation::SoftShortage> all;
  for (const SoftRow& row : rows) {
    auto found = std::ranges::find_if(
        all, [&](const Explanation::SoftShortage& s) { return is_same_row(s.missed, row.name); });
    if (found == all.end()) {
      found = all.insert(all.end(), {.missed = row.name, .weight = row.penalty->weight});
      found->missed.nominal = nominal[row.row];
    }
    for (const int slack : {row.below, row.above, row.free})
      if (slack >= 0) found->price += program.slack_cost(slack, w);
    // part of the violation; positive: below the lower side
    const double free = row.free >= 0 ? w[row.free] : 0.0;
    const double lower = program.row_lower()[row.row], upper = program.row_upper()[row.row];
    for (const Side side : {Side::lower, Side::upper}) {
      const bool is_low = side == Side::lower;
      const int slack = is_low ? row.below : row.above;
      const double amount = slack < 0 ? 0.0 : w[slack] + (is_low ? free : -free);
      Explanation::Shortage& missed = found->missed;
      if (amount <= missed.amount) continue;
      missed.side = side;
      missed.amount = amount;
      missed.nominal = nominal[row.row];
      missed.time = program.time_of(row.point, &w);
      missed.bound = is_low ? lower : upper;
      missed.value = is_low ? lower - amount : upper + amount;
      missed.is_exact = lower == upper;
    }
  }
  merge_repeats(all);
  double paid = 0.0;
  for (const Explanation::SoftShortage& s : all) paid += s.price;
  std::erase_if(all, [&](const Explanation::SoftShortage& s) {
    return s.missed.amount <= smallest_relaxation * s.missed.nominal ||
           s.price < smallest_price_fraction * paid;
  });
  std::ranges::stable_sort(all, std::ranges::greater{}, &Explanation::SoftShortage::price);
  return all;
}

OptimalControlProblem with_hard_terms(const OptimalControlProblem& problem,
                                      const std::vector<Explanation::SoftShortage>& soft) {
  return with_penalties(problem, soft,
                        [](std::optional<Penalty>& penalty, const auto&) { penalty.reset(); });
}

void explain_soft_terms(const OptimalControlProblem& problem, int most_remedies,
                        SolveBudget& solves, Explanation& explanation) {
  SoftTerms(problem, solves, explanation).run(most_remedies);
}

}  // namespace saltus
