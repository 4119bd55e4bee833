// Algebraic states eliminated from formulas: values, derivatives, sparsity, and messages where no
// solution is found.
#include "saltus/model/algebraic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "saltus/core/error.hpp"
#include "saltus/model/derivative_check.hpp"
#include "saltus/model/make_function.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

constexpr int nx = 2, nu = 1, np = 1, nz = 3;
constexpr Arguments sizes{nx, nu, np};

template <class F>
Function extended(F formula) {
  return make_function<nx + nz, nu, np>(FormulaWithAlgebraic<nx, nz, F>{std::move(formula)});
}

// z0 = sqrt(x0^2 + p) from its square, z1 from Kepler's equation, z2 from both.
struct Equations {
  template <class S>
  Vec<S, nz> operator()(const S& t, const Vec<S, nx>& x, const Vec<S, nz>& z, const Vec<S, nu>& u,
                        const Vec<S, np>& p) const {
    return {z[0] * z[0] - x[0] * x[0] - p[0], z[1] - 0.5 * sin(z[1]) - u[0] * x[1],
            z[2] * (2.0 + cos(z[1])) - z[0] - t};
  }
};

std::shared_ptr<const AlgebraicEquations> equations() {
  return std::make_shared<const AlgebraicEquations>(sizes, extended(Equations{}),
                                                    Vec<double, nz>{1.0, 0.0, 1.0});
}

// (t | x | u | p)
const VectorXd point = (VectorXd(5) << 0.3, 1.2, -0.7, 0.9, 0.8).finished();

TEST(Algebraic, StatesSatisfyTheirEquations) {
  const VectorXd z = algebraic_states(equations())(point);
  constexpr double rounding = 4e-16;
  EXPECT_NEAR(z[0], std::sqrt(1.2 * 1.2 + 0.8), rounding);
  EXPECT_NEAR(z[1] - 0.5 * std::sin(z[1]), -0.63, rounding);
  EXPECT_NEAR(z[2], (z[0] + 0.3) / (2.0 + std::cos(z[1])), rounding);
}

// z + z^2 / c = c: the relative result is the same for every c. The start gives no scale.
TEST(Algebraic, SmallStatesAreAsAccurateAsLargeOnes) {
  for (double c = 1.0; c > 5e-13; c *= 0.1) {
    const auto equation = [c](const auto&, const auto& x) {
      return Vec<std::decay_t<decltype(x[0])>, 1>{x[1] + x[1] * x[1] / c - x[0]};
    };
    const AlgebraicEquations single({1, 0, 0}, make_function<2, 0, 0>(equation), VectorXd{{0.0}});
    const ConsistentStart start = consistent_start(single, VectorXd{{0.0, c}});
    ASSERT_TRUE(start.found()) << c << ": " << start.message;
    EXPECT_NEAR(start.z[0] / c, 0.5 * (std::sqrt(5.0) - 1.0), 1e-15) << c;
  }
}

// A relative tolerance fails at zero. A solution z = 0 is found nonetheless from every start.
TEST(Algebraic, StatesThatEndAtZeroAreFound) {
  for (const double x : {0.0, 1e-30, 1e-12})
    for (const double guess : {0.0, 0.5, 1.0}) {
      const auto equation = [](const auto&, const auto& in) {
        return Vec<std::decay_t<decltype(in[0])>, 1>{in[1] + 0.3 * sin(in[1]) * in[1] - in[0]};
      };
      const AlgebraicEquations single({1, 0, 0}, make_function<2, 0, 0>(equation),
                                      VectorXd{{guess}});
      const ConsistentStart start = consistent_start(single, VectorXd{{0.0, x}});
      ASSERT_TRUE(start.found()) << x << ' ' << guess << ": " << start.message;
      EXPECT_NEAR(start.z[0], x, 1e-15);
    }
}

TEST(Algebraic, DerivativesOfFirstAndSecondOrderAreExact) {
  const auto rates = [](const auto& t, const auto& x, const auto& z, const auto& u, const auto& p) {
    return std::decay_t<decltype(x)>{z[0] * z[1] + x[1] * u[0] + p[0],
                                     sin(z[2]) * x[0] + z[1] * z[1] * t};
  };
  for (const Function& f : {eliminate(extended(rates), equations()), algebraic_states(equations()),
                            algebraic_state(equations(), 2)}) {
    const DerivativeReport report = check_derivatives(f, point);
    EXPECT_TRUE(report.ok) << report;
  }
}

