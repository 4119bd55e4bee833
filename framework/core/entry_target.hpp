// Where an entry of a sparse matrix goes when the matrix itself is not stored.
#pragma once

namespace saltus {

/// *to = scale * entry.
struct EntryTarget {
  double* to = nullptr;
  double scale = 1.0;
};

}  // namespace saltus
