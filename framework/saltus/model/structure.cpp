#include "saltus/model/make_function.hpp"

#include <utility>

namespace saltus {

detail::FormulaStructure detail::structure_of(int inputs, const std::vector<Tracer>& outputs) {
  using Pairs = std::vector<std::pair<int, int>>;
  detail::FormulaStructure structure;
  Pairs first, second;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    Pairs curved;
    outputs[i].inputs().for_each([&](int j) { first.emplace_back(static_cast<int>(i), j); });
    outputs[i].for_each_pair([&](int j, int k) { curved.emplace_back(j, k); });
    second.insert(second.end(), curved.begin(), curved.end());
    structure.curvature.push_back(SparsityPattern::from_pairs(inputs, inputs, std::move(curved)));
  }
  const int rows = static_cast<int>(outputs.size());
  structure.jacobian = SparsityPattern::from_pairs(rows, inputs, std::move(first));
  structure.hessian = SparsityPattern::from_pairs(inputs, inputs, std::move(second));
  return structure;
}

bool depends_on(const Function& function, int output, int input) {
  return function.jacobian_pattern().contains(output, input);
}

bool depends_on(const Function& function, int input) {
  for (int i = 0; i < function.outputs(); ++i)
    if (depends_on(function, i, input)) return true;
  return false;
}

bool depends_on_any(const Function& function, int first, int count) {
  for (int i = first; i < first + count; ++i)
    if (depends_on(function, i)) return true;
  return false;
}

bool is_affine_in(const Function& function, int first, int count) {
  const auto among = [&](int i) { return i >= first && i < first + count; };
  bool affine = true;
  function.hessian_pattern().for_each([&](int i, int j, int) {
    if (among(i) && among(j)) affine = false;
  });
  return affine;
}

}  // namespace saltus
