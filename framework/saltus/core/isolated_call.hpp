// Work of libraries that may break down, in a process of its own.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace saltus {

/// What `work` returns, computed by a copy of this process: none if that is ended by a signal,
/// leaves an exception, takes more than `seconds` of processor time, ten times as long on the clock
/// (and 10 s more) or 4 GB of memory. Nothing else of what it does is seen here. Not for control
/// loops.
std::optional<std::string> isolated_call(const std::function<std::string()>& work, int seconds);

}  // namespace saltus
