#include "saltus/autodiff/expression_graph.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace saltus::detail {
namespace {

constexpr int one = 0;  // node of the number 1

Product product_of(const Scaled& a, const Scaled& b) {
  return {a.scale * b.scale, std::max(a.node, b.node), std::min(a.node, b.node)};
}
Product linear(const Scaled& a) { return {a.scale, a.node, one}; }
Scaled scaled(double scale, const Scaled& a) { return {scale * a.scale, a.node}; }

bool precedes(const Product& p, const Product& q) {
  return std::pair(p.a, p.b) < std::pair(q.a, q.b);
}

}  // namespace

double evaluate(Elementary function, double parameter, double a, double b) {
  switch (function) {
    case Elementary::none:
      break;
    case Elementary::inverse:
      return 1.0 / a;
    case Elementary::inverse_or_zero:
      return std::abs(a) <= parameter ? 0.0 : 1.0 / a;
    case Elementary::sin:
      return std::sin(a);
    case Elementary::cos:
      return std::cos(a);
    case Elementary::tan:
      return std::tan(a);
    case Elementary::asin:
      return std::asin(a);
    case Elementary::acos:
      return std::acos(a);
    case Elementary::atan:
      return std::atan(a);
    case Elementary::sinh:
      return std::sinh(a);
    case Elementary::cosh:
      return std::cosh(a);
    case Elementary::tanh:
      return std::tanh(a);
    case Elementary::exp:
      return std::exp(a);
    case Elementary::log:
      return std::log(a);
    case Elementary::sqrt:
      return std::sqrt(a);
    case Elementary::abs:
      return std::abs(a);
    case Elementary::sign:
      return a > 0.0 ? 1.0 : (a < 0.0 ? -1.0 : 0.0);
    case Elementary::power:
      return std::pow(a, parameter);
    case Elementary::power_or_zero:
      return a == 0.0 && parameter < 0.0 ? 0.0 : std::pow(a, parameter);
    case Elementary::atan2:
      return std::atan2(a, b);
    case Elementary::hypot:
      return std::hypot(a, b);
  }
  return 0.0;
}

std::size_t ExpressionGraph::Hash::operator()(const ExpressionNode& node) const {
  std::uint64_t hash = 0x9e3779b97f4a7c15u;
  const auto mix = [&hash](std::uint64_t value) {
    hash = (hash ^ value) * 0xff51afd7ed558ccdu;
    hash ^= hash >> 32;
  };
  const auto index = [](int of) { return static_cast<std::uint64_t>(of) + 1; };  // -1: none
  mix(index(node.input));
  mix(static_cast<std::uint64_t>(node.function));
  mix(std::bit_cast<std::uint64_t>(node.parameter + 0.0));
  mix(index(node.a) << 32 | index(node.b));
  for (const Product& p : node.sum) {
    mix(std::bit_cast<std::uint64_t>(p.scale + 0.0));
    mix(static_cast<std::uint64_t>(p.a) << 32 | static_cast<std::uint64_t>(p.b));
  }
  return static_cast<std::size_t>(hash);
}

ExpressionGraph::ExpressionGraph() { add({.sum = {}}); }

int ExpressionGraph::add(ExpressionNode node) {
  const auto [at, is_new] = known_.try_emplace(std::move(node), size());
  if (is_new) nodes_.push_back(at->first);
  return at->second;
}

Scaled ExpressionGraph::input(int index) { return {1.0, add({.input = index, .sum = {}})}; }

int ExpressionGraph::constant(double value) {
  return value == 1.0 ? one : add({.sum = {{value, one, one}}});
}

Scaled ExpressionGraph::sum(std::vector<Product> products) {
  std::stable_sort(products.begin(), products.end(), precedes);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < products.size();) {
    Product merged = products[i];
    for (++i; i < products.size() && !precedes(merged, products[i]); ++i)
      merged.scale += products[i].scale;
    if (merged.scale != 0.0) products[kept++] = merged;
  }
  products.resize(kept);
  if (products.empty()) return {};
  if (products.size() == 1) {
    const double scale = products[0].scale;
    if (products[0].b == one) return {scale, products[0].a};
    products[0].scale = 1.0;
    return {scale, add({.sum = std::move(products)})};
  }
  return {1.0, add({.sum = std::move(products)})};
}

