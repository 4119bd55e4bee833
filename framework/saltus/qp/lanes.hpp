// SIMD vectors of the build's width: the arithmetic of the structured solver.
#pragma once

#include <cstdlib>
#include <memory>
#include <new>

// Kernels with compile-time sizes pay off only if they are inlined completely.
#define SALTUS_INLINE inline __attribute__((always_inline))

namespace saltus::qp {

// Uses only widths that the build's -march supports in hardware. Emulated vectors are ten times
// slower.
#if defined(__AVX512F__)
inline constexpr int lanes = 8;
#elif defined(__AVX__)
inline constexpr int lanes = 4;
#else
inline constexpr int lanes = 2;
#endif

/// A vector of `lanes` doubles with element-wise arithmetic (a gcc and clang extension).
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));

// Addresses must be multiples of the vector size.
inline Lanes load(const double* p) { return *reinterpret_cast<const Lanes*>(p); }
inline void store(double* p, const Lanes& a) { *reinterpret_cast<Lanes*>(p) = a; }
inline Lanes broadcast(double a) {
  // Lanes{} + a would be an addition that the compiler may not remove: 0 + -0 is not -0.
#if defined(__AVX512F__)
  return Lanes{a, a, a, a, a, a, a, a};
#elif defined(__AVX__)
  return Lanes{a, a, a, a};
#else
  return Lanes{a, a};
#endif
}
inline Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
inline Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
inline Lanes magnitude(const Lanes& a) { return larger(a, -a); }

template <class V>
inline double sum(const V& a) {
  constexpr int n = sizeof(V) / sizeof(double);
  if constexpr (n == 8)
    return ((a[0] + a[4]) + (a[1] + a[5])) + ((a[2] + a[6]) + (a[3] + a[7]));
  else if constexpr (n == 4)
    return (a[0] + a[2]) + (a[1] + a[3]);
  else
    return a[0] + a[1];
}
/// Sum of the lanes of every vector: sums(a)[i] = sum(a[i]).
inline Lanes sums(const Lanes (&a)[lanes]) {
#if defined(__AVX__) && !defined(__AVX512F__)
  const Lanes low = __builtin_shufflevector(a[0], a[1], 0, 4, 2, 6) +
                    __builtin_shufflevector(a[0], a[1], 1, 5, 3, 7);
  const Lanes high = __builtin_shufflevector(a[2], a[3], 0, 4, 2, 6) +
                     __builtin_shufflevector(a[2], a[3], 1, 5, 3, 7);
  return __builtin_shufflevector(low, high, 0, 1, 4, 5) +
         __builtin_shufflevector(low, high, 2, 3, 6, 7);
#else
  Lanes result;
  for (int i = 0; i < lanes; ++i) result[i] = sum(a[i]);
  return result;
#endif
}
inline double largest(const Lanes& a) {
  double result = a[0];
  for (int i = 1; i < lanes; ++i) result = result < a[i] ? a[i] : result;
  return result;
}

// Loads and stores at addresses without alignment.
typedef double LooseLanes __attribute__((vector_size(lanes * sizeof(double)), aligned(8)));
inline Lanes load_loose(const double* p) { return *reinterpret_cast<const LooseLanes*>(p); }
inline void store_loose(double* p, const Lanes& a) { *reinterpret_cast<LooseLanes*>(p) = a; }

/// Rounds n up to whole vectors.
constexpr int padded(int n) { return (n + lanes - 1) / lanes * lanes; }

/// A zero-initialised array of doubles of fixed size on a 64-byte boundary.
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size) : size_(size) {
    const std::size_t bytes = (size * sizeof(double) + 63) / 64 * 64 + 64;
    data_.reset(static_cast<double*>(std::aligned_alloc(64, bytes)));
    if (!data_) throw std::bad_alloc();
    for (std::size_t i = 0; i < bytes / sizeof(double); ++i) data_[i] = 0.0;
  }
  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  double& operator[](std::size_t i) { return data_[i]; }
  const double& operator[](std::size_t i) const { return data_[i]; }

 private:
  struct Free {
    void operator()(double* p) const { std::free(p); }
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0;
};

}  // namespace saltus::qp
