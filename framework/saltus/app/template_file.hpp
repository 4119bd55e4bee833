// Files that are installed with the program and filled in where it runs.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace saltus {

/// What stands in a template for what: {"@NAME@", "cart"}.
using Marks = std::vector<std::pair<std::string, std::string>>;

/// The file with all marks replaced. Throws InputError if it cannot be read.
std::string filled_in(const std::filesystem::path& file, const Marks& marks);

}  // namespace saltus
