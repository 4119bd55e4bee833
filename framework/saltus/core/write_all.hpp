// All of a text into a pipe.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <string_view>

namespace saltus {

/// As much as the other end takes: what is missing there says that it has gone.
inline void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

}  // namespace saltus
