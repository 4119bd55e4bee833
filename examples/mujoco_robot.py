"""A robot for `saltus control`: MuJoCo in a process that knows nothing of Saltus but its protocol (docs/robot_link.md).

    saltus control --mjcf icub.xml
    saltus control --link udp:5555 &
    python3 mujoco_robot.py icub.xml --link udp:5555 --push 7 --loss 0.01 --jitter 0.005

Needs the package mujoco. The robot hangs on a stand until the controller balances. Exit status: 0 the robot stands at
the end, 1 it has fallen, 2 wrong arguments, 3 no answer from a controller, 77 the package mujoco is missing.
"""

import argparse
import math
import mmap
import os
import random
import socket
import struct
import sys
import time
import zlib

try:
    import mujoco
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}; install it with: python3 -m pip install mujoco")
    sys.exit(77)

HEADER = struct.Struct("<IHHIIIHHQq")  # magic, version, type, size, checksum, robot, joints, flags, sequence, time in ns
MAGIC, VERSION, SENSORS, COMMAND = 0x4C544C53, 1, 1, 2
START, STAND, BALANCE, HOLD, DAMP, RELEASE, CHECK = range(7)


class Protocol:
    def __init__(self, joints):
        self.n = len(joints)
        self.robot = zlib.crc32("".join(name + "\n" for name in joints).encode())

    def sensors(self, sequence, seconds, pace, stop, numbers, guards=False):
        body = struct.pack(f"<dd{len(numbers)}d", pace, 0.0, *numbers)
        head = [MAGIC, VERSION, SENSORS, HEADER.size + len(body), 0, self.robot, self.n,
                int(stop) + 2 * int(guards), sequence, round(seconds * 1e9)]
        head[4] = zlib.crc32(HEADER.pack(*head) + body)
        return HEADER.pack(*head) + body

    def command(self, data):
        """(sequence, answered sequence, state, torques, positions, velocities, stiffness, damping), or None."""
        if len(data) != HEADER.size + 16 + 40 * self.n:
            return None
        head = list(HEADER.unpack_from(data))
        checksum, head[4] = head[4], 0
        if head[:4] != [MAGIC, VERSION, COMMAND, len(data)] or head[5:7] != [self.robot, self.n]:
            return None
        if checksum != zlib.crc32(HEADER.pack(*head) + data[HEADER.size:]):
            return None
        answers, state = struct.unpack_from("<QI", data, HEADER.size)
        numbers = np.frombuffer(data, "<f8", 5 * self.n, HEADER.size + 16)
        return (head[8], answers, state, *numbers.reshape(5, self.n)) if np.isfinite(numbers).all() else None


class Udp:
    def __init__(self, address):
        host, _, port = address.rpartition(":")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host or "127.0.0.1", int(port)))

    def send(self, data):
        try:
            self.socket.send(data)
        except ConnectionRefusedError:  # nobody listens yet
            pass

    def receive(self, seconds):
        self.socket.settimeout(max(seconds, 1e-6))
        try:
            return self.socket.recv(65536)
        except (TimeoutError, BlockingIOError, ConnectionRefusedError):
            return None


class SharedMemory:
    """Two slots of a count (odd while it is written), a size and 8192 bytes: to the controller, to the robot."""

    def __init__(self, name):
        with open(os.path.join("/dev/shm", name), "r+b") as file:
            self.memory = mmap.mmap(file.fileno(), 2 * 8200)
        self.seen = struct.unpack_from("<I", self.memory, 8200)[0]

    def send(self, data):
        count = struct.unpack_from("<I", self.memory, 0)[0] | 1
        struct.pack_into("<I", self.memory, 0, count)
        struct.pack_into(f"<I{len(data)}s", self.memory, 4, len(data), data)
        struct.pack_into("<I", self.memory, 0, (count + 1) % 2**32)

    def receive(self, seconds):
        until = time.perf_counter() + seconds
        while True:
            count, size = struct.unpack_from("<II", self.memory, 8200)
            if count % 2 == 0 and count != self.seen:
                data = self.memory[8208:8208 + min(size, 8192)]
                if struct.unpack_from("<I", self.memory, 8200)[0] == count:
                    self.seen = count
                    return data
            if time.perf_counter() >= until:
                return None
            time.sleep(2e-5)


