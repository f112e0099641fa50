"""Wrong inputs: each is refused with a message that names the value and the rule."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hertzchain as hc

NAN, INF = float("nan"), float("inf")
CHAIN = hc.Chain(sites=3)
HEAVY = hc.Chain(sites=3, kappa=1.0, rho=1.0)
RING = hc.Chain(sites=4, kappa=1.0, rho=1.0, boundary="strain-ring")
MOVED = hc.Chain(
    sites=3,
    kappa=1.0,
    beads={"rho": [0.0, 1.0, 1.0]},
    drive=[{"site": 0, "kind": "moved", "amplitude": 0.1, "omega": 1.0}],
)
LOSSY = hc.Chain(sites=3, boundary="free", bonds={"viscoelastic": 0.1})
WAVE = hc.Scene.load("tw-q15")
REST = {"u": np.zeros(3)}
MASKED = np.ma.array([0.0, 0.5, 0.0], mask=[False, True, False])


def run(**options: Any) -> Any:
    return hc.run(CHAIN, **{"y0": REST, "until": 1.0, **options})


def wave(**numbers: Any) -> Any:
    return hc.TravellingWave(**{"q": 0.5, "a": 1.0, "b": 0.0, "epsilon": 0.01, **numbers})


CASES: list[tuple[Callable[[], Any], str]] = [
    # Chains.
    (lambda: hc.Chain(sites=0), "sites"),
    (lambda: hc.Chain(sites=-1), "sites = -1"),
    (lambda: hc.Chain(sites=2.5), "sites = 2.5"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=True), "sites = True"),
    (lambda: hc.Chain(sites=2**70), "below 2\\^63"),
    (lambda: hc.Chain(sites=3, alpha=0.0), "alpha"),
    (lambda: hc.Chain(sites=3, alpha=NAN), "alpha = NaN"),
    (lambda: hc.Chain(sites=3, alpha="1.5"), "alpha = '1.5'"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=3, kappa=-1.0), "kappa = -1"),
    (lambda: hc.Chain(sites=3, kappa=1j), "kappa"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=3, rho=-2.0), "rho = -2"),
    (lambda: hc.Chain(sites=3, boundary="rng"), "did you mean \"ring\""),
    (lambda: hc.Chain(sites=3, boundary=3), "boundary = 3"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=3, precompression=NAN), "precompression"),
    # What differs from bead to bead.
    (lambda: hc.Chain(sites=3, beads=[1, 2, 3]), "beads = \\[1, 2, 3\\] is not valid: a dictionary"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=3, beads={"masss": 1.0}), "'masss' is not valid: keys are mass, kappa"),
    (lambda: hc.Chain(sites=3, beads={"mass": np.ones(2)}), "beads.mass with 2 numbers is not valid: 3 of them"),
    (lambda: hc.Chain(sites=3, beads={"mass": np.ones((3, 1))}), "beads.mass of shape \\(3, 1\\)"),
    (lambda: hc.Chain(sites=3, beads={"mass": [1.0, NAN, 1.0]}), "mass"),
    (lambda: hc.Chain(sites=3, beads={"mass": [1.0, -1.0, 1.0]}), "beads.mass = -1"),
    (lambda: hc.Chain(sites=3, beads={"mass": 0.0}), "beads.mass = 0"),
    (lambda: hc.Chain(sites=3, beads={"mass": "heavy"}), "mass"),
    (lambda: hc.Chain(sites=3, beads={"mass": [1j, 1, 1]}), "beads.mass of type complex128"),
    (lambda: hc.Chain(sites=3, beads={"mass": [2**53 + 1, 1, 1]}), "doubles cannot hold"),
    (lambda: hc.Chain(sites=3, beads={"mass": np.array([1, 2, None])}), "beads.mass of type object"),
    (lambda: hc.Chain(sites=3, beads={"mass": {"pattrn": [1.0]}}), "pattrn"),
    (lambda: hc.Chain(sites=3, beads={"mass": {"taper": 0.9, "value": 1.0}}), "taper|value"),
    (lambda: hc.Chain(sites=3, beads={"drag": -0.1}), "beads.drag = -0.1"),
    (lambda: hc.Chain(sites=3, beads={"dashpot": 0.1}), "dashpot"),
    (lambda: hc.Chain(sites=3, kappa=1.0, beads={"rho": [1.0, -1.0, INF]}), "rho = -1"),
    (lambda: hc.Chain(sites=4, boundary="strain-ring", beads={"mass": np.ones(4)}), "strain ring"),
    (lambda: hc.Chain(sites=3, bonds={"contact": np.ones(3)}), "bonds.contact with 3 numbers is not valid: 2"),
    (lambda: hc.Chain(sites=3, boundary="fixed", bonds={"contact": np.ones(3)}), "3 numbers is not valid: 4"),
    (lambda: hc.Chain(sites=3, bonds={"wall": 1.0}), "bonds.wall"),
    (lambda: hc.Chain(sites=3, bonds={"alpha": 0.0}), "alpha = 0"),
    (lambda: hc.Chain(sites=3, bonds={"overlap": 0.1}), "overlap"),
    (lambda: hc.Chain(sites=3, bonds={"viscoelastic": 0.1, "dashpot": 0.1}), "viscoelastic"),
    (lambda: hc.Chain(sites=3, bonds={"table": 2.0}), "bonds.table = 2.0 is not valid: a dictionary"),
    (lambda: hc.Chain(sites=3, bonds={"table": {"rows": [0]}}), "bonds.table with the key 'rows'"),
    (
        lambda: hc.Chain(sites=3, bonds={"table": {"overlap": [0, 1], "force": [0, -1]}}),
        "bonds.table.force = -1 \\(entry 1\\)",
    ),
    (lambda: hc.Chain(sites=3, bonds={"terms": 2.0}), "bonds.terms = 2.0 is not valid: a list of dictionaries"),
    (lambda: hc.Chain(sites=3, bonds={"terms": [{"alpha": 2.5}]}), "missing field `contact`"),
    (lambda: hc.Chain(sites=3, bonds={"terms": [{"contact": 1, "beta": 2}]}), "bonds.terms with the key 'beta'"),
    (lambda: hc.Chain(sites=3, bonds={"terms": [{"contact": -1, "alpha": 2}]}), "bonds.terms.contact = -1 \\(entry 0\\)"),
    (lambda: hc.Chain(sites=3, bonds={"terms": [{"contact": np.ones(3), "alpha": 2}]}), "contact with 3 numbers"),
    (lambda: hc.Chain(sites=3, drive={"site": 0}), "a list of dictionaries"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=3, drive=[{"site": 0, "kind": "shaken", "amplitude": 1.0, "omega": 1.0}]), "shaken"),
    (lambda: hc.Chain(sites=3, drive=[{"site": 9, "kind": "moved", "amplitude": 1.0, "omega": 1.0}]), "site"),
    (lambda: hc.Chain(sites=3, drive=[{"site": 0.5, "kind": "moved"}]), "drive.site = 0.5"),
    (lambda: hc.Chain(sites=3, drive=[{"kind": "moved", "amplitude": 1.0, "omega": 1.0}]), "site"),
    (lambda: hc.Chain(sites=3, drive=[{"site": 0, "kind": "moved"}]), "drive.amplitude"),
    (lambda: hc.Chain(sites=3, drive=[{"site": 0, "kind": "pushed", "velocity": 1.0}]), "drive.velocity"),
    (lambda: hc.Chain(sites=3, gravity=1.0, tilt=100.0), "tilt = 100"),
    (lambda: hc.Chain(sites=3, units={"system": "SI", "radius": 0.01}), "density|young"),
    (lambda: hc.Chain(sites=3, units={"radius": 0.01}), "units.system is missing"),
    (lambda: run(y0={"pu": [0.0, 1.0]}), "pu with 2 numbers"),
    (lambda: hc.run(MOVED, y0={"u": np.zeros(3), "pv": [1.0, 0, 0]}, until=1.0), "pv = 1.0 of site 0"),
    (lambda: hc.run(MOVED, y0={"u": np.zeros(3), "v": [0.1, 0, 0]}, until=1.0), "v = 0.1 at site 0"),
    (lambda: hc.run(LOSSY, y0=REST, until=1.0, step=0.1, method="verlet"), "dop853"),
    (lambda: hc.monodromy(LOSSY, y0=REST, until=1.0), "dissipate"),
    # Scenes.
    (lambda: hc.Scene.load("tw-q16"), "did you mean"),
    (lambda: hc.Scene.load("no/such/file.toml"), "no/such/file.toml"),
    (lambda: hc.Scene.load("tw-q15", {"chain.rhoo": 1}), "rhoo"),
    (lambda: hc.Scene.load("tw-q15", {"chain.rho": -1}), "rho = -1"),
    (lambda: hc.Scene.load("tw-q15", {"chain.rho": None}), "change = None"),
    (lambda: hc.Scene.from_toml("chain = 3"), "chain"),
    (lambda: hc.Scene.from_toml(3), "text = 3"),  # type: ignore[arg-type]
    (lambda: WAVE.until(-1.0), "until = -1"),
    (lambda: WAVE.until(NAN), "until = NaN"),
    # States.
    (lambda: hc.run(CHAIN, until=1.0), "y0 = None"),
    (lambda: hc.run(CHAIN, y0=REST), "until = None"),
    (lambda: run(y0={"w": np.zeros(3)}), "'w'"),
    (lambda: run(y0={"x": np.zeros(3)}), "keys are u, v, pu, pv"),
    (lambda: hc.run(RING, y0={"u": np.zeros(4)}, until=1.0), "keys are x, y, vx, vy"),
    (lambda: run(y0={"u": np.zeros(2)}), "u with 2 numbers is not valid: 3"),
    (lambda: run(y0={"u": np.zeros((3, 1))}), "shape \\(3, 1\\)"),
    (lambda: run(y0={"u": [0, NAN, 0]}), "u = NaN"),
    (lambda: run(y0={"pu": [0, INF, 0]}), "u_dot = inf"),
    (lambda: run(y0={"u": ["a", "b", "c"]}), "u of type"),
    (lambda: run(y0={"u": [1j, 0, 0]}), "u of type complex128"),
    (lambda: run(y0={"u": [2**53 + 1, 0, 0]}), "doubles cannot hold"),
    (lambda: run(y0={"u": np.array([1, 2, None])}), "u of type object"),
    (lambda: run(y0={"u": [[1], [2, 3], [4]]}), "u is not valid"),
    (lambda: run(y0={"v": np.zeros(3)}), "v"),
    (lambda: run(y0=np.zeros(7)), "y0 with 7 numbers is not valid: 6"),
    (lambda: hc.run(HEAVY, y0=np.zeros(6), until=1.0), "12 of them"),
    # Runs.
    (lambda: run(y0={"u": MASKED}), "u is not valid: an array without a mask"),
    (lambda: run(y0={"u": [MASKED[0], 0.0, np.ma.masked]}), "without a mask"),
    (lambda: run(until=np.ma.masked), "until = masked"),
    (lambda: run(at=MASKED), "at is not valid: an array without a mask"),
    (lambda: run()(MASKED), "t is not valid: an array without a mask"),
    (lambda: hc.run_many(CHAIN, {"u": np.ma.array([MASKED])}, until=1.0), "without a mask"),
    (lambda: hc.Chain(sites=3, beads={"mass": MASKED}), "beads.mass is not valid: an array without a mask"),
    (lambda: hc.Scene.load("impact", {"beads.mass": MASKED}), "without a mask"),
    (lambda: hc.studies.modes("impact", set={"beads.mass": MASKED}), "without a mask"),
    (lambda: run(events="yes"), "events = 'yes' is not valid: True or False"),
    (lambda: run(states=1), "states = 1"),
    (lambda: run(dimensionless="no"), "dimensionless = 'no'"),
    (lambda: run().resume(2.0, events="yes"), "events = 'yes'"),
    (lambda: hc.run_many(CHAIN, [REST], until=1.0, states="yes"), "states = 'yes'"),
    (lambda: WAVE.plan("yes"), "events = 'yes'"),  # type: ignore[arg-type]
    (lambda: hc.run("tw-q15"), "a Scene or a Chain"),  # type: ignore[arg-type]
    (lambda: run(until=0.0), "until = 0"),
    (lambda: run(until="1"), "until = '1'"),
    (lambda: run(method="verlett"), "did you mean \"verlet\""),
    (lambda: run(method=4), "method = 4"),
    (lambda: run(tol=0.0), "tol"),
    (lambda: run(tol=1.0), "tol"),
    (lambda: run(tol=NAN), "tol"),
    (lambda: run(method="verlet", tol=1e-9), "equal steps"),
    (lambda: run(method="verlet", step=-0.1), "step = -0.1"),
    (lambda: run(method="verlet", step=1e-30), "steps"),
    (lambda: run(method="dop853", step=0.1), "tol"),
    (lambda: run(at=[0.5, 0.2]), "ascending"),
    (lambda: run(at=[2.0]), "from zero to the end"),
    (lambda: run(at=[NAN]), "times = NaN"),
    (lambda: run(at=0), "at = 0"),
    (lambda: run(on_sample=3), "on_sample = 3"),
    (lambda: run(on_contact=3), "on_contact = 3"),
    (lambda: run(on_crossing=3, stop="u[0] > 1"), "on_crossing = 3"),
    (lambda: run(on_crossing=print), "on_crossing is not valid without crossings or stop"),
    (lambda: run(crossings=3), "crossings = 3"),
    (lambda: run(stop=["u[0] > 1", 3]), "stop = 3"),
    (lambda: run(stop="u[3] > 1"), "stop = u\\[3\\] > 1 of sites 0 to 2 is not valid"),
    (lambda: run(crossings="overlap[2] = 0"), "overlap\\[2\\] = 0 of bonds 0 to 1 is not valid"),
    (lambda: run(stop="overlap[18446744073709551615] > 0"), "of bonds 0 to 1 is not valid"),
    (lambda: run(crossings="v[0] = 0"), "no resonator moves there"),
    (lambda: run(crossings="u[0] + 1"), "a quantity, its place, a sign and a number"),
    (lambda: run(derivatives="kappa"), "resonators have no springs here"),
    (lambda: run(derivatives="rho"), "no resonator moves"),
    (lambda: run(derivatives="mass[3]"), "a site of the chain"),
    (lambda: run(derivatives="beta"), "unknown derivative"),
    (lambda: hc.run(LOSSY, y0=REST, until=1.0, derivatives="alpha"), "do not dissipate"),
    (lambda: hc.run(WAVE, derivatives="alpha"), "displacements"),
    (lambda: hc.run(hc.Chain(sites=3, alpha=1.0), y0=REST, until=1.0, derivatives="alpha"), "above 1"),
    (lambda: hc.run(hc.Scene.load("trivial-breather"), stop="u[0] > 1"), "an exact solution has no log"),
    # Waves, breathers, orbits.
    (lambda: wave(epsilon=None), "epsilon and detuning"),
    (lambda: wave(detuning=0.1), "epsilon and detuning"),
    (lambda: wave(a=-1.0), "a = -1"),
    (lambda: wave(rho=0.0), "rho = 0"),
    (lambda: hc.TravellingWave.of(hc.Scene.load("impact")), "travelling-wave"),
    (lambda: hc.BrightBreather("side", 0.01, 40), "did you mean \"site\""),
    (lambda: hc.BrightBreather("site", 0.01, 3), "sites = 3"),
    (lambda: hc.BrightBreather("site", 0.01, 41).scene(1, boundary="strain-ring"), "strain-ring"),
    (lambda: hc.DarkBreather("middle").solve(), "unknown center"),
    (lambda: hc.DarkBreather(sites=10).solve(), "sites = 10"),
    (lambda: hc.DarkBreather(omega_b=1.9).solve(), "omega_b = 1.9"),
    (lambda: hc.continue_branch(hc.DarkBreather(), to=2.1), "omega_b = None"),
    (lambda: hc.continue_branch(hc.DarkBreather(omega_b=2.05), "q", to=2.1), "vary = 'q'"),
    (lambda: hc.continue_branch(hc.DarkBreather(omega_b=2.05), to=1.0), "to = 1"),
    (lambda: hc.continue_branch(3, to=1.0), "orbit = 3"),  # type: ignore[arg-type]
    (lambda: hc.Branch.load("no-such-branch.npz"), "no-such-branch.npz"),
    (lambda: hc.compare(WAVE, "verlet"), "a list of names"),
    (lambda: hc.compare(WAVE, 3), "methods = 3 is not valid: a text, or a list of them"),  # type: ignore[arg-type]
    (lambda: hc.TravellingWave.of("tw-q15"), "scene = 'tw-q15' is not valid: a Scene"),  # type: ignore[arg-type]
    (lambda: hc.Scene.load("tw-q15", "chain.rho=3"), "changes = 'chain.rho=3'"),  # type: ignore[arg-type]
    (lambda: hc.sweep(abs, 3), "points = 3 is not valid: a list of them"),  # type: ignore[arg-type]
    (lambda: hc.Chain(sites=np.zeros(2)), "a whole number, at least zero"),  # type: ignore[arg-type]
    (lambda: hc.compare(WAVE, ["verlett"]), "did you mean"),
    (lambda: hc.monodromy(CHAIN, y0=REST, until=1.0, tol=0.0), "tol"),
    # Modulation theory.
    (lambda: hc.dps.g(NAN, 1.0), "b"),
    (lambda: hc.dps.g(MASKED, 1.0), "b is not valid: an array without a mask"),
    (lambda: hc.dps.flow(MASKED, [1.0], force=1.0), "start is not valid: an array without a mask"),
    (lambda: hc.dps.g(0.0, -1.0), "r"),
    (lambda: hc.dps.g(0.0, 1.0, alpha=0.0), "alpha"),
    (lambda: hc.dps.homoclinic("site", alpha=1.0), "alpha = 1"),
    (lambda: hc.dps.dark_profile(sites=4), "sites = 4"),
    (lambda: hc.dps.flow([1, 2], [0.0, 1.0]), "force"),
    (lambda: hc.dps.flow([1, 2], [1.0, 0.0], force=1.0), "ascending"),
    (lambda: hc.dps.flow([1, NAN], [1.0], force=1.0), "start = NaN"),
    (lambda: hc.dps.flow([1, 2], [1.0], force=1.0, ends="fixed"), "ends = 'fixed'"),
    # Sweeps.
    (lambda: hc.sweep(abs, [1], shard="1/2"), "a shard needs a store"),
    (lambda: hc.sweep(abs, [1], shard="3/2", store="s"), "1 <= K <= N"),
    (lambda: hc.sweep(abs, [1], shard=(1, 2), store="s"), "K/N"),  # type: ignore[arg-type]
    (lambda: hc.sweep(abs, [1], out="s"), "a plan a folder"),
    (lambda: hc.sweep(abs, [1], format="png"), "a function has no pictures"),
    (lambda: hc.sweep("no-plan.toml", format="png"), "pictures need a folder"),
    (lambda: hc.sweep("no-plan.toml"), "no-plan.toml"),
    (lambda: hc.sweep_plan("no-plan.toml", shard="0/2"), "shard = 0/2"),
]


@pytest.mark.parametrize(("call", "message"), CASES)
def test_wrong_input_is_refused(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(hc.Error, match=message) as caught:
        call()
    assert not isinstance(caught.value, hc.InternalError)


def test_layouts_and_types_that_convert_without_loss() -> None:
    want = run(y0={"pu": [1.0, 0.0, 0.0]}).end["pu"]
    wide = np.zeros((3, 2))
    wide[0, 1] = 1.0
    for array in (
        [1, 0, 0],
        np.array([1, 0, 0], dtype=np.int8),
        np.array([1, 0, 0], dtype=np.float16),
        np.array([True, False, False]),
        np.array([1, 0, 0], dtype=">f8"),
        wide[:, 1],
        np.array([0.0, 0.0, 1.0])[::-1],
    ):
        assert np.array_equal(run(y0={"pu": array}).end["pu"], want)


def test_values_that_json_cannot_keep_are_refused(tmp_path: Path) -> None:
    for k, value in enumerate((1j, MASKED, np.ma.masked)):
        with pytest.raises(hc.ParameterError, match="a store keeps JSON"):
            hc.sweep(lambda _: value, [1], store=tmp_path / f"s{k}", name="one", version=1)
    with pytest.raises(hc.ParameterError, match="a store keeps JSON"):
        hc.sweep(abs, MASKED, store=tmp_path / "points", version=1)


def test_files_that_cannot_be_read_or_written_are_named(tmp_path: Path) -> None:
    # A folder that is missing, one in the place of a file, a file in the place of a folder.
    (tmp_path / "text").write_text("no archive")
    places = [tmp_path / "missing" / "a.npz", tmp_path / "folder.npz", tmp_path / "text" / "a.npz"]
    places[1].mkdir()
    simulation = hc.Simulation(CHAIN, REST)
    branch = hc.continue_branch(hc.DarkBreather("bond", 2.02, sites=5), to=2.03, step=0.01)
    writers: list[Callable[[Any], Any]] = [simulation.save, branch.save]
    writers.append(lambda path: hc.sweep(abs, [1], store=path, version=1))
    for call in writers:
        for place in places:
            with pytest.raises(hc.FileError, match=place.name):
                call(place)
        with pytest.raises(hc.ParameterError, match="= 3 is not valid: a path"):
            call(3)
    with pytest.raises(hc.FileError, match="text"):
        hc.study("dps homoclinic").save(tmp_path / "text")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.npz", "text"]
    # Truncated archives, at every length.
    for of, load in ((simulation, hc.Simulation.load), (branch, hc.Branch.load)):
        of.save(tmp_path / "whole.npz")
        whole = (tmp_path / "whole.npz").read_bytes()
        for length in (0, 1, *range(50, len(whole), len(whole) // 40 + 1), len(whole) - 1):
            (tmp_path / "part.npz").write_bytes(whole[:length])
            with pytest.raises(hc.FileError, match="part.npz"):
                load(tmp_path / "part.npz")
