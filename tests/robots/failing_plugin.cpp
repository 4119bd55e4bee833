// A plugin whose controller of two joints fails in the third tick and in all later calls.
#include "saltus/c/saltus_c.h"

struct saltus_controller {
  int ticks = 0, failures = 0;
};

namespace {

saltus_controller only;

saltus_status fails_later() {
  if (only.ticks < 3) return SALTUS_OK;
  ++only.failures;
  return SALTUS_FAILURE;
}

}  // namespace

int saltus_interface_version(void) { return SALTUS_INTERFACE_VERSION; }
int saltus_controllers(void) { return 1; }
const char* saltus_controller_name(int) { return "failing"; }
saltus_status saltus_create(const char*, saltus_controller** controller) {
  *controller = &only;
  return SALTUS_OK;
}
void saltus_destroy(saltus_controller*) {}
const char* saltus_error(const saltus_controller* controller) {
  return controller->failures == 1 ? "no memory for the tick" : "another failure";
}
saltus_status saltus_read_sizes(saltus_controller*, saltus_sizes* sizes) {
  *sizes = {};
  sizes->states = 4;
  sizes->inputs = sizes->plan_inputs = 2;
  sizes->period = 0.001;
  return SALTUS_OK;
}
saltus_status saltus_prepare(saltus_controller*, double) { return fails_later(); }
saltus_status saltus_feedback(saltus_controller* controller, const double*, int,
                              saltus_tick* tick) {
  ++controller->ticks;
  *tick = {};
  tick->pieces = 1;
  return fails_later();
}
saltus_status saltus_read_piece(saltus_controller*, int, double* start, double* length,
                                double* input, int, int* count) {
  *start = 0.0;
  *length = 1.0;
  input[0] = input[1] = 1.0;
  *count = 2;
  return fails_later();
}
