"""What results have in common: read-only arrays, equality by numbers, a table for notebooks."""

from __future__ import annotations

import html
from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray


T = TypeVar("T")


class Value:
    """A result: it equals another one of its class whose attributes have the same bits.

    The arrays that it keeps are read-only.
    """

    _left_out: ClassVar[frozenset[str]] = frozenset()
    """Attributes that equality leaves out, such as times of the clock."""

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, read_only(value))

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            setattr(self, name, value)

    def _own(self) -> dict[str, Any]:
        """The attributes that are not computed from others when they are first asked for."""
        kind = type(self)
        return {name: of for name, of in vars(self).items() if not isinstance(getattr(kind, name, None), cached_property)}

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        assert isinstance(other, Value)
        one, two = ({name: of for name, of in each._own().items() if name not in self._left_out} for each in (self, other))
        return alike(one, two)

    __hash__ = None  # type: ignore[assignment]

    def _repr_html_(self) -> str:
        shown = {name: of for name, of in self._own().items() if not name.startswith("_") and name != "record"}
        return html_table(type(self).__name__, shown)


class Made:
    """An object that is made anew from the arguments in ``_given``."""

    _given: Any
    _maker: Any = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self._maker or type(self), self._given)

    def _own(self) -> dict[str, Any]:
        given: dict[str, Any] = self._given
        return given

    def __repr__(self) -> str:
        return f"{type(self).__name__}(" + ", ".join(f"{name}={brief(of)}" for name, of in self._given.items()) + ")"

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self._given)


def _made(maker: Any, given: dict[str, Any]) -> Any:
    return maker(**given)


def read_only(value: T) -> T:
    """A value with views in place of its arrays, also in dictionaries, that cannot be written to."""
    of: Any = value
    if isinstance(of, np.ndarray):
        of = of.view()
        of.flags.writeable = False
    if type(of) is dict:
        of = {key: read_only(one) for key, one in of.items()}
    kept: T = of
    return kept


def copies(state: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Copies of the arrays of a state, which can be changed."""
    return {name: array.copy() for name, array in state.items()}


def alike(one: Any, two: Any) -> bool:
    """Whether two values have the same types and bits; NaN equals NaN."""
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return one.dtype == two.dtype and one.shape == two.shape and one.tobytes() == two.tobytes()
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(alike(of, two[name]) for name, of in one.items())
    if isinstance(one, (list, tuple)) and isinstance(two, (list, tuple)):
        return len(one) == len(two) and all(map(alike, one, two))
    return type(one) is type(two) and bool(one == two or one != one and two != two)


def html_table(title: str, values: Mapping[str, Any]) -> str:
    """Names and values as a table in HTML; arrays and lists by their sizes."""
    rows = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(brief(of))}</td></tr>" for name, of in values.items())
    return f"<table><caption>{html.escape(title)}</caption>{rows}</table>"


def brief(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return f"array{value.shape}"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {brief(one)}" for key, one in value.items()) + "}"
    if isinstance(value, (list, tuple)) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(brief, value)) + "]"
    return f"{value:.10g}" if isinstance(value, float) else repr(value)


def plain(value: Any) -> Any:
    """A value with dictionaries in place of read-only mappings, which cannot be pickled."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    return [plain(one) for one in value] if isinstance(value, (list, tuple)) else value
