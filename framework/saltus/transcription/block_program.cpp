// Evaluation of a BlockProgram: evaluates blocks at a point and sums their values and derivatives.
#include "saltus/transcription/block_program.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {

void BlockProgram::set_constant(int block, int argument, double value) {
  double& constant = blocks_[block].constants[argument];
  if (constant == value) return;
  constant = value;
  Compiled& c = compiled_[block];
  c.argument[argument] = value;  // variables are added by gather()
  if (!c.reads[argument]) return;
  c.level = Level::none;
  c.has_entries = c.has_hessian = false;
  ++revision_;
}

void BlockProgram::set_weight(int block, int output, double value) {
  double& weight = blocks_[block].outputs[output].factor;
  if (weight == value) return;
  weight = value;
  ++revision_;
}

void BlockProgram::set_variable_cost(int variable, double linear, double quadratic) {
  if (linear_cost_[variable] == linear && quadratic_cost_[variable] == quadratic) return;
  linear_cost_[variable] = linear;
  quadratic_cost_[variable] = quadratic;
  ++revision_;
}

void BlockProgram::gather(const Block& block, Compiled& c, const double* w) {
  for (const int i : c.with_coefficients) {
    double sum = block.constants[i];
    for (const VariableCoefficient& s : block.coefficients[i]) sum += s.factor * w[s.variable];
    c.argument[i] = sum;
  }
}

void BlockProgram::move_to(const double* w) {
  if (point_ > 0 && std::equal(w, w + variables(), last_w_.data())) return;
  std::copy_n(w, variables(), last_w_.data());
  ++point_;
}

// A block repeats the result of the previous block with the same function if the arguments agree.
// This happens for equal intervals of a time-invariant problem.
bool BlockProgram::repeats(Compiled& c, Level level) const {
  if (c.before < 0) return false;
  const Compiled& other = compiled_[c.before];
  if (other.point != point_ || other.level < level) return false;
  if (level == Level::derivatives && !other.has_entries) return false;
  for (const int i : c.read)
    if (c.argument[i] != other.argument[i]) return false;
  c.value = other.value;
  if (level == Level::derivatives) {
    std::copy(other.entries.begin(), other.entries.end(), c.entries.begin());
    c.has_entries = true;
  }
  c.level = level;
  c.point = point_;
  return true;
}

void BlockProgram::update(const Block& block, Compiled& c, const double* w, Level level) {
  if (c.point == point_ && c.level >= level) return;
  c.level = Level::none;  // in case the formula throws
  gather(block, c, w);
  if (repeats(c, level)) return;
  // The derivatives of an affine block do not depend on the point.
  if (level == Level::values || (c.is_affine && c.has_entries)) {
    block.function.value(c.argument.data(), c.value.data());
  } else {
    block.function.jacobian(c.argument.data(), c.value.data(), c.entries.data());
    c.has_entries = std::all_of(c.entries.begin(), c.entries.end(),
                                [](double entry) { return std::isfinite(entry); });
  }
  c.level = level;
  c.point = point_;
}

// Each thread has fixed blocks in a fixed order.
template <class Work>
void BlockProgram::run_on_threads(const Work& work) {
  if (!pool_) return work(shares_.front(), 0);
  const auto part = [&](int k) { work(shares_[k], k); };
  pool_->run(part);
}

// Calls add(block, entry) for every entry of a list. Threads process entries that only they write;
// the calling thread then processes the others.
template <class Add>
void BlockProgram::add_shared(std::vector<Scatter> Compiled::*list,
                              const std::vector<SharedScatter>& shared, const Add& add) {
  run_on_threads([&](const std::vector<int>& blocks, int) {
    for (const int i : blocks)
      for (const Scatter& s : compiled_[i].*list) add(i, s);
  });
  for (const SharedScatter& s : shared) add(s.block, s.scatter);
}

bool BlockProgram::all_shares_finite() const {
  return std::find(finite_in_share_.begin(), finite_in_share_.end(), 0) == finite_in_share_.end();
}

template <class Visit>
void BlockProgram::for_each_jacobian_entry(const Visit& visit) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (const Scatter& s : compiled_[i].jacobian) visit(static_cast<int>(i), s);
  for (const SharedScatter& s : shared_jacobian_) visit(s.block, s.scatter);
}

