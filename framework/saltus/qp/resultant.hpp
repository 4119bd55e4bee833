// Inputs that act through a common resultant, and the maps between their groups.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus::qp {

/// The leading part of B is [B_1 B_2 ... B_parts], `rows` x parts * size, in groups of `size`
/// columns. The maps T_p satisfy B_p = B_1 T_p. T and the inverses hold p = 2 ... parts in order:
/// size x (parts - 1) * size, columns padded to whole vectors.
struct ResultantSizes {
  int rows = 0, size = 0, parts = 0;
};
/// Size limits: larger problems are not searched for maps.
inline constexpr int max_resultant_rows = 64, max_resultant_size = 16;

/// True if B_p = B_1 T_p up to rounding.
bool maps_to_resultant(const MatrixXd& B, const ResultantSizes& sizes, const double* T);

/// Returns false if no maps exist or if they are nearly singular. Does not allocate.
bool find_resultant_maps(const MatrixXd& B, const ResultantSizes& sizes, double* T,
                         double* T_inverse);

}  // namespace saltus::qp
