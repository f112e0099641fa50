"""Periodic orbits of driven chains under the stroboscopic map, with multipliers and branches."""

from __future__ import annotations

import io
import json
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import studies
from ._arrays import Vector, number, optional, whole, word
from ._chain import Chain, Scene
from ._errors import ParameterError
from ._progress import Progress
from ._run import scene_of
from ._study import Study, written
from ._values import Value, copies


class DrivenOrbit(Value):
    """A periodic orbit of a driven chain with its Floquet multipliers; :func:`driven_orbit` finds it.

    Attributes
    ----------
    y0 : dict of ndarray
        Displacements and momenta ``u, v, pu, pv`` at ``t = 0``, for :func:`run`; for a drive with a
        ramp, those under the drive at its full height. Always in the units of the scene, as
        :func:`run` takes them.
    period, response, residual : float
        Period of the orbit (s, if in SI units); largest half range of a bead that no drive moves
        (m); residual of Newton's method.
    bead_ranges, strain_ranges : ndarray, shape (sites,), (sites - 1,)
        Half ranges of displacements and of strains between neighbours (m).
    multipliers : complex ndarray
        The multipliers, the largest modulus first.
    stable : bool
        Whether no multiplier is outside the unit circle.
    driven, dissipated : float
        Work of the drives, and dissipated energy, over the orbit (J).
    si : bool
        Whether the numbers are in SI units; otherwise all are dimensionless.
    record : dict
        All that ``hertzchain orbit driven --json`` prints, with ``--dimensionless`` if it is so.
    """

    def __init__(
        self, scene: Scene, turns: int, settle: int, record: dict[str, Any], dimensionless: bool = False
    ) -> None:
        self.scene = scene
        self.record = record
        self._dimensionless = dimensionless
        self._search = (turns, settle)
        self.si: bool = record.get("si", False)
        masses, (length, velocity) = scene._scene.masses(True), scene_units(record, scene)
        start: dict[str, Vector] = {}
        for name, mass in zip("uv", masses):
            if record[name]:
                start[name] = np.array(record[name], dtype=np.float64) * length
                start[f"p{name}"] = mass * (np.array(record[f"{name}_dot"], dtype=np.float64) * velocity)
        self._start = start
        self.period: float = record["drive"]["period"]
        self.response: float = record["response"]
        self.residual: float = record["residual"]
        self.bead_ranges: Vector = np.array(record["bead_ranges"], dtype=np.float64)
        self.strain_ranges: Vector = np.array(record["strain_ranges"], dtype=np.float64)
        self.multipliers: NDArray[np.complex128] = np.array([complex(one["re"], one["im"]) for one in record["multipliers"]])
        self.stable: bool = record["unstable"] == 0
        self.driven: float = record["driven"]
        self.dissipated: float = record["dissipated"]

    @property
    def y0(self) -> dict[str, Vector]:
        """The state at ``t = 0``, in arrays of its own."""
        return copies(self._start)

    def __repr__(self) -> str:
        what = "stable" if self.stable else "unstable"
        return f"DrivenOrbit(period={self.period:g}, response={self.response:g}, {what})"


def scene_units(record: dict[str, Any], scene: Scene) -> tuple[float, float]:
    """The units of length and velocity of a record in those of its scene: 1 if they are the same."""
    units = {} if record.get("si") else scene.units or {}
    return units.get("length_m", 1.0), units.get("velocity_m_per_s", 1.0)