class Body:
    """The simulated robot, its sensors and its motors."""

    def __init__(self, file):
        self.model = mujoco.MjModel.from_xml_path(file)
        self.data = mujoco.MjData(self.model)
        m = self.model
        self.joints = m.actuator_trnid[:, 0]
        self.names = [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j) for j in self.joints]
        self.q, self.v = m.jnt_qposadr[self.joints], m.jnt_dofadr[self.joints]
        self.feet = [(m.site(side + "_sole").id, m.site_bodyid[m.site(side + "_sole").id]) for side in ("left", "right")]
        mujoco.mj_resetDataKeyframe(m, self.data, 0)
        mujoco.mj_forward(m, self.data)
        self.height = self.data.qpos[2]

    def sensors(self):
        m, d = self.model, self.data
        mujoco.mj_rnePostConstraint(m, d)
        feet = []
        for site, body in self.feet:  # cfrc_ext: torque about the CoM of the robot, force; world axes
            axes, torque, force = d.site_xmat[site].reshape(3, 3), d.cfrc_ext[body, :3], d.cfrc_ext[body, 3:]
            arm = d.site_xpos[site] - d.subtree_com[m.body_rootid[body]]
            feet += [force @ axes, (torque - np.cross(arm, force)) @ axes]
        named = [d.sensor(name).data for name in ("gyroscope", "accelerometer", "orientation")]
        return np.concatenate([*named, *feet, d.qpos[self.q], d.qvel[self.v]])

    def drive(self, command, age):
        """Torque of motors with springs and dampers. Positions advance with the velocities."""
        torques, positions, velocities, stiffness, damping = command
        q, dq = self.data.qpos[self.q], self.data.qvel[self.v]
        total = torques + stiffness * (positions + age * velocities - q) + damping * (velocities - dq)
        self.data.ctrl[:] = np.clip(total, *self.model.actuator_ctrlrange.T)

    def fallen(self):
        return self.data.qpos[2] < 0.6 * self.height or not np.isfinite(self.data.qpos).all()