Scaled ExpressionGraph::product(const Scaled& a, const Scaled& b) {
  return sum({product_of(a, b)});
}

Scaled ExpressionGraph::apply(Elementary function, const Scaled& a, const Scaled& b,
                              double parameter) {
  if (a.is_constant() && (b.node < 0 || b.is_constant()))
    return {evaluate(function, parameter, a.scale, b.scale), one};
  const int first = node_of(a), second = b.node < 0 ? -1 : node_of(b);
  return {1.0,
          add({.function = function, .parameter = parameter, .a = first, .b = second, .sum = {}})};
}

int ExpressionGraph::node_of(const Scaled& a) {
  if (a.is_constant()) return constant(a.scale);
  return a.scale == 1.0 ? a.node : add({.sum = {linear(a)}});
}

Scaled ExpressionGraph::power(const Scaled& a, double exponent, bool or_zero) {
  if (exponent == 0.0) return {1.0, one};
  if (exponent == 1.0) return a;
  if (exponent == 2.0) return product(a, a);
  return apply(or_zero ? Elementary::power_or_zero : Elementary::power, a, {1.0, -1}, exponent);
}

std::vector<int> ExpressionGraph::append(const FormulaSteps& formula) {
  const std::vector<FormulaStep>& steps = formula.steps;
  std::vector<int> uses(steps.size(), 0);
  for (const FormulaStep& s : steps)
    for (const int argument : {s.a, s.b, s.c})
      if (argument >= 0) ++uses[argument];
  for (const int output : formula.outputs) uses[output] += 2;  // never absorbed

  // Each step is a sum of products until something other than a sum uses it.
  std::vector<std::vector<Product>> sums(steps.size());
  const auto atom = [&](int step) {
    const Scaled value = sum(sums[step]);
    sums[step] = {linear(value)};
    return value;
  };
  const auto add_terms = [&](std::vector<Product>& to, int step, double sign) {
    // A sum with several uses is computed once. Copies of a product pay for up to two uses.
    const bool is_product = sums[step].size() == 1 && sums[step].front().b != one;
    if ((uses[step] > 1 && sums[step].size() > 1) || (uses[step] > 2 && is_product)) atom(step);
    for (Product p : sums[step]) {
      p.scale *= sign;
      to.push_back(p);
    }
  };
  const auto function = [&](Elementary f, int a) { return apply(f, atom(a)); };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const FormulaStep& s = steps[i];
    Scaled value;
    switch (s.operation) {
      case Operation::input:
        value = input(static_cast<int>(s.value));
        break;
      case Operation::constant:
        value = {s.value, one};
        break;
      case Operation::add:
      case Operation::subtract:
        add_terms(sums[i], s.a, 1.0);
        add_terms(sums[i], s.b, s.operation == Operation::add ? 1.0 : -1.0);
        continue;
      case Operation::negate:
        add_terms(sums[i], s.a, -1.0);
        continue;
      case Operation::multiply: {
        const Scaled a = atom(s.a), b = atom(s.b);
        if (const Product p = product_of(a, b); p.scale != 0.0) sums[i] = {p};
        continue;
      }
      case Operation::divide: {
        const Scaled a = atom(s.a), b = atom(s.b);
        if (b.is_constant())
          value = {a.scale / b.scale, a.node};
        else
          value = product(a, apply(Elementary::inverse, b));
        break;
      }
      case Operation::sin:
        value = function(Elementary::sin, s.a);
        break;
      case Operation::cos:
        value = function(Elementary::cos, s.a);
        break;
      case Operation::tan:
        value = function(Elementary::tan, s.a);
        break;
      case Operation::asin:
        value = function(Elementary::asin, s.a);
        break;
      case Operation::acos:
        value = function(Elementary::acos, s.a);
        break;
      case Operation::atan:
        value = function(Elementary::atan, s.a);
        break;
      case Operation::sinh:
        value = function(Elementary::sinh, s.a);
        break;
      case Operation::cosh:
        value = function(Elementary::cosh, s.a);
        break;
      case Operation::tanh:
        value = function(Elementary::tanh, s.a);
        break;
      case Operation::exp:
        value = function(Elementary::exp, s.a);
        break;
      case Operation::log:
        value = function(Elementary::log, s.a);
        break;
      case Operation::sqrt:
        value = function(Elementary::sqrt, s.a);
        break;
      case Operation::abs:
        value = function(Elementary::abs, s.a);
        break;
      case Operation::atan2:
        value = apply(Elementary::atan2, atom(s.a), atom(s.b));
        break;
      case Operation::hypot:
        value = apply(Elementary::hypot, atom(s.a), atom(s.b));
        break;
      case Operation::pow: {
        const Scaled exponent = atom(s.b);
        if (!exponent.is_constant()) return {};
        value = power(atom(s.a), exponent.scale, false);
        break;
      }
      case Operation::min:
      case Operation::max:
      case Operation::select:
        return {};
    }
    if (!value.is_zero()) sums[i] = {linear(value)};
  }
  std::vector<int> outputs;
  outputs.reserve(formula.outputs.size());
  for (const int output : formula.outputs) outputs.push_back(node_of(atom(output)));
  return outputs;
}

