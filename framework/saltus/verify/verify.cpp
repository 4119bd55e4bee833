#include "saltus/verify/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/verify/controlled_steps.hpp"
#include "saltus/verify/flow_growth.hpp"
#include "saltus/verify/mode_switches.hpp"
#include "saltus/verify/plan_costs.hpp"
#include "saltus/verify/plan_rows.hpp"
#include "saltus/verify/row_search.hpp"

namespace saltus {
namespace {

constexpr double step_tolerance = 1e-9;       // per step, relative to max(unit, |state|)
constexpr double tightest_tolerance = 1e-13;  // tolerance of the open loop if errors grow
constexpr double quadrature_share = 1e3;      // integrals need less accuracy than states
constexpr int max_events = 1000;              // per interval
// Peaks of rates may be narrower than the distance of the stages. The search finds a rate that
// exceeds its known range by this fraction of a unit per interval.
constexpr double peak_tolerance = 1e-4;
constexpr int most_retries = 100;      // per interval
constexpr int most_peak_pieces = 200;  // per step and function
// Fraction of a row's tolerance: smaller defects are solver errors of an equation.
constexpr double solved = 1e-2;

// Rates dy/dt of consecutive entries of y = (x | q), from `first` on.
struct Rates {
  int first = 0;
  PathConstraint values;
};

// Integrated quantities of a phase: states, then its integrated costs, then its integral
// constraints.
struct PhaseFlow {
  PhaseFlow(const OptimalControlProblem& problem, int j)
      : definition(problem.phases()[j]),
        terms(integrated_terms(problem, j)),
        field(definition.sizes, definition.dynamics, integrands(definition, terms),
              definition.input_shape()),
        steps(field, step_tolerance),
        switches(definition) {
    if (!switches.empty()) return;
    const auto add = [&](int first, const Function& function) {
      if (std::optional<PathConstraint> values = values_of(function))
        rates.push_back({first, *std::move(values)});
    };
    add(0, definition.dynamics);
    int q = definition.sizes.nx;
    for (const Function& integrand : integrands(definition, terms)) add(q++, integrand);
  }

  static std::vector<int> integrated_terms(const OptimalControlProblem& problem, int j) {
    std::vector<int> list;
    if (problem.cost_rule(j) != CostRule::integrated) return list;
    const std::vector<Term>& terms = problem.phases()[j].terms;
    for (int t = 0; t < static_cast<int>(terms.size()); ++t)
      if (terms[t].kind != Term::Kind::constraint && terms[t].domain == Term::Domain::running)
        list.push_back(t);
    return list;
  }
  static std::vector<Function> integrands(const PhaseDefinition& phase,
                                          const std::vector<int>& terms) {
    std::vector<Function> list;
    for (const int t : terms) list.push_back(cost_function(phase.terms[t]));
    for (const IntegralConstraint& integral : phase.integrals) list.push_back(integral.integrand);
    return list;
  }

  const PhaseDefinition& definition;
  std::vector<int> terms;
  PlanField field;
  ControlledSteps steps;
  ModeSwitches switches;
  std::vector<PathConstraint> constraints;
  std::vector<Rates> rates;  // rates of states and integrals, searched for hidden peaks
  VectorXd units;            // units of the states, then of the integrals
  VectorXd tolerances;       // tolerances of the states as rows (GridAccuracy::rows)
  bool undecided = false;    // an event could not be followed
};

class Verifier {
 public:
  Verifier(const OptimalControlProblem& problem, const Plan& plan, const VerifyOptions& options)
      : problem_(problem), plan_(plan), options_(options), search_(options.resolution) {}

  VerificationDetail run() {
    const auto begin = WallClock::now();
    set_up();
    for (std::size_t i = 0; i < plan_.intervals.size(); ++i) follow(i);
    finish_phase();
    for (const VectorXd& sums : sums_)
      if (sums.size() > 0) summary().defect.sum += sums.maxCoeff();
    note_violations();
    check_rows_at_nodes();
    check_instants(problem_, plan_, totals_, options_.accuracy, [&](Verification::Miss miss) {
      if (miss.term.starts_with("integral"))
        note(summary().between_nodes, std::move(miss));  // the grid determines its accuracy
      else
        note(summary().at_nodes, std::move(miss));
    });
    compare_cost();
    judge_open_loop();
    describe_schemes();
    summary().seconds = seconds_since(begin);
    return std::move(result_);
  }

