// How the directional derivatives of a dual number lie in memory: chunks of doubles that the
// processor adds and multiplies at once.
//
// The width follows the target (8 doubles with AVX-512, 4 with AVX, else 2): a wider pack than the
// machine has is slow and changes the calling convention. The width is therefore part of the names
// of what depends on it (SALTUS_LANES_ABI), so that a program and an installed library may be built
// with different -march: each keeps its own instances, and no type of one meets code of the other.
//
// Packs are aligned like one double. Eigen is told (EIGEN_MAX_ALIGN_BYTES=16) to align the heap to
// 16 bytes only, so that a dynamic matrix of duals with naturally aligned packs would be a crash.
#pragma once

// The name of an inline namespace.
#if defined(__AVX512F__)
#define SALTUS_LANES_ABI lanes_8
#elif defined(__AVX__)
#define SALTUS_LANES_ABI lanes_4
#else
#define SALTUS_LANES_ABI lanes_2
#endif

namespace saltus {
inline namespace SALTUS_LANES_ABI {

#if defined(__AVX512F__)
inline constexpr int native_lanes = 8;
#elif defined(__AVX__)
inline constexpr int native_lanes = 4;
#else
inline constexpr int native_lanes = 2;
#endif

/// A vector of `lanes` doubles with element-wise + - * and double * Pack. Written out for each
/// width because vector attributes are dropped from types that depend on a template parameter.
template <int lanes>
struct Pack;
template <>
struct Pack<1> {
  using Lanes = double;
};
template <>
struct Pack<2> {
  using Lanes [[gnu::vector_size(16), gnu::aligned(8)]] = double;
};
template <>
struct Pack<4> {
  using Lanes [[gnu::vector_size(32), gnu::aligned(8)]] = double;
};
template <>
struct Pack<8> {
  using Lanes [[gnu::vector_size(64), gnu::aligned(8)]] = double;
};

/// The widest pack that the machine has and n doubles fill.
constexpr int lanes_for(int n) {
  int lanes = 1;
  while (lanes < n && lanes < native_lanes) lanes *= 2;
  return lanes;
}

/// n doubles, stored in whole packs; the lanes beyond n are computed and never read.
template <int n>
class Chunk {
 public:
  static constexpr int lanes = lanes_for(n);
  static constexpr int packs = (n + lanes - 1) / lanes;

  static Chunk zero() {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = Lanes{};
    return c;
  }
  /// From packs * lanes doubles.
  static Chunk load(const double* values) {
    // Vectors may alias their elements; a memcpy would go in smaller pieces than are read next.
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = reinterpret_cast<const Lanes*>(values)[k];
    return c;
  }
  static Chunk unit(int lane) {
    Chunk c = zero();
    c.set(lane, 1.0);
    return c;
  }

  double operator[](int i) const {
    if constexpr (lanes == 1) {
      return packs_[i];
    } else {
      return packs_[i / lanes][i % lanes];
    }
  }
  void set(int i, double value) {
    if constexpr (lanes == 1) {
      packs_[i] = value;
    } else {
      packs_[i / lanes][i % lanes] = value;
    }
  }

  Chunk& operator+=(const Chunk& b) {
    for (int k = 0; k < packs; ++k) packs_[k] += b.packs_[k];
    return *this;
  }
  Chunk& operator-=(const Chunk& b) {
    for (int k = 0; k < packs; ++k) packs_[k] -= b.packs_[k];
    return *this;
  }
  [[gnu::always_inline]] friend Chunk operator+(const Chunk& a, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = a.packs_[k] + b.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator-(const Chunk& a, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = a.packs_[k] - b.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator-(const Chunk& a) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = -a.packs_[k];
    return c;
  }
  [[gnu::always_inline]] friend Chunk operator*(double s, const Chunk& a) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = s * a.packs_[k];
    return c;
  }
  /// s a + r b in one sweep: the product and chain rules of two arguments.
  [[gnu::always_inline]] friend Chunk combine(double s, const Chunk& a, double r, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = s * a.packs_[k] + r * b.packs_[k];
    return c;
  }

 private:
  using Lanes = typename Pack<lanes>::Lanes;
  Lanes packs_[packs];
};

/// Nothing: the derivatives of a number that is only evaluated.
template <>
class Chunk<0> {
 public:
  static Chunk zero() { return {}; }
  Chunk& operator+=(const Chunk&) { return *this; }
  Chunk& operator-=(const Chunk&) { return *this; }
  friend Chunk operator+(const Chunk&, const Chunk&) { return {}; }
  friend Chunk operator-(const Chunk&, const Chunk&) { return {}; }
  friend Chunk operator-(const Chunk&) { return {}; }
  friend Chunk operator*(double, const Chunk&) { return {}; }
  friend Chunk combine(double, const Chunk&, double, const Chunk&) { return {}; }
};

}  // namespace SALTUS_LANES_ABI
}  // namespace saltus
