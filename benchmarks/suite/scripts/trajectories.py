"""Quadratic programs with stages as trajectories, for solvers of states and inputs with a given start, without other
variables."""

import numpy as np

import hpipm
from peers import NotApplicable
from quadratic_program import Whole


class Trajectory:
    """The stages with the start x_0 as their first state, which trajectory solvers keep themselves."""

    def __init__(self, qp):
        if not qp.stages or len(qp.stages) < 2:
            raise NotApplicable("it has no stages")
        self.qp, self.stages = qp, hpipm.stages_of(qp, Whole(qp))
        self.nx = int(self.stages[0].nx)
        if any(s.nx != self.nx for s in self.stages) or self.stages[-1].nu:
            raise NotApplicable("the number of its states varies between stages, or it has inputs at its end")
        self.start = qp.lower[:self.nx]
        if (self.start != qp.upper[:self.nx]).any():
            raise NotApplicable("its start is not fixed")
        self.rows = [self._rows(k) for k in range(len(self.stages))]

    def _rows(self, k):
        """(C, D, low, high) of low <= C x + D u <= high: rows, then bounds of states except the first, then of inputs."""
        s = self.stages[k]
        C, D, low, high = [s.C], [s.D], [s.low], [s.high]
        if k > 0:
            C.append(np.eye(s.nx)[s.bounded_x])
            D.append(np.zeros((len(s.bounded_x), s.nu)))
            low.append(s.x_low)
            high.append(s.x_high)
        C.append(np.zeros((len(s.bounded_u), s.nx)))
        D.append(np.eye(s.nu)[s.bounded_u])
        low.append(s.u_low)
        high.append(s.u_high)
        return np.vstack(C), np.vstack(D), np.concatenate(low), np.concatenate(high)

    def split(self, w):
        """(states, inputs) of a point; for None the given start, then zeros."""
        if w is None:
            w = np.zeros(self.qp.n)
            w[:self.nx] = self.start
        return [w[s.x].copy() for s in self.stages], [w[s.u].copy() for s in self.stages[:-1]]

    def split_multipliers(self, rows, bounds):
        """(of the start and the dynamics that lead to each state, of the rows of each stage)."""
        costates = [bounds[:self.nx].copy(), *(rows[s.dynamics].copy() for s in self.stages[:-1])]
        pushes = [np.concatenate([rows[s.rows], bounds[s.x.start + s.bounded_x] if k else [], bounds[s.u.start + s.bounded_u]])
                  for k, s in enumerate(self.stages)]
        return costates, pushes

    def joined(self, states, inputs):
        w = np.zeros(self.qp.n)
        for s, x in zip(self.stages, states):
            w[s.x] = x
        for s, u in zip(self.stages, inputs):
            w[s.u] = u
        return w

    def joined_multipliers(self, w, costates, pushes):
        """(lambda, z); the multipliers of the start make its slope zero."""
        rows, bounds = np.zeros(self.qp.m), np.zeros(self.qp.n)
        for k, s in enumerate(self.stages):
            if k + 1 < len(self.stages):
                rows[s.dynamics] = costates[k + 1]
            count, states = len(s.low), len(s.bounded_x) if k else 0
            rows[s.rows] = pushes[k][:count]
            bounds[s.x.start + s.bounded_x[:states]] = pushes[k][count:count + states]
            bounds[s.u.start + s.bounded_u] = pushes[k][count + states:]
        bounds[:self.nx] = -self.slope(w, rows)[:self.nx]
        return rows, bounds

    def slope(self, w, rows):
        """Gradient of the Lagrangian without the bounds."""
        return self.qp.hessian.times(w) + self.qp.gradient + self.qp.jacobian.transposed_times(rows)
