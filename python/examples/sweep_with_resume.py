"""A sweep over the mass ratio on all cores, that goes on where it was stopped."""

import sys
import tempfile
from pathlib import Path

import numpy as np

import hertzchain as hc


def kept(rho: float) -> float:
    """The share of its momentum that a struck bead has at t = 5."""
    chain = hc.Chain(sites=10, kappa=1, rho=rho)
    return float(hc.run(chain, y0={"pu": np.eye(10)[0]}, until=5.0, tol=1e-9, at=[5.0]).end["pu"][0])


with tempfile.TemporaryDirectory() as folder:
    store = Path(folder) / "kept.jsonl"
    grid = np.geomspace(0.1, 10, 13)
    some = hc.sweep(kept, grid[:6], store=store, version=1)  # stopped after six points
    values = hc.sweep(kept, grid, store=store, version=1)  # computes the other seven
    assert values[:6] == some
for rho, value in zip(grid, values):
    print(f"rho {rho:7.3f}  momentum {value:+.9f}")
if len(sys.argv) > 1:
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(layout="constrained")
    ax.semilogx(grid, values, "o-")
    ax.set(xlabel="mass ratio rho", ylabel="momentum of the struck bead at t = 5")
    figure.savefig(sys.argv[1], dpi=120)
