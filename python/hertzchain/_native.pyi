from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_V = NDArray[np.float64]
_State = tuple[_V | None, _V | None, _V | None, _V | None]
_Numbers = tuple[int, float, float, float, str, float, str, tuple[float, float]]

__all__ = [
    "Bright",
    "CONTACT_COLUMNS",
    "KEYS",
    "Report",
    "Scene",
    "Wave",
    "__version__",
    "averages",
    "check_chain",
    "derivatives",
    "flow",
    "integrators",
    "load_branch",
    "look",
    "modes",
    "monodromy",
    "program",
    "run",
    "run_many",
    "scenes",
    "study",
    "wave_of",
]

__version__: str
CONTACT_COLUMNS: list[str]
KEYS: dict[str, list[str]]

@final
class Scene:
    @staticmethod
    def load(name: str, changes: list[str]) -> Scene: ...
    @staticmethod
    def parse(text: str, name: str, changes: list[str]) -> Scene: ...
    @staticmethod
    def of_chain(chain: _Numbers, state: _State, until: float) -> Scene: ...
    def from_state(self, state: _State) -> Scene: ...
    def part(self, start: float, end: float, state: _State) -> Scene: ...
    def until(self, end: float) -> Scene: ...
    def to_toml(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def chain(self) -> tuple[int, float, float, float, str, float, float, float]: ...
    @property
    def tables(self) -> dict[str, Any] | None: ...
    @property
    def sections(self) -> str: ...
    def masses(self, si: bool) -> list[_V]: ...
    @property
    def units(self) -> dict[str, float] | None: ...
    @property
    def period(self) -> float: ...
    @property
    def end(self) -> float: ...
    def initial(self) -> list[_V | None]: ...
    def plan(self, events: bool) -> list[str]: ...

@final
class Report:
    @property
    def json(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def failure(self) -> str | None: ...
    @property
    def remark(self) -> str | None: ...
    def tables(self) -> list[tuple[str, list[tuple[str, list[Any]]]]]: ...
    def files(self, formats: list[str]) -> list[tuple[str, bytes]]: ...

@final
class Wave:
    def __new__(
        cls, chain: list[float], shape: list[float], epsilon: float | None, detuning: float | None
    ) -> Wave: ...
    @property
    def omega_tw(self) -> float: ...
    @property
    def epsilon(self) -> float: ...
    def sites(self, sites: int, t: float) -> _V: ...

@final
class Bright:
    def __new__(cls, chain: list[float], about: str, epsilon: float, sites: int) -> Bright: ...
    @property
    def omega_b(self) -> float: ...
    @property
    def period(self) -> float: ...
    @property
    def horizon(self) -> float: ...
    def sites(self, t: float) -> _V: ...

def derivatives(scene: Scene, names: list[str], columns: _V, end: float, tol: float) -> tuple[_V, _V]: ...
def program(arguments: list[str]) -> int: ...
def integrators() -> list[str]: ...
def look(name: str) -> tuple[str, str, list[float]] | None: ...
def check_chain(chain: _Numbers) -> None: ...
def scenes() -> list[tuple[str, str]]: ...
def run(
    scene: Scene,
    *,
    method: str | None,
    tol: float | None,
    step: float | None,
    steps_per_period: float | None,
    times: _V | None,
    states: bool,
    events: bool,
    crossings: list[str],
    stop: list[str],
    dimensionless: bool,
    progress: Callable[[float], Any] | None,
    seen: Callable[[float, _V], Any] | None,
    told: Callable[[float, _V], Any] | None,
    crossed: Callable[[float, int, bool, _V], Any] | None,
) -> tuple[dict[str, Any], BaseException | None]: ...
def run_many(
    scenes: list[Scene],
    *,
    method: str | None,
    tol: float | None,
    step: float | None,
    steps_per_period: float | None,
    times: _V | None,
    states: bool,
    dimensionless: bool,
    progress: Callable[[float], Any] | None,
) -> tuple[list[dict[str, Any]], BaseException | None]: ...
def study(
    line: list[str], progress: Callable[[float], Any] | None
) -> tuple[Report | None, BaseException | None]: ...
def load_branch(path: str) -> Report: ...
def modes(npz: bytes) -> _V: ...
def monodromy(scene: Scene, tol: float) -> _V: ...
def wave_of(scene: Scene) -> Wave: ...
def averages(alpha: float, kappa: float, b: _V, r: _V) -> list[_V]: ...
def flow(
    chain: list[float],
    start: _V,
    times: _V,
    force: float | None,
    mean_strain: float | None,
    ring: bool,
    strains: bool,
    tol: float,
) -> _V: ...
