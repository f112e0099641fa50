"""Chains whose beads differ: arrays, rules, drives; round trips; callbacks."""

from __future__ import annotations

import pickle
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


# Truth: the scene of the chain, and the chain of the scene; a bead with an on-site spring is a pendulum.
def test_springs_and_contacts_that_may_pull_go_there_and_back() -> None:
    bonds = {"dashpot": 0.1, "beta": 0.25, "pull": True, "spring": [0.5, 0.2], "magnet": 0.1, "distance": 2.0, "decay": 3.0}
    chain = hc.Chain(sites=3, beads={"onsite": [0.0, 0.3, 1.0]}, bonds=bonds)
    again = hc.Scene.from_toml(chain.scene(y0={"u": [0.1, 0.0, 0.0]}, until=5.0).to_toml()).chain
    assert again.bonds is not None and again.beads is not None
    assert again.bonds["pull"] is True and again.bonds["beta"] == 0.25 and again.bonds["spring"].tolist() == [0.5, 0.2]
    assert again.beads["onsite"].tolist() == [0.0, 0.3, 1.0]
    run = hc.run(hc.Chain(sites=1, beads={"onsite": 4.0}), y0={"u": [0.5]}, until=1.0, tol=1e-11, at=[1.0])
    assert np.allclose(run.u[-1], [0.5 * np.cos(2.0)], atol=1e-9)


# Truth: f(g) = g + 3 g is a spring: two beads part after half a period, with exchanged momenta.
def test_contacts_have_sums_of_powers() -> None:
    terms = [{"contact": np.array([3.0]), "alpha": 1.0}]
    chain = hc.Chain(sites=2, alpha=1.0, bonds={"terms": terms})
    run = hc.run(chain, y0={"pu": [1.0, 0.0]}, until=3.0, tol=1e-12, events=True)
    assert np.allclose(run.pu[-1], [0.0, 1.0], atol=1e-10)
    assert run.contacts is not None and abs(run.contacts["release"][0] - np.pi / 8**0.5) < 1e-10
    again = hc.Scene.from_toml(chain.scene(y0={"pu": [1.0, 0.0]}, until=3.0).to_toml()).chain
    other = pickle.loads(pickle.dumps(chain))
    assert other == chain and hash(other) == hash(chain) and chain != hc.Chain(sites=2, alpha=1.0)
    for same in (again, other):
        assert same.bonds is not None and same.bonds["terms"][0]["contact"].tolist() == [3.0]
    with pytest.raises(hc.Error, match="integrator = collocation is not valid: it needs contacts of one power"):
        hc.run(chain, y0={"pu": [1.0, 0.0]}, until=3.0, method="collocation", tol=1e-9)


