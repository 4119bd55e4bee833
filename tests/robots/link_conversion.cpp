// Conversions of a plugin: they let the controller of the cart move a cart of twice the mass to 1 m
// instead of 0 m.
#include "saltus/c/saltus_robot.h"

void saltus_state_of_sensors(const saltus_sensors* readings, int joints, double* state,
                             int states) {
  if (joints != 1 || states != 2) return;
  state[0] = readings->q[0] - 1.0;
  state[1] = readings->dq[0];
}

void saltus_torques_of_input(const saltus_sensors*, const double* input, int inputs,
                             double* torques, int joints) {
  if (inputs == 1 && joints == 1) torques[0] = 2.0 * input[0];
}
