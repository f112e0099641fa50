"""Sweeps: a function at many points, on threads, in shards and on MPI ranks."""

from __future__ import annotations

import io
import json
import os
import re
import sys
import threading
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from . import studies
from ._arrays import Vector, file_at, several, texts, whole, word
from ._belongs import belongings, digest
from ._errors import FileError, ParameterError, RunError, RunWarning, of_file
from ._progress import Progress, shown, stopped_by
from ._study import Study
from ._values import Value

try:
    import fcntl
except ImportError:  # where files have no such locks
    fcntl = None  # type: ignore[assignment]


T = TypeVar("T")


class Table(Value):
    """The results of the sweep of a plan.

    Attributes
    ----------
    columns : dict of ndarray
        Keys of the scene and quantities, of shape (points,), or (points, numbers) for arrays.
    failures : dict
        The first of the points that failed: the reason by the number of the point.
    record : dict
        All that ``hertzchain sweep --json`` prints; for a shard ``{"shard": words}``.
    """

    def __init__(self, study: Study) -> None:
        self.record: dict[str, Any] = study.record
        self.columns: dict[str, Vector] = {}
        if "shard" in self.record:
            self.record = {"shard": study.text.partition(": ")[2].strip()}
        else:
            with np.load(io.BytesIO(study.file("sweep.npz"))) as arrays:
                self.columns = dict(arrays)
        self.failures: dict[int, str] = {one["row"]: one["failure"] for one in self.record.get("failed", [])}

    def __getitem__(self, name: str) -> Vector:
        return self.columns[name]

    def __repr__(self) -> str:
        return self.record.get("shard") or f"Table({', '.join(self.columns)})"


def sweep_plan(
    plan: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    format: str | Iterable[str] = (),
    shard: str | None = None,
    progress: Progress = False,
) -> Table:
    """Run a scene at every point of a grid, as ``hertzchain sweep PLAN.toml`` does.

    Parameters
    ----------
    plan : path
        A TOML file; ``python -m hertzchain sweep --template`` prints one.
    out : path, optional
        A folder for tables and for the store. The same sweep with the same folder resumes: it
        computes only what is missing.
    format : str or list of str, optional
        Formats of the pictures in `out`: ``"png"``, which is the default, ``"svg"`` or both.
    shard : str, optional
        ``"K/N"``: compute the K-th part of N, counted from 1, into a store of its own in `out`; a
        sweep without a shard merges them.
    progress : bool or callable
        As in :func:`run`.
    """
    folder = None if out is None else file_at("out", out)
    formats = texts("format", format)
    if formats and folder is None:
        raise ParameterError(f"format = {format!r} is not valid: pictures need a folder, out")
    return Table(studies.sweep(plan, out=folder, format=formats or ("png",), shard=shard, progress=progress))


class Results(list[Any]):
    """The values of a function at the points of a sweep, in their order; None at points that failed.

    Attributes
    ----------
    failures : dict
        Why points failed, by their numbers.
    """

    def __init__(self, values: Iterable[Any], failures: dict[int, str]) -> None:
        super().__init__(values)
        self.failures = failures


