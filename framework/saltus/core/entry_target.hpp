// Where an entry of a sparse matrix goes when the matrix itself is not stored.
#pragma once

namespace saltus {

/// *to = scale * entry.
struct EntryTarget {
  double* to = nullptr;  ///< where the number goes
  double scale = 1.0;    ///< by what it is multiplied on the way
};

}  // namespace saltus