 private:
  Verification& summary() { return result_.summary; }
  const GridAccuracy& accuracy() const { return options_.accuracy; }

  void set_up() {
    const std::vector<VectorXd> units = units_of_states(problem_, plan_);
    for (int j = 0; j < static_cast<int>(problem_.phases().size()); ++j) {
      PhaseFlow& flow = *flows_.emplace_back(std::make_unique<PhaseFlow>(problem_, j));
      flow.constraints = path_constraints(flow.definition, accuracy());
      flow.units.resize(flow.field.outputs());
      flow.units.head(units[j].size()) = units[j];
      flow.tolerances = accuracy().rows * flow.definition.nominal_state;
      totals_.push_back({std::vector<double>(flow.definition.terms.size(), 0.0),
                         std::vector<double>(flow.definition.integrals.size(), 0.0)});
    }
    set_units_of_integrals();
    result_.intervals.resize(plan_.intervals.size());
    sums_.resize(flows_.size());
    for (std::size_t j = 0; j < flows_.size(); ++j)
      sums_[j] = VectorXd::Zero(flows_[j]->definition.sizes.nx);
  }

  void activate(PhaseFlow& flow, const Plan::Interval& interval) {
    for (std::size_t i = 0; i < flow.terms.size(); ++i)
      flow.field.activate(static_cast<int>(i),
                          is_open(flow.definition.terms[flow.terms[i]].window, problem_.schedule(),
                                  plan_.starts[interval.phase], interval));
  }

  // Units from the rates at the starts of the intervals, but at least a fraction of the cost.
  void set_units_of_integrals() {
    double all = std::abs(plan_.cost);
    for (const auto& flow : flows_)
      flow->units.tail(flow->field.outputs() - flow->field.states()).setZero();
    for (const Plan::Interval& interval : plan_.intervals) {
      PhaseFlow& flow = *flows_[interval.phase];
      const int nx = flow.field.states();
      std::vector<double> y(flow.field.outputs()), rates(flow.field.outputs());
      std::copy_n(interval.state.data(), nx, y.data());
      flow.field.load(interval, plan_.parameters[interval.phase]);
      activate(flow, interval);
      if (!(interval.length > 0.0) || !flow.field.rates(0.0, y.data(), rates.data())) continue;
      for (int q = nx; q < flow.field.outputs(); ++q)
        flow.units[q] = std::max(flow.units[q], std::abs(rates[q]));
    }
    for (const auto& flow : flows_)
      for (int q = flow->field.states(); q < flow->field.outputs(); ++q)
        all = std::max(all, flow->units[q]);
    constexpr double least = 1e-8;
    for (const auto& flow : flows_) {
      for (int q = flow->field.states(); q < flow->field.outputs(); ++q)
        flow->units[q] =
            quadrature_share * std::max(flow->units[q], least * (all > 0.0 ? all : 1.0));
      flow->steps.set_units(flow->units);
    }
  }

  // ---- along the plan -------------------------------------------------------------------------

  void follow(std::size_t index) {
    const Plan::Interval& interval = plan_.intervals[index];
    if (interval.phase != phase_) enter(interval, index);
    PhaseFlow& flow = *flows_[interval.phase];
    if (!(interval.length > 0.0)) return;  // the phase has vanished
    flow.field.load(interval, plan_.parameters[interval.phase]);
    activate(flow, interval);
    widen_rows(flow, interval, index == 0);
    std::vector<double> y(flow.field.outputs(), 0.0);
    std::copy_n(interval.state.data(), interval.state.size(), y.data());
    bool works = flow.switches.start(flow.field, interval.state);
    if (!works) flow.undecided = true;
    if (works) works = integrate(flow, y, true);
    if (works) add_totals(flow, interval.phase, y);
    close_rows(flow, index);
    note_defect(flow, index, y, works);
  }

