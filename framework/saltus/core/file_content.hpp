// Reads a whole file into memory, up to a limit.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace saltus {

/// Default limit of file_content(): 64 MB. No file that Saltus reads is larger.
inline constexpr std::size_t max_file_size = std::size_t{1} << 26U;

/// Content of a file or of a named stream such as /dev/stdin. Throws InputError with the name if it
/// does not exist, is a folder, cannot be read or has more than `longest` bytes. The limit guards
/// against endless devices.
std::string file_content(const std::filesystem::path& file, std::size_t longest = max_file_size);

}  // namespace saltus
