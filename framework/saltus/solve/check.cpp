#include "saltus/solve/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/dependent_rows.hpp"
#include "saltus/transcription/integration_failure.hpp"
#include "saltus/transcription/quantities.hpp"

namespace saltus {
namespace {

constexpr int points_per_phase = 3;
// Distance of points around the guess, as a fraction of the nominal magnitude: away from kinks and
// zeros.
constexpr double distance = 0.03;
// Exact derivatives agree to 1e-8; wrong ones differ by more than this.
constexpr double derivative_tolerance = 1e-5;
// solve() scales sizes beyond 1e2 and 1e-2; sizes another decade beyond are reported. Finite bounds
// above `huge_side` times the nominal magnitude are reported too.
constexpr double huge_side = 1e8;
constexpr double largest_size = 1e3, smallest_size = 1e-3;
// Largest number of rows whose dense band is factored quickly.
constexpr int most_rows = 6000;
constexpr double time_limit = 20.0;  // limit of the first solve, in seconds

// "t", "x0", "u1", "p2": entry i of the argument of a phase's functions.
std::string name_of_argument(int i, const Arguments& sizes) {
  if (i == 0) return "t";
  if (i <= sizes.nx) return fmt::format("x{}", i - 1);
  if (i <= sizes.nx + sizes.nu) return fmt::format("u{}", i - 1 - sizes.nx);
  return fmt::format("p{}", i - 1 - sizes.nx - sizes.nu);
}

struct NamedFunction {
  std::string name;
  Function function;
};

std::vector<NamedFunction> functions_of(const PhaseDefinition& phase) {
  std::vector<NamedFunction> all;
  const auto add = [&](const std::string& name, const Function& function) {
    if (function) all.push_back({fmt::format("phase '{}', {}", phase.name, name), function});
  };
  if (phase.switching.modes.empty()) add("the dynamics", phase.dynamics);
  for (const SwitchingSystem::Mode& mode : phase.switching.modes)
    add(fmt::format("the dynamics of mode '{}'", mode.name), mode.dynamics);
  for (const SwitchingSystem::Transition& event : phase.switching.transitions) {
    add(fmt::format("the guard of event '{}'", event.name), event.guard);
    add(fmt::format("the reset of event '{}'", event.name), event.reset);
  }
  for (const Term& term : phase.terms) add(fmt::format("term '{}'", term.name), term.function);
  return all;
}

class Checker {
 public:
  Checker(const OptimalControlProblem& problem, ShootingOptions options)
      : problem_(problem), options_(std::move(options)) {
    if (!options_.integrator) options_.integrator = runge_kutta4({.steps = 2});
  }

  std::vector<ProblemCheck::Line> run() {
    define();
    if (!shooting_) return std::move(lines_);
    guess_ = shooting_->initial_guess().w;
    find_magnitudes(*shooting_);
    const bool can_start = check_guess_values();
    check_function_derivatives();
    check_jumps();
    check_declared_bounds();
    check_scaling();
    if (can_start) {
      check_ranks();
      check_first_solve();
    }
    return std::move(lines_);
  }

 private:
  void say(const char* aspect, const std::string& complaint, const std::string& praise) {
    lines_.push_back(
        {aspect, complaint.empty() ? ProblemCheck::Verdict::good : ProblemCheck::Verdict::doubtful,
         complaint.empty() ? praise : complaint});
  }

  // Transcribes the problem if its definition is valid.
  void define() {
    std::string complaint;
    try {
      problem_.check();
      for (const std::string& warning : problem_.warnings())
        complaint += (complaint.empty() ? "" : "; ") + warning;
      shooting_.emplace(problem_, options_);
    } catch (const std::exception& error) {
      complaint = error.what();
    }
    say("definition", complaint, "phases, terms and sizes are consistent");
  }

