#include "saltus/app/template_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "saltus/core/error.hpp"

namespace saltus {

std::string fill_template(const std::filesystem::path& file, const Marks& marks) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("the template '{}' cannot be read", file.string()));
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  for (const auto& [mark, value] : marks)
    for (std::size_t at = text.find(mark); at != std::string::npos;
         at = text.find(mark, at + value.size()))
      text.replace(at, mark.size(), value);
  return text;
}

}  // namespace saltus
