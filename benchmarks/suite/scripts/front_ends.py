"""do-mpc and rockit: front ends that formulate an optimal control problem themselves, for CasADi and Ipopt.

They receive next state and cost of an interval as one CasADi function of state, input and the varying numbers (times),
so their program has our discretisation. This supports problems with a fixed start and without other stage rows. Neither
returns its multipliers in our order, so they are computed from the point, in its favour.
"""

import numpy as np

from fatrop import Stages
from nonlinear_peers import CasadiIpopt
from nonlinear_program import CasadiProgram, expression
from peers import Answer, NotApplicable

UNSUITED = "its start is not given, or it has rows other than dynamics, bounds of states, or intervals that differ"


class Intervals:
    """step(x, u, numbers) -> (next, cost), numbers[k] of interval k, and the indices of states and inputs in w. With `more` a
    program may also have bounds of states, a cost at the end (end_cost(x) or None), and given values at the end (end_rows)."""

    def __init__(self, file, more=False):
        import casadi as ca
        found = Stages(file)
        sizes = found.sizes
        nx, nu, self.N = sizes[1][0], sizes[0][0] + sizes[0][1] - sizes[1][0], len(sizes) - 1
        wanted = [[nx, nu, 0]] * (self.N - 1) + [[nx, 0, sizes[-1][2] if more else 0]]
        self._counts, self.more, self._end_blocks = np.array([len(of) for of in found.columns]), more, []
        if nu < 1 or sizes[0][2] != nx or sizes[1:] != wanted or file.data["variable_costs"]:
            raise NotApplicable(UNSUITED)
        self.file, self.nx, self.nu = file, nx, nu
        self.states = np.array([k * (nx + nu) + np.arange(nx) for k in range(self.N + 1)])
        self.inputs = np.array([k * (nx + nu) + nx + np.arange(nu) for k in range(self.N)])
        self.start = self._given_start()
        if not more and (np.isfinite(file.lower[self.states]).any() or np.isfinite(file.upper[self.states]).any()):
            raise NotApplicable(UNSUITED)
        self.low, self.high = file.lower[self.inputs[0]], file.upper[self.inputs[0]]
        if (file.lower[self.inputs] != self.low).any() or (file.upper[self.inputs] != self.high).any():
            raise NotApplicable(UNSUITED)
        kinds, numbers = zip(*(self._interval(k) for k in range(self.N)))
        if any(kind != kinds[0] for kind in kinds):
            raise NotApplicable(UNSUITED)
        numbers = np.array(numbers)
        self.varies = np.flatnonzero(np.ptp(numbers, axis=0) > 0.0)
        self.numbers = numbers[:, self.varies]
        x, u, p = ca.SX.sym("x", nx), ca.SX.sym("u", nu), ca.SX.sym("p", len(self.varies))
        every = ca.SX(numbers[0])
        for i, place in enumerate(self.varies):
            every[int(place)] = p[i]
        self.step = ca.Function("step", [x, u, p], self._outputs(kinds[0], ca.vertcat(x, u), every))
        self.end_cost = self._cost_at_end(ca.SX.sym("x", nx)) if self._end_blocks else None
        self.end_rows = [(row, v - self.states[-1, 0], file.row_lower[row] / f, f) for row, v, f in file.data["linear"]
                         if v >= self.states[-1, 0] and self._count(row) == 1]
        if any(file.row_lower[row] != file.row_upper[row] for row, *_ in self.end_rows):
            raise NotApplicable(UNSUITED)

    def _given_start(self):
        start, self.start_rows = np.full(self.nx, np.nan), []
        for row, variable, factor in self.file.data["linear"]:
            if variable < self.nx and self.file.row_lower[row] == self.file.row_upper[row] and self._count(row) == 1:
                start[variable] = self.file.row_lower[row] / factor
                self.start_rows.append((row, variable, factor))
        if np.isnan(start).any():
            raise NotApplicable(UNSUITED)
        return start

    def _count(self, row):
        return self._counts[row]

    def _interval(self, k):
        """(operations of the interval, relative to its first variable and first dynamics row; numbers that are
        arguments)."""
        if not hasattr(self, "_sorted"):
            self._sort()
        first, leads_to = k * (self.nx + self.nu), self._leads_to
        blocks, numbers = [], []
        for block in self._sorted[0][k]:
            coefficients = tuple(tuple((v - first, f) for v, f in terms) for terms in block["coefficients"])
            outputs = tuple((leads_to.get(row, -1) - first if row >= 0 else None, f) for row, f in block["outputs"])
            blocks.append((block["function"], coefficients, outputs))
            numbers += block["constants"]
        linear = tuple((leads_to[row] - first, v - first, f) for row, v, f in self._sorted[1][k])
        return (tuple(blocks), linear), numbers

    def _sort(self):
        """Blocks and linear parts of the dynamics by interval; row -> state that it defines."""
        size, after = self.nx + self.nu, set(self.states[1:].ravel().tolist())
        rows, self._leads_to, self.row_of = {}, {}, {}
        for row, v, f in self.file.data["linear"]:
            if self._count(row) > 1:
                rows.setdefault(row, []).append((v, f))
        for row, terms in rows.items():
            last, factor = max(terms)
            if last not in after or abs(factor) != 1.0 or self.file.row_lower[row] != self.file.row_upper[row]:
                raise NotApplicable(UNSUITED)
            self._leads_to[row] = last
            self.row_of[last] = row, factor
        blocks, linear = [[] for _ in range(self.N)], [[] for _ in range(self.N)]
        for block in self.file.data["blocks"]:
            touched = [v for terms in block["coefficients"] for v, _ in terms]
            k = min(touched) // size if touched else self.N
            if self.more and k == self.N and all(row < 0 for row, f in block["outputs"] if f != 0.0):
                self._end_blocks.append(block)
                continue
            if k >= self.N or max(touched) >= (k + 1) * size or any(
                    row >= 0 and f != 0.0 and row not in self._leads_to for row, f in block["outputs"]):
                raise NotApplicable(UNSUITED)  # a cost at the end, or of several intervals
            blocks[k].append(block)
        for row, terms in rows.items():
            k = (self._leads_to[row] // size) - 1
            linear[k] += [(row, v, f) for v, f in terms]
            if self.file.row_lower[row] != 0.0:
                raise NotApplicable(UNSUITED)
        self._sorted = blocks, linear

    def _cost_at_end(self, x):
        import casadi as ca
        cost = ca.SX(0)
        for block in self._end_blocks:
            arguments = {i: block["constants"][i] + sum((f * x[int(v - self.states[-1, 0])] for v, f in terms), ca.SX(0))
                         for i, terms in enumerate(block["coefficients"])}
            values = expression(self.file.data["functions"][block["function"]], arguments)
            cost += sum((factor * value for value, (_, factor) in zip(values, block["outputs"])), ca.SX(0))
        return ca.Function("end_cost", [x], [cost])

    def _outputs(self, kind, z, numbers):
        """Solves 0 = sum of linear parts and blocks for the next state; the cost of the interval."""
        import casadi as ca
        size = self.nx + self.nu
        rest, sign, cost, at = [ca.SX(0)] * self.nx, [1.0] * self.nx, ca.SX(0), 0
        for function, coefficients, outputs in kind[0]:
            arguments = {}
            for i, terms in enumerate(coefficients):
                arguments[i] = numbers[at + i] + sum((f * z[v] for v, f in terms), ca.SX(0))
            at += len(coefficients)
            for value, (place, factor) in zip(expression(self.file.data["functions"][function], arguments), outputs):
                if factor == 0.0:
                    continue
                if place is None:
                    cost += factor * value
                else:
                    rest[place - size] += factor * value
        for place, v, f in kind[1]:
            if v == place:
                sign[place - size] = f
            else:
                rest[place - size] += f * z[v]
        return [ca.vertcat(*(-r / s for r, s in zip(rest, sign))), cost]

    def joined(self, states, inputs):
        w = np.zeros(self.file.n)
        w[self.states], w[self.inputs] = states, inputs
        return w


class _FrontEnd(CasadiIpopt):
    """Uses the Ipopt options of casadi-ipopt."""
    takes_files = takes_pairs = False

    def __init__(self, file, tolerance):
        self.file = file
        if getattr(file, "intervals", None) is None:
            file.intervals = Intervals(file)
        if getattr(file, "casadi", None) is None:
            file.casadi = CasadiProgram(file)
        self.intervals = file.intervals
        self.guess = file.start[self.intervals.states], file.start[self.intervals.inputs]
        self.build({"print_time": False, "error_on_fail": False, "record_time": True, **self.options(tolerance)})

    def multipliers(self, w):
        """Multipliers of a point. Costates follow from zero slopes along the states; input bounds receive the remaining
        slope."""
        import casadi as ca
        import scipy.sparse.linalg as linear
        f, it, file = self.file.casadi.functions, self.intervals, self.file
        _, gradient, _, J = f["nlp_jac_fg"](w, [])
        gradient, J = np.array(gradient).ravel(), ca.DM(J).sparse().tocsc()
        states = it.states.ravel()
        rows = linear.spsolve(J[:, states].T.tocsc(), -gradient[states])
        slope = gradient + J.T @ rows
        bounds = np.zeros(file.n)
        places = it.inputs.ravel()
        distance = np.where(slope < 0.0, file.upper - w, w - file.lower)[places]
        bounds[places] = np.where(distance < 1.0, -slope[places], 0.0)
        return rows, bounds

    def answer(self, states, inputs, stats):
        w = self.intervals.joined(states, inputs)
        return Answer(w, *self.multipliers(w), claimed=str(stats.get("return_status", "")), solved=bool(stats.get("success")),
                      iterations=int(stats.get("iter_count", -1)), own_us=1e6 * stats["t_proc_total"])


class DoMpc(_FrontEnd):
    name, package, module = "do-mpc", "do-mpc", "do_mpc"
    about = "a front end: its program from our discretisation as a discrete model; CasADi's Ipopt, functions in CasADi's virtual machine"

    def build(self, options):
        import do_mpc
        it = self.intervals
        model = do_mpc.model.Model("discrete", "SX")
        x, u = model.set_variable("_x", "x", (it.nx, 1)), model.set_variable("_u", "u", (it.nu, 1))
        p = model.set_variable("_tvp", "p", (max(1, len(it.varies)), 1))
        model.set_rhs("x", it.step(x, u, p[:len(it.varies)])[0])
        model.setup()
        x, u, p = model.x["x"], model.u["u"], model.tvp["p"]  # modified below
        cost = it.step(x, u, p[:len(it.varies)])[1]
        self.mpc = mpc = do_mpc.controller.MPC(model)
        mpc.settings.n_horizon, mpc.settings.t_step, mpc.settings.store_full_solution = it.N, 1.0, False
        mpc.settings.nlpsol_opts = options
        mpc.set_objective(mterm=0 * x[0], lterm=cost)
        mpc.set_rterm(u=0.0)
        mpc.bounds["lower", "_u", "u"], mpc.bounds["upper", "_u", "u"] = it.low, it.high
        template = mpc.get_tvp_template()
        for k in range(it.N + 1):
            if len(it.varies):
                template["_tvp", k, "p"] = it.numbers[min(k, it.N - 1)]
        mpc.set_tvp_fun(lambda now: template)
        mpc.setup()
        mpc.x0, mpc.u0 = it.start, np.zeros(it.nu)
        mpc.set_initial_guess()
        mpc.opt_p_num["_x0"], mpc.opt_p_num["_u_prev"] = it.start, np.zeros(it.nu)
        mpc.opt_p_num["_tvp"] = template["_tvp"]

    def hand_over(self, start):
        mpc, it = self.mpc, self.intervals
        for k in range(it.N + 1):
            mpc.opt_x_num["_x", k, 0, -1] = self.guess[0][k]
            if k < it.N:
                mpc.opt_x_num["_u", k, 0] = self.guess[1][k]

    def run(self):
        self.mpc.solve()

    def read(self):
        mpc, it, found = self.mpc, self.intervals, self.mpc.opt_x_num
        states = np.array([np.array(found["_x", k, 0, -1]).ravel() for k in range(it.N + 1)])
        inputs = np.array([np.array(found["_u", k, 0]).ravel() for k in range(it.N)])
        return self.answer(states, inputs, mpc.solver_stats)


class Rockit(_FrontEnd):
    name, package, module = "rockit", "rockit-meco", "rockit"
    about = "a front end: its program from our discretisation as a discrete system; CasADi's Ipopt, functions in CasADi's virtual machine"

    def build(self, options):
        import rockit
        it = self.intervals
        self.ocp = ocp = rockit.Ocp(t0=0.0, T=float(it.N))
        self.x, self.u = ocp.state(it.nx), ocp.control(it.nu)
        p = ocp.parameter(len(it.varies), grid="control") if len(it.varies) else np.zeros(0)
        following, cost = it.step(self.x, self.u, p)
        ocp.set_next(self.x, following)
        ocp.add_objective(ocp.sum(cost))
        ocp.subject_to(ocp.at_t0(self.x) == it.start)
        for i in range(it.nu):
            if np.isfinite(it.low[i]) or np.isfinite(it.high[i]):
                ocp.subject_to((float(it.low[i]) <= self.u[i]) <= float(it.high[i]))
        if len(it.varies):
            ocp.set_value(p, it.numbers.T)
        ocp.solver("ipopt", {**options, "expand": True})
        ocp.method(rockit.MultipleShooting(N=it.N))
        ocp.set_initial(self.x, self.guess[0].T)  # the solver keeps state, so each timed solve is the first one
        ocp.set_initial(self.u, self.guess[1].T)
        ocp._transcribe()  # takes seconds, which would count in the first solve

    def run(self):
        try:
            self.solution = self.ocp.solve_limited()
        except RuntimeError:
            self.solution = self.ocp.non_converged_solution

    def read(self):
        solution = self.solution
        states = np.reshape(solution.sample(self.x, grid="control")[1], (-1, self.intervals.nx))
        inputs = np.reshape(solution.sample(self.u, grid="control")[1], (-1, self.intervals.nu))[:-1]  # the last one occurs twice
        return self.answer(states, inputs, solution.stats)