  bool check_guess_values() {
    NonlinearProgram& nlp = shooting_->nlp();
    double cost = 0.0;
    VectorXd gradient(nlp.variables()), rows(nlp.rows());
    std::vector<double> entries(nlp.jacobian_pattern().entries());
    std::string complaint;
    if (!nlp.constraints(guess_.data(), rows.data()) ||
        !nlp.jacobian(guess_.data(), entries.data())) {
      const std::string where = describe_integration_failure(shooting_->program(), guess_);
      complaint = where.empty() ? function_without_value() : where;
      if (complaint.empty()) complaint = "the constraints cannot be evaluated";
    } else if (!nlp.objective(guess_.data(), cost) ||
               !nlp.gradient(guess_.data(), gradient.data()) || !std::isfinite(cost)) {
      complaint = function_without_value();
      if (complaint.empty()) complaint = "the cost cannot be evaluated";
    } else if (!gradient.allFinite()) {
      complaint = function_without_value();
      if (complaint.empty()) complaint = "the cost has a derivative that is not finite";
    }
    for (int r = 0; r < nlp.rows() && complaint.empty(); ++r)
      if (!std::isfinite(rows[r])) complaint = nlp.describe_row(r) + " is not finite";
    if (complaint.empty())
      nlp.jacobian_pattern().for_each([&](int r, int, int e) {
        if (complaint.empty() && !std::isfinite(entries[e]))
          complaint = nlp.describe_row(r) + " has a derivative that is not finite";
      });
    const bool is_good = complaint.empty();
    say("start", is_good ? "" : complaint + ": at the guess (guess_state, guess_input, start_at)",
        "all formulas and their derivatives are finite at the guess");
    return is_good;
  }

  // The first formula without a finite value at the guess; empty if none.
  std::string function_without_value() const {
    for (std::size_t j = 0; j < problem_.phases().size(); ++j)
      for (const VectorXd& z : points_of(static_cast<int>(j), 0.0))
        for (const NamedFunction& f : functions_of(problem_.phases()[j])) {
          if (f.function.inputs() != z.size()) continue;
          if (!f.function(z).allFinite()) return f.name + " has no finite value";
          if (!f.function.dense_jacobian(z).allFinite())
            return f.name + " has a derivative that is not finite";
        }
    return {};
  }

  // Magnitudes of the arguments (t | x | u | p), per phase: nominal ones or, if none are declared,
  // those of the guess if they are small. Large ones are part of the values.
  void find_magnitudes(MultipleShooting& shooting) {
    ProgramSize size(shooting.nlp(), undeclared_quantities(shooting.program()));
    size.look_at(guess_);
    const VectorXd unit = size.to_one().variables;
    const Layout& layout = shooting.layout();
    const Trajectory guess = shooting.trajectory(guess_);
    const auto magnitude = [](double nominal, double told) {
      return !is_declared(nominal) && told > 0.0 ? std::min(1.0, told) : nominal;
    };
    for (int j = 0; j < static_cast<int>(problem_.phases().size()); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      const Arguments& sizes = phase.sizes;
      VectorXd m(sizes.size());
      m[0] = magnitude(1.0, guess.end_time() - guess.start_time());
      for (int i = 0; i < sizes.nx; ++i)
        m[sizes.x(i)] = magnitude(phase.nominal_state[i], 1.0 / unit[layout.state(j, 0) + i]);
      for (int i = 0; i < sizes.nu; ++i)
        m[sizes.u(i)] = magnitude(phase.nominal_input[i], 1.0 / unit[layout.input(j, 0) + i]);
      for (int i = 0; i < sizes.np; ++i)
        m[sizes.p(i)] =
            magnitude(phase.nominal_parameter(i), std::abs(guess.phases()[j].parameters[i]));
      magnitudes_.push_back(std::move(m));
    }
  }

