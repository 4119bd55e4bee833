"""The peers: third-party solvers, each behind an adapter that calls it in the way that is fairest to it.

An adapter is a class with these members:
    name; package: its name in PyPI, whose version is reported; about: a remark for the table
    ladder: (1.0,) if it has no tolerance
    takes_start: False if it always uses its own start
    warm_levels(): kinds of warm start, if there are several; the attribute `level` selects one
    module: the imported module, if its name differs from that of the package
    takes_integers: True if it solves mixed-integer programs; takes_continuous: False if it solves no others
    takes_files: True for nonlinear programs that are data; `program` is then a NonlinearFile. takes_pairs: True if it also
        takes programs with complementarity, see nonlinear_judge.lifted()
    missing(): why it cannot be used, if this depends on more than the import of its package
    __init__(program, tolerance): the set-up, whose time is listed separately. Raises NotApplicable if the solver cannot
        solve the program and this is known in advance.
    hand_over(start), run(), read() -> Answer: one whole solve from `start`, (w, lambda, z) or None for the solver's own
        start. run() is the call of the solver and is timed. The others convert data and are recorded apart. An adapter may
        define solve(start) instead; then all of it is timed. Nothing that is left from the previous solve may help it.
README.md in the folder above describes the calls of each solver.
"""

import importlib.metadata
import os
import sys
import warnings
from dataclasses import dataclass

import numpy as np

from cache import not_installed
from quadratic_program import Reduced

ITERATIONS = 200
FIRST_ORDER_ITERATIONS = 20000
STEP = 0.1  # default of OSQP


class NotApplicable(Exception):
    """This solver does not support this program; the message is one sentence."""


@dataclass
class Answer:
    """The answer of a peer, with the signs of quadratic_program.py. own_us is the time of its own timer, or None."""
    w: np.ndarray
    row_multipliers: np.ndarray
    bound_multipliers: np.ndarray
    claimed: str
    solved: bool
    iterations: int
    own_us: float | None = None


class Adapter:
    """Base of the adapters."""
    needs = ("scipy.sparse",)

    def hand_over(self, start):
        self.start = start

    def run(self):
        raise NotImplementedError

    def read(self):
        raise NotImplementedError

    def solve(self, start):
        self.hand_over(start)
        self.run()
        return self.read()


class _Split:
    """Rows as equalities and two-sided inequalities, of the program without its fixed variables."""

    def __init__(self, qp):
        r = self.reduced = Reduced(qp)
        self.P, self.c = r.hessian, r.gradient
        self.A, self.b = r.jacobian[r.equal], r.row_lower[r.equal]
        self.G = r.jacobian[r.unequal]
        self.low, self.high = r.row_lower[r.unequal], r.row_upper[r.unequal]

    def rows(self, equalities, inequalities):
        r = self.reduced
        multipliers = np.zeros(r.jacobian.shape[0])
        multipliers[r.equal], multipliers[r.unequal] = equalities, inequalities
        return multipliers

    def expand(self, x, equalities, inequalities, bounds):
        return self.reduced.expand(x, self.rows(equalities, inequalities), bounds)


class Piqp(Adapter):
    name, package = "piqp", "piqp"
    about = "sparse LDL', interior point with proximal terms; no warm start, so cold in both columns"
    takes_start = False
    backend = "sparse_ldlt"

    def __init__(self, qp, tolerance):
        import piqp
        s = self.split = _Split(qp)
        self.solver = piqp.SparseSolver()
        settings = self.solver.settings
        settings.eps_abs, settings.eps_rel = tolerance, 0.0
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = tolerance, 0.0
        settings.compute_timings = True
        settings.max_iter = ITERATIONS
        settings.kkt_solver = getattr(piqp.KKTSolver, self.backend)
        if self.backend == "sparse_multistage" and not qp.stages:
            raise NotApplicable("it has no stages")
        r = s.reduced
        self.solver.setup(s.P, s.c, s.A, s.b, s.G, s.low, s.high, r.lower, r.upper)

    def run(self):
        self.status = self.solver.solve()

    def read(self):
        status, result, s = self.status, self.solver.result, self.split
        return Answer(*s.expand(result.x, result.y, result.z_u - result.z_l,
                                result.z_bu - result.z_bl),
                      claimed=str(status).split(".")[-1],
                      solved=str(status).upper().endswith("SOLVED"),
                      iterations=int(result.info.iter), own_us=1e6 * result.info.solve_time)


