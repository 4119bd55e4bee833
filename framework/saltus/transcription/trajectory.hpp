// The trajectory of a solution: states and inputs at any time with the accuracy of the integrator,
// and CSV output.
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "saltus/model/reentrant_integrator.hpp"

namespace saltus {

/// One shooting interval of a solution.
struct TrajectoryPiece {
  int phase = 0;          ///< index of the phase
  double start = 0.0;     ///< absolute time, s
  double length = 0.0;    ///< s, positive
  VectorXd state;         ///< at the start of the interval
  VectorXd coefficients;  ///< input coefficients, see InputShape
  VectorXd end_state;     ///< state of the node at its end, before any jump

  /// End time, s.
  double end() const { return start + length; }
};

/// Pieces in order of time. Right-continuous: at an event, values are those of the new phase, x+
/// after the jump.
///
/// Value semantics: several threads may read a trajectory or its copies concurrently, also while
/// the program or controller that made it continues. Reading allocates and is not for control
/// loops. Members throw DefinitionError if the trajectory is empty or a given time is NaN. The plan
/// of a failed solve may contain NaN times; values read from it are NaN.
class Trajectory {
 public:
  /// Data of a phase.
  struct PhaseInfo {
    std::string name;     ///< also the name of the mode
    VectorXd parameters;  ///< p of the phase: data and unknowns
    /// Problem and scheme of the solve.
    std::shared_ptr<const ReentrantIntegrator> integrator;
  };

  Trajectory();
  Trajectory(const Trajectory& other);
  Trajectory(Trajectory&& other) noexcept;
  Trajectory& operator=(const Trajectory& other);
  Trajectory& operator=(Trajectory&& other) noexcept;
  ~Trajectory();
  /// Pieces in order of time. Throws DefinitionError if a phase has no integrator, a piece refers
  /// to no phase, or a size differs from that of its phase.
  Trajectory(std::vector<PhaseInfo> phases, std::vector<TrajectoryPiece> pieces);

  /// True if it has no pieces.
  bool empty() const { return pieces_.empty(); }
  /// The phases in order.
  const std::vector<PhaseInfo>& phases() const { return phases_; }
  /// One piece per interval in order of time.
  const std::vector<TrajectoryPiece>& pieces() const { return pieces_; }
  /// Start of the first piece, s.
  double start_time() const;
  /// End of the last piece, s.
  double end_time() const;
  /// State at the end of the last phase.
  const VectorXd& final_state() const;

  /// The piece at time t. Times outside the trajectory are clipped.
  const TrajectoryPiece& piece_at(double t) const;
  /// State at time t, integrated from the node before t (dense output).
  VectorXd state(double t) const;
  /// Left limit: x- of the old phase at an event, elsewhere state(t).
  VectorXd state_before(double t) const;
  /// Input at time t, right-continuous at control breaks.
  VectorXd input(double t) const;
  /// State at time t within one of pieces(), without the lookup by time and its rounding at the
  /// ends.
  VectorXd state_in(const TrajectoryPiece& piece, double t) const;
  /// Input at time t within a piece. At its end this is the left limit.
  VectorXd input_in(const TrajectoryPiece& piece, double t) const;
  /// Algebraic states at time t. Empty if the phase has none, NaN if they cannot be found.
  VectorXd algebraic(double t) const;

  /// The trajectory without its first `phases` phases. Throws DefinitionError if none remains.
  Trajectory after(int phases) const;

  /// Writes a header and one line per sample: t, phase, x0..., u0..., z0... Columns that a phase
  /// does not have are empty. Events appear twice, with the values before and after.
  void write_csv(std::ostream& out, int samples_per_interval = 1) const;

 private:
  const PhaseInfo& phase_of(const TrajectoryPiece& piece) const;
  VectorXd algebraic_in(const TrajectoryPiece& piece, double t) const;

  std::vector<PhaseInfo> phases_;
  std::vector<TrajectoryPiece> pieces_;
};

}  // namespace saltus
