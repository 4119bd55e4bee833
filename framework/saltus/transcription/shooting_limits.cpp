// Rows of integrals along phases and of links between their ends; see framework/design/links.md.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

// An integral begins at zero, or at its value from the last phase with that integral.
void ShootingProgram::build_integral_start(int j) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const int ni = static_cast<int>(phase.integrals.size());
  const int first = new_rows(ni, fmt::format("phase '{}', start of integral", phase.name));
  integral_start_rows_.push_back(first);
  for (int i = 0; i < ni; ++i) {
    bound_row(first + i, 0.0, 0.0);
    add_linear(first + i, layout_.integral(j, 0) + i, 1.0);
    int from = j - 1, there = -1;
    for (; from >= 0 && there < 0; --from)
      there = problem_.phases()[from].integral_index(phase.integrals[i].name);
    if (there >= 0)
      add_linear(first + i, layout_.integral(from + 1, grid_.intervals(from + 1)) + there, -1.0);
  }
}

void ShootingProgram::build_integral_limits(int j) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const int end = grid_.intervals(j);
  for (int i = 0; i < static_cast<int>(phase.integrals.size()); ++i) {
    const IntegralConstraint& integral = phase.integrals[i];
    LimitInstance instance;
    instance.phase = j;
    instance.point = {.phase = j, .node = end};
    instance.integral = i;
    instance.first_row = new_rows(1, describe_limit(instance) + ", row");
    add_linear(instance.first_row, layout_.integral(j, end) + i, integral.magnitude);
    limits_.push_back(std::move(instance));
  }
}

// Arguments of the link: (nothing | t duration x p | ...), one group per end.
void ShootingProgram::build_link(int l) {
  const Link& link = problem_.links()[l];
  LimitInstance instance;
  instance.link = l;
  instance.count = link.function.outputs();
  Block block(link.function);
  std::vector<BlockInstance> placed;
  int first = 1;
  for (const Link::End& end : link.ends) {
    const int j = problem_.phase_index(end.phase);
    const PhaseDefinition& phase = problem_.phases()[j];
    const GridPoint point{.phase = j, .node = end.is_end ? grid_.intervals(j) : 0};
    if (placed.empty() || j > instance.phase || (j == instance.phase && end.is_end)) {
      instance.phase = j;
      instance.point = point;
    }
    const int state = first + 2, parameter = state + end.nx;
    block.coefficients[first] = time_coefficients(point);
    block.coefficients[first + 1] = offset_coefficients(j, 1.0);
    for (int i = 0; i < end.nx; ++i)
      block.coefficients[state + i] = {{layout_.state(j, point.node) + i, phase.nominal_state[i]}};
    for (int i = 0; i < end.np; ++i)
      if (layout_.parameter(j, i) >= 0)
        block.coefficients[parameter + i] = {{layout_.parameter(j, i), phase.nominal_parameter(i)}};
    BlockInstance where{-1, point, first, -1, end.np > 0 ? parameter : -1};
    where.duration_argument = first + 1;
    placed.push_back(where);
    first += end.size();
  }
  if (link.is_cost) {
    block.outputs = {BlockOutput{}};
  } else {
    instance.first_row = new_rows(instance.count, describe_limit(instance) + ", row");
    for (int i = 0; i < instance.count; ++i) block.outputs.push_back({instance.first_row + i, 1.0});
  }
  const int index = add_block(std::move(block));
  for (BlockInstance& where : placed) {
    where.block = index;
    placed_.push_back(where);
  }
  if (link.is_cost)
    link_costs_.push_back({l, instance.phase, index});
  else
    limits_.push_back(std::move(instance));
}

const Limits& ShootingProgram::limits_of(const LimitInstance& instance) const {
  return instance.link >= 0 ? problem_.links()[instance.link].limits
                            : problem_.phases()[instance.phase].integrals[instance.integral].limits;
}

std::string ShootingProgram::describe_limit(const LimitInstance& instance) const {
  if (instance.link >= 0) return fmt::format("link '{}'", problem_.links()[instance.link].name);
  const PhaseDefinition& phase = problem_.phases()[instance.phase];
  return fmt::format("phase '{}', integral '{}'", phase.name,
                     phase.integrals[instance.integral].name);
}

// Charged once, not per unit of time.
void ShootingProgram::build_limit_slacks() {
  for (LimitInstance& instance : limits_) {
    const Limits& limits = limits_of(instance);
    for (auto* slacks : {&instance.slack_below, &instance.slack_above, &instance.slack_free})
      slacks->assign(instance.count, -1);
    if (!limits.soft) continue;
    const Penalty::Slacks slacks = penalty_slacks(*limits.soft);
    const auto add = [&](int row, double sign, const Penalty::SlackCost& cost) {
      const int slack = add_variables(1);
      add_linear(row, slack, sign);
      penalty_blocks_.push_back(-1);
      if (cost.is_quadratic) declare_quadratic(slack);
      return slack;
    };
    for (int i = 0; i < instance.count; ++i) {
      const int row = instance.first_row + i;
      const Bounds& b = limits.bounds[limits.bounds.size() > 1 ? i : 0];
      if (std::isfinite(b.lower)) instance.slack_below[i] = add(row, 1.0, slacks.side);
      if (std::isfinite(b.upper)) instance.slack_above[i] = add(row, -1.0, slacks.side);
      if (slacks.free && !b.is_free()) instance.slack_free[i] = add(row, 1.0, *slacks.free);
    }
  }
}

// Links and integrals are always active and charged once.
void ShootingProgram::refresh_limits() {
  for (const LimitInstance& instance : limits_) {
    const Limits& limits = limits_of(instance);
    for (int i = 0; i < instance.count; ++i) {
      const Bounds& b = limits.bounds[limits.bounds.size() > 1 ? i : 0];
      bound_row(instance.first_row + i, b.lower, b.upper);
      if (!limits.soft) continue;
      const Penalty::Slacks slacks = penalty_slacks(*limits.soft);
      for (const int slack : {instance.slack_below[i], instance.slack_above[i]})
        if (slack >= 0) {
          bound_variable(slack, 0.0, infinity);
          charge_slack(slack, slacks.side, 1.0, 1.0);
        }
      if (const int slack = instance.slack_free[i]; slack >= 0)
        charge_slack(slack, *slacks.free, 1.0, 1.0);
    }
  }
}

void ShootingProgram::fill_integrals(VectorXd& w) {
  std::map<std::string, double> reached;
  VectorXd outputs;
  for (const shooting::IntervalInstance& instance : intervals_) {
    const int j = instance.phase, k = instance.interval;
    const PhaseDefinition& phase = problem_.phases()[j];
    if (phase.integrals.empty()) continue;
    outputs.resize(block_outputs(instance.block));
    evaluate_block(instance.block, w.data(), outputs.data());
    const int ni = static_cast<int>(phase.integrals.size());
    for (int i = 0; i < ni; ++i) {
      const IntegralConstraint& integral = phase.integrals[i];
      double& so_far = reached[integral.name];
      if (k == 0) w[layout_.integral(j, 0) + i] = so_far;
      const double part = outputs[outputs.size() - ni + i] / integral.magnitude;
      if (std::isfinite(part)) so_far += part;
      w[layout_.integral(j, k + 1) + i] = so_far;
    }
  }
}

}  // namespace saltus
