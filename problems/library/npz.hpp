// Arrays from a file of numpy's savez, as far as reference data need it: members stored without
// compression, doubles in one or two dimensions. (No packaged library reads these: libcnpy is not
// in Debian, and a general one for zip archives would serve for the few bytes around each member.)
#pragma once

#include <map>
#include <string>

#include "saltus/core/types.hpp"

namespace saltus::library {

/// By name, without ".npy"; vectors have one column. Arrays of other types, such as the None that
/// stands for an absent one, are left out. Throws InputError if the file is not of this kind.
std::map<std::string, MatrixXd> read_npz(const std::string& path);

}  // namespace saltus::library
