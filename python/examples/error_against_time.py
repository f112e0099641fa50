"""Error against run time on one chain: hertzchain beside scipy, and heyoka if it is there.

heyoka gets the force as one expression. Its Taylor steps are longer than contacts, and it is not told
of them by events: so it takes no account of what happens inside a step.
"""

import os
import platform
import sys
import time
from typing import Callable

import numpy as np
from scipy.integrate import solve_ivp

import hertzchain as hc

SITES, RHO, END = 30, 1 / 3, 20.0
chain = hc.Chain(sites=SITES, kappa=1, rho=RHO)
start = np.zeros((4, SITES))
start[2, 0] = 1.0


def slope(_: float, z: np.ndarray) -> np.ndarray:
    u, v, pu, pv = z.reshape(4, SITES)
    overlap = np.maximum(u[:-1] - u[1:], 0)
    force = overlap * np.sqrt(overlap)
    push = np.zeros(SITES)
    push[:-1] -= force
    push[1:] += force
    return np.concatenate([pu, pv / RHO, push - (u - v), u - v])


def ours(**options: object) -> np.ndarray:
    end = hc.run(chain, y0=start.ravel(), until=END, at=[END], **options).end
    return np.concatenate([end[name] for name in ("u", "v", "pu", "pv")])


def scipys(method: str, tol: float) -> np.ndarray:
    return solve_ivp(slope, (0, END), start.ravel(), method=method, rtol=tol, atol=tol, t_eval=[END]).y[:, -1]


def heyokas(tol: float) -> Callable[[], np.ndarray]:
    import heyoka as hy

    u, v, pu, pv = (hy.make_vars(*[f"{name}{n}" for n in range(SITES)]) for name in ("u", "v", "pu", "pv"))
    overlaps = [u[n] - u[n + 1] for n in range(SITES - 1)]
    force = [0.0, *[hy.select(hy.gt(x, 0.0), x**1.5, 0.0) for x in overlaps], 0.0]
    field = [
        *[(u[n], pu[n]) for n in range(SITES)],
        *[(v[n], pv[n] / RHO) for n in range(SITES)],
        *[(pu[n], force[n] - force[n + 1] - (u[n] - v[n])) for n in range(SITES)],
        *[(pv[n], u[n] - v[n]) for n in range(SITES)],
    ]
    flow = hy.taylor_adaptive(field, start.ravel().copy(), tol=tol, compact_mode=True)

    def compute() -> np.ndarray:
        flow.time, flow.state[:] = 0.0, start.ravel()
        flow.propagate_until(END)
        return flow.state.copy()

    return compute


def timed(compute: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    """The shortest of all runs in a fifth of a second, and what a run gives."""
    best, begin = np.inf, time.perf_counter()
    while best == np.inf or time.perf_counter() < begin + 0.2:
        clock = time.perf_counter()
        state = compute()
        best = min(best, time.perf_counter() - clock)
    return best, state


truth = ours(method="dop853-regularised", tol=1e-15)  # good to 4e-13
ladders = {
    "collocation": [lambda tol=10.0**-k: ours(tol=tol) for k in range(3, 13, 2)],
    "corrected": [lambda h=0.2 / 2**k: ours(method="corrected", step=h) for k in range(6)],
    "strang-linear": [lambda h=0.2 / 2**k: ours(method="strang-linear", step=h) for k in range(8)],
    "scipy DOP853": [lambda tol=10.0**-k: scipys("DOP853", tol) for k in range(3, 10, 2)],
    "scipy LSODA": [lambda tol=10.0**-k: scipys("LSODA", tol) for k in range(3, 10, 2)],
}
try:
    ladders["heyoka, no events"] = [heyokas(10.0**-k) for k in (3, 9)]
except ImportError:
    print("heyoka is not installed")
curves = {}
for name, ladder in ladders.items():
    rows = [(seconds, abs(state - truth).max()) for seconds, state in map(timed, ladder)]
    curves[name] = rows
    for seconds, error in rows:
        print(f"{name:24} {1e3 * seconds:9.3f} ms  error {error:.1e}")

if len(sys.argv) > 1:
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(layout="constrained")
    ax.set_prop_cycle(color=["0.2", "0.45", "0.65"])  # of what is not ours
    for name, rows in curves.items():
        ax.loglog(*zip(*rows), label=name, **hc.look(name))
    stamp = f"{time.strftime('%Y-%m-%d')}, {platform.machine()}, {os.cpu_count()} cores, one thread"
    ax.set(xlabel="run time (s)", ylabel="largest error of the state", title=f"A struck chain of 30 beads\n{stamp}")
    ax.legend(loc="lower right")
    figure.savefig(sys.argv[1], dpi=120)
