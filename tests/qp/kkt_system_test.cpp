// Tests that both systems satisfy the requirements of kkt_system.hpp. The reference values are the
// systems' own products, which the optima of the solvers test. Newton's step is tested by its
// equations.
#include "saltus/qp/kkt_system.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <type_traits>
#include <utility>

#include "saltus/qp/ipm_newton.hpp"
#include "saltus/qp/riccati_system.hpp"
#include "saltus/qp/sparse_system.hpp"
#include "tests/qp/program_with_groups.hpp"
#include "tests/support/random_qp.hpp"
#include "tests/support/stage_conversion.hpp"

namespace saltus::qp {
namespace {

using saltus::testing::program_with_groups;
using saltus::testing::random_qp;

constexpr int programs = 40;
constexpr double rounding = 1e-13;  // a few hundred operations, relative to their largest terms

struct Point {
  template <KktSystem System>
  explicit Point(const System& system)
      : v(system.variables()), y(system.equalities()), side(system.sides()) {}
  AlignedArray v, y, side;
};

double dot(const AlignedArray& a, const AlignedArray& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}
double size_of(const AlignedArray& a) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i]));
  return most;
}

// A system that counts its calls.
template <class System>
struct Counting : System {
  using System::System;
  void solve(const double* rv, const double* ry, double* dv, double* dy) {
    ++solves;
    System::solve(rv, ry, dv, dy);
  }
  int solves = 0;
};

// A program for either system, and points of its space. Padding stays zero.
struct Staged {
  explicit Staged(StageQp program) : qp(std::move(program)), system(qp, {}) {
    EXPECT_TRUE(system.pack(qp));
  }
  Point draw(Random& random) {
    StagePoint point(qp);
    for (StagePoint::AtStage& s : point.stages) {
      for (VectorXd* x : {&s.x, &s.u, &s.costate, &s.x_bound, &s.u_bound})
        *x = random.vector(static_cast<int>(x->size()));
      for (VectorXd& g : s.group) g = random.vector(static_cast<int>(g.size()));
    }
    Point result(system);
    pack_point(qp, point, system.packed(), true, result.v.data(), result.y.data(),
               result.side.data());
    draw_sides(system, random, result.side);
    return result;
  }
  template <KktSystem System>
  static void draw_sides(const System& system, Random& random, AlignedArray& side) {
    for (int i = 0; i < system.sides(); ++i)
      side[i] = random.uniform(-1.0, 1.0) * system.active()[i];
  }
  StageQp qp;
  Counting<RiccatiSystem> system;
};
struct Sparse {
  explicit Sparse(const StageQp& program)
      : qp(to_sparse(program)), system(qp.hessian_pattern, qp.row_pattern) {
    EXPECT_TRUE(system.load(qp));
  }
  Point draw(Random& random) {
    const int n = qp.variables(), m = qp.row_pattern.rows();
    Point result(system);
    system.load_point({random.vector(n), random.vector(m), random.vector(n)}, result.v.data(),
                      result.y.data(), result.side.data());
    Staged::draw_sides(system, random, result.side);
    return result;
  }
  SparseQp qp;
  Counting<SparseSystem> system;
};

StageQp program(int seed) {
  if (seed % 4 == 0) return program_with_groups(2 + seed / 4 % 2, seed, /*equality=*/0.3);
  return random_qp(seed, {.semidefinite = 0.0, .rank_deficient = 0.0}).qp;
}

template <class Program>
class KktSystemOf : public ::testing::Test {
 protected:
  template <class Check>
  void for_programs(const Check& check) {
    for (int seed = 1; seed <= programs; ++seed) {
      SCOPED_TRACE(seed);
      Program given(program(seed));
      Random random(seed);
      check(given, random);
    }
  }
};
using Programs = ::testing::Types<Staged, Sparse>;
TYPED_TEST_SUITE(KktSystemOf, Programs);

