// SALTUS_SANITIZED is defined if the address sanitizer or the thread sanitizer is active. Their
// malloc keeps freed memory for some time.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SALTUS_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SALTUS_SANITIZED
#endif
#endif

namespace saltus::test {
#ifdef SALTUS_SANITIZED
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif
}  // namespace saltus::test
