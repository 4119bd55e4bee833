#include "saltus/model/make_function.hpp"

#include <algorithm>

namespace saltus {
namespace {

using Lists = std::vector<std::vector<int>>;

// Greedy colouring. Each list (rows of a column, partners of an input) gets the first colour whose
// lists share no member with it. An empty list gets -1.
std::vector<int> colour_disjoint(const Lists& lists, int members) {
  std::vector<int> colour(lists.size(), -1);
  std::vector<std::vector<bool>> taken;  // per colour: members in use
  for (std::size_t k = 0; k < lists.size(); ++k) {
    if (lists[k].empty()) continue;
    const auto free_in = [&](const std::vector<bool>& used) {
      return std::none_of(lists[k].begin(), lists[k].end(), [&](int m) { return used[m]; });
    };
    const auto first_free = std::find_if(taken.begin(), taken.end(), free_in);
    colour[k] = static_cast<int>(first_free - taken.begin());
    if (first_free == taken.end()) taken.emplace_back(members, false);
    for (int m : lists[k]) taken[colour[k]][m] = true;
  }
  return colour;
}

// Greedy vertex cover: inputs that touch every pair, those with most uncovered pairs first.
std::vector<int> cover_pairs(const Lists& partners) {
  const int n = static_cast<int>(partners.size());
  std::vector<int> cover;
  std::vector<bool> covered(n, false);
  for (;;) {
    int best = -1;
    std::ptrdiff_t most = 0;
    for (int i = 0; i < n; ++i) {
      if (covered[i]) continue;
      const auto open =
          std::count_if(partners[i].begin(), partners[i].end(), [&](int j) { return !covered[j]; });
      if (open > most) {
        most = open;
        best = i;
      }
    }
    if (best < 0) return cover;
    covered[best] = true;
    cover.push_back(best);
  }
}

// Seeds as whole vectors. Reading a vector right after writing one of its lanes would stall on the
// store.
std::vector<double> tangents_of(const std::vector<detail::Seed>& seeds, int inputs, int lanes) {
  std::vector<double> tangents(static_cast<std::size_t>(inputs) * lanes, 0.0);
  for (const detail::Seed& seed : seeds) tangents[seed.input * lanes + seed.lane] = 1.0;
  return tangents;
}

}  // namespace

std::vector<detail::JacobianPass> detail::jacobian_passes(const SparsityPattern& jacobian,
                                                          int lanes) {
  Lists rows_of(jacobian.cols());
  jacobian.for_each([&](int r, int c, int) { rows_of[c].push_back(r); });
  const std::vector<int> colour = colour_disjoint(rows_of, jacobian.rows());
  std::vector<detail::JacobianPass> passes;
  const auto pass_of = [&](int c) -> detail::JacobianPass& {
    const std::size_t pass = colour[c] / lanes;
    if (pass >= passes.size()) passes.resize(pass + 1);
    return passes[pass];
  };
  for (int c = 0; c < jacobian.cols(); ++c)
    if (colour[c] >= 0) pass_of(c).seeds.push_back({c, colour[c] % lanes});
  jacobian.for_each([&](int r, int c, int entry) {
    pass_of(c).readings.push_back({r, colour[c] % lanes, entry});
  });
  for (detail::JacobianPass& pass : passes)
    pass.tangents = tangents_of(pass.seeds, jacobian.cols(), lanes);
  return passes;
}

std::vector<detail::HessianDirection> detail::hessian_directions(const SparsityPattern& hessian) {
  const int n = hessian.cols();
  Lists partners(n);
  hessian.for_each([&](int i, int j, int) {
    partners[i].push_back(j);
    if (i != j) partners[j].push_back(i);
  });
  const std::vector<int> cover = cover_pairs(partners);

  // Inputs without a common partner share a direction: at most one of them contributes to each
  // entry of the product.
  Lists partners_of_cover;
  for (int j : cover) partners_of_cover.push_back(partners[j]);
  const std::vector<int> colour = colour_disjoint(partners_of_cover, n);
  std::vector<detail::HessianDirection> directions(
      cover.empty() ? 0 : 1 + *std::max_element(colour.begin(), colour.end()));
  for (std::size_t k = 0; k < cover.size(); ++k) directions[colour[k]].inputs.push_back(cover[k]);
  std::vector<bool> known(hessian.entries(), false);
  for (detail::HessianDirection& direction : directions)
    for (int j : direction.inputs)
      for (int i : partners[j]) {
        const int entry = hessian.find(std::max(i, j), std::min(i, j));
        if (!known[entry]) direction.readings.emplace_back(i, entry);
        known[entry] = true;
      }
  return directions;
}

std::vector<detail::HessianPass> detail::hessian_passes(const SparsityPattern& hessian, int lanes) {
  std::vector<detail::HessianPass> passes;
  for (const detail::HessianDirection& direction : hessian_directions(hessian)) {
    detail::HessianPass blank;
    blank.outer = direction.inputs;
    detail::HessianPass pass = blank;
    for (const auto& [i, entry] : direction.readings) {
      if (static_cast<int>(pass.seeds.size()) == lanes) {
        passes.push_back(pass);
        pass = blank;
      }
      const int lane = static_cast<int>(pass.seeds.size());
      pass.seeds.push_back({i, lane});
      pass.readings.push_back({0, lane, entry});
    }
    if (!pass.seeds.empty()) passes.push_back(pass);
  }
  const int n = hessian.cols();
  for (detail::HessianPass& pass : passes) {
    pass.tangents = tangents_of(pass.seeds, n, lanes);
    pass.outer_tangents.assign(n, 0.0);
    for (const int j : pass.outer) pass.outer_tangents[j] = 1.0;
  }
  return passes;
}

}  // namespace saltus