bool BlockProgram::evaluate(const double* w, Level level) {
  move_to(w);
  if (evaluated_point_ == point_ && evaluated_revision_ == revision_ && level_ >= level)
    return finite_;
  evaluated_point_ = 0;  // in case a formula throws
  run_on_threads([&](const std::vector<int>& blocks, int k) {
    bool finite = true;
    for (const int i : blocks) {
      const Block& block = blocks_[i];
      Compiled& c = compiled_[i];
      const bool in_force = std::any_of(block.outputs.begin(), block.outputs.end(),
                                        [&](const BlockOutput& o) { return counts(o); });
      if (!in_force) continue;
      update(block, c, w, level);
      for (int o = 0; o < c.value.size(); ++o)
        if (!std::isfinite(c.value[o]) && counts(block.outputs[o])) {
          finite = false;
          c.level = Level::none;  // the failure may not occur at the next evaluation
        }
    }
    finite_in_share_[k] = finite;
  });
  finite_ = all_shares_finite();
  level_ = level;
  evaluated_point_ = finite_ ? point_ : 0;
  evaluated_revision_ = revision_;
  return finite_;
}

bool BlockProgram::objective(const double* w, double& f) {
  if (!evaluate(w, Level::values)) return false;
  run_on_threads([&](const std::vector<int>& blocks, int) {
    for (const int i : blocks) {
      const Compiled& c = compiled_[i];
      double* term = objective_terms_.data() + c.first_objective_term;
      for (int o = 0; o < c.value.size(); ++o) {
        const BlockOutput& output = blocks_[i].outputs[o];
        if (output.row == BlockOutput::objective)
          *term++ = output.factor == 0.0 ? 0.0 : output.factor * c.value[o];
      }
    }
  });
  f = 0.0;
  for (const double term : objective_terms_) f += term;
  for (int i = 0; i < variables(); ++i)
    f += (linear_cost_[i] + 0.5 * quadratic_cost_[i] * w[i]) * w[i];
  return std::isfinite(f);
}

bool BlockProgram::gradient(const double* w, double* gradient) {
  if (!evaluate(w, Level::derivatives)) return false;
  for (int i = 0; i < variables(); ++i) gradient[i] = linear_cost_[i] + quadratic_cost_[i] * w[i];
  add_shared(&Compiled::gradient, shared_gradient_, [&](int i, const Scatter& s) {
    const double weight = blocks_[i].outputs[s.output].factor;
    if (weight != 0.0) gradient[s.to] += weight * s.factor * compiled_[i].entries[s.from];
  });
  return std::all_of(gradient, gradient + variables(), [](double e) { return std::isfinite(e); });
}

bool BlockProgram::constraints(const double* w, double* g) {
  if (!evaluate(w, Level::values)) return false;
  std::fill_n(g, rows(), 0.0);
  for (const Linear& l : linear_) g[l.row] += l.coefficient * w[l.variable];
  add_shared(&Compiled::rows, shared_rows_, [&](int i, const Scatter& s) {
    if (!is_off(s.to)) g[s.to] += s.factor * compiled_[i].value[s.from];
  });
  return true;
}

bool BlockProgram::jacobian(const double* w, double* entries) {
  if (!evaluate(w, Level::derivatives)) return false;
  std::fill_n(entries, jacobian_pattern_.entries(), 0.0);
  for (const Linear& l : linear_) entries[l.position] += l.coefficient;
  add_shared(&Compiled::jacobian, shared_jacobian_, [&](int i, const Scatter& s) {
    const double entry = compiled_[i].entries[s.from];
    if (!is_off(blocks_[i].outputs[s.output].row)) entries[s.to] += s.factor * entry;
  });
  return std::all_of(entries, entries + jacobian_pattern_.entries(),
                     [](double e) { return std::isfinite(e); });
}

// Linear entries first. Blocks add to them at the same positions.
bool BlockProgram::write_jacobian(const double* w, std::span<const detail::EntryTarget> targets) {
  for (const Linear& l : linear_) {
    const detail::EntryTarget& target = targets[l.position];
    const double value = target.scale * l.coefficient;
    *target.to = l.adds ? *target.to + value : value;
  }
  if (!evaluate(w, Level::derivatives)) return false;
  bool finite = true;
  const auto write = [&](int i, const Scatter& s) {
    if (is_off(blocks_[i].outputs[s.output].row)) return;
    const detail::EntryTarget& target = targets[s.to];
    const double value = target.scale * (s.factor * compiled_[i].entries[s.from]);
    *target.to = s.adds ? *target.to + value : value;
    finite = finite && std::isfinite(value);
  };
  for_each_jacobian_entry(write);
  return finite;
}

void BlockProgram::multiply_jacobian(const VectorXd& v, VectorXd& out) const {
  out.setZero();
  for (const Linear& l : linear_) out[l.row] += l.coefficient * v[l.variable];
  for_each_jacobian_entry([&](int i, const Scatter& s) {
    const int row = blocks_[i].outputs[s.output].row;
    if (!is_off(row))
      out[row] += s.factor * compiled_[i].entries[s.from] * v[jacobian_pattern_.col(s.to)];
  });
}