# Truth: rows of f(g) = 4 g are a spring, as above; the same scene in TOML has the same bits.
def test_contacts_have_tables() -> None:
    rows = {"overlap": np.linspace(0.0, 1.0, 5), "force": [0, 1, 2, 3, 4]}
    chain = hc.Chain(sites=2, bonds={"table": rows})
    run = hc.run(chain, y0={"pu": [1.0, 0.0]}, until=3.0, tol=1e-12, events=True)
    assert np.allclose(run.pu[-1], [0.0, 1.0], atol=1e-10)
    assert run.contacts is not None and abs(run.contacts["release"][0] - np.pi / 8**0.5) < 1e-10
    scene = hc.Scene.from_toml(chain.scene(y0={"pu": [1.0, 0.0]}, until=3.0).to_toml())
    assert np.array_equal(hc.run(scene, tol=1e-12).pu[-1], run.pu[-1])
    again = pickle.loads(pickle.dumps(chain))
    assert again == chain and hash(again) == hash(chain) and chain != hc.Chain(sites=2)
    for same in (scene.chain, again):
        assert same.bonds is not None and same.bonds["table"]["force"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    short = hc.Chain(sites=2, bonds={"table": {"overlap": [0, 0.1], "force": [0, 0.4]}})
    with pytest.warns(hc.RunWarning, match="bond 1 overlaps by .*: the table of its contact law ends at 1e-1"):
        hc.run(short, y0={"pu": [1.0, 0.0]}, until=3.0, tol=1e-9)


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


def test_numbers_in_si_units_are_those_of_the_program(program: Any, tmp_path: Any) -> None:
    flags = ["--until", "6e-4", "--tol", "1e-9", "--events", "--out", str(tmp_path)]
    printed = program("run", "granular-crystal", *flags)
    scene = hc.Scene.load("granular-crystal")
    told: list[Any] = []
    si = hc.run(scene, until=6e-4, tol=1e-9, events=True, on_sample=lambda t, y: told.append((t, y)))
    assert si.si and si.t_end == printed["t"] == 6e-4 and si.driven == printed["driven"]
    assert si.dissipated == printed["dissipated"] and si.end["u"].tolist() == printed["u"] and si.t[-1] == si.t_end
    contacts = np.genfromtxt(tmp_path / "contacts.csv", delimiter=",", names=True)
    assert si.contacts is not None and si.contacts.dtype.names == contacts.dtype.names
    for name in contacts.dtype.names:
        assert np.array_equal(si.contacts[name], contacts[name], equal_nan=True), name
    assert si.end["pu"].tolist() == printed["pu"]
    # Functions are told the same numbers; the fourth quarter are velocities.
    assert [t for t, _ in told] == si.t.tolist() and np.array_equal(told[-1][1][:20], si.u[-1])
    assert np.array_equal(told[-1][1][20:] * scene.chain.masses[0], si.pu[-1])
    # The old form: the same run in the units of the scene.
    bare, units = hc.run(scene, until=6e-4, tol=1e-9, events=True, dimensionless=True), si.units
    assert units is not None and si.energy is not None and bare.energy is not None and not bare.si
    assert np.array_equal(si.u, bare.u * units["length_m"]) and si.t_end == bare.t_end * units["time_s"]
    assert np.allclose(si.energy, bare.energy * units["energy_j"], rtol=1e-15, atol=0)


def test_a_scene_in_si_units_and_its_chain_are_the_same_run() -> None:
    scene = hc.Scene.load("granular-crystal")
    assert scene.end == 2.2e-3 and scene.until(1e-3).end == 1e-3
    mass = 4 / 3 * np.pi * 9.525e-3**3 * 8027.0
    assert np.allclose(scene.chain.masses[0], mass, rtol=1e-15, atol=0)
    run = hc.run(scene, until=7e-4, tol=1e-9, at=[0.0, 3e-4, 7e-4])
    again = hc.run(scene.chain, y0=scene.y0, until=7e-4, tol=1e-9, at=[0.0, 3e-4, 7e-4])
    assert np.array_equal(run.u, again.u) and np.allclose(run.t, [0.0, 3e-4, 7e-4], rtol=1e-15, atol=0)
    # What a run ends with begins another: half and half are the whole, up to the tolerance.
    undriven = hc.Chain(sites=5, units={"system": "SI", "radius": 0.01, "density": 8e3, "young": 2e11, "poisson": 0.3})
    strike = {"pu": undriven.masses[0] * [0.5, 0, 0, 0, 0]}
    half = hc.run(undriven, y0=strike, until=5e-5, tol=1e-12)
    whole = hc.run(undriven, y0=strike, until=1e-4, tol=1e-12)
    rest = hc.run(undriven, y0=half.end, until=5e-5, tol=1e-12)
    assert np.allclose(rest.end["u"], whole.end["u"], rtol=0, atol=1e-9 * np.abs(whole.end["u"]).max())


def test_struck_steel_spheres_follow_newtons_equations_in_si_units() -> None:
    # Truth: a Runge-Kutta method in SI units, here.
    steel = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3}
    mass = 4 / 3 * np.pi * 9.525e-3**3 * 8027.0
    contact = 193e9 * np.sqrt(2 * 9.525e-3) / (3 * (1 - 0.3**2))
    tau = 5e-4

    def rate(y: Any) -> Any:
        force = contact * np.maximum(-np.diff(y[0]), 0.0) ** 1.5
        return np.array([y[1], (np.append(0.0, force) - np.append(force, 0.0)) / mass - y[1] / tau])

    y, h = np.zeros((2, 40)), 4e-4 / 4000
    y[1, 0] = 0.5
    for _ in range(4000):
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        d = rate(y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
    chain = hc.Chain(sites=40, units=steel, beads={"tau": tau})
    run = hc.run(chain, y0={"pu": mass * 0.5 * np.eye(40)[0]}, until=4e-4, tol=1e-11)
    assert np.abs(run.u[-1] - y[0]).max() < 1e-6 * np.abs(y[0]).max()
    assert np.abs(run.pu[-1] / mass - y[1]).max() < 1e-6
    # The same as a scene that is written in SI units only; the program runs it in tests/commands/si.rs.
    text = (
        "[chain]\nsites = 40\nalpha = 1.5\nboundary = 'free'\n[units]\nsystem = 'SI'\nradius = 9.525e-3\n"
        "density = 8027.0\nyoung = 193e9\npoisson = 0.3\n[initial]\nkind = 'single-bead'\nsite = 0\n"
        f"velocity = 0.5\n[span]\nuntil = 4e-4\n[beads]\ntau = {tau}\n"
    )
    scene = hc.run(hc.Scene.from_toml(text), tol=1e-11, events=True)
    assert np.abs(scene.u[-1] - y[0]).max() < 1e-6 * np.abs(y[0]).max()
    assert np.abs(scene.pu[-1] / mass - y[1]).max() < 1e-6
    assert scene.t[-1] == 4e-4 and abs(scene.energy[0] / (0.5 * mass * 0.25) - 1) < 1e-9
    with pytest.warns(RuntimeWarning, match="above 2 % of the speed of sound"):
        hc.run(chain, y0={"pu": mass * 6e3 * np.eye(40)[0]}, until=1e-8, tol=1e-6)
    with pytest.raises(hc.ParameterError, match="beside drag"):
        hc.Chain(sites=3, beads={"tau": 1.0, "drag": 1.0})
    with pytest.raises(hc.ParameterError, match="system"):
        hc.Chain(sites=3, units={**steel, "system": "cgs"})