TYPED_TEST(KktSystemOf, ProductsAreConsistent) {
  this->for_programs([](TypeParam& given, Random& random) {
    auto& system = given.system;
    const Point a = given.draw(random), b = given.draw(random), zero(system);
    Point of_a(system), of_b(system), at_a(system), at_zero(system);
    const auto near = [](double x, double y, double size) {
      EXPECT_NEAR(x, y, rounding * (1.0 + size));
    };
    // Without multipliers the product uses H and E only, and H is symmetric.
    system.apply(a.v.data(), zero.y.data(), zero.side.data(), of_a.v.data(), of_a.y.data(),
                 of_a.side.data());
    system.apply(b.v.data(), zero.y.data(), zero.side.data(), of_b.v.data(), of_b.y.data(),
                 of_b.side.data());
    const double in_all = size_of(of_a.v) * static_cast<double>(of_a.v.size());
    near(dot(of_a.v, b.v), dot(of_b.v, a.v), in_all);
    // E' and G' are the transposes of E and G.
    Point pulled(system), pushed(system);
    system.apply(zero.v.data(), b.y.data(), zero.side.data(), pulled.v.data(), pulled.y.data(),
                 pulled.side.data());
    near(dot(of_a.y, b.y), dot(pulled.v, a.v), size_of(of_a.y) * static_cast<double>(b.y.size()));
    system.add_transposed(b.side.data(), pushed.v.data());
    near(dot(of_a.side, b.side), dot(pushed.v, a.v),
         size_of(of_a.side) * static_cast<double>(b.side.size()));
    Point alone(system);
    system.multiply(a.v.data(), alone.side.data());
    for (int i = 0; i < system.sides(); ++i) near(alone.side[i], of_a.side[i], size_of(of_a.side));
    // All products together equal the sum, and evaluate() adds g and e.
    Point together(system);
    system.apply(a.v.data(), b.y.data(), b.side.data(), together.v.data(), together.y.data(),
                 together.side.data());
    const double in_sum = size_of(of_a.v) + size_of(pulled.v) + size_of(pushed.v);
    for (int i = 0; i < system.variables(); ++i)
      near(together.v[i], of_a.v[i] + pulled.v[i] - pushed.v[i], in_sum);
    system.evaluate(zero.v.data(), zero.y.data(), zero.side.data(), at_zero.v.data(),
                    at_zero.y.data(), at_zero.side.data());
    system.evaluate(a.v.data(), b.y.data(), b.side.data(), at_a.v.data(), at_a.y.data(),
                    at_a.side.data());
    for (int i = 0; i < system.variables(); ++i)
      near(at_a.v[i], together.v[i] + at_zero.v[i], size_of(at_a.v));
    for (int i = 0; i < system.equalities(); ++i)
      near(at_a.y[i], of_a.y[i] + at_zero.y[i], size_of(at_a.y));
    for (int i = 0; i < system.sides(); ++i) near(at_a.side[i], of_a.side[i], size_of(at_a.side));
    const double in_cost = in_all + size_of(at_zero.v) * static_cast<double>(a.v.size());
    near(system.cost(a.v.data()), 0.5 * dot(of_a.v, a.v) + dot(at_zero.v, a.v), in_cost);
  });
}

TYPED_TEST(KktSystemOf, RowNormsAreExact) {
  this->for_programs([](TypeParam& given, Random&) {
    auto& system = given.system;
    AlignedArray sizes(system.sides());
    system.row_sizes(sizes.data());
    for (int i = 0; i < system.sides(); ++i) {
      if (system.active()[i] == 0.0) continue;
      Point row(system);
      row.side[i] = 1.0;
      system.add_transposed(row.side.data(), row.v.data());
      EXPECT_NEAR(sizes[i], std::sqrt(dot(row.v, row.v)), rounding * (1.0 + sizes[i]));
    }
  });
}

// (H + shift I + G'WG) dv + E'dy = -rv, E dv = -ry.
TYPED_TEST(KktSystemOf, SolvesItsEquationsWithAShiftAndWithout) {
  constexpr double accurate = 1e-8;  // error of steps, which are refined where needed
  for (const double shift : {0.0, 0.3, 100.0})
    this->for_programs([&](TypeParam& given, Random& random) {
      auto& system = given.system;
      const Point right = given.draw(random);
      AlignedArray weights(system.sides());
      for (int i = 0; i < system.sides(); ++i)
        weights[i] = random.log_uniform(1e-3, 1e3) * system.active()[i];
      system.set_shift(shift);
      ASSERT_TRUE(system.factor(weights.data()));
      Point step(system), left(system), pull(system);
      system.solve(right.v.data(), right.y.data(), step.v.data(), step.y.data());
      const Point zero(system);
      system.apply(step.v.data(), step.y.data(), zero.side.data(), left.v.data(), left.y.data(),
                   left.side.data());
      for (int i = 0; i < system.sides(); ++i) left.side[i] *= weights[i];
      system.add_transposed(left.side.data(), pull.v.data());
      const double size = 1.0 + size_of(left.v) + size_of(pull.v) + (1.0 + shift) * size_of(step.v);
      for (int i = 0; i < system.variables(); ++i)
        EXPECT_NEAR(left.v[i] + pull.v[i] + shift * step.v[i], -right.v[i], accurate * size);
      for (int i = 0; i < system.equalities(); ++i)
        EXPECT_NEAR(left.y[i], -right.y[i], accurate * size);
    });
}

