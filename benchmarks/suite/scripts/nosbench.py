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
    return {"format": "saltus-nlp 1", "problem": name, "instance": 1, "variables": n, "rows": rows,
            "start": [float(v) for v in data["w0"]], "lower": sides(data["lbw"]), "upper": sides(data["ubw"]),
            "row_lower": sides(lower) + [0.0] * (2 * pairs), "row_upper": sides(upper) + [None] * (2 * pairs),
            "functions": [{"inputs": n + len(p), "steps": steps, "outputs": [*f, *g, *G, *H]}],
            "blocks": [{"function": 0, "constants": [0.0] * n + [float(v) for v in p],
                        "coefficients": [[[i, 1.0]] for i in range(n)] + [[] for _ in p],
                        "outputs": [[-1, 1.0]] + [[row, 1.0] for row in range(rows)]}],
            "linear": [], "variable_costs": [], "complementarity": [[m + i, m + pairs + i] for i in range(pairs)]}
