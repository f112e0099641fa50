"""End state of a chain of stiff resonators, tests/reference/stiff.json, by scipy's DOP853.

40 beads, the first struck with velocity 1, free ends, alpha = 3/2, kappa = 1e4, rho = 0.1, t = 40.
Two runs, at rtol 1e-13 and at 3e-14, give the state and `error`, their largest difference of
strains, velocities and stretches, each over its own largest: `python stiff.py > stiff.json`.
"""

import json

import numpy as np
from scipy.integrate import solve_ivp

N, KAPPA, RHO, END = 40, 1e4, 0.1, 40.0


def rates(_t, y):
    u, v, u_dot, v_dot = np.split(y, 4)
    g = np.maximum(u[:-1] - u[1:], 0.0)
    f = np.concatenate([[0.0], g * np.sqrt(g), [0.0]])
    pull = KAPPA * (u - v)
    return np.concatenate([u_dot, v_dot, f[:-1] - f[1:] - pull, pull / RHO])


def end(rtol):
    y = np.zeros(4 * N)
    y[2 * N] = 1.0
    return solve_ivp(rates, (0.0, END), y, method="DOP853", rtol=rtol, atol=rtol * 1e-2).y[:, -1]


def parts(y):
    u, v, u_dot, _ = np.split(y, 4)
    return [np.diff(u), u_dot, u - v]


a, b = end(1e-13), end(3e-14)
error = max(float(np.abs(x - z).max() / np.abs(z).max()) for x, z in zip(parts(a), parts(b)))
print(json.dumps({"error": error, "state": b.tolist()}))
