"""Orbits, branches, waves, modulation theory: the bits of the program, and independent truths."""

from __future__ import annotations

import inspect
import math
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hertzchain as hc


# Truth: the defaults that the help of the program prints.
@pytest.mark.parametrize(
    ("function", "command", "options"),
    [
        (hc.DarkBreather, "breather dark", ["center", "rho", "sites", "alpha", "kappa", "precompression", "tol"]),
        (hc.continue_branch, "breather continue", ["weak"]),
        (hc.driven_orbit, "orbit driven", ["turns", "settle"]),
        (hc.compare, "compare", ["max_time"]),
    ],
)
def test_defaults_are_those_of_the_program(function: Callable[..., Any], command: str, options: list[str]) -> None:
    line = [sys.executable, "-m", "hertzchain", *command.split(), "--help"]
    told = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    for option in options:
        flag = option.replace("_", "-")
        _, _, block = told.partition(f"\n      --{flag} ")
        printed = re.search(r"\[default: ([^]]+)\]", block.partition("\n      --")[0])
        default = inspect.signature(function).parameters[option].default
        assert printed is not None and type(default)(printed[1]) == default, option


def test_dark_breather_has_the_bits_of_the_program(program: Any) -> None:
    orbit = hc.DarkBreather("bond", omega_b=2.04, rho=0.5, sites=13, kappa=1.0).solve()
    flags = ["--center", "bond", "--omega-b", "2.04", "--rho", "0.5", "--sites", "13"]
    printed = program("breather", "dark", *flags)
    assert orbit.record == printed
    assert orbit.multipliers.shape == (52,) and orbit.modes.shape == (52, 52)


def test_orbit_returns_and_its_multipliers_are_those_of_the_monodromy() -> None:
    orbit = hc.DarkBreather("site", omega_b=2.05, sites=11).solve()
    scene = orbit.scene()
    run = hc.run(scene, tol=1e-13)
    assert np.abs(run.x[-1] - orbit.x).max() < 1e-12
    matrix = hc.monodromy(scene, tol=1e-13)
    assert abs(max(abs(np.linalg.eigvals(matrix))) - abs(orbit.multipliers).max()) < 1e-7
    # The real part d of an eigenvector: (M - lambda)(M - conj lambda) d = 0.
    d, value = orbit.modes[0], orbit.multipliers[0]
    twice = matrix @ (matrix @ d) - 2 * value.real * (matrix @ d) + abs(value) ** 2 * d
    assert np.abs(twice).max() < 1e-8


def test_branch_has_the_bits_of_the_program_and_comes_back_from_its_file(program: Any, tmp_path: Path) -> None:
    told: list[float] = []
    start = hc.DarkBreather("bond", omega_b=2.02, sites=11).solve()
    branch = hc.continue_branch(start, "omega_b", to=2.04, step=0.005, progress=told.append)
    line = "breather continue --center bond --sites 11 --from 2.02 --to 2.04 --step 0.005 --bifurcations"
    printed = program(*line.split())
    assert branch.record["points"] == printed["points"]
    branch.save(tmp_path / "branch.npz")
    again = hc.Branch.load(tmp_path / "branch.npz")
    assert again.record["points"] == branch.record["points"] and again.end == "reached"
    assert len(branch[1:3]) == 2 and branch[-1].omega_b == 2.04
    assert [point.k_x for point in branch] == branch.column("k_x").tolist()


def bead(amplitude: float = 0.3, omega: float = 1.2, drag: float = 0.2) -> hc.Chain:
    """A damped bead between walls, pushed."""
    push = {"site": 0, "kind": "pushed", "amplitude": amplitude, "omega": omega}
    return hc.Chain(1, boundary="fixed", precompression=1.0, beads={"drag": drag}, drive=[push])


