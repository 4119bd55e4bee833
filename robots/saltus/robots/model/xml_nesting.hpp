// Is a text safe for an XML parser that recurses over elements?
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace saltus {

/// Robots and their meshes have some ten levels of elements.
inline constexpr int deepest_element = 100;

/// Why the text is not handed to a parser, as a clause: more than deepest_element open elements, or
/// brackets of which parsers do not agree where they end, so that nobody can count. None if there
/// is no such reason; what else is no XML is for the parser to say.
std::optional<std::string> nesting_doubt(std::string_view xml);

}  // namespace saltus
