"""Studies by the words of their commands."""

from __future__ import annotations

import difflib
import html
import inspect
import json
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arrays import file_at, number, texts, unmasked, word
from ._chain import Chain, Scene, changes_of
from ._errors import ParameterError, RunWarning, UnknownNameError, of_file
from ._progress import Progress, shown
from ._values import read_only


@dataclass(frozen=True)
class _Kept:
    """What a copy of a study in another process has of its report: all but the pictures."""

    json: str
    text: str
    failure: str | None
    remark: str | None
    _tables: list[tuple[str, list[tuple[str, list[Any]]]]]
    _files: list[tuple[str, bytes]]

    def tables(self) -> list[tuple[str, list[tuple[str, list[Any]]]]]:
        return self._tables

    def files(self, formats: list[str]) -> list[tuple[str, bytes]]:
        if formats:
            raise ParameterError(f"format = {formats!r} is not valid: a study that was pickled has no pictures, only ()")
        return self._files


class Study:
    """The report of a study; :func:`study` and the functions of ``hertzchain.studies`` return it.

    Attributes
    ----------
    failure, remark : str or None
        Why the study has not done what it was asked for; what else is remarkable.
    """

    def __init__(self, report: _native.Report | _Kept) -> None:
        self._report = report
        self.failure, self.remark = report.failure, report.remark

    def __reduce__(self) -> tuple[Any, ...]:
        of = self._report
        return Study, (_Kept(of.json, of.text, of.failure, of.remark, of.tables(), of.files([])),)

    def __eq__(self, other: object) -> bool:
        return self._report.json == other._report.json if isinstance(other, Study) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._report.json)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"

    @cached_property
    def record(self) -> dict[str, Any]:
        """All that the command prints with ``--json``."""
        record: dict[str, Any] = json.loads(self._report.json)
        return record

    @cached_property
    def tables(self) -> dict[str, NDArray[Any]]:
        """The tables by the names of their CSV files, as structured arrays.

        Columns have doubles, whole numbers, truth values or words; missing numbers are ``nan``.
        """
        return {name: _table(columns) for name, columns in self._report.tables()}

    @property
    def text(self) -> str:
        """The text that the command prints."""
        return self._report.text

    def __repr__(self) -> str:
        return self.text.rstrip("\n")

    def file(self, name: str) -> bytes:
        """The bytes of a file of the study, such as its NPZ file."""
        files = dict(self._report.files([]))
        if word("name", name) not in files:
            raise ParameterError(f"name = {name!r} is not valid: one of {', '.join(files)}")
        return files[name]

    def save(self, folder: str | os.PathLike[str], format: str | Iterable[str] = "png") -> None:
        """Write the files of the study, with its pictures in the formats ``"png"`` or ``"svg"``."""
        formats = texts("format", format)
        into = file_at("folder", folder)
        with of_file(into):
            into.mkdir(parents=True, exist_ok=True)
        for name, content in self._report.files(formats):
            written(into / name, content)


def written(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file whole or not at all."""
    file = file_at("path", path)
    part = Path(f"{file}.part")
    with of_file(file):
        try:
            part.write_bytes(content)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)


def _table(columns: list[tuple[str, list[Any]]]) -> NDArray[Any]:
    arrays = {name: np.array(values) for name, values in columns}
    table = np.empty(len(columns[0][1]), dtype=[(name, array.dtype) for name, array in arrays.items()])
    for name, array in arrays.items():
        table[name] = array
    return read_only(table)


def study(command: str, /, *, progress: Progress = False, **options: Any) -> Study:
    """Do a study of the program, with the same results as its command.

    Parameters
    ----------
    command : str
        The words of the command, such as ``"wave exact"``.
    progress : bool or callable
        As in :func:`run`.
    **options
        Options of the command, with underscores and ``from_`` for ``from``: numbers, words, lists,
        and ``True`` for flags without a value. A scene is a name, a path, a :class:`Scene` or a
        :class:`Chain` (at rest); ``set`` is a dictionary. With ``out`` the files are written to this
        folder; a study that keeps its points there goes on with them.

    Raises
    ------
    ParameterError, UnknownNameError, SceneError
        For options that are refused.
    KeyboardInterrupt
        On Ctrl-C; if the study reports what was done before, this is its attribute ``partial``.

    Warns
    -----
    RunWarning
        If the study has not done what it was asked for; ``failure`` says why.

    Examples
    --------
    >>> import hertzchain as hc
    >>> orbit = hc.study("orbit driven", scene="granular-crystal", settle=20)
    >>> orbit.record["unstable"], orbit.tables["leading-multipliers"].dtype.names[:2]
    (0, ('re', 'im'))
    """
    from . import studies

    functions = {function.__name__: function for function in vars(studies).values() if inspect.isfunction(function)}
    del functions[called.__name__]
    name = word("study", command).removeprefix("study ").replace(" ", "_").replace("-", "_")
    known("study", name, functions)
    for option in options:
        known("option", option, inspect.signature(functions[name]).parameters)
    done: Study = functions[name](progress=progress, **options)
    return done


def known(kind: str, name: str, names: Iterable[str]) -> None:
    """Refuses a name that is not one of these."""
    if name not in names:
        near = difflib.get_close_matches(name, names, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"one of {', '.join(names)}"
        raise UnknownNameError(f"unknown {kind} {name!r}; {hint}")


def called(command: str, function: Callable[..., Study], given: Mapping[str, Any]) -> Study:
    """The study of a function, with the arguments that are not its defaults."""
    flags, operands = ["hertzchain", *command.split()], ["--"]
    for name, parameter in inspect.signature(function).parameters.items():
        if name == "progress" or given[name] is None or given[name] is parameter.default:
            continue
        flag, words = "--" + name.strip("_").replace("_", "-"), _words(name, given[name])
        if parameter.kind is parameter.POSITIONAL_OR_KEYWORD:
            operands += words
        elif "Mapping" in parameter.annotation:
            flags += [f"{flag}={each}" for each in words]
        elif words == ["true"]:
            flags.append(flag)
        elif words != ["false"] or parameter.default is not False:
            flags.append(f"{flag}={','.join(words)}")
    with shown(given["progress"], command) as tell:
        report, raised = _native.study(flags + operands, tell)
    if raised is not None:
        if report is not None:
            raised.partial = Study(report)  # type: ignore[attr-defined]
        raise raised
    assert report is not None
    if report.failure is not None:
        warnings.warn(report.failure, RunWarning, stacklevel=3)
    return Study(report)


def _words(name: str, value: Any) -> list[str]:
    """The values of an option as the program reads them; numbers are read back to the bit."""
    if isinstance(value, Chain):
        value = value.scene({}, 1.0)
    if isinstance(value, Scene):
        return [value.to_toml()]
    if isinstance(value, Mapping):
        return changes_of(value)
    if isinstance(value, (str, os.PathLike)):
        return [word(name, os.fspath(value))]
    if isinstance(value, np.ndarray):
        return _words(name, unmasked(name, value).tolist())
    if isinstance(value, Sequence):
        return [one for each in value for one in _words(name, each)]
    if isinstance(value, (bool, np.bool_)):
        return ["true" if value else "false"]
    return [repr(int(value))] if hasattr(value, "__index__") else [repr(number(name, value))]
