// Named parameters: one list defines offsets, names and packing, also in formulas.
#include "saltus/model/named_parameters.hpp"

#include <gtest/gtest.h>

#include "saltus/core/error.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

template <class S>
struct Road {
  S slope = 0.1;
  Vec<S, 2> wind = Vec<S, 2>::Zero();
  Mat<S, 2, 3> bumps = Mat<S, 2, 3>::Zero();
  S grip = 0.9;

  using Entries = ParameterEntries<&Road::slope, &Road::wind, &Road::bumps, &Road::grip>;
};
template <class S>
struct Tyres {
  Vec<S, 4> wear = Vec<S, 4>::Zero();

  using Entries = ParameterEntries<&Tyres::wear>;
};

TEST(NamedParameters, SizesAndNamesFollowFromTheList) {
  static_assert(size_of<Road> == 10 && size_of<Tyres> == 4);
  static_assert(after<Road> == 10 && after<Road, Tyres> == 14);
  constexpr auto entries = entries_of<Road<double>>();
  ASSERT_EQ(entries.size(), 4u);
  EXPECT_EQ(entries[0], (ParameterEntry{"slope", 0, 1, 1}));
  EXPECT_EQ(entries[1], (ParameterEntry{"wind", 1, 2, 1}));
  EXPECT_EQ(entries[2], (ParameterEntry{"bumps", 3, 2, 3}));
  EXPECT_EQ(entries[3], (ParameterEntry{"grip", 9, 1, 1}));
}

TEST(NamedParameters, MatricesAreRowMajor) {
  Road<double> road{.slope = 1.0, .wind = {2.0, 3.0}};
  road.bumps << 4, 5, 6, 7, 8, 9;
  road.grip = 10.0;
  const Vec<double, 10> p = packed(road);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(p[i], i + 1.0);
  const auto seen = view_as<Road>(p);
  EXPECT_EQ(seen.bumps, road.bumps);
  EXPECT_EQ(seen.wind, road.wind);
  EXPECT_EQ(seen.grip, 10.0);
}

TEST(NamedParameters, FormulasReadThemWithExactSparsity) {
  const Function f = make_function<1, 1, size_of<Road> + size_of<Tyres>>(
      [](const auto&, const auto& x, const auto&, const auto& p) {
        const auto road = view_as<Road>(p);
        const auto tyres = view_as<Tyres>(p, after<Road>);
        return x[0] * road.bumps(1, 0) + road.grip * tyres.wear[3];
      });
  const Arguments z{1, 1, 14};
  VectorXd at = VectorXd::Zero(z.size());
  at[z.x()] = 3.0;
  at[z.p(6)] = 2.0;       // bumps(1, 0)
  at[z.p(9)] = 0.5;       // grip
  at[z.p(10 + 3)] = 8.0;  // wear[3]
  double y = 0.0;
  f.value(at.data(), &y);
  EXPECT_EQ(y, 10.0);
  EXPECT_EQ(f.jacobian_pattern().entries(), 4);
}

TEST(NamedParameters, ResultsAreReadByName) {
  VectorXd p = packed(Road<double>{.grip = 0.3});
  EXPECT_EQ(view_as<Road>(p).grip, 0.3);
  EXPECT_THROW(view_as<Road>(p, 1), DefinitionError);
  p.conservativeResize(9);
  EXPECT_THROW(view_as<Road>(p), DefinitionError);
}

}  // namespace
}  // namespace saltus
