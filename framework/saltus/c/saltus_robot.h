/* The robot's side of the link to `saltus control`, in plain C: it writes and reads the messages of
 * docs/robot_link.md, and guards the motors. Nothing here allocates, waits or uses the network, and
 * no library is needed.
 *
 *   saltus_guard_init(&guard, joints, largest_torques);
 *   every period:
 *     size = saltus_write_sensors(&link, &readings, bytes);           send it
 *     saltus_guard_take(&guard, &link, received, received_size, now); for every message received
 *     saltus_guard_torques(&guard, now, q, dq, torques);              to the motors
 *
 * Vectors have one entry per joint, in the order of the names given to saltus_link_of(). */
#ifndef SALTUS_ROBOT_H
#define SALTUS_ROBOT_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of the messages. */
#define SALTUS_LINK_VERSION 1
/** Largest size of a message in bytes. */
#define SALTUS_LINK_BYTES 8192
/** Largest number of joints. */
#define SALTUS_LINK_JOINTS 203

/** What both sides must agree on. */
typedef struct saltus_link {
  uint32_t robot; /**< identity of the robot: CRC-32 of the names of its joints */
  int joints;     /**< number of joints */
} saltus_link;

/** Readings of one period, sent to the controller. docs/robot_link.md defines units and axes. */
typedef struct saltus_sensors {
  uint64_t sequence;            /**< increases by one in every period */
  int64_t time;                 /**< time of the readings on the robot's clock, ns */
  double pace;                  /**< wall-clock seconds per second of this clock; 0: lock-step */
  int requests_stop;            /**< not 0: requests a soft stop */
  int is_guarded;               /**< not 0: the guard acts instead of the commands */
  double angular_velocity[3];   /**< of the base, mean over the last period, rad/s */
  double specific_force[3];     /**< acceleration minus gravity, mean over the last period, m/s^2 */
  double orientation[4];        /**< of the base (w, x, y, z); zeros: unknown */
  double left[6];               /**< force (N) and torque (Nm) of the ground on the left foot */
  double right[6];              /**< the same for the right foot */
  double q[SALTUS_LINK_JOINTS]; /**< joint positions, rad */
  double dq[SALTUS_LINK_JOINTS]; /**< joint velocities, rad/s */
} saltus_sensors;

/** State of the controller. */
typedef enum saltus_link_state {
  SALTUS_START = 0,   /**< waits for the first readings; no torque */
  SALTUS_STAND = 1,   /**< moves the joints into the posture of the start */
  SALTUS_BALANCE = 2, /**< the controller runs */
  SALTUS_HOLD = 3,    /**< soft stop: the last torques, and springs */
  SALTUS_DAMP = 4,    /**< soft stop: torques and springs fade */
  SALTUS_RELEASE = 5, /**< no torque */
  SALTUS_CHECK = 6    /**< moves one joint after the other; the robot hangs */
} saltus_link_state;

/** Command of the controller to all joints. A motor exerts torque + stiffness (position - q) +
 * damping (velocity - dq). */
typedef struct saltus_command {
  uint64_t sequence;                     /**< increases by one in every message */
  uint64_t answers;                      /**< sequence number of the readings that it answers */
  int64_t time;                          /**< time stamp of these readings, ns */
  uint32_t state;                        /**< a saltus_link_state */
  double torques[SALTUS_LINK_JOINTS];    /**< torques, Nm */
  double positions[SALTUS_LINK_JOINTS];  /**< target positions, rad */
  double velocities[SALTUS_LINK_JOINTS]; /**< target velocities, rad/s */
  double stiffness[SALTUS_LINK_JOINTS];  /**< stiffness of the springs, Nm/rad */
  double damping[SALTUS_LINK_JOINTS];    /**< damping, Nm s/rad */
} saltus_command;

/* ---- plugins of `saltus control --plugin` ----
 *
 * By default the state of a plugin's controller is (positions, velocities) of all joints, and its
 * inputs are the joint torques. A plugin may define one or both of these functions (in C++ as
 * extern "C") to convert another state or input. They must not allocate. `requests_stop` and
 * `is_guarded` are not set. */
#ifdef __GNUC__
#define SALTUS_OF_PLUGIN __attribute__((visibility("default")))
#else
#define SALTUS_OF_PLUGIN
#endif

/** Writes the state of the controller for these readings. */
SALTUS_OF_PLUGIN void saltus_state_of_sensors(const saltus_sensors* readings, int joints,
                                              double* state, int states);
