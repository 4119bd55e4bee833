#include "saltus/robots/model/xml_nesting.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace saltus::robots {
namespace {

constexpr std::size_t none = std::string_view::npos;

bool begins_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (c & 0x80) != 0;
}

// Position of the bracket that ends a tag, outside of quotes.
std::size_t end_of_tag(std::string_view xml, std::size_t at) {
  for (at = xml.find_first_of("\"'>", at); at != none && xml[at] != '>';
       at = xml.find_first_of("\"'>", at + 1)) {
    at = xml.find(xml[at], at + 1);
    if (at == none) break;
  }
  return at;
}

}  // namespace

std::optional<std::string> xml_nesting_error(std::string_view xml) {
  constexpr std::string_view comment = "<!--", data = "<![CDATA[";
  int depth = 0;
  for (std::size_t at = xml.find('<'); at != none; at = xml.find('<', at)) {
    const std::string_view rest = xml.substr(at);
    if (rest.starts_with(comment)) {
      at = xml.find("-->", at + comment.size());
    } else if (rest.starts_with(data)) {
      at = xml.find("]]>", at + data.size());
    } else if (rest.starts_with("<?") || rest.starts_with("<!")) {
      if (depth > 0)
        return fmt::format("a declaration ({}) is inside an element", rest.substr(0, 2));
      at = xml.find('>', at);
    } else if (rest.starts_with("</")) {
      depth = std::max(0, depth - 1);
      at = xml.find('>', at);
    } else if (rest.size() < 2 || !begins_name(rest[1])) {
      return "a bracket (<) does not begin an element; write it as &lt;";
    } else {
      at = end_of_tag(xml, at);
      if (at != none && xml[at - 1] != '/' && ++depth > deepest_element)
        return fmt::format("elements are nested more than {} deep", deepest_element);
    }
    if (at == none) break;
  }
  return std::nullopt;
}

}  // namespace saltus::robots
