#include "saltus/solve/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

using Kind = ProblemChange::Kind;
using Side = ProblemChange::Side;
using shooting::GridPoint;

constexpr double tolerance = 1e-9;  // of elastic programs: what is missing to six digits
// A relaxation, or a part of one, that counts: what a good solution of the problem itself leaves.
constexpr double worth_naming = 1e-6;
constexpr double worth_mentioning = 1e-3;  // of the whole: beyond what rho leaves
constexpr double worth_noting = 1e-9;      // multipliers of nominal values are of order one
constexpr double most_effort = 20.0;       // times the value before: no longer the same problem
constexpr double difference_step = 1e-4;   // central differences of smooth functions: 1e-8
constexpr int most_candidates = 8, most_trials = 6, most_events = 4;
constexpr int event_trial = 2;  // intervals, of the first step of an event
// Beyond where a problem can just be met, so that its solution has room.
constexpr double margins[] = {0.01, 0.05, 0.2};

// Something that is asked for: an elastic group with where its rows stand, or where its variables
// do.
struct Asked {
  const char* kind = "term";
  std::optional<Kind> change = {};  // empty: nothing that could be changed
  int phase = 0;
  bool has_phase = true;
  std::string name;
  int component = 0;
  double unit = 1.0;  // of the term over that of the rows
  ElasticGroup group;
  std::vector<GridPoint> points;
};

bool has_side(double lower, double upper) { return lower > -infinity || upper < infinity; }

class Collector {
 public:
  explicit Collector(const ShootingProgram& program) : program_(program) {}

  std::vector<Asked> run() {
    take_terms();
    take_states();
    take_limits();
    const PhaseDefinition& first = program_.problem().phases().front();
    if (const int row = program_.closing_row(); row >= 0)
      for (int i = 0; i < first.sizes.nx; ++i) {
        Asked& asked = begin("closing", {}, 0, "closing", i);
        asked.has_phase = false;
        asked.unit = first.nominal_state[i];
        take_row(asked, row + i, {.phase = last_phase(), .node = end_of(last_phase())});
      }
    if (const int row = program_.total_time_row(); row >= 0) {
      Asked& asked = begin("total time", Kind::total_time, 0, "total time", 0);
      asked.has_phase = false;
      take_row(asked, row, {.phase = last_phase(), .node = end_of(last_phase())});
    }
    std::erase_if(all_, [](const Asked& a) { return a.points.empty(); });
    return std::move(all_);
  }

 private:
  int last_phase() const { return program_.grid().phases() - 1; }
  int end_of(int phase) const { return program_.grid().intervals(phase); }

  Asked& begin(const char* kind, std::optional<Kind> change, int phase, const std::string& name,
               int component) {
    Asked& asked = all_.emplace_back();
    asked.kind = kind;
    asked.change = change;
    asked.phase = phase;
    asked.name = name;
    asked.component = component;
    asked.group.name = fmt::format("{} '{}', row {}", kind, name, component);
    return asked;
  }
  void take_row(Asked& asked, int row, const GridPoint& point) {
    if (!has_side(program_.row_lower()[row], program_.row_upper()[row])) return;
    asked.group.rows.push_back(row);
    asked.points.push_back(point);
  }

  void take_terms() {
    for (int j = 0; j < program_.grid().phases(); ++j) {
      const PhaseDefinition& phase = program_.problem().phases()[j];
      for (std::size_t t = 0; t < phase.terms.size(); ++t) {
        const Term& term = phase.terms[t];
        if (term.kind != TermKind::constraint || term.soft) continue;
        for (int i = 0; i < term.function.outputs(); ++i) {
          Asked& asked = begin("term", Kind::term, j, term.name, i);
          for (const shooting::RowInstance& instance : program_.row_instances())
            if (instance.phase == j && instance.term == static_cast<int>(t))
              take_row(asked, instance.first_row + i, instance.block.point);
        }
      }
    }
  }