// Random iterate, residuals and targets. Weights are about `stiffness` at most.
struct Linearised {
  template <class Program>
  Linearised(Program& given, Random& random, double stiffness)
      : p(sizes(given.system)), r(sizes(given.system)), target(given.system.sides()) {
    const auto& system = given.system;
    const Point residual = given.draw(random);
    std::copy_n(residual.v.data(), system.variables(), r.stationarity.data());
    std::copy_n(residual.y.data(), system.equalities(), r.equality.data());
    for (int i = 0; i < system.sides(); ++i) {
      const bool active = system.active()[i] != 0.0, soft = active && i >= system.first_soft();
      const double least = 1.0 / std::sqrt(stiffness);
      p.s[i] = active ? random.log_uniform(least, 1.0) : 1.0;
      p.lambda[i] = active ? random.log_uniform(0.1, 1.0 / least) : 0.0;
      p.t[i] = soft ? random.log_uniform(least, 1.0) : 1.0;
      p.tau[i] = soft ? random.log_uniform(0.1, 1.0 / least) : 1.0;
      r.side[i] = active ? random.uniform(-1.0, 1.0) : 0.0;
      r.soft[i] = soft ? random.uniform(-1.0, 1.0) : 0.0;
      target.side[i] = active ? random.uniform(-1.0, 1.0) * p.lambda[i] : 0.0;
      target.soft[i] = soft ? random.uniform(-1.0, 1.0) * p.tau[i] : 0.0;
    }
  }

  // Residual of each linear equation after a step, relative to its terms.
  template <KktSystem System>
  void expect_solved(System& system, const Iterate& step, double shift, double accurate) const {
    const auto vanishes = [&](std::initializer_list<double> terms) {
      double sum = 0.0, size = 0.0;
      for (const double term : terms) {
        sum += term;
        size = std::max(size, std::abs(term));
      }
      EXPECT_LE(std::abs(sum), accurate * (1.0 + size));
    };
    Point left(system);
    system.apply(step.v.data(), step.y.data(), step.lambda.data(), left.v.data(), left.y.data(),
                 left.side.data());
    const double pull = size_of(step.lambda) + size_of(step.y);
    for (int i = 0; i < system.variables(); ++i)
      EXPECT_LE(std::abs(left.v[i] + shift * step.v[i] + r.stationarity[i]),
                accurate * (1.0 + size_of(left.v) + pull));
    for (int i = 0; i < system.equalities(); ++i) vanishes({left.y[i], r.equality[i]});
    for (int i = 0; i < system.sides(); ++i) {
      const double dt = i < system.first_soft() ? 0.0 : step.t[i];
      vanishes({left.side[i], dt, -step.s[i], r.side[i]});
      vanishes({p.s[i] * step.lambda[i], p.lambda[i] * step.s[i], p.s[i] * target.side[i]});
      if (i < system.first_soft()) continue;
      vanishes({system.l2()[i] * dt, -step.lambda[i], -step.tau[i], r.soft[i]});
      vanishes({p.t[i] * step.tau[i], p.tau[i] * dt, p.t[i] * target.soft[i]});
    }
  }

  struct Sizes {
    int variables, equalities, sides;
    operator Iterate() const { return Iterate(variables, equalities, sides); }
    operator Residuals() const { return Residuals(variables, equalities, sides); }
  };
  template <KktSystem System>
  static Sizes sizes(const System& system) {
    return {system.variables(), system.equalities(), system.sides()};
  }
  Iterate p;
  Residuals r;
  SideTarget target;
};

template <class Program>
class NewtonStepOf : public KktSystemOf<Program> {};
TYPED_TEST_SUITE(NewtonStepOf, Programs);

// Solves with and without refinement, and with and without a shift.
TYPED_TEST(NewtonStepOf, SolvesTheLinearisedConditions) {
  constexpr double accurate = 1e-7;
  for (const bool careful : {false, true})
    for (const double shift : {0.0, 0.3})
      this->for_programs([&](TypeParam& given, Random& random) {
        auto& system = given.system;
        const Linearised at(given, random, 1e4);
        NewtonStep<std::decay_t<decltype(system)>> newton(system.variables(), system.equalities(),
                                                          system.sides());
        newton.reset();
        ASSERT_TRUE(newton.factor(system, at.p, careful, shift));
        Iterate step = Linearised::sizes(system);
        newton.solve(system, at.p, at.r, at.target, step);
        at.expect_solved(system, step, shift, accurate);
      });
}

// An accurate step is not refined further.
TYPED_TEST(NewtonStepOf, IsRefinedOnlyIfNecessary) {
  int solves = 0;
  this->for_programs([&](TypeParam& given, Random& random) {
    auto& system = given.system;
    const Linearised at(given, random, 1e2);
    NewtonStep<std::decay_t<decltype(system)>> newton(system.variables(), system.equalities(),
                                                      system.sides());
    newton.reset();
    ASSERT_TRUE(newton.factor(system, at.p, /*careful=*/true));
    Iterate step = Linearised::sizes(system);
    system.solves = 0;
    newton.solve(system, at.p, at.r, at.target, step);
    solves += system.solves;
  });
  EXPECT_LE(solves, 1.6 * programs);  // measured: 1.5 for the recursion, 1 for the sparse factor
}

}  // namespace
}  // namespace saltus::qp
