"""Runs and their results."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypedDict, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import Vector, flag, number, optional, several, texts, unmasked, vector, word
from ._chain import STRAIN_RING, Chain, Scene, names
from ._errors import ParameterError, RunWarning
from ._progress import Progress, shown
from ._values import Value, copies, read_only

if TYPE_CHECKING:
    from typing_extensions import Unpack

T = TypeVar("T")
ENERGIES = np.dtype([(name, np.float64) for name in ("beads", "resonators", "springs", "contacts")])
CONTACTS = np.dtype([(name, np.int64 if name == "bond" else np.float64) for name in _native.CONTACT_COLUMNS])
CROSSINGS = np.dtype([("condition", np.int64), ("t", np.float64), ("rising", np.bool_)])
DEFAULT_SAMPLES = 400
# The first bond of a chain that can touch, where there is no wall on the left.
FIRST = {"free": 1, "right-wall": 1}


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `partial` is what the run, or :func:`run_many`, had recorded.

    Attributes
    ----------
    partial : Trajectory or Ensemble
    """

    def __init__(self, partial: Trajectory | Ensemble) -> None:
        super().__init__(f"stopped at t = {partial.t_end:g}")
        self.partial = partial


class StateArray(Generic[T]):
    """An array of states, which its owner has by its name."""

    def __init__(self, about: str) -> None:
        self.__doc__ = about

    def __set_name__(self, _: type, name: str) -> None:
        self.name = name

    def __get__(self, owner: Any, _: Any = None) -> T:
        return self if owner is None else owner._array(self.name)  # type: ignore[return-value]


class Arrays(Value):
    """The arrays of states by their names."""

    u = StateArray[Vector]("Displacements of beads.")
    v = StateArray[Vector | None]("Displacements of resonators; None if none moves.")
    pu = StateArray[Vector]("Momenta of beads.")
    pv = StateArray[Vector | None]("Momenta of resonators; None if none moves.")
    x = StateArray[Vector]("Strains of beads on a strain ring.")
    y = StateArray[Vector | None]("Strains of resonators on a strain ring; None if none moves.")
    vx = StateArray[Vector]("Rates of `x`.")
    vy = StateArray[Vector | None]("Rates of `y`; None if no resonator moves.")


class Told(TypedDict, total=False):
    """Options of a part of a run, as in :func:`run`."""

    states: bool
    events: bool
    crossings: str | Sequence[str]
    stop: str | Sequence[str]
    progress: Progress
    on_sample: Callable[[float, Vector], Any] | None
    on_contact: Callable[[dict[str, float]], Any] | None
    on_crossing: Callable[[dict[str, float], Vector], Any] | None


