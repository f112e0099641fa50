"""Runs and their results."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import Vector, number, optional, vector, word
from ._chain import STRAIN_RING, Chain, Scene, names
from ._errors import ParameterError
from ._progress import Progress, shown

ENERGIES = np.dtype([(name, np.float64) for name in ("beads", "resonators", "springs", "contacts")])
CONTACTS = np.dtype([(name, np.int64 if name == "bond" else np.float64) for name in _native.CONTACT_COLUMNS])
DEFAULT_SAMPLES = 400


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `partial` is what the run, or :func:`run_many`, had recorded.

    Attributes
    ----------
    partial : Trajectory or Ensemble
    """

    def __init__(self, partial: Trajectory | Ensemble) -> None:
        super().__init__(f"stopped at t = {partial.t_end:g}")
        self.partial = partial


class Trajectory:
    """The record of a run, in SI units for a scene or chain with ``[units]``: metres, seconds,
    joules, momenta in kg m/s.

    Attributes
    ----------
    t : ndarray, shape (times,)
        Sample times.
    u, v, pu, pv : ndarray, shape (times, sites), or None
        Displacements of beads and resonators, and their momenta, mass times rate; for equal beads
        ``pu = u'``, ``pv = rho v'``. ``v`` and ``pv`` are None if no resonator moves. On a strain
        ring these are ``x, y, vx, vy``: strains and their rates.
    energy : ndarray, shape (times,), or None
        Energy at the sample times; None on a strain ring whose state has no energy.
    energies : structured ndarray or None
        The energy by kind: ``beads``, ``resonators``, ``springs``, ``contacts``.
    contacts : structured ndarray or None
        The log of contacts, if it was asked for: ``bond``, ``onset``, ``release``, and so on. NaN
        stands for a number that a contact does not have, such as the release of an open one.
    stats : dict
        ``steps``, ``rejected``, ``force_evaluations``, ``wall_s``.
    energy_error : float or None
        Largest sampled ``|E(t) - E(0)| / |E(0)|``; of chains that dissipate or are driven, that of
        the balance energy + dissipated - driven.
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

    def __init__(
        self, chain: Chain, record: dict[str, Any], units: dict[str, float] | None = None, si: bool = False
    ) -> None:
        self.chain = chain
        self.units = units
        self.si = si
        strains = chain.boundary == STRAIN_RING
        self._names = names(strains)
        self.t: Vector = record["t"]
        self._states = dict(zip(self._names, record.get("states") or (None,) * 4))
        self._has_states = "states" in record
        self._energies: Vector | None = record.get("energies")
        self._contacts: Vector | None = record.get("contacts")
        self.stats = {name: record[name] for name in ("steps", "rejected", "force_evaluations", "wall_s")}
        self.energy_error: float | None = record["energy_error"]
        work = record.get("dissipated")
        self.dissipated = None if work is None else dict(zip(("drag", "dashpots", "contacts", "total"), work))
        self.driven: float | None = record.get("driven")
        self.warnings: list[str] = record["warnings"]
        self.failure: str | None = record["failure"]
        self.t_end: float = record["t_end"]
        self.end: dict[str, Vector] = {
            name: array[0] for name, array in zip(self._names, record["end"]) if array is not None
        }
        self.integrator: str = record["integrator"]
        self.setting: str = record["setting"]
        self.reason: str | None = record["reason"]

    @property
    def energy(self) -> Vector | None:
        """Energy at the sample times."""
        return None if self._energies is None else np.asarray(self._energies.sum(axis=1))

    @property
    def energies(self) -> NDArray[Any] | None:
        """Energy at the sample times by kind."""
        return None if self._energies is None else self._energies.view(ENERGIES)[:, 0]

    @cached_property
    def contacts(self) -> NDArray[Any] | None:
        """The log of contacts."""
        if self._contacts is None:
            return None
        table = np.zeros(len(self._contacts), CONTACTS)
        for k, name in enumerate(_native.CONTACT_COLUMNS):
            table[name] = self._contacts[:, k]
        return table

    def __getattr__(self, name: str) -> Any:
        states = self.__dict__.get("_states", {})
        if name in states:
            if not self._has_states:
                raise AttributeError(f"no states were kept: call run(..., states=True) for {name!r}")
            return states[name]
        if name in ("u", "v", "pu", "pv", "x", "y", "vx", "vy"):
            raise AttributeError(f"{name!r} is not of this chain: its arrays are {', '.join(self._names)}")
        raise AttributeError(name)

    def __repr__(self) -> str:
        failed = f", failure={self.failure!r}" if self.failure else ""
        return f"Trajectory({len(self.t)} times up to t={self.t_end:g}, {self.integrator}, {self.setting}{failed})"

    def strains(self) -> Vector:
        """Strains of the contacts, ``u_n - u_{n-1}``, or ``x`` on a strain ring.

        Returns
        -------
        ndarray, shape (times, contacts)
            Negative where beads press each other. On a ring the first contact is that of the last
            site with the first.
        """
        if self.chain.boundary == STRAIN_RING:
            strains: Vector = self.x
            return strains
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
        ax.set(xlabel="contact n", ylabel="time t" + (" (s)" if self.si else ""))
        ax.figure.colorbar(picture, ax=ax, label="strain" + (" (m)" if self.si else "") + ", negative in contacts", extend="max")
        return ax


def scene_of(what: Scene | Chain, y0: Any, until: float | None) -> Scene:
    """The scene to run."""
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
    until: float | None = None,
    method: str | None = None,
    tol: float | None = None,
    step: float | None = None,
    steps_per_period: float | None = None,
    at: ArrayLike | int | None = None,
    states: bool = True,
    events: bool = False,
    progress: Progress = False,
    on_sample: Callable[[float, Vector], Any] | None = None,
    on_contact: Callable[[dict[str, float]], Any] | None = None,
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
        and ``pv`` if no resonator moves.
    until : float, optional
        End time; the run begins at zero.
    method : str, optional
        An integrator by name, see :func:`integrators`. Without a name, a `tol` selects contact
        collocation; otherwise ``hertzchain run`` has the same choice.
    tol : float, optional
        Tolerance, from 1e-15 to 0.1; for collocation it bounds the sum of the errors of all
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
    progress : bool or callable
        Whether to show progress; or a function that is called with the share done, from 0 to 1.
    on_sample : callable, optional
        Called with the time of every sample and the state there, ``[u, v, u', v']``.
    on_contact : callable, optional
        Called with each contact, a dictionary with the columns of the log, after the step in which
        the contact ends. It turns `events` on. An exception in one of the two functions stops the
        run and is raised; its attribute ``partial`` is the trajectory so far.
    dimensionless : bool
        Whether the trajectory, and what the functions are called with, is dimensionless also for a
        scene or chain with ``[units]``; what is given stays in SI units.

    Returns
    -------
    Trajectory
        The attribute `failure` is set if the run failed before its end.

    Warns
    -----
    RuntimeWarning
        If the result is doubtful; the attribute `warnings` has the same sentences.

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
    whole = scene_of(scene, y0, until)
    with shown(progress, whole.name) as tell:
        record, raised = _native.run(
            whole._scene,
            **asked(method, tol, step, steps_per_period),
            times=times_of(scene, at, whole.end),
            states=states,
            events=events or on_contact is not None,
            dimensionless=bool(dimensionless),
            progress=tell,
            seen=on_sample,
            told=None if on_contact is None else lambda _, numbers: on_contact(contact_of(numbers)),
        )
    si = whole.units is not None and not dimensionless
    trajectory = Trajectory(scene if isinstance(scene, Chain) else whole.chain, record, whole.units, si)
    for warning in trajectory.warnings:
        warnings.warn(warning, RuntimeWarning, stacklevel=2)
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted(trajectory) from None
    if raised is not None:
        raised.partial = trajectory  # type: ignore[attr-defined]
        raise raised
    return trajectory


class Ensemble(Sequence[Trajectory]):
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

    def _whole(self, arrays: list[Vector]) -> Vector:
        whole = np.full((len(arrays), len(self.t), *arrays[0].shape[1:]), np.nan)
        for row, array in zip(whole, arrays):
            row[: len(array)] = array
        return whole

    @property
    def energy(self) -> Vector | None:
        """Energy at the sample times."""
        energies = [member.energy for member in self._members]
        return None if any(energy is None for energy in energies) else self._whole(energies)  # type: ignore[arg-type]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        arrays = [getattr(member, name) for member in self._members]
        if not isinstance(arrays[0], np.ndarray):
            raise AttributeError(f"{name!r} is not an array over time: it is of each member")
        return self._whole(arrays)

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

    By a splitting with equal steps, such as ``strang-linear`` or ``verlet``, chains of equal beads
    are moved side by side, one in each lane of a vector register, which takes less time.

    Parameters
    ----------
    scene : Scene or Chain
        What to run; a chain needs `until`.
    y0 : sequence or mapping
        The initial states: a sequence of what :func:`run` takes, such as the rows of an array of
        shape (members, numbers); or a mapping of ``u, v, pu, pv`` to arrays of shape (members,
        sites).
    until, method, tol, step, steps_per_period, at, states, progress, dimensionless
        As in :func:`run`.

    Returns
    -------
    Ensemble

    Warns
    -----
    RuntimeWarning
        Once for each kind of doubt about members, with the number of the first.

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
    scenes = [scene_of(scene, state, until) for state in states_of(y0)]
    if not scenes:
        raise ParameterError("y0 with no state is not valid: at least one")
    whole = scenes[0]
    with shown(progress, whole.name) as tell:
        records, raised = _native.run_many(
            [one._scene for one in scenes],
            **asked(method, tol, step, steps_per_period),
            times=times_of(scene, at, whole.end),
            states=states,
            dimensionless=bool(dimensionless),
            progress=tell,
        )
    chain = scene if isinstance(scene, Chain) else whole.chain
    si = whole.units is not None and not dimensionless
    members = [Trajectory(chain, record, whole.units, si) for record in records]
    told: set[str] = set()
    for k, member in enumerate(members):
        for warning in member.warnings:
            if (kind := re.sub(r"\d[\d.e+-]*", "", warning)) not in told:
                told.add(kind)
                warnings.warn(f"member {k}: {warning}", RuntimeWarning, stacklevel=2)
    ensemble = Ensemble(members)
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted(ensemble) from None
    if raised is not None:
        raise raised
    return ensemble


def contact_of(numbers: Vector) -> dict[str, float]:
    """A contact as a dictionary with the columns of the log."""
    contact: dict[str, float] = dict(zip(_native.CONTACT_COLUMNS, numbers.tolist()))
    return contact | {"bond": int(numbers[0])}


def asked(method: str | None, tol: Any, step: Any, steps_per_period: Any) -> dict[str, Any]:
    """How a run is to be computed, as the native functions take it."""
    return {
        "integrator": None if method is None else word("method", method),
        "tol": optional("tol", tol),
        "step": optional("step", step),
        "steps_per_period": optional("steps_per_period", steps_per_period),
    }


def times_of(scene: Scene | Chain, at: ArrayLike | int | None, end: float) -> Vector | None:
    """Sample times; None for those of a scene."""
    if at is None:
        if not isinstance(scene, Chain):
            return None
        at = DEFAULT_SAMPLES
    if isinstance(at, (int, np.integer)) and not isinstance(at, bool):
        if not 1 <= at <= 1_000_000:
            raise ParameterError(f"at = {at} is not valid: from 1 to 10^6 equal parts, or times")
        return np.asarray(end * (np.arange(int(at) + 1) / int(at)))
    return vector("at", at)


def states_of(y0: Any) -> list[Any]:
    """The initial states of many runs."""
    if isinstance(y0, Mapping):
        arrays = {name: states_of(rows) for name, rows in y0.items()}
        if len({len(rows) for rows in arrays.values()}) > 1:
            counts = ", ".join(f"{len(rows)} of {name}" for name, rows in arrays.items())
            raise ParameterError(f"y0 with {counts} is not valid: as many rows of each")
        return [dict(zip(arrays, rows)) for rows in zip(*arrays.values())]
    if not isinstance(y0, Iterable) or isinstance(y0, str):
        raise ParameterError(f"y0 = {y0!r} is not valid: a sequence of states, or a mapping of arrays of them")
    return list(y0)


def integrators() -> list[str]:
    """Names of all integrators.

    Examples
    --------
    >>> import hertzchain as hc
    >>> "collocation" in hc.integrators()
    True
    """
    return _native.integrators()
