"""Objects: pickles, copies, equality, views for notebooks, types, and the indices of bonds."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import subprocess
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hertzchain as hc
from hertzchain._values import alike, plain

DIMER = hc.Chain(
    sites=4,
    boundary="fixed",
    precompression=0.1,
    beads={"mass": [1.0, 2.0, 1.0, 2.0], "drag": [0.0, 0.01, 0.01, 0.01]},
    bonds={"contact": {"value": 1.0, "except": [[1, 2.0]]}, "alpha": np.full(5, 1.5)},
    drive=[{"site": 0, "kind": "moved", "amplitude": [0.01, 0.02], "omega": [1.0, 2.0]}],
)
STRUCK = {"pu": np.eye(5)[0]}


def objects() -> dict[str, Any]:
    plain = hc.Chain(sites=5, kappa=1, rho=0.5)
    driven = hc.driven_orbit(hc.Scene.load("granular-crystal"), settle=20)
    breather = hc.DarkBreather("site", omega_b=2.05, sites=7)
    run = hc.run(plain, y0=STRUCK, until=3.0, tol=1e-9, events=True)
    return {
        "chain": plain,
        "dimer": DIMER,
        "scene": hc.Scene.load("tw-q15"),
        "scene of a chain": DIMER.scene({}, 5.0),
        "trajectory": run,
        "part": run.resume(4.0),
        "trajectory in SI units": hc.run(hc.Scene.load("granular-crystal"), until=7e-4, tol=1e-6, at=3),
        "ensemble": hc.run_many(plain, [STRUCK, STRUCK], until=1.0, method="verlet", step=0.1),
        "breather": breather,
        "orbit": breather.solve(),
        "branch": hc.continue_branch(hc.DarkBreather("bond", 2.02, sites=7), to=2.04, step=0.01),
        "driven orbit": driven,
        "driven branch": hc.continue_branch(driven, "amplitude", to=12e-9, step=1e-9),
        "mode": hc.normal_mode(hc.Chain(sites=2, boundary="fixed", precompression=1.0), to=0.1),
        "wave": hc.TravellingWave(q=0.5, a=1.0, b=0.2, detuning=0.01),
        "wave of a scene": hc.TravellingWave.of(hc.Scene.load("tw-q15")),
        "bright": hc.BrightBreather("bond", epsilon=0.01, sites=20),
        "study": hc.study("dps homoclinic", center="bond"),
        "comparison": hc.compare(hc.Scene.load("impact").until(1.0), ["verlet"], max_time=0.2),
        "simulation": hc.Simulation(DIMER, {}, tol=1e-9),
    }


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, Mapping):
        yield from (array for one in value.values() for array in arrays_of(one))
    elif isinstance(value, (list, tuple)):
        yield from (array for one in value for array in arrays_of(one))


def told(of: Any) -> dict[str, Any]:
    """The public attributes, and what the methods give that have states."""
    called: dict[str, tuple[Any, ...]] = {"y0": (0,), "column": ("k_x",), "strains": (), "at": (0.3,)}
    called["at"] = (0.3, 4) if isinstance(of, hc.TravellingWave) else (0.3,)
    values: dict[str, Any] = {}
    for name in (name for name in dir(of) if name[0] != "_"):
        value = getattr(of, name, None)
        if callable(value) and not isinstance(value, type):
            value = value(*called[name]) if name in called else None
        values[name] = value
    if isinstance(of, hc.Trajectory):
        frame, data = of.to_dataframe(), of.to_xarray()
        values |= {"call": of(0.97 * of.t_end), "xarray": {name: data[name].values for name in data}}
        values["again"] = hc.run(of.chain, y0=of.end, t0=of.t_end, until=1.2 * of.t_end, tol=1e-6, at=1).end
        frame.iloc[:] = 7.0
    return values


@pytest.mark.filterwarnings("ignore::hertzchain.RunWarning")
def test_arrays_of_objects_are_read_only_or_copies(tmp_path: Path) -> None:
    # Truth: what an object tells before anything is written to what it has told.
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    (tmp_path / "plan.toml").write_text(
        'scene = "impact"\nkeep = ["energy_error"]\n[[axis]]\nkey = "span.until"\nvalues = [1.0, 2.0]\n'
    )
    some = objects() | {
        "table": hc.sweep_plan(tmp_path / "plan.toml"),
        "point": hc.continue_branch(hc.DarkBreather("bond", 2.02, sites=7), to=2.03, step=0.01)[0],
        "profile": hc.dps.homoclinic("bond"),
        "dark profile": hc.dps.dark_profile(sites=7),
        "results": hc.sweep(abs, [-1, 2]),
        "ring": hc.run(hc.Scene.load("tw-q15").until(1.0), tol=1e-6, at=3),
    }
    known = [of for module in (hc, hc.dps) for of in vars(module).values() if isinstance(of, type)]
    ours = {of for of in known if of.__module__.startswith("hertzchain") and not issubclass(of, (BaseException, Warning))}
    assert ours == {type(of) for of in some.values()}
    for name, of in some.items():
        again = () if isinstance(of, tuple) else (pickle.loads(pickle.dumps(of)), copy.copy(of), copy.deepcopy(of))
        for one in (of, *again):
            before = copy.deepcopy(plain(told(one)))
            for attribute, value in told(one).items():
                if (name, attribute) == ("simulation", "state"):  # made to be changed
                    continue
                for array in arrays_of(value):
                    if array.flags.writeable:
                        array[...] = np.zeros((), array.dtype)
                if attribute in ("y0", "end", "units") and type(value) is dict:
                    value.clear()
            after = plain(told(one))
            assert not [key for key in after if not alike(before[key], after[key])], name
    with pytest.raises(ValueError, match="read-only"):
        some["chain"].masses[0][0] *= 1e3
    # What a caller has given is not taken either.
    mass, share = np.ones(3), [[1, 2.0]]
    chain = hc.Chain(sites=3, beads={"mass": mass}, bonds={"contact": {"value": 1.0, "except": share}})
    mass *= 2.0
    share[0][1] = 5.0
    assert chain == pickle.loads(pickle.dumps(chain)) and chain.masses[0].tolist() == [1.0, 1.0, 1.0]


def again(of: Any) -> Any:
    """What another process gets, and sends back."""
    return of


def test_objects_are_pickled_copied_compared_and_shown() -> None:
    some = objects()
    # A process that is spawned knows nothing of this one.
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = dict(zip(some, pool.map(again, some.values())))
    for name, of in some.items():
        for other in (there[name], pickle.loads(pickle.dumps(of)), copy.copy(of), copy.deepcopy(of)):
            assert type(other) is type(of) and other == of and not other != of, name
            assert repr(other) == repr(of) and "object at 0x" not in repr(of), name
            if name != "breather":
                assert of._repr_html_() == other._repr_html_() and of._repr_html_().startswith("<"), name
        assert of != 3 and all(of != other for key, other in some.items() if key != name), name
    assert there["branch"]._study.file("branch.npz") == some["branch"]._study.file("branch.npz")
    assert np.array_equal(there["orbit"].modes, some["orbit"].modes)
    assert there["wave"].omega_tw == some["wave"].omega_tw
    assert hash(there["dimer"]) == hash(DIMER) and hash(there["scene"]) == hash(some["scene"])
    # A copy runs on as the original does.
    for name in ("trajectory", "part", "trajectory in SI units"):
        one, other = (each.resume(1.5 * each.t_end, at=2) for each in (some[name], there[name]))
        assert all(np.array_equal(array, other.end[key]) for key, array in one.end.items()), name


def test_objects_go_through_joblib() -> None:
    joblib = pytest.importorskip("joblib")
    run = hc.run(DIMER, y0={}, until=2.0, tol=1e-9)
    ends = joblib.Parallel(n_jobs=2)(joblib.delayed(hc.run)(DIMER, y0={}, until=2.0, tol=1e-9) for _ in range(2))
    assert ends == [run, run]


def test_numbers_that_differ_make_objects_differ() -> None:
    chain = hc.Chain(sites=3)
    one, other = (hc.run(chain, y0={"pu": [1.0, 0.0, last]}, until=1.0, tol=1e-9) for last in (0.0, 1e-15))
    assert one == hc.run(chain, y0={"pu": [1, 0, 0]}, until=1.0, tol=1e-9) and one != other
    changed, u = copy.deepcopy(one), one.u.copy()
    u[-1, 0] = np.nextafter(u[-1, 0], 2.0)
    changed._states = {**one._states, "u": u}
    assert changed != one
    assert pickle.loads(pickle.dumps(hc.Chain(sites=3, alpha=np.nextafter(1.5, 2)))).alpha == np.nextafter(1.5, 2)
    assert repr(DIMER) == (
        "Chain(sites=4, boundary='fixed', precompression=0.1, beads={'mass': array(4,), 'drag': array(4,)}, "
        "bonds={'contact': {'value': 1, 'except': [[1, 2]]}, 'alpha': array(5,)}, "
        "drive=[{'site': 0, 'kind': 'moved', 'amplitude': array(2,), 'omega': array(2,)}])"
    )


@pytest.mark.parametrize(
    ("boundary", "count"), [("free", 2), ("fixed", 4), ("left-wall", 3), ("right-wall", 3), ("ring", 3)]
)
def test_bonds_count_alike(boundary: str, count: int) -> None:
    # Truth: the overlap of a bond is minus its strain, and a contact of constant c pushes c times as hard.
    for k in range(count):
        stiff = np.ones(count)
        stiff[k] = 3.0
        by_rule = {"value": 1.0, "except": [[k, 3.0]]}
        chain = hc.Chain(sites=3, boundary=boundary, bonds={"contact": stiff})
        told: list[Any] = []
        start = {"u": [0.3, 0.1, -0.2], "pu": [-0.5, 0.2, 0.4]}
        run = hc.run(chain, y0=start, until=3.0, tol=1e-10, at=4000, on_contact=told.append)
        assert run.strains().shape[1] == count
        assert set(run.contacts["bond"]) <= set(range(count)) and len(run.contacts) > 0
        for contact in [*run.contacts, *told]:
            column = -run.strains()[:, contact["bond"]]
            end = contact["release"] if contact["release"] == contact["release"] else run.t_end
            onset = contact["onset"] if contact["onset"] == contact["onset"] else 0.0
            within = column[(run.t >= onset) & (run.t <= end)]
            assert len(within) == 0 or abs(within.max() - contact["largest_overlap"]) < 1e-5
        if boundary in ("fixed", "ring"):
            pressed = hc.Chain(sites=3, boundary=boundary, bonds={"contact": stiff, "overlap": 0.1})
            forces = 0.1**1.5 * stiff
            first = hc.run(pressed, y0={"u": np.zeros(3)}, until=1e-4, tol=1e-12).pu[-1] / 1e-4
            # Bond k is between beads k - 1 and k.
            right = np.roll(forces, -1)[:3] if boundary == "ring" else forces[1:]
            assert np.abs(first - (forces[:3] - right)).max() < 1e-6
        other = hc.run(hc.Chain(sites=3, boundary=boundary, bonds={"contact": by_rule}), y0=start, until=3.0, tol=1e-10)
        assert np.array_equal(other.u[-1], run.u[-1])


def test_arrays_are_properties_and_what_was_not_kept_is_said() -> None:
    run = hc.run(hc.Chain(sites=5), y0=STRUCK, until=1.0, tol=1e-9, states=False)
    assert {"u", "v", "pu", "pv"} <= set(dir(run)) and {"u", "pv"} <= set(dir(hc.Ensemble))
    with pytest.raises(AttributeError, match="states=True"):
        _ = run.u
    with pytest.raises(AttributeError, match="events=True"):
        _ = run.contacts
    with pytest.raises(AttributeError, match="its arrays are u, v, pu, pv"):
        _ = run.x


def test_a_failed_run_warns() -> None:
    light = hc.Chain(sites=3, kappa=1.0, rho=1e-8)
    with pytest.warns(hc.RunWarning, match="unstable|finite"):
        assert hc.run(light, y0={"u": [0, 0, 0.1]}, until=100.0, method="verlet", step=0.1).failure
    with pytest.warns(hc.RunWarning, match="member 1: .*(unstable|finite)"):
        many = hc.run_many(light, [{}, {"u": [0, 0, 0.1]}], until=100.0, method="verlet", step=0.1)
    assert list(many.failures) == [1]


def test_many_runs_refuse_what_is_no_list_of_states() -> None:
    for y0 in (None, 3, 0.5, "rest"):
        with pytest.raises(hc.ParameterError, match="a sequence of states"):
            hc.run_many(hc.Chain(sites=2), y0, until=1.0)
    with pytest.raises(hc.ParameterError, match="a sequence of states"):
        hc.run_many(hc.Chain(sites=2), {"u": None}, until=1.0)


def test_members_with_a_closed_form_are_those_of_run() -> None:
    # At rest, and a state whose beads never press each other: both have an exact solution.
    scene = hc.Scene.load("trivial-breather")
    states = [scene.y0, {name: 0.5 * array for name, array in scene.y0.items()}]
    many = hc.run_many(scene.chain, states, until=3.0, at=5)
    ones = [hc.run(scene.chain, y0=state, until=3.0, at=5) for state in states]
    assert [one.integrator for one in ones] == ["closed-form"] * 2 == [member.integrator for member in many]
    assert all(np.array_equal(one.u, member.u) and np.array_equal(one.pv, member.pv) for one, member in zip(ones, many))


def test_tables_for_pandas_and_xarray() -> None:
    run = hc.run(hc.Chain(sites=5, kappa=1, rho=0.5), y0=STRUCK, until=1.0, tol=1e-9, at=4)
    pytest.importorskip("pandas")
    frame = run.to_dataframe()
    assert list(frame.columns) == ["u", "v", "pu", "pv"] and frame.loc[(run.t[2], 3), "pv"] == run.pv[2, 3]
    pytest.importorskip("xarray")
    data = run.to_xarray()
    assert data["u"].dims == ("t", "site") and np.array_equal(data["energy"], run.energy)
    assert float(data["pu"].sel(site=1).isel(t=-1)) == run.pu[-1, 1]


def test_states_of_branch_points_begin_orbits(tmp_path: Path) -> None:
    # Truth: a run over the period of the point returns to its state.
    branch = hc.continue_branch(hc.DarkBreather("bond", 2.02, sites=7), to=2.04, step=0.01)
    push = {"site": 0, "kind": "pushed", "amplitude": 0.02, "omega": 1.3}
    ends = hc.Chain(sites=2, boundary="fixed", precompression=0.5, beads={"drag": 0.3}, drive=[push])
    driven = hc.continue_branch(hc.driven_orbit(ends), "amplitude", to=0.03, step=0.005)
    driven.save(tmp_path / "driven.npz")
    assert hc.DrivenBranch.load(tmp_path / "driven.npz").record == driven.record
    for k in (0, len(branch) - 1):
        period = 2 * np.pi / branch[k].omega_b
        run = hc.run(hc.Chain(7, 1.5, 1.0, 1 / 3, "strain-ring"), y0=branch.y0(k), until=period, tol=1e-12)
        assert np.abs(run.end["x"] - branch.y0(k)["x"]).max() < 1e-9
    for k in (0, len(driven) - 1):
        chain = dataclasses.replace(ends, drive=[{**push, "amplitude": driven.values[k]}])
        run = hc.run(chain, y0=driven.y0(k), until=2 * np.pi / 1.3, tol=1e-12)
        assert all(np.abs(run.end[name] - array).max() < 1e-9 for name, array in driven.y0(k).items())
    si = hc.driven_orbit(hc.Scene.load("granular-crystal"))
    first = hc.continue_branch(si, "amplitude", to=10.5e-9, step=0.5e-9, max_points=2).y0(0)
    assert all(np.allclose(first[name], si.y0[name], rtol=1e-6, atol=1e-9 * np.abs(array).max()) for name, array in si.y0.items())


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_type_checkers_find_typos(checker: str, tmp_path: Path) -> None:
    pytest.importorskip(checker)
    options = ["--strict", "--cache-dir", str(tmp_path / "cache")] if checker == "mypy" else ["--pythonpath", sys.executable]
    file = tmp_path / "user.py"
    file.write_text(
        "import hertzchain as hc\nrun = hc.run(hc.Chain(sites=2), y0={}, until=1.0, events=True)\n"
        'print(run.contacts["bond"], run.u[-1], run(0.5)["u"])\nprint(run.uu)\nhc.run(hc.Chain(site=2))\n'
    )
    said = subprocess.run([sys.executable, "-m", checker, *options, file], capture_output=True, text=True).stdout
    errors = [line for line in said.splitlines() if " error:" in line]
    assert {int(line.split("user.py:")[1].split(":")[0]) for line in errors} == {4, 5}, said


def test_the_wheel_has_its_licenses() -> None:
    from importlib.metadata import PackageNotFoundError, files

    try:
        names = {file.name for file in files("hertzchain") or ()}
    except PackageNotFoundError:
        pytest.skip("not installed from a wheel")
    assert {"LICENSE-MIT", "LICENSE-APACHE"} <= names
