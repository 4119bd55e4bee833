// Lets std::visit take one lambda per alternative of a variant.
#pragma once

namespace saltus {

template <class... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
/// Deduces the types of the lambdas.
template <class... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

}  // namespace saltus
