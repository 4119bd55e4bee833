// A whole file in memory, unless it is none or without an end.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace saltus {

/// More than any file that Saltus reads has: 64 MB.
inline constexpr std::size_t longest_file = std::size_t{1} << 26U;

/// What a file, or a stream with a name (/dev/stdin), holds. Throws InputError that names it if
/// there is no such file, if it is a folder, cannot be read or has more than `longest` bytes (a
/// device may have no end).
std::string file_content(const std::filesystem::path& file, std::size_t longest = longest_file);

}  // namespace saltus