void BlockProgram::add_jacobian_transposed(const VectorXd& lambda, VectorXd& out) const {
  for (const Linear& l : linear_) out[l.variable] += l.coefficient * lambda[l.row];
  for_each_jacobian_entry([&](int i, const Scatter& s) {
    const double multiplier = lambda[blocks_[i].outputs[s.output].row];
    if (multiplier != 0.0)
      out[jacobian_pattern_.col(s.to)] += s.factor * compiled_[i].entries[s.from] * multiplier;
  });
}

// Returns false if the block contributes nothing.
bool BlockProgram::weigh(const Block& block, Compiled& c, double sigma, const double* lambda,
                         Curvature curvature) const {
  bool any = false;
  for (int o = 0; o < c.weights.size(); ++o) {
    const BlockOutput& output = block.outputs[o];
    const bool cost = output.row == BlockOutput::objective;
    c.weights[o] = cost ? sigma * output.factor : output.factor * lambda[output.row];
    // Gauss-Newton drops the curvature of constraints. Interval functions keep that of their costs.
    if (!cost && (curvature == Curvature::gauss_newton || is_off(output.row))) c.weights[o] = 0.0;
    any = any || c.weights[o] != 0.0;
  }
  return any;
}

bool BlockProgram::knows_hessian(const Compiled& c, Curvature curvature) const {
  return c.has_hessian && (c.is_quadratic || c.hessian_point == point_) &&
         c.hessian_curvature == curvature && c.hessian_weights == c.weights;
}

void BlockProgram::note_hessian(Compiled& c, Curvature curvature) const {
  c.has_hessian = true;
  c.hessian_point = point_;
  c.hessian_curvature = curvature;
  c.hessian_weights = c.weights;
}

void BlockProgram::prepare_derivatives(const double* w, double sigma, const double* lambda,
                                       Curvature curvature) {
  if (linear_quadratic_) return;  // most derivatives are known for every point
  move_to(w);
  run_on_threads([&](const std::vector<int>& blocks, int) {
    for (const int i : blocks) {
      const Block& block = blocks_[i];
      Compiled& c = compiled_[i];
      const bool has_first = c.point == point_ && c.level == Level::derivatives;
      if (has_first || !c.is_curved || !weigh(block, c, sigma, lambda, curvature) ||
          knows_hessian(c, curvature))
        continue;
      c.level = Level::none;
      c.has_entries = c.has_hessian = false;
      gather(block, c, w);
      block.function.derivatives(c.argument.data(), c.weights.data(), c.value.data(),
                                 c.entries.data(), c.hessian_entries.data(), curvature);
      c.level = Level::derivatives;
      c.point = point_;
      c.has_entries = true;
      note_hessian(c, curvature);
    }
  });
}

bool BlockProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                           Curvature curvature) {
  move_to(w);
  std::fill_n(entries, hessian_pattern_.entries(), 0.0);
  for (const int v : quadratic_variables_)
    entries[quadratic_position_[v]] += sigma * quadratic_cost_[v];
  run_on_threads([&](const std::vector<int>& blocks, int k) {
    bool finite = true;
    for (const int i : blocks) {
      const Block& block = blocks_[i];
      Compiled& c = compiled_[i];
      c.counts_hessian = c.is_curved && weigh(block, c, sigma, lambda, curvature);
      if (!c.counts_hessian) continue;
      if (!knows_hessian(c, curvature)) {
        c.has_hessian = false;  // in case the formula throws
        gather(block, c, w);
        block.function.hessian(c.argument.data(), c.weights.data(), c.hessian_entries.data(),
                               curvature);
        note_hessian(c, curvature);
      }
      for (const Scatter& s : c.hessian) {
        entries[s.to] += s.factor * c.hessian_entries[s.from];
        finite = finite && std::isfinite(c.hessian_entries[s.from]);
      }
    }
    finite_in_share_[k] = finite;
  });
  bool finite = all_shares_finite();
  for (const auto& [i, s] : shared_hessian_) {
    if (!compiled_[i].counts_hessian) continue;
    entries[s.to] += s.factor * compiled_[i].hessian_entries[s.from];
    finite = finite && std::isfinite(compiled_[i].hessian_entries[s.from]);
  }
  return finite;
}

void BlockProgram::evaluate_block(int block, const double* w, double* outputs) {
  Compiled& c = compiled_[block];
  gather(blocks_[block], c, w);
  blocks_[block].function.value(c.argument.data(), outputs);
}

}  // namespace saltus
