"""The tables of beads, bonds, drives and units of a scene: from Python values to TOML."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from ._arrays import number, vector, whole
from ._errors import ParameterError
from ._native import KEYS
from ._values import read_only

Table = Mapping[str, Any]

BEADS, BONDS, TERM, ROWS, DRIVE, UNITS = (
    tuple(KEYS[name]) for name in ("beads", "bonds", "term", "table", "drive", "units")
)
# Number of bonds that can touch, less the number of sites, by boundary.
TOUCHING = {"free": -1, "ring": 0, "strain-ring": 0, "fixed": 1, "left-wall": 0, "right-wall": 0}


def table(name: str, given: Any, keys: tuple[str, ...], count: int | None) -> Table:
    """A checked copy of a table, which cannot be changed; its lists have `count` numbers."""
    if not isinstance(given, Mapping):
        raise ParameterError(f"{name} = {given!r} is not valid: a dictionary with some of {', '.join(keys)}")
    unknown = [key for key in given if key not in keys]
    if unknown:
        raise ParameterError(f"{name} with the key {unknown[0]!r} is not valid: keys are {', '.join(keys)}")
    return MappingProxyType({key: _value(f"{name}.{key}", value, count) for key, value in given.items()})


def tables(name: str, given: Any, keys: tuple[str, ...], count: int | None = None) -> tuple[Table, ...]:
    """A checked table for each drive, or for each term."""
    if isinstance(given, Mapping) or not isinstance(given, Sequence) or isinstance(given, str):
        each = "term" if keys == TERM else "drive"
        raise ParameterError(f"{name} = {given!r} is not valid: a list of dictionaries, one for each {each}")
    return tuple(table(name, one, keys, count) for one in given)


def _value(name: str, value: Any, count: int | None) -> Any:
    """A number, a word, a list of numbers, or a rule, which the program checks."""
    if isinstance(value, str) or name == "bonds.pull" and isinstance(value, bool):
        return value
    if name in ("drive.site", "drive.seed"):
        return whole(name, value)
    if name == "bonds.terms":
        return tables(name, value, TERM, count)
    if name == "bonds.table":
        return table(name, value, ROWS, None)
    if isinstance(value, Mapping):
        return MappingProxyType({key: _fixed(one) for key, one in value.items()})
    if isinstance(value, (list, tuple)) or isinstance(value, np.ndarray) and value.ndim > 0:
        return read_only(vector(name, value, count).copy())
    return number(name, value)


def _fixed(value: Any) -> Any:
    """A copy of a part of a rule, which cannot be changed."""
    if isinstance(value, (list, tuple)):
        return tuple(map(_fixed, value))
    return read_only(value.copy()) if isinstance(value, np.ndarray) else value


def text_of(
    beads: Table | None, bonds: Table | None, drive: tuple[Table, ...], units: Table | None
) -> str:
    """The tables as TOML; each number is read back to the bit."""
    named = [("[beads]", beads), ("[bonds]", bonds), ("[units]", units), *(("[[drive]]", one) for one in drive)]
    lines = [[head, *(f"{key} = {_toml(value)}" for key, value in one.items())] for head, one in named if one]
    return "".join("\n".join(block) + "\n" for block in lines)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, np.ndarray):
        return "[" + ", ".join(map(repr, value.tolist())) + "]"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, (int, np.integer)):
        return repr(int(value))
    return repr(number("rule", value))
