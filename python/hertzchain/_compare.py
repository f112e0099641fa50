"""Integrators on a scene: error against run time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from . import _native, studies
from ._arrays import number, texts
from ._chain import Scene
from ._errors import ParameterError
from ._progress import Progress
from ._study import Study
from ._values import Value


class Comparison(Value):
    """Errors and run times of integrators on a scene.

    Attributes
    ----------
    rows : list of dict
        A dictionary for each run: ``integrator``, ``setting``, ``error``, ``wall_s`` and so on.
    record : dict
        All that ``hertzchain compare --json`` prints.
    """

    def __init__(self, study: Study) -> None:
        self.record: dict[str, Any] = study.record
        self.rows: list[dict[str, Any]] = self.record["rows"]

    def __repr__(self) -> str:
        return f"Comparison({len(self.rows)} runs)"

    def plot(self, ax: Any = None) -> Any:
        """Error against run time, by matplotlib."""
        import matplotlib.pyplot as plt

        ax = ax if ax is not None else plt.subplots(layout="constrained")[1]
        names = dict.fromkeys(row["integrator"] for row in self.rows)
        for name in names:
            rows = [row for row in self.rows if row["integrator"] == name and row.get("error")]
            ax.loglog([row["wall_s"] for row in rows], [row["error"] for row in rows], label=name, **look(name))
        ax.set(xlabel="run time (s)", ylabel="error")
        machine = self.record["machine"]
        where = machine.get("processor", machine["system"])
        ax.set_title(f"{machine['date']}, one thread, {where}, {machine['cores']} cores", fontsize="x-small")
        ax.legend(fontsize="small")
        return ax


def look(name: str) -> dict[str, Any]:
    """Colour, marker and dashes of an integrator in all pictures, as arguments of matplotlib's ``plot``."""
    found = _native.look(name)
    if found is None:
        return {"marker": "."}
    colour, marker, dashes = found
    return {"color": colour, "marker": marker, "markersize": 4, "linestyle": (0, dashes) if dashes else "-"}


def compare(
    scene: Scene,
    methods: Sequence[str] | None = None,
    *,
    error: Literal["strain", "velocity", "resonator", "energy", "all"] = "all",
    max_time: float = 10.0,
    progress: Progress = False,
) -> Comparison:
    """Run integrators on a scene over a ladder of steps or tolerances.

    Parameters
    ----------
    scene : Scene
        The scene.
    methods : sequence of str, optional
        Names of integrators; by default those of ``hertzchain compare``.
    error : str
        What errors are measured in: ``strain``, ``velocity``, ``resonator``, ``energy`` or, the
        largest of the first three, ``all``.
    max_time : float
        Wall time for all runs, in seconds; runs that would exceed it are left out.
    progress : bool or callable
        As in :func:`run`.
    """
    if not isinstance(scene, Scene):
        raise ParameterError(f"scene = {scene!r} is not valid: a Scene")
    if isinstance(methods, str):
        raise ParameterError(f"methods = {methods!r} is not valid: a list of names")
    names = [] if methods is None else texts("methods", methods)
    limit = number("max_time", max_time)
    return Comparison(studies.compare(scene, integrators=names or None, error=error, max_time=limit, progress=progress))