  // Arguments (t | x | u | p) along the guess of a phase.
  std::vector<VectorXd> points_of(int phase, double away) const {
    const PhaseDefinition& definition = problem_.phases()[phase];
    const Trajectory guess = shooting_->trajectory(guess_);
    std::vector<const Trajectory::Piece*> pieces;
    for (const Trajectory::Piece& piece : guess.pieces())
      if (piece.phase == phase) pieces.push_back(&piece);
    std::vector<VectorXd> points;
    const VectorXd& magnitudes = magnitudes_[phase];
    Random random(7);
    const auto noise = [&](int i) { return away * random.uniform(-1.0, 1.0) * magnitudes[i]; };
    for (int k = 0; k < points_per_phase && !pieces.empty(); ++k) {
      const Trajectory::Piece& piece = *pieces[pieces.size() * k / points_per_phase];
      const Arguments& sizes = definition.sizes;
      VectorXd z(1 + sizes.nx + sizes.nu + sizes.np);
      z[0] = piece.start + noise(0);
      for (int i = 0; i < sizes.nx; ++i) z[1 + i] = piece.state[i] + noise(1 + i);
      for (int i = 0; i < sizes.nu; ++i)
        z[1 + sizes.nx + i] = piece.coefficients[i] + noise(1 + sizes.nx + i);
      z.tail(sizes.np) = guess.phases()[phase].parameters;
      points.push_back(std::move(z));
    }
    return points;
  }

  // Records the first entry that is wrong at two points. Steps stay short for large magnitudes: an
  // atmosphere of 7 km lies above a radius of 6000 km.
  static void compare(const NamedFunction& f, const std::vector<VectorXd>& points,
                      const VectorXd& magnitudes, const Arguments& sizes, std::string& derivatives,
                      std::string& sparsity) {
    std::map<std::tuple<bool, int, int>, int> wrong;  // second, row, col: number of points
    int evaluated = 0;
    for (const VectorXd& z : points) {
      if (f.function.inputs() != z.size() || !f.function(z).allFinite()) continue;
      ++evaluated;
      const DerivativeReport report = check_derivatives(
          f.function, z,
          {.tolerance = derivative_tolerance, .magnitudes = magnitudes.cwiseMin(1.0)});
      const auto take = [&](const DerivativeReport::Entry& e, bool second) {
        // A single point may be close to a kink.
        if (++wrong[{second, e.row, e.col}] < std::min(2, evaluated) ||
            !std::isfinite(e.difference))
          return;
        const std::string column = name_of_argument(e.col, sizes);
        const std::string what = second ? fmt::format("the second derivative by {} and {}",
                                                      name_of_argument(e.row, sizes), column)
                                        : fmt::format("d (row {}) / d {}", e.row, column);
        if (!e.in_pattern && sparsity.empty())
          sparsity =
              fmt::format("{}: {} is {:.6g}, but not in the pattern", f.name, what, e.difference);
        if (e.in_pattern && derivatives.empty())
          derivatives = fmt::format("{}: {} is {:.6g}, differences give {:.6g}", f.name, what,
                                    e.exact, e.difference);
      };
      for (const DerivativeReport::Entry& entry : report.jacobian_failures) take(entry, false);
      for (const DerivativeReport::Entry& entry : report.hessian_failures) take(entry, true);
    }
  }