  // Integrates from s = 0 to 1; y receives the end. Returns false if the integration fails or an
  // event is undecided.
  bool integrate(PhaseFlow& flow, std::vector<double>& y, bool follows_plan) {
    ControlledSteps& steps = flow.steps;
    steps.begin(0.0, y.data());
    int events = 0, retries = 0;
    while (!steps.is_at_end()) {
      if (!steps.step()) return false;
      while (follows_plan && retries < most_retries) {
        const std::optional<double> peak = hidden_peak(flow);
        if (!peak) break;
        ++retries;
        steps.retry_before(*peak);
        if (!steps.step()) return false;
      }
      const std::optional<double> event =
          flow.switches.empty() ? std::nullopt : flow.switches.first_event(flow.field, steps);
      const double end = event.value_or(1.0);
      if (follows_plan) {
        look_at_rows(flow, end);
        if (flow.switches.empty()) grow(flow);
      }
      if (!event) continue;
      y.resize(flow.field.outputs());
      steps.state_at(end, y.data());
      const double s = steps.step_start() + end * steps.step_length();
      if (!flow.switches.take(flow.field, s, y) || ++events > max_events) {
        flow.undecided = true;
        return false;
      }
      steps.begin(s, y.data());
    }
    y = steps.state();
    return true;
  }

  // The fraction of the last step at which a rate leaves the range that the polynomial of the step
  // shows, if its integral may matter. The error estimate of the step does not see a peak between
  // its stages.
  std::optional<double> hidden_peak(PhaseFlow& flow) {
    const ControlledSteps& steps = flow.steps;
    const int nx = flow.field.states();
    std::optional<double> first;
    std::erase_if(flow.rates, [&](Rates& rates) {
      if (rates.first >= nx && !flow.field.is_active(rates.first - nx)) return false;
      int r = rates.first;
      for (PathRow& row : rates.values.rows) {
        double least = infinity, most = -infinity;
        for (const double theta : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          double slope = 0.0;
          for (int k = ControlledSteps::degree; k > 0; --k)
            slope = slope * theta + k * steps.coefficient(k)[r];
          least = std::min(least, slope);
          most = std::max(most, slope);
        }
        const double per_second = 1.0 / (steps.step_length() * flow.field.length());
        const double range = most - least;
        row.bounds = {(least - range) * per_second, (most + range) * per_second};
        const double unit = r < nx ? std::max(flow.units[r], std::abs(steps.coefficient(0)[r]))
                                   : flow.units[r] / quadrature_share + 1e-2 * std::abs(plan_.cost);
        row.lower_between = row.upper_between = peak_tolerance * unit / flow.field.length();
        row.lower_found = row.upper_found = 0.0;
        ++r;
      }
      search_.look_at(flow.field, flow.steps);
      const bool is_complete = search_.search(rates.values, most_peak_pieces);
      bool is_found = false;
      for (const PathRow& row : rates.values.rows)
        for (const bool upper : {false, true})
          if ((upper ? row.upper_found : row.lower_found) > row.upper_between) {
            const double at = search_.fraction_at(upper ? row.upper_time : row.lower_time);
            first = std::min(first.value_or(at), at);
            is_found = true;
          }
      return !is_complete && !is_found;  // its bounds are too wide to be of use
    });
    return first;
  }

  void grow(PhaseFlow& flow) {
    const int nx = flow.field.states();
    jacobian_.resize(static_cast<std::size_t>(nx) * nx);
    middle_.resize(flow.field.outputs());
    flow.steps.state_at(0.5, middle_.data());
    const double s = flow.steps.step_start() + 0.5 * flow.steps.step_length();
    if (flow.field.state_jacobian(s, middle_.data(), jacobian_.data()))
      growth_.step(jacobian_, flow.steps.step_length());
    else
      growth_known_ = false;
  }

