"""Dark breathers as exact periodic orbits, with multipliers and branches."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from . import _native, studies
from ._arrays import Vector, file_at, number, optional, whole, word
from ._chain import STRAIN_RING, Chain, Scene
from ._driven import DrivenBranch, DrivenOrbit, continue_driven
from ._errors import ParameterError
from ._progress import Progress
from ._run import scene_of
from ._study import Study, known, written
from ._values import Value, copies, read_only

PARAMETERS = ("omega_b", "rho", "kappa", "alpha", "c_x")


@dataclass(frozen=True)
class DarkBreather:
    """A dark breather on a ring of strains; :meth:`solve` computes its orbit.

    Parameters
    ----------
    center : {"site", "bond"}
        What the profile is symmetric about.
    omega_b : float, optional
        Frequency, above ``omega = sqrt(kappa (1 + 1/rho))``; by default 1.025 of it.
    rho, kappa, alpha : float
        Parameters of the chain.
    sites : int
        Sites of the ring, an odd number.
    precompression : float
        Static overlap of the contacts; the mean of two strains of the first site, half a period
        apart, is minus this number.
    tol : float
        Tolerance of the flow in Newton's method.

    Examples
    --------
    >>> import hertzchain as hc
    >>> orbit = hc.DarkBreather("site", omega_b=2.05, sites=11).solve()
    >>> orbit.residual < 1e-12, orbit.x.shape, bool(abs(orbit.multipliers).max() > 1)
    (True, (11,), True)
    """

    center: str = "site"
    omega_b: float | None = None
    rho: float = 1 / 3
    sites: int = 41
    alpha: float = 1.5
    kappa: float = 1.0
    precompression: float = 0.0
    tol: float = 1e-13

    def __post_init__(self) -> None:
        word("center", self.center)
        object.__setattr__(self, "sites", whole("sites", self.sites))
        object.__setattr__(self, "omega_b", optional("omega_b", self.omega_b))
        for name in ("rho", "alpha", "kappa", "precompression", "tol"):
            object.__setattr__(self, name, number(name, getattr(self, name)))

    def solve(self) -> Orbit:
        """The orbit, by Newton's method from the profile of the DpS equations.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge.
        """
        return Orbit(self, studies.breather_dark(**asdict(self)))


class Orbit(Value):
    """A periodic orbit with its Floquet multipliers.

    Attributes
    ----------
    x, y : ndarray, shape (sites,)
        Strains of contacts and resonators at ``t = 0``, where all rates are zero.
    multipliers : complex ndarray, shape (4 sites,)
        The multipliers, the largest modulus first.
    krein : int ndarray, shape (4 sites,)
        Krein signatures of multipliers on the unit circle; 0 elsewhere.
    kinds : list of str
        Kind of each multiplier: trivial, linear, circle, real, negative, quartet.
    errors : ndarray, shape (4 sites,)
        Estimated errors of the moduli.
    quality : dict
        Measured errors of the multipliers.
    residual, period, omega_b, e_b : float
        Residual of Newton's method, period, frequency, error of periodicity.
    record : dict
        All that ``hertzchain breather dark --json`` prints.
    """

    def __init__(self, breather: DarkBreather, study: Study) -> None:
        self._study = study
        self.record: dict[str, Any] = study.record
        record = self.record
        self.breather = replace(breather, omega_b=record["omega_b"])
        self.x: Vector = np.array(record["x"], dtype=np.float64)
        self.y: Vector = np.array(record["y"], dtype=np.float64)
        rows = record["multipliers"]
        self.multipliers: NDArray[np.complex128] = np.array([complex(row["re"], row["im"]) for row in rows])
        self.krein = np.array([row["krein"] for row in rows], dtype=np.int64)
        self.kinds: list[str] = [row["kind"] for row in rows]
        self.errors: Vector = np.array([row["error"] for row in rows], dtype=np.float64)
        self.quality: dict[str, Any] = record["quality"]
        self.residual: float = record["residual"]
        self.period: float = record["period"]
        self.omega_b: float = record["omega_b"]
        self.e_b: float = record["e_b"]

    def __repr__(self) -> str:
        return f"Orbit(omega_b={self.omega_b:g}, sites={len(self.x)}, largest |lambda|={abs(self.multipliers).max():.9f})"

    @cached_property
    def modes(self) -> Vector:
        """A direction ``[x, y, x', y']`` for each multiplier, a row each.

        The real part of its eigenvector, with the largest entry 1; shape (4 sites, 4 sites).
        """
        return read_only(_native.modes(self._study.file("dark-breather.npz")))

    @property
    def y0(self) -> dict[str, Vector]:
        """The state at ``t = 0`` for :func:`run`, in arrays of its own."""
        return copies({"x": self.x, "y": self.y})

    @property
    def chain(self) -> Chain:
        """The ring of strains."""
        of = self.breather
        return Chain(of.sites, of.alpha, of.kappa, of.rho, STRAIN_RING)

    def scene(self, periods: float = 1.0) -> Scene:
        """The scene in which the ring runs from this state for a number of periods."""
        return self.chain.scene(self.y0, number("periods", periods) * self.period)

    def plot(self, ax: Any = None) -> Any:
        """The multipliers and the unit circle, by matplotlib."""
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        angle = np.linspace(0, 2 * np.pi, 400)
        ax.plot(np.cos(angle), np.sin(angle), color="0.7", linewidth=0.8)
        ax.plot(self.multipliers.real, self.multipliers.imag, ".")
        ax.set(xlabel="Re λ", ylabel="Im λ", aspect="equal")
        return ax


@dataclass(frozen=True)
class BranchPoint:
    """A point of a branch: its parameter, measures of the orbit, and the largest modulus."""

    parameter: float
    omega_b: float
    rho: float
    k_x: float
    k_y: float
    c_x: float
    c_y: float
    residual: float
    max_modulus: float
    symplectic_defect: float
    leading: tuple[complex, ...]


class Branch(Value):
    """A branch of dark breathers in one parameter.

    It can be iterated, indexed and sliced; its items are :class:`BranchPoint`.

    Attributes
    ----------
    parameter : str
        Name of the parameter that varies.
    end : str
        Why the branch ended.
    bifurcations : list of dict
        ``kind``, ``parameter``, and more, of each.
    gaps : list of float
        Parameters of orbits whose multipliers could not be computed.
    record : dict
        All that ``hertzchain breather continue --json`` prints.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self.record: dict[str, Any] = study.record
        self.parameter: str = self.record["parameter"]
        self.end: str = self.record["end"]
        self.bifurcations: list[dict[str, Any]] = self.record["bifurcations"]
        self.gaps: list[float] = self.record["gaps"]
        self._points = [_point(row) for row in self.record["points"]]

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Branch:
        """The branch in a file ``branch.npz`` of :meth:`save` or of the program.

        Multipliers and bifurcations are computed anew.
        """
        return Branch(Study(_native.load_branch(str(file_at("path", path)))))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``branch.npz``, whole or not at all."""
        written(path, self._study.file("branch.npz"))

    def y0(self, k: int) -> dict[str, Vector]:
        """The orbit of a point at ``t = 0``, where all rates are zero, for :func:`run`: ``x, y``."""
        with np.load(io.BytesIO(self._study.file("branch.npz"))) as file:
            return {name: file[name][k] for name in ("x", "y")}

    def __len__(self) -> int:
        return len(self._points)

    def __iter__(self) -> Iterator[BranchPoint]:
        return iter(self._points)

    @overload
    def __getitem__(self, k: int) -> BranchPoint: ...
    @overload
    def __getitem__(self, k: slice) -> list[BranchPoint]: ...
    def __getitem__(self, k: int | slice) -> BranchPoint | list[BranchPoint]:
        return self._points[k]

    def column(self, name: str) -> Vector:
        """A quantity of all points, such as ``"k_x"`` or ``"max_modulus"``, shape (points,)."""
        known("column", word("name", name), [field.name for field in fields(BranchPoint) if field.name != "leading"])
        return np.array([getattr(point, name) for point in self._points], dtype=np.float64)

    def __repr__(self) -> str:
        return f"Branch({self.parameter}, {len(self)} points, {len(self.bifurcations)} bifurcations, {self.end})"

    def plot(self, ax: Any = None, y: str = "k_x") -> Any:
        """A quantity of the points over the parameter, dashed where orbits are unstable."""
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        p, values = self.column("parameter"), self.column(y)
        unstable = self.column("max_modulus") > 1 + 1e-6
        for which, line, color, label in ((~unstable, "-", "C0", "stable"), (unstable, "--", "C3", "unstable")):
            if which.any():
                ax.plot(p, np.where(which, values, np.nan), line, color=color, label=label)
        for one in self.bifurcations:
            ax.axvline(one["parameter"], color="0.8", linewidth=0.8)
        ax.set(xlabel=self.parameter, ylabel=y)
        ax.legend()
        return ax


def _point(row: dict[str, Any]) -> BranchPoint:
    leading = tuple(complex(one["re"], one["im"]) for one in row["leading"])
    known: dict[str, Any] = {field.name: row.get(field.name) for field in fields(BranchPoint)}
    return BranchPoint(**{**known, "leading": leading})


@overload
def continue_branch(
    orbit: Orbit | DarkBreather,
    vary: str = "omega_b",
    *,
    to: float,
    step: float | None = None,
    max_points: int | None = None,
    weak: float = 0.01,
    progress: Progress = False,
) -> Branch: ...
@overload
def continue_branch(
    orbit: DrivenOrbit,
    vary: str,
    *,
    to: float,
    step: float | None = None,
    max_points: int | None = None,
    switch: int | None = None,
    dimensionless: bool | None = None,
    progress: Progress = False,
) -> DrivenBranch: ...
def continue_branch(
    orbit: Orbit | DarkBreather | DrivenOrbit,
    vary: str = "omega_b",
    *,
    to: float,
    step: float | None = None,
    max_points: int | None = None,
    weak: float = 0.01,
    switch: int | None = None,
    dimensionless: bool | None = None,
    progress: Progress = False,
) -> Branch | DrivenBranch:
    """Follow a branch from an orbit.

    Parameters
    ----------
    orbit : Orbit, DarkBreather or DrivenOrbit
        Orbit at which the branch begins.
    vary : str
        The parameter that varies: ``"omega_b", "rho", "kappa", "alpha"`` or ``"c_x"`` of a dark
        breather;
        ``"amplitude", "omega"`` or ``"damping"`` (a factor, 1 at the start) of a driven orbit.
    to : float
        Value of the parameter at which the branch ends.
    step : float, optional
        Largest change of the parameter from point to point; by default a hundredth of the range,
        for driven orbits a twentieth.
    max_points : int, optional
        Largest number of points; by default 1000.
    weak : float
        Collisions of multipliers after which moduli stay below ``1 + weak`` are not located. For
        dark breathers only.
    switch : int, optional
        Number of a bifurcation, counted from 1. The branch that crosses there is followed too; it
        is ``switched`` of the result. For driven orbits only.
    dimensionless : bool, optional
        Whether the numbers of the branch are dimensionless also for a scene with ``[units]``; by
        default as those of the orbit. `to` and `step` are in SI units in any case. For driven
        orbits only.
    progress : bool or callable
        As in :func:`run`.

    Examples
    --------
    >>> import hertzchain as hc, numpy as np
    >>> branch = hc.continue_branch(hc.DarkBreather("bond", 2.02, sites=11), to=2.04, step=0.01)
    >>> branch.end, bool((branch.column("k_x")[1:] > branch.column("k_x")[:-1]).all())
    ('reached', True)

    A driven orbit in SI units: the first bead is moved by 10 nm at first, and by 12 nm at the end.

    >>> orbit = hc.driven_orbit(hc.Scene.load("granular-crystal"))
    >>> driven = hc.continue_branch(orbit, "amplitude", to=12e-9)
    >>> driven.end, bool(np.allclose(driven.values[[0, -1]], [10e-9, 12e-9], rtol=1e-15, atol=0))
    ('reached', True)
    """
    if isinstance(orbit, DrivenOrbit):
        if weak != 0.01:
            raise ParameterError("weak is not valid: it is for dark breathers")
        return continue_driven(orbit, vary, to, step, max_points, switch, dimensionless, progress)
    for name, value in (("switch", switch), ("dimensionless", dimensionless)):
        if value is not None:
            raise ParameterError(f"{name} is not valid: it is for driven orbits")
    breather = orbit.breather if isinstance(orbit, Orbit) else orbit
    if not isinstance(breather, DarkBreather):
        raise ParameterError(f"orbit = {orbit!r} is not valid: an Orbit, a DarkBreather or a DrivenOrbit")
    if word("vary", vary) not in PARAMETERS:
        raise ParameterError(f"vary = {vary!r} is not valid: one of {', '.join(PARAMETERS)}")
    start = getattr(breather, vary)
    if start is None:
        raise ParameterError("omega_b = None is not valid: a branch in omega_b needs its first value")
    options = {**asdict(breather), "omega_b": None if vary == "omega_b" else breather.omega_b}
    return Branch(
        studies.breather_continue(
            **options,
            vary=vary,
            from_=start,
            to=number("to", to),
            step=optional("step", step),
            max_points=whole("max_points", 1000 if max_points is None else max_points),
            bifurcations=True,
            weak=number("weak", weak),
            progress=progress,
        )
    )


def monodromy(scene: Scene | Chain, *, y0: Any = None, until: float | None = None, tol: float = 1e-10) -> Vector:
    """The tangent map: the derivative of the state at the end by the state at the start.

    Parameters
    ----------
    scene, y0, until
        As in :func:`run`.
    tol : float
        Tolerance of the run.

    Returns
    -------
    ndarray, shape (dim, dim)
        For states ``[u, v, u', v']`` (``[u, u']`` without moving resonators), in SI units with
        ``[units]``. Rows and columns of
        beads that drives move are zero.

    Raises
    ------
    ParameterError
        For contacts that dissipate (`driven_orbit` has their multipliers), or a chain of more than
        256 bonds.

    Examples
    --------
    Without contact, the tangent map of beads in flight is ``[[1, t], [0, 1]]``.

    >>> import hertzchain as hc, numpy as np
    >>> chain = hc.Chain(sites=2)
    >>> map = hc.monodromy(chain, y0={"u": [0, 1], "pu": [0, 1]}, until=3.0)
    >>> bool(np.abs(map - np.kron([[1, 3], [0, 1]], np.eye(2))).max() < 1e-14)
    True
    """
    native = scene_of(scene, y0, until)._scene
    tangent = _native.monodromy(native, number("tol", tol))
    second, half = (native.units or {}).get("time_s", 1.0), len(tangent) // 2
    # Velocities by displacements are per second, displacements by velocities in seconds.
    tangent[half:, :half] /= second
    tangent[:half, half:] *= second
    return tangent