  void take_states() {
    for (int j = 0; j < program_.grid().phases(); ++j) {
      const PhaseDefinition& phase = program_.problem().phases()[j];
      for (int i = 0; i < phase.sizes.nx; ++i) {
        Asked& asked = begin("state", Kind::state, j, fmt::format("state {}", i), i);
        asked.unit = phase.nominal_state[i];
        for (int node = 0; node <= end_of(j); ++node) {
          const int v = program_.layout().state(j, node) + i;
          if (!has_side(program_.lower()[v], program_.upper()[v])) continue;
          asked.group.variables.push_back(v);
          asked.points.push_back({.phase = j, .node = node});
        }
      }
    }
  }

  void take_limits() {
    for (const shooting::LimitInstance& instance : program_.limit_instances()) {
      if (program_.limits_of(instance).soft) continue;
      const bool is_link = instance.link >= 0;
      for (int i = 0; i < instance.count; ++i) {
        const OptimalControlProblem& problem = program_.problem();
        Asked& asked =
            is_link
                ? begin("link", Kind::link, instance.phase, problem.links()[instance.link].name, i)
                : begin("integral", Kind::integral, instance.phase,
                        problem.phases()[instance.phase].integrals[instance.integral].name, i);
        asked.has_phase = !is_link;
        take_row(asked, instance.first_row + i, instance.point);
      }
    }
  }

  const ShootingProgram& program_;
  std::vector<Asked> all_;
};

std::vector<Asked> asked_of(ShootingProgram& program, const VectorXd& w) {
  std::vector<Asked> all = Collector(program).run();
  std::vector<double> entries(program.jacobian_pattern().entries());
  VectorXd steepest = VectorXd::Zero(program.rows());
  if (program.jacobian(w.data(), entries.data()))
    program.jacobian_pattern().for_each([&](int r, int, int e) {
      if (std::isfinite(entries[e])) steepest[r] = std::max(steepest[r], std::abs(entries[e]));
    });
  for (Asked& asked : all) {
    double nominal = 0.0;
    for (const int r : asked.group.rows) nominal = std::max(nominal, steepest[r]);
    asked.group.nominal = nominal > 0.0 ? nominal : 1.0;
  }
  return all;
}

// The least relaxation of a problem, with everything that it is about.
struct Relaxed {
  std::optional<MultipleShooting> shooting;
  std::vector<Asked> asked;
  std::optional<ElasticProgram> program;
  NlpResult result;
  double amount = infinity;

  bool ok() const { return is_success(result.status); }
};

// What could change, and how fast the relaxation does so.
struct Candidate {
  ProblemChange change;
  double slope = 0.0;  // of the relaxation
  double before = 0.0, scale = 1.0;

  double predicted(double relaxation) const { return -relaxation / slope; }
  double effort(double by) const { return std::abs(by) / scale; }
};

class Explainer {
 public:
  Explainer(const OptimalControlProblem& problem, const ExplainOptions& options)
      : problem_(problem), options_(options) {
    if (!options_.shooting.integrator) options_.shooting.integrator = runge_kutta4({.steps = 2});
    if (options_.time_limit > 0.0) deadline_ = seconds_after(begin_, options_.time_limit);
  }

  Explanation run() {
    relax(problem_, nullptr, relaxed_);
    if (options_.guess) {
      Relaxed other;
      relax(problem_, &*options_.guess, other);
      if (other.ok() && (!relaxed_.ok() || other.amount < relaxed_.amount - worth_naming))
        relax(problem_, &*options_.guess, relaxed_);
    }
    explanation_.status = relaxed_.result.status;
    if (relaxed_.ok()) {
      explanation_.relaxation = relaxed_.amount;
      explanation_.trajectory = relaxed_.shooting->trajectory(problem_point());
      if (relaxed_.amount > worth_naming) {
        name_shortages();
        if (options_.remedies > 0) find_remedies();
      }
    }
    explanation_.solves = solves_;
    explanation_.seconds = seconds_since(begin_);
    return std::move(explanation_);
  }

 private:
  bool is_late() const { return WallClock::now() >= deadline_; }

  std::unique_ptr<Solver> make_solver() const {
    std::unique_ptr<Solver> solver =
        options_.make_solver ? options_.make_solver() : make_sqp({.tolerance = tolerance});
    solver->set_deadline(deadline_);
    return solver;
  }

