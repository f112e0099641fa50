"""Sweeps: a function at many points, on threads, on shards and on MPI ranks."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from ._errors import FileError, ParameterError
from ._progress import Progress, shown


def sweep(
    function: Callable[[Any], Any],
    points: Iterable[Any],
    *,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    shard: tuple[int, int] | None = None,
    comm: Any = None,
    progress: Progress = False,
) -> list[Any]:
    """The values of a function at points, computed on threads.

    Runs release the interpreter's lock, so that threads use several cores.

    Parameters
    ----------
    function : callable
        Called with a point; with a store or MPI its values must be JSON: numbers, strings, lists,
        dictionaries, None.
    points : iterable
        The points; with a store they must be JSON too.
    workers : int, optional
        Threads; by default the number of cores.
    store : path, optional
        A file to which each value is added as soon as it is there. A sweep with the same file
        computes only what is missing.
    shard : (int, int), optional
        ``(k, n)``: compute only the points k, k + n, k + 2 n, and so on, counted from 0, into a store
        of their own beside `store`; a sweep without a shard collects these.
    comm : mpi4py communicator, optional
        Divide the points over its ranks; all of them get all values.
    progress : bool or callable
        As in :func:`run`.

    Returns
    -------
    list
        The values in the order of the points; of a shard only its own.

    Examples
    --------
    >>> import hertzchain as hc
    >>> hc.sweep(lambda x: x**2, [1, 2, 3])
    [1, 4, 9]
    """
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
    count: int, store: str | os.PathLike[str] | None, shard: tuple[int, int] | None, comm: Any
) -> tuple[list[int], Path | None]:
    """The points of this process, and the file for their values."""
    if shard is not None and comm is not None:
        raise ParameterError("shard and comm are not valid together: ranks divide the points themselves")
    if comm is not None:
        shard = (comm.Get_rank(), comm.Get_size())
    elif shard is not None and store is None:
        raise ParameterError(f"shard = {shard!r} is not valid: a shard needs a store")
    if shard is None:
        return list(range(count)), None if store is None else Path(store)
    k, n = shard
    if not 0 <= k < n:
        raise ParameterError(f"shard = {shard!r} is not valid: (k, n) with 0 <= k < n")
    file = None if store is None else Path(f"{os.fspath(store)}.{k}-of-{n}")
    return list(range(k, count, n)), file


class _Store:
    """Lines ``{"point": .., "value": ..}``, each written whole."""

    def __init__(self, file: Path | None, points: list[Any]) -> None:
        self._points = points
        self._file = None if file is None else file.open("a+b")
        if self._file is not None:
            # A line that was torn is ended, so that the next one is whole.
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
    """The whole lines of a store; a torn one is passed over."""
    if not file.exists():
        return
    with file.open("rb") as lines:
        for line in lines:
            try:
                row = json.loads(line)
                yield row["point"], row["value"]
            except (ValueError, KeyError, TypeError):
                continue
