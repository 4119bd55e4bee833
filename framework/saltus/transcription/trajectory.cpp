#include "saltus/transcription/solution.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <tuple>
#include <utility>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"

namespace saltus {

namespace {
// Tolerance for equal times, a few units in the last place. Ends and starts of neighbours sum
// durations in a different order, as do times of callers. The tolerance is not larger, because
// clocks may count from an epoch while intervals last milliseconds.
double rounding(double t) {
  if (std::isinf(t)) return 0.0;
  return std::max(1e-12, 4.0 * std::numeric_limits<double>::epsilon() * std::abs(t));
}

// Throws for NaN, unless the times of the plan are NaN themselves; `last` is its last piece.
void check_time(double t, const Trajectory::Piece& last) {
  if (std::isnan(t) && !std::isnan(last.end()))
    throw DefinitionError("trajectory: the given time is NaN");
}

const std::vector<Trajectory::Piece>& checked(const std::vector<Trajectory::Piece>& pieces) {
  if (pieces.empty())
    throw DefinitionError(
        "trajectory: it is empty (never filled, moved from, or from a solve without a plan); check "
        "empty() first");
  return pieces;
}
}  // namespace

Trajectory::Trajectory(std::vector<PhaseInfo> phases, std::vector<Trajectory::Piece> pieces)
    : phases_(std::move(phases)), pieces_(std::move(pieces)) {
  for (const PhaseInfo& phase : phases_) {
    if (!phase.integrator)
      throw DefinitionError(fmt::format("trajectory: phase '{}' has no integrator", phase.name));
    if (const int np = phase.integrator->arguments().np; phase.parameters.size() != np)
      throw DefinitionError(fmt::format("trajectory: phase '{}' has {} parameters, expected {}",
                                        phase.name, phase.parameters.size(), np));
  }
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Trajectory::Piece& piece = pieces_[k];
    if (piece.phase < 0 || piece.phase >= static_cast<int>(phases_.size()))
      throw DefinitionError(
          fmt::format("trajectory: piece {} refers to phase {}, but there are {} phases", k,
                      piece.phase, phases_.size()));
    const IntervalArguments a = phases_[piece.phase].integrator->arguments();
    for (const auto& [what, given, expected] : {std::tuple{"state", piece.state.size(), a.nx},
                                                {"end state", piece.end_state.size(), a.nx},
                                                {"input", piece.coefficients.size(), a.nc}})
      if (given != expected)
        throw DefinitionError(
            fmt::format("trajectory: piece {} of phase '{}' has {} entries of its {}, expected {}",
                        k, phases_[piece.phase].name, given, what, expected));
  }
}

Trajectory::Trajectory() = default;
Trajectory::Trajectory(const Trajectory& other) = default;
Trajectory::Trajectory(Trajectory&& other) noexcept = default;
Trajectory& Trajectory::operator=(const Trajectory& other) = default;
Trajectory& Trajectory::operator=(Trajectory&& other) noexcept = default;
Trajectory::~Trajectory() = default;

double Trajectory::start_time() const { return checked(pieces_).front().start; }
double Trajectory::end_time() const { return checked(pieces_).back().end(); }
const VectorXd& Trajectory::final_state() const { return checked(pieces_).back().end_state; }

const Trajectory::PhaseInfo& Trajectory::phase_of(const Trajectory::Piece& piece) const {
  if (piece.phase < 0 || piece.phase >= static_cast<int>(phases_.size()))
    throw DefinitionError(
        fmt::format("trajectory: the piece of phase {} is not one of its pieces; it has {} phases",
                    piece.phase, phases_.size()));
  return phases_[piece.phase];
}

const Trajectory::Piece& Trajectory::piece_at(double t) const {
  check_time(t, checked(pieces_).back());
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), t + rounding(t),
                                      [](double time, const auto& p) { return time < p.start; });
  return after == pieces_.begin() ? pieces_.front() : *(after - 1);
}

VectorXd Trajectory::input_in(const Trajectory::Piece& piece, double t) const {
  check_time(t, piece);
  const IntervalProblem& problem = phase_of(piece).integrator->problem();
  const int nu = problem.arguments.nu;
  if (problem.shape == InputShape::constant) return piece.coefficients;
  const double s =
      piece.length > 0.0 ? std::clamp((t - piece.start) / piece.length, 0.0, 1.0) : 0.0;
  return (1.0 - s) * piece.coefficients.head(nu) + s * piece.coefficients.tail(nu);
}

