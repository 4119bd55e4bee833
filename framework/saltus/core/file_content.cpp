#include "saltus/core/file_content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"

namespace saltus {

namespace fs = std::filesystem;

std::string file_content(const fs::path& file, std::size_t longest) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: {}", shortened(file.string()), why));
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) refuse("there is no such file");
  if (fs::is_directory(status)) refuse("this is a folder, not a file");
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  constexpr std::size_t piece = std::size_t{1} << 16U;
  while (stream && text.size() <= longest) {
    const std::size_t begin = text.size();
    text.resize(begin + piece);
    stream.read(text.data() + begin, piece);
    text.resize(begin + static_cast<std::size_t>(stream.gcount()));
  }
  if (text.size() > longest)
    refuse(fmt::format("the file has more than {} MB, the limit for files that Saltus reads",
                       longest >> 20U));
  if (!stream.eof()) refuse("the file cannot be read; check its permissions");
  return text;
}

}  // namespace saltus
