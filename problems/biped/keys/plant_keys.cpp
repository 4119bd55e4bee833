#include "problems/biped/keys/keys.hpp"

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {

void declare_plant(Settings& s, PlantSettings& plant) {
  s.choice<PlantSettings::Choice>(
      "plant", plant.choice,
      {{"centroidal", PlantSettings::Choice::centroidal},
       {"dart", PlantSettings::Choice::dart},
       {"mujoco", PlantSettings::Choice::mujoco}},
      "simulated plant: the centroidal model, or the whole body in DART or MuJoCo");
}

void declare_step(Settings& s, PlantSettings& plant) {
  s.number("simulator.step_s", plant.engine.step, "s",
           "whole body: time step of the physics engine", between(1e-5, 0.1));
}

void declare_settings(Settings& s, Plant::Ground& ground) {
  s.number("simulator.ground_edge_m", ground.edge, "m",
           "whole body: distance from the stance sole at which another ground begins, which the "
           "controllers take for level; the other keys ground_* describe it",
           between(0.05, 1.0));
  s.flag("simulator.ground_ahead", ground.ahead,
         "whole body: the other ground begins ahead of the robot, at x = ground_edge_m; "
         "ground_step_m is then the height at the edge, and ground_slope_side the rise per metre "
         "to the left");
  s.number("simulator.ground_step_m", ground.height, "m",
           "whole body: height of the ground beyond ground_edge_m", between(-0.1, 0.1));
  s.number("simulator.ground_slope_forward", ground.slope_forward, "",
           "whole body: rise per metre forward; ground_step_m is the height at x = 0, 0.06 m "
           "beyond the edge",
           between(-0.2, 0.2));
  s.number("simulator.ground_slope_side", ground.slope_side, "",
           "whole body: rise per metre away from the stance foot", between(-0.2, 0.2));
  s.number("simulator.ground_end_forward_m", ground.end_forward, "m",
           "whole body: x at which the ground ends; beyond, it is 5 cm lower",
           between(-1.0, 100.0));
  s.number("simulator.ground_end_side_m", ground.end_side, "m",
           "whole body: width of the ground; beyond, it is 5 cm lower", between(0.01, 100.0));
  s.rule(
      {"simulator.ground_ahead", "simulator.ground_end_forward_m", "simulator.ground_end_side_m"},
      [&ground] {
        return ground.ahead && (ground.end_forward || ground.end_side)
                   ? "ground ahead of the robot has no end; leave simulator.ground_end_forward_m "
                     "and simulator.ground_end_side_m out, or simulator.ground_ahead"
                   : "";
      });
  s.number("simulator.ground_roughness_m", ground.roughness, "m",
           "whole body: bound of the random heights of square tiles with edges of 0.1 m, within "
           "2 m",
           between(0.0, 0.03));
  s.integer("simulator.ground_seed", ground.seed, "",
            "whole body: seed of the heights of the tiles", at_least(0.0));
  s.number("simulator.ground_friction", ground.friction, "",
           "whole body: friction coefficient; 0: as simulator.friction", between(0.0, 100.0));
  s.number(
      "simulator.ground_sink_m", ground.sink, "m",
      "whole body: soft ground, in which a sole that carries the robot's whole weight sinks by "
      "this depth; 0: rigid ground",
      between(0.0, 0.03));
}

void declare_settings(Settings& s, PlantSettings& plant) {
  s.number("simulator.friction", plant.engine.friction, "",
           "whole body: friction coefficient of the ground", above(0.0));
  declare_settings(s, plant.engine.ground);
  s.number("simulator.joint_friction_nms_per_rad", plant.engine.joint_friction, "Nm s/rad",
           "whole body: viscous friction of the joints", at_least(0.0));
  s.integer("simulator.delay_ticks", plant.delay_ticks, "",
            "whole body: delay of the torques, in control periods", between(0.0, 100.0));
  s.number("motor.bandwidth_hz", plant.motors.bandwidth, "Hz",
           "whole body: bandwidth of the torques (first-order lag); 0: no lag", at_least(0.0));
  s.number("motor.torque_rate", plant.motors.torque_rate, "Nm/s",
           "whole body: maximum rate of the torques; 0: no limit", at_least(0.0));
  s.number("drive.rotor_inertia", plant.drives.rotor_inertia, "",
           "whole body: rotor inertia of the drives, as a multiple of that in the robot's file",
           between(0.0, 10.0));
  s.number("drive.friction", plant.drives.friction, "",
           "whole body: dry and viscous friction of the drives, as a multiple of that in the "
           "robot's file",
           between(0.0, 10.0));
  s.rule({"drive.rotor_inertia", "drive.friction"}, [&plant] {
    return plant.drives.friction > 0.0 && plant.drives.rotor_inertia == 0.0
               ? "drive.friction needs rotors that it can hold; set drive.rotor_inertia above 0"
               : "";
  });
  s.flag("drive.torque_speed_line", plant.drives.torque_speed_line,
         "whole body: stall torque and no-load speed limit the torque of a motor");
  s.number("drive.elasticity", plant.drives.elasticity, "",
           "whole body: elasticity between the rotors and the joints, as a multiple of the "
           "compliance (1 / stiffness) in the robot's file; 0: rigid drives. The controllers take "
           "the drives for rigid",
           between(0.0, 100.0));
  s.number("drive.backlash", plant.drives.backlash, "",
           "whole body: play between the rotors and the joints, as a multiple of the backlash in "
           "the robot's file; needs drive.elasticity",
           between(0.0, 100.0));
  s.rule({"drive.elasticity", "drive.rotor_inertia", "drive.backlash"}, [&plant] {
    if (plant.drives.elasticity > 0.0 && plant.drives.rotor_inertia == 0.0)
      return "drive.elasticity needs rotors that turn the springs; set drive.rotor_inertia above 0";
    return plant.drives.backlash > 0.0 && plant.drives.elasticity == 0.0
               ? "drive.backlash needs springs at its ends; set drive.elasticity above 0"
               : "";
  });
  s.choice<PlantSettings::Sensors>(
      "sensors", plant.sensors,
      {{"ideal", PlantSettings::Sensors::ideal}, {"measured", PlantSettings::Sensors::measured}},
      "whole body: controllers receive the true state, or an estimate from iCub's sensors: "
      "encoders, gyroscope, accelerometer and force sensors in the feet");
  declare_settings(s, plant.sensor, plant.estimation);
  s.choice<DartOptions::Collision>("dart.collision", plant.engine.collision,
                                   {{"dart", DartOptions::Collision::dart},
                                    {"fcl", DartOptions::Collision::fcl},
                                    {"bullet", DartOptions::Collision::bullet},
                                    {"ode", DartOptions::Collision::ode}},
                                   "collision detector of DART");
  s.choice<DartOptions::Lcp>(
      "dart.lcp", plant.engine.lcp,
      {{"dantzig", DartOptions::Lcp::dantzig}, {"pgs", DartOptions::Lcp::pgs}},
      "contact solver of DART");
  s.choice<DartOptions::Friction>(
      "dart.friction", plant.engine.cone,
      {{"box", DartOptions::Friction::box}, {"inscribed", DartOptions::Friction::inscribed}},
      "square friction pyramid of DART: circumscribed about the round cone of "
      "simulator.friction (box), or inscribed in it");
}

}  // namespace saltus::robots::walking
