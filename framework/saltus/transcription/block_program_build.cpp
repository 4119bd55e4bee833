// Set-up of a BlockProgram: patterns, and positions of all derivatives of blocks.
#include <algorithm>
#include <map>
#include <utility>

#include "saltus/transcription/block_program.hpp"

namespace saltus {
namespace {

void grow(VectorXd& v, int count, double value) {
  const auto old = v.size();
  v.conservativeResize(old + count);
  v.tail(count).setConstant(value);
}

// Calls visit(a, b, factor) for every pair of variables a >= b to which a local second derivative
// (l1, l2), l1 >= l2, contributes: the congruence C' H C with H given by its lower triangle.
template <class Visit>
void for_each_pair(const Block& block, int l1, int l2, Visit&& visit) {
  for (const VariableCoefficient& s1 : block.coefficients[l1])
    for (const VariableCoefficient& s2 : block.coefficients[l2]) {
      const int a = std::max(s1.variable, s2.variable), b = std::min(s1.variable, s2.variable);
      const double factor = s1.factor * s2.factor;
      if (l1 == l2) {
        if (s1.variable >= s2.variable) visit(a, b, factor);  // the ordered pair once
      } else {
        visit(a, b, a == b ? 2.0 * factor : factor);  // H(l1, l2) and H(l2, l1)
      }
    }
}

// Degrees of the outputs of a block in its variables. Blocks of the same function mostly share
// them.
class BlockDegrees {
 public:
  const std::vector<int>& of(const Block& block) {
    const Function& f = block.function;
    std::vector<char> variable(f.inputs(), 0);
    for (int i = 0; i < f.inputs(); ++i) variable[i] = block.coefficients[i].empty() ? 0 : 1;
    const auto [at, is_new] = known_.try_emplace({f.identity(), variable});
    for (int o = 0; is_new && o < f.outputs(); ++o) at->second.push_back(f.degree(o, variable));
    return at->second;
  }

 private:
  std::map<std::pair<const void*, std::vector<char>>, std::vector<int>> known_;
};

}  // namespace

int BlockProgram::add_variables(int count) {
  const int first = variables();
  grow(lower_, count, -infinity);
  grow(upper_, count, infinity);
  return first;
}

int BlockProgram::add_rows(int count) {
  const int first = rows();
  grow(row_lower_, count, -infinity);
  grow(row_upper_, count, infinity);
  return first;
}

int BlockProgram::add_block(Block block) {
  blocks_.push_back(std::move(block));
  return static_cast<int>(blocks_.size()) - 1;
}

void BlockProgram::add_linear(int row, int variable, double coefficient) {
  linear_.push_back({row, variable, -1, coefficient});
}

void BlockProgram::set_threads(int threads) {
  threads_ = threads;
  pool_ = threads == 1 ? nullptr : std::make_unique<ThreadPool>(threads);
}

// Distributes blocks of each function in contiguous runs, so that neighbours mostly share a thread.
// Each thread gets separate functions, so that no evaluation elsewhere makes the program allocate.
// The calling thread keeps functions that are not re-entrant.
void BlockProgram::assign_threads() {
  constexpr int runs_per_thread = 8;
  shares_.assign(threads_, {});
  finite_in_share_.assign(threads_, 1);
  struct Group {
    int count = 0, seen = 0;
    std::vector<Function> separate;  // per thread; empty at first
  };
  std::map<const void*, Group> groups;
  for (const Block& block : blocks_) ++groups[block.function.identity()].count;
  int alone = 0;  // counts blocks whose function occurs once
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Function& function = blocks_[i].function;
    Group& group = groups[function.identity()];
    const int runs = runs_per_thread * threads_;
    int thread =
        group.count == 1
            ? alone++ % threads_
            : static_cast<int>(static_cast<long>(group.seen++) * runs / group.count) % threads_;
    if (thread > 0 || function.is_reentrant()) {
      group.separate.resize(threads_);
      Function& own = group.separate[thread];
      if (!own) own = function.separate();
      if (own)
        function = own;
      else
        thread = 0;
    }
    shares_[thread].push_back(static_cast<int>(i));
  }
}

// Entries written by blocks of several threads are left to the calling thread, in the order of
// blocks. Every sum then equals that of a single thread.
void BlockProgram::separate_shared() {
  if (threads_ == 1) return;
  std::vector<int> thread_of(blocks_.size(), 0);
  for (int k = 0; k < threads_; ++k)
    for (const int i : shares_[k]) thread_of[i] = k;
  const auto separate = [&](std::vector<Scatter> Compiled::*list, int entries,
                            std::vector<SharedScatter>& shared) {
    constexpr int nobody = -1, several = -2;
    std::vector<int> writer(entries, nobody);
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      for (const Scatter& s : compiled_[i].*list) {
        int& of = writer[s.to];
        of = of == nobody || of == thread_of[i] ? thread_of[i] : several;
      }
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      std::vector<Scatter>& all = compiled_[i].*list;
      const auto is_own = [&](const Scatter& s) { return writer[s.to] != several; };
      const auto first = std::stable_partition(all.begin(), all.end(), is_own);
      for (auto s = first; s != all.end(); ++s) shared.push_back({static_cast<int>(i), *s});
      all.erase(first, all.end());
    }
  };
  separate(&Compiled::rows, rows(), shared_rows_);
  separate(&Compiled::gradient, variables(), shared_gradient_);
  separate(&Compiled::jacobian, jacobian_pattern_.entries(), shared_jacobian_);
  separate(&Compiled::hessian, hessian_pattern_.entries(), shared_hessian_);
}

