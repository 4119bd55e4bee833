#include "tests/support/count_allocations.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#include "tests/support/sanitized.hpp"

// Eigen allocates with malloc, so this file replaces malloc itself. glibc allows that and keeps its
// implementation under __libc_*. operator new calls malloc, so its calls are counted as well.
namespace {
std::atomic<long> allocations{0};
thread_local long allocations_here = 0;

void count_one() {
  ++allocations;
  ++allocations_here;
}
}  // namespace

#ifndef SALTUS_SANITIZED
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  count_one();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  count_one();
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  count_one();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count_one();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  count_one();
  *result = __libc_memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}
}
#else
// The sanitizer calls this hook after each allocation by malloc or new.
extern "C" void __sanitizer_malloc_hook(const volatile void*, std::size_t) { count_one(); }
#endif

namespace saltus::testing {

AllocationCount::AllocationCount() : start_(allocations), start_here_(allocations_here) {}
long AllocationCount::made() const { return allocations - start_; }
long AllocationCount::made_by_this_thread() const { return allocations_here - start_here_; }

}  // namespace saltus::testing
