#include "saltus/transcription/interval_function.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

using Flags = std::vector<char>;  // per argument of the interval

void unite(Flags& into, const Flags& from) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = into[i] || from[i];
}

// Dependence of model arguments (t, x, u, p) on arguments of the interval.
class Reach {
 public:
  explicit Reach(const IntervalProblem& problem, const IntervalArguments& w)
      : arguments_(problem.arguments), reach_(arguments_.size(), Flags(w.size(), 0)) {
    const Arguments& a = arguments_;
    for (int i = 0; i < a.nx; ++i) reach_[a.x(i)][w.x(i)] = 1;
    for (int i = 0; i < a.nu; ++i) {
      reach_[a.u(i)][w.c(i)] = 1;
      if (problem.shape == InputShape::linear) reach_[a.u(i)][w.c(a.nu + i)] = 1;
    }
    for (int i = 0; i < a.np; ++i)
      if (problem.differentiate_parameter[i]) reach_[a.p(i)][w.p(i)] = 1;
    if (problem.differentiate_time) reach_[a.t()][w.t0()] = reach_[a.t()][w.h()] = 1;

    bool grew = true;
    while (grew) {
      grew = false;
      for (int i = 0; i < a.nx; ++i) {
        Flags& state = reach_[a.x(i)];
        const Flags before = state;
        unite(state, of_output(problem.dynamics, i));
        for (const SwitchingSystem::Mode& mode : problem.switching.modes)
          unite(state, of_output(mode.dynamics, i));
        for (const SwitchingSystem::Transition& event : problem.switching.transitions) {
          unite(state, of_output(event.guard, 0));  // through the time of the event
          if (event.reset) unite(state, of_output(event.reset, i));
        }
        if (problem.differentiate_time) state[w.h()] = 1;
        grew = grew || state != before;
      }
    }
  }

  const Flags& of_argument(int a) const { return reach_[a]; }
  Flags of_output(const Function& f, int output) const {
    Flags flags(reach_.front().size(), 0);
    const SparsityPattern& pattern = f.jacobian_pattern();
    for (int e = pattern.row_begin(output); e < pattern.row_end(output); ++e)
      unite(flags, reach_[pattern.col(e)]);
    return flags;
  }

 private:
  Arguments arguments_;
  std::vector<Flags> reach_;
};

class IntervalFunction final : public FunctionBody {
 public:
  IntervalFunction(std::shared_ptr<Integrator> integrator, IntegratorChoice scheme,
                   SelectiveStack costs, std::vector<int> optional)
      : FunctionBody(integrator->arguments().size() + static_cast<int>(optional.size()),
                     integrator->outputs()),
        integrator_(std::move(integrator)),
        scheme_(std::move(scheme)),
        costs_(std::move(costs)),
        optional_(std::move(optional)),
        derivative_(outputs(), integrator_->arguments().size()),
        second_(derivative_.cols(), derivative_.cols()) {
    for (const int cost : optional_) costs_.evaluate(cost, false);
    const IntervalProblem& problem = integrator_->problem();
    const IntervalArguments w = integrator_->arguments();
    const Reach reach(problem, w);
    std::vector<std::pair<int, int>> first, second;

    for (int i = 0; i < outputs(); ++i) {
      const bool is_state = i < problem.arguments.nx;
      Flags row = is_state ? reach.of_argument(problem.arguments.x(i))
                           : reach.of_output(problem.running_cost, i - problem.arguments.nx);
      for (const SwitchingSystem::Transition& event : problem.switching.transitions)
        unite(row, reach.of_output(event.guard, 0));
      for (const SwitchingSystem::Mode& mode : problem.switching.modes)
        if (!is_state && mode.running_cost)
          unite(row, reach.of_output(mode.running_cost, i - problem.arguments.nx));
      if (problem.differentiate_time) row[w.h()] = 1;
      for (int j = 0; j < w.size(); ++j)
        if (row[j]) first.emplace_back(i, j);
    }
    const auto add_pairs = [&](const Flags& a, const Flags& b) {
      for (int i = 0; i < w.size(); ++i)
        for (int j = 0; j < w.size(); ++j)
          if (a[i] && b[j]) second.emplace_back(std::max(i, j), std::min(i, j));
    };
    const auto add_function = [&](const Function& f) {
      if (!f) return;
      f.hessian_pattern().for_each(
          [&](int a, int b, int) { add_pairs(reach.of_argument(a), reach.of_argument(b)); });
      if (!problem.differentiate_time) return;
      Flags length(w.size(), 0);  // h multiplies the right-hand side
      length[w.h()] = 1;
      for (int i = 0; i < f.outputs(); ++i) add_pairs(length, reach.of_output(f, i));
    };
    if (integrator_->has_hessian() && problem.switching.empty()) {
      add_function(problem.dynamics);
      add_function(problem.running_cost);
    } else if (integrator_->has_hessian()) {  // event times couple their arguments
      Flags any(w.size(), 0);
      for (const auto& [row, column] : first) any[column] = 1;
      add_pairs(any, any);
    }
    jacobian_pattern_ = SparsityPattern::from_pairs(outputs(), inputs(), std::move(first));
    hessian_pattern_ = SparsityPattern::from_pairs(inputs(), inputs(), std::move(second));
  }