  void enter(const Plan::Interval& interval, std::size_t index) {
    if (phase_ < 0) {
      phase_ = interval.phase;
      growth_.begin(static_cast<int>(interval.state.size()));
      start_units_ = flows_[phase_]->units.head(interval.state.size());
      return;
    }
    finish_phase();
    const Plan::Interval& before = plan_.intervals[index - 1];
    VectorXd x = before.end_state;
    for (; phase_ < interval.phase; ++phase_) {
      const Jump& jump = problem_.jumps()[phase_ + 1];
      if (!jump.map) continue;
      const VectorXd z = jump.argument(before.end(), x, plan_.parameters[phase_]);
      growth_.jump(jump.map.dense_jacobian(z).middleCols(1, x.size()));
      x = jump.map(z);
    }
    growth_.add_deviation(x - interval.state);
  }

  // At the end of a phase: first-order deviation of the open loop.
  void finish_phase() {
    if (phase_ < 0) return;
    const PhaseFlow& flow = *flows_[phase_];
    const VectorXd units = flow.units.head(flow.field.states());
    Verification::OpenLoop& loop = summary().open_loop;
    if (!flow.switches.empty()) growth_known_ = false;
    if (growth_known_) loop.growth = std::max(loop.growth, growth_.growth(start_units_, units));
    ends_.push_back({phase_, growth_.deviation()});
  }

  void add_totals(const PhaseFlow& flow, int j, const std::vector<double>& y) {
    std::size_t q = flow.definition.sizes.nx;
    for (const int t : flow.terms) totals_[j].costs[t] += y[q++];
    for (double& integral : totals_[j].integrals) integral += y[q++];
  }

  void note_defect(PhaseFlow& flow, std::size_t index, const std::vector<double>& y, bool works) {
    const Plan::Interval& interval = plan_.intervals[index];
    VerificationDetail::Interval& found = result_.intervals[index];
    Verification::Defect& worst = summary().defect;
    if (flow.undecided) return;  // reported in not_verified
    const int nx = flow.field.states();
    VectorXd gap(nx);
    for (int i = 0; i < nx; ++i) {
      gap[i] = works ? y[i] - interval.end_state[i] : infinity;
      const double unit =
          std::max({flow.units[i], std::abs(interval.state[i]), std::abs(interval.end_state[i])});
      const bool is_solved = std::abs(gap[i]) <= solved * flow.tolerances[i];
      const double off = is_solved               ? 0.0
                         : std::isfinite(gap[i]) ? std::abs(gap[i]) / unit
                                                 : infinity;
      sums_[interval.phase][i] += off;
      found.defect = std::max(found.defect, off);
      if (!(off > worst.largest) && !worst.phase.empty()) continue;
      worst.phase = flow.definition.name;
      worst.state = i;
      worst.time = interval.start;
      worst.largest = off;
      worst.absolute = std::abs(gap[i]);
    }
    if (gap.allFinite())
      growth_.add_deviation(gap);
    else
      growth_known_ = false;
  }

  // ---- path constraints -----------------------------------------------------------------------

  // On the way back from a start outside the bounds, rows of states do not hold. Their bounds are
  // extended to the start.
  void widen_rows(PhaseFlow& flow, const Plan::Interval& interval, bool is_first) {
    const bool is_given = is_first && interval.phase == 0 &&
                          std::ranges::all_of(problem_.start_bounds(), &Bounds::is_equality);
    open_.clear();
    for (PathConstraint& c : flow.constraints) {
      if (!is_open(c.window, problem_.schedule(), plan_.starts[interval.phase], interval)) continue;
      open_.push_back({&c, {}});
      for (PathRow& row : c.rows) row.lower_found = row.upper_found = 0.0;
      if (!is_given) continue;
      const VectorXd value = evaluate(c, flow.definition.sizes, interval, false);
      for (std::size_t i = 0; i < c.rows.size(); ++i) {
        Bounds& b = c.rows[i].bounds;
        open_.back().bounds.push_back(b);
        if (!c.rows[i].reads_states_alone) continue;
        b = {std::min(b.lower, value[static_cast<int>(i)]),
             std::max(b.upper, value[static_cast<int>(i)])};
      }
    }
  }

