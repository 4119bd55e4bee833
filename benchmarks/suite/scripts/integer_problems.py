"""Mixed-integer programs that this file generates, in the format `saltus-qp 1`. The instance is the seed.

    integer/dwell       a switched linear system of three modes that tracks a signal; a mode lasts at least DWELL intervals
    integer/commitment  four units that cover a demand; minimum times on and off, start-up costs
    integer/logic       predictive control of a mass that may touch a spring, which is a logical condition

Names that end in -l1 have linear costs. Exhaustive search gives the optima of integer/dwell, and dynamic programming those
of integer/commitment. The optima of integer/logic are stored in KNOWN: the best of all 256 combinations of contacts, each
solved as a convex program to 1e-10 (PIQP, HiGHS).
"""

import itertools
import math

import numpy as np

import quadratic_files

PREFIX = "integer/"
ABOUT = {"dwell": "a switched system with dwell times tracks a signal, quadratic cost", "dwell-l1": "the same with absolute values",
         "commitment": "four units cover a demand; minimum times on and off", "logic": "predictive control with a contact, quadratic cost",
         "logic-l1": "the same with absolute values"}
INTERVALS, DWELL, MODES, SWITCH_COST = 12, 3, 3, 0.05
PERIODS, UNITS, LASTS = 16, 4, 3
STEPS, TIME_STEP, STIFFNESS, FAR, CONTROL_COST = 8, 0.25, 4.0, 10.0, 0.05
KNOWN = {"logic": (0.636034368424, 14.399528110508, 17.123613538942, 6.305756865411, 1.237150969378),
         "logic-l1": (1.094405595398, 10.133621834388, 11.070609873075, 6.664400195012, 2.099284059683)}
INSTANCES = 5
MARGIN = 1e-6  # relative


def described():
    return [{"name": PREFIX + name, "about": about, "instances": INSTANCES, "warm": False,
             "horizon": {"d": INTERVALS, "c": PERIODS, "l": STEPS}[name[0]], "kind": "integer"} for name, about in ABOUT.items()]


def program(problem, seed):
    name = problem[len(PREFIX):]
    make = {"dwell": dwell, "commitment": commitment, "logic": logic}[name.split("-")[0]]
    return {**make(problem, seed, name.endswith("-l1")), "instance": seed, "optimum_tolerance": MARGIN}


class Model:
    """Builder of a program: adds variables with bounds, and rows. A term is a pair (variable, factor)."""

    def __init__(self):
        self.lower, self.upper, self.integer, self.linear, self.square = [], [], [], [], []
        self.rows, self.row_lower, self.row_upper, self.constant = [], [], [], 0.0

    def variable(self, lower=-math.inf, upper=math.inf, cost=0.0, square=0.0, is_integer=False):
        """Adds cost v + square v^2 to the objective."""
        if is_integer:
            self.integer.append(len(self.lower))
        for of, value in ((self.lower, lower), (self.upper, upper), (self.linear, cost), (self.square, square)):
            of.append(value)
        return len(self.lower) - 1

    def variables(self, count, *sides, **more):
        return [self.variable(*sides, **more) for _ in range(count)]

    def binaries(self, count, **more):
        return self.variables(count, 0.0, 1.0, is_integer=True, **more)

    def row(self, terms, lower=-math.inf, upper=math.inf):
        self.rows.append(terms)
        self.row_lower.append(lower)
        self.row_upper.append(upper)

    def penalty(self, variable, target, weight, is_absolute):
        """Adds weight (v - target)^2, or weight |v - target|."""
        if is_absolute:
            size = self.variable(0.0, cost=weight)
            self.row([(size, 1.0), (variable, -1.0)], lower=-target)
            self.row([(size, 1.0), (variable, 1.0)], lower=target)
        else:
            self.square[variable] += weight
            self.linear[variable] -= 2.0 * weight * target
            self.constant += weight * target * target

    def file(self, name, optimum):
        entries = [(i, v, factor) for i, terms in enumerate(self.rows) for v, factor in terms]
        diagonal = [v for v, square in enumerate(self.square) if square]
        return {**quadratic_files.program(
            name, len(self.lower), len(self.rows), (diagonal, diagonal, [2.0 * self.square[v] for v in diagonal]),
            tuple(zip(*entries)), self.linear, (self.lower, self.upper), (self.row_lower, self.row_upper), self.constant),
            "integer": self.integer, "optimum": optimum}