  // The flow of affine dynamics is affine. A running cost along it keeps its degree.
  int degree(int output, const std::vector<char>& variable) const override {
    const IntervalProblem& problem = integrator_->problem();
    const IntervalArguments w = integrator_->arguments();
    const Arguments& a = problem.arguments;
    if (variable[w.t0()] || variable[w.h()] || !problem.switching.empty()) return 3;
    std::vector<char> in_model(a.size(), 0);
    for (int i = 0; i < a.nx + a.nu; ++i) in_model[a.x(i)] = 1;
    for (int i = 0; i < a.np; ++i) in_model[a.p(i)] = variable[w.p(i)];
    for (int i = 0; i < a.nx; ++i)
      if (problem.dynamics.degree(i, in_model) > 1) return 3;
    for (int i = 0; i < a.np; ++i)
      if (variable[w.p(i)] && depends_on(problem.dynamics, a.p(i))) return 3;
    return output < a.nx ? 1 : problem.running_cost.degree(output - a.nx, in_model);
  }

  // Data and times may be read without being differentiated.
  bool reads(int input) const override {
    const IntervalProblem& problem = integrator_->problem();
    const IntervalArguments w = integrator_->arguments();
    const auto model_reads = [&](int argument) {
      const auto reads_it = [&](const Function& f) { return f && f.reads(argument); };
      bool found = reads_it(problem.dynamics) || reads_it(problem.running_cost);
      for (const SwitchingSystem::Mode& mode : problem.switching.modes)
        found = found || reads_it(mode.dynamics) || reads_it(mode.running_cost);
      for (const SwitchingSystem::Transition& event : problem.switching.transitions)
        found = found || reads_it(event.guard) || reads_it(event.reset);
      return found;
    };
    if (input >= w.size()) return true;
    if (input == w.t0()) return model_reads(problem.arguments.t());
    if (input >= w.p() && input < w.t0()) return model_reads(problem.arguments.p(input - w.p()));
    return true;
  }

  void value(const double* w, double* end) const override {
    const Selection selection(*this, w);
    if (integrator_->value(w, end) != IntegrationStatus::success) spoil(end, outputs());
  }

  void jacobian(const double* w, double* end, double* entries) const override {
    const Selection selection(*this, w);
    if (integrator_->jacobian(w, end, derivative_) != IntegrationStatus::success) {
      spoil(end, outputs());
      spoil(entries, jacobian_pattern_.entries());
      return;
    }
    jacobian_pattern_.for_each([&](int r, int c, int e) { entries[e] = derivative_(r, c); });
  }

  void hessian(const double* w, const double* weights, double* entries,
               Curvature curvature) const override {
    const Selection selection(*this, w);
    if (integrator_->hessian(w, weights, second_, curvature) != IntegrationStatus::success) {
      spoil(entries, hessian_pattern_.entries());
      return;
    }
    hessian_pattern_.for_each([&](int r, int c, int e) { entries[e] = second_(r, c); });
  }

  void derivatives(const double* w, const double* weights, double* end, double* jacobian_entries,
                   double* hessian_entries, Curvature curvature) const override {
    const Selection selection(*this, w);
    if (integrator_->derivatives(w, weights, end, derivative_, second_, curvature) !=
        IntegrationStatus::success) {
      spoil(end, outputs());
      spoil(jacobian_entries, jacobian_pattern_.entries());
      spoil(hessian_entries, hessian_pattern_.entries());
      return;
    }
    jacobian_pattern_.for_each(
        [&](int r, int c, int e) { jacobian_entries[e] = derivative_(r, c); });
    hessian_pattern_.for_each([&](int r, int c, int e) { hessian_entries[e] = second_(r, c); });
  }

  std::shared_ptr<const FunctionBody> separate() const override {
    if (!scheme_) return nullptr;
    SelectiveStack costs = costs_.separate();
    IntervalProblem problem = integrator_->problem();
    if (costs_.size() > 0) {
      if (costs.size() == 0) return nullptr;
      problem.running_cost = costs.function();
    }
    return std::make_shared<IntervalFunction>(scheme_->make(problem), scheme_, std::move(costs),
                                              optional_);
  }

 private:
  // Enables optional costs during one call.
  class Selection {
   public:
    Selection(const IntervalFunction& function, const double* w) : function_(function) {
      const int first = function_.integrator_->arguments().size();
      for (std::size_t i = 0; i < function_.optional_.size(); ++i)
        function_.costs_.evaluate(function_.optional_[i], w[first + i] != 0.0);
    }
    ~Selection() {
      for (const int cost : function_.optional_) function_.costs_.evaluate(cost, false);
    }
    Selection(const Selection&) = delete;
    Selection& operator=(const Selection&) = delete;

   private:
    const IntervalFunction& function_;
  };

  static void spoil(double* values, int count) {
    std::fill_n(values, count, std::numeric_limits<double>::quiet_NaN());
  }

  std::shared_ptr<Integrator> integrator_;
  IntegratorChoice scheme_;
  SelectiveStack costs_;
  std::vector<int> optional_;
  mutable MatrixXd derivative_, second_;
};

}  // namespace

Function interval_function(std::shared_ptr<Integrator> integrator, IntegratorChoice scheme,
                           SelectiveStack costs, std::vector<int> optional) {
  return Function(std::make_shared<IntervalFunction>(std::move(integrator), std::move(scheme),
                                                     std::move(costs), std::move(optional)));
}

}  // namespace saltus