class PiqpMultistage(Piqp):
    name, backend = "piqp-multistage", "sparse_multistage"
    about = "piqp with its factorisation by stages; no warm start, so cold in both columns"


class Cones:
    """The program without its fixed variables as A x = b, G x <= h: sides of rows, then of variables."""

    def __init__(self, qp):
        import scipy.sparse as sparse
        s = self.split = _Split(qp)
        r = self.reduced = s.reduced
        self.P, self.c, self.A, self.b = s.P, s.c, s.A, s.b
        self.high, self.low = np.flatnonzero(np.isfinite(s.high)), np.flatnonzero(np.isfinite(s.low))
        self.x_high, self.x_low = np.flatnonzero(np.isfinite(r.upper)), np.flatnonzero(np.isfinite(r.lower))
        unit = sparse.identity(s.P.shape[0], format="csc")
        self.G = sparse.vstack([s.G[self.high], -s.G[self.low], unit[self.x_high], -unit[self.x_low]], format="csc")
        self.h = np.concatenate([s.high[self.high], -s.low[self.low], r.upper[self.x_high], -r.lower[self.x_low]])

    def expand(self, x, equalities, z):
        parts = np.split(z, np.cumsum([len(self.high), len(self.low), len(self.x_high)]))
        rows, bounds = np.zeros(len(self.split.low)), np.zeros(len(self.c))
        rows[self.high] += parts[0]
        rows[self.low] -= parts[1]
        bounds[self.x_high] += parts[2]
        bounds[self.x_low] -= parts[3]
        return self.split.expand(x, equalities, rows, bounds)

    def duals(self, rows, bounds):
        """(multipliers of A, of G) of a point of the program without its fixed variables."""
        r = self.reduced
        unequal = rows[r.unequal]
        return rows[r.equal], np.maximum(np.concatenate([unequal[self.high], -unequal[self.low], bounds[self.x_high],
                                                         -bounds[self.x_low]]), 0.0)


class Clarabel(Adapter):
    name, package = "clarabel", "clarabel"
    about = "interior point on the homogeneous embedding; no warm start, so cold in both columns"
    takes_start = False

    def __init__(self, qp, tolerance):
        import clarabel
        import scipy.sparse as sparse
        c = self.cones = Cones(qp)
        cones = [clarabel.ZeroConeT(len(c.b)), clarabel.NonnegativeConeT(len(c.h))]
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.max_iter = ITERATIONS
        settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = tolerance
        settings.max_threads = 1
        self.solver = clarabel.DefaultSolver(sparse.triu(c.P, format="csc"), c.c, sparse.vstack([c.A, c.G], format="csc"),
                                             np.concatenate([c.b, c.h]), cones, settings)

    def run(self):
        self.solution = self.solver.solve()

    def read(self):
        solution, z = self.solution, np.array(self.solution.z)
        equalities = len(self.cones.b)
        return Answer(*self.cones.expand(np.array(solution.x), z[:equalities], z[equalities:]), claimed=str(solution.status),
                      solved=str(solution.status) == "Solved", iterations=int(solution.iterations),
                      own_us=1e6 * solution.solve_time)


class _RowsAndBounds:
    """All rows and bounds as l <= A x <= u."""

    def __init__(self, qp):
        import scipy.sparse as sparse
        r = self.reduced = Reduced(qp)
        self.bounded = np.flatnonzero(np.isfinite(r.lower) | np.isfinite(r.upper))
        unit = sparse.identity(r.hessian.shape[0], format="csc")
        self.A = sparse.vstack([r.jacobian, unit[self.bounded]], format="csc")
        self.low = np.concatenate([r.row_lower, r.lower[self.bounded]])
        self.high = np.concatenate([r.row_upper, r.upper[self.bounded]])

    def expand(self, x, y):
        m = self.reduced.jacobian.shape[0]
        bounds = np.zeros(len(x))
        bounds[self.bounded] = y[m:]
        return self.reduced.expand(x, y[:m], bounds)

    def dual(self, rows, bounds):
        return np.concatenate([rows, bounds[self.bounded]])


