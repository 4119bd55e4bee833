/* A robot for `saltus control` in C: separate joints that hang from a stand, each an inertia with
 * friction. It needs saltus_robot.h and no library. Replace `move` and `measure` with the drivers
 * of a robot.
 *
 * Usage: joint_robot PORT [--KEY VALUE]... NAME[=INERTIA[,FRICTION[,TORQUE[,START]]]]...
 *
 *   PORT           port of `saltus control --link udp:PORT` on this machine
 *   --time         duration in balance, s; then the robot requests a stop (default 3)
 *   --pace         wall-clock seconds per second of the robot; 0: lock-step, waits for each answer
 *                  (default 0)
 *   --period       period of the readings, s (default 0.001)
 *   --delay        delay of the readings in periods (default 0)
 *   --guard        time without commands until the guard acts, s (default 0.015)
 *   --fault        nan, clock, stuck, silence, sign, velocity or offset
 *   --fault-at     start of the fault in balance, s (default 1)
 *   --fault-joint  index of the faulty joint (default 0)
 *
 * Units: kg m^2, Nm s/rad, Nm, rad; for a linear joint kg, N s/m, N, m.
 *
 * Prints the result. Exit status: 0 if the controller has stopped the robot, 1 if the controller
 * has gone, 2 for wrong arguments, 3 without a controller. */
#define _GNU_SOURCE /* ppoll */
#include <arpa/inet.h>
#include <poll.h>
#include <saltus/c/saltus_robot.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { most_joints = 64, most_delay = 100 };

static struct {
  double time, pace, period, delay, guard, fault_at, fault_joint;
  const char* fault;
} option = {3.0, 0.0, 0.001, 0.0, 0.015, 1.0, 0.0, ""};

static struct {
  double inertia, friction, limit, q, dq;
} joint[most_joints];
static const char* names[most_joints];
static int joints = 0;

