// Problems that the compiler must refuse, one per CASE_ definition. Without one, the file compiles.
#include <cmath>
#include <type_traits>

#include "saltus/model/automaton.hpp"
#include "saltus/ocp/link.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/simulation/plants.hpp"
using namespace saltus;

struct Cart {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0]};
  }
};
struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
#ifdef CASE_standard_sine_in_struct
    return {x[1], u[0] - std::sin(x[0])};
#else
    return {x[1], u[0] - sin(x[0])};
#endif
  }
};
// Returns a number of entries that differs from its declaration.
template <int rows>
struct Braces {
  template <class S>
  Vec<S, rows> operator()(const S&, const Vec<S, rows>& x, const Vec<S, 1>& u) const {
#if defined(CASE_one_entry_too_many)
    return {x[1], u[0], x[0]};
#elif defined(CASE_three_entries_too_many)
    return {x[1], u[0], x[0], x[0], x[0]};
#elif defined(CASE_one_entry_too_few)
    return {x[1], u[0]};
#elif defined(CASE_other_vector_returned)
    return Vec<S, rows + 1>::Zero();
#else
    return 0.0 * u[0] * x;
#endif
  }
};
// Declares a number of rows that differs from the number of states of the phase.
template <int rows>
struct Rows {
  template <class S>
  Vec<S, rows> operator()(const S&, const Vec<S, 2>&) const {
    return Vec<S, rows>::Zero();
  }
};
struct OfThreeStates {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>&) const {
    return {x[1], x[2]};
  }
};
struct NotConst {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) {
    return {x[1], u[0]};
  }
};

void define() {
  const Bounds seconds = between(0.1, 2.0);
  Phase<2, 1> phase{"phase", Cart{}, seconds};
  Automaton<2, 1> automaton;
  automaton.mode("one", Cart{}).mode("two", Pendulum{});
  const auto first = [](auto, const auto& x) { return x[0]; };
  const auto both = [](auto, const auto& x) { return (1.0 * x).eval(); };
  const auto dynamics = [](auto, const auto& x, const auto&, const auto&) {
    return (1.0 * x).eval();
  };
  const auto equation = [](auto, const auto& x, const auto& z, const auto&) { return x[0] - z[0]; };
  const Vec<double, 1> guess{0.0};
#if defined(CASE_standard_sine_in_struct)
  Phase<2, 1>{"pendulum", Pendulum{}, seconds};
#elif defined(CASE_one_entry_too_many) || defined(CASE_three_entries_too_many) || \
    defined(CASE_other_vector_returned)
  Phase<2, 1>{"braces", Braces<2>{}, seconds};
#elif defined(CASE_one_entry_too_few)
  Phase<3, 1>{"braces", Braces<3>{}, seconds};
#elif defined(CASE_rows_of_struct)
  Phase<2, 1>{"rows", Rows<3>{}, seconds};
#elif defined(CASE_rows_of_lambda)
  Phase<2, 1>{"rows", first, seconds};
#elif defined(CASE_states_of_struct)
  Phase<2, 1>{"states", OfThreeStates{}, seconds};
#elif defined(CASE_not_const)
  Phase<2, 1>{"states", NotConst{}, seconds};
#elif defined(CASE_no_formula)
  phase.keep("number", 3.0, between(0, 1));
#elif defined(CASE_cosine_in_keep)
  phase.keep(
      "cos", [](auto, const auto& x) { return std::cos(x[0]); }, between(0, 1));
#elif defined(CASE_root_in_reach)
  phase.reach(
      "root", [](auto, const auto& x) { return std::sqrt(x[0]); }, between(0, 1));
#elif defined(CASE_exponential_in_minimise)
  phase.minimise("exp", [](auto, const auto& x) { return std::exp(x[0]) + x[1]; });
#elif defined(CASE_power_in_minimise_at_end)
  phase.minimise_at_end("pow", [](auto, const auto& x) { return std::pow(x[0], 2) + x[1]; });
#elif defined(CASE_tanh_in_track)
  phase.track(
      "tanh", [](auto, const auto& x) { return std::tanh(2 * x[0]); }, VectorXd::Ones(1));
#elif defined(CASE_vector_as_cost)
  phase.minimise("both", both);
#elif defined(CASE_vector_as_cost_at_end)
  phase.minimise_at_end("both", both);
#elif defined(CASE_abs_in_guard)
  phase.ends_when(
      "abs", [](auto, const auto& x) { return std::abs(x[0]); }, Crossing::rising);
#elif defined(CASE_vector_as_guard)
  phase.ends_when("both", both, Crossing::rising);
#elif defined(CASE_rows_of_switch)
  phase.switch_at("switch", first, first);
#elif defined(CASE_sine_in_switch)
  phase.switch_at(
      "switch", [](auto, const auto& x) { return std::sin(x[0]); }, Rows<2>{});
#elif defined(CASE_rows_of_reset)
  phase.on("reset", first, Crossing::rising, first);
#elif defined(CASE_sine_in_jump)
  jump<2>("jump", [](auto, const auto& x) { return (std::sin(x[0]) * x).eval(); });
#elif defined(CASE_sine_in_link)
  make_link(
      "link", [](const auto& a) { return std::sin(a.x[0]); }, between(0, 1), end_of(phase));
#elif defined(CASE_ends_of_link)
  make_link(
      "link", [](const auto& a, const auto& b) { return a.x[0] - b.x[0]; }, between(0, 1),
      end_of(phase));
#elif defined(CASE_rows_of_equations)
  Phase<2, 1, 0, 1>{"dae", dynamics, dynamics, guess, seconds};
#elif defined(CASE_rows_of_dae)
  Phase<2, 1, 0, 1>{"dae", equation, equation, guess, seconds};
#elif defined(CASE_sine_in_equations)
  Phase<2, 1, 0, 1>{"dae", dynamics,
                    [](auto, const auto& x, const auto& z) { return x[0] - std::sin(z[0]); }, guess,
                    seconds};
#elif defined(CASE_arguments_of_dae)
  Phase<2, 1, 0, 1>{"dae", [](const auto& x) { return x; }, equation, guess, seconds};
#elif defined(CASE_rows_of_mode)
  automaton.mode("three", Rows<3>{});
#elif defined(CASE_rows_of_event)
  automaton.event("event", "one", "two", both, Crossing::rising);
#elif defined(CASE_rows_of_plant)
  make_plant<2, 1>(Rows<1>{}, {}, VectorXd::Zero(2));
#else
  // Valid variants: every kind of number, and choices between a number and a scalar.
  phase.keep(
      "numbers",
      [](const auto& t, const auto& x) {
        using S = std::decay_t<decltype(t)>;
        enum { three = 3 };
        const S chosen = three > 2 ? x[0] : 1.0;
        return S(2 * x[0] + x[1] / 2 - 1.5F * x[0] + 2.0L * x[1] + three * x[0] +
                 Eigen::Index(3) * chosen);
      },
      between(0, 1));
  Phase<2, 1>{"braces", Braces<2>{}, seconds};
  Phase<2, 1, 0, 1>{"dae", dynamics, equation, guess, seconds};
  phase.switch_at("switch", first, Rows<2>{}).on("reset", first, Crossing::rising, both);
#endif
}