def cost_of(error, weight, is_absolute):
    return weight * (np.abs(error) if is_absolute else error * error)


def dwell(name, seed, is_absolute):
    random = np.random.default_rng(seed)
    A = np.array([[0.95, 0.1], [-0.1, 0.9]])
    drive, phase = random.uniform(-0.6, 0.6, (MODES, 2)), random.uniform(0.0, 6.0)
    start, signal = np.zeros(2), 1.5 * np.sin(0.4 * np.arange(1, INTERVALS + 1) + phase)
    m = Model()
    mode = [m.binaries(MODES) for _ in range(INTERVALS)]
    begins = [m.binaries(MODES, cost=SWITCH_COST if k else 0.0) for k in range(INTERVALS)]
    state = [m.variables(2) for _ in range(INTERVALS)]
    for k in range(INTERVALS):
        m.row([(v, 1.0) for v in mode[k]], 1.0, 1.0)
        for i in range(2):
            terms = [(state[k][i], -1.0), *((v, d) for v, d in zip(mode[k], drive[:, i]))]
            shift = -float(A[i] @ start) if k == 0 else 0.0
            m.row(terms + ([] if k == 0 else [(state[k - 1][j], A[i, j]) for j in range(2)]), shift, shift)
        for j in range(MODES):
            before = [(mode[k - 1][j], 1.0)] if k else []
            m.row([(begins[k][j], 1.0), (mode[k][j], -1.0), *before], lower=0.0)
            m.row([*((begins[i][j], 1.0) for i in range(max(0, k - DWELL + 1), k + 1)), (mode[k][j], -1.0)], upper=0.0)
        m.penalty(state[k][0], signal[k], 1.0, is_absolute)
    return m.file(name, _best_sequence(A, drive, start, signal, is_absolute))


def _best_sequence(A, drive, start, signal, is_absolute):
    """The smallest cost of all sequences that respect the dwell time."""
    state, cost = np.tile(start, (MODES, 1)), np.zeros(MODES)
    mode, age = np.arange(MODES), np.zeros(MODES, dtype=int)
    for k in range(INTERVALS):
        if k:
            free = np.flatnonzero(age >= DWELL)
            turn = np.concatenate([(mode[free] + shift) % MODES for shift in range(1, MODES)])
            state = np.vstack([state, *[state[free]] * (MODES - 1)])
            cost = np.concatenate([cost, *[cost[free] + SWITCH_COST] * (MODES - 1)])
            mode, age = np.concatenate([mode, turn]), np.concatenate([age, np.zeros(len(turn), dtype=int)])
        state, age = state @ A.T + drive[mode], age + 1
        cost = cost + cost_of(state[:, 0] - signal[k], 1.0, is_absolute)
    return float(cost.min())


def commitment(name, seed, _):
    random = np.random.default_rng(seed)
    low, high = random.uniform(0.3, 0.6, UNITS), random.uniform(1.0, 2.0, UNITS)
    idle, price, start = (random.uniform(*sides, UNITS) for sides in ((0.1, 0.4), (0.5, 1.5), (0.5, 1.5)))
    demand = (0.3 + 0.5 * random.uniform(0.0, 1.0, PERIODS)) * high.sum()
    m = Model()
    on, begins, ends = ([m.binaries(UNITS) for _ in range(PERIODS)] for _ in range(3))
    power = [m.variables(UNITS, 0.0) for _ in range(PERIODS)]
    for t in range(PERIODS):
        m.row([(v, 1.0) for v in power[t]], lower=demand[t])
        for u in range(UNITS):
            for v, cost in ((on[t][u], idle[u]), (begins[t][u], start[u]), (power[t][u], price[u])):
                m.linear[v] += cost
            m.row([(power[t][u], 1.0), (on[t][u], -low[u])], lower=0.0)
            m.row([(power[t][u], 1.0), (on[t][u], -high[u])], upper=0.0)
            m.row([(on[t][u], 1.0), (begins[t][u], -1.0), (ends[t][u], 1.0), *([(on[t - 1][u], -1.0)] if t else [])], 0.0, 0.0)
            recent = range(max(0, t - LASTS + 1), t + 1)
            m.row([*((begins[i][u], 1.0) for i in recent), (on[t][u], -1.0)], upper=0.0)
            m.row([*((ends[i][u], 1.0) for i in recent), (on[t][u], 1.0)], upper=1.0)
    return m.file(name, _best_schedule(low, high, idle, price, start, demand))


