"""Runs that go on: start times, drives at their phase, resuming, simulations, states between samples."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hertzchain as hc

DRIVEN: dict[str, Any] = {
    "sites": 6,
    "boundary": "fixed",
    "precompression": 0.1,
    "beads": {"drag": [0.0] + [0.05] * 5},
    "drive": [{"site": 0, "kind": "moved", "amplitude": 0.05, "omega": 1.3, "phase": 0.4}],
}
STEEL = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3}


def off(one: hc.Trajectory, other: hc.Trajectory) -> float:
    return max(float(np.abs(array - other.end[name]).max()) for name, array in one.end.items())


@pytest.mark.parametrize("how", [{"tol": 1e-11}, {"tol": 1e-11, "method": "dop853"}, {"method": "verlet", "step": 1e-4}])
def test_a_driven_chain_goes_on_at_its_phase(how: dict[str, Any]) -> None:
    # Truth: the run in one piece. A restart at time zero is off by the phase of the drive.
    chain = hc.Chain(**DRIVEN)
    whole = hc.run(chain, y0={}, until=12.0, at=[12.0], **how)
    half = hc.run(chain, y0={}, until=5.0, **how)
    tolerance = 1e-6 if "step" in how else 1e-8
    for rest in (hc.run(chain, y0=half.end, t0=5.0, until=12.0, **how), half.resume(12.0)):
        assert rest.t[0] == 5.0 and rest.t[-1] == rest.t_end == 12.0 and off(rest, whole) < tolerance
        assert rest.integrator == half.integrator
    with pytest.raises(hc.ParameterError, match="a bead that is moved begins as its drive does"):
        hc.run(chain, y0=half.end, until=7.0, **how)
    # A chain of its own with the drive ahead by its phase is another truth.
    ahead = hc.Chain(**{**DRIVEN, "drive": [{**DRIVEN["drive"][0], "phase": 0.4 + 5.0 * 1.3}]})
    start = {name: array * (np.arange(6) > 0) for name, array in half.end.items()}
    assert off(hc.run(ahead, y0=start, until=7.0, **how), whole) < tolerance


def test_parts_of_a_ramp_and_of_a_run_in_si_units() -> None:
    push = [{"site": 0, "kind": "pushed", "amplitude": 100.0, "omega": 3e4, "ramp": 4e-4}]
    chain = hc.Chain(sites=4, boundary="fixed", units={**STEEL, "static_load": 50.0}, drive=push)
    whole = hc.run(chain, y0={}, until=6e-4, tol=1e-11)
    size = np.abs(whole.u).max()
    part = hc.run(chain, y0={}, t0=0.0, until=1e-4, tol=1e-11)
    for until in (2.5e-4, 6e-4):
        part = part.resume(until, at=3)
        assert np.isclose(part.t_end, until, rtol=1e-15)
    assert np.abs(part.end["u"] - whole.end["u"]).max() < 1e-8 * size
    bare = hc.run(chain, y0={}, t0=0.0, until=3e-4, tol=1e-11, dimensionless=True)
    again = bare.resume(6e-4 / chain.scene({}, 6e-4).units["time_s"], at=3)  # type: ignore[index]
    assert not again.si and np.abs(again.end["u"] * again.units["length_m"] - whole.end["u"]).max() < 1e-8 * size  # type: ignore[index]


def test_start_times_are_checked() -> None:
    chain = hc.Chain(sites=3)
    for options, words in (
        ({"t0": 2.0, "until": 2.0}, "t0 = 2.0 is not valid: at least zero, and before until = 2.0"),
        ({"t0": -1.0, "until": 2.0}, "t0 = -1.0"),
        ({"t0": float("nan"), "until": 2.0}, "t0 = nan"),
        ({"t0": 1.0, "until": 2.0, "at": [0.5]}, "from the start to the end of the run"),
    ):
        with pytest.raises(hc.ParameterError, match=words):
            hc.run(chain, y0={}, **options)
    with pytest.raises(hc.ParameterError, match="without y0"):
        hc.run(hc.Scene.load("tw-q15"), t0=1.0)


@pytest.mark.parametrize("how", [{"tol": 1e-11}, {"method": "strang-linear", "step": 1e-3}])
def test_a_trajectory_has_a_state_at_every_time(how: dict[str, Any]) -> None:
    # Truth: another run with samples at these times.
    chain = hc.Chain(sites=5, kappa=1, rho=0.5)
    start, times = {"pu": np.eye(5)[0]}, np.array([7.9, 0.0, 3.3, 3.31, 8.0, 0.01])
    run = hc.run(chain, y0=start, until=8.0, at=16, **how)
    want = hc.run(chain, y0=start, until=8.0, at=np.sort(times), **how)
    got = run(times)
    for name in ("u", "v", "pu", "pv"):
        wanted = getattr(want, name)[np.searchsorted(np.sort(times), times)]
        assert np.abs(got[name] - wanted).max() < (1e-9 if "tol" in how else 1e-6), name
    assert all(np.array_equal(run(run.t)[name], getattr(run, name)) for name in got)
    assert np.array_equal(run(3.3)["u"], got["u"][2]) and run(3.3)["u"].shape == (5,)
    # Without kept states the run is made again, with the same bits.
    bare = hc.run(chain, y0=start, until=8.0, states=False, at=16, **how)
    assert np.array_equal(bare(np.sort(times))["u"], want.u)
    for outside in (-0.1, 8.1, float("nan")):
        with pytest.raises(hc.ParameterError, match="the span of the run"):
            run(outside)
    later = run.resume(9.0, at=4)
    assert np.allclose(later(8.0)["u"], run.u[-1], rtol=1e-14) and later(8.4)["u"].shape == (5,)


def test_a_trajectory_in_si_units_and_an_exact_one_have_states_between_samples() -> None:
    chain = hc.Chain(sites=4, units=STEEL)
    strike = {"pu": chain.masses[0] * [0.5, 0, 0, 0]}
    want = hc.run(chain, y0=strike, until=8e-5, tol=1e-11, at=[3.1e-5])
    for dimensionless in (False, True):
        run = hc.run(chain, y0=strike, until=8e-5, tol=1e-11, at=7, dimensionless=dimensionless)
        assert run.units is not None
        by = run.units["length_m"] if dimensionless else 1.0
        time = 3.1e-5 / (run.units["time_s"] if dimensionless else 1.0)
        assert np.abs(run(time)["u"] * by - want.u[0]).max() < 1e-8 * np.abs(want.u).max()
    exact = hc.run(hc.Scene.load("trivial-breather"))
    assert exact.integrator == "closed-form"
    again = hc.run(hc.Scene.load("trivial-breather"), at=[0.37, 1.2])
    assert np.array_equal(exact([0.37, 1.2])["u"], again.u)


def test_a_simulation_goes_on_is_changed_saved_and_copied(tmp_path: Path) -> None:
    chain = hc.Chain(**DRIVEN)
    sim = hc.Simulation(chain, {}, tol=1e-11)
    for until in (2.0, 5.0):
        sim.integrate(until)
    sim.save(tmp_path / "sim.npz")
    read, copied = hc.Simulation.load(tmp_path / "sim.npz"), sim.copy()
    assert read == sim == copied and read.t == 5.0 and read.chain == chain
    whole = hc.run(chain, y0={}, until=12.0, tol=1e-11)
    ends = [one.integrate(12.0) for one in (sim, read, copied)]
    assert all(np.array_equal(ends[0].end[name], end.end[name]) for end in ends for name in end.end)
    assert off(ends[0], whole) < 1e-8
    # What is changed counts; a copy is not changed by it.
    heavy = dataclasses.replace(chain, beads={"mass": [1.0] + [2.0] * 5, "drag": [0.0] + [0.05] * 5})
    copied.chain = heavy
    copied.state["pu"][3] += 0.1
    want = hc.run(heavy, y0=copied.state, t0=12.0, until=13.0, tol=1e-11)
    assert np.array_equal(copied.integrate(13.0).end["u"], want.end["u"]) and sim.t == 12.0
    for path in (tmp_path / "none.npz", tmp_path / "text.npz"):
        (tmp_path / "text.npz").write_text("no archive")
        with pytest.raises(hc.FileError):
            hc.Simulation.load(path)


@pytest.mark.filterwarnings("ignore::hertzchain.RunWarning")
def test_a_failed_part_leaves_a_simulation_as_it_was() -> None:
    sim = hc.Simulation(hc.Chain(sites=3, kappa=1.0, rho=1e-8), {"u": [0, 0, 0.1]}, method="verlet", step=0.1)
    assert sim.integrate(100.0).failure is not None
    assert sim.t == 0.0 and sim.state["u"].tolist() == [0.0, 0.0, 0.1]


def test_a_simulation_of_a_scene_and_of_a_ring_of_strains() -> None:
    scene = hc.Scene.load("tw-q15").until(3.0)
    sim = hc.Simulation(scene, tol=1e-11)
    assert list(sim.state) == ["x", "y", "vx", "vy"]
    sim.integrate(1.0)
    assert np.abs(sim.integrate(3.0).end["x"] - hc.run(scene, tol=1e-11).end["x"]).max() < 1e-10
    with pytest.raises(hc.ParameterError, match="a chain needs a state"):
        hc.Simulation(hc.Chain(sites=2))
    with pytest.raises(hc.ParameterError, match="no resonator of this chain moves"):
        hc.Simulation(hc.Chain(sites=2), {"v": [1.0, 0.0]})