def test_driven_orbit_and_branch_have_the_bits_of_the_program(program: Any) -> None:
    scene = hc.Scene.load("end-driven")
    orbit = hc.driven_orbit(scene)
    assert orbit.record == program("orbit", "driven", "end-driven")
    told: list[float] = []
    branch = hc.continue_branch(orbit, "omega", to=1.32, step=0.01, progress=told.append)
    printed = program("orbit", "continue", "end-driven", "--vary", "omega", "--to", "1.32", "--step", "0.01")
    assert branch.record == printed and len(branch) == len(printed["points"])


def test_driven_orbit_returns_and_is_where_the_run_settles() -> None:
    chain = bead()
    orbit = hc.driven_orbit(chain)
    run = hc.run(chain, y0=orbit.y0, until=orbit.period, tol=1e-13)
    assert abs(run.u[-1] - orbit.y0["u"]).max() < 1e-12 and abs(run.pu[-1] - orbit.y0["pu"]).max() < 1e-12
    # Multipliers of modulus exp(-0.1 * 5.2) let transients fall below 1e-9 in 60 periods.
    settled = hc.run(chain, y0={}, until=60 * orbit.period, tol=1e-11)
    assert abs(settled.u[-1] - orbit.y0["u"]).max() < 1e-9
    assert orbit.stable and abs(np.prod(orbit.multipliers) - np.exp(-0.2 * orbit.period)) < 1e-10


def test_driven_branch_turns_at_folds() -> None:
    branch = hc.continue_branch(hc.driven_orbit(bead(0.5, 2.13, drag=0.1)), "omega", to=1.13)
    kinds = [one["kind"] for one in branch.bifurcations]
    assert branch.end == "reached" and kinds == ["fold", "fold"] and not branch.stable.all()
    with pytest.raises(hc.ParameterError, match="dark breathers"):
        hc.continue_branch(hc.driven_orbit(bead()), "omega", to=1.3, weak=0.1)  # type: ignore[call-overload]
    with pytest.raises(hc.UnknownNameError, match="omega_b"):
        hc.continue_branch(hc.driven_orbit(bead()), "omega_b", to=1.3)
    with pytest.raises(hc.ParameterError, match="drive"):
        hc.driven_orbit(hc.Scene.load("impact"))


def test_driven_orbits_double_their_period() -> None:
    # A bead that rests on a wall under its weight, and is shaken.
    push = {"site": 0, "kind": "pushed", "amplitude": 0.1, "omega": 1.8}
    weight = {"site": 0, "kind": "pushed", "amplitude": -1.0, "omega": 0.0, "phase": math.pi / 2}
    bonds = {"overlap": [1.0, 0.0], "contact": [1.0, 0.0]}
    chain = hc.Chain(1, kappa=0.0, rho=0.0, boundary="fixed", beads={"drag": 0.15}, bonds=bonds, drive=[push, weight])
    branch = hc.continue_branch(hc.driven_orbit(chain), "amplitude", to=2.0, step=0.1, switch=1)
    doubled = branch.switched
    assert doubled is not None and doubled.switched is None and doubled.end == "reached"
    assert [one["kind"] for one in doubled.bifurcations] == ["fold", "fold", "period-doubling"]
    assert doubled.record["points"][0]["turns"] == 2 and abs(doubled.values[0] - 1.833236) < 1e-6


def test_waves_and_breathers_are_those_of_scenes() -> None:
    scene = hc.Scene.load("tw-q15")
    wave = hc.TravellingWave.of(scene)
    assert wave.omega_tw == pytest.approx(2 * math.pi / scene.period, rel=1e-15)
    assert np.allclose(wave.at(0.0, 50)["x"], scene.y0["x"], rtol=0, atol=1e-15)
    breather = hc.BrightBreather("bond", epsilon=0.01, sites=40, rho=1000.0)
    run = hc.run(breather.scene(periods=3), tol=1e-10)
    size = np.abs(run.u).max()
    assert np.abs(run.u[-1] - breather.at(run.t[-1])["u"]).max() < 0.02 * size


