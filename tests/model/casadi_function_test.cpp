// Tests functions of CasADi's generated code against the same formula in C++, and their refusals.
#include "saltus/model/casadi_function.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

constexpr Arguments sizes{2, 1, 1};

Function load(const std::string& name) {
  return load_casadi(SALTUS_GENERATED_PENDULUM, name, sizes);
}

struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return {x[1], p[0] * sin(x[0]) + u[0]};
  }
};

TEST(CasadiFunction, EqualsTheFormula) {
  const Function loaded = load("pendulum"), native = make_function<2, 1, 1>(Pendulum{});
  EXPECT_EQ(loaded.jacobian_pattern(), native.jacobian_pattern());
  EXPECT_EQ(loaded.hessian_pattern(), native.hessian_pattern());
  const VectorXd z{{0.0, 0.7, -0.3, 0.5, 2.0}}, weights{{0.4, 1.5}};
  // The same operations in both.
  EXPECT_LE((loaded(z) - native(z)).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LE((loaded.dense_jacobian(z) - native.dense_jacobian(z)).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LE(
      (loaded.dense_hessian(z, weights) - native.dense_hessian(z, weights)).cwiseAbs().maxCoeff(),
      1e-15);
}

TEST(CasadiFunction, FailuresOfTheCodeAreNaN) {
  const VectorXd z{{0.0, 101.0, 0.0, 0.0, 1.0}};
  const Function loaded = load("pendulum");
  EXPECT_TRUE(std::isnan(loaded(z)[0]));
  EXPECT_TRUE(std::isnan(loaded.dense_jacobian(z)(0, 2)));
}

TEST(CasadiFunction, SeparateCopiesDoNotAllocate) {
  const Function loaded = load("pendulum").separate();
  const VectorXd z{{0.0, 0.7, -0.3, 0.5, 2.0}}, weights{{0.4, 1.5}};
  double y[2], jacobian[4], hessian[2];
  const saltus::testing::AllocationCount count;
  loaded.value(z.data(), y);
  loaded.derivatives(z.data(), weights.data(), y, jacobian, hessian, Curvature::exact);
  EXPECT_EQ(count.made(), 0);
}

template <class Error>
std::string refusal(const std::string& library, const std::string& name, const Arguments& given) {
  try {
    load_casadi(library, name, given);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CasadiFunction, RefusalsSayWhy) {
  const std::string here = SALTUS_GENERATED_PENDULUM;
  const auto contains = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  contains(refusal<InputError>("absent.so", "f", sizes), "cannot load the library");
  contains(refusal<InputError>(here, "absent", sizes), "there is no function 'absent'");
  contains(refusal<InputError>(here, "alone", sizes), "'alone_jacobian' of CasADi; generate");
  contains(refusal<DefinitionError>(here, "pendulum", {3, 1, 1}),
           "'pendulum' has 2 entries in input 1, but x has 3");
  contains(refusal<DefinitionError>(here, "upper", sizes), "it must return the lower triangle");
}

}  // namespace
}  // namespace saltus
