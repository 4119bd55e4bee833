// A number beside what it should be.
#pragma once

#include <cmath>
#include <string>

namespace saltus {

struct CheckedValue {
  std::string name;        ///< "x(3)[0]", "dJ/dx0"
  double value = 0.0;      ///< ours
  double reference = 0.0;  ///< published, computed independently, or in closed form
  double tolerance = 0.0;  ///< absolute
  int digits = 0;          ///< of the reference that are known

  double error() const { return std::abs(value - reference); }
  bool is_met() const { return error() <= tolerance; }  // false for NaN
};

}  // namespace saltus
