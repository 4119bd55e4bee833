// Kernels for rows of a stage with few columns: products, and their contribution to the Hessian.
#pragma once

#include <algorithm>

#include "saltus/qp/riccati_kernels.hpp"

namespace saltus::qp {

constexpr int pairs_of(int columns) { return columns * (columns + 1) / 2; }
/// Entries of an upper triangle whose columns are padded to whole vectors.
constexpr int padded_pairs_of(int columns) {
  int size = 0;
  for (int j = 0; j < columns; ++j) size += padded(j + 1);
  return size;
}
/// Products of column pairs are stored for at most this many columns.
inline constexpr int max_pair_columns = 8;

struct RowKernel;

/// Rows of a stage that have the same columns and kind, packed over whole vectors.
struct RowBlock {
  int rows = 0, columns = 0;
  int lower_at = -1, upper_at = -1;  ///< first side; -1: no lower (upper) sides
  int equality_at = -1;              ///< first entry of y; equalities have no sides
  bool soft = false;
  bool partial = false;            ///< some rows lack a side that other rows have
  const RowBlock* twin = nullptr;  ///< equal block of the previous stage
  int part = 0;                    ///< index of the inputs' part; 0: the stage's main variables
  int joined = -1;                 ///< part to whose Hessian it contributes; -1: that of the stage
  int v_at = 0;                    ///< offset of the part's variables in v
  const int* column = nullptr;     ///< per column, its offset from v_at
  bool contiguous = false;         ///< the columns are consecutive
  bool diagonal = false;  ///< row i has an entry in column i alone: C is one column of them
  /// Offset in that Hessian of every pair of columns (of every column, if diagonal).
  const int* target = nullptr;
  const double* C = nullptr;   ///< coefficients, stored by columns over rows
  const double* Ct = nullptr;  ///< coefficients, stored by rows over columns
  /// Products of two columns, by rows over a padded upper triangle; only for few columns.
  const double* pairs = nullptr;
  const RowKernel* kernel = nullptr;
  // Origin of the rows: the group of the stage (-1: bounds), and the row indices in it.
  int group = -1;
  const int* source = nullptr;
  const double* scale = nullptr;  ///< equalities: scale factor of every row
};

/// Kernels for COLUMNS columns; -1: any number.
template <int COLUMNS>
struct RowFunctions {
  /// Computes out = sign C x. x: the variables of the block's part.
  static void multiply(const RowBlock& b, const double* x, double sign, double* out) {
    if (b.contiguous)
      multiply_entries(
          b, [x = x + b.column[0]](int c) { return x[c]; }, sign, out);
    else
      multiply_entries(
          b, [x, &b](int c) { return x[b.column[c]]; }, sign, out);
  }

  /// x += sign C' weights.
  static void add_transposed(const RowBlock& b, const double* weights, double sign, double* x) {
    const Extent<COLUMNS> columns(b.columns);
    const int rows = b.rows, ld = padded(columns);
    const auto chunk = [&]<int V>(int i) {
      const double* Ct = b.Ct + i;
      // Two independent sums avoid the latency of dependent additions.
      Lanes even[V] = {}, odd[V] = {};
      int r = 0;
      for (; r + 2 <= rows; r += 2) {
        const Lanes first = broadcast(weights[r]), second = broadcast(weights[r + 1]);
        for (int v = 0; v < V; ++v) {
          even[v] += load(Ct + r * ld + v * lanes) * first;
          odd[v] += load(Ct + (r + 1) * ld + v * lanes) * second;
        }
      }
      if (r < rows)
        for (int v = 0; v < V; ++v) even[v] += load(Ct + r * ld + v * lanes) * weights[r];
      for (int v = 0; v < V; ++v) {
        const Lanes total = (even[v] + odd[v]) * sign;
        const int begin = i + v * lanes;
        if (b.contiguous) {
          // Lanes beyond the columns add zero to the entries that follow.
          double* to = x + b.column[0] + begin;
          store_loose(to, load_loose(to) + total);
        } else {
          for (int c = begin; c < columns && c < begin + lanes; ++c)
            x[b.column[c]] += total[c - begin];
        }
      }
    };
    int i = 0;
    for (; i + 2 * lanes <= ld; i += 2 * lanes) chunk.template operator()<2>(i);
    if (i < ld) chunk.template operator()<1>(i);
  }

