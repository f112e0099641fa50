"""Chains whose beads differ: arrays, rules, drives; round trips; callbacks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hertzchain as hc

N = 8
MASS = np.linspace(1.0, 0.5, N)
CHAIN: dict[str, Any] = {
    "sites": N,
    "boundary": "fixed",
    "precompression": 0.1,
    "kappa": 1.0,
    "rho": 0.5,
    "beads": {"mass": MASS, "rho": [0, 1, 1, 1, np.inf, 1, 1, 1], "drag": [0] + [0.01] * (N - 1), "dashpot": [0, 0, 0, 0.1, 0, 0, 0, 0]},
    "bonds": {"contact": np.linspace(1, 2, N + 1), "wall": 3.0, "overlap": {"value": 0.1, "except": [[2, -0.05]]}},
    "drive": [{"site": 0, "kind": "moved", "amplitude": [0.1, 0.05], "omega": [1.0, 2.0], "ramp": 5.0}],
}
START = {"u": 0.05 * np.sin(np.arange(N)) * (np.arange(N) > 0)}


def same(one: hc.Trajectory, other: hc.Trajectory) -> bool:
    return all(np.array_equal(array, other.end[name]) for name, array in one.end.items())


def test_bits_of_the_program(program: Any, tmp_path: Any) -> None:
    scene = hc.Chain(**CHAIN).scene(START, 12.0)
    file = tmp_path / "scene.toml"
    file.write_text(scene.to_toml())
    printed = program("run", str(file), "--tol", "1e-9", "--integrator", "dop853")
    run = hc.run(scene, tol=1e-9, method="dop853")
    for name, array in run.end.items():
        assert array.tolist() == printed[name], name
    assert run.dissipated == printed["dissipated"] and run.driven == printed["driven"]
    assert run.energy_error == printed["energy_error"]


@pytest.mark.parametrize("name", ["dimer", "end-driven", "granular-crystal", "disorder"])
def test_momenta_are_those_of_the_program(program: Any, name: str) -> None:
    printed = program("run", name, "--tol", "1e-8", "--integrator", "dop853")
    run = hc.run(hc.Scene.load(name), tol=1e-8, method="dop853")
    for array, values in run.end.items():
        assert values.tolist() == printed[array], array


def test_round_trip_by_toml_and_by_arrays() -> None:
    chain = hc.Chain(**CHAIN)
    scene = chain.scene(START, 12.0)
    want = hc.run(scene, tol=1e-8)
    assert same(want, hc.run(hc.Scene.from_toml(scene.to_toml()), tol=1e-8))
    # The chain of a scene has rules as arrays.
    again = hc.Scene.from_toml(scene.to_toml()).chain
    assert again.beads is not None and again.bonds is not None
    assert np.array_equal(again.beads["mass"], MASS)
    assert again.bonds["overlap"].tolist() == [0.1, 0.1, -0.05] + [0.1] * (N - 2)
    assert again.bonds["contact"][0] == again.bonds["contact"][-1] == 3.0
    assert same(want, hc.run(again, y0=START, until=12.0, tol=1e-8))


@pytest.mark.parametrize("name", ["dimer", "impurity", "taper", "disorder", "end-driven", "granular-crystal"])
def test_scenes_give_chains_that_run_alike(name: str) -> None:
    scene = hc.Scene.load(name)
    want = hc.run(scene, tol=1e-7, method="dop853")
    got = hc.run(scene.chain, y0=scene.y0, until=scene.end, tol=1e-7, method="dop853")
    for array, values in want.end.items():
        # Velocities go by momenta there and back, which rounds.
        assert np.allclose(values, got.end[array], rtol=0, atol=1e-10), array


# Truth: the closed form of an elastic collision of two free bodies.
def test_unequal_beads_exchange_momentum() -> None:
    m, chain = (2.0, 0.5), hc.Chain(sites=2, beads={"mass": [2.0, 0.5]})
    run = hc.run(chain, y0={"u": [0.0, 1.0], "pu": [2.0, 0.0]}, until=20.0, tol=1e-12)
    want = [m[0] * (m[0] - m[1]) / sum(m), m[1] * 2 * m[0] / sum(m)]
    assert np.allclose(run.pu[-1], want, atol=1e-9)


# Truth: a bead on a spring to a resonator at rest is a pendulum of frequency (kappa/mass)^(1/2).
def test_resonators_at_rest_bead_by_bead() -> None:
    chain = hc.Chain(sites=3, kappa=2.0, beads={"rho": np.inf, "mass": [1.0, 2.0, 4.0], "kappa": [2.0, 2.0, 1.0]})
    run = hc.run(chain, y0={"u": [-3.0, 0.0, 0.5]}, until=1.0, tol=1e-11, at=[1.0])
    want = [-3.0 * np.cos(2.0**0.5), 0.0, 0.5 * np.cos(0.5)]
    assert np.allclose(run.u[-1], want, atol=1e-9)


def test_tables_are_copied_compared_and_cannot_be_changed() -> None:
    mass = np.ones(3)
    one, other = hc.Chain(sites=3, beads={"mass": mass}), hc.Chain(sites=3, beads={"mass": [1, 1, 1]})
    mass[0] = 7.0
    assert one == other and hash(one) == hash(other) and one != hc.Chain(sites=3, beads={"mass": 2.0})
    assert one.beads is not None and one.beads["mass"][0] == 1.0
    with pytest.raises(ValueError):
        one.beads["mass"][0] = 2.0
    with pytest.raises(TypeError):
        one.beads["mass"] = 2.0  # type: ignore[index]
    assert one.masses[0].tolist() == [1, 1, 1] and one.masses[1].tolist() == [0, 0, 0]


@pytest.mark.parametrize("method", ["collocation", "corrected", "dop853", "strang-linear"])
def test_on_contact_tells_of_the_log(method: str) -> None:
    told: list[dict[str, float]] = []
    accuracy: dict[str, Any] = {"step": 0.02} if method in ("corrected", "strang-linear") else {"tol": 1e-9}
    chain = hc.Chain(sites=6)
    start = {"pu": np.eye(6)[0]}
    run = hc.run(chain, y0=start, until=15.0, method=method, on_contact=told.append, **accuracy)
    assert run.contacts is not None
    ended = run.contacts[~np.isnan(run.contacts["release"])]
    assert len(ended) >= 5
    log = {(row["bond"], row["onset"]): row for row in ended}
    assert {(row["bond"], row["onset"]) for row in told} >= set(log)
    for row in told:
        if (row["bond"], row["onset"]) in log:
            assert row["largest_overlap"] == log[row["bond"], row["onset"]]["largest_overlap"]
    # Contacts that are told of but are not in the log are roundings of the largest one.
    assert all((row["bond"], row["onset"]) in log or row["largest_overlap"] < 1e-13 for row in told)


@pytest.mark.parametrize("which", ["on_sample", "on_contact"])
def test_an_exception_stops_the_run_and_carries_what_it_had(which: str) -> None:
    calls = []

    def stop(*given: Any) -> None:
        calls.append(given)
        if len(calls) == 3:
            raise LookupError("enough")

    chain = hc.Chain(sites=60)
    options: dict[str, Any] = {which: stop}
    with pytest.raises(LookupError, match="enough") as caught:
        hc.run(chain, y0={"pu": np.eye(60)[0]}, until=60.0, method="verlet", step=1e-4, **options)
    assert len(calls) == 3
    partial = caught.value.partial  # type: ignore[attr-defined]
    assert isinstance(partial, hc.Trajectory)
    assert 0 < partial.t_end < 60 and len(partial.u) == len(partial.t) and partial.failure


def test_pictures_of_a_sweep_in_both_formats(tmp_path: Any) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('scene = "impact"\nset = ["span.until=2"]\nkeep = ["energy"]\n[[axis]]\nkey = "chain.alpha"\n'
                    "values = [1.5, 2.0, 3.0]\n")
    hc.sweep(plan, out=tmp_path / "out", format=["png", "svg"])
    assert (tmp_path / "out" / "sweep.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / "out" / "sweep.svg").read_text()
    with pytest.raises(hc.UnknownNameError, match="jpg"):
        hc.sweep(plan, out=tmp_path / "other", format="jpg")


def test_si_units_are_those_of_the_program(program: Any, tmp_path: Any) -> None:
    flags = ["--until", "120", "--tol", "1e-9", "--events", "--si", "--out", str(tmp_path)]
    printed = program("run", "granular-crystal", *flags)
    run = hc.run(hc.Scene.load("granular-crystal"), until=120.0, tol=1e-9, events=True)
    si = run.in_si()
    assert si.t_end == printed["t"] and si.driven == printed["driven"] and si.dissipated == printed["dissipated"]
    assert si.end["u"].tolist() == printed["u"] and si.t[-1] == si.t_end
    contacts = np.genfromtxt(tmp_path / "contacts.csv", delimiter=",", names=True)
    assert si.contacts is not None and si.contacts.dtype.names == contacts.dtype.names
    for name in contacts.dtype.names:
        assert np.array_equal(si.contacts[name], contacts[name], equal_nan=True), name
    # The program multiplies in another order.
    assert np.allclose(si.end["pu"], printed["pu"], rtol=4e-16, atol=0)
    units = run.units
    assert units is not None and si.energy is not None and run.energy is not None
    assert np.allclose(si.energy, run.energy * units["energy_j"], rtol=1e-15, atol=0)


def test_a_run_in_si_units_is_the_run_turned_into_them() -> None:
    scene = hc.Scene.load("granular-crystal")
    si = hc.run(scene, until=110.0, tol=1e-6, events=True, si=True)
    run = hc.run(scene, until=110.0, tol=1e-6, events=True).in_si()
    assert np.array_equal(si.t, run.t) and np.array_equal(si.u, run.u) and np.array_equal(si.pu, run.pu)
    assert si.contacts is not None and run.contacts is not None
    assert si.contacts.tobytes() == run.contacts.tobytes() and si.driven == run.driven
    times: list[float] = []
    with pytest.raises(hc.ParameterError, match="units"):
        # Refused before the run begins.
        hc.run(hc.Chain(sites=2), y0={"pu": [1.0, 0.0]}, until=1.0, on_sample=lambda t, _: times.append(t), si=True)
    assert not times

    def stop(t: float, _: Any) -> None:
        if t > 50.0:
            raise LookupError("enough")

    with pytest.raises(LookupError) as caught:
        hc.run(scene, until=110.0, method="verlet", step=1e-2, on_sample=stop, si=True)
    partial, units = caught.value.partial, scene.units  # type: ignore[attr-defined]
    assert units is not None and 50.0 < partial.t[-1] / units["time_s"] < 51.0


def test_si_units_need_spheres() -> None:
    run = hc.run(hc.Chain(sites=2), y0={"pu": [1.0, 0.0]}, until=1.0)
    assert run.units is None
    with pytest.raises(hc.ParameterError, match="units"):
        run.in_si()
    with pytest.raises(hc.ParameterError, match="units"):
        # What is in SI units has none to be turned into.
        hc.run(hc.Scene.load("granular-crystal"), until=110.0, tol=1e-6).in_si().in_si()
