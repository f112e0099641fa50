"""Chains and scenes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _native
from ._arrays import Vector, number, vector, whole, word
from ._errors import ParameterError

STRAIN_RING = "strain-ring"
Arrays = tuple[Vector | None, Vector | None, Vector | None, Vector | None]


@dataclass(frozen=True)
class Chain:
    """A chain of equal beads, each with a linear resonator.

    Beads push each other with the force (overlap)_+^alpha:
    ``u_n'' = (u_{n-1} - u_n)_+^alpha - (u_n - u_{n+1})_+^alpha - kappa (u_n - v_n)`` and
    ``rho v_n'' = kappa (u_n - v_n)``.

    Parameters
    ----------
    sites : int
        Number of beads.
    alpha : float
        Exponent of the contact force; 1.5 for spheres.
    kappa : float
        Spring constant of the resonators; 0 for none.
    rho : float
        Mass ratio resonator to bead; 0 for no resonators, ``math.inf`` for resonators at rest.
    boundary : {"free", "fixed", "ring", "strain-ring"}
        What is beyond the ends. On a strain ring the unknowns are strains ``x, y``.
    precompression : float
        Static overlap of each contact.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain(sites=10, kappa=1, rho=1 / 3)
    >>> round(chain.omega, 12)
    2.0
    """

    sites: int
    alpha: float = 1.5
    kappa: float = 0.0
    rho: float = 0.0
    boundary: str = "free"
    precompression: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sites", whole("sites", self.sites))
        for name in ("alpha", "kappa", "rho", "precompression"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        word("boundary", self.boundary)
        params = [self.alpha, self.kappa, self.rho]
        _native.check_chain(self.sites, params, self.boundary, self.precompression)

    @property
    def omega(self) -> float:
        """Frequency of a bead against its resonator, ``sqrt(kappa (1 + 1/rho))``."""
        if self.rho == 0.0 or self.kappa == 0.0:
            return 0.0
        return math.sqrt(self.kappa * (1.0 + 1.0 / self.rho))

    @property
    def resonators(self) -> bool:
        """Whether resonators move."""
        return self.kappa > 0.0 and 0.0 < self.rho < math.inf

    def _native(self, state: Any, until: float) -> _native.Scene:
        return _native.Scene.of_chain(
            self.sites, self.alpha, self.kappa, self.rho, self.boundary, self.precompression, tuple(state), until
        )

    def scene(self, y0: Any, until: float) -> Scene:
        """A scene: this chain from a state up to a time.

        Parameters
        ----------
        y0 : mapping or array_like
            The state, as in :func:`run`.
        until : float
            End time.
        """
        state = velocities(y0, self.sites, self.resonators, self.rho, self.boundary == STRAIN_RING)
        return Scene(self._native(state, number("until", until)))


class Scene:
    """A complete set-up: chain, initial state, time span, number of samples.

    Scenes come from :meth:`load`, :meth:`from_toml` or :meth:`Chain.scene`.

    Examples
    --------
    >>> import hertzchain as hc
    >>> scene = hc.Scene.load("tw-q15", {"chain.rho": 1.0})
    >>> scene.sites, scene.chain.rho
    (50, 1.0)
    """

    def __init__(self, native: _native.Scene) -> None:
        self._scene = native
        self._chain: Chain | None = None

    @staticmethod
    def names() -> dict[str, str]:
        """Names of the built-in scenes, and what they show."""
        return dict(_native.scenes())

    @staticmethod
    def load(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
        """A built-in scene by its name, or the scene in a TOML file.

        Parameters
        ----------
        name : str
            Name or path.
        changes : mapping, optional
            Keys of the scene with new values, such as ``{"chain.rho": 3}``.
        """
        return Scene(_native.Scene.load(word("scene", str(name)), changes_of(changes)))

    @staticmethod
    def from_toml(text: str, changes: Mapping[str, Any] | None = None, name: str = "scene") -> Scene:
        """The scene in a text; messages call it `name`."""
        return Scene(_native.Scene.parse(word("text", text), word("name", name), changes_of(changes)))

    def to_toml(self) -> str:
        """The scene as the text of a file."""
        return self._scene.to_toml()

    def until(self, end: float) -> Scene:
        """The scene with another end time."""
        return Scene(self._scene.until(number("until", end)))

    def plan(self, events: bool = False) -> list[str]:
        """What a run computes and what it leaves out, in words."""
        return self._scene.plan(events)

    @property
    def chain(self) -> Chain:
        """The chain."""
        if self._chain is None:
            self._chain = Chain(*self._scene.chain)
        return self._chain

    @property
    def name(self) -> str:
        """Short name."""
        return self._scene.name

    @property
    def sites(self) -> int:
        """Number of beads."""
        return self._scene.chain[0]

    @property
    def period(self) -> float:
        """Unit of time of "steps per period"."""
        return self._scene.period

    @property
    def end(self) -> float:
        """End time; scenes begin at zero."""
        return self._scene.end

    @property
    def y0(self) -> dict[str, Vector]:
        """The initial state: ``u, v, pu, pv``, or ``x, y, vx, vy`` on a strain ring."""
        chain = self.chain
        strains = chain.boundary == STRAIN_RING
        u, v, u_dot, v_dot = self._scene.initial()
        if v_dot is not None and not strains:
            v_dot = chain.rho * v_dot
        return {name: array for name, array in zip(names(strains), (u, v, u_dot, v_dot)) if array is not None}

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, sites={self.sites}, end={self.end:g})"


def names(strains: bool) -> tuple[str, str, str, str]:
    """The names of the four arrays of a state."""
    return ("x", "y", "vx", "vy") if strains else ("u", "v", "pu", "pv")


def changes_of(changes: Mapping[str, Any] | None) -> list[str]:
    """Changes to a scene as the program takes them."""

    def value(of: Any) -> str:
        if isinstance(of, bool):
            return "true" if of else "false"
        if isinstance(of, str):
            return of
        if isinstance(of, (list, tuple, np.ndarray)):
            return "[" + ", ".join(value(one) for one in np.asarray(of).tolist()) + "]"
        return repr(int(of)) if hasattr(of, "__index__") else repr(number("change", of))

    return [f"{key}={value(of)}" for key, of in (changes or {}).items()]


def velocities(y0: Any, sites: int, resonators: bool, rho: float, strains: bool) -> Arrays:
    """The arrays ``u, v, u', v'`` of a state that is given by momenta, or by strains and rates."""
    known = names(strains)
    if isinstance(y0, Mapping):
        unknown = [key for key in y0 if key not in known]
        if unknown:
            raise ParameterError(f"y0 with the key {unknown[0]!r} is not valid: keys are {', '.join(known)}")
        arrays = {name: vector(name, y0[name], sites) for name in known if y0.get(name) is not None}
    else:
        parts = [name for k, name in enumerate(known) if resonators or k % 2 == 0]
        flat = vector("y0", y0, len(parts) * sites)
        arrays = dict(zip(parts, np.split(flat, len(parts))))
    u, v, pu, pv = (arrays.get(name) for name in known)
    if pv is not None and resonators and not strains:
        pv = pv / rho
    return u, v, pu, pv