  // In place: an elastic program refers to its shooting.
  void relax(const OptimalControlProblem& problem, const Trajectory* guess, Relaxed& relaxed) {
    ++solves_;
    relaxed.program.reset();
    relaxed.shooting.emplace(problem, options_.shooting);
    ShootingProgram& program = relaxed.shooting->editable_program();
    const VectorXd own = relaxed.shooting->initial_guess().w;
    relaxed.asked = asked_of(program, own);
    std::vector<ElasticGroup> groups;
    groups.reserve(relaxed.asked.size());
    for (const Asked& asked : relaxed.asked) groups.push_back(asked.group);
    relaxed.program.emplace(program, std::move(groups), own);
    const VectorXd w = guess != nullptr ? relaxed.shooting->guess_from(*guess).w : own;
    relaxed.result = make_solver()->solve(*relaxed.program, relaxed.program->start(w), false);
    relaxed.amount = relaxed.ok() ? relaxed.program->relaxation(relaxed.result.point.w) : infinity;
  }

  VectorXd problem_point() const {
    return relaxed_.result.point.w.head(relaxed_.shooting->program().variables());
  }
  double multiplier(int row) const { return relaxed_.result.point.lambda[row]; }

  void name_shortages() {
    ShootingProgram& program = relaxed_.shooting->editable_program();
    const VectorXd w = problem_point();
    VectorXd g(program.rows());
    program.constraints(w.data(), g.data());
    const SparsityPattern& pattern = program.jacobian_pattern();
    std::vector<double> entries(pattern.entries());
    program.jacobian(w.data(), entries.data());
    const auto repeats = [&](int a, int b) {
      const int n = pattern.row_end(a) - pattern.row_begin(a);
      if (n != pattern.row_end(b) - pattern.row_begin(b) || g[a] != g[b]) return false;
      for (int i = 0; i < n; ++i)
        if (pattern.col(pattern.row_begin(a) + i) != pattern.col(pattern.row_begin(b) + i) ||
            entries[pattern.row_begin(a) + i] != entries[pattern.row_begin(b) + i])
          return false;
      return true;
    };
    std::vector<std::pair<std::string, int>> named;
    for (int k = 0; k < static_cast<int>(relaxed_.asked.size()); ++k) {
      const Asked& asked = relaxed_.asked[k];
      const std::vector<int> rows = relaxed_.program->rows_of(k);
      for (const Side side : {Side::lower, Side::upper}) {
        const double relative =
            relaxed_.result.point
                .w[side == Side::lower ? relaxed_.program->below(k) : relaxed_.program->above(k)];
        if (!(relative > std::max(worth_naming, worth_mentioning * relaxed_.amount))) continue;
        const double sign = side == Side::lower ? -1.0 : 1.0;
        std::size_t held = 0;
        for (std::size_t i = 1; i < rows.size(); ++i)
          if (sign * multiplier(rows[i]) > sign * multiplier(rows[held])) held = i;
        const bool is_row = held < asked.group.rows.size();
        const double value = is_row ? g[asked.group.rows[held]]
                                    : w[asked.group.variables[held - asked.group.rows.size()]];
        const VectorXd& sides =
            side == Side::lower ? relaxed_.program->row_lower() : relaxed_.program->row_upper();
        Shortage shortage{
            .kind = asked.kind,
            .phase = asked.has_phase ? program.problem().phases()[asked.phase].name : "",
            .term = asked.name,
            .component = asked.component,
            .side = side,
            .amount = relative * asked.group.nominal * asked.unit,
            .nominal = asked.group.nominal * asked.unit,
            .time = program.time_of(asked.points[held], &w),
            .value = value * asked.unit,
            .bound = sides[rows[held]] * asked.unit,
            .is_exact = relaxed_.program->row_lower()[rows[held]] ==
                        relaxed_.program->row_upper()[rows[held]]};
        if (!asked.change)
          can_give_ = false;
        else
          given_.push_back({*asked.change, asked.phase, asked.name, asked.component, side,
                            sign * shortage.amount});
        // A row that repeats another, as hulls of fixed size have, is named once.
        const int row = is_row ? asked.group.rows[held] : -1;
        if (row >= 0 && std::ranges::any_of(named, [&](const auto& other) {
              return other.first == asked.name && repeats(row, other.second);
            }))
          continue;
        if (row >= 0) named.emplace_back(asked.name, row);
        explanation_.shortages.push_back(std::move(shortage));
      }
    }
    std::ranges::stable_sort(explanation_.shortages, std::ranges::greater{},
                             [](const Shortage& s) { return s.amount / s.nominal; });
  }