def test_averages_against_a_sum_over_a_period() -> None:
    b, r, alpha, kappa = -0.3, 0.7, 1.5, 1.3
    # The trapezoidal rule; its error falls with the number of nodes to the power 5/2.
    angle = 2 * np.pi * (np.arange(1 << 20) + 0.5) / (1 << 20)
    force = np.maximum(-(b - 2 * kappa * r * np.cos(angle)), 0) ** alpha
    assert float(hc.dps.g(b, r, alpha, kappa)) == pytest.approx(force.mean(), abs=1e-12)
    harmonic = (force * np.cos(angle)).mean() / r
    assert float(hc.dps.h(b, r, alpha, kappa)) == pytest.approx(abs(harmonic), abs=1e-11)


def test_homoclinic_and_dark_profiles_solve_their_equations() -> None:
    n, a = hc.dps.homoclinic("site", alpha=1.5)
    strain = np.diff(a)
    force = np.sqrt(abs(strain)) * strain
    middle = slice(1, -1)
    assert np.abs(a[middle] + force[1:] - force[:-1]).max() < 1e-14
    profile = hc.dps.dark_profile("bond", sites=21)
    assert profile.residual < 1e-13
    assert profile.a[profile.n == 1] == profile.a[profile.n == 0]


PLAN = """
scene = "impact"
set = ["chain.sites=5", "span.until=3"]
keep = ["energy_error", "u"]
axis = [{ key = "chain.alpha", values = [1.5, 2.0, 3.0] }, { key = "initial.velocity", from = 0.5, to = 1.0, count = 2 }]
"""