  /// Computes H += C' diag(weights) C from the products of columns. `work`:
  /// padded_pairs_of(columns).
  static void add_square(const RowBlock& b, const double* weights, double* H, double* work) {
    const Extent<COLUMNS> columns(b.columns);
    const int ld = padded_pairs_of(columns);
    const auto chunk = [&]<int V>(int i, Lanes(&sum)[V]) __attribute__((always_inline)) {
      const double* pairs = b.pairs + i;
      for (Lanes& entry : sum) entry = Lanes{};
#pragma GCC unroll 3
      for (int r = 0; r < b.rows; ++r, pairs += ld) {
        const Lanes w = broadcast(weights[r]);
        for (int v = 0; v < V; ++v) sum[v] += load(pairs + v * lanes) * w;
      }
    };
    constexpr int registers = 12, vectors = padded_pairs_of(std::max(COLUMNS, 1)) / lanes;
    if constexpr (COLUMNS > 0 && vectors <= registers) {
      Lanes sum[vectors];
      chunk(0, sum);
      if (b.contiguous) {
        // Lanes below the diagonal add zero to entries that are not read.
        for_each(
            columns, [&](auto j) __attribute__((always_inline)) {
              for (int v = 0; v <= j; v += lanes) {
                double* to = H + b.target[pairs_of(j)] + v;
                store_loose(to, load_loose(to) + sum[(padded_pairs_of(j) + v) / lanes]);
              }
            });
        return;
      }
      for (int v = 0; v < vectors; ++v) store(work + v * lanes, sum[v]);
    } else {
      Lanes sum[1];
      for (int i = 0; i < ld; i += lanes) {
        chunk(i, sum);
        store(work + i, sum[0]);
      }
    }
    for (int j = 0, at = 0, pair = 0; j < columns; at += padded(++j))
      for (int i = 0; i <= j; ++i) H[b.target[pair++]] += work[at + i];
  }

 private:
  // entry(c): value of the variable of column c.
  template <class Entry>
  static SALTUS_INLINE void multiply_entries(const RowBlock& b, Entry entry, double sign,
                                             double* out) {
    const Extent<COLUMNS> columns(b.columns);
    const int ld = padded(b.rows);
    const auto chunk = [&]<int V>(int i) {
      const double* C = b.C + i;
      Lanes sum[V] = {};
      for (int c = 0; c < columns; ++c) {
        const Lanes x = broadcast(entry(c));
        for (int v = 0; v < V; ++v) sum[v] += load(C + c * ld + v * lanes) * x;
      }
      for (int v = 0; v < V; ++v) store(out + i + v * lanes, sum[v] * sign);
    };
    // Most blocks have one of these heights.
    if (ld == 4 * lanes) return chunk.template operator()<4>(0);
    if (ld == 2 * lanes) return chunk.template operator()<2>(0);
    int i = 0;
    for (; i + 2 * lanes <= ld; i += 2 * lanes) chunk.template operator()<2>(i);
    if (i < ld) chunk.template operator()<1>(i);
  }
};

/// Kernels for diagonal blocks, such as limits of single variables.
struct DiagonalRowFunctions {
  static void multiply(const RowBlock& b, const double* x, double sign, double* out) {
    if (b.contiguous) {
      // C is zero beyond the rows.
      for (int i = 0; i < padded(b.rows); i += lanes)
        store(out + i, load(b.C + i) * load_loose(x + b.column[0] + i) * sign);
      return;
    }
    for (int i = 0; i < b.rows; ++i) out[i] = sign * b.C[i] * x[b.column[i]];
    for (int i = b.rows; i < padded(b.rows); ++i) out[i] = 0.0;
  }

  static void add_transposed(const RowBlock& b, const double* weights, double sign, double* x) {
    if (b.contiguous) {
      for (int i = 0; i < padded(b.rows); i += lanes) {
        double* to = x + b.column[0] + i;
        store_loose(to, load_loose(to) + load(b.C + i) * load(weights + i) * sign);
      }
      return;
    }
    for (int i = 0; i < b.rows; ++i) x[b.column[i]] += sign * b.C[i] * weights[i];
  }

