// Problems stored as data in benchmarks/data.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus::bench {

/// Path of the file in this build.
std::filesystem::path data_file(const std::string& name);
/// Reads the file. Throws InputError with its name if it is missing or not JSON.
nlohmann::json read_json(const std::filesystem::path& file);
/// Reads a list of `size` numbers; throws InputError with the name of the file otherwise.
VectorXd vector_of(const nlohmann::json& list, int size, const std::filesystem::path& file);

}  // namespace saltus::bench
