"""Measures evaluations of one function in four forms: value, Jacobian and Hessian of the pendulum on a cart.

Usage: casadi_times.py. Needs CasADi and a C compiler.
"""

import os
import subprocess
import tempfile
import time

import casadi as ca
import numpy as np

import saltus as sl

M, m, g, l = 1.0, 0.1, 9.81, 0.8


def formula(t, x, u):
    p, theta, v, dtheta = x
    s, c = sl.sin(theta), sl.cos(theta)
    d = M + m - m * c * c
    return [v, dtheta, (-m * l * s * dtheta * dtheta + m * g * c * s + u[0]) / d,
            (-m * l * c * s * dtheta * dtheta + u[0] * c + (M + m) * g * s) / (l * d)]


def of_casadi():
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", 4), ca.SX.sym("u")
    theta, dtheta, s, c = x[1], x[3], ca.sin(x[1]), ca.cos(x[1])
    d = M + m - m * c * c
    return ca.Function("cart", [t, x, u], [ca.vertcat(
        x[2], dtheta, (-m * l * s * dtheta * dtheta + m * g * c * s + u) / d,
        (-m * l * c * s * dtheta * dtheta + u * c + (M + m) * g * s) / (l * d))])


with tempfile.TemporaryDirectory() as folder:
    code, library = os.path.join(folder, "cart.c"), os.path.join(folder, "cart.so")
    sl.generate_casadi(of_casadi(), code)
    subprocess.run(["cc", "-O2", "-fPIC", "-shared", code, "-o", library, "-lm"], check=True)
    forms = {"Python formula, recorded": sl.make_function(formula, 4, 1),
             "CasADi function, recorded": sl.make_function(of_casadi(), 4, 1),
             "CasADi function, C code": sl.load_casadi(library, "cart", 4, 1)}
    z, weights = np.array([0.0, 0.1, 0.7, 0.3, -0.2, 1.5]), np.ones(4)
    print(f"{'':28}{'value':>10}{'Jacobian':>10}{'Hessian':>10}   ns")
    for name, f in forms.items():
        print(f"{name:28}" + "".join(f"{1e9 * seconds:10.0f}" for seconds in f.seconds(z, weights)))
    f = of_casadi()
    buffer, evaluate = f.buffer()
    arguments = [np.array([0.0]), np.array([0.1, 0.7, 0.3, -0.2]), np.array([1.5])]
    result = np.zeros(4)
    for i, argument in enumerate(arguments):
        buffer.set_arg(i, memoryview(argument))
    buffer.set_res(0, memoryview(result))
    begin = time.perf_counter()
    for _ in range(100000):
        evaluate()
    print(f"{'CasADi, virtual machine':28}{1e4 * (time.perf_counter() - begin):10.0f}")
