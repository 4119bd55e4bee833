// Which way a guard passes through zero where its event happens.
#pragma once

namespace saltus {

/// The sign of the rate g_t + g_x f of a guard g(t, x, ...) at its event, before any jump.
enum class Crossing {
  rising,  ///< from negative to positive
  falling  ///< from positive to negative
};

/// In words, for messages.
constexpr const char* describe(Crossing crossing) {
  return crossing == Crossing::rising ? "rising" : "falling";
}

/// +1 for rising, -1 for falling: crossing_sign(c) * rate is positive for an event as declared.
constexpr double crossing_sign(Crossing crossing) {
  return crossing == Crossing::rising ? 1.0 : -1.0;
}

}  // namespace saltus
