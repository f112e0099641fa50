"""Runs a second of 1000 chains of 50 beads: hertzchain beside scipy, and heyoka if it is there.

scipy integrates all chains as one system by numpy; heyoka has a chain in each lane of a register,
and is not told of contacts by events. On one core: `taskset -c 0 python many_runs.py`; a number
after it is that of chains, a multiple of eight.
"""

import sys
import time
from typing import Callable

import numpy as np
from scipy.integrate import solve_ivp

import hertzchain as hc

MEMBERS = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
SITES, RHO, END = 50, 1 / 3, 20.0
chain = hc.Chain(sites=SITES, kappa=1, rho=RHO)
start = np.zeros((MEMBERS, 4, SITES))
start[:, 2, 0] = np.linspace(0.5, 1.5, MEMBERS)


def slope(_: float, z: np.ndarray) -> np.ndarray:
    u, v, pu, pv = z.reshape(4, SITES, -1)
    overlap = np.maximum(u[:-1] - u[1:], 0)
    force = np.pad(overlap * np.sqrt(overlap), ((1, 1), (0, 0)))
    return np.concatenate([pu, pv / RHO, force[:-1] - force[1:] - (u - v), u - v]).ravel()


def ours(starts: np.ndarray, **options: object) -> np.ndarray:
    runs = hc.run_many(chain, list(starts.reshape(-1, 4 * SITES)), until=END, at=[END], **options)
    return np.stack([getattr(runs, name)[:, -1] for name in ("u", "v", "pu", "pv")], 1)


def scipys(tol: float) -> np.ndarray:
    z = solve_ivp(slope, (0, END), start.transpose(1, 2, 0).ravel(), method="DOP853", rtol=tol, atol=tol, t_eval=[END])
    return z.y[:, -1].reshape(4, SITES, MEMBERS).transpose(2, 0, 1)


def heyokas(tol: float) -> Callable[[], np.ndarray]:
    import heyoka as hy

    lanes = hy.recommended_simd_size()
    u, v, pu, pv = (hy.make_vars(*[f"{name}{n}" for n in range(SITES)]) for name in ("u", "v", "pu", "pv"))
    gaps = [u[n] - u[n + 1] for n in range(SITES - 1)]
    force = [0.0, *[hy.select(hy.gt(x, 0.0), x**1.5, 0.0) for x in gaps], 0.0]
    field = [
        *[(u[n], pu[n]) for n in range(SITES)],
        *[(v[n], pv[n] / RHO) for n in range(SITES)],
        *[(pu[n], force[n] - force[n + 1] - (u[n] - v[n])) for n in range(SITES)],
        *[(pv[n], u[n] - v[n]) for n in range(SITES)],
    ]
    groups = start.reshape(-1, lanes, 4 * SITES).transpose(0, 2, 1)
    flow = hy.taylor_adaptive_batch(field, groups[0].copy(), tol=tol, compact_mode=True)

    def compute() -> np.ndarray:
        ends = []
        for group in groups:
            flow.set_time(0.0)
            flow.state[:] = group
            flow.propagate_until(END)
            ends.append(flow.state.copy())
        return np.stack(ends).transpose(0, 2, 1).reshape(MEMBERS, 4, SITES)

    return compute


few = slice(None, None, 100)
truth = ours(start[few], tol=1e-13)
steps = [("strang-linear", 0.1), ("strang-linear", 0.01), ("corrected", 0.05)]
ways = {f"{name}, step {h}": lambda name=name, h=h: ours(start, method=name, step=h) for name, h in steps}
ways["collocation, tol 1e-9"] = lambda: ours(start, tol=1e-9)
ways |= {f"scipy DOP853, tol {tol:g}": lambda tol=tol: scipys(tol) for tol in (1e-3, 1e-6)}
try:
    ways |= {f"heyoka, tol {tol:g}": heyokas(tol) for tol in (1e-3, 1e-9)}
except ImportError:
    print("heyoka is not installed")
for name, compute in ways.items():
    times = []
    for _ in range(3):
        clock = time.perf_counter()
        ends = compute()
        times.append(time.perf_counter() - clock)
    print(f"{name:26} {MEMBERS / min(times):9.0f} runs a second  error {abs(ends[few] - truth).max():.1e}", flush=True)