// z0 depends on x0 and p, z1 on x1 and u. Neither depends on anything else, including time.
TEST(Algebraic, SparsityMatchesTheComposition) {
  const Function z = algebraic_states(equations());
  const SparsityPattern& pattern = z.jacobian_pattern();
  const auto row = [&](int r) {
    std::vector<int> columns;
    for (int e = pattern.row_begin(r); e < pattern.row_end(r); ++e)
      columns.push_back(pattern.col(e));
    return columns;
  };
  EXPECT_EQ(row(0), (std::vector<int>{1, 4}));
  EXPECT_EQ(row(1), (std::vector<int>{2, 3}));
  EXPECT_EQ(row(2), (std::vector<int>{0, 1, 2, 3, 4}));
  // Formulas that do not read z are unchanged.
  const Function plain =
      eliminate(extended([](const auto&, const auto& x) { return x[0] * x[1]; }), equations());
  EXPECT_EQ(plain.jacobian_pattern().entries(), 2);
  EXPECT_EQ(plain.hessian_pattern().entries(), 1);
  EXPECT_FALSE(plain.reads(0));
  EXPECT_TRUE(check_derivatives(plain, point).ok);
}

TEST(Algebraic, AffineEquationsLeaveAffineFunctions) {
  constexpr Arguments one{1, 1, 0};
  const auto make = [&](auto formula) {
    return make_function<2, 1, 0>(FormulaWithAlgebraic<1, 1, decltype(formula)>{formula});
  };
  const auto affine = std::make_shared<const AlgebraicEquations>(
      one, make([](const auto&, const auto& x, const auto& z, const auto& u) {
        return 2.0 * z[0] - x[0] + u[0];
      }),
      VectorXd::Zero(1));
  const Function rate = eliminate(
      make([](const auto&, const auto& x, const auto& z) { return x[0] + 3.0 * z[0]; }), affine);
  EXPECT_EQ(rate.degree(0, {0, 1, 1}), 1);
  EXPECT_EQ(rate.hessian_pattern().entries(), 0);
  EXPECT_NEAR(rate((VectorXd(3) << 0.0, 2.0, 1.0).finished())[0], 3.5, 1e-15);
}

TEST(Algebraic, AllocatesInTheFirstEvaluationOnly) {
  const Function z = algebraic_states(equations());
  VectorXd value(nz), entries(z.jacobian_pattern().entries()),
      curved(z.hessian_pattern().entries());
  const VectorXd weights = VectorXd::Ones(nz);
  const auto call = [&] {
    z.value(point.data(), value.data());
    z.jacobian(point.data(), value.data(), entries.data());
    z.hessian(point.data(), weights.data(), curved.data());
  };
  call();
  const saltus::testing::AllocationCount count;
  call();
  EXPECT_EQ(count.made(), 0);
}

template <class G>
std::string refusal(G formula) {
  return error_of<DefinitionError>(
      [&] { AlgebraicEquations(sizes, extended(formula), VectorXd::Zero(nz)); });
}

TEST(Algebraic, IndexAboveOneNamesTheEquation) {
  // Position level: the second equation does not read z.
  EXPECT_NE(refusal([](const auto&, const auto& x, const auto& z) {
              return std::decay_t<decltype(z)>{z[0], x[0] * x[0] - 1.0, z[1] + z[2]};
            }).find("algebraic equation 1 of 3, counted from 0, contains no algebraic state:"),
            std::string::npos);
  // Two equations for z0, none for z2.
  EXPECT_NE(refusal([](const auto&, const auto& x, const auto& z) {
              return std::decay_t<decltype(z)>{z[0] + x[0], z[0] * z[0], z[1] * z[2]};
            }).find("algebraic equation 1 of 3, counted from 0, contains no algebraic state that"),
            std::string::npos);
  EXPECT_THROW(AlgebraicEquations(sizes, extended(Equations{}), VectorXd::Zero(2)),
               DefinitionError);
}

TEST(Algebraic, ConsistentStartsAreFoundAndReported) {
  const ConsistentStart start = consistent_start(*equations(), point);
  EXPECT_TRUE(start.found());
  EXPECT_LE(start.residual.cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NE(start.message.find("algebraic state 1 differs most from its guess"), std::string::npos)
      << start.message;

  VectorXd nowhere = point;
  nowhere[4] = -2.0;  // z0^2 = -0.56
  const ConsistentStart none = consistent_start(*equations(), nowhere);
  EXPECT_EQ(none.status, AlgebraicEquations::Status::no_solution);
  EXPECT_EQ(none.equation, 0);
  EXPECT_NE(none.message.find("algebraic equation 0 of 3, counted from 0, has the residual"),
            std::string::npos)
      << none.message;
  EXPECT_TRUE(std::isnan(algebraic_states(equations())(nowhere)[0]));
}

// Structurally regular, numerically singular: the second equation is twice the first.
TEST(Algebraic, NamesDependentEquations) {
  const AlgebraicEquations dependent(
      sizes, extended([](const auto&, const auto& x, const auto& z) {
        return std::decay_t<decltype(z)>{z[0] + z[1] - x[0], 2.0 * z[0] + 2.0 * z[1], z[2]};
      }),
      VectorXd::Zero(nz));
  const ConsistentStart start = consistent_start(dependent, point);
  EXPECT_EQ(start.status, AlgebraicEquations::Status::singular);
  EXPECT_LE(start.equation, 1);
  EXPECT_NE(start.message.find("g_z is singular there, so the index exceeds 1"), std::string::npos)
      << start.message;
}

}  // namespace
}  // namespace saltus
