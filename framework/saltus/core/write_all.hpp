// Writes a whole text to a pipe.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <string_view>

namespace saltus {

/// Writes until the text ends or the other end closes. Errors are ignored: the reader notices
/// missing text.
inline void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

}  // namespace saltus
