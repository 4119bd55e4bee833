#include "saltus/ocp/phase_definition.hpp"

#include <fmt/format.h>

#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {

Guess::Guess() = default;
Guess::Guess(const Guess& other) = default;
Guess::Guess(Guess&& other) noexcept = default;
Guess& Guess::operator=(const Guess& other) = default;
Guess& Guess::operator=(Guess&& other) noexcept = default;
Guess::~Guess() = default;
Guess::Guess(std::function<VectorXd(double)> f) : trajectory_(std::move(f)) {}

Guess Guess::constant(VectorXd value) {
  return Guess([v = std::move(value)](double) { return v; });
}

Guess Guess::interpolate(VectorXd first, VectorXd last) {
  if (first.size() != last.size())
    throw DefinitionError(fmt::format(
        "guess: it has {} entries at the start and {} at the end, but needs the same number",
        first.size(), last.size()));
  return Guess([a = std::move(first), b = std::move(last)](double s) -> VectorXd {
    return a + s * (b - a);
  });
}

Guess Guess::trajectory(std::function<VectorXd(double fraction)> f) {
  if (!f) throw DefinitionError("guess: the function of the fraction is empty");
  return Guess(std::move(f));
}

VectorXd Guess::at(double fraction) const {
  if (!is_given()) throw DefinitionError("guess: no trajectory was given, so it has no value");
  return trajectory_(fraction);
}

Guess Guess::simulate() {
  Guess guess;
  guess.simulated_ = true;
  return guess;
}

}  // namespace saltus