std::vector<Partial> ExpressionGraph::partials(int index) {
  const ExpressionNode node = nodes_[index];  // a copy: more nodes follow
  if (node.function == Elementary::none) {
    std::map<int, std::vector<Product>> by_argument;
    for (const Product& p : node.sum) {
      if (p.a != one) by_argument[p.a].push_back({p.scale, p.b, one});
      if (p.b != one) by_argument[p.b].push_back({p.scale, p.a, one});
    }
    std::vector<Partial> result;
    result.reserve(by_argument.size());
    for (auto& [argument, products] : by_argument)
      result.push_back({argument, sum(std::move(products))});
    return result;
  }
  const Scaled a{1.0, node.a}, f{1.0, index};
  const auto alone = [&](const Scaled& derivative) {
    return std::vector<Partial>{{node.a, derivative}};
  };
  const auto sum_of = [&](double constant, double scale, const Scaled& p) {
    return sum({{constant, one, one}, product_of(scaled(scale, p), p)});
  };
  switch (node.function) {
    case Elementary::none:
    case Elementary::sign:
      return {};
    case Elementary::inverse:
    case Elementary::inverse_or_zero:
      return alone(scaled(-1.0, product(f, f)));
    case Elementary::sin:
      return alone(apply(Elementary::cos, a));
    case Elementary::cos:
      return alone(scaled(-1.0, apply(Elementary::sin, a)));
    case Elementary::tan:
      return alone(sum_of(1.0, 1.0, f));
    case Elementary::asin:
    case Elementary::acos: {
      const Scaled root = apply(Elementary::sqrt, sum_of(1.0, -1.0, a));
      return alone(scaled(node.function == Elementary::asin ? 1.0 : -1.0,
                          apply(Elementary::inverse_or_zero, root)));
    }
    case Elementary::atan:
      return alone(apply(Elementary::inverse, sum_of(1.0, 1.0, a)));
    case Elementary::sinh:
      return alone(apply(Elementary::cosh, a));
    case Elementary::cosh:
      return alone(apply(Elementary::sinh, a));
    case Elementary::tanh:
      return alone(sum_of(1.0, -1.0, f));
    case Elementary::exp:
      return alone(f);
    case Elementary::log:
      return alone(apply(Elementary::inverse, a));
    case Elementary::sqrt:
      return alone(scaled(0.5, apply(Elementary::inverse_or_zero, f)));
    case Elementary::abs:
      return alone(apply(Elementary::sign, a));
    case Elementary::power:
    case Elementary::power_or_zero:
      return alone(scaled(node.parameter, power(a, node.parameter - 1.0, true)));
    case Elementary::atan2:
    case Elementary::hypot: {
      Scaled inverse_length;
      const auto [of_a, of_b] = angle_partials(node, inverse_length);
      if (node.a == node.b) return alone(sum({linear(of_a), linear(of_b)}));
      return {{node.a, of_a}, {node.b, of_b}};
    }
  }
  return {};
}

