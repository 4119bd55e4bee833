"""Optimal control problems in continuous time (format `saltus-ocp 1`, benchmarks/formats.md) as nonlinear programs of the
format `saltus-nlp 1`, by Radau collocation of order 5 with inputs that are constant over each interval.

With points c_j of the interval k of length h = T/N, the states x_kj at the points satisfy
    sum_i D_ji x_ki = h f(t_kj, x_kj, z_kj, u_k, p),   i = 0: the start of the interval,
and the integral of L is the sum of h b_j L over all points. The last point is the start of the next interval.

With `is_shooting`, problems of one phase without parameters become x_k+1 = F(x_k, u_k) instead, one step of the classical
Runge-Kutta method of order 4 per interval. Given values at start and end are rows then.
"""

import ast
import math

import numpy as np

FORMAT = "saltus-ocp 1"
FUNCTIONS = {"abs": 1, "acos": 1, "asin": 1, "atan": 1, "atan2": 2, "cos": 1, "cosh": 1, "exp": 1, "log": 1, "max": 2,
             "min": 2, "sin": 1, "sinh": 1, "sqrt": 1, "tan": 1, "tanh": 1}
OPERATORS = {ast.Add: "add", ast.Sub: "subtract", ast.Mult: "multiply", ast.Div: "divide", ast.Pow: "pow"}
MOST_CHARACTERS, MOST_INTERVALS, MOST_DEPTH = 10_000, 20_000, 100
POINTS = np.array([(4.0 - math.sqrt(6.0)) / 10.0, (4.0 + math.sqrt(6.0)) / 10.0, 1.0])


def _collocation():
    """D (3 x 4, derivative at the points of the polynomial through 0 and the points) and the weights b."""
    nodes = np.array([0.0, *POINTS])
    D = np.zeros((3, 4))
    for i in range(4):
        others = np.delete(nodes, i)
        basis = np.poly1d(np.poly(others) / np.prod(nodes[i] - others))
        D[:, i] = basis.deriv()(POINTS)
    b = np.linalg.solve(np.vander(POINTS, increasing=True).T, 1.0 / np.arange(1, 4))
    return D, b


class Mistake(ValueError):
    """An invalid problem; the message is one sentence."""


class Steps:
    """A function of elementary steps under construction. Equal steps are shared."""

    def __init__(self, names):
        self.names, self.steps, self.known, self.outputs = names, [], {}, []
        self.places = {}  # names of steps

    def step(self, *step):
        if step not in self.known:
            self.known[step] = len(self.steps)
            self.steps.append(list(step))
        return self.known[step]

    def add(self, text, place):
        """The number of the step that computes an expression."""
        text = str(text)
        if len(text) > MOST_CHARACTERS:
            raise Mistake(f"{place}: an expression has at most {MOST_CHARACTERS} characters; introduce definitions")
        try:
            return self._of(ast.parse(text, mode="eval").body, place, 0)
        except SyntaxError as error:
            raise Mistake(f"{place}: '{text}' is not an expression: {error.msg}") from None
        except (RecursionError, MemoryError):
            raise Mistake(f"{place}: an expression is nested too deeply; introduce definitions") from None

    def _of(self, node, place, depth):
        if depth > MOST_DEPTH:
            raise RecursionError
        of = lambda n: self._of(n, place, depth + 1)  # noqa: E731
        if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
            return self.step("constant", float(node.value))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return self.step("negate", of(node.operand))
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            return self.step(OPERATORS[type(node.op)], of(node.left), of(node.right))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            name = node.func.id
            if name in ("initial", "final") and len(node.args) == 1:
                return self._named(f"{name}({ast.unparse(node.args[0])})", place)
            if FUNCTIONS.get(name) == len(node.args):
                return self.step(name, *map(of, node.args))
            raise Mistake(f"{place}: there is no function {name} of {len(node.args)} arguments; the functions are "
                          f"{', '.join(FUNCTIONS)}")
        if isinstance(node, ast.Name):
            return self._named(node.id, place)
        raise Mistake(f"{place}: '{ast.unparse(node)}' is not part of an expression; use numbers, names, + - * / **, functions")

    def _named(self, name, place):
        if name in self.places:
            return self.places[name]
        found = self.names.get(name)
        if found is None:
            raise Mistake(f"{place}: '{name}' is not defined; known here: {', '.join(list(self.names)[:12])}")
        if isinstance(found, int):
            return self.step("input", found)
        self.names = {**self.names, name: None}  # a definition may use earlier ones, not itself
        step = self.add(found, f"definition {name}")
        self.names = {**self.names, name: found}
        return step

    def function(self, inputs):
        return {"inputs": inputs, "steps": self.steps, "outputs": self.outputs}


