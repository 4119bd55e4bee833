"""The peers on nonlinear programs, all through CasADi on the same discretisation (nonlinear_program.py).

An adapter is a class as in peers.py; `program` is a NonlinearFile, and solve() starts at its guess.
"""

import hashlib
import math
import os
import shutil
import tempfile

import numpy as np

from cache import cache_folder
from nonlinear_program import CasadiProgram
from peers import Adapter, Answer, NotApplicable, plug_ins

ITERATIONS = 1000
PRODUCTS = [10.0 ** -k for k in range(10)]  # bounds of the products of complementarity pairs
# For larger sources gcc -O3 takes up to twenty minutes (pendulum_on_cart: 110 stages of Runge-Kutta in one function).
LARGE_SOURCE = 1_000_000
# Functions that the plug-ins expect in a library of compiled functions.
FOR_IPOPT = ("nlp", "nlp_f", "nlp_g", "nlp_grad_f", "nlp_jac_g", "triangle")
FOR_SQPMETHOD = ("nlp", "nlp_fg", "nlp_jac_fg", "whole")


def compiled(program, names, functions=None):
    """The path of the shared library with the functions of a CasadiProgram, or with replacements."""
    if shutil.which("gcc") is None:
        raise NotApplicable("gcc is needed to compile CasADi's functions")
    with tempfile.TemporaryDirectory(prefix="saltus-casadi-") as folder:
        source = program.write_source(folder, names, functions)
        flags = ["-O1" if os.path.getsize(source) > LARGE_SOURCE else "-O3", "-march=native"]
        with open(source, "rb") as file:
            key = hashlib.sha256(file.read() + " ".join(flags).encode()).hexdigest()[:24]
        library = os.path.join(cache_folder("casadi"), key + ".so")
        if not os.path.exists(library):
            program.compile(source, os.path.join(folder, "nlp.so"), flags)
            shutil.copy(os.path.join(folder, "nlp.so"), library + f".{os.getpid()}")
            os.replace(library + f".{os.getpid()}", library)
    return library


class CasadiNlp(Adapter):
    """nlpsol on our program, from its guess."""
    package = "casadi"
    plugin, is_compiled, compiles = "", False, FOR_IPOPT
    largest = 100000
    takes_files, takes_pairs = True, False  # programs that are data; with complementarity

    def options(self, tolerance):
        return {}

    def derivatives(self, functions):
        return {}

    def prepare(self, program):
        """The functions to compile, by name."""
        return program.functions

    def row_multipliers(self, found):
        return found

    def __init__(self, file, tolerance):
        if file.n > self.largest:
            raise NotApplicable(f"more than {self.largest} variables")
        if file.pairs and not self.takes_pairs:
            raise NotApplicable("it does not reduce the products of complementarity pairs")
        self.file, self.iterations = file, 0
        # Built once per program, for all solvers and tolerances.
        if getattr(file, "casadi", None) is None:
            file.casadi = CasadiProgram(file)
            difference, what = file.casadi.disagreement()
            if difference == math.inf:
                file.casadi = CasadiProgram(file, is_safe=True)
                difference, what = file.casadi.disagreement()
            if not difference <= 1e-9:  # rounding, relative to the largest entry
                raise NotApplicable(f"its {what} differs from ours by {difference:.1e}, so it is a different problem")
        self.build(file.casadi.functions, tolerance)

    def build(self, functions, tolerance):
        import casadi
        file = self.file
        options = {"print_time": False, "error_on_fail": False, "record_time": True, "no_nlp_grad": True,
                   **self.options(tolerance)}
        if self.is_compiled:
            self.solver = casadi.nlpsol("solver", self.plugin, compiled(
                file.casadi, self.compiles, self.prepare(file.casadi)), options)
        else:
            self.solver = casadi.nlpsol("solver", self.plugin, functions["nlp"],
                                        {**options, **self.derivatives(functions)})
        self.given = {"x0": casadi.DM(file.start), "lbx": casadi.DM(file.lower), "ubx": casadi.DM(file.upper),
                      "lbg": casadi.DM(file.row_lower), "ubg": casadi.DM(file.row_upper)}

    def run(self):
        self.iterations = 0
        if self.file.pairs:
            self._reduce_products()
        else:
            self.answer = self.solver(**self.given)

    def _reduce_products(self):
        """As our solvers do it, see NonlinearFile::solve."""
        first, second, product = np.array(self.file.pairs, dtype=int).T
        upper, row_upper, x = self.file.upper.copy(), self.file.row_upper.copy(), self.file.start
        for largest in (*PRODUCTS, math.inf):
            row_upper[product] = largest
            if largest == math.inf:  # the smaller variable of each pair stays 0
                upper[np.where(x[first] <= x[second], first, second)] = 0.0
            self.answer = self.solver(**{**self.given, "x0": x, "ubx": upper, "ubg": row_upper})
            self.iterations += max(0, int(self.solver.stats().get("iter_count", 0)))
            found = np.array(self.answer["x"]).ravel()
            x = found if np.isfinite(found).all() else x

    def read(self):
        answer, stats = self.answer, self.solver.stats()
        return Answer(np.array(answer["x"]).ravel(), self.row_multipliers(np.array(answer["lam_g"]).ravel()),
                      np.array(answer["lam_x"]).ravel(), claimed=str(stats.get("return_status", "")),
                      solved=bool(stats.get("success")), iterations=self.iterations or int(stats.get("iter_count", -1)))