  static void add_square(const RowBlock& b, const double* weights, double* H, double*) {
    for (int i = 0; i < b.rows; ++i) H[b.target[i]] += b.C[i] * b.C[i] * weights[i];
  }
};

struct RowKernel {
  int columns;  ///< -1: any
  void (*multiply)(const RowBlock&, const double*, double, double*);
  void (*add_transposed)(const RowBlock&, const double*, double, double*);
  void (*add_square)(const RowBlock&, const double*, double*, double*);
};

template <int COLUMNS>
constexpr RowKernel row_kernel() {
  using F = RowFunctions<COLUMNS>;
  return {COLUMNS, &F::multiply, &F::add_transposed, &F::add_square};
}

inline constexpr RowKernel diagonal_row_kernel = {-1, &DiagonalRowFunctions::multiply,
                                                  &DiagonalRowFunctions::add_transposed,
                                                  &DiagonalRowFunctions::add_square};

/// Two groups of inputs that act through their sum. With S = R_1 + R_2 = L D L', their joint
/// Hessian is R_1 S^-1 R_2. An explicit inverse of S would be faster but loses half the digits,
/// because active rows make S stiff. All matrices are m x m with leading dimension padded(m).
struct Split {
  double* before = nullptr;      ///< R_1
  double* second = nullptr;      ///< R_2
  double* L = nullptr;           ///< factor without its diagonal
  double* Lt = nullptr;          ///< its transpose
  double* pivot = nullptr;       ///< inverse pivots
  double* difference = nullptr;  ///< gradient of the second group minus that of the first
  static constexpr int size(int m) { return 3 * padded(m) * m + 2 * padded(m); }
};

template <int M>
struct SplitFunctions {
  /// Copies the Hessians of the groups, stored consecutively in `R`, and adds constants to the
  /// diagonals.
  static void begin(int size, int parts, const double* R, double on_first, double on_further,
                    double* out) {
    const Extent<M> m(size);
    const int ld = padded(m);
    for (int part = 0; part < parts; ++part, R += ld * m, out += ld * m) {
      const double diagonal = part == 0 ? on_first : on_further;
      for (int i = 0; i < ld * m; i += lanes) store(out + i, load(R + i));
      for (int i = 0; i < m; ++i) out[i * (ld + 1)] += diagonal;
    }
  }

  /// Writes or adds the joint Hessian to the upper triangle of `out`. s.before and s.second hold
  /// upper triangles on entry and full matrices on return.
  static void join(int size, Split& s, double* work, double least_pivot, double* out, int ldo,
                   bool add) {
    const Extent<M> m(size);
    const int ld = padded(m), stride = padded(2 * m);
    double* S = work;           // R_1 + R_2
    double* rows = S + ld * m;  // row by row [R_1 | R_2], forward-substituted
    double* scaled = rows + stride * m + lanes;
    double* joint = scaled + stride * m + lanes;
    for (int j = 0; j < m; ++j) {
      for (int i = 0; i < j; ++i) {
        s.before[j + i * ld] = s.before[i + j * ld];
        s.second[j + i * ld] = s.second[i + j * ld];
      }
      for (int i = m; i < ld; ++i) s.before[i + j * ld] = s.second[i + j * ld] = 0.0;
    }
    for (int i = 0; i < m; ++i) {
      // The next row overwrites the excess of the last vector.
      double* row = rows + i * stride;
      for (int v = 0; v < ld; v += lanes) store(row + v, load(s.before + i * ld + v));
      for (int v = 0; v < ld; v += lanes) {
        const Lanes second = load(s.second + i * ld + v);
        store_loose(row + m + v, second);
        store(S + i * ld + v, load(s.before + i * ld + v) + second);
        store(s.L + i * ld + v, Lanes{});
        store(s.Lt + i * ld + v, Lanes{});
      }
    }
    for_each(
        m, [&](int j) __attribute__((always_inline)) {
          const double* pivot_column = S + j * ld;
          const double* row = rows + j * stride;
          const double diagonal = s.before[j + j * ld] + s.second[j + j * ld];
          double pivot = pivot_column[j];
          if (!(pivot > least_pivot + lost_digits * diagonal))
            pivot = diagonal > least_pivot ? diagonal : least_pivot;
          s.pivot[j] = 1.0 / pivot;
          for (int v = 0; v < stride; v += lanes)
            store(scaled + j * stride + v, load(row + v) * s.pivot[j]);
          for (int i = j + 1; i < m; ++i) {
            const double factor = pivot_column[i] * s.pivot[j];
            s.L[i + j * ld] = s.Lt[j + i * ld] = factor;
            double* to = rows + i * stride;
            for (int v = 0; v < stride; v += lanes)
              store(to + v, load(to + v) - load(row + v) * factor);
            double* column = S + i * ld;
            for (int v = i / lanes * lanes; v < ld; v += lanes)
              store(column + v, load(column + v) - load(pivot_column + v) * factor);
          }
        });
    multiply(m, m, m, rows, stride, scaled + m, stride, 1, joint, ld);
    for (int j = 0; j < m; ++j)
      for (int i = 0; i <= j; ++i) {
        const double mean = 0.5 * (joint[i + j * ld] + joint[j + i * ld]);
        out[i + j * ldo] = add ? out[i + j * ldo] + mean : mean;
      }
  }