class Lossy:
    """Loses and delays messages, each by its own time: later ones can arrive first."""

    def __init__(self, options):
        self.loss, self.delay, self.jitter = options.loss, options.delay, options.jitter
        self.random, self.waiting = random.Random(options.seed), []

    def put(self, now, order, message):
        lost, late = self.random.random() < self.loss, self.random.uniform(0.0, self.jitter)
        if not lost:
            self.waiting.append((now + self.delay + late, order, message))

    def take(self, now):
        due = sorted((one for one in self.waiting if one[0] <= now + 1e-9), key=lambda one: one[1])
        self.waiting = [one for one in self.waiting if one[0] > now + 1e-9]
        return [message for _, _, message in due]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", help="MJCF file")
    parser.add_argument("--link", required=True, help="udp:PORT, udp:ADDRESS:PORT or shm:NAME")
    parser.add_argument("--pace", type=float, default=0.0, help="wall-clock time per robot time; 0: lock-step (default)")
    parser.add_argument("--time", type=float, default=6.0, help="duration, s")
    parser.add_argument("--push", type=float, default=0.0, help="impulse, N s")
    parser.add_argument("--angle", type=float, default=-90.0, help="its direction, degrees: 0 forward, 90 to the left")
    parser.add_argument("--push-at", type=float, default=2.4, help="its start, s")
    parser.add_argument("--push-for", type=float, default=0.1, help="its duration, s")
    parser.add_argument("--push-body", default="chest", help="name of the pushed body")
    parser.add_argument("--loss", type=float, default=0.0, help="fraction of lost messages, in each direction")
    parser.add_argument("--delay", type=float, default=0.0, help="delay in each direction, s")
    parser.add_argument("--jitter", type=float, default=0.0, help="additional random delay, at most, s")
    parser.add_argument("--seed", type=int, default=1, help="seed of loss and jitter")
    parser.add_argument("--guard", type=float, default=0.015, help="time without commands until the guard acts, s")
    parser.add_argument("--guard-damping", type=float, default=0.2, help="dampers of the guard, torque limits per rad/s")
    parser.add_argument("--guard-release", type=float, default=0.3, help="time after which the guard releases, s")
    parser.add_argument("--fault", choices=["nan", "clock", "stuck", "silence"], help="a fault to simulate")
    parser.add_argument("--fault-joint", type=int, default=3, help="index of the faulty joint")
    parser.add_argument("--fault-at", type=float, default=1.0, help="its start, s")
    o = parser.parse_args()

    body, link = Body(o.model), {"udp": Udp, "shm": SharedMemory}[o.link[:3]](o.link[4:])
    protocol, period, steps = Protocol(body.names), body.model.opt.timestep, round(o.time / body.model.opt.timestep)
    out, back = Lossy(o), Lossy(argparse.Namespace(**{**vars(o), "seed": o.seed + 10**6}))
    zeros = np.zeros(protocol.n)
    limit, chest = body.model.actuator_ctrlrange[:, 1], body.model.body(o.push_body).id
    force = o.push / o.push_for * np.array([math.cos(math.radians(o.angle)), math.sin(math.radians(o.angle)), 0.0])
    command, newest, commanded_at, guarded, on_stand, state, is_alive = (zeros,) * 5, 0, 0.0, 0, True, START, True
    begin, k, sequence, delivered, answered = time.perf_counter(), 0, 0, -1, -1
    waiting_since, guards = begin, False
    answers, taken_at = -1, 0.0  # of the newest command
    while k < steps:
        now = sequence * period  # the clock of the robot runs on the stand, too
        t = k * period           # since the robot left the stand
        readings, stamp = body.sensors(), now
        if o.fault and t >= o.fault_at:
            if o.fault == "nan":
                readings[22 + o.fault_joint] = math.nan
            if o.fault == "clock":
                stamp = now - (t - o.fault_at)
        if not (o.fault == "silence" and t >= o.fault_at):
            out.put(now, sequence, (sequence, protocol.sensors(sequence, stamp, o.pace, False, readings, guards)))
        before = delivered
        for number, message in out.take(now):
            delivered = max(delivered, number)
            link.send(message)
        # Lock-step: waits for the answer to what was delivered. Otherwise until the end of the period.
        until = time.perf_counter() + 2.0 if o.pace == 0.0 else begin + o.pace * (sequence + 1) * period
        while (o.pace > 0.0 or (answered < delivered and delivered > before and is_alive)) and time.perf_counter() < until:
            data = link.receive(min(until - time.perf_counter(), 0.1))
            one = protocol.command(data) if data else None
            if one:
                answered, waiting_since = max(answered, one[1]), time.perf_counter()
                back.put(now if o.pace == 0.0 else now + period, one[0], one)
        if o.pace == 0.0 and not on_stand and answered < delivered and delivered > before:
            is_alive = False  # do not wait for a controller that has gone
        for one in back.take(now):
            # A new controller may count from one. It answers newer readings.
            if one[0] > newest or (one[1] > answers and now - taken_at >= o.guard_release):
                newest, answers, state, command, commanded_at, taken_at = *one[:3], one[3:], now, now
        on_stand = on_stand and state != BALANCE
        sequence += 1
        if on_stand:  # the joints follow the commands, the base does not move
            if state in (STAND, CHECK):
                body.data.qpos[body.q] = command[1]
                mujoco.mj_forward(body.model, body.data)
            if time.perf_counter() - waiting_since > 30.0:
                print("robot: no controller balances within 30 s; start `saltus control` with the same --link")
                return 3
            commanded_at = now
            continue
        silent = now - commanded_at
        guards = silent >= o.guard
        if not guards:
            body.drive(command, silent)
        else:
            guarded += 1
            body.drive((zeros, zeros, zeros, zeros, o.guard_damping * limit * (silent < o.guard_release)), 0.0)
        if o.fault == "stuck" and t >= o.fault_at:
            body.data.qvel[body.v[o.fault_joint]] = 0.0
            body.model.dof_damping[body.v[o.fault_joint]] = 1e4
        body.data.xfrc_applied[chest, :3] = force if o.push_at <= t < o.push_at + o.push_for else 0.0
        mujoco.mj_step(body.model, body.data)
        k += 1
        if body.fallen():
            break
    for _ in range(50):  # asks for a soft stop
        link.send(protocol.sensors(sequence, sequence * period, o.pace, True, body.sensors()))
        sequence += 1
    print(f"robot: {'has fallen' if body.fallen() else 'stands'} after {k * period:.3f} s; guard: {guarded} periods; "
          f"{time.perf_counter() - begin:.1f} s of real time")
    return 1 if body.fallen() else 0


if __name__ == "__main__":
    sys.exit(main())
