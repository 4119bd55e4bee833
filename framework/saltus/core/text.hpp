// Text helpers for messages: nearest known name, name lists, printable text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saltus {

/// The known name closest to `given` by edit distance. The first one wins a tie. Empty if no name
/// is close, i.e. if more than half of the letters differ.
std::string nearest_name(std::string_view given, const std::vector<std::string>& known);

/// "; did you mean 'name'?" with the nearest name. Empty if no name is close.
std::string did_you_mean(std::string_view given, const std::vector<std::string>& known);

/// The text with its ASCII letters in lower case.
std::string lower_case(std::string text);

/// Shortens long text for a message: its beginning and its length in bytes.
std::string shortened(std::string_view text);

/// Replaces control characters, such as terminal colour codes, by \n, \t or \x1b.
std::string printable(std::string_view text);

/// Joins names as "a, b and c".
std::string join_names(const std::vector<std::string>& names);

}  // namespace saltus
