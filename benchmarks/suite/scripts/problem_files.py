"""Problems as data: reads every format that the suite knows, validates it, and says what it is (benchmarks/formats.md)."""

import json
import math
import os

import control_problem
import nosbench
import quadratic_files

QP, NLP, OCP = "saltus-qp 1", "saltus-nlp 1", control_problem.FORMAT
ENDINGS = (".json", *quadratic_files.READERS)
MOST_BYTES = 2 << 30
OPERATIONS = {"input": 1, "constant": 1, "negate": 1, "add": 2, "subtract": 2, "multiply": 2, "divide": 2, "pow": 2,
              "hypot": 2, "select": 3, **control_problem.FUNCTIONS}


class FileError(ValueError):
    """A file that cannot be used; the message is one sentence with place and remedy."""


def read(path, name=None):
    """The contents as a file of one of our formats."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in ENDINGS:
        raise FileError(f"'{path}' is not a problem; the suite reads {', '.join(ENDINGS)}")
    if os.path.getsize(path) > MOST_BYTES:
        raise FileError(f"'{path}' has more than {MOST_BYTES >> 30} GiB; split it")
    name = name or os.path.splitext(os.path.basename(path))[0]
    try:
        if ending != ".json":
            return quadratic_files.read(name, path)
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        if not isinstance(data, dict):
            raise FileError(f"'{path}' must contain an object with the key format")
        return nosbench.convert(name, data) if nosbench.is_nosbench(data) else data
    except FileError:
        raise
    except json.JSONDecodeError as error:
        raise FileError(f"'{path}' is not JSON: {error}") from None
    except (UnicodeDecodeError, RecursionError, EOFError) as error:
        raise FileError(f"'{path}' cannot be read: {error}") from None
    except (ValueError, TypeError, IndexError, KeyError) as error:
        text = str(error)
        raise FileError(text if path in text else f"'{path}' cannot be read: {text}") from None


def program_of(data, is_shooting=False):
    """A control problem as a nonlinear program; other programs are what they are."""
    if data.get("format") != OCP:
        return data
    program = control_problem.ControlProblem(data).program(is_shooting)
    return {**program, **{key: data[key] for key in ("optimum", "optimum_tolerance") if key in data}}


def kind_of(data):
    """The class, which follows from the contents."""
    if data["format"] == QP:
        return ("mixed-integer " if data.get("integer") else "") + "quadratic program" + (" in stages" if data["stages"] else "")
    if data["format"] == NLP:
        return ("complementarity program" if data.get("complementarity") else
                "mixed-integer nonlinear program" if data.get("integer") else "nonlinear program")
    phases = data["phases"]
    if any(phase.get("complementarity") for phase in phases):
        return "optimal control with complementarity"
    if any(v.get("integer") for phase in phases for v in phase.get("inputs", [])):
        return "switched optimal control"
    if any(phase.get("algebraic") for phase in phases):
        return "optimal control of a DAE"
    return "multi-phase optimal control" if len(phases) > 1 else "optimal control"


def sizes_of(data):
    program = program_of(data)
    text = f"{program['variables']} variables, {program['rows']} rows"
    if data["format"] == OCP:
        text += f", {sum(int(phase.get('intervals', 50)) for phase in data['phases'])} intervals"
    elif data.get("stages"):
        text += f", {len(data['stages'])} stages"
    pairs = len(program.get("complementarity", []))
    return text + (f", {pairs} complementarity pairs" if pairs else "")


def validate(data, path):
    """Raises FileError with the first mistake."""
    def wrong(sentence):
        return FileError(f"'{path}': {sentence}")
    known = data.get("format")
    if known not in (QP, NLP, OCP):
        raise wrong(f"the format is '{known}', not one of {QP}, {NLP}, {OCP}")
    for key in ("problem", "about", "licence", "source", "optimum_source", "optimum_of"):
        if not isinstance(data.get(key, ""), str):
            raise wrong(f"'{key}' must be a text")
    for key in ("optimum", "optimum_tolerance"):
        if data.get(key) is not None and not _is_number(data[key]):
            raise wrong(f"'{key}' must be a number")
    try:
        program = program_of(data)
        _sides(program)
        (_quadratic if known == QP else _nonlinear)(program)
    except KeyError as error:
        raise wrong(f"the key {error} is missing") from None
    except (ValueError, TypeError, IndexError, AttributeError) as error:
        raise wrong(str(error)) from None


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _sides(program):
    n, m = program["variables"], program["rows"]
    if not all(isinstance(v, int) and v >= 0 for v in (n, m)):
        raise ValueError("variables and rows must be numbers from 0")
    for low, high, count in (("lower", "upper", n), ("row_lower", "row_upper", m)):
        for key in (low, high):
            if len(program[key]) != count:
                raise ValueError(f"'{key}' must have {count} entries, not {len(program[key])}")
            for i, value in enumerate(program[key]):
                if value is not None and not _is_number(value):
                    raise ValueError(f"'{key}[{i}]' must be a number, or null for an absent side")
        for i, (a, b) in enumerate(zip(program[low], program[high])):
            if a is not None and b is not None and a > b:
                raise ValueError(f"'{low}[{i}]' is above '{high}[{i}]'")
    for i in program.get("integer", []):
        if not isinstance(i, int) or not 0 <= i < n:
            raise ValueError(f"'integer' names the variable {i}, which does not exist")


def _quadratic(program):
    n, m = program["variables"], program["rows"]
    _numbers("gradient", program["gradient"], n)
    if not _is_number(program["constant"]):
        raise ValueError("'constant' must be a number")
    for key, rows in (("hessian", n), ("jacobian", m)):
        row, col, value = (program[key][part] for part in ("row", "col", "value"))
        if not len(row) == len(col) == len(value):
            raise ValueError(f"row, col and value of '{key}' differ in length")
        _numbers(f"{key}.value", value, len(value))
        for e, (i, j) in enumerate(zip(row, col)):
            if not (0 <= i < rows and 0 <= j < n):
                raise ValueError(f"entry {e} of '{key}' is outside the matrix")
            if key == "hessian" and i < j:
                raise ValueError(f"entry {e} of 'hessian' is above the diagonal; give the lower triangle")
    stages = program["stages"]
    if stages and sum(nx + nu for nx, nu, _ in stages) != n:
        raise ValueError(f"'stages' have {sum(nx + nu for nx, nu, _ in stages)} variables, not {n}")
    if stages and sum(rows for *_, rows in stages) + sum(nx for nx, *_ in stages[1:]) != m:
        raise ValueError(f"'stages' have {sum(rows for *_, rows in stages) + sum(nx for nx, *_ in stages[1:])} rows, not {m}")


def _numbers(key, values, count):
    if len(values) != count:
        raise ValueError(f"'{key}' must have {count} entries, not {len(values)}")
    for i, value in enumerate(values):
        if not _is_number(value):
            raise ValueError(f"'{key}[{i}]' must be a number")


def _nonlinear(program):
    n, m = program["variables"], program["rows"]
    _numbers("start", program["start"], n)
    functions = program["functions"]
    for f, function in enumerate(functions):
        for s, (operation, *rest) in enumerate(function["steps"]):
            if OPERATIONS.get(operation) != len(rest):
                raise ValueError(f"step {s} of function {f}: there is no operation '{operation}' of {len(rest)} arguments")
            if operation == "input" and not 0 <= rest[0] < function["inputs"]:
                raise ValueError(f"step {s} of function {f}: there is no input {rest[0]}")
            if operation not in ("input", "constant") and not all(0 <= i < s for i in rest):
                raise ValueError(f"step {s} of function {f} uses a later step; a step may use earlier ones")
            if operation == "constant" and not _is_number(rest[0]):
                raise ValueError(f"step {s} of function {f}: a constant must be a number")
        for o in function["outputs"]:
            if not 0 <= o < len(function["steps"]):
                raise ValueError(f"function {f}: there is no step {o} for an output")
    for b, block in enumerate(program["blocks"]):
        if not 0 <= block["function"] < len(functions):
            raise ValueError(f"block {b}: there is no function {block['function']}")
        function = functions[block["function"]]
        _numbers(f"blocks[{b}].constants", block["constants"], function["inputs"])
        if len(block["coefficients"]) != function["inputs"] or len(block["outputs"]) != len(function["outputs"]):
            raise ValueError(f"block {b} needs one entry of coefficients per input and one of outputs per output")
        for variable, _ in (pair for pairs in block["coefficients"] for pair in pairs):
            if not 0 <= variable < n:
                raise ValueError(f"block {b}: there is no variable {variable}")
        for row, _ in block["outputs"]:
            if not -1 <= row < m:
                raise ValueError(f"block {b}: there is no row {row}")
    for row, variable, _ in program["linear"]:
        if not (0 <= row < m and 0 <= variable < n):
            raise ValueError(f"'linear': there is no row {row} or no variable {variable}")
    for a, b in program.get("complementarity", []):
        if not (0 <= a < m and 0 <= b < m and program["row_lower"][a] == program["row_lower"][b] == 0.0):
            raise ValueError(f"'complementarity': the pair {a}, {b} must be two rows with lower side 0")


def found_in(paths):
    """The problem files in folders, sorted, and files as given."""
    files = []
    for path in paths:
        if os.path.isdir(path):
            files += [os.path.join(place, name) for place, _, names in sorted(os.walk(path)) for name in sorted(names)
                      if os.path.splitext(name)[1].lower() in ENDINGS and name != "listing.json"]
        else:
            files.append(path)
    return files


def check(paths, out, brief=False):
    """Validates files and folders. Returns the number of invalid ones; the last lines count the valid ones per class."""
    counts, invalid = {}, 0
    for path in found_in(paths):
        try:
            data = read(path)
            validate(data, path)
        except FileError as error:
            print(error, file=out)
            invalid += 1
            continue
        kind = kind_of(data)
        counts[kind] = counts.get(kind, 0) + 1
        if not brief:
            optimum = "" if data.get("optimum") is None else f", optimum {data['optimum']:.9g}"
            print(f"{path}: {kind}, {sizes_of(data)}{optimum}", file=out)
    for kind in sorted(counts):
        print(f"{counts[kind]:6} {kind}", file=out)
    print(f"{sum(counts.values()):6} valid, {invalid} invalid", file=out)
    return invalid