def test_a_plan_has_the_bits_of_the_program_also_in_shards(program: Any, tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    table = hc.sweep(plan)
    assert table["u"].shape == (6, 5) and table["energy_error"].max() < 1e-8
    printed = program("sweep", str(plan), "--out", str(tmp_path / "program"))
    with np.load(tmp_path / "program" / "sweep.npz") as file:
        assert np.array_equal(file["u"], table["u"])
    for shard in ("1/2", "2/2"):
        assert "kept" in hc.sweep_plan(plan, out=tmp_path / "parts", shard=shard).record["shard"]
    merged = hc.sweep_plan(plan, out=tmp_path / "parts")
    assert np.array_equal(merged["u"], table["u"]) and merged.record["computed"] == 0 < printed["computed"]
    run = hc.run(hc.Scene.load("impact", {"chain.sites": 5, "span.until": 3, "chain.alpha": 2.0, "initial.velocity": 1.0}))
    assert run.end["u"].tolist() == table["u"][3].tolist()


def test_a_folder_of_another_process_is_refused_with_its_name(tmp_path: Path) -> None:
    fcntl = pytest.importorskip("fcntl")
    plan, lock = tmp_path / "plan.toml", tmp_path / ".hertzchain-lock"
    plan.write_text(PLAN)
    with lock.open("w") as held:
        held.write("process 7 on elsewhere")
        held.flush()
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(hc.Error, match=r"in use by another run \(process 7 on elsewhere\)"):
            hc.sweep(plan, out=tmp_path)


def test_compare_has_rows_for_each_method() -> None:
    scene = hc.Scene.load("tw-q15").until(3.0)
    comparison = hc.compare(scene, ["verlet", "collocation"], max_time=5.0)
    assert {row["integrator"] for row in comparison.rows} >= {"verlet", "collocation"}


def test_pictures() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    for one in (hc.run(hc.Scene.load("impact").until(5.0)), hc.DarkBreather(sites=7, omega_b=2.05).solve()):
        figure = one.plot().figure
        figure.canvas.draw()


def test_normal_mode_has_the_bits_of_the_program_and_returns(program: Any) -> None:
    mode = hc.normal_mode(hc.Scene.load("defect"), to=0.2, step=0.1)
    printed = program("orbit", "mode", "defect", "--to", "0.2", "--step", "0.1", "--bifurcations")
    assert mode.record == printed and mode.mode == len(mode.linear) == 21 and len(mode.stable) == len(mode)
    assert mode.amplitude[[0, -1]].tolist() == [0.1, 0.2] and abs(np.prod(mode.multipliers) - 1) < 1e-10
    chain = hc.Scene.load("defect").chain
    run = hc.run(chain, y0=mode.y0, until=mode.period, tol=1e-13)
    assert np.abs(run.u[-1] - mode.y0["u"]).max() < 1e-12 and np.abs(run.pu[-1]).max() < 1e-12


def test_normal_modes_are_those_of_chains_that_contacts_hold() -> None:
    # Truth: two beads between walls with the stiffness k = 3/2 of each contact, omega^2 = k and 3 k.
    held = hc.Chain(sites=2, boundary="fixed", precompression=1.0)
    mode = hc.normal_mode(held, to=0.02, mode=2, step=0.01)
    assert np.allclose(mode.linear["omega"] ** 2, [1.5, 4.5], rtol=1e-14, atol=0)
    with pytest.warns(RuntimeWarning, match="no bifurcation"):
        alone = hc.normal_mode(held, to=0.02, mode=2, step=0.01, switch=1)
    assert alone.switched is None and np.array_equal(alone.omega, mode.omega)
    with pytest.raises(hc.ParameterError, match="held"):
        hc.normal_mode(hc.Chain(sites=2), to=0.1)
    with pytest.raises(hc.ParameterError, match="linear_mode = 0 is not valid: at least 1"):
        hc.normal_mode(held, to=0.1, mode=0)
    with pytest.raises(hc.ParameterError, match="driven|dissipat"):
        hc.normal_mode(bead(), to=0.1)


# Steel spheres: radius, density, Young's modulus, Poisson's ratio; the load in N.
SPHERES = {"radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3, "static_load": 20.0}
STEEL = {"system": "SI", **SPHERES}
MASS = 4 / 3 * math.pi * SPHERES["radius"] ** 3 * SPHERES["density"]
# Hertz's constant of two such spheres, N/m^(3/2).
CONTACT = 4 / 3 * SPHERES["young"] / (1 - SPHERES["poisson"] ** 2) / 2 * math.sqrt(SPHERES["radius"] / 2)


def test_driven_orbits_in_si_units_are_those_of_the_program(program: Any) -> None:
    scene = hc.Scene.load("granular-crystal")
    orbit, bare = hc.driven_orbit(scene), hc.driven_orbit(scene, dimensionless=True)
    assert orbit.si and not bare.si and orbit.record == program("orbit", "driven", "granular-crystal")
    # Two roundings, and one more with the mass.
    for name, array in bare.y0.items():
        assert np.allclose(orbit.y0[name], array, rtol=5e-16, atol=0), name
    printed = program("orbit", "continue", "granular-crystal", "--to", "1.2e-8", "--step", "1e-9")
    branch = hc.continue_branch(orbit, "amplitude", to=1.2e-8, step=1e-9)
    assert branch.si and branch.record == printed
    assert hc.continue_branch(bare, "amplitude", to=1.2e-8, step=1e-9, dimensionless=False).record == printed
    assert hc.continue_branch(orbit, "amplitude", to=1.2e-8, step=1e-9, dimensionless=True).record == \
        hc.continue_branch(bare, "amplitude", to=1.2e-8, step=1e-9).record


def test_a_pushed_bead_in_si_units_is_a_linear_oscillator() -> None:
    # Truth: u'' = -(K u + c u' - F cos)/m, whose drive does the work pi c w u_0^2 in a period.
    push = {"site": 0, "kind": "pushed", "amplitude": 2.0, "omega": 5e4}
    units = {**STEEL, "static_load": 0.0}
    spring, drag = 1e5, 10.0
    chain = hc.Chain(1, kappa=spring, rho=math.inf, beads={"drag": drag}, units=units, drive=[push])

    def work(force: float, omega: float = 5e4) -> float:
        return math.pi * drag * omega * (force / abs(spring - MASS * omega**2 + 1j * drag * omega)) ** 2

    orbit = hc.driven_orbit(chain)
    assert orbit.period == pytest.approx(2 * math.pi / 5e4, rel=1e-14)
    for energy in (orbit.driven, orbit.dissipated):
        assert energy == pytest.approx(work(2.0), rel=1e-8)
    size = math.sqrt(work(2.0) / (math.pi * drag * 5e4))
    assert orbit.response == pytest.approx(size, rel=1e-8)
    branch = hc.continue_branch(orbit, "amplitude", to=3.0, step=0.5)
    assert np.allclose(branch.values[[0, -1]], [2.0, 3.0], rtol=1e-14, atol=0)
    assert np.allclose(branch.response / branch.values, orbit.response / 2.0, rtol=1e-8, atol=0)
    branch = hc.continue_branch(orbit, "omega", to=5.5e4)
    assert np.allclose(branch.values[[0, -1]], [5e4, 5.5e4], rtol=1e-14, atol=0) and branch.end == "reached"
    with pytest.raises(hc.ParameterError, match="to = -50000 "):
        hc.continue_branch(orbit, "omega", to=-5e4)
    with pytest.raises(hc.ParameterError, match="driven orbits"):
        hc.continue_branch(hc.DarkBreather("bond", 2.02), to=2.03, dimensionless=True)  # type: ignore[call-overload]


def test_normal_modes_in_si_units_are_those_of_the_program(program: Any, tmp_path: Any) -> None:
    # Truth: a ring of six spheres under the load F has the stiffness 3/2 A^(2/3) F^(1/3).
    ring = hc.Chain(6, boundary="ring", units=STEEL)
    mode = hc.normal_mode(ring, mode=5, to=2e-9, step=1e-9)
    waves = 2 * np.sqrt(1.5 * CONTACT ** (2 / 3) * 20 ** (1 / 3) / MASS) * np.sin(np.pi * np.array([1, 1, 2, 2, 3]) / 6)
    assert mode.si and np.allclose(mode.linear["omega"], waves, rtol=1e-13, atol=0)
    assert np.allclose(mode.amplitude[[0, -1]], [1e-9, 2e-9], rtol=1e-15, atol=0)
    assert mode.period == pytest.approx(2 * math.pi / waves[-1], rel=1e-3)
    file = tmp_path / "ring.toml"
    file.write_text(ring.scene({}, 1.0).to_toml())
    flags = ["--linear-mode", "5", "--to", "2e-9", "--step", "1e-9", "--bifurcations"]
    printed = program("orbit", "mode", str(file), *flags)
    assert mode.record == printed | {"scene": mode.record["scene"], "scene_file": mode.record["scene_file"]}
    units = ring.scene({}, 1.0).units
    assert units is not None
    bare = hc.normal_mode(ring, mode=5, to=2e-9, step=1e-9, dimensionless=True)
    assert np.allclose(mode.y0["u"], bare.y0["u"], rtol=3e-16, atol=0)
    assert np.allclose(mode.energy, bare.energy * units["energy_j"], rtol=3e-16, atol=0)


def test_tangent_map_of_a_damped_bead_is_its_closed_form() -> None:
    # Truth: m u'' = -c u' in free flight; the ledger of work is no part of the map.
    chain = hc.Chain(sites=1, beads={"mass": 2.0, "drag": 0.6})
    rate, t = 0.3, 3.0
    want = [[1.0, (1.0 - math.exp(-rate * t)) / rate], [0.0, math.exp(-rate * t)]]
    assert np.abs(hc.monodromy(chain, y0={"pu": [1.0]}, until=t) - want).max() < 2e-15
