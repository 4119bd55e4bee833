// What every scheme integrates: dynamics and running costs of one interval as one field over
// scaled time, with its derivatives in the directions that are wanted.
//
// With s = (t - t0) / h in [0, 1] and y = (x | q) the interval reads
//   dy/ds = F(s, x; theta) = h phi(z),  phi = (f | L),  z = (t0 + s h | x | u(s; c) | p),
// where theta = (c | p | t0 | h) is constant. In scaled time start and length are parameters like
// any other: they act through t, through u(s) and as the factor h, and an interval of length zero
// or a negative one needs no special case. z is linear in (x, theta), so that
//   dF     = h phi_z dz + phi dh,
//   w' d2F = h dz' (w' phi)_zz dz + 2 (w' phi_z dz) dh.
#pragma once

#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Sensitivities are stored by rows: a sparse Jacobian then adds contiguous rows. A row has one
/// column per direction, or more (padded_directions()), which then are zero.
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The combined field of an IntervalProblem. Owns scratch memory; after construction nothing
/// allocates. A "direction" is a differentiated entry of w = (x0 | c | p | t0 | h); directions keep
/// the order of w, and the first nx of them are the start state.
class IntervalField {
 public:
  /// Throws DefinitionError when the functions do not have the sizes that the arguments announce.
  explicit IntervalField(const IntervalProblem& problem);

  int states() const { return nx_; }
  int outputs() const { return nx_ + nq_; }
  int arguments() const { return sizes_.size(); }
  int directions() const { return static_cast<int>(column_.size()); }
  /// Columns of sensitivities whose rows fill whole vectors of the processor.
  int padded_directions() const;
  /// Column of w that a direction differentiates.
  int column(int direction) const { return column_[direction]; }
  bool differentiates_time() const { return h_direction_ >= 0; }
  int h_direction() const { return h_direction_; }
  int entries() const { return dynamics_entries_ + cost_entries_; }

  /// Takes over c, p, t0 and h of the interval; must precede everything below.
  void load(const double* w);
  double length() const { return h_; }

  /// z at scaled time s and state x.
  void argument(double s, const double* x, double* z) const;

  /// phi(z), outputs() entries, not multiplied by h.
  void value(const double* z, double* phi) const;
  /// phi(z) and the Jacobian entries of f and then of L, in the order of their patterns.
  void jacobian(const double* z, double* phi, double* entries) const;
  /// phi_z' weights, arguments() entries.
  void adjoint(const double* entries, const double* weights, double* gradient) const;
  /// h phi_x, dense, column-major with leading dimension outputs(); columns of q are zero.
  void scaled_state_jacobian(const double* entries, double* dense) const;

  /// rates (outputs rows with as many columns as `sensitivity`) = dF along the state directions
  /// `sensitivity` (states x directions or more rows) at scaled time s.
  void rate_sensitivity(double s, const double* phi, const double* entries,
                        const RowMajorMatrix& sensitivity, double* rates) const;
  /// The same for one direction: rate (outputs) from the state part (states) of its column.
  void rate_sensitivity(double s, const double* phi, const double* entries, int direction,
                        const double* sensitivity, double* rate) const;

  /// Adds h Z' (weights' phi)_zz Z to the lower triangle of `sum` (directions x directions), with
  /// Z = dz along the directions. Gauss-Newton leaves the dynamics out.
  void add_curvature(double s, const double* z, const double* weights,
                     const RowMajorMatrix& sensitivity, Curvature curvature,
                     RowMajorMatrix& sum) const;
  /// dz' gradient along all directions (what dh multiplies in the second derivative).
  void pull_back(double s, const double* gradient, const RowMajorMatrix& sensitivity,
                 double* along) const;

  /// The same where the instant moves by `moves` (directions) with the directions, so that all of z
  /// does: dz (arguments x directions), of which the states are those of `sensitivity`.
  void differentiate_argument(double s, const RowMajorMatrix& sensitivity, const double* moves,
                              RowMajorMatrix& dz) const;
  /// dF (outputs x directions) along dz.
  void rate_differential(const double* phi, const double* entries, const RowMajorMatrix& dz,
                         RowMajorMatrix& rates) const;
  /// Adds h dz' (weights' phi)_zz dz to `sum`, as add_curvature() does.
  void add_moving_curvature(const double* z, const double* weights, const RowMajorMatrix& dz,
                            Curvature curvature, RowMajorMatrix& sum) const;
  /// gradient' dz/ds, differentiated: through h and the two ends of an input.
  void slope_differential(const double* gradient, double* along) const;
  /// visit(row of phi, state, entry of jacobian()) for all state columns.
  template <class Visit>
  void for_each_state_entry(Visit visit) const {
    for (const Entry& e : state_entries_) visit(e.row, e.col - 1, e.entry);
  }

  /// dF/ds at fixed state: h (phi_t h + phi_u du/ds), outputs() entries.
  void explicit_rate(const double* entries, double* rate) const;
  /// The differential m_z dz (outputs of m x directions) of another function of z, given the
  /// entries of its Jacobian, along the state directions `sensitivity`.
  void differential(const SparsityPattern& pattern, const double* entries, double s,
                    const RowMajorMatrix& sensitivity, RowMajorMatrix& result) const;
  /// The slope m_z dz/ds of that function at fixed state: m_t h + m_u du/ds.
  void explicit_slope(const SparsityPattern& pattern, const double* entries, double* slope) const;

  /// Writes a sensitivity (outputs x directions) into the columns of d end / d w, others zero.
  void scatter(const RowMajorMatrix& sensitivity, MatrixXd& derivative) const;
  /// Writes a lower triangle over directions into the symmetric matrix over w, others zero.
  void scatter_symmetric(const RowMajorMatrix& lower, MatrixXd& hessian) const;

 private:
  // dz_row / d direction = constant + slope * s; a theta row has at most two such directions.
  struct Coefficient {
    int direction;
    double constant;
    double slope;
    double at(double s) const { return constant + slope * s; }
  };
  struct Entry {
    int row;  // of phi
    int col;  // of z
    int entry;
  };
  // An entry of a row of a matrix times z: where the row of derivatives of z's entry stands.
  struct Factor {
    int entry;
    bool is_state;
    int row;  // of the sensitivity, or of direct_rows_
  };
  // What one direction adds to the rates through t, u or p.
  struct DirectEntry {
    int row;
    int entry;
    Coefficient coefficient;
  };
  struct CurvatureRow {
    int col;  // of z
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
  std::vector<std::vector<Factor>> rate_factors_;         // of the rows of phi
  std::vector<std::vector<Factor>> gradient_factors_;     // of the columns: `row` is one of phi
  std::vector<Entry> state_entries_;                      // those of state columns
  std::vector<std::vector<DirectEntry>> direct_entries_;  // the others, per direction
  std::vector<CurvatureRow> curvature_rows_;              // of (weights' phi)_zz that are not zero
  int dynamics_curvature_ = 0;  // entries; those of the running cost follow
  // dz / d direction of what is no state: a row per entry of z that moves, and what of it moves
  // with s.
  std::vector<int> direct_row_;  // per entry of z: there, or its state
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

/// Whether all numbers of a range are finite.
bool all_finite(const double* values, int count);

}  // namespace saltus
