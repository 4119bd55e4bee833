// Calls library code that may crash in a separate process.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace saltus {

/// Runs `work` in a forked copy of this process and returns its result. Returns nullopt if the copy
/// dies from a signal, throws, or exceeds a limit. The limits are `seconds` of CPU time, 10 *
/// seconds + 10 s of wall-clock time, and 4 GB of memory. All other side effects of `work` are
/// lost. Not for control loops.
std::optional<std::string> isolated_call(const std::function<std::string()>& work, int seconds);

}  // namespace saltus
