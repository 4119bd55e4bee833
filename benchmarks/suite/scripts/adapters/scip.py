"""SCIP: branch and cut for mixed-integer programs, with convex quadratic costs.

The package pyscipopt contains SCIP with SoPlex and Ipopt. The rows are linear constraints with two sides. SCIP takes
linear costs only, so an additional variable bounds a quadratic cost from above. The feasibility tolerance is the requested
one. Both gaps are 0, so that SCIP proves optimality. It uses one thread, presolve and otherwise default settings. Each
solve starts from the original form of the model, without solutions of earlier solves. SCIP solves mixed-integer programs
only, because it returns no multipliers of quadratic programs.
"""

import numpy as np

from peers import Adapter, Answer, NotApplicable


class Scip(Adapter):
    name, package, module = "scip", "pyscipopt", "pyscipopt"
    about = "SCIP, branch and cut with SoPlex; takes no starting point"
    needs = ()
    takes_start, takes_integers, takes_continuous = False, True, False

    def __init__(self, qp, tolerance):
        import pyscipopt
        if not len(qp.integer):
            raise NotApplicable("it returns no multipliers, so it is used for mixed-integer programs only")
        self.qp = qp
        model = self.model = pyscipopt.Model()
        model.hideOutput()
        for name, value in (("numerics/feastol", tolerance), ("limits/gap", 0.0), ("limits/absgap", 0.0), ("limits/maxorigsol", 0),
                            ("parallel/maxnthreads", 1), ("lp/threads", 1)):
            model.setParam(name, value)
        integer = set(qp.integer.tolist())

        def side(value):
            return None if np.isinf(value) else float(value)
        self.x = [model.addVar(f"x{i}", vtype="I" if i in integer else "C", lb=side(qp.lower[i]), ub=side(qp.upper[i]))
                  for i in range(qp.n)]
        terms = [[] for _ in range(qp.m)]
        for i, j, value in zip(qp.jacobian.row, qp.jacobian.col, qp.jacobian.value):
            terms[i].append(float(value) * self.x[j])
        for of, low, high in zip(terms, qp.row_lower, qp.row_upper):
            row, sides = pyscipopt.quicksum(of), [side(low), side(high)]
            if low == high:
                model.addCons(row == sides[0])
            elif sides[1] is None and sides[0] is not None:
                model.addCons(row >= sides[0])
            elif sides[1] is not None:
                added = model.addCons(row <= sides[1])
                if sides[0] is not None:
                    model.chgLhs(added, sides[0])
        cost = pyscipopt.quicksum(float(g) * x for g, x in zip(qp.gradient, self.x) if g)
        square = [0.5 * float(value) * self.x[i] * self.x[j]
                  for i, j, value in zip(qp.hessian.row, qp.hessian.col, qp.hessian.value) if value]
        if square:
            bound = model.addVar("cost", lb=None)
            model.addCons(pyscipopt.quicksum(square) <= bound)
            cost += bound
        model.setObjective(cost, "minimize")

    def hand_over(self, start):
        self.model.freeTransform()

    def run(self):
        self.model.optimize()

    def read(self):
        model, qp, status = self.model, self.qp, self.model.getStatus()
        w = np.full(qp.n, np.nan)
        if model.getNSols():
            best = model.getBestSol()
            w = np.array([best[x] for x in self.x])
        return Answer(w, np.zeros(qp.m), np.zeros(qp.n), claimed=status, solved=status == "optimal", iterations=int(model.getNTotalNodes()),
                      own_us=1e6 * model.getSolvingTime())
