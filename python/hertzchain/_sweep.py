"""Sweeps: a function at many points, on threads, in shards and on MPI ranks."""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from . import studies
from ._arrays import Vector, word
from ._errors import FileError, ParameterError
from ._progress import Progress, shown
from ._study import Study


class Table:
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
    folder = None if out is None else os.fspath(out)
    formats = [word("format", name) for name in ([format] if isinstance(format, str) else format)]
    if formats and folder is None:
        raise ParameterError(f"format = {format!r} is not valid: pictures need a folder, out")
    return Table(studies.sweep(plan, out=folder, format=formats or ("png",), shard=shard, progress=progress))


def sweep(
    function: Callable[[Any], Any] | str | os.PathLike[str],
    points: Iterable[Any] = (),
    *,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] | None = None,
    format: str | Iterable[str] = (),
    shard: str | None = None,
    comm: Any = None,
    progress: Progress = False,
) -> Any:
    """The values of a function at points, computed on threads; or the sweep of a plan.

    Runs release the interpreter's lock, so that threads use several cores.

    Parameters
    ----------
    function : callable or path
        Called with a point; with a store or MPI its values must be JSON: numbers, strings, lists,
        dictionaries, None. Or a plan, as for :func:`sweep_plan`, with `out`, `format`, `shard`,
        `progress`.
    points : iterable
        The points; with a store they must be JSON too.
    workers : int, optional
        Threads; by default the number of cores.
    store : path, optional
        A file to which each value is added as soon as it is computed. A sweep with the same file
        computes only what is missing.
    shard : str, optional
        ``"K/N"``: compute only every N-th point from the K-th on, counted from 1, into a store of
        their own beside `store`; a sweep without a shard collects these.
    comm : mpi4py communicator, optional
        Divide the points over its ranks; all of them get all values.
    progress : bool or callable
        As in :func:`run`.

    Returns
    -------
    list or Table
        The values in the order of the points; of a shard only its own.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.sweep(lambda x: x**2, [1, 2, 3])
    [1, 4, 9]
    """
    if not callable(function):
        return sweep_plan(function, out=out, format=format, shard=shard, progress=progress)
    if format:
        raise ParameterError(f"format = {format!r} is not valid: a function has no pictures, a plan has")
    if out is not None:
        raise ParameterError(f"out = {os.fspath(out)!r} is not valid: a function has a store, a plan a folder")
    todo = list(points)
    mine, file = _share(len(todo), store, shard, comm)
    known = {} if file is None else _Store.read_all(Path(store or ""), todo)
    missing = [k for k in mine if k not in known]
    with shown(progress, "sweep") as tell, _Store(file, todo) as kept:
        with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
            try:
                for done, (k, value) in enumerate(zip(missing, pool.map(lambda k: function(todo[k]), missing))):
                    known[k] = kept.add(k, value)
                    if tell:
                        tell((done + 1) / len(missing))
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    if comm is not None:
        for part in comm.allgather({k: known[k] for k in mine}):
            known.update(part)
        return [known[k] for k in range(len(todo))]
    return [known[k] for k in mine]


def _share(
    count: int, store: str | os.PathLike[str] | None, shard: str | None, comm: Any
) -> tuple[list[int], Path | None]:
    """The points of this process, and the file for their values."""
    if shard is not None and comm is not None:
        raise ParameterError("shard and comm are not valid together: ranks divide the points themselves")
    if shard is not None and store is None:
        raise ParameterError(f"shard = {shard!r} is not valid: a shard needs a store")
    if shard is None and comm is None:
        return list(range(count)), None if store is None else Path(store)
    k, n = (comm.Get_rank() + 1, comm.Get_size()) if comm is not None else _shard(shard)
    file = None if store is None else Path(f"{os.fspath(store)}.{k}-of-{n}")
    return list(range(k - 1, count, n)), file


def _shard(shard: Any) -> tuple[int, int]:
    """K and N of ``"K/N"``."""
    parts = re.fullmatch(r"(\d+)/(\d+)", shard) if isinstance(shard, str) else None
    k, n = (int(parts[1]), int(parts[2])) if parts else (0, 0)
    if not 1 <= k <= n:
        raise ParameterError(f'shard = {shard!r} is not valid: "K/N" with 1 <= K <= N')
    return k, n


class _Store:
    """Lines ``{"point": .., "value": ..}``, each written whole."""

    def __init__(self, file: Path | None, points: list[Any]) -> None:
        self._points = points
        self._file = None if file is None else file.open("a+b")
        if self._file is not None:
            # A truncated last line is ended, so that the next line begins on its own.
            self._file.seek(0, os.SEEK_END)
            if self._file.tell() > 0:
                self._file.seek(-1, os.SEEK_END)
                if self._file.read(1) != b"\n":
                    self._file.write(b"\n")

    def __enter__(self) -> _Store:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()

    def add(self, k: int, value: Any) -> Any:
        """Keeps a value and returns it as a later sweep would read it."""
        if self._file is None:
            return value
        try:
            line = json.dumps({"point": self._points[k], "value": value})
        except TypeError as error:
            raise ParameterError(f"the value at point {k} is not valid: a store keeps JSON ({error})") from None
        self._file.write(line.encode() + b"\n")
        self._file.flush()
        return json.loads(line)["value"]

    @staticmethod
    def read_all(store: Path, points: list[Any]) -> dict[int, Any]:
        """The values in a store and in the stores of its shards."""
        try:
            places = {json.dumps(point, sort_keys=True): k for k, point in enumerate(points)}
        except TypeError as error:
            raise ParameterError(f"points are not valid: a store keeps JSON ({error})") from None
        if len(places) < len(points):
            raise ParameterError("points are not valid: with a store no point occurs twice")
        known: dict[int, Any] = {}
        for file in [store, *sorted(store.parent.glob(store.name + ".*-of-*"))]:
            for point, value in _rows(file):
                k = places.get(json.dumps(point, sort_keys=True))
                if k is None:
                    raise FileError(f"{file}: the point {point!r} is not of this sweep: take another store")
                known[k] = value
        return known


def _rows(file: Path) -> Iterator[tuple[Any, Any]]:
    """The complete lines of a store; truncated lines are skipped."""
    if not file.exists():
        return
    with file.open("rb") as lines:
        for line in lines:
            try:
                row = json.loads(line)
                yield row["point"], row["value"]
            except (ValueError, KeyError, TypeError):
                continue