  void check_function_derivatives() {
    std::string derivatives, sparsity;
    int functions = 0;
    for (std::size_t j = 0; j < problem_.phases().size(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      const std::vector<VectorXd> points = points_of(static_cast<int>(j), distance);
      for (const NamedFunction& f : functions_of(phase)) {
        ++functions;
        compare(f, points, magnitudes_[j], phase.sizes, derivatives, sparsity);
      }
    }
    say("derivatives", derivatives,
        fmt::format("{} functions agree with differences to {:g}", functions,
                    derivative_tolerance));
    say("sparsity", sparsity, "no function has a derivative outside its pattern");
  }

  // Arguments (t | x- | p) of a jump out of a phase, near the end of its guess.
  std::vector<VectorXd> ends_of(int phase, const Jump& jump, double away) const {
    const Trajectory guess = shooting_->trajectory(guess_);
    const Trajectory::Piece* last = nullptr;
    for (const Trajectory::Piece& piece : guess.pieces())
      if (piece.phase == phase) last = &piece;
    std::vector<VectorXd> points;
    const VectorXd& magnitudes = magnitudes_[phase];
    Random random(11);
    for (int k = 0; k < points_per_phase && last != nullptr; ++k) {
      VectorXd x = last->end_state;
      for (int i = 0; i < x.size(); ++i)
        x[i] += away * random.uniform(-1.0, 1.0) * magnitudes[1 + i];
      const double t =
          last->start + last->length + away * random.uniform(-1.0, 1.0) * magnitudes[0];
      points.push_back(jump.argument(t, x, guess.phases()[phase].parameters));
    }
    return points;
  }

  // Magnitudes of the arguments of a jump out of a phase.
  VectorXd magnitudes_of(int phase, const Jump& jump) const {
    const Arguments& sizes = problem_.phases()[phase].sizes;
    const VectorXd& m = magnitudes_[phase];
    return jump.argument(m[0], m.segment(1, sizes.nx), m.tail(sizes.np));
  }

  // Checks jumps between phases, the closing, and resets where their guards are closest to zero
  // along the guess.
  void check_jumps() {
    std::string complaint;
    int maps = 0;
    const auto look = [&](const Jump& jump, int from, const char* kind) {
      if (!jump.map) return;
      ++maps;
      const PhaseDefinition& phase = problem_.phases()[from];
      const NamedFunction f{fmt::format("{} '{}' out of phase '{}'", kind, jump.name, phase.name),
                            jump.map};
      const std::vector<VectorXd> at_the_end = ends_of(from, jump, 0.0);
      if (complaint.empty() && !at_the_end.empty()) complaint = finite_at(f, at_the_end.front());
      Arguments sizes = phase.sizes;
      sizes.nu = 0;
      std::string derivatives, sparsity;
      compare(f, ends_of(from, jump, distance), magnitudes_of(from, jump), sizes, derivatives,
              sparsity);
      if (complaint.empty()) complaint = derivatives.empty() ? sparsity : derivatives;
    };
    for (std::size_t j = 1; j < problem_.phases().size(); ++j)
      look(problem_.jumps()[j], static_cast<int>(j) - 1, "jump");
    if (problem_.closing())
      look(*problem_.closing(), static_cast<int>(problem_.phases().size()) - 1, "closing");
    for (std::size_t j = 0; j < problem_.phases().size(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      const std::vector<VectorXd> points = points_of(static_cast<int>(j), 0.0);
      for (const SwitchingSystem::Transition& event : phase.switching.transitions) {
        if (!event.reset) continue;
        ++maps;
        const VectorXd* nearest = nullptr;
        double least = infinity;
        for (const VectorXd& z : points) {
          if (event.guard.inputs() != z.size() || event.reset.inputs() != z.size()) continue;
          const double distance_to_event = std::abs(event.guard(z)[0]);
          if (distance_to_event < least) {
            least = distance_to_event;
            nearest = &z;
          }
        }
        if (complaint.empty() && nearest != nullptr)
          complaint =
              finite_at({fmt::format("phase '{}', the reset of event '{}'", phase.name, event.name),
                         event.reset},
                        *nearest);
      }
    }
    say("jumps", complaint,
        maps == 0
            ? "no jump changes the state"
            : fmt::format("{} state maps checked: finite, in agreement with differences", maps));
  }

  // An error message, or an empty string.
  static std::string finite_at(const NamedFunction& f, const VectorXd& z) {
    if (!f.function(z).allFinite()) return f.name + " has no finite value at the guess";
    if (!f.function.dense_jacobian(z).allFinite())
      return f.name + " has a derivative that is not finite at the guess";
    return {};
  }

  void check_declared_bounds() {
    std::string complaint;
    const PhaseDefinition& first = problem_.phases().front();
    for (const PhaseDefinition::ComponentBounds& bounded : first.state_bounds) {
      const Bounds& start = problem_.start_bounds()[bounded.component];
      if (bounded.window.is_whole() && complaint.empty() &&
          (start.lower > bounded.bounds.upper || start.upper < bounded.bounds.lower))
        complaint = fmt::format(
            "state {} starts at {:.6g}, but phase '{}' keeps it within [{:.6g}, {:.6g}]",
            bounded.component, start.lower, first.name, bounded.bounds.lower, bounded.bounds.upper);
    }
    const NonlinearProgram& nlp = shooting_->nlp();
    for (int i = 0; i < nlp.variables() && complaint.empty(); ++i)
      if (nlp.lower()[i] > nlp.upper()[i])
        complaint = nlp.describe_variable(i) + ": its lower bound exceeds its upper bound";
    for (int r = 0; r < nlp.rows() && complaint.empty(); ++r)
      if (nlp.row_lower()[r] > nlp.row_upper()[r])
        complaint = nlp.describe_row(r) + ": its lower bound exceeds its upper bound";
    if (complaint.empty()) complaint = huge_bound();
    say("bounds", complaint, "all bounds are consistent, and the start is within them");
  }

  // The first finite bound that seems to mean infinity; empty if none.
  std::string huge_bound() const {
    std::string complaint;
    const auto look = [&](const Bounds& b, double magnitude, const auto& describe) {
      for (const double side : {b.lower, b.upper})
        if (complaint.empty() && std::isfinite(side) &&
            std::abs(side) >= huge_side * std::max(1.0, magnitude))
          complaint = fmt::format(
              "{} has a bound of {:g}: leave out a bound that is never active (unbounded(), "
              "at_least(), "
              "at_most()), or declare the nominal magnitude of such a large quantity",
              describe(), side);
    };
    for (const PhaseDefinition& phase : problem_.phases()) {
      const auto of_phase = [&](const std::string& what) {
        return fmt::format("phase '{}', {}", phase.name, what);
      };
      for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds)
        look(b.bounds, phase.nominal_state[b.component],
             [&] { return of_phase(fmt::format("state {}", b.component)); });
      for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds)
        look(b.bounds, phase.nominal_input[b.component],
             [&] { return of_phase(fmt::format("input {}", b.component)); });
      for (const Term& term : phase.terms)
        for (std::size_t i = 0; i < term.bounds.size(); ++i)
          look(term.bounds[i], 1.0,
               [&] { return of_phase(fmt::format("term '{}', row {}", term.name, i)); });
      for (const IntegralConstraint& integral : phase.integrals)
        for (const Bounds& b : integral.limits.bounds)
          look(b, integral.magnitude,
               [&] { return of_phase(fmt::format("integral '{}'", integral.name)); });
      for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
        for (std::size_t i = 0; i < block.bounds.size(); ++i)
          look(block.bounds[i], block.nominal[static_cast<int>(i)],
               [&] { return of_phase(fmt::format("unknown '{}', entry {}", block.name, i)); });
      look(phase.duration, phase.nominal_duration, [&] { return of_phase("duration"); });
    }
    for (const Link& link : problem_.links())
      for (const Bounds& b : link.limits.bounds)
        look(b, 1.0, [&] { return fmt::format("link '{}'", link.name); });
    const PhaseDefinition& first = problem_.phases().front();
    for (std::size_t i = 0; i < problem_.start_bounds().size(); ++i)
      if (!problem_.start_bounds()[i].is_equality())
        look(problem_.start_bounds()[i], first.nominal_state[static_cast<int>(i)],
             [&] { return fmt::format("the start of state {}", i); });
    look(problem_.total_time(), 1.0, [] { return std::string("the total time"); });
    if (problem_.start_time_bounds())
      look(*problem_.start_time_bounds(), 1.0, [] { return std::string("the start time"); });
    return complaint;
  }

