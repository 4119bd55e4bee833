// Maps of a common resultant are found exactly where they exist.
#include "saltus/qp/resultant.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "saltus/qp/lanes.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus::qp {
namespace {

constexpr int states = 9, size = 6, parts = 3;
constexpr ResultantSizes sizes{states, size, parts};

struct Resultant {
  MatrixXd B = MatrixXd::Zero(states, parts* size);
  std::vector<MatrixXd> T;  // for each further part
};

Resultant random_resultant(std::uint64_t seed) {
  Random random(seed);
  Resultant r;
  r.B.leftCols(size) = random.matrix(states, size);
  for (int part = 1; part < parts; ++part) {
    r.T.push_back(MatrixXd::Identity(size, size) + 0.4 * random.matrix(size, size));
    r.B.middleCols(part * size, size) = r.B.leftCols(size) * r.T.back();
  }
  return r;
}

struct Maps {
  AlignedArray T{static_cast<std::size_t>(padded(size) * (parts - 1) * size)}, inverse{T.size()};
  bool find(const MatrixXd& B) { return find_resultant_maps(B, sizes, T.data(), inverse.data()); }
  MatrixXd of(const AlignedArray& maps, int part) const {
    return Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>(
        maps.data() + (part - 1) * size * padded(size), size, size,
        Eigen::OuterStride<>(padded(size)));
  }
};

TEST(Resultant, FindsMapsAndInversesWithoutAllocation) {
  for (int seed = 1; seed <= 100; ++seed) {
    const Resultant r = random_resultant(seed);
    Maps maps;
    const testing::AllocationCount count;
    ASSERT_TRUE(maps.find(r.B)) << seed;
    EXPECT_EQ(count.made(), 0) << seed;
    EXPECT_TRUE(maps_to_resultant(r.B, sizes, maps.T.data())) << seed;
    for (int part = 1; part < parts; ++part) {
      const MatrixXd T = maps.of(maps.T, part), inverse = maps.of(maps.inverse, part);
      // The condition of B_1 is a few hundred at most.
      EXPECT_LT((T - r.T[part - 1]).cwiseAbs().maxCoeff(), 1e-11) << seed;
      EXPECT_LT((T * inverse - MatrixXd::Identity(size, size)).cwiseAbs().maxCoeff(), 1e-11)
          << seed;
    }
  }
}

TEST(Resultant, GroupsWithDifferentEffectsHaveNoResultant) {
  Resultant r = random_resultant(1);
  r.B(0, 2 * size) += 1e-6;  // outside the range of B_1
  EXPECT_FALSE(Maps().find(r.B));
}

TEST(Resultant, InputsWithoutEffectHaveNoResultant) {
  Resultant dependent = random_resultant(2);
  dependent.B.col(1) = dependent.B.col(0);  // B_1 loses rank
  EXPECT_FALSE(Maps().find(dependent.B));
  Resultant singular = random_resultant(3);
  singular.B.col(size + 1) = singular.B.col(size);  // T_2 loses rank
  EXPECT_FALSE(Maps().find(singular.B));
}

TEST(Resultant, RejectsMoreThanTheCapacity) {
  constexpr int many = max_resultant_rows + 1;
  const MatrixXd B = MatrixXd::Identity(many, 2).replicate(1, 2);
  AlignedArray T(64), inverse(64);
  EXPECT_FALSE(find_resultant_maps(B, {many, 2, 2}, T.data(), inverse.data()));
  EXPECT_TRUE(find_resultant_maps(B, {many - 1, 2, 2}, T.data(), inverse.data()));
}

}  // namespace
}  // namespace saltus::qp
