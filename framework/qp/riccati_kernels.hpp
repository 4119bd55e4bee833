// One stage of the Riccati recursion: elimination of its inputs, and the two sweeps that use it.
// Derivation: framework/design/riccati.md. The same source serves sizes known to the compiler and
// sizes known at run time only (-1).
#pragma once

#include "saltus/qp/lanes.hpp"

namespace saltus::qp {

/// A size, known to the compiler if N >= 0.
template <int N>
struct Extent {
  explicit constexpr Extent(int) {}
  constexpr operator int() const { return N; }
};
template <>
struct Extent<-1> {
  explicit constexpr Extent(int size) : n(size) {}
  constexpr operator int() const { return n; }
  int n;
};

/// Matrices by columns, every column padded to whole vectors; stage vector v = (x, u), n = nx + nu.
struct SweepStage {
  int nx = 0, nu = 0, next = 0;             ///< next: states of the stage that follows
  int ld = 0;                               ///< padded(nx + nu)
  int ld_next = 0;                          ///< padded(next)
  const double* flow = nullptr;             ///< [A B], next x n, leading dimension ld_next
  const double* flow_transposed = nullptr;  ///< n x next, leading dimension ld
  /// n x n, upper triangle: before factor() cost and barrier, after it P in the leading nx x nx
  /// (both triangles).
  double* M = nullptr;
  double* L = nullptr;       ///< ld x nu: unit upper factor, without its diagonal
  double* pivot = nullptr;   ///< nu: inverse pivots
  bool curves_down = false;  ///< set by factor() when it met a pivot that is clearly negative
  double* p = nullptr;       ///< ld: gradient; after backward() of the cost to go, eliminated below
};

/// A pivot this small beside the diagonal it began as is nothing but rounding.
inline constexpr double lost_digits = 1e-15;
/// A pivot below minus this, relative to 1 + the diagonal it began as, is more than rounding.
inline constexpr double clearly_negative = 1e-12;

enum class Update { set, add, subtract };

// V vectors x C columns of out (+/-)= A B, B(i, j) = B[i * step_i + j * step_j].
template <Update update, int V, int C>
SALTUS_INLINE void tile(int depth, const double* A, int lda, const double* B, int step_i,
                        int step_j, double* out, int ldo) {
  Lanes acc[C][V];
  for (int c = 0; c < C; ++c)
    for (int v = 0; v < V; ++v)
      acc[c][v] = update == Update::set ? Lanes{} : load(out + c * ldo + v * lanes);
  for (int i = 0; i < depth; ++i) {
    Lanes a[V];
    for (int v = 0; v < V; ++v) a[v] = load(A + i * lda + v * lanes);
    for (int c = 0; c < C; ++c) {
      const Lanes b = broadcast(B[i * step_i + c * step_j]);
      for (int v = 0; v < V; ++v)
        if constexpr (update == Update::subtract)
          acc[c][v] -= a[v] * b;
        else
          acc[c][v] += a[v] * b;
    }
  }
  for (int c = 0; c < C; ++c)
    for (int v = 0; v < V; ++v) store(out + c * ldo + v * lanes, acc[c][v]);
}

// C columns of any height. Tiles are as high as the registers allow.
template <Update update, int C>
SALTUS_INLINE void strip(int vectors, int depth, const double* A, int lda, const double* B,
                         int step_i, int step_j, double* out, int ldo) {
  constexpr int high = lanes == 8 ? 4 : 3;
  int v = 0;
  while (vectors - v > high + 1 || vectors - v == high) {
    tile<update, high, C>(depth, A + v * lanes, lda, B, step_i, step_j, out + v * lanes, ldo);
    v += high;
  }
  const auto rest = [&]<int V>() {
    tile<update, V, C>(depth, A + v * lanes, lda, B, step_i, step_j, out + v * lanes, ldo);
    v += V;
  };
  if (vectors - v >= 4) rest.template operator()<2>();
  if (vectors - v == 3) rest.template operator()<3>();
  if (vectors - v == 2) rest.template operator()<2>();
  if (vectors - v == 1) rest.template operator()<1>();
}

// What whole strips of four have left over.
template <Update update>
SALTUS_INLINE void last_strip(int columns, int vectors, int depth, const double* A, int lda,
                              const double* B, int step_i, int step_j, double* out, int ldo) {
  if (columns == 3) strip<update, 3>(vectors, depth, A, lda, B, step_i, step_j, out, ldo);
  if (columns == 2) strip<update, 2>(vectors, depth, A, lda, B, step_i, step_j, out, ldo);
  if (columns == 1) strip<update, 1>(vectors, depth, A, lda, B, step_i, step_j, out, ldo);
}

/// out (+/-)= A B for out with `columns` columns of `rows` entries.
template <Update update>
SALTUS_INLINE void multiply(int rows, int columns, int depth, const double* A, int lda,
                            const double* B, int step_i, int step_j, double* out, int ldo) {
  const int vectors = padded(rows) / lanes;
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    strip<update, 4>(vectors, depth, A, lda, B + j * step_j, step_i, step_j, out + j * ldo, ldo);
  last_strip<update>(columns - j, vectors, depth, A, lda, B + j * step_j, step_i, step_j,
                     out + j * ldo, ldo);
}

/// The same for the upper triangle of a symmetric result.
template <Update update>
SALTUS_INLINE void multiply_upper(int columns, int depth, const double* A, int lda, const double* B,
                                  int step_i, int step_j, double* out, int ldo) {
  int j = 0;
  for (; j + 4 <= columns; j += 4)
    strip<update, 4>(padded(j + 4) / lanes, depth, A, lda, B + j * step_j, step_i, step_j,
                     out + j * ldo, ldo);
  last_strip<update>(columns - j, padded(columns) / lanes, depth, A, lda, B + j * step_j, step_i,
                     step_j, out + j * ldo, ldo);
}

// V vectors of y (+/-)= A x; two sums where one would wait for its own additions.
template <Update update, int V>
SALTUS_INLINE void vector_tile(int columns, const double* A, int lda, const double* x, double* y) {
  Lanes even[V], odd[V];
  for (int v = 0; v < V; ++v) {
    even[v] = update == Update::set ? Lanes{} : load(y + v * lanes);
    odd[v] = Lanes{};
  }
  int j = 0;
  for (; j + 2 <= columns; j += 2) {
    const Lanes a = broadcast(x[j]), b = broadcast(x[j + 1]);
    for (int v = 0; v < V; ++v) {
      even[v] += load(A + j * lda + v * lanes) * a;
      odd[v] += load(A + (j + 1) * lda + v * lanes) * b;
    }
  }
  if (j < columns) {
    const Lanes a = broadcast(x[j]);
    for (int v = 0; v < V; ++v) even[v] += load(A + j * lda + v * lanes) * a;
  }
  for (int v = 0; v < V; ++v) store(y + v * lanes, even[v] + odd[v]);
}

/// y (+)= A x.
template <Update update>
SALTUS_INLINE void multiply_vector(int rows, int columns, const double* A, int lda, const double* x,
                                   double* y) {
  const int vectors = padded(rows) / lanes;
  int v = 0;
  for (; v + 4 <= vectors; v += 4)
    vector_tile<update, 4>(columns, A + v * lanes, lda, x, y + v * lanes);
  A += v * lanes;
  y += v * lanes;
  if (vectors - v == 3) vector_tile<update, 3>(columns, A, lda, x, y);
  if (vectors - v == 2) vector_tile<update, 2>(columns, A, lda, x, y);
  if (vectors - v == 1) vector_tile<update, 1>(columns, A, lda, x, y);
}

/// What the recursion does at one stage.
template <int NX, int NU, int NN>
struct RiccatiStage {
  /// M += flow' P flow, then eliminates the inputs. P: next x next, leading dimension ld_P.
  /// `work`: ld_next x n. Pivots at or below `least_pivot` are replaced.
  static void factor(SweepStage& s, const double* P, int ld_P, double* work, double least_pivot) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    if (nn > 0) {
      multiply<Update::set>(nn, n, nn, P, ld_P, s.flow, 1, ld_next, work, ld_next);
      multiply_upper<Update::add>(n, nn, s.flow_transposed, ld, work, 1, ld_next, s.M, ld);
    }
    for (int j = 0; j < nu; ++j) s.pivot[j] = s.M[(nx + j) * (ld + 1)];
    for (int j = nu - 1; j >= 0; --j) {
      double* column = s.M + (nx + j) * ld;
      double* factor = s.L + j * ld;
      double pivot = column[nx + j];
      // What rounding has left of a stiff direction: it stays where it is in this step.
      if (!(pivot > least_pivot + lost_digits * s.pivot[j])) {
        if (pivot < -clearly_negative * (1.0 + (s.pivot[j] < 0.0 ? -s.pivot[j] : s.pivot[j])))
          s.curves_down = true;
        pivot = s.pivot[j] > least_pivot ? s.pivot[j] : least_pivot;
      }
      const double inverse = 1.0 / pivot;
      s.pivot[j] = inverse;
      // Entries from the diagonal down must not count in the sweeps.
      for (int i = nx + j; i < padded(nx + j + 1); ++i) column[i] = 0.0;
      const int height = padded(nx + j);
      for (int v = 0; v < height; v += lanes) store(factor + v, load(column + v) * inverse);
      for (int c = 0; c < j; ++c) {
        const double m = column[nx + c];
        double* target = s.M + (nx + c) * ld;
        for (int v = 0; v < padded(nx + c + 1); v += lanes)
          store(target + v, load(target + v) - load(factor + v) * m);
      }
    }
    if (nx > 0 && nu > 0)
      multiply_upper<Update::subtract>(nx, nu, s.L, ld, s.M + nx * ld, ld, 1, s.M, ld);
    for (int j = 1; j < nx; ++j)
      for (int i = 0; i < j; ++i) s.M[j + i * ld] = s.M[i + j * ld];
  }

