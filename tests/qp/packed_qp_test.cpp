// A packed program has value semantics: refilling or moving it leaves no trace of earlier contents.
#include "saltus/qp/packed_qp.hpp"

#include <gtest/gtest.h>

#include <random>
#include <utility>
#include <vector>

#include "saltus/qp/riccati_system.hpp"
#include "tests/qp/program_with_groups.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus::qp {
namespace {

using saltus::testing::multiplier_scale;
using saltus::testing::program_with_groups;
using saltus::testing::random_qp;
using saltus::testing::RandomQp;

struct FlatPoint {
  explicit FlatPoint(const PackedQp& packed)
      : v(packed.capacity.variables),
        y(packed.capacity.equalities),
        lambda(packed.capacity.sides) {}
  AlignedArray v, y, lambda;
};

StagePoint there_and_back(const StageQp& qp, const PackedQp& packed, const StagePoint& point) {
  FlatPoint flat(packed);
  pack_point(qp, point, packed, true, flat.v.data(), flat.y.data(), flat.lambda.data());
  StagePoint result(qp);
  unpack_point(qp, packed, flat.v.data(), flat.y.data(), flat.lambda.data(), result);
  return result;
}

double largest_difference(const StageQp& qp, const StagePoint& a, const StagePoint& b) {
  double most = 0.0;
  const auto see = [&](const VectorXd& x, const VectorXd& y, int size) {
    if (size > 0) most = std::max(most, (x - y).head(size).cwiseAbs().maxCoeff());
  };
  for (std::size_t k = 0; k < qp.stages.size(); ++k) {
    const Stage& s = qp.stages[k];
    see(a.stages[k].x, b.stages[k].x, s.nx);
    see(a.stages[k].u, b.stages[k].u, s.nu);
    see(a.stages[k].x_bound, b.stages[k].x_bound, s.nx);
    see(a.stages[k].u_bound, b.stages[k].u_bound, s.nu);
    if (k + 1 < qp.stages.size())
      see(a.stages[k].costate, b.stages[k].costate, qp.stages[k + 1].nx);
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      see(a.stages[k].group[g], b.stages[k].group[g], s.groups[g].rows);
  }
  return most;
}

// With a fixed start, rows on the start alone are not part of the packed program, so they have no
// multipliers to return.
TEST(PackedQp, PointsRoundTrip) {
  for (int seed = 1; seed <= 200; ++seed) {
    const RandomQp random = random_qp(seed, {.free_start = 1.0});
    PackedQp packed(random.qp, {});
    ASSERT_TRUE(packed.pack(random.qp)) << random.describe();
    const StagePoint back = there_and_back(random.qp, packed, random.optimum);
    // Multipliers of equality rows are divided by the row's scale and multiplied again.
    EXPECT_LE(largest_difference(random.qp, back, random.optimum),
              1e-14 * multiplier_scale(random.optimum))
        << random.describe();
  }
}

TEST(PackedQp, RepackingChangesNothing) {
  for (int seed = 1; seed <= 50; ++seed) {
    const RandomQp random = random_qp(seed);
    PackedQp first(random.qp, {});
    ASSERT_TRUE(first.pack(random.qp));
    PackedQp packed = std::move(first);
    const StagePoint once = there_and_back(random.qp, packed, random.optimum);
    StageQp other = random.qp;
    for (Stage& s : other.stages) {
      s.Q *= 2.0;
      s.q.setOnes();
      for (RowGroup& g : s.groups) g.rows = 0;
    }
    ASSERT_TRUE(packed.pack(other));
    ASSERT_TRUE(packed.pack(random.qp));
    EXPECT_EQ(
        largest_difference(random.qp, there_and_back(random.qp, packed, random.optimum), once), 0.0)
        << random.describe();
  }
}

// Residuals at a point and sides of a packed program.
std::vector<double> contents(RiccatiSystem& system, const StageQp& qp, const StagePoint& point) {
  const PackedQp& packed = system.packed();
  FlatPoint at(packed), residual(packed);
  pack_point(qp, point, packed, true, at.v.data(), at.y.data(), at.lambda.data());
  system.evaluate(at.v.data(), at.y.data(), at.lambda.data(), residual.v.data(), residual.y.data(),
                  residual.lambda.data());
  std::vector<double> all;
  const auto add = [&](const AlignedArray& numbers, int first, int last) {
    all.insert(all.end(), numbers.data() + first, numbers.data() + last);
  };
  add(residual.v, 0, packed.variables);
  add(residual.y, 0, packed.equalities);
  add(residual.lambda, 0, packed.sides);
  for (const AlignedArray* of_sides : {&packed.active, &packed.beta})
    add(*of_sides, 0, packed.sides);
  for (const AlignedArray* of_soft : {&packed.l1, &packed.l2})
    add(*of_soft, packed.first_soft, packed.sides);
  return all;
}

void move_vectors(StageQp& qp) {
  const auto move = [](VectorXd& lower, VectorXd& upper) {  // infinite values stay so
    lower.array() += 0.25;
    upper.array() += 0.25;
  };
  for (Stage& s : qp.stages) {
    s.q.array() += 1.0;
    s.r.array() -= 2.0;
    s.b.array() += 0.5;
    move(s.x_lower, s.x_upper);
    move(s.u_lower, s.u_upper);
    for (RowGroup& g : s.groups) {
      move(g.lower, g.upper);
      g.l1.array() += 3.0;
    }
  }
  qp.start.array() += 0.125;
}

// Writing only the vectors, or only the start, gives the program that packing all of it gives.
// Returns true if the other start contradicts the rows.
bool expect_updated(const StageQp& qp, const StagePoint& point) {
  StageQp moved = qp, started = qp;
  move_vectors(moved);
  started.start.array() += 0.125;
  RiccatiSystem anew(qp, {}), system(qp, {});
  EXPECT_TRUE(system.pack(qp));
  system.pack_start(started);
  EXPECT_TRUE(anew.pack(started));
  EXPECT_EQ(contents(system, started, point), contents(anew, started, point));
  const bool contradiction = anew.packed().contradiction;
  EXPECT_EQ(system.packed().contradiction, contradiction);

  system.pack_vectors(moved);
  EXPECT_TRUE(anew.pack(moved));
  EXPECT_EQ(contents(system, moved, point), contents(anew, moved, point));
  FlatPoint constants(system.packed()), residual(system.packed()), zero(system.packed());
  system.constants(constants.v.data(), constants.y.data());
  system.evaluate(zero.v.data(), zero.y.data(), zero.lambda.data(), residual.v.data(),
                  residual.y.data(), residual.lambda.data());
  for (int i = 0; i < system.variables(); ++i) EXPECT_EQ(constants.v[i], residual.v[i]);
  for (int i = 0; i < system.equalities(); ++i) EXPECT_EQ(constants.y[i], residual.y[i]);
  return contradiction;
}

TEST(PackedQp, VectorsAndStartReplaceThoseOfTheLastProgram) {
  int contradictions = 0;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    const RandomQp random = random_qp(seed);
    contradictions += expect_updated(random.qp, random.optimum) ? 1 : 0;
    const StageQp groups = program_with_groups(1 + seed % 3, seed, 0.3);
    expect_updated(groups, StagePoint(groups));
  }
  EXPECT_GT(contradictions, 0);
}