  VectorXd evaluate(const PathConstraint& c, const Arguments& sizes, const Plan::Interval& interval,
                    bool at_end) const {
    const VectorXd z = argument_of(sizes, interval, at_end, plan_.parameters[interval.phase]);
    if (c.state >= 0) return z.segment(sizes.x(c.state), 1);
    return c.function(z);
  }

  void look_at_rows(PhaseFlow& flow, double end) {
    if (open_.empty()) return;
    search_.look_at(flow.field, flow.steps, end);
    for (const OpenConstraint& open : open_)
      if (!search_.search(*open.constraint))
        say(fmt::format("term '{}' of phase '{}' varies too fast to be followed everywhere",
                        open.constraint->name, flow.definition.name));
  }

  void close_rows(PhaseFlow& flow, std::size_t index) {
    VerificationDetail::Interval& found = result_.intervals[index];
    for (OpenConstraint& open : open_) {
      PathConstraint& c = *open.constraint;
      for (std::size_t i = 0; i < c.rows.size(); ++i) {
        PathRow& row = c.rows[i];
        for (const bool upper : {false, true}) {
          const double amount = upper ? row.upper_found : row.lower_found;
          if (!(amount > 0.0)) continue;
          const Verification::Miss miss{flow.definition.name, c.name,
                                        upper ? row.upper_time : row.lower_time, amount,
                                        upper ? row.upper_between : row.lower_between};
          found.violation = std::max(found.violation, amount);
          found.excess = std::max(found.excess, amount / miss.tolerance);
          auto known = std::ranges::find_if(
              worst_, [&](const Worst& w) { return w.constraint == &c && w.row == i; });
          if (known == worst_.end())
            known = worst_.insert(known, {&c, i, {}, plan_.intervals[index].phase, index});
          if (miss.amount / miss.tolerance > ratio(known->miss)) {
            known->miss = miss;
            known->interval = index;
          }
        }
        if (i < open.bounds.size()) row.bounds = open.bounds[i];
      }
    }
  }

  static double ratio(const Verification::Miss& miss) {
    return miss.amount > 0.0 ? miss.amount / miss.tolerance : 0.0;
  }

  void note(Verification::Miss& worst, Verification::Miss miss) {
    if (ratio(miss) > ratio(worst) || worst.tolerance == 0.0) worst = std::move(miss);
  }

  void note_violations() {
    for (Worst& w : worst_) {
      const PathRow& row = w.constraint->rows[w.row];
      const double range = row.most - row.least, by_nominal = nominal_change(w);
      const double scale = std::max(std::isfinite(range) ? range : 0.0, by_nominal);
      note(summary().between_nodes, w.miss);
      const auto same =
          std::ranges::find_if(result_.violated, [&](const VerificationDetail::Path& f) {
            return f.miss.phase == w.miss.phase && f.miss.term == w.miss.term;
          });
      if (same == result_.violated.end())
        result_.violated.push_back({w.miss, scale > 0.0 ? scale : 1.0});
      else if (ratio(w.miss) > ratio(same->miss))
        *same = {w.miss, scale > 0.0 ? scale : 1.0};
    }
    std::ranges::stable_sort(
        result_.violated, [](const VerificationDetail::Path& a, const VerificationDetail::Path& b) {
          return ratio(a.miss) > ratio(b.miss);
        });
  }

  struct Worst;
  // Change of a row for nominal changes of state and input, at the start of the interval of its
  // miss.
  double nominal_change(const Worst& w) const {
    const PhaseDefinition& phase = flows_[w.phase]->definition;
    const Arguments& a = phase.sizes;
    if (w.constraint->state >= 0) return phase.nominal_state[w.constraint->state];
    const MatrixXd slope = w.constraint->function.dense_jacobian(
        argument_of(a, plan_.intervals[w.interval], false, plan_.parameters[w.phase]));
    double change = 0.0;
    const auto row = static_cast<Eigen::Index>(w.row);
    for (int i = 0; i < a.nx; ++i) change += std::abs(slope(row, a.x(i))) * phase.nominal_state[i];
    for (int i = 0; i < a.nu; ++i) change += std::abs(slope(row, a.u(i))) * phase.nominal_input[i];
    return std::isfinite(change) ? change : 0.0;
  }

