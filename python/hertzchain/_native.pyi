from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_V = NDArray[np.float64]
_State = tuple[_V | None, _V | None, _V | None, _V | None]
_Numbers = tuple[int, float, float, float, str, float, str]

__all__ = [
    "Bright",
    "CONTACT_COLUMNS",
    "Scene",
    "Wave",
    "__version__",
    "averages",
    "check_chain",
    "compare_json",
    "continue_branch",
    "dark",
    "dark_profile",
    "driven_branch",
    "driven_orbit",
    "flow",
    "homoclinic",
    "integrators",
    "load_branch",
    "monodromy",
    "normal_mode",
    "program",
    "run",
    "scenes",
    "sweep_plan",
    "wave_of",
]

__version__: str
CONTACT_COLUMNS: list[str]

@final
class Scene:
    @staticmethod
    def load(name: str, changes: list[str]) -> Scene: ...
    @staticmethod
    def parse(text: str, name: str, changes: list[str]) -> Scene: ...
    @staticmethod
    def of_chain(chain: _Numbers, state: _State, until: float) -> Scene: ...
    def from_state(self, state: _State) -> Scene: ...
    def until(self, end: float) -> Scene: ...
    def to_toml(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def chain(self) -> tuple[int, float, float, float, str, float]: ...
    @property
    def tables(self) -> dict[str, Any] | None: ...
    def masses(self) -> list[_V]: ...
    @property
    def units(self) -> dict[str, float] | None: ...
    @property
    def period(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def samples(self) -> int: ...
    def initial(self) -> list[_V | None]: ...
    def plan(self, events: bool) -> list[str]: ...

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

def program(arguments: list[str]) -> int: ...
def integrators() -> list[str]: ...
def check_chain(chain: _Numbers) -> None: ...
def scenes() -> list[tuple[str, str]]: ...
def run(
    scene: Scene,
    *,
    integrator: str | None,
    tol: float | None,
    step: float | None,
    steps_per_period: float | None,
    times: _V | None,
    states: bool,
    events: bool,
    progress: Callable[[float], Any] | None,
    seen: Callable[[float, _V], Any] | None,
    told: Callable[[float, _V], Any] | None,
) -> tuple[dict[str, Any], BaseException | None]: ...
def dark(breather: Any) -> tuple[str, _V]: ...
def continue_branch(
    breather: Any,
    *,
    parameter: str,
    from_: float,
    to: float,
    step: float | None,
    points: int,
    natural: bool,
    weak: float,
    bound: bool,
    progress: Callable[[float], Any] | None,
) -> tuple[str, bytes]: ...
def load_branch(path: Any) -> tuple[str, bytes]: ...
def driven_orbit(
    scene: Scene, *, turns: int, settle: int, si: bool, progress: Callable[[float], Any] | None
) -> str: ...
def driven_branch(
    scene: Scene,
    *,
    turns: int,
    settle: int,
    parameter: str,
    to: float,
    step: float | None,
    points: int,
    switch: int | None,
    si: bool,
    progress: Callable[[float], Any] | None,
) -> str: ...
def normal_mode(
    scene: Scene,
    *,
    mode: int | None,
    to: float,
    step: float | None,
    points: int,
    switch: int | None,
    si: bool,
    progress: Callable[[float], Any] | None,
) -> str: ...
def compare_json(
    scene: Scene, integrators: list[str], max_time: float, progress: Callable[[float], Any] | None
) -> str: ...
def sweep_plan(
    path: str,
    out: str | None,
    formats: list[str],
    shard: str | None,
    progress: Callable[[float], Any] | None,
) -> tuple[str, list[tuple[str, _V, int]], list[tuple[int, str]]]: ...
def monodromy(scene: Scene, tol: float) -> _V: ...
def wave_of(scene: Scene) -> Wave: ...
def averages(alpha: float, kappa: float, b: _V, r: _V) -> list[_V]: ...
def homoclinic(alpha: float, about: str) -> tuple[NDArray[np.int64], _V]: ...
def dark_profile(chain: list[float], about: str, sites: int, c: float) -> tuple[NDArray[np.int64], _V, _V, float]: ...
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
