// Sides that presolve() keeps in a program, and rows that it reports as contradictions.
#include "saltus/solver/presolve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "tests/solver/small_programs.hpp"

namespace saltus {
namespace {

// Two phases. x0 is given, x1 and x2 follow from nonlinear equations, and y = x2 by an identity. a
// and b are free.
enum Variable { x0, x1, x2, y, a, b, variable_count };
enum Row {
  start,        // x0 = 1
  first_step,   // x1 - x0 - sin x1 = 0
  second_step,  // x2 - x1 - x1^2 = 0
  jump,         // y - x2 = 0
  curved,       // y^2 + 1 <= 5
  same_curve,   // 2 x2^2 - 3 <= 5, which is the same
  straight,     // x2 <= 3
  reversed,     // -2 y >= -6, which is the same
  constant,     // 2 <= 3
  of_start,     // x0 + 1 <= 2
  sum,          // a + b = 1
  twice_sum,    // 2 a + 2 b = 2
  row_count
};

class TwoPhases final : public testing_support::RowsOnly {
 public:
  TwoPhases()
      : RowsOnly(SparsityPattern::from_pairs(row_count, variable_count,
                                             {{start, x0},
                                              {first_step, x0},
                                              {first_step, x1},
                                              {second_step, x1},
                                              {second_step, x2},
                                              {jump, y},
                                              {jump, x2},
                                              {curved, y},
                                              {same_curve, x2},
                                              {straight, x2},
                                              {reversed, y},
                                              {of_start, x0},
                                              {sum, a},
                                              {sum, b},
                                              {twice_sum, a},
                                              {twice_sum, b}}),
                 SparsityPattern(variable_count, variable_count)) {
    for (const auto& [row, value] : {std::pair{start, 1.0},
                                     {first_step, 0.0},
                                     {second_step, 0.0},
                                     {jump, 0.0},
                                     {sum, 1.0},
                                     {twice_sum, 2.0}})
      row_lower_[row] = row_upper_[row] = value;
    for (const auto& [row, upper] : {std::pair{curved, 5.0},
                                     {same_curve, 5.0},
                                     {straight, 3.0},
                                     {constant, 3.0},
                                     {of_start, 2.0}})
      row_upper_[row] = upper;
    row_lower_[reversed] = -6.0;
  }

