#include "problems/push_recovery/unmet_explanations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "problems/push_recovery/step_problem.hpp"
#include "problems/push_recovery/tick_data.hpp"

namespace saltus::push_recovery {
namespace {

using robots::walking::UnmetDecision;
using Kind = ProblemChange::Kind;

bool is_of_wrenches(const UnmetDecision& unmet) { return unmet.decision == "wrenches"; }

// "-y", or "(-0.71, 0.71)" if not along an axis.
std::string world_direction(const Vec<double, 2>& normal) {
  const Vec<double, 2> n = normal.normalized();
  constexpr double along = 0.98;  // within 11 degrees
  for (const int i : {0, 1})
    if (std::abs(n[i]) > along)
      return fmt::format("{}{}", n[i] < 0.0 ? "-" : "+", i == 0 ? 'x' : 'y');
  return fmt::format("({:.2f}, {:.2f})", n[0], n[1]);
}

// In the frame of the step problem: forward, and to the side of the foot that swings first.
std::string step_direction(double forward, double aside) {
  const char* const ahead = forward > 0.0 ? "forward" : "backward";
  const char* const beside = aside > 0.0 ? "to the swing side" : "to the stance side";
  if (aside == 0.0) return ahead;
  if (forward == 0.0) return beside;
  return fmt::format("{} and {}", ahead, beside);
}

std::optional<Vec<double, 2>> hull_normal(const OptimalControlProblem& problem, int row) {
  for (const PhaseDefinition::ParameterBlock& block : problem.phases().front().parameters)
    if (block.name == "tick" && block.value.size() == size_of<Tick> && row < hull_rows)
      return view_as<Tick>(block.value).hull_normals.row(row).transpose();
  return std::nullopt;
}

// A state of the wrench program, with the unit in which it is shown.
struct Quantity {
  const char* name;
  double factor;
  const char* unit;
};
constexpr Quantity quantities[] = {
    {"CoM", 1e3, "mm"}, {"velocity", 1.0, "m/s"}, {"angular momentum", 1.0, "Nms"}};
const Quantity& quantity(int state) { return quantities[std::clamp(state / 3, 0, 2)]; }

std::string axis(int state, double sign) {
  return fmt::format("{}{}", sign < 0.0 ? "-" : "+", "xyz"[std::clamp(state, 0, 8) % 3]);
}

std::string state_words(const Explanation::Shortage& s, int state) {
  const Quantity& q = quantity(state);
  return fmt::format("the {} would be {:.3g} {} beyond its limit towards {} at t = {:.3f} s",
                     q.name, q.factor * s.amount, q.unit,
                     axis(state, s.side == ProblemChange::Side::lower ? -1.0 : 1.0), s.time);
}

std::string hull_words(const OptimalControlProblem& problem, const Explanation::Shortage& s) {
  const std::optional<Vec<double, 2>> normal = hull_normal(problem, s.component);
  if (!normal) return {};
  return fmt::format(
      "the capture point is not in the hull of the feet at t = {:.3f} s: {:.1f} mm outside towards "
      "{}",
      s.time, 1e3 * s.amount, world_direction(*normal));
}

std::string captured_words(const Explanation::Shortage& s) {
  const double sign = s.side == ProblemChange::Side::lower ? -1.0 : 1.0;
  return fmt::format(
      "the robot is not captured: the capture point would come to rest {:.1f} mm off the soles, "
      "{}, "
      "at t = {:.3f} s",
      1e3 * s.amount, s.component == 0 ? step_direction(sign, 0.0) : step_direction(0.0, sign),
      s.time);
}

std::string speed_words(const Explanation::Shortage& s) {
  // The directions of too_far() in step_problem.cpp.
  constexpr double ways[8][2] = {{1, 0}, {-1, 0}, {0, 1},  {0, -1},
                                 {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
  const auto& way = ways[std::clamp(s.component, 0, 7)];
  return fmt::format(
      "the foot cannot swing fast enough: {:.1f} mm of its path {} would remain at t = {:.3f} s",
      1e3 * s.amount, step_direction(way[0], way[1]), s.time);
}

// State after the push, or the required shift of the verdict's limits.
std::string change_of_state(const ProblemChange& c) {
  const Quantity& q = quantity(c.component);
  const std::string by = fmt::format("{:.3g} {}", q.factor * std::abs(c.by), q.unit);
  if (c.kind == Kind::start)
    return fmt::format("if the {} had been {} further towards {}", q.name, by,
                       axis(c.component, c.by));
  return fmt::format("with the limit of the {} {} further towards {}", q.name, by,
                     axis(c.component, c.by));
}

std::string change_of_step(const OptimalControlProblem& problem, const ProblemChange& c) {
  const int i = c.component % 2;  // forward, or to the swing side
  const auto way = [&] { return i == 0 ? step_direction(c.by, 0.0) : step_direction(0.0, c.by); };
  const double percent = 100.0 * std::abs(c.by / value_before(problem, c));
  if (c.kind == Kind::start && (c.component == 2 || c.component == 3))
    return fmt::format("with a push that left the capture point {:.1f} mm further {}",
                       1e3 * std::abs(c.by), way());
  if (c.kind == Kind::input && c.component < 2)
    return fmt::format("with soles that extend {:.3g} % further {}", percent, way());
  if (c.kind == Kind::input && c.component < 4)
    return fmt::format("with {:.3g} % more torque about the CoM", percent);
  if (c.kind == Kind::state && (c.component == 4 || c.component == 5))
    return fmt::format("with {:.3g} % more angular momentum", percent);
  if (c.kind == Kind::term && c.name == "captured")
    return fmt::format("if the capture point could come to rest {:.1f} mm off the soles, {}",
                       1e3 * std::abs(c.by), way());
  return {};
}

}  // namespace

// Omits the limits that the robot already exceeds, because no plan could satisfy them.
std::vector<PhaseDefinition::ComponentBounds> PushRecoveryExplanations::limits_that_hold(
    const UnmetDecision& unmet) const {
  std::vector<PhaseDefinition::ComponentBounds> all{{2, limits_.height}};
  for (int i = 6; i < 9; ++i) all.push_back({i, between(-limits_.momentum, limits_.momentum)});
  const VectorXd& start = unmet.problem.start_guess();
  std::erase_if(all, [&](const PhaseDefinition::ComponentBounds& b) {
    return start[b.component] < b.bounds.lower || start[b.component] > b.bounds.upper;
  });
  return all;
}

OptimalControlProblem PushRecoveryExplanations::problem(const UnmetDecision& unmet) const {
  OptimalControlProblem problem = unmet.problem;
  if (is_of_wrenches(unmet)) problem.editable_phase(0).state_bounds = limits_that_hold(unmet);
  return problem;
}

std::string PushRecoveryExplanations::limits(const UnmetDecision& unmet) const {
  if (!is_of_wrenches(unmet)) return {};
  std::vector<std::string> held;
  for (const PhaseDefinition::ComponentBounds& b : limits_that_hold(unmet))
    held.push_back(
        b.component == 2
            ? fmt::format("the CoM at {:.2f} to {:.2f} m", b.bounds.lower, b.bounds.upper)
            : fmt::format("|H_{}| up to {:.3g} Nms", "xyz"[b.component - 6], b.bounds.upper));
  return held.empty() ? std::string("beyond the limits of the verdict")
                      : fmt::format("with {}", fmt::join(held, ", "));
}

bool PushRecoveryExplanations::may_change(const UnmetDecision& unmet,
                                          const ProblemChange& change) const {
  switch (change.kind) {
    case Kind::parameter:
      return false;  // measured, or derived from the feet
    case Kind::duration:
      return !is_of_wrenches(unmet);  // the horizon
    case Kind::state:
      return !is_of_wrenches(unmet);  // limits of the verdict
    default:
      return true;
  }
}

std::string PushRecoveryExplanations::of(const UnmetDecision& unmet,
                                         const Explanation::Shortage& s) const {
  if (s.kind == "state" && is_of_wrenches(unmet)) return state_words(s, s.component);
  if (s.kind != "term") return {};
  if (s.term == "capture point in hull") return hull_words(unmet.problem, s);
  if (s.term == "captured") return captured_words(s);
  if (s.term == "swing speed" || s.term == "change of the swing") return speed_words(s);
  if (s.term == "reach of the legs")
    return fmt::format(
        "the legs do not reach: the CoM is {:.1f} mm too far from the {} foot at t = {:.3f} s",
        1e3 * s.amount, s.component < reach_rows ? "landing" : "standing", s.time);
  if (s.term == "reach of the foot")
    return fmt::format("the foot would land {:.1f} mm beyond its reach at t = {:.3f} s",
                       1e3 * s.amount, s.time);
  return {};
}

std::string PushRecoveryExplanations::of(const UnmetDecision& unmet, const ProblemChange& c) const {
  if (c.kind == Kind::event && c.name == "impact")
    return fmt::format("if the foot landed {:.0f} ms {}", 1e3 * std::abs(c.by),
                       c.by < 0.0 ? "earlier" : "later");
  if (c.kind == Kind::term && c.name == "capture point in hull") {
    const std::optional<Vec<double, 2>> normal = hull_normal(unmet.problem, c.component);
    if (normal)
      return fmt::format("with a hull of the feet that reaches {:.1f} mm further towards {}",
                         1e3 * c.by, world_direction(*normal));
  }
  if (is_of_wrenches(unmet))
    return c.kind == Kind::start || c.kind == Kind::state ? change_of_state(c) : std::string();
  return change_of_step(unmet.problem, c);
}

}  // namespace saltus::push_recovery
