"""Derivatives of the state at the end by numbers of the chain: closed forms, differences."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import hertzchain as hc


def collision(alpha: float) -> float:
    """The time for which two beads touch that meet with speed 1: g'' = -2 g^alpha."""
    p = alpha + 1
    return 2 * (p / 4) ** (1 / p) * math.sqrt(math.pi) * math.gamma(1 + 1 / p) / math.gamma(0.5 + 1 / p)


@pytest.mark.parametrize("alpha", [1.2, 1.5, 2.0, 3.5])
def test_the_exponent_of_a_collision(alpha: float) -> None:
    # Truth: after a contact from t = 1 to 1 + D both beads are at 1 + D/2. The first one stays there,
    # the second one moves on with speed 1: by alpha they are moved by D'/2 and -D'/2.
    run = hc.run(hc.Chain(sites=2, alpha=alpha), y0={"u": [0, 1], "pu": [1, 0]}, until=6.0, tol=1e-12, derivatives="alpha")
    h = 1e-3
    slope = (8 * (collision(alpha + h) - collision(alpha - h)) - collision(alpha + 2 * h) + collision(alpha - 2 * h)) / (12 * h)
    got = run.derivatives["alpha"]
    assert np.abs(got["u"] - [slope / 2, -slope / 2]).max() < 1e-8 and np.abs(got["pu"]).max() < 1e-8


def test_springs_masses_and_amplitudes_of_an_oscillator() -> None:
    # Truth: u = cos(w t), w^2 = kappa/m; and a bead with a resonator, by its two modes.
    t, kappa, mass = 3.0, 4.0, 2.0
    chain = hc.Chain(sites=1, kappa=kappa, rho=math.inf, beads={"mass": mass})
    names = ["kappa", "amplitude", "mass[0]"]
    got = hc.run(chain, y0={"u": [1.0]}, until=t, tol=1e-12, derivatives=names).derivatives
    w = math.sqrt(kappa / mass)
    slow = -t * math.sin(w * t)  # d cos(w t)/dw
    assert abs(got["kappa"]["u"][0] - slow / (2 * w * mass)) < 1e-10
    assert abs(got["amplitude"]["u"][0] - math.cos(w * t)) < 1e-10
    assert abs(got["mass[0]"]["u"][0] + slow * w / (2 * mass)) < 1e-10
    # p = -m w sin(w t), and m w = sqrt(kappa m).
    momentum = -w / 2 * math.sin(w * t) + mass * w * math.cos(w * t) * t * w / (2 * mass)
    assert abs(got["mass[0]"]["pu"][0] - momentum) < 1e-10


@pytest.mark.parametrize("name", ["alpha", "kappa", "rho", "mass[1]", "amplitude"])
def test_a_chain_against_differences(name: str) -> None:
    # Truth: central differences of runs; the momenta of the start are the same for all masses.
    numbers = {"alpha": 1.6, "kappa": 1.3, "rho": 0.6, "mass[1]": 0.8, "amplitude": 1.0}
    start = {"pu": np.array([1.0, 0.2, 0, 0]), "pv": np.array([0, 0.3, 0, 0]), "u": np.array([0, 0.1, 0.0, 0.0])}

    def end(h: float, **options: Any) -> hc.Trajectory:
        of = numbers | {name: numbers[name] + h}
        mass = [1.0, of["mass[1]"], 2.0, 1.5]
        chain = hc.Chain(sites=4, alpha=of["alpha"], kappa=of["kappa"], rho=of["rho"], boundary="fixed", beads={"mass": mass})
        y0 = {key: of["amplitude"] * array for key, array in start.items()}
        return hc.run(chain, y0=y0, until=4.0, tol=1e-13, **options)

    got, h = end(0.0, derivatives=[name]).derivatives[name], 1e-4
    plus, minus = end(h).end, end(-h).end
    for key, array in got.items():
        assert np.abs((plus[key] - minus[key]) / (2 * h) - array).max() < 3e-6, key


@pytest.mark.parametrize("rho", [0.0, [0.0, 0.5], [math.inf, 0.0]])
def test_on_site_springs_do_not_change_with_kappa(rho: Any) -> None:
    # Truth: central differences of runs; without a resonator nothing depends on kappa.
    beads = {"onsite": 0.5, "rho": rho} if isinstance(rho, list) else {"onsite": 0.5}

    def end(kappa: float, **options: Any) -> hc.Trajectory:
        chain = hc.Chain(sites=2, alpha=1.5, kappa=kappa, beads=beads)
        return hc.run(chain, y0={"u": [1.0, 0.0]}, until=3.0, tol=1e-13, **options)

    got, h = end(1.0, derivatives="kappa").derivatives["kappa"], 1e-4
    plus, minus = end(1.0 + h).end, end(1.0 - h).end
    for key, array in got.items():
        assert np.abs((plus[key] - minus[key]) / (2 * h) - array).max() < 3e-6, key
    assert rho != 0.0 or not got["u"].any()


def test_derivatives_are_refused_before_the_run() -> None:
    seen: list[float] = []
    chain, start = hc.Chain(sites=2), {"u": [1.0, 0.0]}
    steel = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3}
    strains = hc.Scene.load("tw-q15")
    runs = [(chain, start, "beta"), (chain, start, "rho"), (chain, start, "mass[2]"), (strains, None, "alpha")]
    runs.append((hc.Chain(sites=2, units=steel), {"u": [1e-6, 0.0]}, "alpha"))
    for what, y0, name in runs:
        with pytest.raises(hc.Error):
            hc.run(what, y0=y0, until=1e-3, derivatives=name, on_sample=lambda t, _: seen.append(t))
    assert not seen


def test_gravity_leaves_the_amplitude() -> None:
    # Truth: a bead that flies; its weight does not change with its start.
    chain = hc.Chain(sites=1, gravity=0.1)
    got = hc.run(chain, y0={"pu": [1.0]}, until=2.0, tol=1e-12, derivatives="amplitude").derivatives["amplitude"]
    assert abs(got["u"][0] - 2) < 1e-10 and abs(got["pu"][0] - 1) < 1e-10
    with pytest.raises(hc.ParameterError, match="without gravity"):
        hc.run(chain, y0={"pu": [1.0]}, until=2.0, derivatives="mass[0]")
