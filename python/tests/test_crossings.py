"""Conditions that a run looks for: times against closed forms, callbacks, ends, and what goes on from there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hertzchain as hc

SPRING = hc.Chain(sites=1, kappa=1, rho=float("inf"))
LINEAR = hc.Chain(sites=2, alpha=1.0)
MEET = {"u": [0.0, 1.0], "pu": [1.0, 0.0]}


@pytest.mark.parametrize("how", [{"tol": 1e-12}, {"tol": 1e-12, "method": "dop853"}, {"method": "strang-linear", "step": 0.3}])
def test_crossings_of_a_bead_on_a_spring(how: dict[str, Any]) -> None:
    # Truth: u = sin t.
    told: list[tuple[dict[str, float], Any]] = []
    looked = ["u[0] = 0.5", "u_dot[0] < 0"]
    run = hc.run(SPRING, y0={"pu": [1.0]}, until=12.0, crossings=looked, on_crossing=lambda *one: told.append(one), **how)
    low, half = np.arcsin(0.5), np.pi / 2
    want = np.array([low, half, np.pi - low, 2 * np.pi + low, 5 * half, 3 * np.pi - low])
    assert run.conditions == looked and run.ended_by is None and run.t_end == 12.0
    assert run.crossings["condition"].tolist() == [0, 1, 0, 0, 1, 0]
    assert run.crossings["rising"].tolist() == [True, False, False, True, False, False]
    assert np.abs(run.crossings["t"] - want).max() < 1e-10
    assert [one["t"] for one, _ in told] == run.crossings["t"].tolist()
    assert np.abs([state - [np.sin(one["t"]), np.cos(one["t"])] for one, state in told]).max() < 1e-10
    assert np.abs(run(run.crossings["t"])["u"][:, 0] - np.sin(run.crossings["t"])).max() < 1e-10
    bare = hc.run(SPRING, y0={"pu": [1.0]}, until=12.0, **how)
    assert np.array_equal(bare.u, run.u) and len(bare.crossings) == 0


def test_a_condition_ends_a_run_and_bonds_count_from_the_first() -> None:
    # Truth: a linear contact from t = 1 on has the overlap sin(sqrt(2) (t - 1))/sqrt(2).
    run = hc.run(LINEAR, y0=MEET, until=9.0, tol=1e-12, events=True, stop="overlap[0] < 0.3")
    end = 1 + (np.pi - np.arcsin(0.3 * np.sqrt(2))) / np.sqrt(2)
    assert abs(run.t_end - end) < 1e-10 and run.ended_by == "overlap[0] < 0.3" and run.failure is None
    assert abs(run.end["u"][0] - run.end["u"][1] - 0.3) < 1e-14 and run.t[-1] <= run.t_end
    (contact,) = run.contacts
    assert abs(contact["onset"] - 1) < 1e-10 and np.isnan(contact["release"])
    # Going on does not find the same crossing again.
    rest = run.resume(9.0, stop="overlap[0] < 0.3")
    assert rest.t_end == 9.0 and abs(rest.end["pu"][1] - 1) < 1e-10 and rest.ended_by is None


def test_a_function_ends_a_run_or_raises() -> None:
    times: list[float] = []

    def third(crossing: dict[str, float], _: Any) -> bool:
        times.append(crossing["t"])
        return len(times) == 3

    run = hc.run(SPRING, y0={"pu": [1.0]}, until=50.0, tol=1e-10, crossings="u[0] > 0.5", on_crossing=third)
    assert run.t_end == times[2] == run.crossings["t"][2] and run.ended_by == "u[0] > 0.5"
    with pytest.raises(ZeroDivisionError) as caught:
        hc.run(SPRING, y0={"pu": [1.0]}, until=50.0, tol=1e-10, crossings="u[0] > 0.5", on_crossing=lambda *_: 1 / 0)
    partial = caught.value.partial  # type: ignore[attr-defined]
    assert abs(partial.t_end - np.arcsin(0.5)) < 1e-8 and partial.ended_by is None


def test_conditions_of_a_scene_in_si_units_and_of_strains() -> None:
    scene = hc.Scene.load("granular-crystal")
    for dimensionless in (False, True):
        run = hc.run(scene, until=7e-4, tol=1e-8, stop="u[0] > 5e-9", dimensionless=dimensionless)
        assert run.units is not None
        by = run.units["length_m"] if dimensionless else 1.0
        assert abs(run.end["u"][0] * by - 5e-9) < 1e-20 and run.crossings["t"][0] == run.t_end
    ring = hc.run(hc.Scene.load("tw-q15"), tol=1e-9, stop="u[3] > 0")
    assert abs(ring.end["x"][3]) < 1e-14 and ring.end["vx"][3] > 0


def test_a_simulation_stops_where_a_condition_is_met() -> None:
    sim = hc.Simulation(SPRING, {"pu": [1.0]}, tol=1e-12)
    for turn in range(3):
        sim.integrate(100.0, stop="u[0] > 0.5")
        assert abs(sim.t - np.arcsin(0.5) - 2 * np.pi * turn) < 1e-9
    sim.integrate(100.0)
    assert sim.t == 100.0


def test_many_runs_begin_at_any_time_and_go_on() -> None:
    # Truth: each alone; a drive acts at its phase.
    shaken = {"site": 0, "kind": "moved", "amplitude": 0.05, "omega": 1.3}
    driven = hc.Chain(sites=4, boundary="fixed", precompression=0.1, drive=[shaken])
    plain = hc.Chain(sites=4, kappa=1, rho=0.5)
    kicks = np.outer([0.0, 0.1, 0.2], [0.0, 0, 1, 0])
    for chain, how in ((driven, {"tol": 1e-10}), (plain, {"method": "verlet", "step": 0.01})):
        many = hc.run_many(chain, {"pu": kicks}, until=2.0, at=4, **how)
        rest = many.resume(5.0, at=[3.0, 5.0])
        assert rest.t.tolist() == [3.0, 5.0] and rest.u.shape == (3, 2, 4)
        for one, other in zip(many, rest):
            alone = one.resume(5.0, at=[3.0, 5.0])
            assert np.array_equal(alone.u, other.u) and alone.end["u"].tolist() == other.end["u"].tolist()
        later = hc.run_many(chain, [one.end for one in many], t0=2.0, until=5.0, at=[3.0, 5.0], **how)
        assert np.array_equal(later.u, rest.u)
    with pytest.raises(hc.ParameterError, match="t0 = 5.0 is not valid: at least zero, and before until = 5.0"):
        many.resume(5.0).resume(5.0)
    failing = hc.Chain(sites=3, kappa=1.0, rho=1e-8)
    with pytest.warns(hc.RunWarning):
        broken = hc.run_many(failing, {"u": [[0, 0, 0.0], [0, 0, 0.1]]}, until=100.0, method="verlet", step=0.1)
    with pytest.raises(hc.ParameterError, match="member 1 has not reached the end"):
        broken.resume(200.0)
