#!/usr/bin/env python3
"""Compares iCub's CoM, momentum, mass matrix, bias forces and Jacobians with those of Pinocchio.

Usage: compare_with_pinocchio.py PRINT_DYNAMICS. In 100 random states of the URDF that
SALTUS_ICUB_URDF names, to 1e-9 of the largest entry of each quantity. Exits with 77, "skipped", if the package pin
(PyPI) or the URDF is missing.
"""

import json
import os
import subprocess
import sys

SKIPPED = 77
STATES, SEED = 100, 1
TOLERANCE = 1e-9  # relative
URDF = os.environ.get("SALTUS_ICUB_URDF", "")

try:
    import numpy as np
    import pinocchio as pin
except ImportError:
    print("skipped: this python3 has no Pinocchio (package pin of PyPI)")
    sys.exit(SKIPPED)


def reduced_model(kept):
    """The free-floating robot with all joints except these frozen at zero."""
    model = pin.buildModelFromUrdf(URDF, pin.JointModelFreeFlyer())
    locked = [i for i in range(2, model.njoints) if model.names[i] not in kept]
    return pin.buildReducedModel(model, locked, pin.neutral(model))


class Comparison:
    def __init__(self, description):
        self.joints = description["joints"]
        self.model = reduced_model(self.joints)
        self.data = self.model.createData()
        self.soles = {}
        for side in ("left", "right"):
            at = self.model.frames[self.model.getFrameId(description[side + "_sole"])]
            offset = pin.SE3(np.eye(3), np.array([0.0, 0.0, description["contact_plane_offset"]]))
            self.soles[side] = self.model.addFrame(
                pin.Frame(side + "_contact", at.parentJoint, 0, at.placement * offset,
                          pin.FrameType.OP_FRAME))
        self.data = self.model.createData()
        # Ours: (angular, linear) of the base, then joints in the order of the torques.
        columns = [self.model.joints[self.model.getJointId(name)].idx_v for name in self.joints]
        self.order = [3, 4, 5, 0, 1, 2] + columns
        self.worst = {}

    def note(self, name, ours, theirs):
        ours, theirs = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
        error = np.abs(ours.reshape(theirs.shape) - theirs).max() / max(np.abs(theirs).max(), 1e-3)
        self.worst[name] = max(self.worst.get(name, 0.0), error)

    def state(self, line):
        R = np.array(line["base_rotation"])
        quaternion = pin.Quaternion(R)
        q = pin.neutral(self.model)
        q[:3] = np.ravel(line["base_position"])
        q[3:7] = quaternion.coeffs()
        twist = np.ravel(line["base_twist"])  # world axes
        v = np.zeros(self.model.nv)
        v[:3], v[3:6] = R.T @ twist[3:], R.T @ twist[:3]
        for name, position, speed in zip(self.joints, np.ravel(line["q"]), np.ravel(line["dq"])):
            joint = self.model.joints[self.model.getJointId(name)]
            q[joint.idx_q], v[joint.idx_v] = position, speed
        return q, v

    def add(self, line):
        model, data = self.model, self.data
        q, v = self.state(line)
        pin.computeAllTerms(model, data, q, v)
        momentum = pin.computeCentroidalMomentum(model, data, q, v)
        self.note("com", line["com"], pin.centerOfMass(model, data, q, v))
        self.note("com velocity", line["com_velocity"], data.vcom[0])
        self.note("angular momentum", line["angular_momentum"], momentum.angular)
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        self.note("mass matrix", line["mass_matrix"], M[np.ix_(self.order, self.order)])
        self.note("bias forces", line["bias"], pin.nonLinearEffects(model, data, q, v)[self.order])
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        pin.updateFramePlacements(model, data)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        for side, frame in self.soles.items():
            ours = line[side]
            self.note("sole's place", ours["position"], data.oMf[frame].translation)
            self.note("sole's axes", ours["rotation"], data.oMf[frame].rotation)
            J = pin.computeFrameJacobian(model, data, q, frame, aligned)[[3, 4, 5, 0, 1, 2]]
            self.note("Jacobian", ours["jacobian"], J[:, self.order])
            drift = pin.getFrameClassicalAcceleration(model, data, frame, aligned)
            self.note("drift", ours["drift"], np.concatenate([drift.angular, drift.linear]))


def main(program):
    if not os.path.exists(URDF):
        print("skipped: SALTUS_ICUB_URDF does not name iCub's URDF")
        return SKIPPED
    lines = subprocess.run([program, URDF, str(STATES), str(SEED)], capture_output=True, text=True,
                           check=True).stdout.splitlines()
    comparison = Comparison(json.loads(lines[0]))
    for line in lines[1:]:
        comparison.add(json.loads(line))
    print(f"{len(lines) - 1} states, seed {SEED}, Pinocchio {pin.__version__}")
    for name, error in comparison.worst.items():
        print(f"  {name:<18}{error:.1e}{'' if error < TOLERANCE else '  TOO LARGE'}")
    return 0 if len(lines) == STATES + 1 and max(comparison.worst.values()) < TOLERANCE else 1


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
