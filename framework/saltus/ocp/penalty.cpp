#include "saltus/ocp/term.hpp"

#include <fmt/format.h>

#include <cmath>

namespace saltus {
namespace {

bool is_positive(double number) { return number > 0.0 && std::isfinite(number); }

}  // namespace

double cost(const Penalty& penalty, double v) {
  switch (penalty.kind) {
    case Penalty::L1:
      return penalty.weight * v;
    case Penalty::L2:
      return 0.5 * penalty.weight * v * v;
    case Penalty::Huber:
      return v <= penalty.threshold
                 ? 0.5 * penalty.weight * v * v
                 : penalty.weight * penalty.threshold * (v - 0.5 * penalty.threshold);
  }
  return 0.0;
}

// Huber is the infimal convolution of L2 and L1: min over r of weight/2 r^2 + weight * threshold *
// |v - r|. The minimum is at r = v up to the threshold and at r = threshold above it. The quadratic
// part uses the free variable, so it always has curvature, and one variable serves both sides of a
// row.
Penalty::Slacks penalty_slacks(const Penalty& penalty) {
  switch (penalty.kind) {
    case Penalty::L1:
      return {{penalty.weight, false}};
    case Penalty::L2:
      return {{penalty.weight, true}};
    case Penalty::Huber:
      return {{penalty.weight * penalty.threshold, false},
              Penalty::SlackCost{penalty.weight, true}};
  }
  return {};
}

// The slope at zero is positive if every slack that can take a small violation has a linear cost.
bool is_exact(const Penalty& penalty) {
  const Penalty::Slacks slacks = penalty_slacks(penalty);
  return !slacks.side.is_quadratic && !(slacks.free && slacks.free->is_quadratic);
}

std::string describe_error(const Penalty& penalty) {
  if (!is_positive(penalty.weight))
    return fmt::format("the penalty weight '{}' is {}, expected a positive number", penalty.name,
                       penalty.weight);
  switch (penalty.kind) {
    case Penalty::L1:
    case Penalty::L2:
      return {};
    case Penalty::Huber:
      if (is_positive(penalty.threshold)) return {};
      return fmt::format("the threshold of penalty '{}' is {}, expected a positive number",
                         penalty.name, penalty.threshold);
  }
  return {};
}

}  // namespace saltus
