// Reads arrays from a file of numpy's savez, as far as reference data need it: members stored
// without compression, doubles in one or two dimensions. (No packaged library reads these: libcnpy
// is not in Debian, and a general zip library would only replace the few bytes around each member.)
#pragma once

#include <map>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus::library {

/// Returns the arrays by name, without ".npy"; vectors have one column. Arrays of other types, such
/// as None for an absent array, are omitted. Throws InputError if the file has a different format.
std::map<std::string, MatrixXd> read_npz(const std::string& path);

}  // namespace saltus::library
