#include "saltus/model/recorded_derivatives.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

namespace saltus::detail {
namespace {

using Term = DirectionSweep::Term;

constexpr int one = 0;  // node of the number 1

/// The nodes of a formula with their local derivatives, and the sweeps through them.
class LocalDerivatives {
 public:
  LocalDerivatives(ExpressionGraph& graph, const std::vector<int>& outputs)
      : graph_(graph), outputs_(outputs), size_(graph.size()), partials_(size_), users_(size_) {
    std::vector<char> needed(size_, 0);
    for (const int output : outputs) needed[output] = 1;
    for (int i = size_; i-- > 0;) {
      if (!needed[i]) continue;
      partials_[i] = graph.partials(i);
      for (const Partial& p : partials_[i]) {
        needed[p.argument] = 1;
        users_[p.argument].push_back({i, p.derivative});
      }
    }
    for (int i = 0; i < size_; ++i) {
      if (const int input = graph[i].input; needed[i] && input >= 0) {
        if (input >= static_cast<int>(input_.size())) input_.resize(input + 1, -1);
        input_[input] = i;
      }
    }
  }

  /// Derivatives of the weighted sum, with the weights as further inputs of the graph.
  void weigh(int first_weight) {
    std::vector<std::vector<Product>> sums(size_);
    for (std::size_t r = 0; r < outputs_.size(); ++r) {
      const Scaled weight = graph_.input(first_weight + static_cast<int>(r));
      sums[outputs_[r]].push_back({weight.scale, weight.node, one});
    }
    std::map<std::pair<int, int>, std::vector<Product>> pairs;
    for (int i = size_; i-- > 0;) {
      if (sums[i].empty() || partials_[i].empty()) continue;
      const Scaled bar = graph_.sum(std::move(sums[i]));
      const auto times_bar = [&](const Scaled& d) {
        return Product{d.scale * bar.scale, std::max(d.node, bar.node), std::min(d.node, bar.node)};
      };
      for (const Partial& p : partials_[i]) sums[p.argument].push_back(times_bar(p.derivative));
      for (const SecondPartial& p : graph_.second_partials(i))
        pairs[{p.first, p.second}].push_back(times_bar(p.derivative));
    }
    curvature_.resize(size_);
    for (auto& [pair, products] : pairs) {
      const Scaled value = graph_.sum(std::move(products));
      if (value.is_zero()) continue;
      curvature_[pair.first].push_back({pair.second, value});
      if (pair.first != pair.second) curvature_[pair.second].push_back({pair.first, value});
    }
  }

  /// Derivatives of outputs along inputs. Seeds are inputs, readings are outputs.
  DirectionSweep forward(const std::vector<Seed>& seeds, const std::vector<Reading>& readings,
                         int lanes) {
    DirectionSweep sweep(lanes);
    begin();
    std::vector<int> forward(size_, -1);
    std::vector<char> needed(size_, 0);
    seed(seeds, active_);
    for (const Reading& r : readings) needed[outputs_[r.row]] = 1;
    spread_needs(needed);
    emit_forward(sweep, seeds, needed, forward);
    for (const Reading& r : readings) read(sweep, forward[outputs_[r.row]], r);
    return sweep;
  }

  /// Derivatives of outputs with respect to inputs. Seeds are outputs, readings are inputs.
  DirectionSweep backward(const std::vector<Seed>& seeds, const std::vector<Reading>& readings,
                          int lanes) {
    DirectionSweep sweep(lanes);
    begin();
    for (const Seed& s : seeds) seeds_of_[outputs_[s.input]].push_back(s.lane);
    emit_backward(sweep, readings, std::vector<int>(size_, -1));
    for (const Seed& s : seeds) seeds_of_[outputs_[s.input]].clear();
    return sweep;
  }

  /// Hessian times directions. Seeds and readings are inputs.
  DirectionSweep second(const std::vector<Seed>& seeds, const std::vector<Reading>& readings,
                        int lanes) {
    DirectionSweep sweep(lanes);
    begin();
    seed(seeds, active_);
    for (int i = 0; i < size_; ++i)
      for (const Partial& p : partials_[i]) active_[i] |= active_[p.argument];
    find_backward(readings);
    std::vector<char> needed(size_, 0);
    for (int k = 0; k < size_; ++k)
      if (needed_[k])
        for (const Weighted& w : curvature_[k]) needed[w.node] |= active_[w.node];
    spread_needs(needed);
    std::vector<int> forward(size_, -1);
    emit_forward(sweep, seeds, needed, forward);
    emit_backward(sweep, readings, forward);
    return sweep;
  }