  // Computes x = S^-1 x. Padding beyond m must be zero.
  static SALTUS_INLINE void solve(const Extent<M>& m, const Split& s, double* x) {
    const int ld = padded(m);
    if constexpr (M >= 0) {
      // The fixed size fits in registers.
      Lanes part[padded(M) / lanes];
      for (int v = 0; v < ld; v += lanes) part[v / lanes] = load(x + v);
      const auto subtract = [&](const double* column, int j, int first, int last)
          __attribute__((always_inline)) {
        const Lanes entry = broadcast(part[j / lanes][j % lanes]);
        for (int v = first; v < last; v += lanes) part[v / lanes] -= load(column + v) * entry;
      };
      for_each(
          m, [&](int j) __attribute__((always_inline)) {
            subtract(s.L + j * ld, j, j / lanes * lanes, ld);
          });
      for (int v = 0; v < ld; v += lanes) part[v / lanes] *= load(s.pivot + v);
      for_each(
          m, [&](int done) __attribute__((always_inline)) {
            const int j = m - 1 - done;
            subtract(s.Lt + j * ld, j, 0, padded(j));
          });
      for (int v = 0; v < ld; v += lanes) store(x + v, part[v / lanes]);
      return;
    }
    for (int j = 0; j + 1 < m; ++j)
      for (int v = 0; v < ld; v += lanes) store(x + v, load(x + v) - load(s.L + j * ld + v) * x[j]);
    for (int j = 0; j < m; ++j) x[j] *= s.pivot[j];
    for (int j = m - 1; j > 0; --j)
      for (int v = 0; v < ld; v += lanes)
        store(x + v, load(x + v) - load(s.Lt + j * ld + v) * x[j]);
  }

  /// Computes the gradient of the sum from those of the groups. `own` holds that of the first group
  /// and receives the result.
  static void gather(int size, Split& s, const double* further, double* own, double* work) {
    const Extent<M> m(size);
    const int ld = padded(m);
    for (int i = m; i < ld; ++i) work[i] = s.difference[i] = 0.0;
    for (int i = 0; i < m; ++i) work[i] = s.difference[i] = further[i] - own[i];
    solve(m, s, work);
    double* product = work + ld;
    multiply_vector<Update::set>(m, m, s.before, ld, work, product);
    for (int i = 0; i < m; ++i) own[i] += product[i];
  }

  /// Divides the sum `own` into the contributions of the groups. `own` receives that of the first
  /// group.
  static void divide(int size, const Split& s, double* own, double* further, double* work) {
    const Extent<M> m(size);
    const int ld = padded(m);
    for (int i = 0; i < ld; i += lanes) store(work + i, load(s.difference + i));
    multiply_vector<Update::add>(m, m, s.second, ld, own, work);
    solve(m, s, work);
    for (int i = 0; i < m; ++i) further[i] = own[i] - work[i];
    for (int i = m; i < ld; ++i) further[i] = 0.0;
    for (int i = 0; i < m; ++i) own[i] = work[i];
  }
};

struct SplitKernel {
  int size;  ///< -1: any
  void (*begin)(int, int, const double*, double, double, double*);
  void (*join)(int, Split&, double*, double, double*, int, bool);
  void (*gather)(int, Split&, const double*, double*, double*);
  void (*divide)(int, const Split&, double*, double*, double*);
};

template <int M>
constexpr SplitKernel split_kernel() {
  using F = SplitFunctions<M>;
  return {M, &F::begin, &F::join, &F::gather, &F::divide};
}

}  // namespace saltus::qp