def value_of(text, names, place):
    """The number of an expression of constants. Infinite values are absent bounds."""
    if text is None:
        return None
    steps = Steps(names)
    try:
        value = evaluate({"inputs": 0, "steps": steps.steps, "outputs": [steps.add(text, place)]}, [])[0]
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, Mistake):
            raise
        raise Mistake(f"{place}: '{text}' has no value: {error}") from None
    if not math.isfinite(value):
        raise Mistake(f"{place}: '{text}' is not finite; leave an absent bound out")
    return value


def evaluate(function, arguments):
    """The outputs of a function of steps at numbers."""
    known = {"add": lambda a, b: a + b, "subtract": lambda a, b: a - b, "multiply": lambda a, b: a * b,
             "divide": lambda a, b: a / b, "negate": lambda a: -a, "pow": math.pow, "abs": abs, "min": min, "max": max}
    values = []
    for operation, *rest in function["steps"]:
        if operation == "input":
            values.append(arguments[rest[0]])
        elif operation == "constant":
            values.append(rest[0])
        else:
            values.append((known.get(operation) or getattr(math, operation))(*(values[i] for i in rest)))
    return [values[i] for i in function["outputs"]]


class _Program:
    """The nonlinear program under construction."""

    def __init__(self, name):
        self.file = {"format": "saltus-nlp 1", "problem": name, "instance": 1, "variables": 0, "rows": 0, "start": [],
                     "lower": [], "upper": [], "row_lower": [], "row_upper": [], "functions": [], "blocks": [],
                     "linear": [], "variable_costs": [], "complementarity": [], "integer": []}

    def variable(self, lower, upper, start, is_integer=False):
        f = self.file
        for key, value in (("lower", lower), ("upper", upper), ("start", start)):
            f[key].append(value)
        if is_integer:
            f["integer"].append(f["variables"])
        f["variables"] += 1
        return f["variables"] - 1

    def row(self, lower, upper):
        f = self.file
        f["row_lower"].append(lower)
        f["row_upper"].append(upper)
        f["rows"] += 1
        return f["rows"] - 1

    def block(self, function, constants, variables, outputs):
        """A function of constants (by index) and variables (by index)."""
        count = self.file["functions"][function]["inputs"]
        self.file["blocks"].append({
            "function": function, "constants": [constants.get(i, 0.0) for i in range(count)],
            "coefficients": [[[variables[i], 1.0]] if i in variables else [] for i in range(count)], "outputs": outputs})

    def function(self, function):
        self.file["functions"].append(function)
        return len(self.file["functions"]) - 1


