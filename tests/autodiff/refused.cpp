// Formulas that the compiler must refuse, one per CASE_ definition. Without one, the file compiles.
#include "saltus/model/make_function.hpp"

using namespace saltus;

struct Doubles {
  template <class S>
  Vec<double, 2> operator()(const S&, const Vec<S, 2>& x) const {
    return {x[1], x[0]};
  }
};

Function f() {
#if defined(CASE_branch_on_state)
  return make_function<1, 0, 0>([](const auto&, const auto& x) {
    if (x[0] > 0) return 2.0 * x[0];
    return 1.0 * x[0];
  });
#elif defined(CASE_branch_inside_eigen)
  return make_function<3, 0, 0>([](const auto&, const auto& x) { return x.normalized(); });
#elif defined(CASE_lose_derivatives)
  return make_function<1, 0, 0>([](const auto&, const auto& x) {
    const double number = x[0];
    return number * x[0];
  });
#elif defined(CASE_vector_of_doubles)
  return make_function<2, 0, 0>([](const auto&, const auto& x) {
    return Vec<double, 2>{x[1], x[0]};
  });
#elif defined(CASE_declared_vector_of_doubles)
  return make_function<2, 0, 0>(Doubles{});
#elif defined(CASE_state_for_time)
  return make_function<2, 1, 0>([](const auto& x, const auto& u) { return x[0] * u[0]; });
#elif defined(CASE_state_for_time_in_parentheses)
  return make_function<2, 1, 0>([](const auto& x, const auto& u) { return x(0) * u(0); });
#elif defined(CASE_wrong_size)
  return make_function<3, 0, 0>(Doubles{});
#elif defined(CASE_doubles_only)
  return make_function<1, 0, 0>([](double, const VectorXd& x) { return x[0]; });
#elif defined(CASE_standard_sine)
  return make_function<1, 0, 0>([](const auto&, const auto& x) { return std::sin(x[0]); });
#elif defined(CASE_standard_power)
  return make_function<1, 0, 0>([](const auto&, const auto& x) { return std::pow(x[0], 2); });
#elif defined(CASE_standard_absolute_value)
  return make_function<1, 0, 0>([](const auto&, const auto& x) { return std::abs(2 * x[0]); });
#elif defined(CASE_standard_maximum)
  return make_function<1, 0, 0>([](const auto&, const auto& x) { return std::max(x[0], 0.0); });
#elif defined(CASE_standard_maximum_of_two)
  return make_function<2, 0, 0>([](const auto&, const auto& x) { return std::max(x[0], x[1]); });
#elif defined(CASE_wrong_arity)
  return make_function<1, 0, 0>([](const auto& x) { return x; });
#elif defined(CASE_dangling_expression)
  return make_function<2, 0, 0>([](auto, auto x) { return 2.0 * x; });
#elif defined(CASE_dynamic_result)
  return make_function<2, 0, 0>([](const auto& t, const auto&) {
    return Eigen::Matrix<std::decay_t<decltype(t)>, Eigen::Dynamic, 1>(3);
  });
#else
  return make_function<2, 0, 0>([](auto, auto x) { return (2 * x).eval(); });
#endif
}
