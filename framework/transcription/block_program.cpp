// Evaluation of a BlockProgram: blocks at a point, their values and derivatives added up.
#include "saltus/transcription/block_program.hpp"

#include <algorithm>
#include <cmath>

namespace saltus {

void BlockProgram::set_constant(int block, int argument, double value) {
  double& constant = blocks_[block].constants[argument];
  if (constant == value) return;
  constant = value;
  Compiled& c = compiled_[block];
  c.argument[argument] = value;  // variables are added when it is gathered
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

void BlockProgram::update(const Block& block, Compiled& c, const double* w, Level level) {
  if (c.point == point_ && c.level >= level) return;
  c.level = Level::none;  // in case the formula throws
  gather(block, c, w);
  // The slopes of an affine block are those of any point.
  if (level == Level::values || (c.is_affine && c.has_entries)) {
    block.function.value(c.argument.data(), c.value.data());
  } else {
    block.function.jacobian(c.argument.data(), c.value.data(), c.entries.data());
    c.has_entries = true;
  }
  c.level = level;
  c.point = point_;
}

bool BlockProgram::evaluate(const double* w, Level level) {
  move_to(w);
  if (evaluated_point_ == point_ && evaluated_revision_ == revision_ && level_ >= level)
    return finite_;
  evaluated_point_ = 0;  // in case a formula throws
  finite_ = true;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    Compiled& c = compiled_[i];
    const bool in_force = std::any_of(block.outputs.begin(), block.outputs.end(),
                                      [&](const BlockOutput& o) { return counts(o); });
    if (!in_force) continue;
    update(block, c, w, level);
    for (int o = 0; o < c.value.size(); ++o)
      if (!std::isfinite(c.value[o]) && counts(block.outputs[o])) finite_ = false;
  }
  level_ = level;
  evaluated_point_ = point_;
  evaluated_revision_ = revision_;
  return finite_;
}

bool BlockProgram::objective(const double* w, double& f) {
  if (!evaluate(w, Level::values)) return false;
  f = 0.0;
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (int o = 0; o < compiled_[i].value.size(); ++o)
      if (blocks_[i].outputs[o].row == BlockOutput::objective &&
          blocks_[i].outputs[o].factor != 0.0)
        f += blocks_[i].outputs[o].factor * compiled_[i].value[o];
  for (int i = 0; i < variables(); ++i)
    f += (linear_cost_[i] + 0.5 * quadratic_cost_[i] * w[i]) * w[i];
  return std::isfinite(f);
}

bool BlockProgram::gradient(const double* w, double* gradient) {
  if (!evaluate(w, Level::derivatives)) return false;
  for (int i = 0; i < variables(); ++i) gradient[i] = linear_cost_[i] + quadratic_cost_[i] * w[i];
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (const Scatter& s : compiled_[i].gradient) {
      const double weight = blocks_[i].outputs[s.output].factor;
      if (weight != 0.0) gradient[s.to] += weight * s.factor * compiled_[i].entries[s.from];
    }
  return std::all_of(gradient, gradient + variables(), [](double e) { return std::isfinite(e); });
}

bool BlockProgram::constraints(const double* w, double* g) {
  if (!evaluate(w, Level::values)) return false;
  std::fill_n(g, rows(), 0.0);
  for (const Linear& l : linear_) g[l.row] += l.coefficient * w[l.variable];
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (int o = 0; o < compiled_[i].value.size(); ++o) {
      const BlockOutput& output = blocks_[i].outputs[o];
      if (output.row != BlockOutput::objective && !is_off(output.row))
        g[output.row] += output.factor * compiled_[i].value[o];
    }
  return true;
}

bool BlockProgram::jacobian(const double* w, double* entries) {
  if (!evaluate(w, Level::derivatives)) return false;
  std::fill_n(entries, jacobian_pattern_.entries(), 0.0);
  for (const Linear& l : linear_) entries[l.position] += l.coefficient;
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (const Scatter& s : compiled_[i].jacobian) {
      const double entry = compiled_[i].entries[s.from];
      if (!is_off(blocks_[i].outputs[s.output].row)) entries[s.to] += s.factor * entry;
    }
  return std::all_of(entries, entries + jacobian_pattern_.entries(),
                     [](double e) { return std::isfinite(e); });
}

// Linear entries first: what a block has there as well is added.
bool BlockProgram::write_jacobian(const double* w, std::span<const EntryTarget> targets) {
  for (const Linear& l : linear_) {
    const EntryTarget& target = targets[l.position];
    const double value = target.scale * l.coefficient;
    *target.to = l.adds ? *target.to + value : value;
  }
  if (!evaluate(w, Level::derivatives)) return false;
  bool finite = true;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double* entries = compiled_[i].entries.data();
    const BlockOutput* outputs = blocks_[i].outputs.data();
    for (const Scatter& s : compiled_[i].jacobian) {
      if (is_off(outputs[s.output].row)) continue;
      const EntryTarget& target = targets[s.to];
      const double value = target.scale * (s.factor * entries[s.from]);
      *target.to = s.adds ? *target.to + value : value;
      finite = finite && std::isfinite(value);
    }
  }
  return finite;
}