def sweep(
    function: Callable[[Any], Any] | str | os.PathLike[str],
    points: Iterable[Any] = (),
    *,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    name: str | None = None,
    version: int | str | None = None,
    out: str | os.PathLike[str] | None = None,
    format: str | Iterable[str] = (),
    shard: str | None = None,
    comm: Any = None,
    progress: Progress = False,
) -> Any:
    """The values of a function at points, computed on threads; or the sweep of a plan.

    Runs release the interpreter's lock, so that threads use several cores. A point at which the
    function raises an exception has the value None and its reason in ``failures``; if all fail, the
    exception of the first is raised.

    Parameters
    ----------
    function : callable or path
        Called with a point; with a store or MPI its values must be JSON: numbers, strings, lists,
        dictionaries, None; arrays and numbers of numpy become lists and numbers. Or a plan, as for
        :func:`sweep_plan`, with `out`, `format`, `shard`, `progress`.
    points : iterable
        The points; with a store they must be JSON too.
    workers : int, optional
        Threads; by default the number of cores that the process may use, and 1 with `comm`.
    store : path, optional
        A file to which each value is added as soon as it is computed. A sweep with the same file
        computes only what is missing or has failed. One process at a time writes to it.
    name, version : str, int or str
        With a store: name and version of the function; by default it has its own name. Values in
        the store belong to both. With another version all points are computed anew. Refused are
        another name, a point in the store that is not one of `points`, and under the same version
        another function: changed code, other defaults, other values of the variables and globals
        that it reads, of the attributes of its object, or of the arguments of a
        ``functools.partial``; also in functions and classes of its module that it uses. Not
        compared are other modules, what has no digest, such as a lock, and what the function
        itself changes, such as a list of its calls: a change there needs another version.
    shard : str, optional
        ``"K/N"``: compute only every N-th point from the K-th on, counted from 1, into a store of
        their own beside `store`; a sweep without a shard collects these.
    comm : mpi4py communicator, optional
        Divide the points over its ranks; all of them get all values. The points of all ranks must
        be the same. What ends the sweep of one rank, such as a store that cannot be written, is
        raised on every rank.
    progress : bool or callable
        As in :func:`run`.

    Returns
    -------
    Results or Table
        The values in the order of the points; of a shard only its own.

    Warns
    -----
    RunWarning
        If points failed, or a store has values of another version.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C, which also stops runs inside the function; a store then has what was computed.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.sweep(lambda x: x**2, [1, 2, 3])
    [1, 4, 9]
    """
    if not callable(function):
        return sweep_plan(function, out=out, format=format, shard=shard, progress=progress)
    if texts("format", format):
        raise ParameterError(f"format = {format!r} is not valid: a function has no pictures, a plan has")
    if out is not None:
        raise ParameterError(f"out = {out!r} is not valid: a function has a store, a plan a folder")
    if workers is not None and whole("workers", workers) == 0:
        raise ParameterError("workers = 0 is not valid: at least 1")
    threads = workers or (1 if comm is not None else _cores())
    todo: list[Any] = []
    first: Exception | None = None

    def given() -> Any:
        todo.extend(several("points", points, "a list of them"))
        return comm and digest(todo)

    def computed() -> _Rows:
        nonlocal first
        mine, file = _share(len(todo), store, shard, comm)
        owner = None if store is None else _owner(function, name, version)
        rows, first = _computed(function, todo, mine, (file, store, owner), threads, progress)
        return {k: rows[k] for k in mine}

    of_ranks = _on_ranks(comm, given)
    for rank, other in enumerate(of_ranks):
        if other != of_ranks[0]:
            raise ParameterError(f"points are not valid: those of rank {rank} are not those of rank 0")
    rows = {k: row for part in _on_ranks(comm, computed) for k, row in part.items()}
    mine = sorted(rows)
    failures = {k: rows[k][1] for k in mine if rows[k][1] is not None}
    if failures:
        number, reason = next(iter(failures.items()))
        told = f"{len(failures)} of {len(mine)} points failed, the first is number {number}, {todo[number]!r}: {reason}"
        if len(failures) == len(mine):
            raise first or RunError(told)
        warnings.warn(told, RunWarning, stacklevel=2)
    return Results([rows[k][0] for k in mine], failures)  # type: ignore[arg-type]


_Rows = dict[int, tuple[Any, str | None]]
"""By the number of a point its value, and why there is none."""


def _on_ranks(comm: Any, work: Callable[[], T]) -> list[T]:
    """What the work of each rank gives, without ranks of this process; what ends one, ends all."""
    if comm is None:
        return [work()]
    done: T | None = None
    ended: BaseException | None = None
    try:
        done = work()
    except BaseException as error:
        ended = error
    # Every rank comes here, whatever has happened to it: none waits for one that has ended.
    parts = comm.allgather((done, None if ended is None else f"{type(ended).__name__}: {ended}"))
    if ended is not None:
        raise ended
    for rank, (_, words) in enumerate(parts):
        if words is not None:
            raise RunError(f"the sweep of rank {rank} has ended: {words}")
    return [part for part, _ in parts]


