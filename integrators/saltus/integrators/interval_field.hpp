// The equations that every scheme integrates: dynamics and running costs of one interval as one
// field over scaled time, with derivatives in the requested directions.
//
// With s = (t - t0) / h in [0, 1] and y = (x | q), the interval reads
//   dy/ds = F(s, x; theta) = h phi(z),  phi = (f | L),  z = (t0 + s h | x | u(s; c) | p),
// where theta = (c | p | t0 | h) is constant. In scaled time, start and length are ordinary
// parameters: they enter through t, through u(s) and as the factor h. Intervals of zero or negative
// length need no special treatment. z is linear in (x, theta), so that
//   dF     = h phi_z dz + phi dh,
//   w' d2F = h dz' (w' phi)_zz dz + 2 (w' phi_z dz) dh.
#pragma once

#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Sensitivities are row-major, so that a sparse Jacobian adds contiguous rows. A row has one
/// column per direction, plus zero columns for padding (padded_directions()).
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The combined field of an IntervalProblem. Owns its workspace and does not allocate after
/// construction. A "direction" is a differentiated entry of w = (x0 | c | p | t0 | h). Directions
/// keep the order of w, so the first nx are the initial state.
class IntervalField {
 public:
  /// Throws DefinitionError if the sizes of the functions do not match the arguments.
  explicit IntervalField(const IntervalProblem& problem);

  int states() const { return nx_; }
  int outputs() const { return nx_ + nq_; }
  int arguments() const { return sizes_.size(); }
  int directions() const { return static_cast<int>(column_.size()); }
  /// Columns of sensitivities, padded to whole vector registers.
  int padded_directions() const;
  /// Column of w of a direction.
  int column(int direction) const { return column_[direction]; }
  bool differentiates_time() const { return h_direction_ >= 0; }
  int h_direction() const { return h_direction_; }
  int entries() const { return dynamics_entries_ + cost_entries_; }

  /// Loads c, p, t0 and h of the interval. Call it before the functions below.
  void load(const double* w);
  double length() const { return h_; }

  /// Computes z at scaled time s and state x.
  void argument(double s, const double* x, double* z) const;

  /// Computes phi(z), outputs() entries, not multiplied by h.
  void value(const double* z, double* phi) const;
  /// Computes phi(z) and the Jacobian entries of f, then of L, in the order of their patterns.
  void jacobian(const double* z, double* phi, double* entries) const;
  /// Computes phi_z' weights, arguments() entries.
  void adjoint(const double* entries, const double* weights, double* gradient) const;
  /// Computes h phi_x, dense, column-major with leading dimension outputs(). Columns of q are zero.
  void scaled_state_jacobian(const double* entries, double* dense) const;

  /// Computes dF along the directions at scaled time s into `rates`. `sensitivity` has states rows
  /// or more and one column per direction. `rates` has outputs rows and the same number of columns.
  void rate_sensitivity(double s, const double* phi, const double* entries,
                        const RowMajorMatrix& sensitivity, double* rates) const;
  /// Same for one direction: `rate` (outputs) from the state part (states) of its column.
  void rate_sensitivity(double s, const double* phi, const double* entries, int direction,
                        const double* sensitivity, double* rate) const;

  /// Adds h Z' (weights' phi)_zz Z to the lower triangle of `sum` (directions x directions), where
  /// Z = dz along the directions. Gauss-Newton omits the dynamics.
  void add_curvature(double s, const double* z, const double* weights,
                     const RowMajorMatrix& sensitivity, Curvature curvature,
                     RowMajorMatrix& sum) const;
  /// Computes dz' gradient along all directions, which dh multiplies in the second derivative.
  void pull_back(double s, const double* gradient, const RowMajorMatrix& sensitivity,
                 double* along) const;

  /// Computes dz (arguments x directions) at an instant that moves by `moves` (directions), so that
  /// all entries of z vary. The states are those of `sensitivity`.
  void differentiate_argument(double s, const RowMajorMatrix& sensitivity, const double* moves,
                              RowMajorMatrix& dz) const;
  /// Computes dF (outputs x directions) along dz.
  void rate_differential(const double* phi, const double* entries, const RowMajorMatrix& dz,
                         RowMajorMatrix& rates) const;
  /// Adds h dz' (weights' phi)_zz dz to `sum`, like add_curvature().
  void add_moving_curvature(const double* z, const double* weights, const RowMajorMatrix& dz,
                            Curvature curvature, RowMajorMatrix& sum) const;
  /// Computes the differential of gradient' dz/ds through h and the two ends of an input.
  void slope_differential(const double* gradient, double* along) const;
  /// Calls visit(row of phi, state, entry of jacobian()) for all state columns.
  template <class Visit>
  void for_each_state_entry(Visit visit) const {
    for (const Entry& e : state_entries_) visit(e.row, e.col - 1, e.entry);
  }

