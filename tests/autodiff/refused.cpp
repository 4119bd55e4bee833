// Formulas that must be refused by the compiler, one per CASE_ definition; none defined: all fine.
#include "saltus/model/make_function.hpp"

using namespace saltus;

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
#elif defined(CASE_wrong_arity)
  return make_function<1, 0, 0>([](const auto& x) { return x; });
#elif defined(CASE_dangling_expression)
  return make_function<2, 0, 0>([](auto, auto x) { return 2.0 * x; });
#elif defined(CASE_dynamic_result)
  return make_function<2, 0, 0>([](const auto& t, const auto&) {
    return Eigen::Matrix<std::decay_t<decltype(t)>, Eigen::Dynamic, 1>(3);
  });
#else
  return make_function<2, 0, 0>([](auto, auto x) { return (2.0 * x).eval(); });
#endif
}
