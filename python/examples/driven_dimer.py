"""Response of a driven dimer against the drive frequency, from weak forces to strong ones.

Heavy and light beads stand between walls under a static load. The first bead is pushed by a harmonic
force, all beads are damped, and the amplitude of the last one is measured once transients have gone.
For weak forces the contacts are springs and the response is known; for strong ones contacts open.
``python driven_dimer.py FILE`` draws the curves.
"""

import sys

import numpy as np

import hertzchain as hc

SITES, DRAG = 8, 0.05
# Heavy and light beads in turn; the static overlap of each contact is 1.
MASS = np.where(np.arange(SITES) % 2, 0.5, 1.0)
PERIODS, KEPT = 50, 5


def response(force, omega):
    """Amplitude of the last bead over the force."""
    push = {"site": 0, "kind": "pushed", "amplitude": force, "omega": omega}
    beads = {"mass": MASS, "drag": DRAG}
    chain = hc.Chain(sites=SITES, boundary="fixed", precompression=1.0, beads=beads, drive=[push])
    period = 2 * np.pi / omega
    times = period * (PERIODS - KEPT + np.arange(32 * KEPT + 1) / 32)
    run = hc.run(chain, y0={"u": np.zeros(SITES)}, until=PERIODS * period, at=times, tol=1e-7)
    return np.ptp(run.u[:, -1]) / 2 / force


def linear_response(omega):
    """The same for contacts as springs of stiffness (3/2) overlap^(1/2)."""
    stiffness = 1.5 * (2 * np.eye(SITES) - np.eye(SITES, k=1) - np.eye(SITES, k=-1))
    moved = np.linalg.solve(stiffness - omega**2 * np.diag(MASS) + 1j * omega * DRAG * np.eye(SITES), np.eye(SITES)[0])
    return abs(moved[-1])


if __name__ == "__main__":
    omegas = np.linspace(0.3, 1.2, 46)
    linear = np.array([linear_response(omega) for omega in omegas])
    curves = {}
    for force in (1e-4, 0.5, 1.5):
        curves[force] = np.array(hc.sweep(lambda omega: response(force, omega), omegas))
        peak = curves[force].argmax()
        print(f"force {force:6g}: largest response {curves[force][peak]:7.4f} at {omegas[peak]:.2f}")
    off = np.abs(curves[1e-4] / linear - 1).max()
    print(f"weak force: within {off:.1e} of the linear response")
    # Sampling 32 times a period misses a maximum by up to (pi/32)^2/2 = 5e-3.
    assert off < 0.01

    if len(sys.argv) > 1:
        import matplotlib.pyplot as plt

        ax = plt.subplots(layout="constrained")[1]
        ax.semilogy(omegas, linear, color="grey", label="linear chain")
        for force, curve in curves.items():
            ax.semilogy(omegas, curve, ".-", label=f"force {force:g}")
        ax.set(xlabel="drive frequency", ylabel="amplitude of the last bead over the force")
        ax.legend()
        ax.figure.savefig(sys.argv[1])
