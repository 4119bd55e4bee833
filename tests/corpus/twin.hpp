// A phase written twice from the same formulas: for the framework, and as plain functions for the
// judge.
#pragma once

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "saltus/ocp/phase.hpp"
#include "tests/corpus/outside.hpp"

namespace saltus::corpus {

namespace detail {

template <class S, int nx, int nu, int np, class F>
auto call(const F& f, const S* z, const std::vector<double>& data) {
  Vec<S, nx> x;
  Vec<S, nu> u;
  for (int i = 0; i < nx; ++i) x.data()[i] = z[1 + i];
  for (int i = 0; i < nu; ++i) u.data()[i] = z[1 + nx + i];
  if constexpr (std::is_invocable_v<const F&, S, Vec<S, nx>, Vec<S, nu>, Vec<S, np>>) {
    Vec<S, np> p;
    for (int i = 0; i < np; ++i) p.data()[i] = data[i];
    return f(z[0], x, u, p);
  } else if constexpr (std::is_invocable_v<const F&, S, Vec<S, nx>, Vec<S, nu>>) {
    return f(z[0], x, u);
  } else {
    return f(z[0], x);
  }
}

template <class S, int nx, int nu, int np, class F>
auto evaluator(F f, std::vector<double> data) {
  return [f = std::move(f), data = std::move(data)](const S* z, S* y) {
    const auto result = call<S, nx, nu, np>(f, z, data);
    if constexpr (std::is_base_of_v<Eigen::EigenBase<std::decay_t<decltype(result)>>,
                                    std::decay_t<decltype(result)>>) {
      for (int i = 0; i < static_cast<int>(result.size()); ++i) y[i] = result[i];
    } else {
      *y = S(result);
    }
  };
}

}  // namespace detail

/// A formula of nx states, nu inputs and data as the judge reads it.
template <int nx, int nu, int np, class F>
OutsideFormula outside_formula(const F& f, const std::vector<double>& data = {}) {
  return {outputs_of<nx, nu, np, F>, detail::evaluator<double, nx, nu, np>(f, data),
          detail::evaluator<Complex, nx, nu, np>(f, data)};
}

/// Both forms of a phase. One call per term fills both. Costs are integrals.
template <int nx, int nu, int np = 0>
class Twin {
 public:
  template <class F>
  Twin(const std::string& name, F field, Bounds duration, std::vector<double> data = {})
      : phase(name, field, duration), data_(std::move(data)) {
    outside.name = name;
    outside.nx = nx;
    outside.nu = nu;
    outside.field = erased(field);
    outside.input_bounds.assign(nu, unbounded());
    outside.duration = duration;
    if constexpr (np > 0) phase.data("data", Eigen::Map<const VectorXd>(data_.data(), np).eval());
  }
  Twin& bound_input(int i, Bounds bounds) {
    phase.bound_input(i, bounds);
    Bounds& known = outside.input_bounds[i];
    known = {std::max(known.lower, bounds.lower), std::min(known.upper, bounds.upper)};
    return *this;
  }
  Twin& bound_state(int i, Bounds bounds) {
    phase.bound_state(i, bounds);
    const auto state = [i](const auto&, const auto& x) { return x[i]; };
    outside.path.push_back({"state " + std::to_string(i), erased(state), {bounds}});
    return *this;
  }
  template <class F>
  Twin& keep(const std::string& name, F formula, Bounds bounds, Window window = {}) {
    OutsideRow row{name, erased(formula), std::vector<Bounds>(rows_of<F>, bounds)};
    if (window.from) row.from = window.from->seconds();
    if (window.to) row.to = window.to->seconds();
    outside.path.push_back(std::move(row));
    phase.keep(name, formula, bounds, window);
    return *this;
  }
  /// The judge expects the hard-constrained plan at the nodes for any weight.
  template <class F>
  Twin& keep_softly(const std::string& name, F formula, Bounds bounds, Penalty penalty) {
    OutsideRow row{name, erased(formula), std::vector<Bounds>(rows_of<F>, bounds)};
    row.nodes_only = true;
    outside.path.push_back(std::move(row));
    phase.keep(name, formula, bounds, {}, std::move(penalty));
    return *this;
  }
  template <class F>
  Twin& reach(const std::string& name, F formula, std::vector<Bounds> bounds) {
    outside.ends.push_back({name, erased(formula), bounds});
    phase.reach(name, formula, std::move(bounds));
    return *this;
  }
  template <class F>
  Twin& reach(const std::string& name, F formula, Bounds bounds) {
    return reach(name, formula, std::vector<Bounds>(rows_of<F>, bounds));
  }
  template <class F>
  Twin& minimise(const std::string& name, F formula) {
    outside.running_costs.push_back(erased(formula));
    phase.minimise(name, formula);
    return *this;
  }
  template <class F>
  Twin& minimise_at_end(const std::string& name, F formula) {
    outside.end_costs.push_back(erased(formula));
    phase.minimise_at_end(name, formula);
    return *this;
  }

  Phase<nx, nu, np> phase;
  OutsidePhase outside;

 private:
  template <class F>
  static constexpr int rows_of = outputs_of<nx, nu, np, F>;
  template <class F>
  OutsideFormula erased(const F& f) const {
    return outside_formula<nx, nu, np>(f, data_);
  }

  std::vector<double> data_;
};

}  // namespace saltus::corpus
