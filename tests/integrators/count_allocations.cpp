// The functions below take the place of the C library's for the whole program and hand over to it
// under its internal names (glibc).
#include "tests/integrators/count_allocations.hpp"

#include <atomic>
#include <cstddef>

namespace {
std::atomic<long> allocations{0};
}  // namespace

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SALTUS_HEAP_IS_TAKEN
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define SALTUS_HEAP_IS_TAKEN
#endif

#ifndef SALTUS_HEAP_IS_TAKEN
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace saltus::test {

AllocationCount::AllocationCount() : start_(allocations) {}
long AllocationCount::so_far() const { return allocations - start_; }

bool AllocationCount::works() {
#ifdef SALTUS_HEAP_IS_TAKEN
  return false;
#else
  return true;
#endif
}

}  // namespace saltus::test
