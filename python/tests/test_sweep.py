"""Sweeps of functions: stores that belong to a function, points that fail, locks, ranks, Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hertzchain as hc


def square(x: Any) -> Any:
    return x**2


def test_a_store_belongs_to_a_function_its_version_and_its_code(tmp_path: Path) -> None:
    store = tmp_path / "store"
    assert hc.sweep(square, [1, 2, 3], store=store, version=1) == [1, 4, 9]
    # The same function computes nothing again, and more points are added.
    called: list[int] = []

    def counted(x: int) -> int:
        called.append(x)
        return x**2

    assert hc.sweep(counted, [1, 2], store=tmp_path / "c", version=1) == [1, 4]
    assert hc.sweep(counted, [1, 2, 3], store=tmp_path / "c", version=1) == [1, 4, 9]
    assert called == [1, 2, 3]
    with pytest.raises(hc.FileError, match="has values of square, not of .*counted"):
        hc.sweep(counted, [1, 2, 3], store=store, version=1)

    def altered(x: int) -> int:
        return x**3

    with pytest.raises(hc.FileError, match="the code of square is not that which version 1 had"):
        hc.sweep(altered, [1, 2, 3], store=store, name="square", version=1)
    with pytest.raises(hc.FileError, match="the point 3 is not of this sweep"):
        hc.sweep(square, [1, 2], store=store, version=1)
    with pytest.warns(hc.RunWarning, match="3 values are of version 1 of square, not 2"):
        assert hc.sweep(altered, [1, 2], store=store, name="square", version=2) == [1, 8]
    with pytest.raises(hc.ParameterError, match="version = None is not valid"):
        hc.sweep(square, [1], store=store)
    with pytest.raises(hc.ParameterError, match="name = None is not valid"):
        hc.sweep(lambda x: x, [1], store=store, version=1)


FACTOR = 2


def doubled(x: Any) -> Any:
    return FACTOR * x


class Times:
    def __init__(self, k: Any) -> None:
        self.k, self.calls = k, 0

    def __call__(self, x: Any) -> Any:
        self.calls += 1
        return self.k * x

    def of(self, x: Any) -> Any:
        return self(x)


def multiplied(kind: str, k: Any) -> Any:
    """A function that multiplies by `k`, which it has in one of many ways."""

    def default(x: Any, k: Any = k) -> Any:
        return k * x

    def keyword(x: Any, *, k: Any = k) -> Any:
        return k * x

    def called(x: Any) -> Any:
        return default(x)

    def array(x: Any, by: Any = {"k": [np.array([k])]}) -> Any:
        return int(by["k"][0][0]) * x

    chain = hc.Chain(sites=2, alpha=k)
    calls: list[Any] = []

    def counted(x: Any) -> Any:
        calls.append(x)
        return int(chain.alpha) * x

    ways = {"closure": lambda x: k * x, "partial": partial(lambda k, x: k * x, k), "object": Times(k), "method": Times(k).of}
    ways |= {"default": default, "keyword": keyword, "called": called, "array": array, "chain": counted}
    return {**ways, "keyword of partial": partial(keyword, k=k), "cached": lru_cache(ways["closure"])}.get(kind, doubled)


@pytest.mark.parametrize(
    ("kind", "what"),
    [
        ("closure", "k"),
        ("default", "defaults"),
        ("keyword", "defaults"),
        ("partial", "the value"),
        ("keyword of partial", "the value"),
        ("object", "k of Times"),
        ("method", "k of Times"),
        ("called", "defaults of .*default"),
        ("array", "defaults"),
        ("chain", "chain"),
        ("cached", "k of .*lambda.*"),
        ("global", "FACTOR"),
    ],
)
def test_what_belongs_to_a_function_belongs_to_its_store(
    kind: str, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Truth: each function without a store.
    store, of = tmp_path / "store", {"store": tmp_path / "store", "name": "times"}
    for k in (2, 3):
        monkeypatch.setattr(sys.modules[__name__], "FACTOR", k)
        function = multiplied(kind, k)
        assert hc.sweep(function, [1, 2]) == [k, 2 * k]
        if k == 3:
            with pytest.raises(hc.FileError, match=f"store: {what} of times is not that which version 1 had"):
                hc.sweep(function, [1, 2], version=1, **of)
            with pytest.warns(hc.RunWarning, match="2 values are of version 1 of times, not 3"):
                assert hc.sweep(function, [1, 2], version=3, **of) == [3, 6]
            continue
        for _ in range(2):
            size = store.stat().st_size if store.exists() else 0
            assert hc.sweep(multiplied(kind, k), [1, 2], version=1, **of) == [2, 4]
            assert size in (0, store.stat().st_size)


def test_what_has_no_digest_is_left_to_the_version(tmp_path: Path) -> None:
    lock, calls = threading.Lock(), []  # the lock has none, and the list is what the function changes

    def careful(x: int) -> int:
        with lock:
            calls.append(x)
            return x**2

    assert hc.sweep(careful, [1, 2], store=tmp_path / "store", shard="1/2", version=1) == [1]
    assert hc.sweep(careful, [1, 2], store=tmp_path / "store", shard="2/2", version=1) == [4]
    calls.clear()
    assert hc.sweep(careful, [1, 2, 3], store=tmp_path / "store", version=1) == [1, 4, 9] and calls == [3]


def test_the_code_of_a_function_is_the_same_in_every_process(tmp_path: Path) -> None:
    # A constant set is ordered by hashes, which differ from process to process.
    (tmp_path / "job.py").write_text(
        "import hertzchain as hc\n\ndef known(x):\n    return x in {'one', 'two', 'three', 'four'}\n\n"
        "print(hc.sweep(known, ['one'], store='store', version=1))\n"
    )
    for seed in "123":
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run([sys.executable, "job.py"], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.stdout == "[True]\n", done.stderr
    assert len((tmp_path / "store").read_text().splitlines()) == 2


def test_sweep_resumes_and_collects_shards(tmp_path: Path) -> None:
    calls: list[int] = []

    def square(x: int) -> int:
        calls.append(x)
        return x * x

    store = tmp_path / "squares.jsonl"
    points = list(range(10))
    assert hc.sweep(square, points[:4], store=tmp_path / "few.jsonl", version=1) == [0, 1, 4, 9]
    assert hc.sweep(square, points, store=store, shard="1/3", version=1) == [0, 9, 36, 81]
    assert hc.sweep(square, points, store=store, shard="3/3", version=1) == [4, 25, 64]
    calls.clear()
    assert hc.sweep(square, points, store=store, version=1) == [x * x for x in points]
    assert sorted(calls) == [1, 4, 7]
    # A torn line is computed again, and nothing else is.
    store.write_bytes(store.read_bytes()[:-4])
    calls.clear()
    assert hc.sweep(square, points, store=store, version=1) == [x * x for x in points]
    assert len(calls) == 1
    with pytest.raises(hc.FileError, match="not of this sweep"):
        hc.sweep(square, [100], store=store, version=1)


def test_a_failing_point_is_a_row_with_its_reason(tmp_path: Path) -> None:
    def inverse(x: int) -> float:
        return 6 / x

    for store in (None, tmp_path / "store"):
        with pytest.warns(hc.RunWarning, match="1 of 3 points failed, the first is number 1, 0: ZeroDivisionError"):
            values = hc.sweep(inverse, [1, 0, 2], store=store, version=1)
        assert values == [6.0, None, 3.0] and list(values.failures) == [1]
    rows = [json.loads(line) for line in (tmp_path / "store").read_text().splitlines()]
    assert {"point": 0, "failure": "ZeroDivisionError: division by zero"} in rows
    with pytest.raises(ZeroDivisionError):
        hc.sweep(inverse, [0, 0.0])


def test_values_are_kept_as_they_complete(tmp_path: Path) -> None:
    store, first = tmp_path / "store", threading.Event()

    def waits(x: int) -> int:
        # The first point ends after the second is in the store.
        if x == 0:
            assert first.wait(20.0)
        return x

    def watch() -> None:
        while not (store.exists() and '"point": 1' in store.read_text()):
            time.sleep(0.01)
        first.set()

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    assert hc.sweep(waits, [0, 1], workers=2, store=store, version=1) == [0, 1]


def test_points_and_values_of_numpy(tmp_path: Path) -> None:
    for points in (np.arange(3), np.linspace(0, 1, 3), [np.float32(0.5), np.int8(2)], [{"k": np.array([1, 2])}]):
        store = tmp_path / f"store-{len(list(tmp_path.iterdir()))}"
        want = [np.array([1.5]).tolist()] * len(points)
        for _ in range(2):
            assert hc.sweep(lambda _: np.array([1.5]), points, store=store, name="one", version=1) == want
    assert hc.sweep(square, np.arange(3), store=tmp_path / "ints", version=1) == [0, 1, 4]
    assert hc.sweep(square, range(3), store=tmp_path / "ints", version=1) == [0, 1, 4]


def test_one_store_has_one_writer(tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    store = tmp_path / "store"

    def inner(x: int) -> Any:
        with pytest.raises(hc.FileError, match="another process writes to it"):
            hc.sweep(square, [1], store=store, name="outer", version=1)
        return x

    assert hc.sweep(inner, [1], store=store, name="outer", version=1) == [1]


def test_workers_are_the_cores_that_the_process_may_use() -> None:
    code = "import os; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))]); import hertzchain._sweep as s; print(s._cores())"
    if hasattr(os, "sched_setaffinity"):
        assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "1\n"
    with pytest.raises(hc.ParameterError, match="workers = 0 is not valid"):
        hc.sweep(square, [1], workers=0)


def test_ctrl_c_stops_the_runs_of_workers_and_keeps_what_was_computed(tmp_path: Path) -> None:
    store = tmp_path / "store"

    def long(k: int) -> float:
        if k == 0:
            return 0.0
        return hc.run(hc.Scene.load("tw-q15").until(1e7), method="strang-linear", step=0.01).t_end

    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    clock = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        hc.sweep(long, range(4), workers=2, store=store, version=1)
    assert time.perf_counter() - clock < 2.5
    assert '{"point": 0, "value": 0.0}' in store.read_text()
    # Other runs are not stopped.
    assert hc.run(hc.Scene.load("tw-q15"), tol=1e-6).failure is None


class Ranks:
    """Threads that stand for the ranks of mpi4py: `allgather` waits for all of them."""

    def __init__(self, size: int) -> None:
        self.size, self.all, self.barrier = size, [None] * size, threading.Barrier(size, timeout=20.0)

    def sweep(self, rank: int, function: Any, points: Any, **options: Any) -> Any:
        outer = self

        class Comm:
            def Get_rank(self) -> int:
                return rank

            def Get_size(self) -> int:
                return outer.size

            def allgather(self, own: Any) -> Any:
                outer.all[rank] = own
                outer.barrier.wait()
                everything = list(outer.all)
                outer.barrier.wait()
                return everything

        try:
            return hc.sweep(function, points(rank) if callable(points) else points, comm=Comm(), **options)
        except Exception as error:
            return error

    def sweeps(self, *arguments: Any, **options: Any) -> list[Any]:
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(self.size) as pool:
            return list(pool.map(lambda rank: self.sweep(rank, *arguments, **options), range(self.size)))


@pytest.mark.filterwarnings("ignore::hertzchain.RunWarning")
def test_no_rank_waits_for_one_that_has_ended(tmp_path: Path) -> None:
    def inverse(x: int) -> float:
        return 6 / x

    assert Ranks(3).sweeps(square, range(7)) == [[x**2 for x in range(7)]] * 3
    for values in Ranks(3).sweeps(inverse, [1, 0, 2, 3]):
        assert values == [6.0, None, 3.0, 2.0] and list(values.failures) == [1]
    # A point alone on its rank may fail; all of them may not.
    assert all(isinstance(one, (ZeroDivisionError, hc.RunError)) for one in Ranks(2).sweeps(inverse, [0, 0.0]))
    # Points that differ, in number, value or type, and points that cannot be made.
    for points in (lambda rank: range(3 + rank), lambda rank: [1.0, 2.0 + 1e-15 * rank], lambda rank: [1, rank and 1.0]):
        for one in Ranks(2).sweeps(square, points):
            assert isinstance(one, hc.ParameterError) and "those of rank 1 are not those of rank 0" in str(one)
    first, second = Ranks(2).sweeps(square, lambda rank: (1 // (1 - rank) for _ in range(2)))
    assert isinstance(second, ZeroDivisionError) and "the sweep of rank 1 has ended: ZeroDivisionError" in str(first)
    # Another process writes to the store of the second rank: every rank has the message.
    fcntl = pytest.importorskip("fcntl")
    with (tmp_path / "store.2-of-2").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        first, second = Ranks(2).sweeps(inverse, [1, 2], store=tmp_path / "store", name="inverse", version=1)
    assert isinstance(second, hc.FileError) and "another process writes to it" in str(second)
    assert isinstance(first, hc.RunError) and "the sweep of rank 1 has ended: FileError" in str(first)


# Truth: at its onset the force of a dashpot is its constant times the speed, 1; else plain DOP853,
# whose forces are those of its steps.
def test_largest_forces_of_contacts_that_dissipate_are_those_of_the_states(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    methods = ["collocation", "dop853-regularised", "dop853-landed", "dop853"]
    wall = {"overlap": -0.3, "dashpot": 1.0}
    for tol in (1e-6, 1e-10, 1e-12):
        chain = hc.Chain(sites=1, boundary="right-wall", bonds=wall)
        run = hc.run(chain, y0={"pu": [1.0]}, until=4.0, tol=tol, events=True)
        assert run.contacts is not None and abs(max(run.contacts["peak_force"]) - 1.0) < 0.2 * tol + 1e-14
    for law, until, truth in (
        ("dashpot=1", 20, {7: 0.12835, 8: 0.11799, 9: 0.10966}),
        ("hunt_crossley=0.01", 15, {8: 0.68450, 9: 0.68198}),
    ):
        changes = ["chain.sites=10", "bonds.overlap=-0.1", f"bonds.{law}"]
        keep = [f"bonds.peak_force[{bond}]" for bond in truth]
        lines = ['scene = "impact"', f"keep = {json.dumps(['largest_force', *keep])}"]
        lines += [f"set = {json.dumps([*changes, f'span.until={until}'])}"]
        lines += ["[[axis]]", 'key = "method.integrator"', f"values = {json.dumps(methods)}"]
        plan.write_text("\n".join(lines))
        kept = hc.sweep_plan(plan)
        for name, force in zip(keep, truth.values()):
            assert np.allclose(kept[name], force, rtol=0, atol=6e-6), (law, name)
        scene = hc.Scene.load("impact", dict(change.split("=") for change in changes))
        for k, method in enumerate(methods):
            contacts = hc.run(scene, until=until, method=method, events=True).contacts
            assert contacts is not None and abs(max(contacts["peak_force"]) / kept["largest_force"][k] - 1.0) < 1e-14
            for bond, force in truth.items():
                own = contacts["peak_force"][contacts["bond"] == bond - 1]
                assert abs(max(own) - force) < 6e-6, (law, method, bond)
