// Memory runs out while a controller is set up: at the k-th allocation, for k from the first to the
// last. The set-up throws an exception and leaks nothing, and the next set-up works as usual.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>

#include "saltus/core/error.hpp"
#include "tests/faults/loop.hpp"
#include "tests/support/sanitized.hpp"

// Replaces malloc itself, because Eigen and C libraries do not use operator new. Not under a
// sanitizer, which has its own malloc.
#ifndef SALTUS_SANITIZED
namespace {
constexpr long never = std::numeric_limits<long>::max();
std::atomic<long> left{never};  // allocations until one fails
std::atomic<long> made{0}, alive{0};

bool fails() {
  ++made;
  return left != never && --left < 0;
}
void* counted(void* block) {
  if (block != nullptr) ++alive;
  return block;
}
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return fails() ? nullptr : counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) {
  return fails() ? nullptr : counted(__libc_calloc(count, size));
}
void* realloc(void* old, std::size_t size) {
  if (fails()) return nullptr;
  void* const block = __libc_realloc(old, size);
  return old == nullptr ? counted(block) : block;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return fails() ? nullptr : counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = fails() ? nullptr : counted(__libc_memalign(alignment, size));
  return *result == nullptr ? ENOMEM : 0;
}
void free(void* block) {
  if (block != nullptr) --alive;
  __libc_free(block);
}
}

namespace saltus::test {
namespace {

enum class End { whole, out_of_memory, sentence, other };

// The set-up fails at its k-th allocation and at each later one.
End set_up(long k) {
  End end = End::whole;
  left = k;
  try {
    const FaultyLoop loop;
  } catch (const std::bad_alloc&) {
    end = End::out_of_memory;
  } catch (const DefinitionError&) {
    end = End::sentence;
  } catch (...) {
    end = End::other;
  }
  left = never;
  return end;
}

TEST(OutOfMemory, LeaksNothingDuringSetUpOfAController) {
  ASSERT_EQ(set_up(never), End::whole);  // allocates everything that exists once per process
  const long begin = made;
  ASSERT_EQ(set_up(never), End::whole);
  const long all = made - begin;
  ASSERT_GT(all, 100);
  constexpr long points = 400;
  const long stride = std::max(1L, all / points);
  long refused = 0;
  for (long k = 0; k < all; k += k < 100 ? 1 : stride) {
    SCOPED_TRACE(fmt::format("allocation {} of {}", k, all));
    const long before = alive;
    const End end = set_up(k);
    const long leaked = alive - before;
    EXPECT_NE(end, End::other);
    EXPECT_EQ(leaked, 0);
    refused += end != End::whole ? 1 : 0;
  }
  EXPECT_GT(refused, points / 2);
  EXPECT_EQ(set_up(never), End::whole);
  FaultyLoop loop;
  for (int k = 0; k < 50; ++k) loop.tick(Fault::none);
  EXPECT_TRUE(loop.input_is_sound());
}

}  // namespace
}  // namespace saltus::test
#else
TEST(OutOfMemory, LeaksNothingDuringSetUpOfAController) {
  GTEST_SKIP() << "the sanitizer replaces malloc, so the test cannot make it fail";
}
#endif