class Trajectory(Arrays):
    """The record of a run, in SI units for a scene or chain with ``[units]``: metres, seconds,
    joules, momenta in kg m/s.

    Attributes
    ----------
    t : ndarray, shape (times,)
        Sample times.
    u, v, pu, pv : ndarray, shape (times, sites), or None
        Displacements of beads and resonators, and their momenta, mass times rate; for equal beads
        ``pu = u'``, ``pv = rho v'``. ``v`` and ``pv`` are None if no resonator moves. On a strain
        ring these are ``x, y, vx, vy``: strains and their rates. They are kept with ``states=True``.
    energy : ndarray, shape (times,), or None
        Energy at the sample times; None on a strain ring whose state has no energy.
    energies : structured ndarray or None
        The energy by kind: ``beads``, ``resonators``, ``springs``, ``contacts``.
    contacts : structured ndarray
        The log of contacts of a run with ``events=True``: ``bond``, ``onset``, ``release``, and so
        on. NaN stands for a number that a contact does not have, such as the release of an open
        one. On every boundary ``bond`` counts the bonds that can touch from 0, from left to right,
        as the columns of :meth:`strains` and the arrays and exceptions of ``Chain(bonds=..)`` do.
    conditions : list of str
        What was looked for: those of `crossings`, then those of `stop`.
    crossings : structured ndarray
        Where these were met, in order of time: ``condition``, the number of one in `conditions`;
        ``t``; ``rising``, whether the quantity rises. A call with ``crossings["t"]`` has the states.
    ended_by : str or None
        The condition at which the run ended before `until`; None if an exception ended it.
    derivatives : dict
        By the names of `derivatives` of :func:`run`: the derivative of `end`, a dictionary of arrays.
    stats : dict
        ``steps``, ``rejected``, ``force_evaluations``, ``wall_s``.
    energy_error : float or None
        Largest sampled ``|E(t) - E(0)| / |E(0)|``; of chains that dissipate or are driven, that of
        the balance energy + dissipated - driven, relative to the largest of the three.
    dissipated : dict or None
        Energy dissipated up to the end by ``drag``, ``dashpots`` and ``contacts``, and ``total``,
        for a chain that dissipates or is driven.
    driven : float or None
        Work of the drives up to the end, for such a chain.
    warnings : list of str
        What makes the result doubtful, such as an energy error that the tolerance does not explain.
    failure : str or None
        Why the run stopped before its end, if it did.
    t_end : float
        Time reached.
    end : dict
        State at this time; it can be the ``y0`` of another run, unless it is dimensionless while
        the scene is in SI units.
    integrator, setting, reason : str
        The method, its accuracy, and why it was chosen if nobody named one.
    units : dict or None
        Value of the unit of each quantity in SI units, for a scene or chain with ``[units]``.
    si : bool
        Whether the numbers are in SI units; otherwise all are dimensionless.
    """

    _left_out = frozenset({"stats", "_how"})

    def __init__(self, chain: Chain, record: dict[str, Any], scene: Scene, si: bool, how: dict[str, Any]) -> None:
        self.chain = chain
        self.si = si
        self._scene, self._how = scene, how
        strains = chain.boundary == STRAIN_RING
        self._names = names(strains)
        self.t: Vector = record["t"]
        self._has_states = "states" in record
        states = self._momenta(record.get("states", []))
        self._states: dict[str, Vector | None] = {name: states.get(name) for name in self._names}
        self._energies: Vector | None = record.get("energies")
        self._contacts: Vector | None = record.get("contacts")
        self.conditions: list[str] = record.get("conditions", [])
        self.crossings = np.array(record["crossings"], CROSSINGS)
        ended = record["ended_by"]
        self.ended_by = None if ended is None else self.conditions[ended]
        self.stats = {name: record[name] for name in ("steps", "rejected", "force_evaluations", "wall_s")}
        self.energy_error: float | None = record["energy_error"]
        work = record.get("dissipated")
        self.dissipated = None if work is None else dict(zip(("drag", "dashpots", "contacts", "total"), work))
        self.driven: float | None = record.get("driven")
        self.warnings: list[str] = record["warnings"]
        self.failure: str | None = record["failure"]
        self.t_end: float = record["t_end"]
        self._end: dict[str, Vector] = {name: array[0] for name, array in self._momenta(record["end"]).items()}
        self.derivatives: dict[str, dict[str, Vector]] = record.get("derivatives", {})
        self.integrator: str = record["integrator"]
        self.setting: str = record["setting"]
        self.reason: str | None = record["reason"]

    def _momenta(self, arrays: list[Vector]) -> dict[str, Vector]:
        """The arrays of states by their names, with momenta in place of velocities."""
        of = dict(zip(self._names if len(arrays) == 4 else self._names[::2], arrays))
        for name, mass in zip(("pu", "pv"), self._scene._scene.masses(self.si)):
            if name in of:
                of[name] *= mass
        return of

    @property
    def end(self) -> dict[str, Vector]:
        """The state at the end, in arrays of its own."""
        return copies(self._end)

    @property
    def units(self) -> dict[str, float] | None:
        """Value of the unit of each quantity in SI units."""
        return self._scene.units

    @property
    def energy(self) -> Vector | None:
        """Energy at the sample times."""
        return None if self._energies is None else np.asarray(self._energies.sum(axis=1))

    @property
    def energies(self) -> NDArray[Any] | None:
        """Energy at the sample times by kind."""
        return None if self._energies is None else self._energies.view(ENERGIES)[:, 0]

    @cached_property
    def contacts(self) -> NDArray[Any]:
        """The log of contacts."""
        if self._contacts is None:
            raise AttributeError("no contacts were logged: call run(..., events=True)")
        table = np.zeros(len(self._contacts), CONTACTS)
        for k, name in enumerate(_native.CONTACT_COLUMNS):
            table[name] = self._contacts[:, k]
        table["bond"] -= FIRST.get(self.chain.boundary, 0)
        return read_only(table)

    def _array(self, name: str) -> Any:
        if name not in self._names:
            raise AttributeError(f"{name!r} is not of this chain: its arrays are {', '.join(self._names)}")
        if not self._has_states:
            raise AttributeError(f"no states were kept: call run(..., states=True) for {name!r}")
        return self._states[name]

    def _in_scene(self, state: dict[str, Vector]) -> dict[str, Vector]:
        """A state in the units of the scene, from those of this trajectory."""
        if self.units is None or self.si:
            return state
        length, momentum = self.units["length_m"], self.units["mass_kg"] * self.units["velocity_m_per_s"]
        return {name: array * (momentum if name[0] == "p" else length) for name, array in state.items()}

    @property
    def _second(self) -> float:
        """The unit of times of this trajectory in that of its scene."""
        return 1.0 if self.units is None or self.si else self.units["time_s"]

    def resume(self, until: float, *, at: ArrayLike | int | None = None, **options: Unpack[Told]) -> Trajectory:
        """Go on from the end up to a later time, in the same way; drives go on at their phase.

        Parameters
        ----------
        until : float
            End time, in the unit of ``t_end``.
        at, states, events, crossings, stop, progress, on_sample, on_contact, on_crossing
            As in :func:`run`.

        Returns
        -------
        Trajectory
            From ``t_end`` on. Its energy error and its works are counted from there, and a
            tolerance holds for this part.
        """
        return self._again(self._end, self.t_end, number("until", until) * self._second, self._times(at), **options)

    def _times(self, at: Any) -> Any:
        """Samples of a part of the run, in the unit of its scene."""
        if at is None or isinstance(at, (int, np.integer)):
            return DEFAULT_SAMPLES if at is None else at
        return vector("at", at) * self._second

    def _again(self, y: dict[str, Vector], t: float, until: float, at: Any, **options: Unpack[Told]) -> Trajectory:
        return run(self._whole, y0=self._in_scene(y), t0=t * self._second, until=until, at=at, **options, **self._how)

    @property
    def _whole(self) -> Scene:
        """The scene of which this is a run, or a part of one."""
        return self._scene._part[0] if self._scene._part else self._scene

    def __call__(self, t: ArrayLike) -> dict[str, Vector]:
        """The state at any time of the run, computed from the sample before it in the same way.

        At a sample it is that sample; elsewhere its error is that of the method.

        Parameters
        ----------
        t : float or array_like
            Times, in any order.

        Returns
        -------
        dict of ndarray
            ``u, v, pu, pv``, or ``x, y, vx, vy`` on a strain ring, of shape (sites,) or (times,
            sites).
        """
        times = vector("t", np.atleast_1d(unmasked("t", t)))
        start = self._scene._start / self._second
        wrong = times[~((times >= start) & (times <= self.t_end))]
        if wrong.size:
            raise ParameterError(f"t = {wrong[0]} is not valid: from {start} to {self.t_end}, the span of the run")
        kept = {name: array for name, array in self._states.items() if array is not None}
        samples = self.t if self._has_states and self.integrator != "closed-form" else self.t[:0]
        before = np.searchsorted(samples, times, side="right") - 1
        rows = {name: np.empty((len(times), self.chain.sites)) for name in self._end}
        for k in map(int, np.unique(before)):
            asked, places = np.unique(times[before == k], return_inverse=True)
            sample: dict[str, Vector] = {name: array[k] for name, array in kept.items()} if k >= 0 else {}
            if k >= 0 and asked[-1] == samples[k]:
                part = {name: array[None] for name, array in sample.items()}
            else:
                if k < 0:
                    again = run(self._scene, at=asked * self._second, **self._how)
                else:
                    last = (samples[k + 1] if k + 1 < len(samples) else self.t_end) * self._second
                    again = self._again(sample, samples[k], last, asked * self._second)
                part = {name: array for name, array in again._states.items() if array is not None}
            for name, array in part.items():
                rows[name][before == k] = array[places]
        return {name: array.reshape(*np.shape(t), self.chain.sites) for name, array in rows.items()}

    def to_dataframe(self) -> Any:
        """The states as a ``pandas.DataFrame`` with a row for each time and site; needs pandas."""
        import pandas

        index = pandas.MultiIndex.from_product([self.t, range(self.chain.sites)], names=["t", "site"])
        arrays = {name: self._array(name) for name in self._names}
        return pandas.DataFrame({name: array.ravel() for name, array in arrays.items() if array is not None}, index=index)

    def to_xarray(self) -> Any:
        """States and energies as an ``xarray.Dataset`` over ``t`` and ``site``; needs xarray."""
        import xarray

        arrays: dict[str, Any] = {}
        for name in self._names:
            if self._array(name) is not None:
                arrays[name] = (("t", "site"), self._array(name).copy())
        if self.energy is not None:
            arrays["energy"] = (("t",), self.energy)
        about = {"integrator": self.integrator, "setting": self.setting, "si": int(self.si)}
        return xarray.Dataset(arrays, {"t": self.t, "site": np.arange(self.chain.sites)}, about)

    def __repr__(self) -> str:
        failed = f", failure={self.failure!r}" if self.failure else ""
        return f"Trajectory({len(self.t)} times up to t={self.t_end:g}, {self.integrator}, {self.setting}{failed})"

    def strains(self) -> Vector:
        """Strains of the contacts, ``u_n - u_{n-1}``, or ``x`` on a strain ring.

        Returns
        -------
        ndarray, shape (times, contacts)
            Negative where beads press each other. Column `k` is bond `k` of ``contacts``, of the
            picture of :meth:`plot` and of ``Chain(bonds=..)``. On a ring the first is that of the
            last site with the first.
        """
        if self.chain.boundary == STRAIN_RING:
            return np.array(self.x)
        u = self.u
        if self.chain.boundary == "ring":
            return np.asarray(u - np.roll(u, 1, axis=1))
        ends = {"fixed": (1, 1), "left-wall": (1, 0), "right-wall": (0, 1)}.get(self.chain.boundary, (0, 0))
        return np.diff(np.pad(u, ((0, 0), ends)), axis=1)

    def plot(self, ax: Any = None) -> Any:
        """Strain over space and time, by matplotlib.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Where to draw; by default a new figure.

        Returns
        -------
        matplotlib axes
        """
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        strains = self.strains()
        # Gaps are often far wider than overlaps: colours end at the largest overlap, if there is one.
        size = float(-strains.min()) if strains.min() < 0 else float(np.abs(strains).max()) or 1.0
        picture = ax.pcolormesh(
            np.arange(strains.shape[1]), self.t, strains, cmap="RdBu_r", vmin=-size, vmax=size, shading="nearest"
        )
        ax.set(xlabel="bond", ylabel="time t" + (" (s)" if self.si else ""))
        ax.figure.colorbar(picture, ax=ax, label="strain" + (" (m)" if self.si else "") + ", negative in contacts", extend="max")
        return ax


