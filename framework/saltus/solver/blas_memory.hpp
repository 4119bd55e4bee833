// The memory that OpenBLAS computes in, taken before it is needed.
#pragma once

namespace saltus {

/// While one lives, OpenBLAS has a buffer for the thread that made it. Without one it asks for
/// memory until it gets it, and never returns where there is none. Throws std::bad_alloc if there
/// is no memory for the buffer. Buffers stay with OpenBLAS, so that only the first object at a time
/// allocates. With another BLAS it does nothing.
class BlasMemory {
 public:
  BlasMemory();
  ~BlasMemory();
  BlasMemory(const BlasMemory&) = delete;
  BlasMemory& operator=(const BlasMemory&) = delete;
};

}  // namespace saltus
