// Words for messages: the nearest known name, lists of names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// The known name closest to `given` by edit distance (ties: the first), or an empty string when
/// none is near enough to be what was meant (more than half of the letters differ).
std::string nearest_name(std::string_view given, const std::vector<std::string>& known);

/// Text from outside as a message shows it: of a long one the beginning, and how long it is.
std::string shortened(std::string_view text);

/// Text with control characters (of a terminal's colours, say) as \n, \t or \x1b.
std::string printable(std::string_view text);

/// "a, b and c".
std::string join_names(const std::vector<std::string>& names);

}  // namespace saltus
