// Memory layout of the tangent of a dual number: packs of doubles for vector instructions.
//
// The width follows the target: 8 doubles with AVX-512, 4 with AVX, otherwise 2. A pack wider than
// the registers is slow and changes the calling convention. The width is therefore part of the
// names that depend on it (SALTUS_LANES_ABI). A program and an installed library may thus use
// different -march options: each keeps its own instances of the templates.
//
// Packs have the alignment of a double. Eigen aligns the heap to 16 bytes only
// (EIGEN_MAX_ALIGN_BYTES=16). A dynamic matrix of duals with naturally aligned packs would crash.
#pragma once

// Name of an inline namespace.
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

/// A vector of `lanes` doubles with element-wise + - * and double * Pack. Each width is a separate
/// specialisation because types that depend on a template parameter lose vector attributes.
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

/// The widest pack of the target that n doubles fill.
constexpr int lanes_for(int n) {
  int lanes = 1;
  while (lanes < n && lanes < native_lanes) lanes *= 2;
  return lanes;
}

/// n doubles stored in whole packs. Surplus lanes are computed and never read.
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
  /// Loads packs * lanes doubles.
  static Chunk load(const double* values) {
    // Vector types may alias their elements. A memcpy would use smaller pieces than the next read.
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
  /// s a + r b in one pass, for the product and chain rules of two arguments.
  [[gnu::always_inline]] friend Chunk combine(double s, const Chunk& a, double r, const Chunk& b) {
    Chunk c;
    for (int k = 0; k < packs; ++k) c.packs_[k] = s * a.packs_[k] + r * b.packs_[k];
    return c;
  }

 private:
  using Lanes = typename Pack<lanes>::Lanes;
  Lanes packs_[packs];
};

/// An empty tangent, for a number without derivatives.
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