  // --- what the multipliers say ------------------------------------------------------------------

  // Moving a bound or value by one changes the relaxation by `slope`.
  void add(ProblemChange change, double slope, double nominal) {
    if (!std::isfinite(slope) || std::abs(slope) * nominal < worth_noting) return;
    Candidate candidate{std::move(change), slope};
    candidate.before = value_before(problem_, candidate.change);
    candidate.scale = std::max(std::abs(candidate.before), 1e-3 * nominal);
    if (candidate.before == 0.0) candidate.scale = nominal;
    if (!std::isfinite(candidate.before)) return;
    candidate.change.by = candidate.predicted(relaxed_.amount);
    if (candidate.effort(candidate.change.by) <= most_effort)
      candidates_.push_back(std::move(candidate));
  }

  // Of sides: `up` holds back the upper, `down` the lower one.
  void add_sides(const ProblemChange& change, double up, double down, bool is_value,
                 double nominal) {
    ProblemChange c = change;
    c.side = Side::upper;
    if (is_value) return add(c, down - up, nominal);
    if (up * nominal > worth_noting) add(c, -up, nominal);
    c.side = Side::lower;
    if (down * nominal > worth_noting) add(c, down, nominal);
  }

  void ask_terms() {
    for (int k = 0; k < static_cast<int>(relaxed_.asked.size()); ++k) {
      const Asked& asked = relaxed_.asked[k];
      if (!asked.change) continue;
      double up = 0.0, down = 0.0;
      bool is_value = true;
      for (const int r : relaxed_.program->rows_of(k)) {
        up += std::max(multiplier(r), 0.0);
        down += std::max(-multiplier(r), 0.0);
        is_value = is_value && relaxed_.program->row_lower()[r] == relaxed_.program->row_upper()[r];
      }
      add_sides({*asked.change, asked.phase, asked.name, asked.component}, up / asked.unit,
                down / asked.unit, is_value, asked.group.nominal * asked.unit);
    }
  }

  void ask_variable(const ProblemChange& change, const std::vector<int>& variables,
                    double nominal) {
    double up = 0.0, down = 0.0;
    for (const int v : variables) {
      const double z = relaxed_.result.point.z[v];
      up += std::max(z, 0.0);
      down += std::max(-z, 0.0);
    }
    add_sides(change, up / nominal, down / nominal, false, nominal);
  }

