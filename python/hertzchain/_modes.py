"""Nonlinear normal modes of conservative chains that contacts hold."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import studies
from ._arrays import Vector, number, optional, whole
from ._chain import Chain, Scene
from ._driven import crossing, scene_units, stretches
from ._progress import Progress
from ._run import scene_of
from ._values import Value, copies


class NormalMode(Value):
    """A branch of periodic orbits that begins as a linear mode; :func:`normal_mode` follows it.

    Attributes
    ----------
    linear : structured ndarray, shape (modes,)
        The linear modes in order of frequency: ``omega`` (rad/s, if in SI units),
        ``participation``, and the ``site`` with the largest share in the mode; ``resonator`` is
        true if that is the share of a resonator.
    mode : int
        Number of the linear mode that is followed, counted from 1.
    amplitude, omega, energy, participation, least_overlap, max_modulus : ndarray, shape (points,)
        Amplitude (m); frequency (rad/s); energy above the equilibrium (J); participation number,
        which counts the coordinates that share the orbit; least overlap at the two times of rest
        (m), negative where beads are apart; largest modulus of a multiplier.
    stable : bool ndarray, shape (points,)
        Whether no multiplier is outside the unit circle.
    bifurcations : list of dict
        ``kind``, ``amplitude`` and ``omega`` of each that was located.
    y0 : dict of ndarray
        The last orbit of the branch when it is at rest, ``u`` and ``v``, for :func:`run`. Always
        in the units of the scene, as :func:`run` takes them.
    period : float
        Period of the last orbit (s).
    multipliers : complex ndarray
        Multipliers of the last orbit.
    end : str
        Why the branch ended.
    switched : NormalMode or None
        The branch that crosses at the bifurcation that was asked for; ``None``, with a warning that
        says why, if none was followed.
    si : bool
        Whether the numbers are in SI units; otherwise all are dimensionless.
    record : dict
        All that ``hertzchain orbit mode --json`` prints, with ``--dimensionless`` if it is so.
    """

    def __init__(self, record: dict[str, Any], scene: Scene) -> None:
        self.record = record
        self.si: bool = record.get("si", False)
        # What belongs to the chain is said once.
        other = crossing(record)
        self.switched: NormalMode | None = None if other is None else NormalMode(other, scene)
        points, last = self.record["points"], self.record["last"]
        kinds = [("omega", np.float64), ("participation", np.float64), ("site", np.int64), ("resonator", np.bool_)]
        rows = [tuple(one[name] for name, _ in kinds) for one in self.record["linear"]]
        self.linear: NDArray[Any] = np.array(rows, dtype=kinds)
        self.mode: int = self.record["mode"]
        self.end: str = self.record["end"]

        def column(name: str) -> Vector:
            return np.array([point[name] for point in points], dtype=np.float64)

        self.amplitude, self.omega, self.energy = column("amplitude"), column("omega"), column("energy")
        self.participation, self.least_overlap = column("participation"), column("least_overlap")
        self.max_modulus = column("max_modulus")
        self.stable: NDArray[np.bool_] = np.array([point["unstable"] == 0 for point in points])
        self.bifurcations: list[dict[str, Any]] = self.record["bifurcations"]
        (length, _), start = scene_units(record, scene), last["start"].items()
        self._start: dict[str, Vector] = {name: np.array(array, dtype=np.float64) * length for name, array in start if array}
        self.period = float(2.0 * np.pi / self.omega[-1])
        multipliers = [complex(one["re"], one["im"]) for one in last["multipliers"]]
        self.multipliers: NDArray[np.complex128] = np.array(multipliers)

    @property
    def y0(self) -> dict[str, Vector]:
        """The last orbit when it is at rest, in arrays of its own."""
        return copies(self._start)

    def __len__(self) -> int:
        return len(self.amplitude)

    def __repr__(self) -> str:
        first = self.linear["omega"][self.mode - 1]
        return f"NormalMode({self.mode}, omega_0={first:g}, {len(self)} points, {self.end})"

    def plot(self, ax: Any = None, color: str = "C0", label: str | None = None) -> Any:
        """The frequency over the amplitude, dotted where orbits are unstable, with bifurcations, by matplotlib."""
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        stretches(ax, self.amplitude, self.omega, self.stable, color, label)
        here = [(one["amplitude"], one["omega"]) for one in self.bifurcations]
        if here:
            ax.plot(*zip(*here), "x", color=color, markersize=5)
        ax.set(xlabel="amplitude a" + (" (m)" if self.si else ""), ylabel="frequency" + (" (rad/s)" if self.si else ""))
        return ax


def normal_mode(
    scene: Scene | Chain,
    *,
    to: float,
    mode: int | None = None,
    step: float | None = None,
    max_points: int | None = None,
    switch: int | None = None,
    dimensionless: bool = False,
    progress: Progress = False,
) -> NormalMode:
    """Follow a nonlinear normal mode of a conservative chain, starting from the linear mode.

    Parameters
    ----------
    scene : Scene or Chain
        Its contacts must be closed at rest: a static overlap, between walls or on a ring. The
        initial state of a scene does not matter.
    to : float
        The amplitude at which the branch ends. The amplitude is the initial displacement of the
        bead or resonator with the largest share in the linear mode.
    mode : int, optional
        Number of the linear mode in order of frequency, counted from 1; by default that of the most
        localised mode.
    step : float, optional
        First amplitude, and its largest change from point to point; by default a twentieth of `to`.
    max_points : int
        Largest number of points of the branch; by default 1000.
    switch : int, optional
        Number of a bifurcation, counted from 1. The branch that crosses there is followed too; it
        is ``switched`` of the result.
    dimensionless : bool
        Whether the numbers of the result are dimensionless also for a scene or chain with
        ``[units]``; `to` and `step` are in m in any case, and so is `y0`.
    progress : bool or callable
        As in :func:`run`.

    Raises
    ------
    ParameterError
        For a chain that dissipates or is driven, or in which contacts do not hold every bead.
    ConvergenceError
        If no first orbit is found.

    Examples
    --------
    A bead between two walls with the overlap 1 has ``omega^2 = 2 alpha`` for small amplitudes.

    >>> import hertzchain as hc, numpy as np
    >>> mode = hc.normal_mode(hc.Chain(sites=1, boundary="fixed", precompression=1.0), to=0.1)
    >>> bool(abs(mode.linear["omega"][0] - 3**0.5) < 1e-14), bool(mode.omega[-1] < mode.omega[0])
    (True, True)

    Two steel spheres under 20 N, in SI units: moving in phase, they have the stiffness of one wall.

    >>> steel = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3, "static_load": 20.0}
    >>> mode = hc.normal_mode(hc.Chain(sites=2, boundary="fixed", units=steel), to=1e-9, mode=1)
    >>> mass, modulus = 4 / 3 * np.pi * 9.525e-3**3 * 8027.0, 193e9 / (1 - 0.3**2) / 2
    >>> wall = 4 / 3 * modulus * 9.525e-3**0.5
    >>> bool(abs(mode.linear["omega"][0] / np.sqrt(1.5 * wall ** (2 / 3) * 20 ** (1 / 3) / mass) - 1) < 1e-13)
    True
    """
    if isinstance(scene, Chain):
        scene = scene_of(scene, {}, 1.0)
    elif not isinstance(scene, Scene):
        scene = scene_of(scene, None, None)
    done = studies.orbit_mode(
        scene,
        linear_mode=None if mode is None else whole("mode", mode),
        to=number("to", to),
        step=optional("step", step),
        max_points=whole("max_points", 1000 if max_points is None else max_points),
        bifurcations=True,
        switch=None if switch is None else whole("switch", switch),
        dimensionless=dimensionless,
        progress=progress,
    )
    return NormalMode(done.record, scene)