def scene_of(what: Scene | Chain, y0: Any, until: float | None, t0: float | None = None) -> Scene:
    """The scene to run."""
    if t0 is not None and isinstance(what, (Chain, Scene)):
        if y0 is None or until is None and isinstance(what, Chain):
            raise ParameterError(f"t0 = {t0!r} is not valid without y0, the state at this time, and until")
        whole = what._rest if isinstance(what, Chain) else what
        return whole._from(y0, t0, whole.end if until is None else until)
    if isinstance(what, Chain):
        if y0 is None or until is None:
            missing = "y0" if y0 is None else "until"
            raise ParameterError(f"{missing} = None is not valid: a chain needs y0 and until")
        return what.scene(y0, until)
    if not isinstance(what, Scene):
        raise ParameterError(f"scene = {what!r} is not valid: a Scene or a Chain")
    if until is None and y0 is None:
        return what
    native = what._scene if until is None else what._scene.until(number("until", until))
    if y0 is not None:
        native = native.from_state(what.chain._velocities(y0))
    return Scene(native)


def run(
    scene: Scene | Chain,
    *,
    y0: Any = None,
    t0: float | None = None,
    until: float | None = None,
    method: str | None = None,
    tol: float | None = None,
    step: float | None = None,
    steps_per_period: float | None = None,
    at: ArrayLike | int | None = None,
    states: bool = True,
    events: bool = False,
    crossings: str | Sequence[str] = (),
    stop: str | Sequence[str] = (),
    derivatives: str | Sequence[str] = (),
    progress: Progress = False,
    on_sample: Callable[[float, Vector], Any] | None = None,
    on_contact: Callable[[dict[str, float]], Any] | None = None,
    on_crossing: Callable[[dict[str, float], Vector], Any] | None = None,
    dimensionless: bool = False,
) -> Trajectory:
    """Run a scene, or a chain from a state.

    Results have the same bits as those of the program. The interpreter's lock is released, so that
    runs on several Python threads use several cores. For a scene or chain with ``[units]`` all that
    is given, and the result, is in SI units.

    Parameters
    ----------
    scene : Scene or Chain
        What to run; a chain needs `y0` and `until`.
    y0 : mapping or array_like, optional
        The initial state: a mapping with some of ``u, v, pu, pv`` (``x, y, vx, vy`` on a strain
        ring; what is left out is zero), or all of them in this order in one array, without ``v``
        and ``pv`` if no resonator moves. Beads that drives move are where their drives are: their
        numbers are zero, or those of the drive.
    t0 : float, optional
        Time at which the run begins, by default zero: drives act as at this time, and need not
        come to their full height before the end. With `y0` only.
    until : float, optional
        End time.
    method : str, optional
        An integrator by name, see :func:`integrators`. Without a name, a `tol` selects contact
        collocation; otherwise ``hertzchain run`` has the same choice.
    tol : float, optional
        Tolerance, from 1e-15 to 0.1; collocation aims at it for the sum of the errors of all
        windows, which the error at the end exceeds where small changes grow.
    step, steps_per_period : float, optional
        Step of a method with equal steps, slightly reduced so that a whole number fits.
    at : array_like or int, optional
        Times of the samples, ascending, or a number of equal parts of the span. By default as the
        scene says; 400 parts for a chain.
    states : bool
        Whether states are kept at the sample times; energies are always kept.
    events : bool
        Whether to log all contacts.
    crossings : str or list of str
        Conditions that are looked for, also between samples: ``"u[10] > 0.5"`` is met where ``u`` of
        site 10 rises through 0.5, ``<`` where it falls, ``=`` at both. Quantities are ``u, v`` and
        their rates ``u_dot, v_dot`` of a site (strains on a strain ring), and ``overlap`` of a bond,
        counted as in ``contacts``.
    stop : str or list of str
        Conditions that end the run where they are met.
    derivatives : str or list of str
        Numbers of the chain by which the state at the end is differentiated, at fixed initial
        positions and momenta, fixed static overlaps and a fixed end time: ``alpha``, ``kappa``,
        ``rho``, ``mass[n]`` of bead n; ``amplitude``, the factor of the initial state. They are
        computed by regularised DOP853 to the tolerance `tol` (1e-10 without one), whatever the
        method; of chains without units whose contacts do not dissipate, with `alpha` above 1.
    progress : bool or callable
        Whether to show progress; or a function that is called with the share done, from 0 to 1.
    on_sample : callable, optional
        Called with the time of every sample and the state there, ``[u, v, u', v']``.
    on_contact : callable, optional
        Called with each contact, a dictionary with the columns of the log, after the step in which
        the contact ends. It turns `events` on.
    on_crossing : callable, optional
        Called with each crossing, a dictionary with the columns of `crossings`, and the state there,
        ``[u, v, u', v']``. It ends the run by returning True. An exception in one of the three
        functions stops the run and is raised; its attribute ``partial`` is the trajectory so far.
    dimensionless : bool
        Whether the trajectory, and what the functions are called with, is dimensionless also for a
        scene or chain with ``[units]``; what is given stays in SI units.

    Returns
    -------
    Trajectory
        The attribute `failure` is set if the run failed before its end. Called with a time, it
        gives the state there.

    Warns
    -----
    RunWarning
        If the result is doubtful, with the sentences of the attribute `warnings`; if the run failed
        before its end.

    Raises
    ------
    Error
        If an argument is refused, before the run begins.
    Interrupted
        On Ctrl-C; its attribute ``partial`` is the trajectory so far.

    Examples
    --------
    A bead strikes a chain of ten; momentum is conserved.

    >>> import hertzchain as hc, numpy as np
    >>> chain = hc.Chain(sites=10)
    >>> end = hc.run(chain, y0={"pu": np.eye(10)[0]}, until=20.0, tol=1e-10, events=True)
    >>> bool(np.abs(end.pu.sum(axis=1) - 1).max() < 1e-12)
    True
    >>> bool((end.contacts["onset"][1:] > 0).all())
    True

    The same up to the time at which the last bead is at 0.1.

    >>> part = hc.run(chain, y0={"pu": np.eye(10)[0]}, until=20.0, tol=1e-10, stop="u[9] > 0.1")
    >>> bool(abs(part.end["u"][9] - 0.1) < 1e-14), part.ended_by, len(part.crossings)
    (True, 'u[9] > 0.1', 1)

    This scene is in SI units: the driven bead moves by at most 10 nm.

    >>> driven = hc.run(hc.Scene.load("granular-crystal"), until=7e-4, tol=1e-8)
    >>> bool(9.9e-9 < np.abs(driven.u[:, 0]).max() <= 1e-8 * (1 + 1e-15))
    True

    Forty steel spheres, of which the first is struck at 0.5 m/s, written in SI units only.

    >>> steel = {"system": "SI", "radius": 9.525e-3, "density": 8027.0, "young": 193e9, "poisson": 0.3}
    >>> chain = hc.Chain(sites=40, units=steel)
    >>> struck = hc.run(chain, y0={"pu": 0.5 * chain.masses[0] * np.eye(40)[0]}, until=6e-4, tol=1e-10)
    >>> bool(abs(struck.energy[-1] / (0.5 * chain.masses[0][0] * 0.5**2) - 1) < 1e-9)
    True
    """
    if on_sample is not None and not callable(on_sample):
        raise ParameterError(f"on_sample = {on_sample!r} is not valid: a function of t and the state")
    if on_contact is not None and not callable(on_contact):
        raise ParameterError(f"on_contact = {on_contact!r} is not valid: a function of a contact")
    if on_crossing is not None and not callable(on_crossing):
        raise ParameterError(f"on_crossing = {on_crossing!r} is not valid: a function of a crossing and the state")
    asked_for = texts("derivatives", derivatives)
    looked, ending = texts("crossings", crossings), texts("stop", stop)
    if on_crossing is not None and not looked + ending:
        raise ParameterError("on_crossing is not valid without crossings or stop")
    whole, how = scene_of(scene, y0, until, t0), asked(method, tol, step, steps_per_period, dimensionless)
    if asked_for:  # Refused before the run, not after it.
        derivatives_of(whole, asked_for, whole._start, how["tol"] or 1e-10)

    def crossed(t: float, condition: int, rising: bool, state: Vector) -> Any:
        assert on_crossing is not None
        return on_crossing({"condition": condition, "t": t, "rising": rising}, state)

    with shown(progress, whole.name) as tell:
        record, raised = _native.run(
            whole._scene,
            **how,
            times=times_of(scene, at, whole.end, whole._start),
            states=flag("states", states),
            events=flag("events", events) or on_contact is not None,
            crossings=looked,
            stop=ending,
            progress=tell,
            seen=on_sample,
            told=None if on_contact is None else lambda _, numbers: on_contact(contact_of(numbers, whole)),
            crossed=None if on_crossing is None else crossed,
        )
    record["conditions"] = looked + ending
    if asked_for and record["failure"] is None and raised is None:
        record["derivatives"] = derivatives_of(whole, asked_for, record["t_end"], how["tol"] or 1e-10)
    si = whole.units is not None and not how["dimensionless"]
    trajectory = Trajectory(scene if isinstance(scene, Chain) else whole.chain, record, whole, si, how)
    failed = [trajectory.failure] if trajectory.failure and raised is None else []
    for warning in [*trajectory.warnings, *failed]:
        warnings.warn(warning, RunWarning, stacklevel=2)
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted(trajectory) from None
    if raised is not None:
        raised.partial = trajectory  # type: ignore[attr-defined]
        raise raised
    return trajectory