class Osqp(Adapter):
    name, package = "osqp", "osqp"
    about = "ADMM with polishing"

    def __init__(self, qp, tolerance):
        import osqp
        import scipy.sparse as sparse
        p = self.rows = _RowsAndBounds(qp)
        self.solver = osqp.OSQP()
        # The step size is adapted after a number of iterations, not after a time, because times on a busy machine
        # would change the iterations.
        self.solver.setup(sparse.triu(p.reduced.hessian, format="csc"), p.reduced.gradient, p.A,
                          p.low, p.high, verbose=False, eps_abs=tolerance, eps_rel=0.0,
                          polishing=True, max_iter=FIRST_ORDER_ITERATIONS, rho=STEP,
                          adaptive_rho_interval=50)

    def hand_over(self, start):
        p, n = self.rows, len(self.rows.reduced.gradient)
        self.solver.update_settings(rho=STEP)  # it would keep the adapted values of the previous solve
        if start is None:
            self.solver.warm_start(x=np.zeros(n), y=np.zeros(len(p.low)))
        else:
            self.solver.warm_start(x=start[0], y=p.dual(start[1], start[2]))

    def run(self):
        self.result = self.solver.solve(raise_error=False)

    def read(self):
        p, result, info = self.rows, self.result, self.result.info
        x = np.array(result.x, dtype=float)
        y = np.array(result.y, dtype=float)
        return Answer(*p.expand(x, y), claimed=str(info.status), solved=info.status == "solved",
                      iterations=int(info.iter), own_us=1e6 * (info.solve_time + info.polish_time))


class Qpalm(Adapter):
    name, package = "qpalm", "qpalm"
    about = "proximal augmented Lagrangian with a semismooth Newton method; it runs in a separate thread"

    def __init__(self, qp, tolerance):
        import qpalm
        p = self.rows = _RowsAndBounds(qp)
        data = qpalm.Data(len(p.reduced.gradient), len(p.low))
        big = 1e20
        data.Q, data.q, data.A = p.reduced.hessian, p.reduced.gradient, p.A
        data.bmin, data.bmax = np.maximum(p.low, -big), np.minimum(p.high, big)
        settings = qpalm.Settings()
        settings.eps_abs, settings.eps_rel = tolerance, 0.0
        settings.eps_abs_in, settings.eps_rel_in = 1.0, 0.0
        settings.max_iter, settings.verbose = FIRST_ORDER_ITERATIONS, 0
        self.new_solver = lambda: qpalm.Solver(data, settings)

    def hand_over(self, start):
        p = self.rows
        x, y = (np.zeros(len(p.reduced.gradient)), np.zeros(len(p.low))) if start is None else (
            start[0], p.dual(start[1], start[2]))
        self.solver = self.new_solver()  # a used solver keeps its penalties
        self.solver.warm_start(x, y)

    def run(self):
        self.solver.solve()

    def read(self):
        p, info, found = self.rows, self.solver.info, self.solver.solution
        return Answer(*p.expand(np.array(found.x), np.array(found.y)), claimed=str(info.status),
                      solved=str(info.status) == "solved", iterations=int(info.iter),
                      own_us=1e6 * info.solve_time)


class Proxqp(Adapter):
    name, package = "proxqp", "proxsuite"
    about = "proximal augmented Lagrangian, sparse"

    def __init__(self, qp, tolerance):
        from proxsuite import proxqp
        import scipy.sparse as sparse
        self.proxqp = proxqp
        p = self.rows = _RowsAndBounds(qp)
        equal = self.equal = np.flatnonzero(p.low == p.high)
        unequal = self.unequal = np.flatnonzero(p.low < p.high)
        self.solver = proxqp.sparse.QP(len(p.reduced.gradient), len(equal), len(unequal))
        settings = self.solver.settings
        settings.eps_abs, settings.eps_rel = tolerance, 0.0
        settings.check_duality_gap = True
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = tolerance, 0.0
        settings.compute_timings = True
        # Its automatic choice uses MINRES for large programs, which then need minutes.
        settings.sparse_backend = proxqp.SparseBackend.SparseCholesky
        A = p.A.tocsr()
        big = 1e20
        self.solver.init(p.reduced.hessian, p.reduced.gradient, sparse.csc_matrix(A[equal]),
                         p.low[equal], sparse.csc_matrix(A[unequal]),
                         np.maximum(p.low[unequal], -big), np.minimum(p.high[unequal], big))

    def hand_over(self, start):
        guess, self.start = self.proxqp.InitialGuess, ()
        if start is None:
            self.solver.settings.initial_guess = guess.EQUALITY_CONSTRAINED_INITIAL_GUESS
        else:
            self.solver.settings.initial_guess = guess.WARM_START
            y = self.rows.dual(start[1], start[2])
            self.start = start[0], y[self.equal], y[self.unequal]

    def run(self):
        self.solver.solve(*self.start)

    def read(self):
        p, result = self.rows, self.solver.results
        y = np.zeros(len(p.low))
        y[self.equal], y[self.unequal] = result.y, result.z
        status = str(result.info.status).split(".")[-1]
        return Answer(*p.expand(np.array(result.x), y), claimed=status,
                      solved=status == "PROXQP_SOLVED", iterations=int(result.info.iter_ext),
                      own_us=result.info.solve_time)


