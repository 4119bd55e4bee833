#!/usr/bin/env python3
"""Writes python/saltus/_core.pyi, the type stubs of the extension, from its signatures and docstrings.

Usage: make_stubs.py BUILD [--print], with the folder python of the build. --print only prints them.
"""

import inspect
import operator
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
# Structs whose fields are keywords of a call.
OPTIONS = {
    "solve": ["SolveOptions"], "solve_refined": ["ShootingOptions", "RefinementOptions"], "check": ["ShootingOptions"],
    "explain": ["ExplainOptions", "ShootingOptions"], "simulate_closed_loop": ["LoopOptions"],
    "MultipleShooting": ["ShootingOptions"], "RecedingHorizonController": ["ControllerOptions"],
    "ShrinkingHorizonController": ["ControllerOptions", "ShootingOptions"], "runge_kutta4": ["RungeKuttaOptions"],
    "runge_kutta8": ["RungeKuttaOptions"], "gauss_legendre": ["ImplicitRungeKuttaOptions"],
    "radau_iia": ["ImplicitRungeKuttaOptions"], "implicit_midpoint": ["ImplicitMidpointOptions"],
    "cvodes": ["CvodesOptions"], "arkode": ["ArkodeOptions"], "idas": ["IdasOptions"],
    "make_native_solver": ["NativeSolverOptions"], "make_ipopt": ["IpoptOptions"], "search": ["SearchOptions"],
    "solve_from": ["SeveralSolutions.Options"],
}
FIELDS_OF_ANY_TYPE = {"integrator": "Integrator | None", "qp": "str", "fallback": "Callable", "input": "Callable",
                      "state": "Callable", "states": "Sequence[Guess | ArrayLike]", "inputs": "Sequence[Guess | ArrayLike]",
                      "make_solver": "Callable[[], Solver]", "before_tick": "Callable", "until": "Callable"}
OF_OBJECT = ("__repr__", "__str__", "__eq__", "__ne__", "__hash__", "__array_ufunc__")
SIGNATURE = re.compile(r"^(?:\d+\. )?(\w+)\((.*)\) -> (.*)$")


def plain(text):
    """A type as Python writes it."""
    text = re.sub(r"saltus\._core\.", "", text)
    text = re.sub(r"saltus::(?:\w+::)*(\w+)", r"\1", text)  # a class that is bound later
    text = re.sub(r"\bfunction\b", "Callable", text)
    # Spellings of pybind11 3.
    text = re.sub(r'typing\.Annotated\[numpy\.typing\.(ArrayLike|NDArray)(?:\[numpy\.\w+\])?(?:, numpy\.\w+)?, "[^"]*"(?:, "[^"]*")*\]',
                  lambda m: "ArrayLike" if m[1] == "ArrayLike" else "ndarray", text)
    text = re.sub(r"numpy\.typing\.NDArray\[numpy\.\w+\]", "ndarray", text)
    text = re.sub(r"typing\.Supports(Int|Float) \| typing\.SupportsIndex", lambda m: m[1].lower(), text)
    text = re.sub(r"collections\.abc\.(Sequence|Callable)\b", r"\1", text)
    text = re.sub(r"numpy\.(?:typing\.)?\w*\[?[^\s,\]]*?(?:numpy\.)?float64\[[^\]]*\](?:, flags\.[\w.]+)*\]?", "ndarray", text)
    text = re.sub(r"numpy\.ndarray(?:\[[^\[\]]*(?:\[[^\]]*\])?[^\[\]]*\])?", "ndarray", text)
    text = re.sub(r"\b(?:typing\.)?(List|Dict|Tuple)\[", lambda m: m[1].lower() + "[", text)
    text = re.sub(r"\b(?:typing\.)?Callable\b", "Callable", text)
    return re.sub(r"\b(?:typing\.)?(Optional|Union)\b", r"\1", text).replace("handle", "Any")


def split(arguments):
    parts, depth, start = [], 0, 0
    for i, letter in enumerate(arguments):
        depth += (letter in "[(<") - (letter in "])" or (letter == ">" and arguments[i - 1] != "-"))
        if letter == "," and depth == 0:
            parts.append(arguments[start:i].strip())
            start = i + 1
    return [part for part in (*parts, arguments[start:].strip()) if part]


def field_types(core, struct):
    cls = operator.attrgetter(struct)(core)
    for name in cls._fields.split(", "):
        doc = getattr(getattr(cls, name, None), "fget", None)
        match = re.search(r"-> (.*)", (doc and doc.__doc__) or "")
        yield name, plain(match[1]) if match else FIELDS_OF_ANY_TYPE.get(name, "Any")


def options_of(core, name):
    if name in OPTIONS:
        structs = OPTIONS[name]
    else:
        try:
            structs = [name] if hasattr(operator.attrgetter(name)(core), "_fields") else []
        except AttributeError:
            structs = []
    fields = dict(pair for struct in structs for pair in field_types(core, struct))
    return ["*", *(f"{key}: {kind.replace('ndarray', 'ArrayLike')} = ..." for key, kind in fields.items())] if fields else []


