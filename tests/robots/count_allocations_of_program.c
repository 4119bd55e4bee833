/* Counts the allocations of a program for each second and for its main thread and all others, for
 * soak_control.py: LD_PRELOAD. At the end it writes one line per second to the file that
 * SALTUS_ALLOCATIONS names. glibc keeps its implementation of malloc under __libc_*. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum { most_seconds = 36000 };
static _Atomic unsigned counts[most_seconds][2];

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

static time_t now(void) {
  struct timespec clock;
  clock_gettime(CLOCK_MONOTONIC, &clock);
  return clock.tv_sec;
}
static time_t begin = 0;

static void count(void) {
  if (begin == 0) begin = now();
  const time_t second = now() - begin;
  if (second < most_seconds) ++counts[second][getpid() == gettid() ? 0 : 1];
}

void* malloc(size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(size_t number, size_t size) {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* old, size_t size) {
  count();
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, size_t alignment, size_t size) {
  count();
  *result = __libc_memalign(alignment, size);
  return *result == NULL ? ENOMEM : 0;
}

static void write_counts(void) __attribute__((destructor));
static void write_counts(void) {
  const char* name = getenv("SALTUS_ALLOCATIONS");
  FILE* file = name != NULL ? fopen(name, "w") : NULL;
  if (file == NULL) return;
  const time_t seconds = now() - begin;
  for (time_t s = 0; s <= seconds && s < most_seconds; ++s)
    fprintf(file, "%ld %u %u\n", (long)(begin + s), counts[s][0], counts[s][1]);
  fclose(file);
}
