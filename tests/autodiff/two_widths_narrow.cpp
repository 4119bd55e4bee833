// Compiled for the baseline of the architecture.
#include "two_widths.hpp"

saltus::two_widths::Derivatives saltus::two_widths::derivatives_narrow() {
  return derivatives_here();
}