  void check_scaling() {
    std::string complaint;
    const NonlinearProgram& nlp = shooting_->nlp();
    for (const std::vector<int>& quantity : undeclared_quantities(shooting_->program())) {
      double size = 0.0;
      for (const int i : quantity) size = std::max(size, std::abs(guess_[i]));
      if (size == 0.0)
        for (const int i : quantity)
          for (const double bound : {nlp.lower()[i], nlp.upper()[i]})
            if (std::isfinite(bound)) size = std::max(size, std::abs(bound));
      if (complaint.empty() && (size > largest_size || (size > 0.0 && size < smallest_size)))
        complaint = fmt::format(
            "{} and similar variables are about {:.1g}, without a nominal magnitude: nominal(...)",
            nlp.describe_variable(quantity.front()), size);
    }
    say("scaling", complaint, "variables without a nominal magnitude are well scaled");
  }

  void check_ranks() {
    const NonlinearProgram& nlp = shooting_->nlp();
    if (nlp.rows() > most_rows) {
      lines_.push_back(
          {"ranks", ProblemCheck::Verdict::unknown,
           fmt::format("{} rows are too many to factor; use fewer intervals", nlp.rows())});
      return;
    }
    // At a point without symmetry, because a dependency found there holds everywhere.
    VectorXd w = guess_;
    Random random(3);
    for (int i = 0; i < w.size(); ++i) {
      const double moved =
          w[i] + distance * std::max(1.0, std::abs(w[i])) * random.uniform(-1.0, 1.0);
      w[i] = std::clamp(moved, std::min(nlp.lower()[i], nlp.upper()[i]), nlp.upper()[i]);
    }
    say("ranks", describe_dependent_rows(shooting_->editable_program(), w),
        "all equations are independent");
  }