  /// s.p: gradient in, cost-to-go out. `gap`: defect A x + B u + b - x_next; `P`, `p` of the next
  /// stage; `work`: ld_next.
  static void backward(SweepStage& s, const double* P, int ld_P, const double* p, const double* gap,
                       double* work) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n);
    if (nn > 0) {
      for (int v = 0; v < padded(nn); v += lanes) store(work + v, load(p + v));
      multiply_vector<Update::add>(nn, nn, P, ld_P, gap, work);
      multiply_vector<Update::add>(n, nn, s.flow_transposed, ld, work, s.p);
    }
    for (int j = nu - 1; j >= 0; --j) {
      const double h = s.p[nx + j];
      for (int v = 0; v < padded(nx + j); v += lanes)
        store(s.p + v, load(s.p + v) - load(s.L + j * ld + v) * h);
    }
  }

  /// v: x in, u out; then the next stage's x and the multipliers of the dynamics.
  static void forward(const SweepStage& s, const double* P, int ld_P, const double* p,
                      const double* gap, double* v, double* v_next, double* costate) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    // The part of x first: the products of the inputs are independent of one another.
    for (int j = 0; j < nu; ++j) {
      const double* factor = s.L + j * ld;
      Lanes dot{};
      int i = 0;
      for (; i + lanes <= nx; i += lanes) dot += load(factor + i) * load(v + i);
      double total = sum(dot);
      for (; i < nx; ++i) total += factor[i] * v[i];
      v[nx + j] = -s.p[nx + j] * s.pivot[j] - total;
    }
    for (int j = 1; j < nu; ++j) {
      double total = v[nx + j];
      for (int i = 0; i < j; ++i) total -= s.L[j * ld + nx + i] * v[nx + i];
      v[nx + j] = total;
    }
    if (nn == 0) return;
    for (int i = 0; i < ld_next; i += lanes) store(v_next + i, load(gap + i));
    multiply_vector<Update::add>(nn, n, s.flow, ld_next, v, v_next);
    for (int i = nn; i < ld_next; ++i) v_next[i] = 0.0;
    for (int i = 0; i < ld_next; i += lanes) store(costate + i, load(p + i));
    multiply_vector<Update::add>(nn, nn, P, ld_P, v_next, costate);
    for (int i = nn; i < ld_next; ++i) costate[i] = 0.0;
  }

  /// gradient += H v, force = flow' costate, gap += flow u - next, where u is v or what the
  /// dynamics see in its place.
  static void products(const SweepStage& s, const double* H, const double* v, const double* u,
                       const double* costate, const double* v_next, double* gradient, double* force,
                       double* gap) {
    const Extent<NX> nx(s.nx);
    const Extent<NU> nu(s.nu);
    const Extent<NN> nn(s.next);
    const int n = nx + nu, ld = padded(n), ld_next = padded(nn);
    multiply_vector<Update::add>(n, n, H, ld, v, gradient);
    if (nn == 0) return;
    multiply_vector<Update::set>(n, nn, s.flow_transposed, ld, costate, force);
    multiply_vector<Update::add>(nn, n, s.flow, ld_next, u, gap);
    int i = 0;
    for (; i + lanes <= nn; i += lanes) store(gap + i, load(gap + i) - load(v_next + i));
    for (; i < nn; ++i) gap[i] -= v_next[i];
    for (; i < ld_next; ++i) gap[i] = 0.0;
  }
};

/// The functions of one combination of sizes, behind pointers.
struct RiccatiKernel {
  int nx, nu, next;  ///< -1: any
  void (*factor)(SweepStage&, const double*, int, double*, double);
  void (*backward)(SweepStage&, const double*, int, const double*, const double*, double*);
  void (*forward)(const SweepStage&, const double*, int, const double*, const double*, double*,
                  double*, double*);
  void (*products)(const SweepStage&, const double*, const double*, const double*, const double*,
                   const double*, double*, double*, double*);
};

template <int NX, int NU, int NN>
constexpr RiccatiKernel riccati_kernel() {
  using S = RiccatiStage<NX, NU, NN>;
  return {NX, NU, NN, &S::factor, &S::backward, &S::forward, &S::products};
}

}  // namespace saltus::qp