TEST(PackedQp, RejectsInvalidPrograms) {
  const RandomQp random = random_qp(1);
  PackedQp packed(random.qp, {});
  StageQp crossed = random.qp;
  crossed.stages.back().x_lower[0] = 1.0;
  crossed.stages.back().x_upper[0] = 0.0;
  EXPECT_FALSE(packed.pack(crossed));
  StageQp shorter = random.qp;
  shorter.stages.pop_back();
  EXPECT_FALSE(packed.pack(shorter));
  EXPECT_TRUE(packed.pack(random.qp));
}

// A program without repeated data, with groups of inputs that act through a common resultant.
StageQp without_repetition(int nx, int nu, int parts, int rows, std::mt19937& random) {
  const int size = nu / parts, stages = 4;
  StageCapacity capacity{.nx = nx, .nu = nu, .groups = {}};
  for (int part = 0; part < parts; ++part) capacity.groups.push_back({rows, size, part % 3 == 2});
  if (parts == 1) capacity.groups.push_back({rows, nx + nu, false});
  StageQp qp(std::vector<StageCapacity>(stages, capacity));
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto fill = [&](auto&& matrix) {
    for (int j = 0; j < matrix.cols(); ++j)
      for (int i = 0; i < matrix.rows(); ++i) matrix(i, j) = any(random);
  };
  const auto bound = [&](double& lower, double& upper) {
    lower = any(random);
    upper = any(random) < 0.0 ? lower : lower + 1.0;
  };
  qp.fixed_start = any(random) < 0.0;
  qp.start = VectorXd::Zero(nx);
  for (Stage& s : qp.stages) {
    fill(s.A);
    fill(s.B);
    for (int part = 1; part < parts; ++part)
      s.B.middleCols(part * size, size) = (1.0 + part) * s.B.leftCols(size);
    for (int i = 0; i < nu; ++i) s.R(i, i) = 2.0 + any(random);
    s.resultant_size = parts > 1 ? size : 0;
    for (int i = 0; i < nx; ++i) bound(s.x_lower[i], s.x_upper[i]);
    for (int i = 0; i < nu; ++i) bound(s.u_lower[i], s.u_upper[i]);
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      RowGroup& group = s.groups[g];
      group.rows = rows;
      const int first = g < static_cast<std::size_t>(parts) ? nx + static_cast<int>(g) * size : 0;
      group.columns.resize(group.M.cols());
      for (std::size_t c = 0; c < group.columns.size(); ++c)
        group.columns[c] = first + static_cast<int>(c);
      fill(group.M);
      for (int i = 0; i < rows; ++i) bound(group.lower[i], group.upper[i]);
      if (group.soft) group.l1.setOnes();
    }
  }
  return qp;
}

