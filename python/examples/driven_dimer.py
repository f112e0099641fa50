"""Bifurcation diagram of a driven dimer: exact orbits with their stability, and runs.

Heavy and light beads stand between walls under a static load. The first bead is pushed by a harmonic
force and all beads are damped. Orbits of the period of the drive are followed in its frequency, past
folds. For a weak force the contacts are springs and the response is known; for stronger ones
contacts open. Runs show what the chain does where the orbit is unstable: the place of the last bead
once a period, when transients have gone.
``python driven_dimer.py FILE`` draws the diagram.
"""

import sys

import numpy as np

import hertzchain as hc

SITES, DRAG = 4, 0.1
# Heavy and light beads in turn; the static overlap of each contact is 1.
MASS = np.where(np.arange(SITES) % 2, 0.5, 1.0)
FIRST, LAST = 0.3, 2.5
TRANSIENT, KEPT = 150, 20


def chain(force, omega):
    """The chain with its drive."""
    push = {"site": 0, "kind": "pushed", "amplitude": force, "omega": omega}
    return hc.Chain(SITES, boundary="fixed", precompression=1.0, beads={"mass": MASS, "drag": DRAG}, drive=[push])


def linear_response(omega):
    """Largest amplitude of a bead over the force, for contacts as springs of stiffness (3/2) overlap^(1/2)."""
    stiffness = 1.5 * (2 * np.eye(SITES) - np.eye(SITES, k=1) - np.eye(SITES, k=-1))
    moved = np.linalg.solve(stiffness - omega**2 * np.diag(MASS) + 1j * omega * DRAG * np.eye(SITES), np.eye(SITES)[0])
    return abs(moved).max()


def strobed(force, omega):
    """Places of the last bead at the phase zero of the drive, after a run from rest."""
    times = 2 * np.pi / omega * np.arange(TRANSIENT, TRANSIENT + KEPT)
    return hc.run(chain(force, omega), y0={}, until=times[-1], at=times, tol=1e-8).u[:, -1]


if __name__ == "__main__":
    forces = (1e-4, 0.4, 1.0)
    start = [hc.driven_orbit(chain(force, FIRST)) for force in forces]
    branches = [hc.continue_branch(orbit, "omega", to=LAST, step=0.02, max_points=400) for orbit in start]
    for force, branch in zip(forces, branches):
        peak = branch.response.argmax()
        print(f"force {force:6g}: largest response {branch.response[peak] / force:.4f} at {branch.values[peak]:.3f}")
        for one in branch.bifurcations:
            print(f"    {one['kind']} at {one['parameter']:.6f}")
    linear = np.array([linear_response(omega) for omega in branches[0].values])
    off = np.abs(branches[0].response / 1e-4 / linear - 1).max()
    print(f"weak force: within {off:.1e} of the linear response")
    # The contacts of a weak force are springs up to terms of second order in the force.
    assert off < 1e-7

    # Between its two doublings the orbit is unstable, and runs have twice the period of the drive.
    doubled = [one["parameter"] for one in branches[2].bifurcations if one["kind"] == "period-doubling"]
    seen = strobed(1.0, np.mean(doubled))
    assert np.ptp(seen[::2]) < 1e-6 < 1e-3 < abs(seen[0] - seen[1]), seen

    if len(sys.argv) > 1:
        import matplotlib.pyplot as plt

        axes = plt.subplots(2, sharex=True, layout="constrained", figsize=(7, 7))[1]
        for k, (force, branch) in enumerate(zip(forces, branches)):
            axes[0].plot([], [], color=f"C{k}", label=f"force {force:g}")
            branch.response = branch.response / force
            for one in branch.bifurcations:
                one["response"] /= force
            branch.plot(axes[0], color=f"C{k}")
        axes[0].set(yscale="log", xlabel="", ylabel="largest half range of a bead over the force")
        axes[0].set_yticks([0.4, 0.6, 1, 2, 3, 4], labels=["0.4", "0.6", "1", "2", "3", "4"])
        axes[0].minorticks_off()
        axes[0].legend()
        omegas = np.linspace(FIRST, LAST, 221)
        places = hc.sweep(lambda omega: strobed(forces[2], omega), omegas)
        axes[1].plot(np.repeat(omegas, KEPT), np.ravel(places), "k,")
        axes[1].set(xlabel="drive frequency", ylabel=f"last bead once a period, force {forces[2]:g}")
        axes[1].figure.savefig(sys.argv[1])