class Ensemble(Arrays, Sequence[Trajectory]):
    """The trajectories of :func:`run_many`: a sequence, and their arrays as one.

    Attributes
    ----------
    t : ndarray, shape (times,)
        Sample times.
    u, v, pu, pv : ndarray, shape (members, times, sites)
        As those of a :class:`Trajectory`, ``x, y, vx, vy`` on a strain ring; NaN after the failure
        of a member.
    energy : ndarray, shape (members, times), or None
        Energy at the sample times.
    energy_error : ndarray, shape (members,)
        NaN for a member without an energy.
    failures : dict
        Why members stopped before the end, by their numbers.
    t_end : float
        The time that all have reached.
    """

    def __init__(self, members: list[Trajectory]) -> None:
        self._members = members
        self.t: Vector = max((member.t for member in members), key=len)
        self.energy_error = np.array([math.nan if m.energy_error is None else m.energy_error for m in members])
        self.failures = {k: member.failure for k, member in enumerate(members) if member.failure}
        self.t_end = min(member.t_end for member in members)

    def resume(
        self,
        until: float,
        *,
        at: ArrayLike | int | None = None,
        states: bool = True,
        progress: Progress = False,
    ) -> Ensemble:
        """Go on from the end up to a later time, in the same way, as :meth:`Trajectory.resume` does.

        Raises
        ------
        ParameterError
            If a member has stopped before the others, as one that failed.
        """
        short = [k for k, member in enumerate(self) if member.failure or member.t_end != self[0].t_end]
        if short:
            raise ParameterError(f"resume is not valid: member {short[0]} has not reached the end")
        first = self[0]
        end, starts = number("until", until) * first._second, [member._in_scene(member.end) for member in self]
        options: dict[str, Any] = {"at": first._times(at), "states": states, "progress": progress, **first._how}
        return run_many(first._whole, starts, t0=first.t_end * first._second, until=end, **options)

    def _table(self, arrays: list[Vector]) -> Vector:
        whole = np.full((len(arrays), len(self.t), *arrays[0].shape[1:]), np.nan)
        for row, array in zip(whole, arrays):
            row[: len(array)] = array
        return whole

    @property
    def energy(self) -> Vector | None:
        """Energy at the sample times."""
        energies = [member.energy for member in self._members]
        return None if any(energy is None for energy in energies) else self._table(energies)  # type: ignore[arg-type]

    def _array(self, name: str) -> Any:
        arrays = [member._array(name) for member in self._members]
        return None if arrays[0] is None else self._table(arrays)

    @overload
    def __getitem__(self, k: int) -> Trajectory: ...
    @overload
    def __getitem__(self, k: slice) -> list[Trajectory]: ...
    def __getitem__(self, k: int | slice) -> Trajectory | list[Trajectory]:
        return self._members[k]

    def __len__(self) -> int:
        return len(self._members)

    def __repr__(self) -> str:
        failed = f", {len(self.failures)} failed" if self.failures else ""
        return f"Ensemble({len(self)} members, {len(self.t)} times{failed})"


