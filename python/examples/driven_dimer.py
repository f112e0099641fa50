"""Response of a driven dimer against the drive frequency: sweeps up and down, as in a laboratory.

A chain of heavy and light beads stands between walls under a static load. Its first bead is pushed by
a harmonic force. The amplitude of the last bead is measured once transients have gone: first with the
frequency rising from run to run, then falling, each run from the state in which the last one ended.
Where the two differ, the chain has two responses at one frequency. ``python driven_dimer.py FILE``
draws them.
"""

import sys

import numpy as np

import hertzchain as hc

SITES, DRAG = 8, 0.02
# Static overlap 1 in each contact; heavy and light beads in turn.
MASS = np.where(np.arange(SITES) % 2, 0.5, 1.0)
PERIODS, KEPT = 40, 8


def driven(omega, force):
    """The chain whose first bead is pushed at a frequency."""
    push = {"site": 0, "kind": "pushed", "amplitude": force, "omega": omega, "phase": np.pi / 2}
    return hc.Chain(
        sites=SITES,
        boundary="fixed",
        precompression=1.0,
        beads={"mass": MASS, "drag": DRAG},
        drive=[push],
    )


def sweep(omegas, force):
    """Amplitude of the last bead at each frequency, one run after the other."""
    state, amplitudes = {"u": np.zeros(SITES)}, []
    for omega in omegas:
        period = 2 * np.pi / omega
        times = period * (PERIODS - KEPT + np.arange(16 * KEPT + 1) / 16)
        run = hc.run(driven(omega, force), y0=state, until=PERIODS * period, at=times, tol=1e-7)
        last = run.u[:, -1]
        amplitudes.append((last.max() - last.min()) / 2)
        state = run.end
    return np.array(amplitudes)


def resonances():
    """Frequencies of the linear chain: contacts as springs of stiffness (3/2) overlap^(1/2)."""
    stiffness = 1.5 * (2 * np.eye(SITES) - np.eye(SITES, k=1) - np.eye(SITES, k=-1))
    scale = 1 / np.sqrt(MASS)
    return np.sqrt(np.linalg.eigvalsh(scale[:, None] * stiffness * scale))


if __name__ == "__main__":
    linear = resonances()
    # A weak force about the lowest resonance: the peak is where the linear chain has it.
    near = linear[0] * np.linspace(0.9, 1.1, 41)
    weak = sweep(near, 1e-4)
    peak = near[weak.argmax()]
    print(f"weak force: largest response at {peak:.4f}, lowest linear frequency {linear[0]:.4f}")
    assert abs(peak / linear[0] - 1) < 0.01

    # A strong force: the resonance bends to lower frequencies, and the sweeps differ.
    omegas = linear[0] * np.linspace(0.7, 1.1, 41)
    up = sweep(omegas, 0.12)
    down = sweep(omegas[::-1], 0.12)[::-1]
    apart = np.abs(up - down) > 0.1 * np.maximum(up, down)
    print(f"strong force: up and down differ at {apart.sum()} of {len(omegas)} frequencies")
    print(f"largest response at {omegas[down.argmax()]:.4f}, up {up.max():.3f}, down {down.max():.3f}")

    if len(sys.argv) > 1:
        import matplotlib.pyplot as plt

        ax = plt.subplots(layout="constrained")[1]
        ax.plot(omegas, up, ".-", label="frequency rising")
        ax.plot(omegas, down, ".-", label="frequency falling")
        ax.axvline(linear[0], color="grey", label="lowest frequency of the linear chain")
        ax.set(xlabel="drive frequency", ylabel="amplitude of the last bead")
        ax.legend()
        ax.figure.savefig(sys.argv[1])