class Daqp(Adapter):
    name, package = "daqp", "daqp"
    about = "dual active set, dense; set-up (with its factorisation) and solve are one call, and both are counted"
    largest = 1000

    def __init__(self, qp, tolerance):
        r = self.reduced = Reduced(qp)
        if len(r.gradient) > self.largest:
            raise NotApplicable(f"dense, and more than {self.largest} variables")
        self.H = np.ascontiguousarray(r.hessian.toarray())
        self.A = np.ascontiguousarray(r.jacobian.toarray())
        big = 1e30
        self.high = np.minimum(np.concatenate([r.upper, r.row_upper]), big)
        self.low = np.maximum(np.concatenate([r.lower, r.row_lower]), -big)
        self.sense = np.where(self.low == self.high, 5, 0).astype(np.int32)
        self.tolerance = tolerance

    def hand_over(self, start):
        import daqp
        self.call, self.more = daqp.solve, {}
        if start is not None:
            self.more = {"primal_start": np.ascontiguousarray(start[0]),
                         "dual_start": np.concatenate([start[2], start[1]])}

    def run(self):
        self.found = self.call(self.H, self.reduced.gradient, self.A, self.high, self.low, self.sense,
                               primal_tol=self.tolerance, dual_tol=self.tolerance, iter_limit=100000, **self.more)

    def read(self):
        x, _, flag, info = self.found
        n = len(self.reduced.gradient)
        multipliers = np.array(info["lam"], dtype=float)
        return Answer(*self.reduced.expand(np.array(x, dtype=float), multipliers[n:],
                                           multipliers[:n]),
                      claimed=f"exit flag {flag}", solved=flag == 1,
                      iterations=int(info["iterations"]),
                      own_us=1e6 * (info["setup_time"] + info["solve_time"]))


class _Casadi(Adapter):
    """A quadratic program through casadi's conic interface, with the compiled plug-ins of its package."""
    package = "casadi"
    plugin = ""
    fixed_start_as_bounds = True
    largest = 100000

    def options(self, qp, tolerance):
        return {}

    def __init__(self, qp, tolerance):
        import casadi
        if qp.n > self.largest:
            raise NotApplicable(f"more than {self.largest} variables")
        self.qp = qp
        hessian, jacobian = qp.hessian.csc(), qp.jacobian.csc()
        H, A = casadi.DM(hessian), casadi.DM(jacobian)
        options = {"error_on_fail": False, "print_time": False, "record_time": True}
        options.update(self.options(qp, tolerance))
        self.new_solver = lambda: casadi.conic("solver", self.plugin, {"h": H.sparsity(), "a": A.sparsity()},
                                               options)
        self.solver = self.new_solver()
        self.given = {"h": H, "g": casadi.DM(qp.gradient), "a": A, "lbx": casadi.DM(qp.lower),
                      "ubx": casadi.DM(qp.upper), "lba": casadi.DM(qp.row_lower),
                      "uba": casadi.DM(qp.row_upper)}

    def hand_over(self, start):
        import casadi
        self.now = dict(self.given)
        if start is not None:
            self.now |= {key: casadi.DM(part) for key, part in zip(("x0", "lam_a0", "lam_x0"), start)}

    def run(self):
        self.answer = self.solver(**self.now)

    def read(self):
        answer, stats = self.answer, self.solver.stats()
        own = stats.get("t_proc_solver", stats.get("t_wall_solver"))
        iterations = stats.get("iter_count", -1)
        return Answer(np.array(answer["x"]).ravel(), np.array(answer["lam_a"]).ravel(),
                      np.array(answer["lam_x"]).ravel(),
                      claimed=str(stats.get("return_status", stats.get("unified_return_status"))),
                      solved=bool(stats.get("success")), iterations=int(iterations or -1),
                      own_us=1e6 * own if own else None)


