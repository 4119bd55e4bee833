// Installed template files that are filled in at run time.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace saltus {

/// Placeholders and their replacements: {"@NAME@", "cart"}.
using Marks = std::vector<std::pair<std::string, std::string>>;

/// Returns the file with all placeholders replaced. Throws InputError if it cannot be read.
std::string fill_template(const std::filesystem::path& file, const Marks& marks);

}  // namespace saltus
