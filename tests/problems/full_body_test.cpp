// The whole body in DART: needs the URDF, whose file SALTUS_ICUB_URDF names.
#include "problems/push_recovery/full_body.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "robots/icub/icub.hpp"

namespace saltus::push_recovery {
namespace {

TEST(FullBody, StepCatchesAPush) {
  const char* urdf = std::getenv("SALTUS_ICUB_URDF");
  if (urdf == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name the URDF of iCubGazeboV2_5";
  const RobotDescription robot = icub(urdf);
  Config config;
  config.plant = PlantChoice::dart;
  config.push.impulse = std::getenv("PUSH") ? atof(std::getenv("PUSH")) : 6.0;
  config.push.start = 0.4;
  if (std::getenv("HW")) config.weights.gamma.tail<3>().setConstant(atof(std::getenv("HW")));
  if (std::getenv("NOSTEP")) config.stepping = false;
  if (std::getenv("DUR")) config.step.duration = atof(std::getenv("DUR"));
  const RunLog log = simulate_full_body(config, robot, urdf);
  const Verdict v = judge(config, log);
  printf("%s %s | touchdown %.3f place %.3f %.3f z %.3f..%.3f H %.2f com err %.4f settle %.3f\n", v.recovered ? "recovered" : "NOT", v.reason.c_str(), log.touchdown, log.final_scene.right.position[0], log.final_scene.right.position[1], v.com_height_min, v.com_height_max, v.angular_momentum_max, v.final_com_error, v.icp_settling);
  printf("control fail %ld of %ld; plan %.2f control %.2f plant %.2f\n", log.control_failures, log.control_calls, log.plan_seconds, log.control_seconds, log.plant_seconds);
  for (std::size_t i = 0; i < log.samples.size(); i += 25) {
    const Sample& s = log.samples[i]; const BodySample& b = log.body[i];
    printf("%.3f com %.3f %.3f %.3f icp %.3f %.3f H %.2f plan fz %.0f %.0f meas %.0f %.0f foot %.3f %.3f %.3f tmax %.1f\n", s.time, s.gamma[0], s.gamma[1], s.gamma[2], s.capture_point[0], s.capture_point[1], s.gamma.tail<3>().norm(), b.planned[2], b.planned[8], b.left[2], b.right[2], b.right_sole.translation()[0], b.right_sole.translation()[1], b.right_sole.translation()[2], b.torques.cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace saltus::push_recovery
