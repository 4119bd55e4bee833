// The component legged: positions of iCub's feet in a scene of the walking layer, and the detection
// of an early landing.
#include <cstdio>
#include <saltus/robots/icub/icub.hpp>
#include <saltus/robots/walking/contacts.hpp>
#include <saltus/robots/walking/scene.hpp>

using namespace saltus;

int main() {
  const robots::RobotDescription robot = icub();
  const robots::walking::Scene scene =
      walking::scene_of(walking::posture_on_both_feet(robot), robot);
  const double apart = (scene.stance.position - scene.swing.position).norm();
  Schedule contacts = walking::one_foot_then_two(0.6);
  contacts.confirm(walking::impact, 0.55);
  std::printf("%.3f m apart, both feet stand from %.2f s on\n", apart,
              walking::landing_time(contacts));
  return apart > 0.05 && apart < 0.3 && contacts.mode_at(0.56) == walking::double_support ? 0 : 1;
}
