// Rejects external JSON that is nested too deeply, before it is parsed.
#pragma once

#include <string_view>

namespace saltus {

/// Maximum nesting of lists and objects. Files of this project have fewer than ten levels.
inline constexpr int deepest_json = 100;

/// Parsers recurse and would overflow the stack on extremely deep documents. Throws InputError that
/// names the source if the text is nested deeper than deepest_json.
void reject_deep_json(std::string_view text, std::string_view source);

}  // namespace saltus
