// The trajectory of a solution: states and inputs at any time, exact as the integrator, and as CSV.
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "saltus/model/reentrant_integrator.hpp"

namespace saltus {

/// One shooting interval of a solution.
struct TrajectoryPiece {
  int phase = 0;          ///< which one
  double start = 0.0;     ///< absolute time, s
  double length = 0.0;    ///< s, positive
  VectorXd state;         ///< at the start of the interval
  VectorXd coefficients;  ///< of the input, see InputShape
  VectorXd end_state;     ///< of the node at its end, before any jump

  /// In s.
  double end() const { return start + length; }
};

/// Pieces in order of time. Right-continuous: at an event the new phase counts, x+ after the jump.
///
/// A value: several threads may read one trajectory, or copies of it, at once, also while the
/// program or the controller that made it goes on. Reading allocates and is not for control loops.
/// Members throw DefinitionError where the trajectory is empty and where a time is NaN. The plan of
/// a failed solve may have times that are NaN itself: then what is read of it is NaN.
class Trajectory {
 public:
  /// What is known of a phase.
  struct PhaseInfo {
    std::string name;     ///< of the mode
    VectorXd parameters;  ///< data and unknowns, p of the phase
    /// Problem and scheme with which the phase was solved.
    std::shared_ptr<const ReentrantIntegrator> integrator;
  };

  Trajectory();
  Trajectory(const Trajectory& other);
  Trajectory(Trajectory&& other) noexcept;
  Trajectory& operator=(const Trajectory& other);
  Trajectory& operator=(Trajectory&& other) noexcept;
  ~Trajectory();
  /// Pieces in the order of time. Throws DefinitionError where a phase has no integrator, a piece
  /// names no phase or a size differs from that of its phase.
  Trajectory(std::vector<PhaseInfo> phases, std::vector<TrajectoryPiece> pieces);

  /// Whether there is none.
  bool empty() const { return pieces_.empty(); }
  /// In their order.
  const std::vector<PhaseInfo>& phases() const { return phases_; }
  /// One per interval, in the order of time.
  const std::vector<TrajectoryPiece>& pieces() const { return pieces_; }
  /// Start of the first piece, in s.
  double start_time() const;
  /// End of the last piece, in s.
  double end_time() const;
  /// State at the end of the last phase.
  const VectorXd& final_state() const;

  /// The piece in force at time t; times outside are clipped to the ends.
  const TrajectoryPiece& piece_at(double t) const;
  /// Dense output: integrated from the node before t.
  VectorXd state(double t) const;
  /// The left limit: at an event x- of the old phase, elsewhere state(t).
  VectorXd state_before(double t) const;
  /// At a time, s; behind a control break.
  VectorXd input(double t) const;
  /// The same within one of pieces(), whichever piece is in force at t: there is no rounding of
  /// times at its ends.
  VectorXd state_in(const TrajectoryPiece& piece, double t) const;
  /// At its end the left limit.
  VectorXd input_in(const TrajectoryPiece& piece, double t) const;
  /// Algebraic states, of which a phase may have none; NaN where they cannot be found.
  VectorXd algebraic(double t) const;

  /// Without the first phases: what is left once they are over. Throws DefinitionError unless it
  /// leaves one.
  Trajectory after(int phases) const;

  /// A header and one line per sample: t, phase, x0..., u0..., z0...; columns that a phase does not
  /// have are empty. Every event appears twice, with the values before and after it.
  void write_csv(std::ostream& out, int samples_per_interval = 1) const;

 private:
  const PhaseInfo& phase_of(const TrajectoryPiece& piece) const;
  VectorXd algebraic_in(const TrajectoryPiece& piece, double t) const;

  std::vector<PhaseInfo> phases_;
  std::vector<TrajectoryPiece> pieces_;
};

}  // namespace saltus
