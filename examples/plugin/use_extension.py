#!/usr/bin/env python3
"""Moves a cart by 1 m with the extension of Python. Usage: use_extension.py FOLDER_OF_THE_EXTENSION"""

import sys

sys.path.insert(0, sys.argv[1])
import cart_extension  # noqa: E402

cart = cart_extension.create("cart")
cart_extension.set_data(cart, "target", [1.0])
x, step = [0.0, 0.0], 0.001
for k in range(200):
    provenance, u = cart_extension.tick(cart, 0.02 * k, x)
    for _ in range(20):
        x = [x[0] + step * x[1], x[1] + step * (u[0] - 0.2 * x[1] * (x[1]**2 + 0.01)**0.5)]
times, states, inputs = cart_extension.plan(cart)
print(f"provenance {provenance}, {abs(x[0] - 1.0):.2f} m from the target, plan of {len(times)} nodes")
try:
    cart_extension.create("train")
    sys.exit("an unknown name was accepted")
except RuntimeError as error:
    print(error)
sys.exit(0 if abs(x[0] - 1.0) < 0.02 and len(times) == len(states) == len(inputs) else 1)
