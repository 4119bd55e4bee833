// What the closed loop drives, whatever simulates it: a biped that is measured, told wrenches and
// where to put its foot, and moved on.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/plant_settings.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

/// Where the swing foot came down: as it is measured, and as it is (m).
struct Landing {
  Vec<double, 3> measured, actual;  ///< where the foot came down: as measured and as it is, m
};

/// What the swing foot is told. Times in s, the place of its contact frame in m.
struct SwingTarget {
  double landing = infinity;                      ///< when it is due
  double earliest = infinity;                     ///< a touch before is none
  Vec<double, 3> place = Vec<double, 3>::Zero();  ///< of the sole, m
};

/// At each instant the loop calls: sense, lift_off, swing and find_landing, command (these four in
/// any number), step. States are (CoM position m, velocity m/s, angular momentum about it Nms),
/// world axes; wrenches of left and right foot in the axes of their soles as if these were level
/// (x forwards, z up), N and Nm.
class LeggedPlant {
 public:
  virtual ~LeggedPlant() = default;

  // --- its clock, s

  /// When tick `k` of the planner begins.
  virtual double tick_time(long k) const = 0;
  /// Where a step from t on ends: at `limit`, or before.
  virtual double step_end(double t, double limit) const = 0;
  /// Until when a sample holds that is taken before a step to `end`: longer where several steps are
  /// made between two measurements.
  virtual double sample_end(double end) const { return end; }

  // --- what the controllers see

  /// Takes measurements at t; false if they are not due yet and nothing changes.
  virtual bool sense(double t) = 0;
  /// gamma as the controller is told it: CoM m, velocity m/s, angular momentum Nms.
  virtual Vec<double, 9> measured() const = 0;
  virtual double nominal_mass() const = 0;  ///< of the controllers' model, kg
  /// The contact frame of a foot, and how fast it moves: m, m/s.
  virtual SoleFrame sole(Side foot) const = 0;
  /// Of the sole's origin as measured, m/s.
  virtual Vec<double, 3> sole_velocity(Side foot) const = 0;
  /// Wrenches commanded last; on the whole body those that its controller expects: N, Nm.
  virtual const Vec<double, 12>& applied() const = 0;
  /// Sum over both feet of what applied() has, world axes, N: on the whole body what its controller
  /// expects of the ground, not what is measured there.
  virtual Vec<double, 3> contact_force() const = 0;
  /// Does a contact that is due begin exactly then? Otherwise it begins when it is felt.
  virtual bool lands_on_time() const = 0;

  // --- what it is told

  /// This foot stands no more, the other one does: it is the swing foot from now on. At the start
  /// that is the one in the air.
  virtual void lift_off(double t, Side foot) = 0;
  /// Of the swing foot.
  virtual void swing(double t, const SwingTarget& target) = 0;
  /// Has the swing foot landed at t? It stands from then on.
  virtual std::optional<Landing> find_landing(double t) = 0;
  /// From t on. Wrenches of a foot that does not stand are disregarded.
  virtual void command(double t, const Vec<double, 12>& wrenches) = 0;
  /// Moves on from `from` to `to` under the pushes; an empty sentence, or why it could not.
  virtual std::string step(double from, double to) = 0;

  // --- what is really so

  virtual double truth_time() const = 0;  ///< of the state, s
  /// gamma as it is.
  virtual Vec<double, 9> truth() const = 0;
  virtual Vec<double, 3> true_sole(Side foot) const = 0;  ///< origin of its contact frame, m
  /// After a step, if a sample was due before it; never of a plant without a body.
  virtual std::optional<BodySample> body_sample() const { return std::nullopt; }
  /// What is known from the start on, and what was counted.
  virtual void describe(RunLog& log) const = 0;
};

/// How the robot stands when the run begins, and what disturbs it. `period` is the planner's, s.
struct PlantStart {
  const RobotDescription& robot;   ///< what is simulated
  const StandingPosture& posture;  ///< how it stands
  Scene scene;                     ///< feet and ground
  std::vector<Push> pushes;        ///< all of them
  double mass_error = 0.0;         ///< relative, of the controllers' model
  double period = 0.01;            ///< of the controller, s
};

/// The exact centroidal dynamics. The swing foot stands from the start if the scene says so.
std::unique_ptr<LeggedPlant> make_centroidal_legged_plant(const PlantStart& start);

/// Whose URDF, how it is controlled, and what its controllers assume of the contacts.
struct WholeBodyOptions {
  std::filesystem::path urdf;  ///< file of the robot
  WholeBodyControl control;    ///< of the whole body
  ContactSettings contact;     ///< of the ground
};

/// Of `push.link`, the setting. Throws InputError that names it.
FloatingRobot::Frame pushed_frame(const FloatingRobot& robot, const UrdfModel& model,
                                  const std::string& link);

/// The whole body in DART or MuJoCo with its controller. Throws InputError for what the files lack
/// or say wrongly.
std::unique_ptr<LeggedPlant> make_whole_body_legged_plant(const PlantStart& start,
                                                          const WholeBodyOptions& options,
                                                          const PlantSettings& settings);

}  // namespace saltus::walking
