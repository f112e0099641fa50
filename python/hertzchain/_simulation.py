"""A chain that is moved on from time to time."""

from __future__ import annotations

import copy
import io
import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._arrays import Vector, file_at, number, optional
from ._chain import Chain, Scene, names, state_of
from ._errors import FileError, ParameterError, of_file
from ._run import Told, Trajectory, run
from ._study import written
from ._values import Value

if TYPE_CHECKING:
    from typing_extensions import Unpack

FORMAT = "hertzchain simulation 1"


class Simulation(Value):
    """A chain with its state at a time; :meth:`integrate` moves it on.

    Between two calls of it the state and the chain can be changed.

    Parameters
    ----------
    chain : Chain or Scene
        A scene is taken for its chain, and for `y0`.
    y0 : mapping or array_like, optional
        The state, as in :func:`run`.
    t : float
        Its time. Drives act as at this time.
    method, tol, step : optional
        As in :func:`run`; a tolerance holds for each call of :meth:`integrate`.

    Attributes
    ----------
    chain : Chain
        It can be replaced by another one of as many sites.
    t : float
        The time, in seconds for a chain with ``units``.
    state : dict of ndarray
        ``u, v, pu, pv`` at this time, or ``x, y, vx, vy`` on a strain ring; the arrays can be
        changed.

    Examples
    --------
    A bead strikes a chain of ten; at time 10 the last bead is stopped.

    >>> import hertzchain as hc, numpy as np
    >>> sim = hc.Simulation(hc.Chain(sites=10), {"pu": np.eye(10)[0]}, tol=1e-10)
    >>> first = sim.integrate(10.0)
    >>> sim.state["pu"][-1] = 0.0
    >>> second = sim.integrate(20.0)
    >>> sim.t, bool(abs(second.pu[-1].sum() - first.pu[-1, :-1].sum()) < 1e-12)
    (20.0, True)
    """

    def __init__(
        self,
        chain: Chain | Scene,
        y0: Any = None,
        *,
        t: float = 0.0,
        method: str | None = None,
        tol: float | None = None,
        step: float | None = None,
    ) -> None:
        if not isinstance(chain, (Chain, Scene)):
            raise ParameterError(f"chain = {chain!r} is not valid: a Chain or a Scene")
        if y0 is None and isinstance(chain, Chain):
            raise ParameterError("y0 = None is not valid: a chain needs a state")
        y0 = chain.y0 if isinstance(chain, Scene) and y0 is None else y0
        self.chain = chain if isinstance(chain, Chain) else chain.chain
        self.t = number("t", t)
        self._how: dict[str, Any] = {"method": method, "tol": optional("tol", tol), "step": optional("step", step)}
        known, sites = names(self.chain.boundary == "strain-ring"), self.chain.sites
        given = state_of(y0, known, sites, self.chain.resonators)
        parts = [name for k, name in enumerate(known) if k % 2 == 0 or self.chain.resonators]
        self.state: dict[str, Vector] = {name: given.pop(name, np.zeros(sites)).copy() for name in parts}
        if any(array.any() for array in given.values()):
            raise ParameterError(f"y0 with {', '.join(given)} is not valid: no resonator of this chain moves")

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)  # The arrays of its state can be changed.

    def integrate(self, until: float, *, at: ArrayLike | int = 1, **options: Unpack[Told]) -> Trajectory:
        """Move the chain on to a time, which becomes `t`.

        A run that a condition of `stop` ends early sets `t` to its end. One that fails, or is stopped by Ctrl-C or by an exception in a function, leaves the
        simulation as it was.

        Parameters
        ----------
        until : float
            The time.
        at : array_like or int
            Times of the samples, or a number of equal parts; by default both ends.
        states, events, crossings, stop, progress, on_sample, on_contact, on_crossing
            As in :func:`run`.

        Returns
        -------
        Trajectory
            From the time before to `until`.
        """
        part = run(self.chain, y0=self.state, t0=self.t, until=until, at=at, **options, **self._how)
        if part.failure is None:
            self.t = number("until", until) if part.ended_by is None else part.t_end
            self.state = part.end
        return part

    def copy(self) -> Simulation:
        """Another simulation, which goes on from here with the same bits."""
        return copy.deepcopy(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the simulation to a file in numpy's format NPZ, whole or not at all."""
        chain = {name: _lists(value) for name, value in self.chain._given.items()}
        about = {"format": FORMAT, "program": _native.__version__, "chain": chain, "t": self.t, "how": self._how}
        content = io.BytesIO()
        np.savez(content, about=np.array(json.dumps(about)), **self.state)  # type: ignore[arg-type]
        written(path, content.getvalue())

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Simulation:
        """The simulation in a file of :meth:`save`; it goes on with the same bits."""
        file = file_at("path", path)
        try:
            with of_file(file), np.load(file) as arrays:
                about = json.loads(str(arrays["about"]))
                state = {name: arrays[name] for name in arrays.files if name != "about"}
            if about["format"] != FORMAT:
                raise ValueError(f"format {about['format']!r}")
            simulation = Simulation(Chain(**about["chain"]), state, t=about["t"])
            simulation._how = about["how"]
        except FileError:
            raise
        except Exception as error:  # Of zip, of numpy, of JSON, of what is in the file.
            raise FileError(f"{file}: not a file of Simulation.save ({error})") from None
        return simulation

    def __repr__(self) -> str:
        return f"Simulation(t={self.t:g}, {self.chain!r})"


def _lists(value: Any) -> Any:
    """A value of a table for JSON, which keeps every double."""
    if isinstance(value, dict):
        return {key: _lists(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_lists(one) for one in value]
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