class CasadiIpopt(CasadiNlp):
    name, plugin, takes_pairs = "casadi-ipopt", "ipopt", True
    about = "Ipopt with MUMPS of casadi's package, functions in CasADi's virtual machine"

    def options(self, tolerance):  # as in our interface to Ipopt
        return {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": tolerance,
                "ipopt.dual_inf_tol": 1e3 * tolerance, "ipopt.compl_inf_tol": 1e3 * tolerance,
                "ipopt.constr_viol_tol": min(1e-4, tolerance), "ipopt.max_iter": ITERATIONS,
                "ipopt.bound_relax_factor": 0.0}

    def derivatives(self, functions):
        return {"grad_f": functions["nlp_grad_f"], "jac_g": functions["nlp_jac_g"],
                "hess_lag": functions["triangle"]}


class CasadiIpoptCompiled(CasadiIpopt):
    name, is_compiled = "casadi-ipopt-compiled", True
    about = "Ipopt with MUMPS of casadi's package, functions as C compiled by gcc for the processor; compile time is not counted"


class CasadiSqpmethod(CasadiNlp):
    name, plugin, is_compiled, compiles = "casadi-sqpmethod", "sqpmethod", True, FOR_SQPMETHOD
    about = "CasADi's sequential quadratic programming, exact Hessian made convex, QRQP for the programs, compiled functions"
    largest = 300

    def options(self, tolerance):
        return {"qpsol": "qrqp", "print_header": False, "print_iteration": False, "print_status": False,
                "tol_pr": tolerance, "tol_du": tolerance, "max_iter": 100, "convexify_strategy": "regularize",
                "qpsol_options": {"print_iter": False, "print_header": False, "print_info": False,
                                  "error_on_fail": False}}


class CasadiBlocksqp(CasadiNlp):
    name, plugin = "casadi-blocksqp", "blocksqp"
    about = ("blockSQP of casadi's package with dense programs for qpOASES (its sparse ones need MA27, which is "
             "missing), functions in "
             "CasADi's virtual machine")
    largest = 200

    def options(self, tolerance):
        return {"schur": False, "linsol": "ldl", "opttol": tolerance, "nlinfeastol": tolerance, "max_iter": 200,
                "print_header": False, "print_iteration": False}

    def run(self):
        self.error = None
        try:
            super().run()
        except RuntimeError as error:  # its message if it fails
            self.error = str(error)

    def read(self):
        if self.error is None:
            return super().read()
        return Answer(self.file.start, np.zeros(self.file.m), np.zeros(self.file.n), claimed=self.error[-80:], solved=False,
                      iterations=-1)


def nonlinear_peers():
    from adapters.acados import AcadosSqp
    from adapters.uno import UnoFilterSqp, UnoIpopt
    from fatrop import CasadiFatropNonlinear
    from front_ends import DoMpc, Rockit
    return [CasadiIpoptCompiled, CasadiIpopt, CasadiFatropNonlinear, AcadosSqp, CasadiSqpmethod, CasadiBlocksqp, UnoFilterSqp,
            UnoIpopt, DoMpc, Rockit, *plug_ins(is_nonlinear=True)]
