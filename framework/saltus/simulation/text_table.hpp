// Deprecated: use saltus/core/csv_table.hpp and saltus/core/json_object.hpp. Removed in 0.4.
#pragma once

#include "saltus/core/csv_table.hpp"
#include "saltus/core/json_object.hpp"

namespace saltus {

/// Of 0.2.
using TextTable [[deprecated("use CsvTable; removed in 0.4")]] = CsvTable;

}  // namespace saltus
