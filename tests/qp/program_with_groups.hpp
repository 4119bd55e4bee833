// Random programs whose inputs act through a common resultant.
#pragma once

#include <cstdint>
#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::testing {

/// Groups of three inputs that act through the sum of their forces. Each group has bounds,
/// friction-like rows and rows with equal sides. There are four states.
inline qp::StageQp program_with_groups(int groups, std::uint64_t seed, double equality = 0.0) {
  constexpr int nx = 4, size = 3, intervals = 6;
  Random random(seed);
  std::vector<qp::StageCapacity> capacity(intervals + 1, {nx, groups * size, {}});
  capacity.back().nu = 0;
  for (int k = 0; k < intervals; ++k)
    for (int g = 0; g < groups; ++g) capacity[k].groups.push_back({3, size, false});
  qp::StageQp qp(capacity);
  qp.start = random.vector(nx);
  const MatrixXd B = random.matrix(nx, size);
  std::vector<MatrixXd> T;
  for (int g = 0; g < groups; ++g)
    T.push_back(g == 0
                    ? MatrixXd(MatrixXd::Identity(size, size))
                    : MatrixXd(MatrixXd::Identity(size, size) + 0.4 * random.matrix(size, size)));
  for (int k = 0; k <= intervals; ++k) {
    qp::Stage& s = qp.stages[k];
    s.Q = MatrixXd::Identity(nx, nx);
    s.q = random.vector(nx);
    if (k == intervals) break;
    s.A = MatrixXd::Identity(nx, nx) + 0.2 * random.matrix(nx, nx);
    s.b = 0.1 * random.vector(nx);
    s.resultant_size = size;
    s.r = random.vector(groups * size);
    for (int g = 0; g < groups; ++g) {
      s.B.middleCols(g * size, size) = B * T[g];
      const MatrixXd root = random.matrix(size, size);
      s.R.block(g * size, g * size, size, size) =
          0.01 * MatrixXd::Identity(size, size) + 0.1 * root * root.transpose();
      qp::RowGroup& rows = s.groups[g];
      rows.rows = 3;
      rows.columns.clear();
      for (int i = 0; i < size; ++i) rows.columns.push_back(nx + g * size + i);
      rows.M = random.matrix(3, size);
      rows.lower.setConstant(-infinity);
      rows.upper.setConstant(0.3);
      if (random.chance(equality)) rows.lower[0] = rows.upper[0] = 0.05;
    }
    s.u_lower.setConstant(-0.5);
    s.u_upper.setConstant(0.7);
  }
  return qp;
}

}  // namespace saltus::testing