def _computed(
    function: Callable[[Any], Any],
    points: list[Any],
    mine: list[int],
    kept: tuple[Path | None, str | os.PathLike[str] | None, _Owner | None],
    threads: int,
    progress: Progress,
) -> tuple[_Rows, Exception | None]:
    """The rows of the points of this process, of a store and computed; the first exception."""
    stop, (file, whole_store, owner) = threading.Event(), kept
    first: Exception | None = None
    with shown(progress, "sweep") as tell, _Store(file, points, owner, function) as store:
        rows: _Rows = {} if owner is None else _Store.read_all(file_at("store", whole_store), points, owner)
        missing = [k for k in mine if k not in rows]

        def one(k: int) -> Any:
            with stopped_by(stop):
                return function(points[k])

        def keep(k: int, future: Future[Any]) -> Exception | None:
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            if error is None:
                try:
                    rows[k] = store.add(k, future.result(), None), None
                    return None
                except ParameterError as refused:
                    error = refused
            reason = f"{type(error).__name__}: {error}"
            rows[k] = store.add(k, None, reason), reason
            return error

        with ThreadPoolExecutor(threads) as pool:
            futures = {pool.submit(one, k): k for k in missing}
            try:
                for done, future in enumerate(as_completed(futures)):
                    error = keep(futures[future], future)
                    first = first or error
                    if tell:
                        tell((done + 1) / len(missing))
            except BaseException:
                # Runs inside the function end; what was complete meanwhile is kept.
                stop.set()
                pool.shutdown(cancel_futures=True)
                for future, k in futures.items():
                    if k not in rows and not future.cancelled() and future.exception() is None:
                        keep(k, future)
                raise
    return rows, first


def _cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _share(
    count: int, store: str | os.PathLike[str] | None, shard: str | None, comm: Any
) -> tuple[list[int], Path | None]:
    """The points of this process, and the file for their values."""
    if shard is not None and comm is not None:
        raise ParameterError("shard and comm are not valid together: ranks divide the points themselves")
    if shard is not None and store is None:
        raise ParameterError(f"shard = {shard!r} is not valid: a shard needs a store")
    if shard is None and comm is None:
        return list(range(count)), None if store is None else file_at("store", store)
    k, n = (comm.Get_rank() + 1, comm.Get_size()) if comm is not None else _shard(shard)
    file = None if store is None else Path(f"{file_at('store', store)}.{k}-of-{n}")
    return list(range(k - 1, count, n)), file


def _shard(shard: Any) -> tuple[int, int]:
    """K and N of ``"K/N"``."""
    parts = re.fullmatch(r"(\d+)/(\d+)", shard) if isinstance(shard, str) else None
    k, n = (int(parts[1]), int(parts[2])) if parts else (0, 0)
    if not 1 <= k <= n:
        raise ParameterError(f'shard = {shard!r} is not valid: "K/N" with 1 <= K <= N')
    return k, n


class _Owner(NamedTuple):
    """The function whose values a store has: its name, its version, and digests of its parts."""

    name: str
    version: str
    code: dict[str, str]


def _owner(function: Callable[[Any], Any], name: str | None, version: int | str | None) -> _Owner:
    """The owner of the values of a function, which must have a name and a version."""
    own = getattr(function, "__qualname__", "<lambda>")
    if name is None and "<lambda>" in own:
        raise ParameterError("name = None is not valid: with a store a function without a name is given one")
    if version is None:
        rule = "with a store a function has a version, such as 1; another one computes all points anew"
        raise ParameterError(f"version = None is not valid: {rule}")
    return _Owner(own if name is None else word("name", name), str(version), _parts(function))


def _parts(function: Callable[[Any], Any]) -> dict[str, str]:
    """Digests of what belongs to a function, which are of this version of Python."""
    return {"python": str(sys.implementation.cache_tag), **belongings(function)}


def _json(value: Any) -> Any:
    """A value that is not JSON itself: an array or a number of numpy."""
    if isinstance(value, (np.ndarray, np.generic)) and not isinstance(value, np.ma.MaskedArray):
        return value.tolist()
    raise TypeError(f"Object of type {type(value).__name__} is not JSON serializable")