void BlockProgram::finish() {
  assign_threads();
  std::vector<std::pair<int, int>> jacobian, hessian;
  for (const Linear& l : linear_) jacobian.emplace_back(l.row, l.variable);
  for (const int v : quadratic_variables_) hessian.emplace_back(v, v);
  for (const Block& block : blocks_) {
    block.function.jacobian_pattern().for_each([&](int out, int in, int) {
      if (block.outputs[out].row != BlockOutput::objective)
        for (const VariableCoefficient& s : block.coefficients[in])
          jacobian.emplace_back(block.outputs[out].row, s.variable);
    });
    block.function.hessian_pattern().for_each([&](int l1, int l2, int) {
      for_each_pair(block, l1, l2, [&](int a, int b, double) { hessian.emplace_back(a, b); });
    });
  }
  jacobian_pattern_ = SparsityPattern::from_pairs(rows(), variables(), std::move(jacobian));
  hessian_pattern_ = SparsityPattern::from_pairs(variables(), variables(), std::move(hessian));
  for (Linear& l : linear_) l.position = jacobian_pattern_.find(l.row, l.variable);

  std::vector<char> filled(jacobian_pattern_.entries(), 0);
  for (Linear& l : linear_) l.adds = std::exchange(filled[l.position], 1) != 0;
  compiled_.resize(blocks_.size());
  BlockDegrees degrees;
  int terms = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    compiled_[i].degrees = degrees.of(blocks_[i]);
    compile_block(blocks_[i], compiled_[i]);
    compiled_[i].first_objective_term = terms;
    for (const BlockOutput& output : blocks_[i].outputs)
      if (output.row == BlockOutput::objective) ++terms;
  }
  objective_terms_.assign(terms, 0.0);
  for (const std::vector<int>& share : shares_) {
    std::map<const void*, int> last;
    for (const int i : share) {
      const auto [at, is_first] = last.try_emplace(blocks_[i].function.identity(), i);
      if (!is_first) compiled_[i].before = std::exchange(at->second, i);
    }
  }
  for (Compiled& c : compiled_)
    for (Scatter& s : c.jacobian) s.adds = std::exchange(filled[s.to], 1) != 0;
  separate_shared();
  linear_cost_ = VectorXd::Zero(variables());
  quadratic_cost_ = VectorXd::Zero(variables());
  quadratic_position_.assign(variables(), -1);
  for (const int v : quadratic_variables_) quadratic_position_[v] = hessian_pattern_.find(v, v);
  last_w_ = VectorXd::Zero(variables());
  linear_quadratic_ = true;
  affine_rows_.assign(rows(), 1);
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (std::size_t o = 0; o < blocks_[i].outputs.size(); ++o) {
      const int row = blocks_[i].outputs[o].row;
      const bool is_cost = row == BlockOutput::objective;
      linear_quadratic_ = linear_quadratic_ && compiled_[i].degrees[o] <= (is_cost ? 2 : 1);
      if (!is_cost && compiled_[i].degrees[o] > 1) affine_rows_[row] = 0;
      curved_cost_ = curved_cost_ || (is_cost && compiled_[i].degrees[o] > 1);
    }
}

void BlockProgram::compile_block(const Block& block, Compiled& c) const {
  const Function& f = block.function;
  c.argument = block.constants;
  for (int i = 0; i < f.inputs(); ++i)
    if (!block.coefficients[i].empty()) c.with_coefficients.push_back(i);
  c.value = VectorXd::Zero(f.outputs());
  c.weights = VectorXd::Zero(f.outputs());
  c.entries.assign(f.jacobian_pattern().entries(), 0.0);
  c.hessian_entries.assign(f.hessian_pattern().entries(), 0.0);
  c.hessian_weights = c.weights;
  for (int i = 0; i < f.inputs(); ++i) {
    c.reads.push_back(f.reads(i) ? 1 : 0);
    if (f.reads(i)) c.read.push_back(i);
  }
  const auto most = std::max_element(c.degrees.begin(), c.degrees.end());
  c.is_affine = most == c.degrees.end() || *most <= 1;
  c.is_quadratic = most == c.degrees.end() || *most <= 2;
  f.jacobian_pattern().for_each([&](int out, int in, int e) {
    const BlockOutput& output = block.outputs[out];
    for (const VariableCoefficient& s : block.coefficients[in])
      if (output.row == BlockOutput::objective)
        c.gradient.push_back({e, s.variable, out, s.factor});
      else
        c.jacobian.push_back(
            {e, jacobian_pattern_.find(output.row, s.variable), out, s.factor * output.factor});
  });
  f.hessian_pattern().for_each([&](int l1, int l2, int e) {
    for_each_pair(block, l1, l2, [&](int a, int b, double factor) {
      c.hessian.push_back({e, hessian_pattern_.find(a, b), 0, factor});
    });
  });
  c.is_curved = !c.hessian.empty();
  for (int o = 0; o < f.outputs(); ++o)
    if (block.outputs[o].row != BlockOutput::objective)
      c.rows.push_back({o, block.outputs[o].row, o, block.outputs[o].factor});
}

}  // namespace saltus