class _Phase:
    def __init__(self, problem, data, number):
        self.place = f"phase {data.get('name', number + 1)}"
        self.name = data.get("name", f"phase{number + 1}")
        self.data, self.problem = data, problem
        self.lists = {key: data.get(key, []) for key in ("states", "algebraic", "inputs")}
        for key, variables in self.lists.items():
            for v in variables:
                if not isinstance(v, dict) or "name" not in v:
                    raise Mistake(f"{self.place}: each entry of {key} needs a name")
        self.intervals = int(data.get("intervals", 50))
        if not 1 <= self.intervals <= MOST_INTERVALS:
            raise Mistake(f"{self.place}: intervals must be from 1 to {MOST_INTERVALS}")
        if len(data.get("dynamics", [])) != len(self.lists["states"]):
            raise Mistake(f"{self.place}: dynamics needs one expression per state ({len(self.lists['states'])}), "
                          f"not {len(data.get('dynamics', []))}")
        if len(data.get("equations", [])) != len(self.lists["algebraic"]):
            raise Mistake(f"{self.place}: equations needs one expression per algebraic variable "
                          f"({len(self.lists['algebraic'])}), not {len(data.get('equations', []))}")

    def point_function(self):
        """The function of x, z, u, p and the fraction of the phase: h f, the integrand, equations, path and pairs."""
        names = [v["name"] for key in ("states", "algebraic", "inputs") for v in self.lists[key]]
        names += [p["name"] for p in self.problem.parameters]
        index = {}
        for i, name in enumerate([*names, "fraction of the phase"]):
            if name in index or name in self.problem.definitions:
                raise Mistake(f"{self.place}: the name '{name}' is defined twice")
            index[name] = i
        steps = Steps({**self.problem.definitions, **index})
        begin, end = (steps.add(t, f"{self.place}, time") for t in self.problem.times[self.name])
        length = steps.step("subtract", end, begin)
        fraction = steps.step("input", index["fraction of the phase"])
        steps.places["t"] = steps.step("add", begin, steps.step("multiply", fraction, length))

        def all_of(key, factor=None):
            for i, text in enumerate(self.data.get(key, [])):
                step = steps.add(text["expression"] if isinstance(text, dict) else text, f"{self.place}, {key}[{i}]")
                steps.outputs.append(step if factor is None else steps.step("multiply", factor, step))
        all_of("dynamics", length)
        steps.outputs.append(steps.step("multiply", length, steps.add(self.data.get("integral", 0), f"{self.place}, integral")))
        all_of("equations")
        all_of("path")
        for i, pair in enumerate(self.data.get("complementarity", [])):
            steps.outputs += [steps.add(text, f"{self.place}, complementarity[{i}]") for text in pair]
        return steps.function(len(index))

    def step_function(self):
        """The function (x, u, elapsed fraction of the phase) -> (next state, integral over the interval)."""
        names = [v["name"] for key in ("states", "inputs") for v in self.lists[key]]
        steps = Steps({**self.problem.definitions, **{name: i for i, name in enumerate(names)}})
        begin, end = (steps.add(t, f"{self.place}, time") for t in self.problem.times[self.name])
        length = steps.step("subtract", end, begin)

        def times(factor, a):
            return steps.step("multiply", steps.step("constant", factor), a)

        def rates(x, part):
            """h f and h L at this fraction of the interval."""
            fraction = steps.step("add", steps.step("input", len(names)), steps.step("constant", part / self.intervals))
            steps.places = dict(zip(names, x))
            steps.places["t"] = steps.step("add", begin, steps.step("multiply", fraction, length))
            found = [steps.add(text, f"{self.place}, dynamics[{i}]") for i, text in enumerate(self.data["dynamics"])]
            found.append(steps.add(self.data.get("integral", 0), f"{self.place}, integral"))
            return [times(1.0 / self.intervals, steps.step("multiply", length, one)) for one in found]

        def plus(x, factor, rate):
            return [steps.step("add", a, times(factor, b)) for a, b in zip(x, rate)]
        x = [steps.step("input", i) for i in range(len(self.lists["states"]))]
        total = [steps.step("constant", 0.0)] * (len(x) + 1)
        rate = rates(x, 0.0)
        for weight, factor, part in ((1.0, 0.5, 0.5), (2.0, 0.5, 0.5), (2.0, 1.0, 1.0), (1.0, None, None)):
            total = plus(total, weight / 6.0, rate)
            if factor is not None:
                rate = rates(plus(x, factor, rate), part)
        steps.outputs = [*(steps.step("add", a, b) for a, b in zip(x, total)), total[-1]]
        return steps.function(len(names) + 1)

    def bounds(self, variable, key):
        return self.problem.number(variable.get(key), f"{self.place}, {variable['name']}, {key}")

    def guess(self, variable, s):
        """Linear between two values, or one value; by default what the bounds suggest."""
        given = variable.get("guess", [variable.get("start", variable.get("end")), variable.get("end", variable.get("start"))])
        pair = given if isinstance(given, list) else [given, given]
        a, b = (self.problem.number(v, f"{self.place}, {variable['name']}, guess") or 0.0 for v in pair)
        low, high = self.bounds(variable, "lower"), self.bounds(variable, "upper")
        value = (1.0 - s) * a + s * b
        return min(max(value, -math.inf if low is None else low), math.inf if high is None else high)