def run_many(
    scene: Scene | Chain,
    y0: Any,
    *,
    t0: float | None = None,
    until: float | None = None,
    method: str | None = None,
    tol: float | None = None,
    step: float | None = None,
    steps_per_period: float | None = None,
    at: ArrayLike | int | None = None,
    states: bool = True,
    progress: Progress = False,
    dimensionless: bool = False,
) -> Ensemble:
    """Run a chain from many states, on all cores; each trajectory has the bits of :func:`run`.

    By a splitting scheme with equal steps, such as ``verlet``, short chains are moved side by side,
    one in each lane of a vector register, which takes less time.

    Parameters
    ----------
    scene : Scene or Chain
        What to run; a chain needs `until`.
    y0 : sequence or mapping
        The initial states: a sequence of what :func:`run` takes, such as the rows of an array of
        shape (members, numbers); or a mapping of ``u, v, pu, pv`` to arrays of shape (members,
        sites).
    t0, until, method, tol, step, steps_per_period, at, states, progress, dimensionless
        As in :func:`run`.

    Returns
    -------
    Ensemble

    Warns
    -----
    RunWarning
        Once for each kind of doubt about members, and of their failures, with the number of the
        first.

    Examples
    --------
    The first bead of a chain is struck at three speeds.

    >>> import hertzchain as hc, numpy as np
    >>> struck = np.zeros((3, 10))
    >>> struck[:, 0] = [0.5, 1.0, 2.0]
    >>> runs = hc.run_many(hc.Chain(sites=10), {"pu": struck}, until=5.0, method="verlet", step=0.01, at=50)
    >>> runs.u.shape, bool(np.allclose(runs.pu.sum(axis=2), struck[:, :1]))
    ((3, 51, 10), True)
    """
    scenes = [scene_of(scene, state, until, t0) for state in states_of(y0)]
    how = asked(method, tol, step, steps_per_period, dimensionless)
    if not scenes:
        raise ParameterError("y0 with no state is not valid: at least one")
    whole = scenes[0]
    with shown(progress, whole.name) as tell:
        records, raised = _native.run_many(
            [one._scene for one in scenes],
            **how,
            times=times_of(scene, at, whole.end, whole._start),
            states=flag("states", states),
            progress=tell,
        )
    chain = scene if isinstance(scene, Chain) else whole.chain
    si = whole.units is not None and not how["dimensionless"]
    members = [Trajectory(chain, record, one, si, how) for one, record in zip(scenes, records)]
    told: set[str] = set()
    for k, member in enumerate(members):
        for warning in [*member.warnings, *([member.failure] if member.failure and raised is None else [])]:
            if (kind := re.sub(r"\d[\d.e+-]*", "", warning)) not in told:
                told.add(kind)
                warnings.warn(f"member {k}: {warning}", RunWarning, stacklevel=2)
    ensemble = Ensemble(members)
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted(ensemble) from None
    if raised is not None:
        raise raised
    return ensemble