  void ask_phases() {
    const ShootingProgram& program = relaxed_.shooting->program();
    const Layout& layout = program.layout();
    std::set<std::pair<std::string, int>> unknowns;
    for (int j = 0; j < program.grid().phases(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      std::set<int> bounded;
      for (const ComponentBounds& b : phase.input_bounds)
        if (!b.bounds.is_equality()) bounded.insert(b.component);  // what is forced stays so
      const int coefficients = program.integrators()[j]->arguments().nc;
      for (const int i : bounded) {
        std::vector<int> variables;
        for (int k = 0; k < program.grid().intervals(j); ++k)
          for (int c = i; c < coefficients; c += phase.sizes.nu)
            if (!program.grid().interval(j, k).is_empty())
              variables.push_back(layout.input(j, k) + c);
        ask_variable({Kind::input, j, {}, i}, variables, phase.nominal_input[i]);
      }
      if (layout.duration(j) >= 0)
        ask_variable({Kind::duration, j}, {layout.duration(j)}, phase.nominal_duration);
      int p = 0;
      for (const ParameterBlock& block : phase.parameters)
        for (int i = 0; i < block.value.size(); ++i, ++p)
          if (block.unknown && unknowns.insert({block.name, i}).second)
            ask_variable({Kind::parameter, j, block.name, i}, {layout.parameter(j, p)},
                         block.nominal[i]);
    }
  }

  void ask_start() {
    const ShootingProgram& program = relaxed_.shooting->program();
    const PhaseDefinition& first = problem_.phases().front();
    for (int i = 0; i < first.sizes.nx; ++i) {
      const double force = multiplier(program.start_row() + i) / first.nominal_state[i];
      add_sides({Kind::start, 0, {}, i}, std::max(force, 0.0), std::max(-force, 0.0),
                problem_.start_bounds()[i].is_equality(), first.nominal_state[i]);
    }
  }

  // Sum of multipliers times (rows - sides) at the point, with the data that are in force: its rate
  // is that of the relaxation (envelope theorem). NaN where a side is gone.
  double held() {
    ShootingProgram& program = relaxed_.shooting->editable_program();
    const VectorXd w = problem_point();
    VectorXd g(program.rows());
    if (!program.constraints(w.data(), g.data())) return std::nan("");
    double sum = 0.0;
    const auto hold = [&](double force, double value, double lower, double upper) {
      if (std::abs(force) > worth_noting) sum += force * (value - (force > 0.0 ? upper : lower));
    };
    for (int r = 0; r < program.rows(); ++r)
      hold(multiplier(r), g[r], program.row_lower()[r], program.row_upper()[r]);
    for (std::size_t k = 0; k < relaxed_.asked.size(); ++k) {
      const std::vector<int> rows = relaxed_.program->rows_of(static_cast<int>(k));
      const ElasticGroup& group = relaxed_.asked[k].group;
      for (std::size_t i = 0; i < group.variables.size(); ++i) {
        const int v = group.variables[i];
        hold(multiplier(rows[group.rows.size() + i]), w[v], program.lower()[v], program.upper()[v]);
      }
    }
    for (int v = 0; v < program.variables(); ++v)
      if (relaxed_.program->upper()[v] < infinity || relaxed_.program->lower()[v] > -infinity)
        hold(relaxed_.result.point.z[v], w[v], program.lower()[v], program.upper()[v]);
    return std::isfinite(sum) ? sum : std::nan("");
  }

  template <class Edit>
  double rate_along(double h, Edit&& edit) {
    ShootingProgram& program = relaxed_.shooting->editable_program();
    const ProblemData before = program.data();
    double ends[2] = {};
    for (const int side : {0, 1}) {
      ProblemData data = before;
      edit(data, side == 0 ? -h : h);
      try {
        program.commit(data);
        ends[side] = held();
      } catch (const DefinitionError&) {
        ends[side] = std::nan("");  // bounds would exclude one another
      }
    }
    program.commit(before);
    return (ends[1] - ends[0]) / (2.0 * h);
  }

  void ask_data() {
    std::set<std::pair<std::string, int>> seen;
    for (int j = 0; j < static_cast<int>(problem_.phases().size()); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      if (!phase.has_free_duration()) {
        const double T = phase.duration.lower;
        const double rate = rate_along(
            difference_step * T, [&](ProblemData& data, double d) { data.durations[j] += d; });
        add({Kind::duration, j}, rate, T);
      }
      for (const ParameterBlock& block : phase.parameters)
        for (int i = 0; i < block.value.size(); ++i) {
          if (block.unknown || !seen.insert({block.name, i}).second || is_late()) continue;
          const double size = std::max(std::abs(block.value[i]), 1e-2);
          const double rate = rate_along(difference_step * size, [&](ProblemData& data, double d) {
            for (std::size_t other = 0; other < problem_.phases().size(); ++other) {
              int first = 0;
              for (const ParameterBlock& b : problem_.phases()[other].parameters) {
                if (b.name == block.name && i < b.value.size())
                  data.parameters[other][first + i] += d;
                first += static_cast<int>(b.value.size());
              }
            }
          });
          add({Kind::parameter, j, block.name, i}, rate,
              std::max(std::abs(block.value[i]), block.nominal[i]));
        }
    }
  }

  // An event moves nodes and rows, so that derivatives at it are of one side only: it is tried.
  // Beyond the end of the motion it would only be out of sight.
  void ask_events() {
    const double length = event_trial * relaxed_.shooting->grid().nominal_length(0);
    const double end = explanation_.trajectory.end_time();
    int asked = 0;
    for (const Event& event : problem_.schedule().events()) {
      if (!std::isfinite(event.time) || event.time > end || ++asked > most_events) continue;
      for (const double by : {-length, length}) {
        const ProblemChange change{
            .kind = Kind::event, .name = std::string(event.name.view()), .by = by};
        if (event.time + by >= end - same_instant) continue;
        const double amount = try_change(change);
        if (amount < relaxed_.amount) add(change, (amount - relaxed_.amount) / by, length);
      }
    }
  }

  // --- carrying it out
  // -----------------------------------------------------------------------------

  bool leaves(const ProblemChange& change) const {
    return change.kind == Kind::event && problem_.schedule().time_of(change.name) + change.by >=
                                             explanation_.trajectory.end_time() - same_instant;
  }

  double try_change(const ProblemChange& change) {
    if (is_late() || leaves(change)) return infinity;
    try {
      Relaxed trial;
      relax(changed(problem_, change), &explanation_.trajectory, trial);
      return trial.amount;
    } catch (const DefinitionError&) {
      return infinity;
    }
  }

  // How far it has to move until nothing is missing, by secants; false if that leads nowhere.
  bool find_amount(Candidate& candidate) {
    ProblemChange& change = candidate.change;
    Trial before{0.0, relaxed_.amount}, failed = before;
    for (int trial = 0; trial < most_trials; ++trial) {
      const double amount = try_change(change);
      if (!std::isfinite(amount)) return false;
      if (amount <= worth_naming) {
        tighten(change, before, failed);
        return true;
      }
      if (amount >= failed.amount) return false;
      before = std::exchange(failed, {change.by, amount});
      const double step = std::clamp(secant(before, failed) / change.by, 0.02, 3.0);
      change.by *= 1.0 + 1.02 * step;
      if (candidate.effort(change.by) > most_effort) return false;
    }
    return false;
  }

  struct Trial {
    double by = 0.0, amount = 0.0;
  };
  // From the last to where nothing is missing, if it goes on like that.
  static double secant(const Trial& before, const Trial& last) {
    return -last.amount * (last.by - before.by) / (last.amount - before.amount);
  }

  // A change that is far enough may be too far: brought back to 1 % of the least.
  void tighten(ProblemChange& change, Trial before, Trial failed) {
    for (int trial = 0; trial < most_trials; ++trial) {
      const double gap = change.by - failed.by;
      if (std::abs(gap) <= margins[0] * std::abs(change.by)) return;
      double by = failed.by + 0.5 * gap;
      if (trial == 0 && failed.by == 0.0) {
        by = (1.0 - margins[0]) * change.by;  // nearly linear?
      } else if (failed.by != before.by) {
        const double estimate = failed.by + 1.005 * secant(before, failed);
        if ((estimate - failed.by) / gap < 0.95) by = estimate;
      }
      ProblemChange less = change;
      less.by = by;
      const double amount = try_change(less);
      if (amount <= worth_naming) {
        change.by = by;
        before = failed;  // the secant has served
      } else {
        before = std::exchange(failed, {by, amount});
      }
    }
  }

  // Three digits, away from zero.
  static double rounded_up(double by) {
    if (by == 0.0) return by;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(by))) - 2.0);
    return std::copysign(std::ceil(std::abs(by) / unit - 1e-9) * unit, by);
  }

  // With some room beyond what is just enough, solved.
  bool carry_out(const std::vector<ProblemChange>& changes, double effort) {
    for (const double margin : margins) {
      if (is_late()) return false;
      Remedy remedy;
      remedy.effort = effort;
      OptimalControlProblem better = problem_;
      try {
        for (ProblemChange change : changes) {
          change.by = rounded_up((1.0 + margin) * change.by);
          better = changed(better, change);
          remedy.text += (remedy.text.empty() ? "" : " and ") + saltus::describe(problem_, change);
          remedy.changes.push_back(std::move(change));
        }
        MultipleShooting shooting(better, options_.shooting);
        for (const Trajectory* guess :
             {static_cast<const Trajectory*>(nullptr), &std::as_const(explanation_.trajectory)}) {
          ++solves_;
          const std::unique_ptr<Solver> solver = make_solver();
          const Solution plan = guess != nullptr
                                    ? solve(shooting, *solver, shooting.guess_from(*guess))
                                    : solve(shooting, *solver);
          remedy.status = plan.status;
          remedy.cost = plan.cost;
          if (!plan.ok() && plan.status != SolveStatus::coarse_grid) continue;
          explanation_.remedies.push_back(std::move(remedy));
          return true;
        }
      } catch (const DefinitionError&) {
        return false;
      }
    }
    return false;
  }

  bool is_given(const ProblemChange& c) const {
    return given_.size() == 1 && given_.front().kind == c.kind && given_.front().phase == c.phase &&
           given_.front().name == c.name && given_.front().component == c.component;
  }

  void find_remedies() {
    ask_terms();
    ask_phases();
    ask_start();
    ask_data();
    ask_events();
    std::ranges::stable_sort(candidates_, {},
                             [](const Candidate& c) { return c.effort(c.change.by); });
    // What is missing itself first, while there is time; it stands last.
    if (can_give_) carry_out(given_, 0.0);
    const std::size_t given = explanation_.remedies.size();
    int tried = 0;
    for (Candidate& candidate : candidates_) {
      const auto found = static_cast<int>(explanation_.remedies.size() - given);
      if (found >= options_.remedies || tried >= most_candidates || is_late()) break;
      if (is_given(candidate.change)) continue;
      ++tried;
      if (find_amount(candidate))
        carry_out({candidate.change}, candidate.effort(candidate.change.by));
    }
    std::rotate(explanation_.remedies.begin(),
                explanation_.remedies.begin() + static_cast<std::ptrdiff_t>(given),
                explanation_.remedies.end());
  }

  OptimalControlProblem problem_;
  ExplainOptions options_;
  WallClock::time_point begin_ = WallClock::now(), deadline_ = WallClock::time_point::max();
  Relaxed relaxed_;
  Explanation explanation_;
  std::vector<ProblemChange> given_;  // what is missing, as changes
  bool can_give_ = true;
  std::vector<Candidate> candidates_;
  int solves_ = 0;
};

}  // namespace