class ControlProblem:
    """Reads and validates the problem. program() transcribes it."""

    def __init__(self, data):
        if data.get("format") != FORMAT:
            raise Mistake(f"an optimal control problem has the format '{FORMAT}', not '{data.get('format')}'")
        self.data = data
        self.definitions = {}
        for name, text in data.get("definitions", {}).items():
            if not name.isidentifier() or name in FUNCTIONS or name in ("t", "initial", "final"):
                raise Mistake(f"definitions: '{name}' is not a name or has another meaning; choose another")
            self.definitions[name] = str(text)
        self.parameters = data.get("parameters", [])
        if not data.get("phases"):
            raise Mistake("a problem needs at least one phase")
        self.times = {}
        self.phases = [_Phase(self, phase, i) for i, phase in enumerate(data["phases"])]
        for phase in self.phases:
            time = phase.data.get("time")
            if not isinstance(time, list) or len(time) != 2:
                raise Mistake(f"{phase.place}: time must be a list of begin and end")
            if phase.name in self.times:
                raise Mistake(f"{phase.place}: two phases have this name")
            self.times[phase.name] = time
        if "objective" not in data and not any("integral" in phase.data for phase in self.phases):
            raise Mistake("a problem needs an objective or an integral in a phase")

    def number(self, text, place):
        return value_of(text, self.definitions, place)

    def is_for_shooting(self):
        """True if the problem is one phase of given length without algebraic variables, path constraints or complementarity."""
        others = ("algebraic", "path", "complementarity")
        return len(self.phases) == 1 and not self.parameters and not any(self.phases[0].data.get(key) for key in others)

    def program(self, is_shooting=False):
        out = _Program(self.data.get("problem", ""))
        p = [out.variable(*(self.number(v.get(key), f"parameter {v['name']}, {key}") for key in ("lower", "upper")),
                          self.number(v.get("guess", 0.0), f"parameter {v['name']}, guess"), v.get("integer", False))
             for v in self.parameters]
        ends = {v["name"]: p[i] for i, v in enumerate(self.parameters)}
        for phase in self.phases:
            if is_shooting:
                self._shoot(out, phase, ends)
            else:
                self._transcribe(out, phase, p, ends)
        objective = self.data.get("objective")
        if objective is not None:
            self._at_ends(out, objective, "objective", ends, -1)
        for i, condition in enumerate(self.data.get("conditions", [])):
            place = f"conditions[{i}]"
            low, high = (self.number(condition.get(key), place) for key in ("lower", "upper"))
            self._at_ends(out, condition["expression"], place, ends, out.row(low, high))
        return out.file

    def _at_ends(self, out, text, place, ends, row):
        steps = Steps({**self.definitions, **{name: i for i, name in enumerate(ends)}})
        steps.outputs.append(steps.add(text, place))
        used = sorted({step[1] for step in steps.steps if step[0] == "input"})
        for step in steps.steps:
            if step[0] == "input":
                step[1] = used.index(step[1])
        variables = list(ends.values())
        out.block(out.function(steps.function(len(used))), {}, {i: variables[k] for i, k in enumerate(used)}, [[row, 1.0]])

    def _shoot(self, out, phase, ends):
        if not self.is_for_shooting():
            raise Mistake("shooting needs one phase without parameters, algebraic variables, path constraints and complementarity")
        states, inputs, N = phase.lists["states"], phase.lists["inputs"], phase.intervals
        function = out.function(phase.step_function())

        def add(variable, s):
            return out.variable(*(phase.bounds(variable, key) for key in ("lower", "upper")), phase.guess(variable, s),
                                variable.get("integer", False))

        def give(key, variables):
            for state, v in zip(states, variables):
                if key in state:
                    value = phase.bounds(state, key)
                    out.file["linear"].append([out.row(value, value), v, 1.0])
        x = first = [add(v, 0.0) for v in states]
        give("start", first)
        u_first = None
        for k in range(N):
            u = [add(v, (k + 0.5) / N) for v in inputs]
            u_first, arguments = u_first or u, [*x, *u]
            x = [add(v, (k + 1) / N) for v in states]
            rows = [out.row(0.0, 0.0) for _ in x]
            out.file["linear"] += [[row, v, -1.0] for row, v in zip(rows, x)]
            out.block(function, {len(arguments): k / N}, dict(enumerate(arguments)), [*([row, 1.0] for row in rows), [-1, 1.0]])
        give("end", x)
        for which, variables in (("initial", [*first, *u_first]), ("final", [*x, *u])):
            ends.update({f"{which}({v['name']})": place for v, place in zip((*states, *inputs), variables)})

    def _transcribe(self, out, phase, p, ends):
        states, algebraic, inputs = (phase.lists[key] for key in ("states", "algebraic", "inputs"))
        N, D, b = phase.intervals, *_collocation()
        function = out.function(phase.point_function())

        def add(variable, s, is_end=False, is_start=False):
            low, high = (phase.bounds(variable, key) for key in ("lower", "upper"))
            for is_here, key in ((is_start, "start"), (is_end, "end")):
                if is_here and key in variable:
                    low = high = phase.bounds(variable, key)
            guess = phase.guess(variable, s)
            return out.variable(low, high, low if low is not None and low == high else guess, variable.get("integer", False))
        nx, nz = len(states), len(algebraic)
        x = first = [add(v, 0.0, is_start=True) for v in states]
        u_first = None
        for k in range(N):
            u = [add(v, (k + 0.5) / N) for v in inputs]
            u_first = u_first or u
            points, before = [], x
            for c in POINTS:
                s = (k + c) / N
                is_end = k == N - 1 and c == 1.0
                points.append(([add(v, s, is_end) for v in states], [add(v, s) for v in algebraic]))
            for j, (xj, zj) in enumerate(points):
                outputs = []
                for i in range(nx):
                    row = out.row(0.0, 0.0)
                    out.file["linear"] += [[row, v[i], float(D[j, m])] for m, v in enumerate([before] + [q for q, _ in points])
                                           if D[j, m] != 0.0]
                    outputs.append([row, -1.0 / N])
                outputs.append([-1, float(b[j]) / N])
                outputs += [[out.row(0.0, 0.0), 1.0] for _ in range(nz)]
                for i, path in enumerate(phase.data.get("path", [])):
                    low, high = (self.number(path.get(key), f"{phase.place}, path[{i}]") for key in ("lower", "upper"))
                    outputs.append([out.row(low, high), 1.0])
                for _ in phase.data.get("complementarity", []):
                    pair = [out.row(0.0, None), out.row(0.0, None)]
                    out.file["complementarity"].append(pair)
                    outputs += [[row, 1.0] for row in pair]
                arguments = [*xj, *zj, *u, *p]
                out.block(function, {len(arguments): float((k + POINTS[j]) / N)}, dict(enumerate(arguments)), outputs)
            x = points[-1][0]
        names = [v["name"] for v in (*states, *inputs)]
        for which, variables in (("initial", [*first, *u_first]), ("final", [*x, *u])):
            for name, variable in zip(names, variables):
                ends[f"{which}({phase.name}.{name})"] = variable
                if len(self.phases) == 1:
                    ends[f"{which}({name})"] = variable
