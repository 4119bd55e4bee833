// Version and commit of Saltus.
#pragma once

#include <string>

namespace saltus {

/// Version such as "0.3.0".
std::string version();
/// Abbreviated commit of the sources at configuration; "unknown" without a git history.
std::string commit();

}  // namespace saltus
