// Direction in which a guard crosses zero at its event.
#pragma once

namespace saltus {

/// Sign of the rate g_t + g_x f of a guard g(t, x, ...) at its event, before a jump.
enum class Crossing {
  rising,  ///< from negative to positive
  falling  ///< from positive to negative
};

/// Text for messages.
constexpr const char* describe(Crossing crossing) {
  return crossing == Crossing::rising ? "rising" : "falling";
}

/// +1 for rising, -1 for falling. crossing_sign(c) * rate is positive at an event in direction c.
constexpr double crossing_sign(Crossing crossing) {
  return crossing == Crossing::rising ? 1.0 : -1.0;
}

}  // namespace saltus