def _best_schedule(low, high, idle, price, start, demand):
    """The smallest cost, by dynamic programming. The state of a unit is (on, periods since its last change, at most LASTS)."""
    def power_cost(on, wanted):
        left = wanted - low[on].sum()
        total = price[on] @ low[on]
        for u in sorted(np.flatnonzero(on), key=lambda u: price[u]):
            more = min(max(left, 0.0), high[u] - low[u])
            total, left = total + more * price[u], left - more
        return total + idle[on].sum() if left <= 1e-12 else math.inf
    sets = [np.array(on, dtype=bool) for on in itertools.product((0, 1), repeat=UNITS)]
    best = {((0, LASTS),) * UNITS: 0.0}
    for wanted in demand:
        of_set = {tuple(map(int, on)): power_cost(on, wanted) for on in sets}
        following = {}
        for state, cost in best.items():
            options = [[(is_on, min(age + 1, LASTS)), *([(1 - is_on, 1)] if age >= LASTS else [])] for is_on, age in state]
            for new in itertools.product(*options):
                total = cost + of_set[tuple(is_on for is_on, _ in new)] + sum(
                    start[u] for u in range(UNITS) if new[u] == (1, 1) and state[u][0] == 0)
                if total < following.get(new, math.inf):
                    following[new] = total
        best = following
    return float(min(best.values()))


def logic(name, seed, is_absolute, contacts=None):
    """p+ = p + h v, v+ = v + h (u + s), where s is the force of a spring: STIFFNESS max(0, -p). A binary variable says
    whether p is below 0. `contacts` fixes them."""
    random = np.random.default_rng(seed)
    position, speed = random.uniform(0.2, 1.0), random.uniform(-3.0, -1.0)
    target, h = random.uniform(0.3, 0.8), TIME_STEP
    m = Model()
    touches, u = m.binaries(STEPS), m.variables(STEPS, -2.0, 2.0)
    if contacts is not None:
        for v, value in zip(touches, contacts):
            m.lower[v] = m.upper[v] = float(value)
    depth, p, v = m.variables(STEPS, 0.0, FAR), m.variables(STEPS + 1, -FAR, FAR), m.variables(STEPS + 1, -FAR, FAR)
    for of, value in ((p, position), (v, speed)):
        m.lower[of[0]] = m.upper[of[0]] = value
    for k in range(STEPS):
        m.row([(p[k + 1], -1.0), (p[k], 1.0), (v[k], h)], 0.0, 0.0)
        m.row([(v[k + 1], -1.0), (v[k], 1.0), (u[k], h), (depth[k], h * STIFFNESS)], 0.0, 0.0)
        m.row([(depth[k], 1.0), (p[k], 1.0)], lower=0.0)
        m.row([(depth[k], 1.0), (p[k], 1.0), (touches[k], FAR)], upper=FAR)
        m.row([(depth[k], 1.0), (touches[k], -FAR)], upper=0.0)
        m.penalty(u[k], 0.0, CONTROL_COST, is_absolute)
        m.penalty(p[k + 1], target, 1.0, is_absolute)
        m.penalty(v[k + 1], 0.0, 0.1, is_absolute)
    return m.file(name, KNOWN[name[len(PREFIX):]][seed - 1])