class CasadiHpipm(_Casadi):
    name, plugin = "casadi-hpipm", "hpipm"
    about = ("HPIPM of casadi's package, whose BLASFEO is generic: about 2.6 times slower than a build for this "
             "processor. Results must not be quoted as HPIPM without this note")

    def options(self, qp, tolerance):
        if not qp.stages:
            raise NotApplicable("it has no stages")
        # With the 1e8 of casadi for absent bounds, the complementarity of HPIPM never falls below its tolerance.
        return {"inf": 1e6, "N": len(qp.stages) - 1, "nx": [s[0] for s in qp.stages],
                "nu": [s[1] for s in qp.stages], "ng": [s[2] for s in qp.stages],
                "hpipm": {"mode": "speed", "iter_max": ITERATIONS, "res_g_max": tolerance,
                          "res_b_max": tolerance, "res_d_max": tolerance,
                          "res_m_max": tolerance}}


class CasadiQpoases(_Casadi):
    name, plugin, largest = "casadi-qpoases", "qpoases", 250
    ladder = (1.0,)
    about = "qpOASES of casadi's package on the uncondensed program: an active-set method, sparse Schur complements off"

    def options(self, qp, tolerance):
        return {"printLevel": "none", "nWSR": 20000, "sparse": False}

    def hand_over(self, start):
        self.solver = self.new_solver()  # a used solver starts from its optimum
        super().hand_over(start)


PLUG_INS = "saltus_bench"  # group of the entry points of packages that bring an adapter


def plug_ins(is_nonlinear=False):
    """Adapters of installed packages for quadratic programs, or those with `takes_files`, for nonlinear ones."""
    found = []
    for entry in importlib.metadata.entry_points(group=PLUG_INS):
        try:
            found.append(entry.load())
        except Exception as error:  # noqa: BLE001 - foreign code
            if not is_nonlinear:  # told once
                print(f"the adapter '{entry.name}' cannot be loaded and is left out: {type(error).__name__}: {error}",
                      file=sys.stderr)
    return [one for one in found if getattr(one, "takes_files", False) == is_nonlinear]


def all_peers():
    import aligator
    import fatrop
    import hpipm
    import mim
    from adapters.highs import Highs
    from adapters.qoco import Qoco
    from adapters.scip import Scip
    from adapters.scs import Scs
    return [Piqp, PiqpMultistage, Clarabel, Osqp, Qpalm, Proxqp, Daqp, Highs, Scip, Qoco, Scs, CasadiHpipm, fatrop.CasadiFatrop, hpipm.AcadosHpipm,
            hpipm.AcadosHpipmBalance, hpipm.OwnHpipm, hpipm.OwnHpipmBalance, CasadiQpoases, aligator.AligatorProxddp, mim.MimCsqp, mim.CrocoddylBoxFddp, *plug_ins()]


def version_of(package):
    """The version, or None if it is not installed."""
    import importlib.metadata
    for path in (sys.path, [os.path.join(sys.prefix, "acados")]):  # the second folder has conflicting packages
        for found in importlib.metadata.distributions(name=package, path=path):
            return found.version
    return None


def named_version(peer):
    """`casadi 3.8.2: `, or empty if it is not a package."""
    return f"{peer.package} {version_of(peer.package)}: " if peer.package else ""


def why_missing(peer):
    """An empty string if the peer can be used, otherwise one sentence. A package that fails at import is missing, too."""
    if hasattr(peer, "missing"):
        return peer.missing()
    if version_of(peer.package) is None:
        return not_installed(peer.package)
    try:
        with warnings.catch_warnings(action="ignore"):  # error of another installed package
            importlib.import_module(getattr(peer, "module", peer.package))
            for needed in getattr(peer, "needs", Adapter.needs):
                importlib.import_module(needed)
    except BaseException as error:  # noqa: BLE001 - whatever a foreign package throws
        return f"the package {peer.package} is broken at import: {type(error).__name__}: {error}"
    return ""