// First derivatives of atan2(a, b) or hypot(a, b), and 1 / hypot(a, b).
std::pair<Scaled, Scaled> ExpressionGraph::angle_partials(const ExpressionNode& node,
                                                          Scaled& inverse_length) {
  const Scaled a{1.0, node.a}, b{1.0, node.b};
  const bool is_angle = node.function == Elementary::atan2;
  // Below 1e-150, second derivatives of the angle would not be finite.
  inverse_length = apply(Elementary::inverse_or_zero, apply(Elementary::hypot, a, b), {1.0, -1},
                         is_angle ? 1e-150 : 0.0);
  const Scaled cosine = product(b, inverse_length), sine = product(a, inverse_length);
  if (!is_angle) return {sine, cosine};
  return {product(cosine, inverse_length), scaled(-1.0, product(sine, inverse_length))};
}

std::vector<SecondPartial> ExpressionGraph::second_partials(int index) {
  const ExpressionNode node = nodes_[index];
  if (node.function == Elementary::none) {
    std::vector<SecondPartial> result;
    for (const Product& p : node.sum)
      if (p.b != one) result.push_back({p.a, p.b, {p.a == p.b ? 2.0 * p.scale : p.scale, one}});
    return result;
  }
  const Scaled a{1.0, node.a}, f{1.0, index};
  const auto alone = [&](const Scaled& derivative) {
    return std::vector<SecondPartial>{{node.a, node.a, derivative}};
  };
  // The derivative of the first derivative, where it has a simple form.
  const auto first = [&] { return partials(index).front().derivative; };
  switch (node.function) {
    case Elementary::none:
    case Elementary::sign:
    case Elementary::abs:
      return {};
    case Elementary::inverse:
    case Elementary::inverse_or_zero:
      return alone(scaled(2.0, product(f, product(f, f))));
    case Elementary::sin:
    case Elementary::cos:
      return alone(scaled(-1.0, f));
    case Elementary::tan:
      return alone(scaled(2.0, product(f, first())));
    case Elementary::tanh:
      return alone(scaled(-2.0, product(f, first())));
    case Elementary::asin:
    case Elementary::acos: {
      const Scaled p = first();
      return alone(product(a, product(p, product(p, p))));
    }
    case Elementary::atan: {
      const Scaled p = first();
      return alone(scaled(-2.0, product(a, product(p, p))));
    }
    case Elementary::sinh:
    case Elementary::cosh:
    case Elementary::exp:
      return alone(f);
    case Elementary::log: {
      const Scaled p = first();
      return alone(scaled(-1.0, product(p, p)));
    }
    case Elementary::sqrt: {
      const Scaled p = first();
      return alone(scaled(-2.0, product(p, product(p, p))));
    }
    case Elementary::power:
    case Elementary::power_or_zero: {
      const double n = node.parameter;
      // Where the first derivative is replaced by zero, so is the second.
      return alone(scaled(n * (n - 1.0), power(a, n - 2.0, true)));
    }
    case Elementary::atan2:
    case Elementary::hypot:
      break;
  }
  Scaled inverse;
  const auto [of_a, of_b] = angle_partials(node, inverse);
  Scaled aa, ab, bb;
  if (node.function == Elementary::hypot) {
    aa = product(inverse, sum({{1.0, one, one}, product_of(scaled(-1.0, of_a), of_a)}));
    bb = product(inverse, sum({{1.0, one, one}, product_of(scaled(-1.0, of_b), of_b)}));
    ab = scaled(-1.0, product(inverse, product(of_a, of_b)));
  } else {
    // The first derivatives are p = b / (length)^2 and q = -a / (length)^2.
    aa = scaled(2.0, product(of_a, of_b));
    bb = scaled(-1.0, aa);
    ab = sum({product_of(of_b, of_b), product_of(scaled(-1.0, of_a), of_a)});
  }
  if (node.a == node.b) return alone(sum({linear(aa), linear(scaled(2.0, ab)), linear(bb)}));
  std::vector<SecondPartial> result{{node.a, node.a, aa}, {node.b, node.b, bb}};
  result.push_back({std::max(node.a, node.b), std::min(node.a, node.b), ab});
  return result;
}

}  // namespace saltus::detail