TEST(PackedQp, HasMemoryForEveryProgramWithinItsCapacity) {
  std::mt19937 random(1);
  int reduced = 0;
  for (const int nx : {1, 3, 6, 9, 20})
    for (const int nu : {1, 2, 6, 8, 12, 24, 30})
      for (int parts = 1; parts <= max_parts && parts <= nu; ++parts)
        for (const int rows : {1, 7, 18}) {
          if (nu % parts != 0) continue;
          const StageQp qp = without_repetition(nx, nu, parts, rows, random);
          PackedQp packed(qp, {});
          EXPECT_TRUE(packed.pack(qp)) << nx << " " << nu << " " << parts << " " << rows;
          reduced += packed.reduced_stages;
        }
  EXPECT_GT(reduced, 100);
}

// The size of push recovery: two contacts with 10 rows each.
TEST(PackedQp, NeedsAtMostSixtyKilobytesPerStage) {
  const StageCapacity stage{.nx = 9, .nu = 12, .groups = {{10, 6, false}, {10, 6, false}}};
  const int stages = 50;
  const PackedQp packed(StageQp(std::vector<StageCapacity>(stages, stage)), {});
  const PackedQp::Capacity& most = packed.capacity;
  const std::size_t bytes =
      sizeof(double) * (packed.storage.numbers.capacity() + 4 * most.sides + most.equalities) +
      sizeof(int) * packed.storage.integers.capacity() +
      sizeof(RowBlock) * packed.storage.blocks.size() +
      sizeof(Split) * packed.storage.splits.size();
  EXPECT_LT(bytes / stages, 60000u);  // with vectors of 8 numbers
}

}  // namespace
}  // namespace saltus::qp