  bool is_affine(int row) const override {
    return row != first_step && row != second_step && row != curved && row != same_curve;
  }
  bool constraints(const double* w, double* g) override {
    g[start] = w[x0];
    g[first_step] = w[x1] - w[x0] - std::sin(w[x1]);
    g[second_step] = w[x2] - w[x1] - w[x1] * w[x1];
    g[jump] = w[y] - w[x2];
    g[curved] = w[y] * w[y] + 1.0;
    g[same_curve] = 2.0 * w[x2] * w[x2] - 3.0;
    g[straight] = w[x2];
    g[reversed] = -2.0 * w[y];
    g[constant] = 2.0;
    g[of_start] = w[x0] + 1.0;
    g[sum] = w[a] + w[b];
    g[twice_sum] = 2.0 * w[a] + 2.0 * w[b];
    return true;
  }
  bool jacobian(const double* w, double* entries) override {
    const auto slope = [&](int row, int column) {
      switch (row) {
        case first_step:
          return column == x0 ? -1.0 : 1.0 - std::cos(w[x1]);
        case second_step:
          return column == x1 ? -1.0 - 2.0 * w[x1] : 1.0;
        case jump:
          return column == y ? 1.0 : -1.0;
        case curved:
          return 2.0 * w[y];
        case same_curve:
          return 4.0 * w[x2];
        case reversed:
          return -2.0;
        case twice_sum:
          return 2.0;
        default:
          return 1.0;
      }
    };
    jacobian_.for_each([&](int r, int c, int e) { entries[e] = slope(r, c); });
    return true;
  }
};

// Presolves at a guess of zeros, where nonlinear rows have zero slope.
Presolve look_at(TwoPhases& program) { return presolve(program, VectorXd::Zero(variable_count)); }
std::vector<int> rows_left(const Presolve& sides) {
  std::vector<int> rows;
  for (int r = 0; r < row_count; ++r)
    if (sides.row_lower[r] > -infinity || sides.row_upper[r] < infinity) rows.push_back(r);
  return rows;
}

TEST(PresolveRows, DropsConstantRowsAndMultiples) {
  TwoPhases program;
  const Presolve sides = look_at(program);
  EXPECT_FALSE(sides.contradiction);
  EXPECT_TRUE(sides.has_changed);
  EXPECT_EQ(rows_left(sides),
            (std::vector<int>{start, first_step, second_step, jump, curved, straight, sum}));
  EXPECT_EQ(sides.nonlinear, std::vector<int>{same_curve});
}

TEST(PresolveRows, KeepsTheTightestBounds) {
  TwoPhases program;
  program.row_upper_[same_curve] = 3.0;  // x2^2 <= 3
  program.row_upper_[reversed] = 8.0;    // y >= -4, in addition to y <= 3
  program.upper_[y] = 2.5;
  const Presolve sides = look_at(program);
  EXPECT_EQ(sides.row_upper[curved], infinity);
  EXPECT_EQ(sides.row_upper[same_curve], 3.0);
  EXPECT_EQ(sides.row_upper[straight], infinity);  // the bound is tighter
  EXPECT_EQ(sides.row_lower[reversed], -infinity);
  EXPECT_EQ(sides.row_upper[reversed], 8.0);
  EXPECT_EQ(sides.upper[y], 2.5);
}

TEST(PresolveRows, ContradictionsNameBothRowsAndTheAmount) {
  struct Case {
    std::string name;
    void (*change)(TwoPhases&);
    NlpResult::Contradiction expected;
  };
  for (const Case& c : std::vector<Case>{
           {"constant",
            [](TwoPhases& p) { p.row_upper_[constant] = 1.0; },
            {constant, -1, -1, 1.0}},
           {"of the start",
            [](TwoPhases& p) { p.row_upper_[of_start] = 1.5; },
            {of_start, start, -1, 0.5}},
           {"curved",
            [](TwoPhases& p) {
              p.row_upper_[curved] = 0.5;
              p.row_lower_[same_curve] = -3.0;
            },
            {curved, same_curve, -1, 0.5}},
           {"bounds", [](TwoPhases& p) { p.lower_[y] = 4.0; }, {straight, -1, y, 1.0}},
           {"sums",
            [](TwoPhases& p) { p.row_lower_[twice_sum] = p.row_upper_[twice_sum] = 3.0; },
            {twice_sum, sum, -1, 1.0}}}) {
    SCOPED_TRACE(c.name);
    TwoPhases program;
    c.change(program);
    const Presolve sides = look_at(program);
    ASSERT_TRUE(sides.contradiction);
    EXPECT_EQ(sides.contradiction->row, c.expected.row);
    EXPECT_EQ(sides.contradiction->other_row, c.expected.other_row);
    EXPECT_EQ(sides.contradiction->variable, c.expected.variable);
    EXPECT_NEAR(sides.contradiction->amount, c.expected.amount, 1e-12);
  }
}

TEST(PresolveRows, ViolationBelowTheToleranceIsNoContradiction) {
  TwoPhases program;
  program.row_upper_[constant] = 2.0 - 1e-6;  // 1e-6 times 2 is allowed
  program.row_lower_[twice_sum] = program.row_upper_[twice_sum] = 2.0 + 1e-6;
  EXPECT_FALSE(look_at(program).contradiction);
  program.row_upper_[constant] = 2.0 - 3e-6;
  EXPECT_TRUE(look_at(program).contradiction);
}

TEST(PresolveRows, SentinelsAreNotBounds) {
  TwoPhases program;
  program.upper_[a] = 1e19;
  program.lower_[a] = -1e30;
  program.lower_[b] = -9e18;
  const Presolve sides = look_at(program);
  EXPECT_EQ(sides.upper[a], infinity);
  EXPECT_EQ(sides.lower[a], -infinity);
  EXPECT_EQ(sides.lower[b], -9e18);
}

}  // namespace
}  // namespace saltus
