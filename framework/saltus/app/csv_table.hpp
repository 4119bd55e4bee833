// Deprecated: use saltus/core/csv_table.hpp. Removed in 0.4.
#pragma once

#include "saltus/core/csv_table.hpp"
