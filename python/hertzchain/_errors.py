"""Errors, with the text of the program."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any


class Error(Exception):
    """Any error of hertzchain. For a refused value the message names the value and the rule."""


class ParameterError(Error, ValueError):
    """A value outside its rule."""


class UnknownNameError(Error, ValueError):
    """A name that is not known; the message has the nearest one."""


class SceneError(Error, ValueError):
    """A scene with a missing or wrong entry; the message has the key and the rule."""


class RunError(Error, RuntimeError):
    """An integration that failed before its end."""


class ConvergenceError(Error, RuntimeError):
    """A search for a periodic orbit that did not converge."""


class FileError(Error, OSError):
    """A file that cannot be read or written, or whose content is not valid."""


@contextlib.contextmanager
def of_file(file: Any) -> Iterator[None]:
    """What the system refuses becomes a :class:`FileError` that names the file."""
    try:
        yield
    except OSError as error:
        if isinstance(error, Error):
            raise
        raise FileError(f"{file}: {error.strerror or error}") from None


class RunWarning(RuntimeWarning):
    """A result that is doubtful or not whole; the message says why."""


class InternalError(Error, RuntimeError):
    """A bug of hertzchain."""
