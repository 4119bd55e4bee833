// Problems that are stored as data: benchmarks/data.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus::bench {

/// Where this build finds the file.
std::filesystem::path data_file(const std::string& name);
/// Throws InputError naming the file if it is missing or no JSON.
nlohmann::json read_json(const std::filesystem::path& file);
/// A list of `size` numbers; throws InputError naming the file otherwise.
VectorXd vector_of(const nlohmann::json& list, int size, const std::filesystem::path& file);

}  // namespace saltus::bench