std::string Shortage::name() const {
  const std::string place = phase.empty() ? "" : fmt::format("phase '{}', ", phase);
  if (kind == "total time") return term;
  if (kind == "closing") return fmt::format("closing, state {}", component);
  if (kind == "state") return place + "bounds of " + term;
  return fmt::format("{}{} '{}'{}", place, kind, term,
                     component > 0 ? fmt::format(", row {}", component) : "");
}

std::string Shortage::text() const {
  const bool is_low = side == Side::lower;
  return fmt::format(
      "{} cannot be met: {:.4g} too {} at t = {:.4g} s ({:.6g} where {}{:.6g} is asked)", name(),
      amount, is_low ? "little" : "much", time, value,
      is_exact ? ""
      : is_low ? "at least "
               : "at most ",
      bound);
}

std::string Explanation::text() const {
  if (!ok()) return fmt::format("the least relaxation is not known: {}\n", describe(status));
  if (shortages.empty()) return "the constraints can be met, near the guess at least\n";
  std::string text;
  for (const Shortage& shortage : shortages) text += shortage.text() + "\n";
  for (std::size_t i = 0; i < remedies.size(); ++i)
    text += (i == 0 ? "it would fit " : "          or ") + remedies[i].text + "\n";
  return text;
}

Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options) {
  return Explainer(problem, options).run();
}

std::vector<ElasticGroup> elastic_groups(MultipleShooting& shooting, const VectorXd& w) {
  std::vector<ElasticGroup> groups;
  for (Asked& asked : asked_of(shooting.editable_program(), w))
    groups.push_back(std::move(asked.group));
  return groups;
}

}  // namespace saltus
