// JSON from elsewhere: refused before it is parsed where it is nested beyond reason.
#pragma once

#include <string_view>

namespace saltus {

/// Lists and objects in each other; ours have fewer than ten levels.
inline constexpr int deepest_json = 100;

/// What walks a document recurses, and would run out of stack in one of a million levels. Throws
/// InputError that names the source if the text has more than deepest_json.
void refuse_deep_json(std::string_view text, std::string_view source);

}  // namespace saltus
