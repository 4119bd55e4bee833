"""Programs with complementarity constraints of NOSBENCH (JSON with functions of CasADi) as files of `saltus-nlp 1`:

    min f(w, p)   lbw <= w <= ubw,   lbg <= g(w, p) <= ubg,   0 <= G(w, p) perp H(w, p) >= 0,   p = p0.
"""

import math

KEYS = ("w0", "lbw", "ubw", "p0", "lbg", "ubg", "g_fun", "G_fun", "H_fun", "augmented_objective_fun")
BINARY = {"ADD": "add", "SUB": "subtract", "MUL": "multiply", "DIV": "divide", "POW": "pow", "CONSTPOW": "pow",
          "FMIN": "min", "FMAX": "max", "ATAN2": "atan2", "HYPOT": "hypot"}
UNARY = {"NEG": "negate", "SQRT": "sqrt", "SIN": "sin", "COS": "cos", "TAN": "tan", "ASIN": "asin", "ACOS": "acos",
         "ATAN": "atan", "SINH": "sinh", "COSH": "cosh", "TANH": "tanh", "EXP": "exp", "LOG": "log", "FABS": "abs"}


def is_nosbench(data):
    return all(key in data for key in KEYS)


def _steps(name, functions, n):
    """The outputs of several functions of (w, p) as one function of steps; p follows w."""
    import casadi as ca
    names = {getattr(ca, key): key[3:] for key in dir(ca) if key.startswith("OP_")}
    steps, outputs = [], []

    def add(*step):
        steps.append(list(step))
        return len(steps) - 1
    for text in functions:
        f = ca.Function.deserialize(text)
        work, found = {}, [add("constant", 0.0)] * f.nnz_out(0)
        if f.nnz_out(0) != f.numel_out(0):
            raise ValueError(f"'{name}': a function has sparse outputs, which are not supported")
        for k in range(f.n_instructions()):
            operation, out, into = names[f.instruction_id(k)], f.instruction_output(k), f.instruction_input(k)
            if operation == "INPUT":
                work[out[0]] = add("input", into[1] + (n if into[0] == 1 else 0))
            elif operation == "CONST":
                work[out[0]] = add("constant", f.instruction_constant(k))
            elif operation == "OUTPUT":
                found[out[1]] = work[into[0]]
            elif operation in BINARY:
                work[out[0]] = add(BINARY[operation], *(work[i] for i in into))
            elif operation in UNARY:
                work[out[0]] = add(UNARY[operation], work[into[0]])
            elif operation in ("SQ", "TWICE"):
                work[out[0]] = add("multiply" if operation == "SQ" else "add", work[into[0]], work[into[0]])
            elif operation == "INV":
                work[out[0]] = add("divide", add("constant", 1.0), work[into[0]])
            elif operation == "ASSIGN":
                work[out[0]] = work[into[0]]
            else:
                raise ValueError(f"'{name}': the operation {operation} of CasADi is not supported")
        outputs.append(found)
    return steps, outputs


def convert(name, data):
    """Raises ValueError with one sentence."""
    n, p = len(data["w0"]), data["p0"]
    p = p if isinstance(p, list) else [p]
    steps, (g, G, H, f) = _steps(name, [data[key] for key in ("g_fun", "G_fun", "H_fun", "augmented_objective_fun")], n)
    lower, upper = data["lbg"], data["ubg"]
    if len(lower) != len(g) or len(G) != len(H) or len(f) != 1:
        raise ValueError(f"'{name}': its functions and bounds differ in length")
    m, pairs = len(g), len(G)
    rows = m + 2 * pairs

    def sides(values):
        return [None if v is None or math.isinf(float(v)) else float(v) for v in values]
    parts = [(-1, sign, step) for sign, step in _terms(steps, f[0])] + [(row, 1.0, step) for row, step in enumerate((*g, *G, *H))]
    functions, blocks = _blocks(steps, parts, n, [float(v) for v in p])
    return {"format": "saltus-nlp 1", "problem": name, "instance": 1, "variables": n, "rows": rows,
            "start": [float(v) for v in data["w0"]], "lower": sides(data["lbw"]), "upper": sides(data["ubw"]),
            "row_lower": sides(lower) + [0.0] * (2 * pairs), "row_upper": sides(upper) + [None] * (2 * pairs),
            "functions": functions, "blocks": blocks, "linear": [], "variable_costs": [],
            "complementarity": [[m + i, m + pairs + i] for i in range(pairs)]}


def _terms(steps, step, sign=1.0):
    """The terms of a sum, with their signs."""
    found, left = [], [(step, sign)]
    while left:
        step, sign = left.pop()
        operation, *rest = steps[step]
        if operation in ("add", "subtract"):
            left += [(rest[0], sign), (rest[1], sign if operation == "add" else -sign)]
        elif operation == "negate":
            left.append((rest[0], -sign))
        else:
            found.append((sign, step))
    return found


def _blocks(steps, parts, n, p):
    """(functions, blocks) of the parts (row, factor, step). Each part becomes a function of the variables that it uses.
    Parts with the same steps and numbers share it."""
    functions, numbers, blocks = [], {}, []
    for row, factor, step in parts:
        needed, left = set(), [step]
        while left:
            s = left.pop()
            if s not in needed:
                needed.add(s)
                if steps[s][0] not in ("input", "constant"):
                    left += steps[s][1:]
        place, inside, arguments = {}, [], {}

        def argument(key):
            return arguments.setdefault(key, len(arguments))
        for s in sorted(needed):
            operation, *rest = steps[s]
            if operation == "input" and rest[0] < n:
                inside.append(("input", argument(rest[0])))
            elif operation in ("input", "constant"):
                inside.append(("constant", p[rest[0] - n] if operation == "input" else rest[0]))
            else:
                inside.append((operation, *(place[i] for i in rest)))
            place[s] = len(inside) - 1
        key = (tuple(inside), len(arguments))
        if key not in numbers:
            numbers[key] = len(functions)
            functions.append({"inputs": len(arguments), "steps": [list(s) for s in inside], "outputs": [place[step]]})
        blocks.append({"function": numbers[key], "constants": [0.0] * len(arguments),
                       "coefficients": [[[variable, 1.0]] for variable in arguments], "outputs": [[row, factor]]})
    return functions, blocks
