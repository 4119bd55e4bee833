// Replaces the plant if MuJoCo is not installed.
#include "saltus/robots/mujoco/mujoco_plant.hpp"

namespace saltus::robots {
namespace {

[[noreturn]] void refuse() {
  throw InputError(
      "this program was built without MuJoCo; install libmujoco-dev and configure again, or use "
      "another plant");
}

}  // namespace

bool has_mujoco() { return false; }

std::unique_ptr<Plant> make_mujoco_plant(const FloatingRobot&, const Plant::Options&) { refuse(); }

MatrixXd mujoco_mass_matrix(const FloatingRobot&, const WholeBodyState&) { refuse(); }

}  // namespace saltus::robots
