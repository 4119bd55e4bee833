// Deprecated: use saltus/core/data_file.hpp. Removed in 0.4.
#pragma once

#include "saltus/core/data_file.hpp"