/** Writes the torques of all joints for an input. `readings` are those of the last tick. */
SALTUS_OF_PLUGIN void saltus_torques_of_input(const saltus_sensors* readings, const double* input,
                                              int inputs, double* torques, int joints);

/* ---- bytes ---- */

/** CRC-32 of IEEE 802.3, continued from `crc`, which is 0 for the first bytes. */
static inline uint32_t saltus_crc32(uint32_t crc, const unsigned char* bytes, size_t size) {
  crc = ~crc;
  for (size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xedb88320U ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

/** Link of a robot with these joints. */
static inline saltus_link saltus_link_of(const char* const* names, int joints) {
  saltus_link link = {0, joints};
  for (int i = 0; i < joints; ++i) {
    link.robot = saltus_crc32(link.robot, (const unsigned char*)names[i], strlen(names[i]));
    link.robot = saltus_crc32(link.robot, (const unsigned char*)"\n", 1);
  }
  return link;
}

/* Whether messages and guards have room for these joints. */
static inline int saltus_has_room(int joints) { return joints > 0 && joints <= SALTUS_LINK_JOINTS; }

/** Size of the readings of a robot with n joints, in bytes. */
static inline size_t saltus_sensors_size(int n) { return 232 + 16 * (size_t)n; }
/** Size of a command for n joints, in bytes. */
static inline size_t saltus_command_size(int n) { return 56 + 40 * (size_t)n; }

/* Numbers in messages are little-endian on every machine. */
static inline unsigned char* saltus_put(unsigned char* at, uint64_t value, int size) {
  for (int i = 0; i < size; ++i) *at++ = (unsigned char)(value >> (8 * i));
  return at;
}
static inline uint64_t saltus_get(const unsigned char* at, int size) {
  uint64_t value = 0;
  for (int i = 0; i < size; ++i) value |= (uint64_t)at[i] << (8 * i);
  return value;
}
static inline unsigned char* saltus_put_numbers(unsigned char* at, const double* values, int n) {
  for (int i = 0; i < n; ++i) {
    uint64_t bits = 0;
    memcpy(&bits, &values[i], sizeof bits);
    at = saltus_put(at, bits, 8);
  }
  return at;
}
static inline const unsigned char* saltus_get_numbers(const unsigned char* at, double* values,
                                                      int n) {
  for (int i = 0; i < n; ++i, at += 8) {
    const uint64_t bits = saltus_get(at, 8);
    memcpy(&values[i], &bits, sizeof bits);
  }
  return at;
}
/* CRC-32 of a message with zeros in place of its checksum. */
static inline uint32_t saltus_checksum(const unsigned char* bytes, size_t size) {
  static const unsigned char zeros[4] = {0, 0, 0, 0};
  const uint32_t crc = saltus_crc32(saltus_crc32(0, bytes, 12), zeros, 4);
  return saltus_crc32(crc, bytes + 16, size - 16);
}
static inline unsigned char* saltus_put_header(unsigned char* at, const saltus_link* link, int kind,
                                               size_t size, int flags, uint64_t sequence,
                                               int64_t time) {
  at = saltus_put(at, 0x4c544c53, 4);
  at = saltus_put(at, SALTUS_LINK_VERSION, 2);
  at = saltus_put(at, (uint64_t)kind, 2);
  at = saltus_put(at, size, 4);
  at = saltus_put(at, 0, 4);
  at = saltus_put(at, link->robot, 4);
  at = saltus_put(at, (uint64_t)link->joints, 2);
  at = saltus_put(at, (uint64_t)flags, 2);
  at = saltus_put(at, sequence, 8);
  return saltus_put(at, (uint64_t)time, 8);
}
static inline int saltus_has_header(const unsigned char* bytes, size_t size,
                                    const saltus_link* link, int kind, size_t expected) {
  return saltus_has_room(link->joints) && size == expected && saltus_get(bytes, 4) == 0x4c544c53 &&
         saltus_get(bytes + 4, 2) == SALTUS_LINK_VERSION &&
         saltus_get(bytes + 6, 2) == (uint64_t)kind && saltus_get(bytes + 8, 4) == size &&
         saltus_get(bytes + 16, 4) == link->robot &&
         saltus_get(bytes + 20, 2) == (uint64_t)link->joints &&
         saltus_get(bytes + 12, 4) == saltus_checksum(bytes, size);
}

/** Writes readings as a message of SALTUS_LINK_BYTES at most. Returns its size, or 0 if the link
 * has no joint or too many. */
static inline size_t saltus_write_sensors(const saltus_link* link, const saltus_sensors* readings,
                                          unsigned char* bytes) {
  static const double reserved = 0.0;
  if (!saltus_has_room(link->joints)) return 0;
  const size_t size = saltus_sensors_size(link->joints);
  unsigned char* at = saltus_put_header(
      bytes, link, 1, size, (readings->requests_stop != 0) | 2 * (readings->is_guarded != 0),
      readings->sequence, readings->time);
  at = saltus_put_numbers(at, &readings->pace, 1);
  at = saltus_put_numbers(at, &reserved, 1);
  at = saltus_put_numbers(at, readings->angular_velocity, 3);
  at = saltus_put_numbers(at, readings->specific_force, 3);
  at = saltus_put_numbers(at, readings->orientation, 4);
  at = saltus_put_numbers(at, readings->left, 6);
  at = saltus_put_numbers(at, readings->right, 6);
  at = saltus_put_numbers(at, readings->q, link->joints);
  saltus_put_numbers(at, readings->dq, link->joints);
  saltus_put(bytes + 12, saltus_checksum(bytes, size), 4);
  return size;
}

/** Reads readings. If the message is not valid, returns 0 and does not change `readings`. */
static inline int saltus_read_sensors(const saltus_link* link, const unsigned char* bytes,
                                      size_t size, saltus_sensors* readings) {
  if (!saltus_has_header(bytes, size, link, 1, saltus_sensors_size(link->joints))) return 0;
  readings->requests_stop = (int)(saltus_get(bytes + 22, 2) & 1);
  readings->is_guarded = (int)(saltus_get(bytes + 22, 2) >> 1 & 1);
  readings->sequence = saltus_get(bytes + 24, 8);
  readings->time = (int64_t)saltus_get(bytes + 32, 8);
  saltus_get_numbers(bytes + 40, &readings->pace, 1);
  const unsigned char* at = saltus_get_numbers(bytes + 56, readings->angular_velocity, 3);
  at = saltus_get_numbers(at, readings->specific_force, 3);
  at = saltus_get_numbers(at, readings->orientation, 4);
  at = saltus_get_numbers(at, readings->left, 6);
  at = saltus_get_numbers(at, readings->right, 6);
  at = saltus_get_numbers(at, readings->q, link->joints);
  saltus_get_numbers(at, readings->dq, link->joints);
  return 1;
}

/** Writes a command as a message of SALTUS_LINK_BYTES at most. Returns its size, or 0 if the link
 * has no joint or too many. */
static inline size_t saltus_write_command(const saltus_link* link, const saltus_command* command,
                                          unsigned char* bytes) {
  const int n = link->joints;
  if (!saltus_has_room(n)) return 0;
  const size_t size = saltus_command_size(n);
  unsigned char* at = saltus_put_header(bytes, link, 2, size, 0, command->sequence, command->time);
  at = saltus_put(at, command->answers, 8);
  at = saltus_put(at, command->state, 8);
  at = saltus_put_numbers(at, command->torques, n);
  at = saltus_put_numbers(at, command->positions, n);
  at = saltus_put_numbers(at, command->velocities, n);
  at = saltus_put_numbers(at, command->stiffness, n);
  saltus_put_numbers(at, command->damping, n);
  saltus_put(bytes + 12, saltus_checksum(bytes, size), 4);
  return size;
}

/** Reads a command. If the message is not valid, returns 0 and does not change `command`. */
static inline int saltus_read_command(const saltus_link* link, const unsigned char* bytes,
                                      size_t size, saltus_command* command) {
  const int n = link->joints;
  if (!saltus_has_header(bytes, size, link, 2, saltus_command_size(n))) return 0;
  command->sequence = saltus_get(bytes + 24, 8);
  command->time = (int64_t)saltus_get(bytes + 32, 8);
  command->answers = saltus_get(bytes + 40, 8);
  command->state = (uint32_t)saltus_get(bytes + 48, 4);
  const unsigned char* at = saltus_get_numbers(bytes + 56, command->torques, n);
  at = saltus_get_numbers(at, command->positions, n);
  at = saltus_get_numbers(at, command->velocities, n);
  at = saltus_get_numbers(at, command->stiffness, n);
  saltus_get_numbers(at, command->damping, n);
  return 1;
}

/* ---- guard ---- */

/** Computes safe motor torques, also if the controller or the link fails. */
typedef struct saltus_guard {
  int joints;                         /**< number of joints */
  double silence;                     /**< s without a new command until it damps (0.015) */
  double release;                     /**< s without a new command until no torque (0.3) */
  double limits[SALTUS_LINK_JOINTS];  /**< largest torques, Nm */
  double dampers[SALTUS_LINK_JOINTS]; /**< its damping, Nm s/rad (0.2 s/rad times limits) */
  saltus_command command;             /**< newest valid command */
  double commanded_at;                /**< time at which it arrived, s; -INFINITY: none */
  long guarded;                       /**< calls in which the guard acted after a command */
  long refused;                       /**< messages refused: not valid, not finite, or old */
} saltus_guard;

/** What the guard lets the motors do. */
typedef enum saltus_guard_action {
  SALTUS_GUARD_PASSES = 0,  /**< the command acts */
  SALTUS_GUARD_DAMPS = 1,   /**< no new command: dampers only */
  SALTUS_GUARD_RELEASES = 2 /**< no command for long, or none yet: no torque */
} saltus_guard_action;

/* Reads the exponents, because -ffast-math lets a compiler assume that all numbers are finite. It
 * cannot look through the volatile bits. */
static inline int saltus_is_finite(const double* values, int n) {
  for (int i = 0; i < n; ++i) {
    uint64_t copy = 0;
    memcpy(&copy, &values[i], sizeof copy);
    const volatile uint64_t bits = copy;
    if ((bits >> 52 & 0x7ff) == 0x7ff) return 0;
  }
  return 1;
}

/** Prepares a guard with the default times, for motors with these largest torques (Nm). One that is
 * negative or not finite counts as 0. Without a joint, or with more than SALTUS_LINK_JOINTS, the
 * guard takes no command and writes no torque. */
static inline void saltus_guard_init(saltus_guard* guard, int joints, const double* limits) {
  memset(guard, 0, sizeof *guard);
  guard->joints = saltus_has_room(joints) ? joints : 0;
  guard->silence = 0.015;
  guard->release = 0.3;
  guard->commanded_at = -INFINITY;
  for (int i = 0; i < guard->joints; ++i) {
    guard->limits[i] = saltus_is_finite(&limits[i], 1) && limits[i] > 0.0 ? limits[i] : 0.0;
    guard->dampers[i] = 0.2 * guard->limits[i];
  }
}

/** Processes a message that arrived at `now` (s, any clock that does not jump). Returns 1 if it is
 * the newest valid command. Refuses a command with a number that is not finite. After the release
 * a controller that restarts may count from one, in any state, if it answers newer readings than
 * the last command did. */
static inline int saltus_guard_take(saltus_guard* guard, const saltus_link* link,
                                    const unsigned char* bytes, size_t size, double now) {
  saltus_command one;
  const int n = guard->joints;
  int is_good = link->joints == n && saltus_read_command(link, bytes, size, &one);
  is_good = is_good && saltus_is_finite(one.torques, n) && saltus_is_finite(one.positions, n) &&
            saltus_is_finite(one.velocities, n) && saltus_is_finite(one.stiffness, n) &&
            saltus_is_finite(one.damping, n);
  if (is_good && one.sequence <= guard->command.sequence)
    is_good = one.answers > guard->command.answers && !(now - guard->commanded_at < guard->release);
  if (!is_good) {
    ++guard->refused;
    return 0;
  }
  guard->command = one;
  guard->commanded_at = now;
  return 1;
}

/** Writes the motor torques at `now`, within their limits, for joint positions q (rad) and
 * velocities dq (rad/s). Target positions advance with the velocities of the command. */
static inline saltus_guard_action saltus_guard_torques(saltus_guard* guard, double now,
                                                       const double* q, const double* dq,
                                                       double* torques) {
  const saltus_command* c = &guard->command;
  const double age = now - guard->commanded_at;
  saltus_guard_action action = SALTUS_GUARD_RELEASES;
  if (age < guard->silence)
    action = SALTUS_GUARD_PASSES;
  else if (age < guard->release)
    action = SALTUS_GUARD_DAMPS;
  if (action != SALTUS_GUARD_PASSES && saltus_is_finite(&guard->commanded_at, 1)) ++guard->guarded;
  for (int i = 0; i < guard->joints; ++i) {
    double torque = 0.0;
    if (action == SALTUS_GUARD_PASSES)
      torque = c->torques[i] + c->stiffness[i] * (c->positions[i] + age * c->velocities[i] - q[i]) +
               c->damping[i] * (c->velocities[i] - dq[i]);
    else if (action == SALTUS_GUARD_DAMPS)
      torque = -guard->dampers[i] * dq[i];
    if (!saltus_is_finite(&torque, 1)) torque = 0.0; /* an encoder reads NaN */
    torques[i] = fmax(-guard->limits[i], fmin(guard->limits[i], torque));
  }
  return action;
}

#ifdef __cplusplus
}
#endif

#endif
