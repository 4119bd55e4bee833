// Inputs that act through a common resultant: the maps between their groups.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus::qp {

/// B = [B_1 B_2 ... B_parts], `rows` x parts * size in its leading part, each group of `size`
/// columns. Wanted are T_p with B_p = B_1 T_p and their inverses, for p = 2 ... parts one after the
/// other: size x (parts - 1) * size, columns padded to whole vectors.
struct ResultantSizes {
  int rows = 0, size = 0, parts = 0;
};
/// Beyond these no maps are looked for.
inline constexpr int max_resultant_rows = 64, max_resultant_size = 16;

/// Whether B_p = B_1 T_p to rounding.
bool maps_to_resultant(const MatrixXd& B, const ResultantSizes& sizes, const double* T);

/// False if there are none, or they are nearly singular. Does not allocate.
bool find_resultant_maps(const MatrixXd& B, const ResultantSizes& sizes, double* T,
                         double* T_inverse);

}  // namespace saltus::qp