VectorXd Trajectory::state_in(const Trajectory::Piece& piece, double t) const {
  check_time(t, piece);
  const PhaseInfo& phase = phase_of(piece);
  if (t <= piece.start) return piece.state;
  if (t >= piece.end()) return piece.end_state;
  const ReentrantIntegrator& integrator = *phase.integrator;
  const IntervalArguments a = integrator.arguments();
  const int nu = integrator.problem().arguments.nu;
  VectorXd w(a.size());
  w.segment(a.x(), a.nx) = piece.state;
  w.segment(a.c(), a.nc) = piece.coefficients;
  if (integrator.problem().shape == InputShape::linear)
    w.segment(a.c(nu), nu) = input_in(piece, t);  // the ramp up to t only
  w.segment(a.p(), a.np) = phase.parameters;
  w[a.t0()] = piece.start;
  w[a.h()] = t - piece.start;
  VectorXd end(integrator.outputs());
  if (integrator.value(w.data(), end.data()) != IntegrationStatus::success)
    return VectorXd::Constant(a.nx, std::numeric_limits<double>::quiet_NaN());
  return end.head(a.nx);
}

VectorXd Trajectory::state(double t) const { return state_in(piece_at(t), t); }
VectorXd Trajectory::state_before(double t) const {
  check_time(t, checked(pieces_).back());
  const auto piece = std::lower_bound(pieces_.begin(), pieces_.end(), t - rounding(t),
                                      [](const auto& p, double time) { return p.end() < time; });
  return state_in(piece == pieces_.end() ? pieces_.back() : *piece, t);
}
VectorXd Trajectory::input(double t) const { return input_in(piece_at(t), t); }

VectorXd Trajectory::algebraic(double t) const { return algebraic_in(piece_at(t), t); }

VectorXd Trajectory::algebraic_in(const Trajectory::Piece& piece, double t) const {
  const PhaseInfo& phase = phase_of(piece);
  const IntervalProblem& problem = phase.integrator->problem();
  if (!problem.algebraic) return {};
  VectorXd argument(problem.arguments.size());
  argument << t, state_in(piece, t), input_in(piece, t), phase.parameters;
  return algebraic_states(problem.algebraic.equations)(argument);
}

Trajectory Trajectory::after(int phases) const {
  if (phases < 0 || phases >= static_cast<int>(phases_.size()))
    throw DefinitionError(fmt::format(
        "trajectory: it has {} phases, so none remains after removing {}", phases_.size(), phases));
  Trajectory rest;
  rest.phases_.assign(phases_.begin() + phases, phases_.end());
  for (const Trajectory::Piece& piece : pieces_)
    if (piece.phase >= phases) {
      rest.pieces_.push_back(piece);
      rest.pieces_.back().phase -= phases;
    }
  return rest;
}

void Trajectory::write_csv(std::ostream& out, int samples_per_interval) const {
  int nx = 0, nu = 0, nz = 0;
  for (const PhaseInfo& phase : phases_) {
    nx = std::max(nx, phase.integrator->problem().arguments.nx);
    nu = std::max(nu, phase.integrator->problem().arguments.nu);
    if (const AlgebraicPart& algebraic = phase.integrator->problem().algebraic)
      nz = std::max(nz, algebraic.equations->count());
  }
  std::vector<std::string> columns{"t", "phase"};
  for (const auto& [letter, count] : {std::pair{"x", nx}, {"u", nu}, {"z", nz}})
    for (int i = 0; i < count; ++i) columns.push_back(fmt::format("{}{}", letter, i));
  CsvTable table(columns);
  const auto add = [&](const VectorXd& v, int count) {
    table.numbers({v.data(), static_cast<std::size_t>(v.size())}, count);
  };
  const int samples = std::max(1, samples_per_interval);
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Trajectory::Piece& piece = pieces_[k];
    const bool closes = k + 1 == pieces_.size() || pieces_[k + 1].phase != piece.phase;
    for (int s = 0; s < samples + (closes ? 1 : 0); ++s) {
      const double t = s == samples ? piece.end() : piece.start + piece.length * s / samples;
      table.number(t).word(phases_[piece.phase].name);
      add(state_in(piece, t), nx);
      add(input_in(piece, t), nu);
      add(algebraic_in(piece, t), nz);
      table.end_row();
    }
  }
  out << table.text();
}

}  // namespace saltus