  void check_first_solve() {
    const std::unique_ptr<Solver> solver = make_native_solver({.time_limit = time_limit});
    const Solution plan = solve(*shooting_, *solver);
    const GridAccuracy& wanted = options_.accuracy;
    const bool is_known = plan.verification.has_value();
    const Verification::Defect defect =
        is_known ? plan.verification->defect : Verification::Defect{};
    const std::string off = fmt::format(
        "integration error {:.1g} of the states' magnitude along a first solution", defect.sum);
    std::string coarse;
    if (!(defect.sum <= wanted.integration && defect.largest <= wanted.defect))
      coarse = fmt::format(
          "{}, largest in phase '{}' at t = {:.4g} s: use more intervals, or an integrator "
          "suited to such dynamics",
          off, defect.phase, defect.time);
    say("integration", coarse, is_known ? off : "not verified");
    const bool is_known_failure =
        plan.status == SolveStatus::infeasible || plan.status == SolveStatus::invalid_problem ||
        plan.status == SolveStatus::unbounded || plan.status == SolveStatus::coarse_grid ||
        plan.status == SolveStatus::wrong_crossing;
    lines_.push_back({"reach",
                      plan.ok()          ? ProblemCheck::Verdict::good
                      : is_known_failure ? ProblemCheck::Verdict::doubtful
                                         : ProblemCheck::Verdict::unknown,
                      plan.ok() ? fmt::format("a first solve meets the constraints after {} "
                                              "iterations",
                                              plan.iterations)
                                : plan.message});
  }

  const OptimalControlProblem& problem_;
  ShootingOptions options_;
  std::optional<MultipleShooting> shooting_;
  VectorXd guess_;
  std::vector<VectorXd> magnitudes_;  // magnitudes of the arguments of each phase
  std::vector<ProblemCheck::Line> lines_;
};

const char* describe(ProblemCheck::Verdict verdict) {
  switch (verdict) {
    case ProblemCheck::Verdict::good:
      return "good";
    case ProblemCheck::Verdict::doubtful:
      return "DOUBTFUL";
    case ProblemCheck::Verdict::unknown:
      return "unknown";
  }
  return "unknown";
}

}  // namespace

bool ProblemCheck::ok() const {
  return std::ranges::none_of(lines, [](const ProblemCheck::Line& line) {
    return line.verdict == ProblemCheck::Verdict::doubtful;
  });
}

const ProblemCheck::Line& ProblemCheck::line(const std::string& aspect) const {
  const auto found = std::ranges::find(lines, aspect, &ProblemCheck::Line::aspect);
  if (found == lines.end())
    throw DefinitionError(fmt::format("the check of '{}' has no line '{}'", problem, aspect));
  return *found;
}

std::string ProblemCheck::text() const {
  std::string text = problem + "\n";
  for (const ProblemCheck::Line& line : lines)
    text += fmt::format("  {:<12} {:<9} {}\n", line.aspect, describe(line.verdict), line.text);
  return text;
}

ProblemCheck check(const OptimalControlProblem& problem, ShootingOptions options) {
  return {problem.name(), Checker(problem, std::move(options)).run()};
}

}  // namespace saltus