static double wall_clock(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int has_fault(const char* kind, double t) {
  return strcmp(option.fault, kind) == 0 && (option.fault_at < 0.0 || t >= option.fault_at);
}

/* Moves the joints for one period. */
static void move(const double* torques, double t) {
  for (int i = 0; i < joints; ++i) {
    const int is_faulty = i == (int)option.fault_joint;
    const double torque = is_faulty && has_fault("sign", t) ? -torques[i] : torques[i];
    /* Implicit Euler for the friction, which is stable for any coefficient. */
    joint[i].dq = (joint[i].dq + option.period * torque / joint[i].inertia) /
                  (1.0 + option.period * joint[i].friction / joint[i].inertia);
    if (is_faulty && has_fault("stuck", t)) joint[i].dq = 0.0;
    joint[i].q += option.period * joint[i].dq;
  }
}

static void measure(saltus_sensors* readings, double t) {
  for (int i = 0; i < joints; ++i) {
    readings->q[i] = joint[i].q;
    readings->dq[i] = joint[i].dq;
  }
  const int i = (int)option.fault_joint;
  if (has_fault("nan", t)) readings->q[i] = NAN;
  if (has_fault("offset", t)) readings->q[i] += 0.02;
  if (has_fault("velocity", t)) readings->dq[i] = -readings->dq[i];
  readings->specific_force[2] = 9.81;
  readings->orientation[0] = 1.0;
}

static int wrong(const char* what) {
  fprintf(stderr, "joint_robot: wrong argument %s; see the first lines of joint_robot.c\n", what);
  return 0;
}

static int parse(int count, char** words) {
  const struct {
    const char* name;
    double* value;
  } numbers[] = {{"--time", &option.time},
                 {"--pace", &option.pace},
                 {"--period", &option.period},
                 {"--delay", &option.delay},
                 {"--guard", &option.guard},
                 {"--fault-at", &option.fault_at},
                 {"--fault-joint", &option.fault_joint}};
  for (int i = 2; i < count; ++i) {
    if (strcmp(words[i], "--fault") == 0 && i + 1 < count) {
      option.fault = words[++i];
    } else if (words[i][0] == '-') {
      size_t k = 0;
      while (k < sizeof numbers / sizeof *numbers && strcmp(numbers[k].name, words[i]) != 0) ++k;
      if (k == sizeof numbers / sizeof *numbers || i + 1 == count) return wrong(words[i]);
      *numbers[k].value = atof(words[++i]);
    } else {
      double value[4] = {1.0, 0.0, 10.0, 0.0};
      char* equal = strchr(words[i], '=');
      if (joints == most_joints) return wrong(words[i]);
      if (equal != NULL) {
        *equal = '\0';
        sscanf(equal + 1, "%lf,%lf,%lf,%lf", &value[0], &value[1], &value[2], &value[3]);
      }
      names[joints] = words[i];
      joint[joints].inertia = value[0];
      joint[joints].friction = value[1];
      joint[joints].limit = value[2];
      joint[joints++].q = value[3];
    }
  }
  if (joints == 0) return wrong("(no joint)");
  if (!(option.fault_joint >= 0.0 && option.fault_joint < joints)) return wrong("--fault-joint");
  if (!(option.period > 0.0) || !(option.delay >= 0.0 && option.delay < most_delay))
    return wrong("--period or --delay");
  return 1;
}

int main(int count, char** words) {
  const int port = count > 2 ? atoi(words[1]) : 0;
  if (port <= 0 || port > 65535) return wrong("PORT") + 2;
  if (!parse(count, words)) return 2;
  const int link_socket = socket(AF_INET, SOCK_DGRAM, 0);
  struct sockaddr_in there = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (link_socket < 0 || connect(link_socket, (struct sockaddr*)&there, sizeof there) != 0) {
    perror("joint_robot");
    return 2;
  }

  const saltus_link link = saltus_link_of(names, joints);
  double limits[most_joints], q[most_joints], dq[most_joints], torques[most_joints];
  for (int i = 0; i < joints; ++i) limits[i] = joint[i].limit;
  static saltus_guard guard;
  saltus_guard_init(&guard, joints, limits);
  guard.silence = option.guard;

  static saltus_sensors waiting[most_delay]; /* delayed readings */
  static unsigned char bytes[SALTUS_LINK_BYTES];
  const double begin = wall_clock();
  double heard = begin, balance_at = INFINITY, stop_at = INFINITY;
  saltus_guard_action action = SALTUS_GUARD_RELEASES;
  int status = 0;
  for (uint64_t k = 0;; ++k) {
    const double now = (double)k * option.period; /* the robot's clock */
    const double t = now - balance_at;            /* time in balance; negative before it */
    if (t > option.time && stop_at == INFINITY) stop_at = now;
    saltus_sensors* readings = &waiting[k % most_delay];
    memset(readings, 0, sizeof *readings);
    readings->sequence = k;
    readings->time = llround(1e9 * (has_fault("clock", t) ? balance_at + option.fault_at : now));
    readings->pace = option.pace;
    readings->requests_stop = now >= stop_at;
    readings->is_guarded = action != SALTUS_GUARD_PASSES;
    measure(readings, t);
    const uint64_t delay = (uint64_t)option.delay;
    int expects = k >= delay && !has_fault("silence", t);
    if (expects)
      send(link_socket, bytes,
           saltus_write_sensors(&link, &waiting[(k - delay) % most_delay], bytes), 0);

    /* In lock-step wait for the answer, otherwise until the end of the period. */
    const double end = option.pace > 0.0 ? begin + option.pace * (double)(k + 1) * option.period
                                         : wall_clock() + (isfinite(balance_at) ? 2.0 : 0.1);
    while (option.pace > 0.0 || expects) {
      const double left = end - wall_clock();
      struct pollfd wanted = {.fd = link_socket, .events = POLLIN};
      if (left <= 0.0) break;
      const struct timespec patience = {(time_t)left, (long)(1e9 * (left - floor(left)))};
      if (ppoll(&wanted, 1, &patience, NULL) <= 0) continue;
      const ssize_t size = recv(link_socket, bytes, sizeof bytes, MSG_DONTWAIT);
      if (size <= 0) {
        if (option.pace == 0.0 && !isfinite(guard.commanded_at)) usleep(1000); /* nobody listens */
        continue;
      }
      if (!saltus_guard_take(&guard, &link, bytes, (size_t)size, now)) continue;
      heard = wall_clock();
      expects = expects && guard.command.answers + delay < k;
    }
    if (guard.command.state >= SALTUS_BALANCE && balance_at == INFINITY) balance_at = now;
    for (int i = 0; i < joints; ++i) {
      q[i] = joint[i].q;
      dq[i] = joint[i].dq;
    }
    action = saltus_guard_torques(&guard, now, q, dq, torques);
    move(torques, t);
    if (guard.command.state == SALTUS_RELEASE) break;
    if (now > stop_at + 5.0 || wall_clock() - heard > (isfinite(guard.commanded_at) ? 3.0 : 30.0)) {
      status = isfinite(guard.commanded_at) ? 1 : 3;
      break;
    }
  }
  printf("robot: guard: %ld periods; refused: %ld; joints:", guard.guarded, guard.refused);
  for (int i = 0; i < joints; ++i) printf(" %.4f", joint[i].q);
  printf("; %s\n", status == 0 ? "released" : "the controller is gone");
  return status;
}