class DrivenBranch(Value):
    """A branch of driven orbits in one parameter.

    Attributes
    ----------
    parameter : {"amplitude", "omega", "damping"}
        The parameter that varies.
    values, response, max_modulus : ndarray, shape (points,)
        The parameter (in SI units m for the amplitude of a bead that is moved, N for that of a
        force, rad/s for ``omega``), the largest half range of a bead that no drive moves (m), and
        the largest modulus of a multiplier.
    stable : bool ndarray, shape (points,)
        Whether no multiplier is outside the unit circle.
    bifurcations : list of dict
        ``kind`` (fold, plus-one, period-doubling, torus), ``parameter``, ``response``,
        ``multiplier`` of each, in the units of `values` and `response`.
    end : str
        Why the branch ended.
    switched : DrivenBranch or None
        The branch that crosses at the bifurcation that was asked for; ``None``, with a warning that
        says why, if none was followed.
    si : bool
        Whether the numbers are in SI units; otherwise all are dimensionless.
    record : dict
        All that ``hertzchain orbit continue --json`` prints, with ``--dimensionless`` if it is so.
    """

    def __init__(self, record: dict[str, Any], study: Study | None = None) -> None:
        self.record = record
        self._study = study
        self.si: bool = record.get("si", False)
        other = crossing(record)
        self.switched: DrivenBranch | None = None if other is None else DrivenBranch(other)
        points = self.record["points"]
        self.parameter: str = self.record["parameter"]
        self.end: str = self.record["end"]
        self.bifurcations: list[dict[str, Any]] = self.record["bifurcations"]
        self.values: Vector = np.array([point[self.parameter] for point in points], dtype=np.float64)
        self.response: Vector = np.array([point["response"] for point in points], dtype=np.float64)
        self.max_modulus: Vector = np.array([point["max_modulus"] for point in points], dtype=np.float64)
        self.stable: NDArray[np.bool_] = np.array([point["unstable"] == 0 for point in points])

    @staticmethod
    def load(path: str | os.PathLike[str], dimensionless: bool = False) -> DrivenBranch:
        """The branch in a file ``driven-branch.npz`` of :meth:`save` or of the program.

        Multipliers and bifurcations are computed anew.
        """
        done = studies.orbit_continue(resume=path, bifurcations=True, dimensionless=dimensionless)
        return DrivenBranch(done.record, done)

    def _file(self) -> bytes:
        if self._study is None:
            raise ParameterError("a branch that was switched to has no file: only the branch it crosses has one")
        return self._study.file("driven-branch.npz")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write ``driven-branch.npz``, whole or not at all."""
        written(path, self._file())

    def y0(self, k: int) -> dict[str, Vector]:
        """The orbit of a point at ``t = 0``, as ``y0`` of a :class:`DrivenOrbit`; the drive or the
        damping must have the value of this point."""
        with np.load(io.BytesIO(self._file())) as file:
            scene = json.loads(file["settings.json"].item())["setting"]["scene"]
            units = Scene.from_toml(scene).units or {}
            length = units.get("length_m", 1.0)
            momentum = units.get("mass_kg", 1.0) * units.get("velocity_m_per_s", 1.0)
            known = [name for name in ("u", "v", "pu", "pv") if name in file.files]
            return {name: file[name][k] * (momentum if name[0] == "p" else length) for name in known}

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        return f"DrivenBranch({self.parameter}, {len(self)} points, {len(self.bifurcations)} bifurcations, {self.end})"

    def plot(self, ax: Any = None, color: str = "C0", label: str | None = None) -> Any:
        """The response over the parameter, dotted where orbits are unstable, with bifurcations."""
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        stretches(ax, self.values, self.response, self.stable, color, label)
        for kind, marker in (("fold", "v"), ("period-doubling", "s"), ("torus", "o"), ("plus-one", "x")):
            here = [(one["parameter"], one["response"]) for one in self.bifurcations if one["kind"] == kind]
            if here:
                ax.plot(*zip(*here), marker, color=color, markersize=5)
        ax.set(
            xlabel=f"{self.parameter} (SI unit)" if self.si and self.parameter != "damping" else self.parameter,
            ylabel="largest half range of a bead" + (" (m)" if self.si else ""),
        )
        return ax


def stretches(ax: Any, x: Vector, y: Vector, stable: NDArray[np.bool_], color: str, label: str | None) -> None:
    """Draw a branch, dotted where it is unstable."""
    for which, line, name in ((stable, "-", label), (~stable, ":", None)):
        # Dotted stretches reach to the stable points beside them, so that the curve has no gaps.
        near = which | np.append(which[1:], False) | np.insert(which[:-1], 0, False) if line == ":" else which
        ax.plot(x, np.where(near, y, np.nan), line, color=color, label=name)


def driven_orbit(
    scene: Scene | Chain,
    *,
    y0: Any = None,
    turns: int = 1,
    settle: int = 300,
    dimensionless: bool = False,
    progress: Progress = False,
) -> DrivenOrbit:
    """The periodic orbit to which a driven chain settles.

    The chain runs for some periods. From the state that it has then, Newton's method solves for a
    fixed point of the stroboscopic map.

    Parameters
    ----------
    scene : Scene or Chain
        With a drive: harmonics that are multiples of one frequency, with or without a ramp.
    y0
        As in :func:`run`; for a chain, rest by default.
    turns : int
        Periods of the drive in a period of the orbit, from 1 to 64.
    settle : int
        Periods of the orbit for which the chain runs before the search; fewer if its motion
        becomes periodic earlier.
    dimensionless : bool
        Whether the numbers of the orbit are dimensionless also for a scene or chain with
        ``[units]``; `y0` is in SI units in any case.
    progress : bool or callable
        As in :func:`run`.

    Raises
    ------
    ConvergenceError
        If Newton's method does not converge.
    ParameterError
        For a scene without a periodic drive.

    Examples
    --------
    A bead on its spring alone: the amplitude of a linear oscillator, ``1/|1 - w^2 + i c w|``.

    >>> import hertzchain as hc
    >>> push = {"site": 0, "kind": "pushed", "amplitude": 1.0, "omega": 1.3}
    >>> chain = hc.Chain(sites=1, kappa=1.0, rho=float("inf"), beads={"drag": 0.2}, drive=[push])
    >>> orbit = hc.driven_orbit(chain)
    >>> bool(abs(orbit.response * abs(1 - 1.3**2 + 0.26j) - 1) < 1e-12), orbit.stable
    (True, True)

    Of a scene in SI units the period is in seconds, and ``frequency`` in hertz.

    >>> orbit = hc.driven_orbit(hc.Scene.load("granular-crystal"))
    >>> bool(abs(orbit.period * orbit.record["drive"]["frequency"] - 1) < 1e-15)
    True
    >>> bool(abs(orbit.record["drive"]["omega"] / 3e4 - 1) < 1e-15)
    True
    """
    if isinstance(scene, Chain):
        # A scene needs an end time; the orbit has its own period.
        scene = scene_of(scene, {} if y0 is None else y0, 1.0)
    else:
        scene = scene_of(scene, y0, None)
    turns, settle = whole("turns", turns), whole("settle", settle)
    done = studies.orbit_driven(scene, turns=turns, settle=settle, dimensionless=dimensionless, progress=progress)
    return DrivenOrbit(scene, turns, settle, done.record, dimensionless)


def crossing(record: dict[str, Any]) -> dict[str, Any] | None:
    """The record of the branch that crosses, if there is one."""
    other = record.get("switched")
    if other is None or "failure" in other:
        return None
    return {**{name: value for name, value in record.items() if name != "switched"}, **other}


def continue_driven(
    orbit: DrivenOrbit,
    vary: str,
    to: float,
    step: float | None,
    max_points: int | None,
    switch: int | None,
    dimensionless: bool | None,
    progress: Progress,
) -> DrivenBranch:
    """The branch of a driven orbit; :func:`continue_branch` describes the parameters."""
    turns, settle = orbit._search
    done = studies.orbit_continue(
        orbit.scene,
        turns=turns,
        settle=settle,
        vary=word("vary", vary),  # type: ignore[arg-type]
        to=number("to", to),
        step=optional("step", step),
        max_points=whole("max_points", 1000 if max_points is None else max_points),
        bifurcations=True,
        switch=None if switch is None else whole("switch", switch),
        dimensionless=orbit._dimensionless if dimensionless is None else dimensionless,
        progress=progress,
    )
    return DrivenBranch(done.record, done)
