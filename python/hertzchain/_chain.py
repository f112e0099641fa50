"""Chains and scenes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from . import _native
from ._arrays import Vector, flag, number, unmasked, vector, whole, word
from ._errors import ParameterError
from ._tables import BEADS, BONDS, DRIVE, TOUCHING, UNITS, Table, table, tables, text_of
from ._values import Made, html_table, plain, read_only

STRAIN_RING = "strain-ring"
Arrays = tuple[Vector | None, Vector | None, Vector | None, Vector | None]


@dataclass(frozen=True, repr=False)
class Chain(Made):
    """A chain of beads, each with a linear resonator.

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
    boundary : {"free", "fixed", "left-wall", "right-wall", "ring", "strain-ring"}
        Nothing beyond the ends, walls, one wall, or a ring. On a strain ring the unknowns are strains
        ``x, y``.
    precompression : float
        Static overlap of each contact.
    beads : mapping, optional
        Parameters of the beads, such as ``mass``. A value is one number for all beads, an array of
        shape (sites,), or a rule such as ``{"taper": 0.97}``.
    bonds : mapping, optional
        Parameters of the bonds, such as ``contact``, with values as for `beads`, or one number where
        the table has one. ``terms`` are further powers in the force of contacts, a list such as
        ``[{"contact": 0.5, "alpha": 2.5}]``; ``table`` has arrays ``overlap`` and ``force`` in
        place of the first power. An array has one number for
        each bond that can touch, from left to right: ``sites - 1`` between free ends, ``sites`` with
        one wall or on a ring, ``sites + 1`` between walls. ``wall``, the contact constant of walls,
        is one number.
    drive : sequence of mappings, optional
        Beads that are moved or pushed: ``site, kind, amplitude, omega, phase, ramp`` and so on;
        ``velocity`` for a piston, ``times, values`` or a ``file`` for a recorded signal.
    units : mapping, optional
        ``system="SI"``, and spheres: ``radius, density, young, poisson`` and so on. All numbers of
        the chain, and states and times given for it, are then in SI units.

        These four have the keys, rules and meanings of the tables of a scene, which
        ``hertzchain scenes template`` explains.
    gravity : float
        Acceleration of gravity; 0 for none.
    tilt : float
        Angle of the chain below the horizontal in degrees: at 90 its right end is at the bottom.

    Examples
    --------
    >>> import hertzchain as hc
    >>> chain = hc.Chain(sites=10, kappa=1, rho=1 / 3)
    >>> round(chain.omega, 12)
    2.0

    A dimer, with a heavy first bead.

    >>> import numpy as np
    >>> mass = np.where(np.arange(10) % 2, 0.3428, 1.0)
    >>> mass[0] = 5.0
    >>> dimer = hc.Chain(sites=10, beads={"mass": mass})
    >>> run = hc.run(dimer, y0={"pu": 5.0 * np.eye(10)[0]}, until=20.0, tol=1e-10)
    >>> bool(abs(run.pu[-1].sum() - 5.0) < 1e-11)
    True
    """

    sites: int
    alpha: float = 1.5
    kappa: float = 0.0
    rho: float = 0.0
    boundary: str = "free"
    precompression: float = 0.0
    beads: Table | None = field(default=None, compare=False)
    bonds: Table | None = field(default=None, compare=False)
    drive: Sequence[Table] = field(default=(), compare=False)
    units: Table | None = field(default=None, compare=False)
    gravity: float = 0.0
    tilt: float = 90.0
    _tables: str = field(init=False, default="", repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sites", whole("sites", self.sites))
        for name in ("alpha", "kappa", "rho", "precompression", "gravity", "tilt"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        word("boundary", self.boundary)
        _native.check_chain(self._numbers)
        counts = {"beads": (BEADS, self.sites), "bonds": (BONDS, self.sites + TOUCHING[self.boundary])}
        for name, (keys, count) in {**counts, "units": (UNITS, self.sites)}.items():
            if getattr(self, name) is not None:
                object.__setattr__(self, name, table(name, getattr(self, name), keys, count))
        object.__setattr__(self, "drive", tables("drive", self.drive, DRIVE))
        object.__setattr__(self, "_tables", text_of(self.beads, self.bonds, tuple(self.drive), self.units))
        if self._tables:
            _native.check_chain(self._numbers)

    @property
    def _given(self) -> dict[str, Any]:
        """The arguments that are not their defaults."""
        given = {one.name: (getattr(self, one.name), one.default) for one in fields(self) if one.init}
        own = {name for name, (value, default) in given.items() if isinstance(default, (float, str)) and value == default}
        own |= {name for name, (value, default) in given.items() if value is default}
        return {name: plain(value) for name, (value, _) in given.items() if name not in own}

    @property
    def _numbers(self) -> tuple[int, float, float, float, str, float, str, tuple[float, float]]:
        params = (self.alpha, self.kappa, self.rho)
        return (self.sites, *params, self.boundary, self.precompression, self._tables, (self.gravity, self.tilt))

    @cached_property
    def masses(self) -> tuple[Vector, Vector]:
        """Masses of the beads and of the resonators, shape (sites,) each, in kg with ``units``; 0
        where nothing moves. They are read-only."""
        beads, resonators = map(read_only, self._rest._scene.masses(True))
        return beads, resonators

    @property
    def omega(self) -> float:
        """Frequency of a bead of mass 1 against its resonator, ``sqrt(kappa (1 + 1/rho))``."""
        if self.rho == 0.0 or self.kappa == 0.0:
            return 0.0
        return math.sqrt(self.kappa * (1.0 + 1.0 / self.rho))

    @property
    def resonators(self) -> bool:
        """Whether at least one resonator moves."""
        if self._tables:
            return bool(self.masses[1].any())
        return self.kappa > 0.0 and 0.0 < self.rho < math.inf

    def _velocities(self, y0: Any) -> Arrays:
        """The arrays ``u, v, u', v'`` of a state."""
        known = names(self.boundary == STRAIN_RING)
        arrays = state_of(y0, known, self.sites, self.resonators)
        if self.boundary != STRAIN_RING:
            masses: tuple[Vector | float, Vector | float] = self.masses if self._tables else (1.0, self.rho)
            for name, mass in zip(("pu", "pv"), masses):
                if name in arrays and (name == "pu" or self.resonators):
                    arrays[name] = velocity(name, arrays[name], mass)
        u, v, u_dot, v_dot = (arrays.get(name) for name in known)
        return u, v, u_dot, v_dot

    @cached_property
    def _rest(self) -> Scene:
        """The scene of this chain at rest, whose drives have all the time that they need."""
        return Scene(_native.Scene.of_chain(self._numbers, (None, None, None, None), 1e80), self)

    def scene(self, y0: Any, until: float) -> Scene:
        """The scene in which this chain runs from a state up to a time.

        Parameters
        ----------
        y0 : mapping or array_like
            The state, as in :func:`run`.
        until : float
            End time.
        """
        return Scene(_native.Scene.of_chain(self._numbers, self._velocities(y0), number("until", until)), self)


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

    def __init__(self, native: _native.Scene, chain: Chain | None = None, part: tuple[Any, ...] | None = None) -> None:
        self._scene = native
        self._chain = chain
        self._part = part

    def __reduce__(self) -> tuple[Any, ...]:
        return _scene_of, (None if self._part else self.to_toml(), self.name, self._chain, self._part)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self.to_toml() == other.to_toml() and self._start == other._start

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def _repr_html_(self) -> str:
        return html_table("Scene", {"name": self.name, "end": self.end, **self.chain._given})

    @property
    def _start(self) -> float:
        return self._part[1] if self._part else 0.0

    def _from(self, y0: Any, t0: float, until: float) -> Scene:
        """The scene from a state at a time `t0` to another time: drives act as at these times."""
        span = (number("t0", t0), number("until", until))
        if not 0 <= span[0] < span[1]:
            raise ParameterError(f"t0 = {span[0]} is not valid: at least zero, and before until = {span[1]}")
        return self._later(*span, self.chain._velocities(y0))

    def _later(self, t0: float, until: float, state: Arrays) -> Scene:
        u, v, u_dot, v_dot = (None if array is None else array.copy() for array in state)
        part = (t0, until, (u, v, u_dot, v_dot))
        return Scene(self._scene.part(*part), self.chain, (self, *part))

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
        """The scene with another end time, in seconds with ``[units]``."""
        return Scene(self._scene.until(number("until", end)))

    def plan(self, events: bool = False) -> list[str]:
        """What a run computes and what it leaves out, in words."""
        return self._scene.plan(flag("events", events))

    @property
    def chain(self) -> Chain:
        """The chain, with numbers for each bead in place of rules, unless it is in SI units."""
        if self._chain is None:
            sections = {name: finite_or_inf(of) for name, of in json.loads(self._scene.sections).items() if of}
            given, tables = self._scene.chain, {**sections, **(self._scene.tables or {})}
            self._chain = Chain(*given[:6], **tables, gravity=given[6], tilt=given[7])
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
    def units(self) -> dict[str, float] | None:
        """Value of the unit of each quantity in SI units; None without a table ``[units]``.

        Keys: ``length_m, mass_kg, time_s, velocity_m_per_s, force_n, energy_j``.
        """
        return self._scene.units

    @property
    def period(self) -> float:
        """Time that counts as a period in ``steps_per_period``; in seconds with ``[units]``."""
        return self._scene.period

    @property
    def end(self) -> float:
        """End time, in seconds with ``[units]``; scenes begin at zero."""
        return self._scene.end

    @property
    def y0(self) -> dict[str, Vector]:
        """The initial state: ``u, v, pu, pv``, or ``x, y, vx, vy`` on a strain ring; in SI units with
        ``[units]``."""
        strains = self.chain.boundary == STRAIN_RING
        u, v, u_dot, v_dot = self._scene.initial()
        if not strains:
            beads, resonators = self._scene.masses(True)
            u_dot = None if u_dot is None else beads * u_dot
            v_dot = None if v_dot is None else resonators * v_dot
        return {name: array for name, array in zip(names(strains), (u, v, u_dot, v_dot)) if array is not None}

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, sites={self.sites}, end={self.end:g})"


def _scene_of(text: str | None, name: str, chain: Chain | None, part: tuple[Any, ...] | None) -> Scene:
    if part is not None:
        whole, *rest = part
        return Scene._later(whole, *rest)
    scene = Scene.from_toml(text or "", name=name)
    scene._chain = chain
    return scene


def finite_or_inf(value: Any) -> Any:
    """A value of JSON, in which ``null`` is infinity."""
    if isinstance(value, dict):
        return {key: finite_or_inf(one) for key, one in value.items()}
    if isinstance(value, list):
        return [finite_or_inf(one) for one in value]
    return math.inf if value is None else value


def names(strains: bool) -> tuple[str, str, str, str]:
    """The names of the four arrays of a state."""
    return ("x", "y", "vx", "vy") if strains else ("u", "v", "pu", "pv")


def changes_of(changes: Mapping[str, Any] | None) -> list[str]:
    """Changes to a scene as the program takes them: a text ``key=value`` each."""

    def value(of: Any) -> str:
        if isinstance(of, bool):
            return "true" if of else "false"
        if isinstance(of, str):
            return of
        if isinstance(of, (list, tuple, np.ndarray)):
            return "[" + ", ".join(value(one) for one in unmasked("change", of).tolist()) + "]"
        return repr(int(of)) if hasattr(of, "__index__") else repr(number("change", of))

    if changes is None:
        return []
    if not isinstance(changes, Mapping):
        raise ParameterError(f"changes = {changes!r} is not valid: a dictionary of keys and values")
    return [f"{key}={value(of)}" for key, of in changes.items()]


def state_of(y0: Any, known: tuple[str, ...], sites: int, resonators: bool) -> dict[str, Vector]:
    """The arrays of a state by their names."""
    if isinstance(y0, Mapping):
        unknown = [key for key in y0 if key not in known]
        if unknown:
            raise ParameterError(f"y0 with the key {unknown[0]!r} is not valid: keys are {', '.join(known)}")
        return {name: vector(name, y0[name], sites) for name in known if y0.get(name) is not None}
    parts = [name for k, name in enumerate(known) if resonators or k % 2 == 0]
    flat = vector("y0", y0, len(parts) * sites)
    return dict(zip(parts, np.split(flat, len(parts))))


def velocity(name: str, momenta: Vector, masses: Vector | float) -> Vector:
    """Velocities from momenta. Momenta must be zero where the mass is zero; so are velocities."""
    if isinstance(masses, float):
        return momenta if masses == 1.0 else momenta / masses
    lost = np.flatnonzero((masses == 0.0) & (momenta != 0.0))
    if lost.size:
        site = int(lost[0])
        raise ParameterError(f"{name} = {momenta[site]} of site {site} is not valid: 0, as nothing moves there")
    return np.divide(momenta, masses, out=np.zeros_like(momenta), where=masses > 0.0)
