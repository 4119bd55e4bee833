#include "saltus/simulation/plants.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"
#include "saltus/ocp/interval_problem_of.hpp"

namespace saltus {
namespace {

IntervalProblem dynamics_only(IntervalProblem problem) {
  problem.running_cost = {};
  for (SwitchingSystem::Mode& mode : problem.switching.modes) mode.running_cost = {};
  problem.shape = InputShape::constant;
  problem.differentiate_time = false;
  problem.differentiate_parameter.assign(problem.arguments.np, false);
  return problem;
}

void expect_size(const char* what, Eigen::Index given, Eigen::Index expected) {
  if (given != expected)
    throw DefinitionError(
        fmt::format("plant: {} has {} entries, expected {}", what, given, expected));
}

}  // namespace

IntegratorPlant::IntegratorPlant(IntervalProblem problem, const IntegratorChoice& scheme,
                                 VectorXd start, VectorXd parameters, double time)
    : clock_(time), state_(std::move(start)), parameters_(std::move(parameters)) {
  if (!scheme) throw DefinitionError("plant: no integrator is given");
  if (!problem.dynamics) throw DefinitionError("plant: no dynamics are given");
  expect_size("the start", state_.size(), problem.arguments.nx);
  expect_size("the vector of parameters", parameters_.size(), problem.arguments.np);
  const bool has_events = !problem.switching.empty();
  integrator_ = scheme->make(dynamics_only(std::move(problem)));
  hybrid_ = dynamic_cast<EventIntegrator*>(integrator_.get());
  if (has_events && hybrid_ == nullptr)
    throw DefinitionError(fmt::format("plant: {} does not handle events", scheme->name()));
  name_ = scheme->name();
  w_.resize(integrator_->arguments().size());
  end_.resize(integrator_->outputs());
}

Integrator& IntegratorPlant::integrator() const {
  if (!integrator_) throw DefinitionError("plant: it was moved from");
  return *integrator_;
}

// Converts exceptions of formulas to a message.
bool IntegratorPlant::integrate(double length) {
  const std::size_t known = events_.size();
  try {
    const IntegrationStatus status = evaluate(length);
    if (status == IntegrationStatus::success) return true;
    const std::string sentence = integrator_->failure();
    failure_ = sentence.empty() ? describe(status) : sentence;
  } catch (...) {
    if (hybrid_ != nullptr) hybrid_->record(nullptr);
    events_.resize(known);
    failure_ = fmt::format("between t = {:.6g} s and {:.6g} s a formula threw: {}", time(),
                           time() + length, describe_exception());
  }
  return false;
}

IntegrationStatus IntegratorPlant::evaluate(double length) {
  if (hybrid_ == nullptr) return integrator_->value(w_.data(), end_.data());
  const std::size_t known = events_.size();
  hybrid_->record(&events_);
  hybrid_->start_in(mode_);
  const IntegrationStatus status = hybrid_->value(w_.data(), end_.data());
  hybrid_->record(nullptr);
  if (status != IntegrationStatus::success)
    events_.resize(known);
  else if (length > 0.0)
    mode_ = hybrid_->end_mode();
  return status;
}

bool IntegratorPlant::advance(const VectorRef& input, double length) {
  expect_size("the input", input.size(), inputs());
  if (!(length >= 0.0)) {
    failure_ = describe_bad_length(length);
    return false;
  }
  w_ << state_, input, parameters_, time(), length;
  if (!integrate(length)) return false;
  state_ = end_.head(state_.size());
  clock_.move_on(length);
  return true;
}

std::string IntegratorPlant::mode() const {
  integrator();
  if (hybrid_ == nullptr) return {};
  if (mode_ >= 0) return hybrid_->mode_name(mode_);
  // Before the first step, an interval of length zero determines the mode.
  VectorXd w(w_.size()), end(end_.size());
  w << state_, VectorXd::Zero(inputs()), parameters_, time(), 0.0;
  hybrid_->start_in(-1);
  try {
    return hybrid_->value(w.data(), end.data()) == IntegrationStatus::success
               ? hybrid_->mode_name(hybrid_->end_mode())
               : std::string();
  } catch (...) {  // exception of a formula; the first step reports it
    return {};
  }
}

void IntegratorPlant::disturb(const VectorRef& change) {
  expect_size("the disturbance of the state", change.size(), state_.size());
  state_ += change;
}

void IntegratorPlant::set_parameters(const VectorRef& parameters) {
  expect_size("the vector of parameters", parameters.size(), parameters_.size());
  parameters_ = parameters;
}

IntegratorPlant nominal_plant(const OptimalControlProblem& problem,
                              const IntegratorChoice& scheme) {
  if (problem.phases().empty()) throw DefinitionError("plant: the problem has no phase");
  const PhaseDefinition& phase = problem.phases().front();
  IntervalProblem interval = interval_problem_of(phase);
  VectorXd parameters(phase.sizes.np);
  Eigen::Index at = 0;
  for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
    parameters.segment(at, block.value.size()) = block.value;
    at += block.value.size();
  }
  return {std::move(interval), scheme, problem.start_guess(), std::move(parameters),
          problem.start_time()};
}

}  // namespace saltus