def derivatives_of(scene: Scene, asked: list[str], end: float, tol: float) -> dict[str, dict[str, Vector]]:
    """Derivatives of positions and momenta at a time, at fixed momenta at the start."""
    known = {name: array for name, array in zip(names(False), scene._scene.initial()) if array is not None}
    sites, start = scene.sites, np.concatenate(list(known.values()))
    half = len(start) // 2
    beads, resonators = scene._scene.masses(True)
    mass = np.concatenate([beads, resonators])[:half]
    # Those by the factor of the state have no source, and come last.
    by = sorted(asked, key=lambda name: name == "amplitude")

    def share(name: str) -> Vector:
        """What part of the masses a change of a number by one is."""
        if name == "rho":
            return np.repeat([0.0, 1.0 / (scene._scene.chain[3] or 1.0)], sites)[:half]
        return np.tile([float(name == f"mass[{site}]") for site in range(sites)] / beads, half // sites)

    shares = np.array([share(name) for name in by])
    columns = np.hstack([np.zeros((len(by), half)), -shares * start[half:]])
    columns[[name == "amplitude" for name in by]] = start
    state, columns = _native.derivatives(scene._scene, by, np.ascontiguousarray(columns.T), end, tol)
    ends = columns.T.copy()
    ends[:, half:] = mass * (ends[:, half:] + shares * state[half:])
    rows = dict(zip(by, ends))
    return {name: dict(zip(known, np.split(rows[name], len(known)))) for name in asked}


def contact_of(numbers: Vector, scene: Scene) -> dict[str, float]:
    """A contact as a dictionary with the columns of the log."""
    contact: dict[str, float] = dict(zip(_native.CONTACT_COLUMNS, numbers.tolist()))
    return contact | {"bond": int(numbers[0]) - FIRST.get(scene._scene.chain[4], 0)}


def asked(method: str | None, tol: Any, step: Any, steps_per_period: Any, dimensionless: bool) -> dict[str, Any]:
    """How a run is to be computed, as the native functions take it."""
    return {
        "method": None if method is None else word("method", method),
        "tol": optional("tol", tol),
        "step": optional("step", step),
        "steps_per_period": optional("steps_per_period", steps_per_period),
        "dimensionless": flag("dimensionless", dimensionless),
    }


def times_of(scene: Scene | Chain, at: ArrayLike | int | None, end: float, start: float = 0.0) -> Vector | None:
    """Sample times; None for those of a scene."""
    if at is None:
        if not isinstance(scene, Chain):
            return None
        at = DEFAULT_SAMPLES
    if isinstance(at, (int, np.integer)) and not isinstance(at, bool):
        if not 1 <= at <= 1_000_000:
            raise ParameterError(f"at = {at} is not valid: from 1 to 10^6 equal parts, or times")
        times = start + (end - start) * (np.arange(int(at) + 1) / int(at))
        times[-1] = end
        return np.asarray(times)
    return vector("at", at)


def states_of(y0: Any) -> list[Any]:
    """The initial states of many runs."""
    if isinstance(y0, Mapping):
        arrays = {name: states_of(rows) for name, rows in y0.items()}
        if len({len(rows) for rows in arrays.values()}) > 1:
            counts = ", ".join(f"{len(rows)} of {name}" for name, rows in arrays.items())
            raise ParameterError(f"y0 with {counts} is not valid: as many rows of each")
        return [dict(zip(arrays, rows)) for rows in zip(*arrays.values())]
    return several("y0", y0, "a sequence of states, or a mapping of arrays of them")


def integrators() -> list[str]:
    """Names of all integrators.

    Examples
    --------
    >>> import hertzchain as hc
    >>> "collocation" in hc.integrators()
    True
    """
    return _native.integrators()
