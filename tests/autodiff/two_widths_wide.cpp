// Compiled for vectors of four doubles.
#include "two_widths.hpp"

saltus::two_widths::Derivatives saltus::two_widths::derivatives_wide() {
  return derivatives_here();
}