  void check_rows_at_nodes() {
    const bool is_given = std::ranges::all_of(problem_.start_bounds(), &Bounds::is_equality);
    for (std::size_t k = 0; k < plan_.intervals.size(); ++k) {
      const Plan::Interval& interval = plan_.intervals[k];
      PhaseFlow& flow = *flows_[interval.phase];
      if (!(interval.length > 0.0)) continue;
      const bool is_linear = flow.field.has_linear_input();
      for (const PathConstraint& c : flow.constraints) {
        if (!is_open(c.window, problem_.schedule(), plan_.starts[interval.phase], interval))
          continue;
        for (const bool at_end : {false, true}) {
          if (c.reads_input && at_end && !is_linear) continue;
          const bool at_given_start = !at_end && k == 0 && interval.phase == 0 && is_given;
          const VectorXd value = evaluate(c, flow.definition.sizes, interval, at_end);
          for (std::size_t i = 0; i < c.rows.size(); ++i) {
            const PathRow& row = c.rows[i];
            if (at_given_start && row.reads_states_alone) continue;
            const double v = value[static_cast<int>(i)];
            const double amount = beyond(v, row.bounds);
            if (amount > 0.0)
              note(summary().at_nodes,
                   {flow.definition.name, c.name, at_end ? interval.end() : interval.start, amount,
                    v < row.bounds.lower ? row.lower_at_node : row.upper_at_node});
          }
        }
      }
    }
  }

  // ---- cost and open loop -----------------------------------------------------------------------

  void compare_cost() {
    for (const auto& flow : flows_) {
      if (flow->undecided) return;
      for (const SwitchingSystem::Mode& mode : flow->definition.switching.modes)
        if (mode.running_cost) return say("the running cost of a mode is not compared");
    }
    const PlanCost own = cost_of(problem_, plan_, totals_);
    Verification::Cost& cost = summary().cost;
    cost.compared = true;
    cost.value = own.value + plan_.grid_cost;
    const double difference = std::abs(cost.value - plan_.cost);
    constexpr double floor = 1e-6;  // absolute, see GridAccuracy::cost
    const double size = std::max({std::abs(plan_.cost), std::abs(cost.value), own.magnitude});
    cost.difference = difference <= floor         ? 0.0
                      : std::isfinite(difference) ? difference / size
                                                  : infinity;
  }

  void judge_open_loop() {
    Verification::OpenLoop& loop = summary().open_loop;
    loop.completed = std::ranges::none_of(flows_, [](const auto& flow) { return flow->undecided; });
    if (!loop.completed || plan_.intervals.empty()) return;
    // First-order deviation if it is reliable, otherwise an integration.
    double largest = 0.0;
    for (const auto& [j, deviation] : ends_)
      for (int i = 0; i < deviation.size(); ++i)
        largest = std::max(largest, std::abs(deviation[i]) / flows_[j]->units[i]);
    constexpr double certain = 0.1;
    bool is_certain = growth_known_ && largest <= certain * accuracy().open_loop;
    if (is_certain) {
      compare_ends();
      is_certain = ratio(loop.end) <= certain * accuracy().open_loop_end;
    }
    if (is_certain) return;
    integrate_open_loop();
    compare_ends();
  }

  // The deviation from the plan and the violations of end constraints by the open loop.
  void compare_ends() {
    Verification::OpenLoop& loop = summary().open_loop;
    loop.states = 0.0;
    loop.end = {};
    for (const auto& [j, deviation] : ends_) {
      const Plan::Interval* last = nullptr;
      for (const Plan::Interval& interval : plan_.intervals)
        if (interval.phase == j) last = &interval;
      if (last == nullptr) continue;
      for (int i = 0; i < deviation.size(); ++i) {
        if (std::abs(deviation[i]) <= flows_[j]->tolerances[i]) continue;
        const double unit = std::max(flows_[j]->units[i], std::abs(last->end_state[i]));
        const double off = std::isfinite(deviation[i]) ? std::abs(deviation[i]) / unit : infinity;
        if (!(off > loop.states)) continue;
        loop.states = off;
        loop.state = i;
        loop.phase = flows_[j]->definition.name;
        loop.time = last->end();
      }
      check_end_terms(problem_, plan_, j, last->end_state + deviation, accuracy(),
                      [&](Verification::Miss miss) { note(loop.end, std::move(miss)); });
    }
  }

