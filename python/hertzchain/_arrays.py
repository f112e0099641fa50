"""Checks of the numbers, arrays and paths that a caller gives, and their conversion to doubles."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import ParameterError

Vector = NDArray[np.float64]


def unmasked(name: str, values: Any) -> NDArray[Any]:
    """What is given as an array, without a mask: masked entries have numbers too."""
    masked = [values, *values] if isinstance(values, (list, tuple)) else [values]
    if any(isinstance(one, np.ma.MaskedArray) for one in masked):
        raise ParameterError(f"{name} is not valid: an array without a mask, such as that of .filled(0)")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise ParameterError(f"{name} is not valid: an array of numbers ({error})") from None


def vector(name: str, values: Any, length: int | None = None) -> Vector:
    """A one-dimensional array of doubles with exactly the given values.

    Parameters
    ----------
    name : str
        Name of the argument in messages.
    values : array_like
        Numbers in one dimension, of any layout and of any type whose values doubles can hold.
    length : int, optional
        The required length.

    Returns
    -------
    numpy.ndarray
        Shape (length,), contiguous.
    """
    given = unmasked(name, values)
    if given.dtype.kind not in "fiub":
        raise ParameterError(f"{name} of type {given.dtype} is not valid: real numbers")
    if given.ndim != 1:
        raise ParameterError(f"{name} of shape {given.shape} is not valid: one dimension")
    if length is not None and given.shape[0] != length:
        raise ParameterError(f"{name} with {given.shape[0]} numbers is not valid: {length} of them")
    doubles = np.ascontiguousarray(given, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        kept = given.dtype.kind == "f" and given.dtype.itemsize <= 8 or _same(doubles, given)
    if not kept:
        raise ParameterError(f"{name} of type {given.dtype} is not valid: doubles cannot hold it")
    return doubles


def _same(doubles: Vector, given: NDArray[Any]) -> bool:
    """Whether the doubles equal the values of the array of another type from which they come."""
    if given.dtype.kind == "f":
        return bool(np.array_equal(doubles.astype(given.dtype), given, equal_nan=True))
    if given.dtype.kind in "iu":
        return [int(value) for value in doubles] == given.tolist() if given.dtype.itemsize == 8 else True
    return True


def number(name: str, value: Any) -> float:
    """A number as a double.

    Parameters
    ----------
    name : str
        Name of the argument in messages.
    value : float
        The number, such as 1.5, 2 or ``numpy.float64(3)``.
    """
    wrong = isinstance(value, (bool, str, bytes, complex, np.ma.MaskedArray))
    if wrong or not hasattr(value, "__float__") and not hasattr(value, "__index__"):
        raise ParameterError(f"{name} = {value!r} is not valid: a number")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"{name} = {value!r} is not valid: a number ({error})") from None


def flag(name: str, value: Any) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise ParameterError(f"{name} = {value!r} is not valid: True or False")
    return bool(value)


def file_at(name: str, value: Any) -> Path:
    """A path, such as ``"run.npz"``."""
    try:
        return Path(os.fsdecode(value))
    except TypeError:
        raise ParameterError(f"{name} = {value!r} is not valid: a path") from None


def optional(name: str, value: Any) -> float | None:
    """As :func:`number`, or None."""
    return None if value is None else number(name, value)


def whole(name: str, value: Any) -> int:
    """A whole number, at least zero."""
    try:
        count = -1 if isinstance(value, bool) else operator.index(value)
    except (TypeError, np.ma.MaskError):
        count = -1
    if not 0 <= count < 2**63:
        rule = "a whole number, at least zero" if count < 0 else "below 2^63"
        raise ParameterError(f"{name} = {value!r} is not valid: {rule}")
    return count


def word(name: str, value: Any) -> str:
    """A string."""
    if not isinstance(value, str):
        raise ParameterError(f"{name} = {value!r} is not valid: a string")
    return value


def several(name: str, given: Any, rule: str) -> list[Any]:
    """What is given as a list, a tuple, an array or another iterable."""
    if not isinstance(given, Iterable) or isinstance(given, str) or getattr(given, "ndim", 1) == 0:
        raise ParameterError(f"{name} = {given!r} is not valid: {rule}")
    return list(given)


def texts(name: str, given: Any) -> list[str]:
    """One or several texts."""
    given = [given] if isinstance(given, str) else given
    return [word(name, one) for one in several(name, given, "a text, or a list of them")]
