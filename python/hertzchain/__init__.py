"""Nonlinear waves in chains of beads with one-sided contacts, each with a linear resonator.

Examples
--------
A bead strikes a chain of twenty beads with resonators.

>>> import hertzchain as hc
>>> import numpy as np
>>> chain = hc.Chain(sites=20, kappa=1, rho=1 / 3)
>>> end = hc.run(chain, y0={"pu": np.eye(20)[0]}, until=40.0, tol=1e-10)
>>> end.u.shape, end.energy_error < 1e-9
((401, 20), True)
"""

from . import dps, studies
from ._chain import Chain, Scene
from ._compare import Comparison, compare, look
from ._driven import DrivenBranch, DrivenOrbit, driven_orbit
from ._errors import (
    ConvergenceError,
    Error,
    FileError,
    InternalError,
    ParameterError,
    RunError,
    RunWarning,
    SceneError,
    UnknownNameError,
)
from ._modes import NormalMode, normal_mode
from ._native import __version__
from ._orbits import Branch, BranchPoint, DarkBreather, Orbit, continue_branch, monodromy
from ._run import Ensemble, Interrupted, Trajectory, integrators, run, run_many
from ._simulation import Simulation
from ._study import Study, study
from ._sweep import Results, Table, sweep, sweep_plan
from ._waves import BrightBreather, TravellingWave

__all__ = [
    "Branch",
    "BranchPoint",
    "BrightBreather",
    "Chain",
    "Comparison",
    "ConvergenceError",
    "DarkBreather",
    "DrivenBranch",
    "DrivenOrbit",
    "Ensemble",
    "Error",
    "FileError",
    "InternalError",
    "Interrupted",
    "NormalMode",
    "Orbit",
    "ParameterError",
    "Results",
    "RunError",
    "RunWarning",
    "Scene",
    "SceneError",
    "Simulation",
    "Study",
    "Table",
    "Trajectory",
    "TravellingWave",
    "UnknownNameError",
    "__version__",
    "compare",
    "continue_branch",
    "dps",
    "driven_orbit",
    "integrators",
    "look",
    "monodromy",
    "normal_mode",
    "run",
    "run_many",
    "studies",
    "study",
    "sweep",
    "sweep_plan",
]
