"""The speed of the solitary wave of the Hertz chain against the force in it."""

import sys

import numpy as np

import hertzchain as hc

SITES = 200
rows = []
for velocity in (0.25, 0.5, 1.0, 2.0, 4.0):
    chain = hc.Chain(sites=SITES)
    start = {"pu": velocity * np.eye(SITES)[0]}
    run = hc.run(chain, y0=start, until=150 / velocity**0.2, tol=1e-10, events=True, at=10)
    first = {int(row["bond"]): row for row in run.contacts[::-1]}
    low, high = first[60], first[120]
    speed = 60 / (high["t_largest"] - low["t_largest"])
    force = high["largest_overlap"] ** 1.5
    rows.append((force, speed))
    print(f"force {force:.6f}  speed {speed:.8f}  speed / force^(1/6) {speed / force ** (1 / 6):.8f}")

ratios = [speed / force ** (1 / 6) for force, speed in rows]
# By the symmetry of scales of the chain the ratio is the same for all.
assert np.ptp(ratios) < 1e-4
if len(sys.argv) > 1:
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(layout="constrained")
    ax.plot(*zip(*rows), "o")
    force = np.geomspace(rows[0][0], rows[-1][0], 100)
    ax.plot(force, ratios[0] * force ** (1 / 6), label=f"{ratios[0]:.5f} force$^{{1/6}}$")
    ax.set(xlabel="largest force", ylabel="speed (sites per unit of time)")
    ax.legend()
    figure.savefig(sys.argv[1], dpi=120)
