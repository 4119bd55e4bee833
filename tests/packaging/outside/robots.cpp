// The component robots: the data of iCub from the file that the library contains.
#include <cstdio>
#include <saltus/robots/icub/icub.hpp>

int main() {
  const saltus::robots::RobotDescription robot = saltus::icub();
  std::printf("%.2f kg\n", robot.mass);
  return robot.mass > 20.0 && robot.mass < 50.0 ? 0 : 1;
}
