// Which Saltus is this?
#pragma once

#include <string>

namespace saltus {

/// "0.2.0".
std::string version();
/// The commit that was checked out when the build was configured, abbreviated; "unknown" of sources
/// without a history.
std::string commit();

}  // namespace saltus
