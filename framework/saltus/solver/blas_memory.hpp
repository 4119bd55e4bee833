// Reserves the memory of OpenBLAS before it is needed.
#pragma once

namespace saltus {

/// While an object lives, OpenBLAS has a buffer for the thread that created it. Without the buffer
/// OpenBLAS requests memory until it succeeds, and never returns if there is none. Throws
/// std::bad_alloc if there is no memory for the buffer. OpenBLAS keeps its buffers, so that only
/// the first of several objects allocates. With another BLAS this class does nothing.
class BlasMemory {
 public:
  BlasMemory();
  ~BlasMemory();
  BlasMemory(const BlasMemory&) = delete;
  BlasMemory& operator=(const BlasMemory&) = delete;
};

}  // namespace saltus
