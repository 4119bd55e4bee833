// Check that a text is safe for an XML parser that recurses over elements.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace saltus::robots {

/// Largest accepted depth of elements. Robots and their meshes have about ten levels.
inline constexpr int deepest_element = 100;

/// Reason, as a clause, why the text must not be passed to a parser: more than deepest_element open
/// elements, or brackets whose end parsers interpret differently, so that the depth is not known.
/// Empty if there is no such reason. All other XML errors are left to the parser.
std::optional<std::string> xml_nesting_error(std::string_view xml);

}  // namespace saltus::robots