void BlockProgram::multiply_jacobian(const VectorXd& v, VectorXd& out) const {
  out.setZero();
  for (const Linear& l : linear_) out[l.row] += l.coefficient * v[l.variable];
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (const Scatter& s : compiled_[i].jacobian) {
      const int row = blocks_[i].outputs[s.output].row;
      if (!is_off(row))
        out[row] += s.factor * compiled_[i].entries[s.from] * v[jacobian_pattern_.col(s.to)];
    }
}

void BlockProgram::add_jacobian_transposed(const VectorXd& lambda, VectorXd& out) const {
  for (const Linear& l : linear_) out[l.variable] += l.coefficient * lambda[l.row];
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (const Scatter& s : compiled_[i].jacobian) {
      const double multiplier = lambda[blocks_[i].outputs[s.output].row];
      if (multiplier != 0.0)
        out[jacobian_pattern_.col(s.to)] += s.factor * compiled_[i].entries[s.from] * multiplier;
    }
}

bool BlockProgram::hessian(const double* w, double sigma, const double* lambda, double* entries,
                           Curvature curvature) {
  move_to(w);
  std::fill_n(entries, hessian_pattern_.entries(), 0.0);
  for (const int v : quadratic_variables_)
    entries[quadratic_position_[v]] += sigma * quadratic_cost_[v];
  bool finite = true;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    Compiled& c = compiled_[i];
    if (c.hessian.empty()) continue;
    bool any = false;
    for (int o = 0; o < c.weights.size(); ++o) {
      const BlockOutput& output = block.outputs[o];
      const bool cost = output.row == BlockOutput::objective;
      c.weights[o] = cost ? sigma * output.factor : output.factor * lambda[output.row];
      // Gauss-Newton: constraints do not curve. Interval functions keep the costs they carry.
      if (!cost && (curvature == Curvature::gauss_newton || is_off(output.row))) c.weights[o] = 0.0;
      any = any || c.weights[o] != 0.0;
    }
    if (!any) continue;
    const bool known = c.has_hessian && (c.is_quadratic || c.hessian_point == point_) &&
                       c.hessian_curvature == curvature && c.hessian_weights == c.weights;
    if (!known) {
      c.has_hessian = false;  // in case the formula throws
      gather(block, c, w);
      block.function.hessian(c.argument.data(), c.weights.data(), c.hessian_entries.data(),
                             curvature);
      c.has_hessian = true;
      c.hessian_point = point_;
      c.hessian_curvature = curvature;
      c.hessian_weights = c.weights;
    }
    for (const Scatter& s : c.hessian) {
      entries[s.to] += s.factor * c.hessian_entries[s.from];
      finite = finite && std::isfinite(c.hessian_entries[s.from]);
    }
  }
  return finite;
}

void BlockProgram::evaluate_block(int block, const double* w, double* outputs) {
  Compiled& c = compiled_[block];
  gather(blocks_[block], c, w);
  blocks_[block].function.value(c.argument.data(), outputs);
}

}  // namespace saltus
