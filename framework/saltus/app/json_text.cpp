#include "saltus/app/json_text.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"

namespace saltus {

void reject_deep_json(std::string_view text, std::string_view source) {
  int depth = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_string && c == '\\')
      ++i;  // the escaped character belongs to the string
    else if (c == '"')
      is_string = !is_string;
    else if (!is_string && (c == '[' || c == '{') && ++depth > deepest_json)
      throw InputError(
          fmt::format("'{}' is nested more than {} levels deep", source, deepest_json));
    else if (!is_string && (c == ']' || c == '}'))
      --depth;
  }
}

}  // namespace saltus
