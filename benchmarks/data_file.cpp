#include "benchmarks/data_file.hpp"

#include <fmt/format.h>

#include "saltus/app/json_text.hpp"
#include "saltus/core/data_file.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/file_content.hpp"

namespace saltus::bench {

std::filesystem::path data_file(const std::string& name) {
  return saltus::data_file("benchmarks/data") / name;
}

nlohmann::json read_json(const std::filesystem::path& file) {
  const std::string text = file_content(file);
  reject_deep_json(text, file.string());
  nlohmann::json value = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded()) throw InputError(fmt::format("'{}' is not JSON", file.string()));
  return value;
}

VectorXd vector_of(const nlohmann::json& list, int size, const std::filesystem::path& file) {
  if (!list.is_array() || static_cast<int>(list.size()) != size)
    throw InputError(fmt::format("'{}' must contain a list of {} numbers, not {}", file.string(),
                                 size, list.dump().substr(0, 40)));
  VectorXd values(size);
  for (int i = 0; i < size; ++i) {
    if (!list[i].is_number())
      throw InputError(fmt::format("'{}' contains {} instead of a number", file.string(),
                                   list[i].dump().substr(0, 40)));
    values[i] = list[i].get<double>();
  }
  return values;
}

}  // namespace saltus::bench