  void integrate_open_loop() {
    const double growth = growth_known_ ? summary().open_loop.growth : 1.0;
    const double tolerance =
        std::clamp(step_tolerance / std::max(1.0, growth), tightest_tolerance, step_tolerance);
    for (auto& [j, deviation] : ends_) deviation.setConstant(infinity);
    VectorXd x = plan_.intervals.front().state;
    int phase = plan_.intervals.front().phase;
    std::size_t end = 0;
    for (std::size_t k = 0; k < plan_.intervals.size(); ++k) {
      const Plan::Interval& interval = plan_.intervals[k];
      for (; phase < interval.phase; ++phase)
        x = problem_.jumps()[phase + 1].apply(plan_.intervals[k - 1].end(), x,
                                              plan_.parameters[phase]);
      PhaseFlow& flow = *flows_[interval.phase];
      if (interval.length > 0.0) {
        flow.field.load(interval, plan_.parameters[interval.phase]);
        for (int i = flow.field.states(); i < flow.field.outputs(); ++i)
          flow.field.activate(i - flow.field.states(), false);
        flow.steps.set_tolerance(tolerance);
        std::vector<double> y(flow.field.outputs(), 0.0);
        std::copy_n(x.data(), x.size(), y.data());
        if (!x.allFinite() || !flow.switches.start(flow.field, x) || !integrate(flow, y, false)) {
          flow.undecided = false;  // true only of the open loop, not of the plan
          return;
        }
        std::copy_n(y.data(), x.size(), x.data());
      }
      const bool ends =
          k + 1 == plan_.intervals.size() || plan_.intervals[k + 1].phase != interval.phase;
      if (ends) ends_[end++].second = x - interval.end_state;
    }
  }

  void describe_schemes() {
    std::set<std::string> schemes;
    for (const auto& flow : flows_) {
      if (flow->steps.was_explicit()) schemes.insert("Dormand-Prince 5(4)");
      if (flow->steps.is_implicit()) schemes.insert("SDIRK 4(3)");
      if (flow->undecided)
        say(
            fmt::format("phase '{}' slides on a surface of an event, or its mode is undecided: its "
                        "integration is not verified",
                        flow->definition.name));
    }
    for (const std::string& scheme : schemes)
      summary().integrator += (summary().integrator.empty() ? "" : ", ") + scheme;
  }

  void say(std::string sentence) {
    auto& list = summary().not_verified;
    if (std::ranges::find(list, sentence) == list.end()) list.push_back(std::move(sentence));
  }

  struct OpenConstraint {
    PathConstraint* constraint;
    std::vector<Bounds> bounds;  // declared bounds of widened rows
  };
  struct Worst {
    const PathConstraint* constraint;
    std::size_t row;
    Verification::Miss miss;
    int phase;
    std::size_t interval;
  };

  const OptimalControlProblem& problem_;
  const Plan& plan_;
  VerifyOptions options_;
  VerificationDetail result_;
  std::vector<std::unique_ptr<PhaseFlow>> flows_;
  std::vector<PhaseTotals> totals_;
  std::vector<VectorXd> sums_;
  RowSearch search_;
  std::vector<OpenConstraint> open_;
  std::vector<Worst> worst_;
  FlowGrowth growth_;
  bool growth_known_ = true;
  int phase_ = -1;
  VectorXd start_units_;
  std::vector<std::pair<int, VectorXd>> ends_;  // deviation of the open loop at ends of phases
  std::vector<double> jacobian_, middle_;
};

}  // namespace

VerificationDetail verify(const OptimalControlProblem& problem, const Plan& plan,
                          const VerifyOptions& options) {
  if (plan.intervals.empty()) return {};
  return Verifier(problem, plan, options).run();
}

}  // namespace saltus
