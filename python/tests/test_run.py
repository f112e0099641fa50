"""Runs: the same bits as the program, conservation, samples, failures, interrupts, threads."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import hertzchain as hc


@pytest.mark.parametrize(
    ("scene", "flags", "options"),
    [
        ("tw-q15", ["--tol", "1e-9"], {"tol": 1e-9}),
        ("tw-q15", ["--integrator", "strang-linear", "--steps-per-period", "64"],
         {"method": "strang-linear", "steps_per_period": 64}),
        ("impact", ["--until", "20", "--integrator", "corrected", "--step", "0.05"],
         {"until": 20.0, "method": "corrected", "step": 0.05}),
        ("trivial-breather", [], {}),
        ("cradle", ["--events"], {"events": True}),
    ],
)
def test_bits_of_the_program(program: Any, scene: str, flags: list[str], options: dict[str, Any]) -> None:
    printed = program("run", scene, *flags)
    run = hc.run(hc.Scene.load(scene), **options)
    for name, array in run.end.items():
        assert array.tolist() == printed[name], name
        assert np.array_equal(array, getattr(run, name)[-1])
    assert run.stats["steps"] == printed["steps"]
    assert run.energy_error == printed["energy_error"]
    assert run.integrator == printed["integrator"]


def test_two_beads_collide_and_exchange_their_velocities() -> None:
    chain = hc.Chain(sites=2)
    run = hc.run(chain, y0={"u": [0.0, 1.0], "pu": [1.0, 0.0]}, until=10.0, tol=1e-12, events=True)
    assert np.allclose(run.pu[-1], [0, 1], atol=1e-11)
    assert run.contacts is not None
    (contact,) = run.contacts
    assert abs(contact["onset"] - 1.0) < 1e-12
    # Energy 1/4 in relative motion, (2/5) x^(5/2) = 1/4 at the largest overlap.
    assert abs(contact["largest_overlap"] - (5 / 8) ** 0.4) < 1e-10


def test_against_an_independent_integrator() -> None:
    scipy = pytest.importorskip("scipy.integrate")
    sites, rho = 6, 1 / 3

    def slope(_: float, z: Any) -> Any:
        u, v, pu, pv = z.reshape(4, sites)
        force = np.maximum(u[:-1] - u[1:], 0) ** 1.5
        spring = u - v
        push = np.zeros(sites)
        push[:-1] -= force
        push[1:] += force
        return np.concatenate([pu, pv / rho, push - spring, spring])

    start = np.zeros((4, sites))
    start[2, 0] = 1.0
    want = scipy.solve_ivp(slope, (0, 10), start.ravel(), method="DOP853", rtol=1e-11, atol=1e-12, max_step=0.01)
    chain = hc.Chain(sites=sites, kappa=1, rho=rho)
    run = hc.run(chain, y0=start.ravel(), until=10.0, tol=1e-11)
    got = np.concatenate([run.u[-1], run.v[-1], run.pu[-1], run.pv[-1]])
    assert np.abs(got - want.y[:, -1]).max() < 1e-8


def test_samples_at_given_times_and_equal_parts_agree() -> None:
    scene = hc.Scene.load("tw-q15").until(10.0)
    parts = hc.run(scene, at=4, tol=1e-9)
    times = hc.run(scene, at=np.array([0, 2.5, 5, 7.5, 10], dtype=np.float32), tol=1e-9)
    assert np.array_equal(parts.t, times.t) and np.array_equal(parts.x, times.x)
    assert hc.run(scene, at=[], tol=1e-9).x.shape == (0, 50)
    one = hc.run(scene, at=[3.3], states=False, tol=1e-9)
    with pytest.raises(AttributeError, match="states=True"):
        _ = one.x


def test_a_run_goes_on_where_another_ended() -> None:
    chain = hc.Chain(sites=8, kappa=1, rho=1.0)
    whole = hc.run(chain, y0={"pu": np.eye(8)[0]}, until=8.0, tol=1e-12)
    first = hc.run(chain, y0={"pu": np.eye(8)[0]}, until=4.0, tol=1e-12)
    second = hc.run(chain, y0=first.end, until=4.0, tol=1e-12)
    assert np.abs(second.u[-1] - whole.u[-1]).max() < 1e-10


def test_a_run_that_fails_keeps_what_it_had() -> None:
    chain = hc.Chain(sites=3, kappa=1.0, rho=1e-8)
    run = hc.run(chain, y0={"u": [0, 0, 0.1]}, until=100.0, method="verlet", step=0.1)
    assert run.failure is not None and "unstable" in run.failure or "finite" in str(run.failure)
    assert 0 < len(run.t) < 401 and len(run.u) == len(run.t)


def test_callbacks_see_every_sample_and_their_errors_end_the_run() -> None:
    scene = hc.Scene.load("tw-q15")
    seen: list[float] = []
    run = hc.run(scene, at=10, tol=1e-6, on_sample=lambda t, y: seen.append(t))
    assert np.array_equal(seen, run.t)

    def fail(t: float, _: Any) -> None:
        if t > 1:
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough") as caught:
        hc.run(scene, at=1000, tol=1e-6, on_sample=fail)
    assert caught.value.partial.t_end < scene.end  # type: ignore[attr-defined]


def long_scene() -> hc.Scene:
    return hc.Scene.load("tw-q15").until(1e7)


def interrupt(after: float) -> None:
    timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()


def test_ctrl_c_stops_a_run_soon_and_keeps_it() -> None:
    waited = []
    # The best of three, as the machine may be shared.
    for _ in range(3):
        interrupt(0.3)
        clock = time.perf_counter()
        with pytest.raises(KeyboardInterrupt) as caught:
            hc.run(long_scene(), at=np.arange(0, 1e5, 10.0), method="strang-linear", step=0.01)
        waited.append(time.perf_counter() - clock - 0.3)
        partial = caught.value.partial  # type: ignore[attr-defined]
        assert isinstance(caught.value, hc.Interrupted)
        assert 0 < partial.t_end < 1e7 and len(partial.x) == len(partial.t) > 0
    assert min(waited) < 0.2
    # The next run is not stopped.
    assert hc.run(hc.Scene.load("tw-q15"), tol=1e-6).failure is None


def test_one_stop_leaves_a_run_on_another_thread_alone() -> None:
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(hc.run, hc.Scene.load("tw-q15").until(3000.0), method="strang-linear", step=0.01)
        interrupt(0.1)
        with pytest.raises(KeyboardInterrupt):
            hc.run(long_scene(), method="strang-linear", step=0.01)
        assert other.result().failure is None


def test_threads_run_side_by_side() -> None:
    scene = hc.Scene.load("tw-q15").until(20000.0)

    def one(_: int) -> hc.Trajectory:
        return hc.run(scene, method="strang-linear", step=0.01, at=10)

    clock = time.process_time()
    first = one(0)
    single = time.process_time() - clock
    with ThreadPoolExecutor(2) as pool:
        clock = time.process_time()
        runs = list(pool.map(one, range(4)))
        together = time.process_time() - clock
    assert all(np.array_equal(first.x, run.x) for run in runs)
    # CPU time: threads that waited for each other's lock while polling would take more.
    assert together < 4 * 1.5 * single


def test_overhead_of_a_call() -> None:
    scene = hc.Chain(sites=2).scene({"pu": [0.0, 1.0]}, 1.0)
    times = np.array([1.0])

    def call() -> float:
        clock = time.perf_counter()
        hc.run(scene, at=times, method="strang-linear", step=1.0)
        return time.perf_counter() - clock

    # The least of many, as the machine may be shared; measured 40 to 60 microseconds.
    assert min(call() for _ in range(2000)) < 120e-6


def test_memory_of_a_long_chain() -> None:
    code = """