class _Store:
    """Lines of JSON, each written whole: ``name, version, code`` of a function, followed by a
    ``point`` each with its ``value`` or the ``failure`` that it had."""

    def __init__(
        self, file: Path | None, points: list[Any], owner: _Owner | None, function: Callable[[Any], Any]
    ) -> None:
        self._points, self._path, self._owner, self._function = points, file, owner, function
        self._file, self._begun = None, False
        if file is None or owner is None:
            return
        with of_file(file):
            self._file = file.open("a+b")
            if fcntl is not None:
                try:
                    fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError:
                    self._file.close()
                    raise FileError(f"{file}: another process writes to it: one store, one sweep at a time") from None
            # A truncated last line is ended, so that the next line begins on its own.
            self._file.seek(0, os.SEEK_END)
            if self._file.tell() > 0:
                self._file.seek(-1, os.SEEK_END)
                if self._file.read(1) != b"\n":
                    self._file.write(b"\n")

    def __enter__(self) -> _Store:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is None:
            return
        if self._begun:
            self._own()
        self._file.close()

    def _own(self) -> None:
        """Says whose values are added, if it is not said yet. What the function itself has changed
        meanwhile does not tell it from another one."""
        assert self._owner is not None
        now = _parts(self._function)
        kept = {name: text for name, text in self._owner.code.items() if now.get(name) == text}
        if not self._begun or kept != self._owner.code:
            self._owner, self._begun = self._owner._replace(code=kept), True
            self._write(self._owner._asdict())

    def _write(self, row: dict[str, Any]) -> Any:
        """Writes a line and returns what a later sweep would read in it."""
        assert self._file is not None
        line = json.dumps(row, default=_json)
        with of_file(self._path):
            self._file.write(line.encode() + b"\n")
            self._file.flush()
        return json.loads(line)

    def add(self, k: int, value: Any, reason: str | None) -> Any:
        """Keeps a value, or why there is none, and returns it as a later sweep would read it."""
        if self._file is None or self._owner is None:
            return value
        row = {"point": self._points[k], **({"value": value} if reason is None else {"failure": reason})}
        if not self._begun:
            self._own()
        try:
            return self._write(row).get("value")
        except (TypeError, ValueError) as error:
            raise ParameterError(f"the value at point {k} is not valid: a store keeps JSON ({error})") from None

    @staticmethod
    def read_all(store: Path, points: list[Any], owner: _Owner) -> _Rows:
        """The values of a function in a store and in the stores of its shards."""
        try:
            places = {json.dumps(point, sort_keys=True, default=_json): k for k, point in enumerate(points)}
        except (TypeError, ValueError) as error:
            raise ParameterError(f"points are not valid: a store keeps JSON ({error})") from None
        if len(places) < len(points):
            raise ParameterError("points are not valid: with a store no point occurs twice")
        known: _Rows = {}
        others: Counter[str] = Counter()
        for file in [store, *sorted(store.parent.glob(store.name + ".*-of-*"))]:
            lines = _lines(file)
            _same(file, [_Owner(**row) for row in lines if "version" in row], owner)
            version: str | None = None
            for row in lines:
                if "version" in row:
                    version = row["version"]
                elif version is None:
                    raise FileError(f"{file}: a value before the name and version of its function: take another store")
                elif version != owner.version:
                    others[version] += 1
                else:
                    k = places.get(json.dumps(row["point"], sort_keys=True))
                    if k is None:
                        raise FileError(f"{file}: the point {row['point']!r} is not of this sweep: take another store")
                    if "value" in row:
                        known[k] = row["value"], None
        for version, count in others.items():
            told = f"{store}: {count} values are of version {version} of {owner.name}, not {owner.version}"
            warnings.warn(f"{told}, and are not used", RunWarning, stacklevel=6)
        return known


def _same(file: Path, there: list[_Owner], here: _Owner) -> None:
    """Refuses the values of another function, and of another one under the same version."""
    for one in there:
        if one.name != here.name:
            raise FileError(f"{file}: it has values of {one.name}, not of {here.name}: take another store")
    # Nothing is compared with another version of Python, and with stores from before: these have a
    # text as the code.
    codes = [one.code for one in there if one.version == here.version and isinstance(one.code, dict)]
    codes = [code for code in codes if code["python"] == here.code["python"]]
    for name, own in here.code.items():
        known = {code.get(name) for code in codes}
        # What a sweep has changed has no digest after it.
        if len(known - {own}) == len(known) == 1 and None not in known:
            rule = "give another version to compute all points anew, or undo the change"
            raise FileError(f"{file}: {name} of {here.name} is not that which version {here.version} had: {rule}")


def _lines(file: Path) -> list[dict[str, Any]]:
    """The complete lines of a store; truncated lines are skipped."""
    rows = []
    with of_file(file):
        for line in file.read_bytes().splitlines() if file.exists() else ():
            try:
                row = json.loads(line)
            except ValueError:
                continue
            if isinstance(row, dict) and ("point" in row or row.keys() == set(_Owner._fields)):
                rows.append(row)
    return rows
