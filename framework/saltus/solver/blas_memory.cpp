#include "saltus/solver/blas_memory.hpp"

#include <sys/mman.h>

#include <mutex>
#include <new>
#include <vector>

// Null with any other BLAS.
extern "C" void* blas_memory_alloc(int) __attribute__((weak));
extern "C" void blas_memory_free(void*) __attribute__((weak));

namespace saltus {
namespace {

// OpenBLAS 0.3 allocates 32 to 128 MB per buffer, and glibc reserves as much again for the heap of
// a thread.
constexpr std::size_t largest_buffer = std::size_t{160} << 20U;  // bytes

std::mutex mutex;
std::size_t users = 0, buffers = 0;

bool is_available(std::size_t bytes) {
  void* memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, /*fd=*/-1, 0);
  return memory != MAP_FAILED && ::munmap(memory, bytes) == 0;
}

}  // namespace

BlasMemory::BlasMemory() {
  if (blas_memory_alloc == nullptr || blas_memory_free == nullptr) return;
  const std::lock_guard lock(mutex);
  if (users == buffers) {
    // Allocated together, so that there are as many buffers as users.
    std::vector<void*> held(buffers + 1);
    if (!is_available(held.size() * largest_buffer)) throw std::bad_alloc();
    for (void*& buffer : held) buffer = blas_memory_alloc(0);
    for (void* buffer : held) blas_memory_free(buffer);
    buffers = held.size();
  }
  ++users;
}

BlasMemory::~BlasMemory() {
  if (blas_memory_alloc == nullptr || blas_memory_free == nullptr) return;
  const std::lock_guard lock(mutex);
  --users;
}

}  // namespace saltus