  /// Computes dF/ds at fixed state, h (phi_t h + phi_u du/ds), outputs() entries.
  void explicit_rate(const double* entries, double* rate) const;
  /// Computes the differential m_z dz (outputs of m x directions) of another function m of z from
  /// its Jacobian entries, along the state directions `sensitivity`.
  void differential(const SparsityPattern& pattern, const double* entries, double s,
                    const RowMajorMatrix& sensitivity, RowMajorMatrix& result) const;
  /// Computes the slope m_z dz/ds of that function at fixed state: m_t h + m_u du/ds.
  void explicit_slope(const SparsityPattern& pattern, const double* entries, double* slope) const;

  /// Writes a sensitivity (outputs x directions) into the columns of d end / d w. Other columns are
  /// zero.
  void scatter(const RowMajorMatrix& sensitivity, MatrixXd& derivative) const;
  /// Writes a lower triangle over directions into the symmetric matrix over w. Other entries are
  /// zero.
  void scatter_symmetric(const RowMajorMatrix& lower, MatrixXd& hessian) const;

 private:
  // dz_row / d direction = constant + slope * s. A row of theta has at most two such directions.
  struct Coefficient {
    int direction;
    double constant;
    double slope;
    double at(double s) const { return constant + slope * s; }
  };
  struct Entry {
    int row;  // row of phi
    int col;  // index in z
    int entry;
  };
  // An entry in a row of a matrix multiplied by dz, with the row of dz that it multiplies.
  struct Factor {
    int entry;
    bool is_state;
    int row;  // row of the sensitivity or of direct_rows_
  };
  // Contribution of a direction to the rates through t, u or p.
  struct DirectEntry {
    int row;
    int entry;
    Coefficient coefficient;
  };
  struct CurvatureRow {
    int col;  // index in z
    std::vector<Factor> factors;
  };

  bool is_state(int col) const { return col >= 1 && col <= nx_; }
  void place_directions();
  Factor factor(int entry, int col) const { return {entry, is_state(col), direct_row_[col]}; }
  void move_directions(double s) const;
  const double* row_of(const Factor& f, const RowMajorMatrix& sensitivity) const {
    const RowMajorMatrix& of = f.is_state ? sensitivity : direct_rows_;
    return of.data() + f.row * of.cols();
  }

  Function dynamics_;
  Function running_cost_;
  InputShape shape_;
  Arguments sizes_;
  IntervalArguments interval_;
  int nx_, nu_, nq_;
  int h_direction_ = -1;
  int dynamics_entries_ = 0, cost_entries_ = 0;
  std::vector<int> column_;
  std::vector<std::vector<Coefficient>> coefficients_;  // per row of z; empty for states and data
  std::vector<Entry> jacobian_entries_;
  std::vector<std::vector<Factor>> rate_factors_;         // per row of phi
  std::vector<std::vector<Factor>> gradient_factors_;     // per column of z; `row` is a row of phi
  std::vector<Entry> state_entries_;                      // entries in state columns
  std::vector<std::vector<DirectEntry>> direct_entries_;  // other entries, per direction
  std::vector<CurvatureRow> curvature_rows_;              // non-zero rows of (weights' phi)_zz
  int dynamics_curvature_ = 0;  // number of entries; those of the running cost follow
  // dz / d direction of the entries of z that are not states: one row per varying entry, and the
  // parts that vary with s.
  std::vector<int> direct_row_;  // per entry of z: its row in direct_rows_, or its state
  struct MovingEntry {
    int row;
    Coefficient coefficient;
  };
  std::vector<MovingEntry> moving_;
  mutable RowMajorMatrix direct_rows_;

  double t0_ = 0.0, h_ = 0.0;
  std::vector<double> c_, p_;
  mutable std::vector<double> hessian_scratch_;
  mutable RowMajorMatrix product_;  // (weights' phi)_zz Z
};

/// True if all numbers are finite.
bool all_finite(const double* values, int count);

}  // namespace saltus