  /// Nodes with a derivative along this input.
  std::vector<char> reach(int input) {
    std::vector<char> active(size_, 0);
    seed({{input, 0}}, active);
    for (int i = 0; i < size_; ++i)
      for (const Partial& p : partials_[i]) active[i] |= active[p.argument];
    return active;
  }

 private:
  struct Weighted {
    int node;
    Scaled derivative;
  };

  void begin() {
    active_.assign(size_, 0);
    needed_.assign(size_, 0);
    seeds_of_.resize(size_);
    curvature_.resize(size_);
  }
  int node_of_input(int input) const {
    return input < static_cast<int>(input_.size()) ? input_[input] : -1;
  }
  void seed(const std::vector<Seed>& seeds, std::vector<char>& active) const {
    for (const Seed& s : seeds)
      if (const int node = node_of_input(s.input); node >= 0) active[node] = 1;
  }
  void spread_needs(std::vector<char>& needed) const {
    for (int i = size_; i-- > 0;)
      if (needed[i])
        for (const Partial& p : partials_[i]) needed[p.argument] = 1;
  }
  static void read(DirectionSweep& sweep, int pack, const Reading& r) {
    sweep.read(pack < 0 ? sweep.zero() : pack, r.lane, r.entry);
  }

  // One row of a sweep. Terms with the same source are merged. A mere copy needs no row.
  struct Sources {
    std::vector<std::pair<int, Product>> terms;  // pack and coefficient
    void add(int source, const Scaled& c) {
      if (source >= 0) terms.push_back({source, {c.scale, c.node, one}});
    }
  };
  int emit(DirectionSweep& sweep, Sources& sources) {
    auto& terms = sources.terms;
    std::stable_sort(terms.begin(), terms.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Term> row;
    for (std::size_t i = 0; i < terms.size();) {
      const int source = terms[i].first;
      std::vector<Product> sum;
      for (; i < terms.size() && terms[i].first == source; ++i) sum.push_back(terms[i].second);
      const Scaled coefficient = graph_.sum(std::move(sum));
      if (!coefficient.is_zero()) row.push_back({graph_.node_of(coefficient), source});
    }
    terms.clear();
    if (row.empty()) return -1;
    if (row.size() == 1 && row.front().coefficient == one) return row.front().source;
    return sweep.add(row);
  }

  void emit_forward(DirectionSweep& sweep, const std::vector<Seed>& seeds,
                    const std::vector<char>& needed, std::vector<int>& forward) {
    for (const Seed& s : seeds)
      if (const int node = node_of_input(s.input); node >= 0) forward[node] = s.lane;
    Sources sources;
    for (int i = 0; i < size_; ++i) {
      if (!needed[i] || partials_[i].empty()) continue;
      for (const Partial& p : partials_[i]) sources.add(forward[p.argument], p.derivative);
      forward[i] = emit(sweep, sources);
    }
  }

  // Marks nodes whose backward pack may be non-zero and contributes to a reading.
  void find_backward(const std::vector<Reading>& readings) {
    std::vector<char> active(size_, 0);
    for (int k = size_; k-- > 0;) {
      bool any = !seeds_of_[k].empty();
      for (const Weighted& user : users_[k]) any = any || active[user.node];
      for (const Weighted& w : curvature_[k]) any = any || active_[w.node];
      active[k] = any;
    }
    for (const Reading& r : readings)
      if (const int node = node_of_input(r.row); node >= 0) needed_[node] = active[node];
    for (int k = 0; k < size_; ++k)
      if (needed_[k])
        for (const Weighted& user : users_[k]) needed_[user.node] |= active[user.node];
  }

  void emit_backward(DirectionSweep& sweep, const std::vector<Reading>& readings,
                     const std::vector<int>& forward) {
    find_backward(readings);
    std::vector<int> backward(size_, -1);
    Sources sources;
    for (int k = size_; k-- > 0;) {
      if (!needed_[k]) continue;
      for (const int lane : seeds_of_[k]) sources.add(lane, {1.0, one});
      for (const Weighted& user : users_[k]) sources.add(backward[user.node], user.derivative);
      for (const Weighted& w : curvature_[k]) sources.add(forward[w.node], w.derivative);
      backward[k] = emit(sweep, sources);
    }
    for (const Reading& r : readings) {
      const int node = node_of_input(r.row);
      read(sweep, node < 0 ? -1 : backward[node], r);
    }
  }

  ExpressionGraph& graph_;
  const std::vector<int>& outputs_;
  int size_;  // later nodes are derivatives
  std::vector<std::vector<Partial>> partials_;
  std::vector<std::vector<Weighted>> users_;      // nodes that use a node
  std::vector<std::vector<Weighted>> curvature_;  // weighted second derivatives of a pair
  std::vector<int> input_;                        // node of each input, or -1
  std::vector<char> active_, needed_;
  std::vector<std::vector<int>> seeds_of_;  // lanes of an output
};

SparsityPattern transposed(const SparsityPattern& pattern) {
  std::vector<std::pair<int, int>> pairs;
  pattern.for_each([&](int r, int c, int) { pairs.emplace_back(c, r); });
  return SparsityPattern::from_pairs(pattern.cols(), pattern.rows(), std::move(pairs));
}

int operations_of(const std::vector<DirectionSweep>& sweeps) {
  int operations = 0;
  for (const DirectionSweep& sweep : sweeps) operations += sweep.operations();
  return operations;
}

int count_lanes(const std::vector<Seed>& seeds) {
  int lanes = 0;
  for (const Seed& s : seeds) lanes = std::max(lanes, s.lane + 1);
  return lanes;
}

int widest(const std::vector<JacobianPass>& passes) {
  int lanes = 1;
  for (const JacobianPass& pass : passes) lanes = std::max(lanes, count_lanes(pass.seeds));
  return lanes_of(lanes);
}

std::vector<DirectionSweep> jacobian_sweeps(LocalDerivatives& local,
                                            const SparsityPattern& jacobian) {
  std::vector<DirectionSweep> forward, backward;
  const std::vector<JacobianPass> columns = jacobian_passes(jacobian, native_lanes);
  for (const JacobianPass& pass : columns)
    forward.push_back(local.forward(pass.seeds, pass.readings, widest(columns)));
  const SparsityPattern rows_of = transposed(jacobian);
  const std::vector<JacobianPass> rows = jacobian_passes(rows_of, native_lanes);
  for (const JacobianPass& pass : rows) {
    std::vector<Reading> readings = pass.readings;
    std::vector<std::pair<int, int>> position(rows_of.entries());
    rows_of.for_each([&](int c, int r, int e) { position[e] = {r, c}; });
    for (Reading& r : readings)
      r.entry = jacobian.find(position[r.entry].first, position[r.entry].second);
    backward.push_back(local.backward(pass.seeds, readings, widest(rows)));
  }
  return operations_of(backward) < operations_of(forward) ? std::move(backward)
                                                          : std::move(forward);
}

// Directions whose inputs reach the same nodes share a sweep, which then has fewer rows.
std::vector<DirectionSweep> hessian_sweeps(LocalDerivatives& local,
                                           const SparsityPattern& hessian) {
  std::vector<HessianDirection> directions = hessian_directions(hessian);
  std::vector<std::vector<char>> reach;
  for (const HessianDirection& d : directions) {
    std::vector<char> all;
    for (const int input : d.inputs) {
      const std::vector<char> reached = local.reach(input);
      all.resize(reached.size(), 0);
      for (std::size_t i = 0; i < all.size(); ++i) all[i] |= reached[i];
    }
    reach.push_back(std::move(all));
  }
  const int lanes = lanes_of(static_cast<int>(directions.size()));
  std::vector<DirectionSweep> sweeps;
  std::vector<char> done(directions.size(), 0);
  for (std::size_t left = directions.size(); left > 0;) {
    std::vector<Seed> seeds;
    std::vector<Reading> readings;
    std::vector<char> reached;
    for (int lane = 0; lane < lanes && left > 0; ++lane, --left) {
      // The first one reaches most nodes, the next ones fewest further nodes.
      std::ptrdiff_t best_score = 0;
      int best = -1;
      for (std::size_t d = 0; d < directions.size(); ++d) {
        if (done[d]) continue;
        std::ptrdiff_t score = 0;
        for (std::size_t i = 0; i < reach[d].size(); ++i)
          score += lane == 0 ? reach[d][i] : -(reach[d][i] & ~reached[i]);
        if (best < 0 || score > best_score) {
          best = static_cast<int>(d);
          best_score = score;
        }
      }
      done[best] = 1;
      reached.resize(reach[best].size(), 0);
      for (std::size_t i = 0; i < reached.size(); ++i) reached[i] |= reach[best][i];
      for (const int input : directions[best].inputs) seeds.push_back({input, lane});
      for (const auto& [input, entry] : directions[best].readings)
        readings.push_back({input, lane, entry});
    }
    sweeps.push_back(local.second(seeds, readings, lanes));
  }
  return sweeps;
}

}  // namespace

RecordedDerivatives::RecordedDerivatives(const FormulaSteps& steps, const SparsityPattern& jacobian,
                                         const SparsityPattern& hessian, Parts parts)
    : inputs_(steps.inputs), outputs_(static_cast<int>(steps.outputs.size())) {
  ExpressionGraph graph;
  const std::vector<int> outputs = graph.append(steps);
  is_complete_ = !outputs.empty();
  if (!is_complete_) return;
  LocalDerivatives local(graph, outputs);
  if (parts.jacobian) jacobian_ = jacobian_sweeps(local, jacobian);
  if (parts.hessian) {
    local.weigh(inputs_);
    hessian_ = hessian_sweeps(local, hessian);
  }
  std::vector<int> first, second;
  if (parts.jacobian) first = outputs;
  const auto collect = [](std::vector<DirectionSweep>& sweeps, std::vector<int>& nodes) {
    for (DirectionSweep& sweep : sweeps)
      sweep.for_each_term([&](Term& term) { nodes.push_back(term.coefficient); });
  };
  collect(jacobian_, first);
  collect(hessian_, second);
  scalars_ = ScalarProgram(graph, inputs_ + outputs_, first, second);
  for (std::vector<DirectionSweep>* sweeps : {&jacobian_, &hessian_})
    for (DirectionSweep& sweep : *sweeps)
      sweep.for_each_term(
          [&](Term& term) { term.coefficient = scalars_.slot_of(term.coefficient); });
  for (const int output : outputs) values_.push_back(scalars_.slot_of(output));
}

int RecordedDerivatives::jacobian_operations() const {
  return scalars_.operations(0) + operations_of(jacobian_);
}

int RecordedDerivatives::hessian_operations() const {
  return scalars_.operations(0) + scalars_.operations(1) + operations_of(hessian_);
}

RecordedDerivatives::Workspace RecordedDerivatives::workspace() const {
  constexpr int line = 8;  // doubles of a cache line
  const auto size_of = [](const std::vector<DirectionSweep>& sweeps) {
    int size = 0;
    for (const DirectionSweep& sweep : sweeps) size = std::max(size, sweep.workspace());
    return (size + line - 1) / line * line;
  };
  Workspace w;
  w.slots.resize(scalars_.slots());
  scalars_.prepare(w.slots.data());
  w.storage.resize(line + size_of(jacobian_) + size_of(hessian_));
  const auto address = reinterpret_cast<std::uintptr_t>(w.storage.data());
  w.jacobian_packs = w.storage.data() + (line - address / sizeof(double) % line) % line;
  w.hessian_packs = w.jacobian_packs + size_of(jacobian_);
  if (!jacobian_.empty()) jacobian_.front().prepare(w.jacobian_packs);
  if (!hessian_.empty()) hessian_.front().prepare(w.hessian_packs);
  return w;
}

void RecordedDerivatives::load(const double* z, const double* weights, Workspace& w) const {
  std::copy_n(z, inputs_, w.slots.data() + ScalarProgram::slot_of_input(0));
  if (weights != nullptr)
    std::copy_n(weights, outputs_, w.slots.data() + ScalarProgram::slot_of_input(inputs_));
  scalars_.run(0, w.slots.data());
}

void RecordedDerivatives::read_values(const Workspace& w, double* y) const {
  for (int r = 0; r < outputs_; ++r) y[r] = w.slots[values_[r]];
}

void RecordedDerivatives::jacobian(const double* z, double* y, double* entries,
                                   Workspace& w) const {
  load(z, nullptr, w);
  read_values(w, y);
  for (const DirectionSweep& sweep : jacobian_)
    sweep.run(w.slots.data(), w.jacobian_packs, entries);
}

void RecordedDerivatives::hessian(const double* z, const double* weights, double* entries,
                                  Workspace& w) const {
  load(z, weights, w);
  scalars_.run(1, w.slots.data());
  for (const DirectionSweep& sweep : hessian_) sweep.run(w.slots.data(), w.hessian_packs, entries);
}

void RecordedDerivatives::derivatives(const double* z, const double* weights, double* y,
                                      double* jacobian_entries, double* hessian_entries,
                                      Workspace& w) const {
  hessian(z, weights, hessian_entries, w);
  read_values(w, y);
  for (const DirectionSweep& sweep : jacobian_)
    sweep.run(w.slots.data(), w.jacobian_packs, jacobian_entries);
}

long dual_operations(const FormulaSteps& steps, std::size_t passes) {
  long operations = 0;
  for (const FormulaStep& s : steps.steps) {
    if (s.operation <= Operation::constant) continue;
    operations += s.operation <= Operation::negate ? 2 : function_cost;
  }
  return operations * static_cast<long>(passes);
}

}  // namespace saltus::detail