def signatures(core, doc, name, owner):
    """Pairs of a signature and the text after it."""
    found, text = [], []
    for line in (doc or "").splitlines():
        match = SIGNATURE.match(line.strip())
        if match and match[1] == name:
            arguments = []
            for part in split(match[2]):
                if part.startswith("**"):
                    arguments += options_of(core, owner if name == "__init__" else name) or ["**options: Any"]
                    continue
                part = re.sub(r" = .*$", " = ...", part)
                arguments.append("self" if part.startswith("self:") else plain(part).replace("*args", "*args: Any")
                                 .replace("ndarray", "ArrayLike"))
            if "*args: Any" in arguments:  # keywords follow it anyway
                arguments = [a for a in arguments if a != "*"]
            returned = "Any" if match[3] == "object" else plain(match[3])
            found.append([f"({', '.join(arguments)}) -> {returned}", ""])
        elif found and line.strip() and line.strip() != "Overloaded function.":
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
    return found


def function(core, name, value, indent, owner="", static=False):
    found = signatures(core, value.__doc__, name, owner)
    for signature, text in found:
        if len(found) > 1:
            yield f"{indent}@overload"
        if static:
            yield f"{indent}@staticmethod"
        yield f"{indent}def {name}{signature}:{'' if text else ' ...'}"
        if text:
            yield f'{indent}    """{text}"""'


def members(core, cls, indent):
    own = cls.__dict__
    enum = "__members__" in own or hasattr(cls, "__members__")
    if enum:
        for name in cls.__members__:
            yield f"{indent}{name}: {cls.__qualname__}"
        yield f"{indent}__members__: dict[str, {cls.__qualname__}]"
        for name, kind in (("name", "str"), ("value", "int")):
            yield f"{indent}@property"
            yield f"{indent}def {name}(self) -> {kind}: ..."
        yield f"{indent}def __init__(self, value: int) -> None: ..."
        yield f"{indent}def __int__(self) -> int: ..."
        yield f"{indent}def __index__(self) -> int: ..."
        return
    if not issubclass(cls, Exception) and not signatures(core, cls.__init__.__doc__, "__init__", cls.__name__):
        yield f"{indent}def __init__(self, *args: Any, **kwargs: Any) -> None: ..."
    for name in sorted(own):
        value = own[name]
        if inspect.isclass(value):
            yield from class_of(core, value, indent)
        elif isinstance(value, property):
            match = re.search(r"-> (.*)", (value.fget.__doc__ or ""))
            yield f"{indent}@property"
            yield f"{indent}def {name}(self) -> {plain(match[1]) if match else 'Any'}: ..."
            if value.fset is not None:
                yield f"{indent}@{name}.setter"
                yield f"{indent}def {name}(self, value: {plain(match[1]) if match else 'Any'}) -> None: ..."
        elif isinstance(value, cls.__class__) or name.startswith("_") and (name in OF_OBJECT or not name.startswith("__")):
            continue
        elif callable(getattr(cls, name)):
            yield from function(core, name, getattr(cls, name), indent, cls.__qualname__, isinstance(value, staticmethod))
    for name in sorted(own):
        if isinstance(own[name], core.Penalty.Kind):
            yield f"{indent}{name}: Penalty.Kind"


def class_of(core, cls, indent=""):
    bases = [base.__name__ for base in cls.__bases__ if base.__module__ == core.__name__]
    if issubclass(cls, Exception):
        bases = [base.__name__ for base in cls.__bases__]
    yield f"{indent}class {cls.__name__}{'(' + ', '.join(bases) + ')' if bases else ''}:"
    text = (cls.__doc__ or "").strip().split("\n")[0]
    lines = list(members(core, cls, indent + "    "))
    if text and not issubclass(cls, Exception):
        yield f'{indent}    """{text}"""'
    yield from lines or [f"{indent}    ..."]


def stubs(core):
    lines = ['"""Modelling, solves and control loops of Saltus. Written by python/make_stubs.py."""', "",
             "from typing import Any, Callable, Optional, Sequence, Union, overload", "", "from numpy import ndarray",
             "from numpy.typing import ArrayLike", ""]
    for name in sorted(dir(core)):
        if name.startswith("_"):
            continue
        value = getattr(core, name)
        if inspect.isclass(value):
            lines += ["", *class_of(core, value)]
        elif callable(value):
            lines += ["", *function(core, name, value, "")]
        else:
            lines += ["", f"{name}: {type(value).__name__}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--print"]):
        sys.exit(__doc__)
    sys.path[:0] = [HERE, sys.argv[1]]
    from saltus import _core
    if sys.argv[2:]:
        print(stubs(_core), end="")
    else:
        with open(os.path.join(HERE, "saltus", "_core.pyi"), "w", encoding="utf-8") as file:
            file.write(stubs(_core))
