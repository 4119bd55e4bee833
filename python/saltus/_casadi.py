"""Functions of CasADi as formulas: their instructions are recorded once, so CasADi is not needed at solve time."""

from . import _core, _formulas


def generate_casadi(function, file):
    """Writes C code of a CasADi function of (t, x), (t, x, u) or (t, x, u, p) with its Jacobian and Hessian, for
    saltus_casadi() of CMake and load_casadi() of C++.
    """
    import os
    import casadi as ca
    name = function.name()
    scalar = function.expand() if not function.is_a("SXFunction") else function
    inputs = [ca.SX.sym(f"i{k}", scalar.numel_in(k)) for k in range(scalar.n_in())]
    y = ca.densify(scalar(*inputs))
    z, weights = ca.vertcat(*inputs), ca.SX.sym("weights", y.numel())
    folder, base = os.path.split(os.path.abspath(file))
    generator = ca.CodeGenerator(base, {"with_header": False})
    generator.add(ca.Function(name, inputs, [y]))
    generator.add(ca.Function(f"{name}_jacobian", inputs, [y, ca.jacobian(y, z)]))
    generator.add(ca.Function(f"{name}_hessian", [*inputs, weights], [ca.tril(ca.hessian(ca.dot(weights, y), z)[0])]))
    generator.generate(folder + os.sep)


def _operations():
    import casadi as ca
    unary = {
        ca.OP_NEG: lambda a: -a, ca.OP_EXP: _formulas.exp, ca.OP_LOG: _formulas.log, ca.OP_SQRT: _formulas.sqrt,
        ca.OP_SQ: lambda a: a * a, ca.OP_TWICE: lambda a: 2.0 * a, ca.OP_SIN: _formulas.sin, ca.OP_COS: _formulas.cos,
        ca.OP_TAN: _formulas.tan, ca.OP_ASIN: _formulas.asin, ca.OP_ACOS: _formulas.acos, ca.OP_ATAN: _formulas.atan,
        ca.OP_SINH: _formulas.sinh, ca.OP_COSH: _formulas.cosh, ca.OP_TANH: _formulas.tanh, ca.OP_FABS: abs,
        ca.OP_INV: lambda a: 1.0 / a, ca.OP_ASSIGN: lambda a: a,
        ca.OP_ASINH: lambda a: _formulas.log(a + _formulas.sqrt(a * a + 1.0)),
        ca.OP_ACOSH: lambda a: _formulas.log(a + _formulas.sqrt(a * a - 1.0)),
        ca.OP_ATANH: lambda a: 0.5 * _formulas.log((1.0 + a) / (1.0 - a)),
        ca.OP_LOG1P: lambda a: _formulas.log(1.0 + a), ca.OP_EXPM1: lambda a: _formulas.exp(a) - 1.0,
    }
    binary = {
        ca.OP_ADD: lambda a, b: a + b, ca.OP_SUB: lambda a, b: a - b, ca.OP_MUL: lambda a, b: a * b,
        ca.OP_DIV: lambda a, b: a / b, ca.OP_POW: lambda a, b: a ** b, ca.OP_CONSTPOW: lambda a, b: a ** b,
        ca.OP_FMIN: _formulas.min, ca.OP_FMAX: _formulas.max, ca.OP_ATAN2: _formulas.atan2,
        ca.OP_HYPOT: _formulas.hypot,
    }
    return unary, binary


def traced(function, z, nx, nz, nu, np):
    """The outputs of a CasADi function of (t, x), (t, x, u) or (t, x, u, p) for the expressions z."""
    import casadi as ca
    name = function.name()
    sizes = [1, nx, *([nz] if nz else []), nu, np]
    given = [function.numel_in(i) for i in range(function.n_in())]
    if len(given) < 2 or given != sizes[:len(given)]:
        raise _core.DefinitionError(f"the CasADi function '{name}' has inputs of {given} entries, but "
                                    f"({'t, x, z, u, p' if nz else 't, x, u, p'}) have {sizes}")
    if function.n_out() != 1 or function.size2_out(0) != 1:
        raise _core.DefinitionError(f"the CasADi function '{name}' must have one output, a column vector")
    try:
        scalar = function.expand() if not function.is_a("SXFunction") else function
    except RuntimeError as error:
        raise _core.DefinitionError(f"the CasADi function '{name}' cannot be expanded to scalars: "
                                    f"{str(error).splitlines()[-1]}") from error
    arguments, first = [], 0
    for size in sizes:
        arguments.append(z[first:first + size])
        first += size
    unary, binary = _operations()
    names = {getattr(ca, text): text[3:].lower() for text in dir(ca) if text.startswith("OP_")}
    nonzeros = [[row for row in scalar.sparsity_in(i).row()] for i in range(scalar.n_in())]
    columns = [scalar.sparsity_in(i).size1() for i in range(scalar.n_in())]
    for i, rows in enumerate(columns):
        if rows != given[i] or scalar.size2_in(i) != 1:
            if given[i] > 0:
                raise _core.DefinitionError(f"input {i} of the CasADi function '{name}' must be a column vector")
    pattern = scalar.sparsity_out(0)
    results = [0.0] * pattern.size1()
    work = [0.0] * scalar.sz_w()
    for k in range(scalar.n_instructions()):
        operation = scalar.instruction_id(k)
        inputs, outputs = scalar.instruction_input(k), scalar.instruction_output(k)
        if operation == ca.OP_CONST:
            work[outputs[0]] = scalar.instruction_constant(k)
        elif operation == ca.OP_INPUT:
            work[outputs[0]] = arguments[inputs[0]][nonzeros[inputs[0]][inputs[1]]]
        elif operation == ca.OP_OUTPUT:
            results[pattern.row()[outputs[1]]] = work[inputs[0]]
        elif operation in unary:
            work[outputs[0]] = unary[operation](work[inputs[0]])
        elif operation in binary:
            work[outputs[0]] = binary[operation](work[inputs[0]], work[inputs[1]])
        else:
            raise _core.DefinitionError(f"the CasADi function '{name}' uses the operation "
                                        f"'{names.get(operation, operation)}', for which there is no formula; replace "
                                        "it by a smooth one, or by saltus.select in a Python formula")
    return results
