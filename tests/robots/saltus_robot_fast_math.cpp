// The guard of the C header, compiled with -ffast-math.
#include "saltus/c/saltus_robot.h"

int take_with_fast_math(saltus_guard* guard, const saltus_link* link, const unsigned char* bytes,
                        size_t size, double now);
saltus_guard_action act_with_fast_math(saltus_guard* guard, double now, const double* q,
                                       const double* dq, double* torques);

int take_with_fast_math(saltus_guard* guard, const saltus_link* link, const unsigned char* bytes,
                        size_t size, double now) {
  return saltus_guard_take(guard, link, bytes, size, now);
}
saltus_guard_action act_with_fast_math(saltus_guard* guard, double now, const double* q,
                                       const double* dq, double* torques) {
  return saltus_guard_torques(guard, now, q, dq, torques);
}
