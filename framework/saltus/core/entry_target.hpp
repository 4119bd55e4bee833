// Destination of an entry of a sparse matrix that is not stored itself.
#pragma once

namespace saltus {

/// Writes *to = scale * entry.
struct EntryTarget {
  double* to = nullptr;  ///< destination
  double scale = 1.0;    ///< factor applied to the entry
};

}  // namespace saltus