import resource, numpy as np, hertzchain as hc
sites = 1_000_000
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
run = hc.run(hc.Chain(sites=sites), y0={"pu": np.r_[1.0, np.zeros(sites - 1)]}, until=1.0, step=0.05,
             method="verlet", at=20)
peak = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
print(peak / (run.u.nbytes + run.pu.nbytes))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    # 21 samples of two arrays; the run itself holds a few arrays of one sample each.
    assert float(done.stdout) < 1.6




@pytest.mark.parametrize("method", ["strang-linear", "verlet", "dop853"])
def test_runs_from_many_states_have_the_bits_of_each(method):
    # Truth: each alone; more members than a register has lanes, all arrays and energies.
    chain = hc.Chain(sites=9, kappa=1, rho=1 / 3)
    rng = np.random.default_rng(3)
    states = 0.1 * rng.standard_normal((11, 36))
    how = {"tol": 1e-6} if method == "dop853" else {"step": 0.05}
    many = hc.run_many(chain, states, until=4.0, method=method, at=[0.5, 1.7, 4.0], **how)
    assert len(many) == 11 and many.u.shape == (11, 3, 9) and not many.failures
    for k, state in enumerate(states):
        one = hc.run(chain, y0=state, until=4.0, method=method, at=[0.5, 1.7, 4.0], **how)
        for name in ("u", "v", "pu", "pv", "energy"):
            assert np.array_equal(getattr(many, name)[k], getattr(one, name)), name
        assert many[k].energy_error == one.energy_error == many.energy_error[k]
        assert all(np.array_equal(many[k].end[name], one.end[name]) for name in one.end)
    by_name = hc.run_many(chain, dict(zip(("u", "v", "pu", "pv"), np.split(states, 4, axis=1))), until=4.0, method=method, **how)
    assert np.array_equal(by_name.u[:, -1], many.u[:, -1])


def test_runs_from_many_states_in_si_units_and_those_that_fail():
    # Truth: each alone. The second member is so fast that its energy at this step is lost.
    steel = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3}
    chain = hc.Chain(sites=12, units=steel)
    states = [{"pu": speed * chain.masses[0] * np.eye(12)[0]} for speed in (0.5, 1e9, 0.7)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        many = hc.run_many(chain, states, until=2e-4, method="verlet", step=1e-6, at=5)
        ones = [hc.run(chain, y0=state, until=2e-4, method="verlet", step=1e-6, at=5) for state in states]
    assert [one.failure for one in ones] == [member.failure for member in many]
    assert list(many.failures) == [1]
    for member, one in zip(many, ones):
        assert np.array_equal(member.u, one.u) and np.array_equal(member.end["u"], one.end["u"], equal_nan=True)
    assert many.u.shape == (3, 6, 12) and np.isnan(many.u[1]).any() and not np.isnan(many.u[[0, 2]]).any()


def test_states_of_many_runs_are_checked():
    chain = hc.Chain(sites=3)
    for y0, words in [([], "at least one"), (np.zeros((2, 5)), "y0"), ({"u": np.zeros((2, 3)), "pu": np.zeros((3, 3))}, "as many")]:
        with pytest.raises(hc.ParameterError, match=words):
            hc.run_many(chain, y0, until=1.0)
    with pytest.raises(hc.ParameterError, match="tol"):
        hc.run_many(chain, np.zeros((2, 6)), until=1.0, method="verlet", tol=1e-6)
