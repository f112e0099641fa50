"""The studies of the program, a function for each, with its options as arguments.

Generated: what ``--help`` says. What is not given has the default of the program. Files are written
to the folder ``out``, and to files that options name.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from ._chain import Chain, Scene
from ._progress import Progress
from ._study import Study, called


def compare(
    scene: Scene | Chain | str,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    error: Literal["strain", "velocity", "resonator", "energy", "all"] = "all",
    integrators: str | Sequence[str] | None = None,
    max_time: float = 10,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compare integrators on a scene: error against run time.

    Every integrator runs with smaller and smaller steps or tolerances until the time of `max_time`
    is used up. Errors are those that `error` names, against a reference that a second method
    checks. The fastest run at each error comes first.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    error : Literal["strain", "velocity", "resonator", "energy", "all"]
        What errors are measured in: the state at the end, or the energy. Of strains, velocities and
        stretches each is relative to its largest, of all sites at 101 times of the reference run.
    integrators : str | Sequence[str]
        Integrators, separated by commas, or all. By default integrators that are the fastest at
        some error on a built-in scene, and those that serve as a standard of comparison: verlet,
        yoshida4, aba864, srkn14-6, strang-linear, aba1064-linear, corrected,
        takahashi-imada-linear, dop853, dop853-regularised, collocation.
    max_time : float
        Wall time for all runs, in seconds; what would not fit is left out. Runs are also left out
        if they take more than a 400th of this time and are expected to be beaten in error and in
        time. Finite and positive.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: compare.json, compare.png; compare.npz with an
        array TABLE.COLUMN for each column of fastest.csv: error, integrator, setting (the coarsest
        that reaches it), wall_s (seconds to this error, between settings on a straight line in log
        error and log time), plain_loop (fastest plain loop), plain_wall_s (its time), ratio (of the
        two times). compare.csv: integrator, setting (kicks in a period of the fastest motion, or
        tolerance), step, error (in the chosen norm (`error`)), energy_error, wall_s (median wall
        time of a run, in seconds), runs (runs whose median it is), force_evaluations, steps,
        rejected, below_reference (whether the error is below 3 times the error estimate of the
        reference: an upper bound at best), failure, step_cost (wall time of a step, in steps of
        plain Verlet), order (of the method through contacts, by theory).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("compare", compare, locals())


def sweep(
    plan: str | os.PathLike[str] | None = None,
    *,
    template: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Run a scene at every point of a grid that a plan describes.

    The plan names a scene, axes (any keys of the scene: lists, ranges, seeds) and the quantities to
    keep of each run; `hertzchain scenes` lists those that come with the program. Prints a table;
    with `out` also writes a picture, and a store from which an interrupted sweep resumes.

    Parameters
    ----------
    plan : str | os.PathLike[str]
        Name of a built-in plan, or a TOML file; `hertzchain sweep --template` prints one.
    template : bool
        Print a plan: a start for your own. The plan that is named, otherwise one with every key,
        each explained.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. sweep.store keeps every point as soon as it is computed;
        the same command resumes from it. Files: sweep.csv (a line a point, also failures),
        sweep.npz (a column a quantity), sweep.json, sweep.png (one or two axes), and for an axis of
        seeds seeds.csv (median, quartiles, least and largest of each number).
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("sweep", sweep, locals())


def order(
    *,
    alpha: float = 1.5,
    beads: int = 6,
    integrators: str | Sequence[str] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Measure the order of every method through contacts.

    Compares methods that step across contacts, land on them, correct for them, or integrate in a
    regularised variable. Measures errors of the state and of its derivative with respect to the
    initial state, and prints their slopes beside the orders of theory.

    Parameters
    ----------
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 0.5 to 10.
    beads : int
        Number of beads of the chain. From 2 to 1000.
    integrators : str | Sequence[str]
        Integrators, separated by commas, or all [default: all]. Each is run in all modes that it
        has.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: order.json, order-state.png, order-tangent.png;
        order.npz with an array TABLE.COLUMN for each column of slopes.csv: mode, method, quantity,
        slope (of log error against log steps), slope_theory (the slope by theory), most_steps (of
        the finest run), least_error (of the finest run, the largest of a component at the end).
        order.csv: method, mode (how it meets contacts), quantity (state, or tangent: its derivative
        by the initial state), slope (order that it shows), slope_theory (the slope by theory),
        steps, error (largest error of a component at the end). order.store keeps every point as
        soon as it is computed; the same command resumes from it. The pictures are order-state.png
        and order-tangent.png.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study order", order, locals())


def bands(
    scene: Scene | Chain | str = "precompressed",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    points: int = 101,
    dimensionless: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute the bands of a scene: the frequencies of its linear waves.

    Finds the cell of beads that repeats along the chain, and computes the frequencies of the waves
    of the infinite chain, resonators included, about its equilibrium: over the phase theta from a
    cell to the next, the edges of the bands and the gaps between them.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. A cell of beads, found by the program, repeats
        between the ends, and contacts have a static overlap. Damping and drives do not matter;
        `[initial]` may be left out. Gravity is refused.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    points : int
        Number of points. Wave numbers, equally spaced from 0 to the edge of the zone. From 2 to
        10000.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: bands.json, bands.png; bands.npz with an array
        TABLE.COLUMN for each column of band-edges.csv: band, omega_from (lowest frequency),
        omega_to (highest frequency), omega_gap (width of the gap above, to the next band).
        bands.csv: theta_over_pi (phase from a cell to the next, over pi), omega_1 (frequency of the
        first band, and so on). envelopes.csv: band, theta_over_pi, group_velocity (of envelopes, in
        beads per unit of time), dispersion (second derivative of the frequency by theta),
        nonlinearity (beta d^2 of i A_t + dispersion/2 A_xx + beta |A|^2 A = 0, with the static
        overlap d and displacements 2 |A|), focusing (whether dispersion times nonlinearity is
        positive: envelopes are bright).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study bands", bands, locals())


def modes(
    scene: Scene | Chain | str = "defect",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    dimensionless: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute the linear modes of a scene.

    Frequencies, participation numbers and shapes of all linear modes of the finite chain about its
    static state, resonators included, also of modes with the same frequency.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. Its contacts hold every bead at rest: a static
        overlap, between walls or on a ring. Damping does not matter; a bead that a drive moves is
        held. `[initial]` may be left out.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: modes.json, modes.png; modes.npz with an array
        TABLE.COLUMN for each column of linear-modes.csv: mode (number by frequency), omega
        (frequency), participation (number of sites that take part), site (of the bead or resonator
        that moves most), resonator (whether that is a resonator). mode-shapes.csv: site, resonator
        (whether the row is that of its resonator), mode_1 (displacement in the first mode, 1 where
        it moves most, and so on).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study modes", modes, locals())


def response(
    scene: Scene | Chain | str = "granular-crystal",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    site: int | None = None,
    kind: Literal["moved", "pushed"] | None = None,
    at: int | Sequence[int] | None = None,
    from_: float = 0,
    to: float | None = None,
    points: int = 401,
    dimensionless: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute the linear response of a scene to a drive at one site.

    Gain and phase of chosen beads over the frequency of the drive, with damping, about the static
    state of the finite chain.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. Its contacts hold every bead at rest: a static
        overlap, between walls or on a ring. Damping counts. `[initial]` may be left out.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    site : int
        Site that is driven [default: that of the scene's first drive, or 0].
    kind : Literal["moved", "pushed"]
        Whether the site is moved or pushed [default: as by the scene's first drive, or pushed].
        moved: the response is a displacement over that of the driven bead. pushed: it is a
        displacement over the force. Other beads that drives of the scene move are held.
    at : int | Sequence[int]
        Sites whose responses are computed, separated by commas [default: the last that no drive
        moves].
    from_ : float
        First frequency omega. Finite and at least 0.
    to : float
        Last frequency omega [default: 1.2 times that of the highest mode]. In rad/s for scenes with
        `[units]`, as `from_`. From 1e-100 to 1e100.
    points : int
        Number of points. Frequencies, equally spaced. From 2 to 100000.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: response.json, response.png; response.npz with an
        array TABLE.COLUMN for each column of response.csv: omega, gain_9 (amplitude of the
        displacement over that of the driven bead, and so on), phase_9 (phase ahead of the drive, in
        radians).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study response", response, locals())


def drift(
    scene: Scene | Chain | str = "bright-breather-16",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    periods: float = 1e4,
    integrators: str | Sequence[str] = ("collocation", "corrected", "strang-linear", "yoshida4-linear"),
    samples: int = 200,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Measure how the energy error grows with time.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    periods : float
        Length of the longest run, in periods. All runs have this length, in periods of the scene.
        From 1 to 1e9.
    integrators : str | Sequence[str]
        Integrators, separated by commas, or all.
    samples : int
        Number of sample times. Spaced evenly in the logarithm of time. From 2 to 100000.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: drift.json, drift.png; drift.npz with an array
        TABLE.COLUMN for each column of methods.csv: integrator, setting, early_error (largest |E(t)
        - E(0)| / |E(0)| up to 1 % of the time), last_error (the same up to the end), slope (of the
        logarithm of the error against that of t), wall (wall time, in seconds), steps, rejected
        (rejected steps), force_evaluations, failure. drift.csv: integrator, setting, t (time),
        energy_error (largest |E - E(0)| / |E(0)| up to t). drift.store keeps every point as soon as
        it is computed; the same command resumes from it.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study drift", drift, locals())


def stability(
    scene: Scene | Chain | str | None = None,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    charts: str | Sequence[str] | None = None,
    integrators: str | Sequence[str] | None = None,
    periods: float = 1e4,
    work: float = 4e6,
    sites: int = 100000,
    quick: bool = False,
    dimensionless: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Chart the stability of the integrators over extreme chains.

    Varies the mass ratio, the stiffness and the exponent of contacts, and the length of the chain
    and of the run. A point is one method on one variant of the chain: stable, drifting or lost (its
    energy error exceeds 1, or the run failed), its energy error, the largest steps that keep the
    error below 1e-3 and below 1e-6, and their cost.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The chain and the state that are varied [default:
        four spheres between walls, kappa = 1, rho = 1/3, amplitude 1].
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    charts : str | Sequence[str]
        Charts, separated by commas [default: all]. The charts are light (mass ratios), stiffness
        (amplitudes and spring constants), alpha (exponents), length (numbers of beads) and time
        (lengths of runs).
    integrators : str | Sequence[str]
        Integrators, separated by commas, or all [default: all].
    periods : float
        Length of the longest run, in periods. For the chart `time`, in contact periods 2 pi/sqrt(2
        alpha A^(alpha-1)). From 1 to 1e6.
    work : float
        Largest work of a run while a step is searched for. In force evaluations times sites. From
        1e4 to 1e12.
    sites : int
        Number of sites. Length of the longest chain in the chart `length`. From 1 to 1000000.
    quick : bool
        Compute fewer points. At most a third of the points of light, stiffness and alpha.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: stability.json, light.png, stiffness.png,
        alpha.png, length.png, time.png; stability.npz with an array TABLE.COLUMN for each column of
        light-errors.csv: integrator, h_omega (step above which the energy has no bound, at the
        lightest), h_contact (the same times Omega_c over the fast frequency). light.csv:
        integrator, rho, contact_frequency (Omega_c), fast_frequency (frequency of the fastest
        motion), span (length of the runs), verdict (at the usual step or tolerance), energy_error
        (the same), step (the usual step), cost (force evaluations a unit of time), step_1e-3
        (largest step with an energy error below 1e-3), cost_1e-3 (its cost), step_1e-6 (largest
        step with an energy error below 1e-6), cost_1e-6 (its cost), stability_limit (limit of
        stability of the step times the fast frequency), why (why nothing was measured, or why the
        run failed). light-ladder.csv: integrator, rho, step (the mean one for adaptive methods),
        tol (tolerance), h_fast (step times the fast frequency), verdict (stable, drifting, lost or
        dear), energy_error (largest |H - H(0)|/|H(0)|), cost (force evaluations a unit of time).
        stiffness-errors.csv: integrator. stiffness.csv: integrator, amplitude, kappa,
        contact_frequency (Omega_c), fast_frequency (frequency of the fastest motion), span (length
        of the runs), verdict (at the usual step or tolerance), energy_error (the same), step (the
        usual step), cost (force evaluations a unit of time), step_1e-3 (largest step with an energy
        error below 1e-3), cost_1e-3 (its cost), step_1e-6 (largest step with an energy error below
        1e-6), cost_1e-6 (its cost), stability_limit (limit of stability of the step times the fast
        frequency), why (why nothing was measured, or why the run failed). stiffness-ladder.csv:
        integrator, amplitude, kappa, step (the mean one for adaptive methods), tol (tolerance),
        h_fast (step times the fast frequency), verdict (stable, drifting, lost or dear),
        energy_error (largest |H - H(0)|/|H(0)|), cost (force evaluations a unit of time).
        alpha-errors.csv: integrator. alpha.csv: integrator, alpha, contact_frequency (Omega_c),
        fast_frequency (frequency of the fastest motion), span (length of the runs), verdict (at the
        usual step or tolerance), energy_error (the same), step (the usual step), cost (force
        evaluations a unit of time), step_1e-3 (largest step with an energy error below 1e-3),
        cost_1e-3 (its cost), step_1e-6 (largest step with an energy error below 1e-6), cost_1e-6
        (its cost), stability_limit (limit of stability of the step times the fast frequency), why
        (why nothing was measured, or why the run failed). alpha-ladder.csv: integrator, alpha, step
        (the mean one for adaptive methods), tol (tolerance), h_fast (step times the fast
        frequency), verdict (stable, drifting, lost or dear), energy_error (largest |H -
        H(0)|/|H(0)|), cost (force evaluations a unit of time). length-errors.csv: integrator.
        length.csv: integrator, sites, contact_frequency (Omega_c), fast_frequency (frequency of the
        fastest motion), span (length of the runs), verdict (at the usual step or tolerance),
        energy_error (the same), step (the usual step), cost (force evaluations a unit of time),
        step_1e-3 (largest step with an energy error below 1e-3), cost_1e-3 (its cost), step_1e-6
        (largest step with an energy error below 1e-6), cost_1e-6 (its cost), stability_limit (limit
        of stability of the step times the fast frequency), why (why nothing was measured, or why
        the run failed). length-ladder.csv: integrator, sites, step (the mean one for adaptive
        methods), tol (tolerance), h_fast (step times the fast frequency), verdict (stable,
        drifting, lost or dear), energy_error (largest |H - H(0)|/|H(0)|), cost (force evaluations a
        unit of time). time-errors.csv: integrator. time.csv: integrator, periods, contact_frequency
        (Omega_c), fast_frequency (frequency of the fastest motion), span (length of the runs),
        verdict (at the usual step or tolerance), energy_error (the same), step (the usual step),
        cost (force evaluations a unit of time), step_1e-3 (largest step with an energy error below
        1e-3), cost_1e-3 (its cost), step_1e-6 (largest step with an energy error below 1e-6),
        cost_1e-6 (its cost), stability_limit (limit of stability of the step times the fast
        frequency), why (why nothing was measured, or why the run failed). time-ladder.csv:
        integrator, periods, step (the mean one for adaptive methods), tol (tolerance), h_fast (step
        times the fast frequency), verdict (stable, drifting, lost or dear), energy_error (largest
        |H - H(0)|/|H(0)|), cost (force evaluations a unit of time). regimes.csv: chart, regime,
        integrator_1e-3, h_fast_1e-3, cost_1e-3, integrator_1e-6, h_fast_1e-6, cost_1e-6.
        stability.store keeps every point as soon as it is computed; the same command resumes from
        it. A chart has pictures of its own, CHART.png.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study stability", stability, locals())


def theorem(
    *,
    alpha: float = 1.5,
    horizon: float = 1,
    rho_law: str = "eps^-2(alpha-1)",
    initial: Literal["site", "bond", "generic"] = "bond",
    c_i: float = 0,
    seed: int | None = None,
    epsilons: float | Sequence[float] = (0.1, 0.01, 0.001, 1e-4, 1e-5, 1e-6),
    sites: int | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Test Theorem 1 of the paper by numerical experiment.

    Does the DpS equation describe the chain with heavy resonators as well, and for as long, as the
    theorem says? Runs the chain with kappa = 1 and free ends at each epsilon, takes the suprema
    over 0 <= t <= T epsilon^(1-alpha) of the four errors (estimu), (estimv) in l_1, l_2 and l_inf
    over samples, divides them by epsilon^alpha (u with u', v) and epsilon^(2 alpha-1) (v'), and
    gives the local slopes d ln sup / d ln epsilon. Exit code 1 if the outcome contradicts the
    theorem: its law of rho, and the verdict "violated".

    Parameters
    ----------
    alpha : float
        Exponent of the contact force; 1.5 for spheres. For breathers from 1.01. Above 1 and at most
        10.
    horizon : float
        T: runs end at t = T epsilon^(1-alpha), at most 1e8. The horizon of the theorem in units of
        the slow time. Above 0 and at most 1000.
    rho_law : str
        Law of the mass ratio, or a number for all epsilon. eps^-2(alpha-1), the smallest ratio that
        the theorem allows; eps^-(alpha-1), which is smaller; or one number for all epsilon, inf for
        Newton's cradle.
    initial : Literal["site", "bond", "generic"]
        Initial amplitudes A(0) of the DpS equation. A breather about a bond or a site, or (xi_n + i
        eta_n) e^(-n^2/4) with random xi_n, eta_n in (-1, 1).
    c_i : float
        C_i: departure of the initial state from the ansatz. The departure has a random direction
        and lies on the boundary of the set (condciu), (condciv) in l_1, and so inside it in all
        norms. 0: the run starts exactly on the ansatz. Finite and at least 0.
    seed : int
        Seed of the random numbers [default: 1]. They give a generic A(0) and the direction of the
        departure from the ansatz.
    epsilons : float | Sequence[float]
        Sizes epsilon of the oscillation, separated by commas [default: decades from 0.1 to 1e-6].
        In any order. Each is above 0 and below 1.
    sites : int
        Number of sites [default: the sites where A(0) is above 1e-16 of its largest value; for
        generic: 21]. At least the default, up to 1000.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: theorem.json, theorem.png; theorem.npz with an
        array TABLE.COLUMN for each column of theorem.csv: epsilon, rho, norm, u_error (supremum of
        the error of u over 0 <= t <= T epsilon^(1-alpha)), v_error (supremum of the error of v over
        0 <= t <= T epsilon^(1-alpha)), vdot_error (supremum of the error of vdot over 0 <= t <= T
        epsilon^(1-alpha)), u_scaled (supremum over 0 <= t <= T epsilon^(1-alpha) of the error of u,
        over epsilon^1.5), v_scaled (supremum over 0 <= t <= T epsilon^(1-alpha) of the error of v,
        over epsilon^1.5), vdot_scaled (supremum over 0 <= t <= T epsilon^(1-alpha) of the error of
        vdot, over epsilon^2), sampling_error (largest share of a supremum that samples may miss), t
        (end of the run), samples (number of samples), windows (windows of the integrator).
        slopes.csv: from, to (local slope between two sizes), u_1, u_2, u_inf, v_1, v_2, v_inf,
        vdot_1, vdot_2, vdot_inf. limits.csv: norm, quantity, theory (power of the theorem),
        expected (power of its proof at this law of rho), limit (limit of the local slopes),
        limit_uncertainty (its uncertainty), verdict. theorem.store keeps every point as soon as it
        is computed; the same command resumes from it. theorem.txt has what is printed.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study theorem", theorem, locals())


def lifetimes(
    *,
    epsilons: float | Sequence[float] = (0.001, 0.003, 0.01, 0.03, 0.1),
    rhos: float | Sequence[float] = (10, 100, 1000, 1e4, 1e5),
    alpha: float = 1.5,
    center: Literal["site", "bond"] = "bond",
    sites: int | None = None,
    until: float | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Measure how long bright breathers live, over size and mass ratio.

    Runs the chain from the breather u(0) = 2 epsilon a at every size epsilon and every mass ratio
    rho.

    A life ends when the core, the fewest sites that hold 0.999 of the sum of a_n^2, has less than
    0.9 of the energy; where it does not before the cap (`until`), the table says: not before t.

    Each point has a fate. `radiates`: the core falls below 0.9 of the energy while its bonds are
    closed at least 1/3 of the time. `decouples`: before that, bonds of the core come to be closed
    less than 1/3 of the time: gaps open, each site oscillates on its own, and the energy stays.
    `persists`: neither before the cap.

    A larger map computes only what is new.

    Parameters
    ----------
    epsilons : float | Sequence[float]
        Sizes epsilon of the oscillation, separated by commas. Displacements start at 2 epsilon a_n.
        Each is named once. Each is above 0 and below 1.
    rhos : float | Sequence[float]
        Mass ratios resonator to bead, separated by commas. Each is named once. Each is finite and
        positive.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    center : Literal["site", "bond"]
        What the profile is symmetric about.
    sites : int
        Number of sites. Length of every chain. By default it is doubled from 100 on, up to 25600,
        until no wave comes back from the ends. From 20 to 100000.
    until : float
        End time, in units of time [default: for each breather 25 times the theorem's time scale, T
        epsilon^(1-alpha)]. No breather is followed longer. Finite and positive.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: lifetimes.json, lifetimes.png; lifetimes.npz with
        an array TABLE.COLUMN for each column of lifetimes.csv: epsilon, rho, lifetime (until the
        core has less than 0.9 of the energy), not_before (end of the run, where it lives longer),
        fate, end (time until which it was followed), decoupled (time at which contact fell below
        1/3), core_share (share of the energy in the core, at the end), contact (share of the last
        ten periods in which a bond of the core is closed), x (rho epsilon^(2(alpha-1))), horizon (T
        epsilon^(1-alpha)), omega_b (frequency of the ansatz), sites (sites of the chain), ends_felt
        (time from which the ends of the chain may be felt), failure. lifetimes.store keeps every
        point as soon as it is computed; the same command resumes from it.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("study lifetimes", lifetimes, locals())


def wave(
    scene: Scene | Chain | str,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    zeta: float | None = None,
    seed: int | None = None,
    seeds: int | None = None,
    integrator: str = "collocation",
    tol: float = 1e-10,
    samples_per_period: int = 50,
    until: float | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Travelling waves, their stability, exact waves and solitary waves.

    Without a subcommand: runs the travelling wave of a scene on the chain and compares it with its
    first-order ansatz; with a perturbation (`zeta`) it shows whether the wave is stable. `wave
    modulation` computes how fast modulations of the wave grow, `wave exact` the exact wave beside
    the ansatz.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have an initial state of kind
        travelling-wave.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    zeta : float
        Perturb each amplitude by up to this share [default: the scene's]. The share bounds the
        changes of the real and of the imaginary part of each amplitude. From 0 (no perturbation) to
        below 1.
    seed : int
        Seed of the random numbers [default: the scene's, else 1]. They perturb the wave.
    seeds : int
        Number of perturbed waves, from that seed on [default: 1]. They run on all cores and give
        the spread of the growth. From 1 to 10000.
    integrator : str
        Integrator; `hertzchain integrators` lists all. Only integrators that take a tolerance.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. This is for collocation; dop853 aims at an error of
        T a step. From 1e-15 to 0.1.
    samples_per_period : int
        Samples per period, from which largest values are taken. Per period of the wave; the end of
        the run is one of them. From 2 to 1000.
    until : float
        End time, in units of time [default: the scene's]. From 1e-100 to 1e100.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: wave.json, wave.png; wave.npz with an array
        TABLE.COLUMN for each column of summary.csv: error, at_the_end (in percent of the
        amplitude), largest (of all samples, in percent of the amplitude). errors.csv: t, e_x (E_x),
        e_y (E_y), e_x_perturbed (E_x of the perturbed wave), e_y_perturbed (E_y of it), tilde_e_x
        (tilde E_x), tilde_e_y (tilde E_y). profile.csv: n (site), x (strain of the bead at the
        end), y (of the resonator), x_ansatz (strains of beads by the ansatz), y_ansatz (of
        resonators), x_perturbed (strains of beads of the perturbed wave), y_perturbed (of its
        resonators), x_perturbed_ansatz (strains of beads by its ansatz), y_perturbed_ansatz (of
        resonators). ensemble.csv: seed (the seed), growth_x (growth of tilde E_x; none for runs
        shorter than two periods), growth_y (growth of tilde E_y), rate (exponential rate of tilde
        E_x, per unit of time; none for runs shorter than eight periods), rate_residual (largest
        distance of the logarithms from the line of that slope: well below the rise along the line
        where growth is exponential). spread.csv: t, x_low (least tilde E_x of the seeds), x_lower
        (quartile), x_median, x_upper (quartile), x_high (largest), y_low (least tilde E_y of the
        seeds), y_lower (quartile), y_median, y_upper (quartile), y_high (largest). growth.csv:
        quantity (growth: largest of the last period over largest of the first; rate: slope of
        ln(largest of each period) over the second half, per unit of time; misfit: its largest
        distance from the line), lowest, lower_quartile, median, upper_quartile, highest.
        ensemble.store keeps every point as soon as it is computed; the same command resumes from
        it. envelope.csv, ensemble.csv, spread.csv and growth.csv are those of perturbed waves. The
        points of the store are the seeds of `seeds`.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("wave", wave, locals())


def wave_modulation(
    scene: Scene | Chain | str | None = None,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    a: float = 1,
    b: float = 1,
    q_over_pi: float = 0.2,
    epsilon: float | Sequence[float] = (0.01,),
    sites: int = 50,
    measure: bool = False,
    modes: int = 12,
    chart: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Compute which modulations of a wave grow, and how fast.

    Growth rates against the wave number of the modulation, in closed form; with `measure` also
    those measured on the full chain.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have an initial state of kind
        travelling-wave. All numbers of the wave are taken from it, in place of the flags.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. Above 0 and at most 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Above 0; inf for Newton's cradle (its DpS equation), with `b`
        0.
    a : float
        Amplitude of the wave. Finite and positive.
    b : float
        Mean strain. Mean strain b of the wave, in the units of the modulation equations; below 2
        kappa a.
    q_over_pi : float
        Wave number over pi, with a whole number of waves on the ring. From -1 to 1.
    epsilon : float | Sequence[float]
        Sizes of the wave, separated by commas. Rates per unit of time are computed for the first
        size. With `measure`, growth is measured at each of them. Each is above 0 and below 1.
    sites : int
        Number of sites. Length of the ring; with `measure` at most 1000. From 2 to 10000.
    measure : bool
        Measure the growth on the full chain as well.
    modes : int
        Number of wave numbers at which growth is measured. They are spread over the wave numbers of
        the ring; that of the fastest growth is added. At least 1.
    chart : bool
        Chart the fastest growth over wave number and mean strain as well.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: stability.json, dps-growth.png; stability.npz with
        an array TABLE.COLUMN for each column of stability.csv: p (wave number of the modulation),
        p_over_pi (wave number of the modulation, over pi), growth (Re lambda), frequency (Im
        lambda), growth_t (growth per unit of time), growth_period (growth per period of the wave).
        measured.csv: epsilon (size of the wave), p (wave number of the modulation), p_over_pi,
        growth (Re lambda, measured on the full chain), growth_theory (of the linearised modulation
        equations), deviation (of the growth from theory, in percent), frequency (Im lambda,
        measured), frequency_theory (of the linearised modulation equations), residual (largest
        deviation of the logarithm of the mode from the line). chart.csv: q (wave number of the
        wave), b (its mean strain), growth (growth of the fastest mode, per slow time). growth.store
        keeps every point as soon as it is computed; the same command resumes from it. The picture
        is dps-growth.png. measured.csv and the store come with `measure`, chart.csv with `chart`.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("wave modulation", wave_modulation, locals())


def wave_exact(
    scene: Scene | Chain | str | None = None,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    q_over_pi: float | None = None,
    omega_tw: float | None = None,
    amplitude: float | None = None,
    mean: float | None = None,
    rho: float | None = None,
    sites: int | None = None,
    tol: float = 1e-14,
    prove: bool = False,
    certificate: str | os.PathLike[str] | None = None,
    to_zero: bool = False,
    modulation: float | Sequence[float] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute an exact periodic travelling wave.

    It has the frequency (or the amplitude) and the mean strain of a wave of the modulation
    equations. Prints its profile, its Fourier coefficients, its distance from that first-order
    ansatz, and its relative multipliers for each Bloch wave number.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have an initial state of kind
        travelling-wave. Numbers of the wave that no flag gives are taken from it [default: tw-q15].
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    q_over_pi : float
        Wave number over pi, with a whole number of waves on the ring. Above 0 and at most 1.
    omega_tw : float
        Frequency of the wave, in radians per unit of time. Above omega = sqrt(kappa (1 + 1/rho)),
        or below sqrt(kappa/rho).
    amplitude : float
        Height of the crest above the mean strain, in place of the frequency. Finite and positive.
    mean : float
        Mean strain [default: in proportion to the amplitude, as in the scene]. A finite number.
    rho : float
        Mass ratio resonator to bead [default: the scene's]. At least 0: 0 for no resonators, inf
        for fixed ones (Newton's cradle). Unless a frequency is given, the wave has the amplitude of
        the scene's wave. With fixed resonators its mean strain is 0.
    sites : int
        Number of sites [default: the scene's]. The multipliers are computed for a ring of this
        length, from 3 to 256.
    tol : float
        Tolerance. The flow over a relative period aims at errors whose sum is at most T. From 1e-15
        to 1e-12 for an exact wave.
    prove : bool
        Prove that the solution exists, by interval arithmetic. It is proved for the exact decimals
        and fractions of the parameters (1/3 for the double nearest to it), about a cosine sum near
        the computed solution. Of a branch in its frequency one curve of solutions is proved, piece
        by piece; the mean strain is linear between its points, and proof.store has the pieces as
        they are proved, from which the same command goes on; without multipliers they are the
        points of `shard` and `engine`. Where it can, `wave exact` also encloses the rate of the
        perturbation that grows fastest, `breather dark` and `breather doubled`, which proves its
        last orbit, a real Floquet multiplier above 1, and `breather continue --center bond` with
        `bifurcations` the frequencies at which the period doubles. Exit code 1 if existence is not
        proved, or not of the whole branch.
    certificate : str | os.PathLike[str]
        Write the certificate of the proof to this file. `hertzchain prove` checks it again. Folders
        that are missing are made.
    to_zero : bool
        Prove the branch down to amplitude zero, where it has the limit of the DpS equation. From
        the wave or the breather, or from the end of the branch with the lower frequency. The mean
        strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps <= eps_0 there
        is a solution within C eps^alpha of the one of the DpS equation with the first harmonic eps.
    modulation : float | Sequence[float]
        Prove that a perturbation grows at all Bloch wave numbers over pi between these two. Also
        proves bounds of the largest growth rate of these. The proof goes in pieces from multipliers
        of the ring, and fails where growth ends. It takes the place of the proof for the multiplier
        that grows fastest. Each is above 0 and at most 1.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: exact.json, exact.png; exact.npz with an array
        TABLE.COLUMN for each column of exact.csv: q_over_pi (wave number over pi), alpha, kappa,
        rho, omega_tw (frequency), period (2 pi/omega_tw), amplitude (height of the crest above the
        mean strain), mean_strain (mean of the strains over a period), residual (of Newton's method,
        over the amplitude). profile.csv: phi (phase), phi_over_pi (the same over pi), x (strain X
        of beads), y (strain Y of resonators), x_apart (X less that of the ansatz, in percent of its
        amplitude), y_apart (the same of Y). fourier.csv: k (harmonic), x (coefficient f_k of X), y
        (the same of Y), share (|f_k|/f_1 of X), law (k^-(alpha + 3)). growth.csv: bloch (Bloch wave
        number), bloch_over_pi (Bloch wave number over pi), exact (largest growth of the wave, per
        unit of time), modulation (the same by the linearised modulation equations), factor (growth
        of the wave in a period). multipliers.csv: bloch (Bloch wave number), re (real part of the
        multiplier), im (imaginary part), modulus (absolute value), error (estimated error of the
        modulus), krein (Krein signature on the circle, 0 elsewhere), growth (per unit of time),
        frequency (in radians per unit of time), kind (where it lies). exact-wave.npz has the wave,
        from which `wave continue --resume` goes on. stalled.json, in place of all files, with the
        best iterate of a search that did not converge.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("wave exact", wave_exact, locals())


def wave_continue(
    scene: Scene | Chain | str | None = None,
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    q_over_pi: float | None = None,
    omega_tw: float | None = None,
    amplitude: float | None = None,
    mean: float | None = None,
    rho: float | None = None,
    sites: int | None = None,
    tol: float = 1e-14,
    vary: Literal["omega_tw", "amplitude", "mean", "rho", "kappa", "alpha"] = "omega_tw",
    to: float | None = None,
    step: float | None = None,
    max_points: int = 1000,
    multipliers: bool | None = None,
    prove: bool = False,
    certificate: str | os.PathLike[str] | None = None,
    to_zero: bool = False,
    resume: str | os.PathLike[str] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Follow a branch of exact travelling waves.

    Varies one parameter of the wave or of the chain, past folds. Waves keep their ratio of mean
    strain to amplitude unless a mean strain is given. Exit code 1 if the branch is lost before its
    end.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have an initial state of kind
        travelling-wave. Numbers of the wave that no flag gives are taken from it [default: tw-q15].
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    q_over_pi : float
        Wave number over pi, with a whole number of waves on the ring. Above 0 and at most 1.
    omega_tw : float
        Frequency of the wave, in radians per unit of time. Above omega = sqrt(kappa (1 + 1/rho)),
        or below sqrt(kappa/rho).
    amplitude : float
        Height of the crest above the mean strain, in place of the frequency. Finite and positive.
    mean : float
        Mean strain [default: in proportion to the amplitude, as in the scene]. A finite number.
    rho : float
        Mass ratio resonator to bead [default: the scene's]. At least 0: 0 for no resonators, inf
        for fixed ones (Newton's cradle). Unless a frequency is given, the wave has the amplitude of
        the scene's wave. With fixed resonators its mean strain is 0.
    sites : int
        Number of sites [default: the scene's]. The multipliers are computed for a ring of this
        length, from 3 to 256.
    tol : float
        Tolerance. The flow over a relative period aims at errors whose sum is at most T. From 1e-15
        to 1e-12 for an exact wave.
    vary : Literal["omega_tw", "amplitude", "mean", "rho", "kappa", "alpha"]
        What varies along the branch. A parameter of the wave or of the chain.
    to : float
        Value of the parameter at which the branch ends. It begins with that of the scene or of
        other options. A finite number.
    step : float
        Largest change of the parameter from point to point. By default a twentieth of the range, of
        dark breathers a hundredth. Finite and positive.
    max_points : int
        Points of the branch at most. With those of a branch that is resumed. At least 2.
    multipliers : bool
        Compute multipliers, or not (=false). On by default where they take less time than the
        orbits: not of dark breathers.
    prove : bool
        Prove that the solution exists, by interval arithmetic. It is proved for the exact decimals
        and fractions of the parameters (1/3 for the double nearest to it), about a cosine sum near
        the computed solution. Of a branch in its frequency one curve of solutions is proved, piece
        by piece; the mean strain is linear between its points, and proof.store has the pieces as
        they are proved, from which the same command goes on; without multipliers they are the
        points of `shard` and `engine`. Where it can, `wave exact` also encloses the rate of the
        perturbation that grows fastest, `breather dark` and `breather doubled`, which proves its
        last orbit, a real Floquet multiplier above 1, and `breather continue --center bond` with
        `bifurcations` the frequencies at which the period doubles. Exit code 1 if existence is not
        proved, or not of the whole branch.
    certificate : str | os.PathLike[str]
        Write the certificate of the proof to this file. `hertzchain prove` checks it again. Folders
        that are missing are made.
    to_zero : bool
        Prove the branch down to amplitude zero, where it has the limit of the DpS equation. From
        the wave or the breather, or from the end of the branch with the lower frequency. The mean
        strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps <= eps_0 there
        is a solution within C eps^alpha of the one of the DpS equation with the first harmonic eps.
    resume : str | os.PathLike[str]
        Go on with what this file, or the file in this folder, has kept. A file of a branch, from
        its last point: to another `to`, by another `step`; then multipliers and bifurcations are
        computed anew. The results are written beside it unless `out` says where.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: waves.json, waves.png; waves.npz with an array
        TABLE.COLUMN for each column of waves.csv: parameter (what varies), q_over_pi (wave number
        over pi), alpha, kappa, rho, omega_tw (frequency), period (2 pi/omega_tw), amplitude (height
        of the crest above the mean strain), mean_strain (mean of the strains over a period),
        residual (of Newton's method, over the amplitude), growth (largest growth, per unit of
        time), bloch (its Bloch wave number), growing (multipliers that grow), modulation (largest
        growth by the linearised modulation equations), e_x_ansatz (error of the ansatz, beads),
        e_y_ansatz (error of the ansatz, resonators), closed (share of the period in which a contact
        is closed). wave-branch.npz has every orbit, and is written every 20 points or 10 s as well.
        stalled.json is there, in place of all files, if there is no first wave. wave-spectra.store
        has what was found about them, from which the same command goes on. Each part of `shard`
        follows the branch itself and computes its share of this.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("wave continue", wave_continue, locals())


def wave_solitary(
    *,
    alpha: float = 1.5,
    kappa: float = 1,
    speed: float | None = None,
    rhos: float | Sequence[float] | None = None,
    sites: int = 20,
    tol: float = 1e-14,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Compute solitary waves, and their tails where resonators move.

    The pulse of the chain without resonators, as an exact wave of a ring and on the infinite line,
    and how its overlap decays from the crest; and how strong a wake a pulse leaves in chains with
    light resonators. Exit code 1 if a wave is not found.

    Parameters
    ----------
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.2 to 5.
    kappa : float
        Spring constant of the resonators. From 1e-100 to 1e100.
    speed : float
        Speed of the pulses, in sites per unit of time [default: that of the pulse of overlap 1
        without resonators]. From 1e-3 to 1e3.
    rhos : float | Sequence[float]
        Mass ratios resonator to bead, separated by commas [default: ratios with omega/speed from
        1.5 pi to 3.6 pi]. Each is from 1e-6 to 100.
    sites : int
        Number of sites. Length of the ring. A pulse with tails is computed on a ring that is up to
        three sites longer, the one that is farthest from resonance with the tails. From 8 to 60.
    tol : float
        Tolerance. The flow over a relative period aims at errors whose sum is at most T. From 1e-15
        to 1e-12 for an exact wave.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: solitary.json, solitary.png; solitary.npz with an
        array TABLE.COLUMN for each column of pulse.csv: n (sites from the crest), g (overlap over
        that of the crest), double_log (ln|ln g|). tails.csv: rho (mass ratio), k_over_2pi (phase of
        a resonator from site to site, k = omega/c), k (k = omega/c), sites (length of the ring),
        crest (largest overlap g), residual (of the search), tail (amplitude of the tail), wake
        (amplitude W that a passage leaves behind), wake_of_line (the same of the pulse whose
        resonators follow their beads), wake_share (wake over crest), wake_share_of_line (wake of
        the line over crest). solitary.store keeps every point as soon as it is computed; the same
        command resumes from it.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("wave solitary", wave_solitary, locals())


def breather_bright(
    *,
    center: Literal["site", "bond"] = "bond",
    epsilon: float = 0.01,
    rho: float = 1000,
    alpha: float = 1.5,
    kappa: float = 1,
    sites: int = 40,
    boundary: Literal["free", "fixed", "left-wall", "right-wall", "ring"] = "free",
    until: float | None = None,
    samples_per_period: int = 20,
    integrator: str = "collocation",
    tol: float = 1e-10,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Run a long-lived bright breather and compare it with its ansatz.

    The chain starts from a breather of the modulation (DpS) equation. Prints how far the chain
    departs from this ansatz, and how much of the energy stays in the core.

    Parameters
    ----------
    center : Literal["site", "bond"]
        What the profile is symmetric about. A site (solution a^1), or a bond (solution a^2), as in
        the paper's run.
    epsilon : float
        Size of the breather: beads start at 2 epsilon a_n. From 1e-100 to 1e100.
    rho : float
        Mass ratio resonator to bead. Above 0; inf for resonators that stay at rest.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    sites : int
        Number of sites. At most a share of 10^-6 of the breather may lie beyond the ends. The
        middle of the chain is a bond if the number is even, a site if it is odd.
    boundary : Literal["free", "fixed", "left-wall", "right-wall", "ring"]
        Boundary condition at the ends of the chain.
    until : float
        End time, in units of time [default: 80 T]. T = 2 pi/omega_0 in units of 1/sqrt(kappa) is
        the period of the envelope in slow time. The run has at most 10^7 samples.
    samples_per_period : int
        Samples per period, from which largest values are taken. Per period T_b of the breather. The
        time at which energy has left the core is also found from them. From 1 to 1000.
    integrator : str
        Integrator; `hertzchain integrators` lists all. Only integrators that take a tolerance.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. This is for collocation; dop853 aims at an error of
        T a step. From 1e-15 to 0.1.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: breather.json, breather.png; breather.npz with an
        array TABLE.COLUMN for each column of norms.csv: t (time), e_u (l_1 distances from the
        ansatz (diff_u_l1norm), (diff_v_l1norm), rescaled), e_udot, e_v, e_vdot, participation ((sum
        e_n)^2 / sum e_n^2 of site energies, half of a contact's at either bead), core_share (share
        of the energy in the core), energy (of the chain). periods.csv: t (time), e_u (l_1 distances
        from the ansatz (diff_u_l1norm), (diff_v_l1norm), rescaled), e_udot, e_v, e_vdot,
        participation ((sum e_n)^2 / sum e_n^2 of site energies, half of a contact's at either
        bead), core_share (share of the energy in the core), energy (of the chain), e_u_max (largest
        since the row before), e_udot_max, e_v_max, e_vdot_max. profiles.csv: t (0, 30 T_b and the
        end), n (site), u (position of the bead), v (and of its resonator), u_ansatz (by the
        ansatz). forces.csv: bond, first_period (mean contact force over the first period),
        after_end (and over a period that begins at the end).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather bright", breather_bright, locals())


def breather_dark(
    *,
    center: Literal["site", "bond"] = "site",
    omega_b: float | None = None,
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    precompression: float = 0,
    formulation: Literal["half-period", "full-period"] = "half-period",
    tol: float = 1e-13,
    infinite: bool = False,
    prove: bool = False,
    certificate: str | os.PathLike[str] | None = None,
    to_zero: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute a dark breather as an exact periodic orbit.

    Newton's method finds the orbit on a ring; its Floquet multipliers tell whether it is stable.

    Parameters
    ----------
    center : Literal["site", "bond"]
        What the profile is symmetric about. The kink is on the site 0, or on the bond between the
        sites 0 and 1.
    omega_b : float
        Frequency of the breather, in radians per unit of time [default: 1.025 omega]. Above omega =
        sqrt(kappa (1 + 1/rho)). Under a precompression below the upper edge of a band, by default
        that at which the background has half its strain.
    sites : int
        Number of sites. The ring has an odd number of sites, n = -N .. N; about a site at least 5.
        Weak quartets of multipliers, and their number, depend on it. From 3 to 255.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    precompression : float
        Static overlap D of the contacts. The background has the vertical centre C_x = -D
        (eq:center); below 0 contacts have gaps. A finite number.
    formulation : Literal["half-period", "full-period"]
        Equations of Newton's method.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    infinite : bool
        Prove the breather of the infinite chain near that of the ring. Far from its centre it
        converges to standing waves of opposite phase, with the mean strain of the far end of the
        ring.
    prove : bool
        Prove that the solution exists, by interval arithmetic. It is proved for the exact decimals
        and fractions of the parameters (1/3 for the double nearest to it), about a cosine sum near
        the computed solution. Of a branch in its frequency one curve of solutions is proved, piece
        by piece; the mean strain is linear between its points, and proof.store has the pieces as
        they are proved, from which the same command goes on; without multipliers they are the
        points of `shard` and `engine`. Where it can, `wave exact` also encloses the rate of the
        perturbation that grows fastest, `breather dark` and `breather doubled`, which proves its
        last orbit, a real Floquet multiplier above 1, and `breather continue --center bond` with
        `bifurcations` the frequencies at which the period doubles. Exit code 1 if existence is not
        proved, or not of the whole branch.
    certificate : str | os.PathLike[str]
        Write the certificate of the proof to this file. `hertzchain prove` checks it again. Folders
        that are missing are made.
    to_zero : bool
        Prove the branch down to amplitude zero, where it has the limit of the DpS equation. From
        the wave or the breather, or from the end of the branch with the lower frequency. The mean
        strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps <= eps_0 there
        is a solution within C eps^alpha of the one of the DpS equation with the first harmonic eps.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: dark-breather.json, dark-breather.png, and tables
        with their columns: multipliers-outside.csv: re (real part), im (imaginary part), modulus,
        error (of the modulus), kind. dark-breather.npz has the orbit, for `breather evolve` and
        `breather continue --resume`.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather dark", breather_dark, locals())


def breather_continue(
    *,
    center: Literal["site", "bond"] = "site",
    vary: str = "omega_b",
    from_: float | None = None,
    step: float | None = None,
    max_points: int = 1000,
    multipliers: bool | None = None,
    bifurcations: bool | None = None,
    weak: float = 0.01,
    omega_b: float | None = None,
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    precompression: float = 0,
    formulation: Literal["half-period", "full-period"] = "half-period",
    tol: float = 1e-13,
    prove: bool = False,
    certificate: str | os.PathLike[str] | None = None,
    to_zero: bool = False,
    to: float | None = None,
    resume: str | os.PathLike[str] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Follow a branch of dark breathers in one parameter.

    Computes the Floquet multipliers of each orbit, and the bifurcations between them.

    Parameters
    ----------
    center : Literal["site", "bond"]
        What the profile is symmetric about. The kink is on the site 0, or on the bond between the
        sites 0 and 1.
    vary : str
        What varies along the branch. omega_b, rho, kappa, alpha or c_x, which is minus the
        precompression.
    from_ : float
        First value of the parameter [default for omega_b: 1.005 omega]. A finite number.
    step : float
        Largest change of the parameter from point to point. By default a twentieth of the range, of
        dark breathers a hundredth. Finite and positive.
    max_points : int
        Points of the branch at most. With those of a branch that is resumed. At least 2.
    multipliers : bool
        Compute multipliers, or not (=false). On by default where they take less time than the
        orbits: not of dark breathers.
    bifurcations : bool
        Locate bifurcations, or not (=false). They need multipliers. Not by default.
    weak : float
        Do not locate collisions of multipliers that stay below 1 + WEAK. The moduli of the
        multipliers are compared with 1 + WEAK. Finite and at least 0.
    omega_b : float
        Frequency of the breather, in radians per unit of time [default: 1.025 omega]. For branches
        in another parameter. Above omega = sqrt(kappa (1 + 1/rho)).
    sites : int
        Number of sites. The ring has an odd number of sites, n = -N .. N; about a site at least 5.
        Weak quartets of multipliers, and their number, depend on it. From 3 to 255.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    precompression : float
        Static overlap D of the contacts. The background has the vertical centre C_x = -D
        (eq:center); below 0 contacts have gaps. A finite number.
    formulation : Literal["half-period", "full-period"]
        Equations of Newton's method.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    prove : bool
        Prove that the solution exists, by interval arithmetic. It is proved for the exact decimals
        and fractions of the parameters (1/3 for the double nearest to it), about a cosine sum near
        the computed solution. Of a branch in its frequency one curve of solutions is proved, piece
        by piece; the mean strain is linear between its points, and proof.store has the pieces as
        they are proved, from which the same command goes on; without multipliers they are the
        points of `shard` and `engine`. Where it can, `wave exact` also encloses the rate of the
        perturbation that grows fastest, `breather dark` and `breather doubled`, which proves its
        last orbit, a real Floquet multiplier above 1, and `breather continue --center bond` with
        `bifurcations` the frequencies at which the period doubles. Exit code 1 if existence is not
        proved, or not of the whole branch.
    certificate : str | os.PathLike[str]
        Write the certificate of the proof to this file. `hertzchain prove` checks it again. Folders
        that are missing are made.
    to_zero : bool
        Prove the branch down to amplitude zero, where it has the limit of the DpS equation. From
        the wave or the breather, or from the end of the branch with the lower frequency. The mean
        strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps <= eps_0 there
        is a solution within C eps^alpha of the one of the DpS equation with the first harmonic eps.
    to : float
        Value of the parameter at which the branch ends. It begins with that of the scene or of
        other options. A finite number.
    resume : str | os.PathLike[str]
        Go on with what this file, or the file in this folder, has kept. A file of a branch, from
        its last point: to another `to`, by another `step`; then multipliers and bifurcations are
        computed anew. The results are written beside it unless `out` says where.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: branch.json, branch.png, and tables with their
        columns: branch.csv: omega_b, k_x (amplitude of the background, of beads), k_y (and of
        resonators), c_x (centre of the background, of beads), c_y (and of resonators), max_modulus
        (largest modulus of a multiplier), real (largest modulus of the real multipliers above 1),
        negative (of those below -1), quartet (of quartets). bifurcations.csv: kind, parameter,
        period, tau (half trace of the two multipliers that meet), omega_b. branch.npz has every
        orbit, and is written every 20 points or 10 s as well. spectra.store has what was found
        about them, from which the same command goes on. Each part of `shard` follows the branch
        itself and computes its share of this.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather continue", breather_continue, locals())


def breather_doubled(
    *,
    omega_b: float = 1.056,
    most: float | None = None,
    step: float = 0.002,
    branch: str | os.PathLike[str] | None = None,
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    precompression: float = 0,
    formulation: Literal["half-period", "full-period"] = "half-period",
    tol: float = 1e-13,
    prove: bool = False,
    certificate: str | os.PathLike[str] | None = None,
    to_zero: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Follow the branch of doubled period of dark breathers.

    The branch starts at the period doubling of the bond-centred dark breathers.

    Parameters
    ----------
    omega_b : float
        Frequency of the breather, in radians per unit of time. The frequency at which the branch of
        doubled period ends: that of the whole period, about half of the frequency of the main
        branch. Finite and positive.
    most : float
        Frequency up to which a period doubling is searched for [default: 1.05 omega]. The main
        branch is followed no further without one. Finite and positive.
    step : float
        Largest change of the frequency from point to point. On the main branch; on the doubled one
        half of it. Finite and positive.
    branch : str | os.PathLike[str]
        File branch.npz of the main branch [default: it is computed here]. A file that `breather
        continue --center bond` has written.
    sites : int
        Number of sites. The ring has an odd number of sites, n = -N .. N; about a site at least 5.
        Weak quartets of multipliers, and their number, depend on it. From 3 to 255.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    precompression : float
        Static overlap D of the contacts. The background has the vertical centre C_x = -D
        (eq:center); below 0 contacts have gaps. A finite number.
    formulation : Literal["half-period", "full-period"]
        Equations of Newton's method.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    prove : bool
        Prove that the solution exists, by interval arithmetic. It is proved for the exact decimals
        and fractions of the parameters (1/3 for the double nearest to it), about a cosine sum near
        the computed solution. Of a branch in its frequency one curve of solutions is proved, piece
        by piece; the mean strain is linear between its points, and proof.store has the pieces as
        they are proved, from which the same command goes on; without multipliers they are the
        points of `shard` and `engine`. Where it can, `wave exact` also encloses the rate of the
        perturbation that grows fastest, `breather dark` and `breather doubled`, which proves its
        last orbit, a real Floquet multiplier above 1, and `breather continue --center bond` with
        `bifurcations` the frequencies at which the period doubles. Exit code 1 if existence is not
        proved, or not of the whole branch.
    certificate : str | os.PathLike[str]
        Write the certificate of the proof to this file. `hertzchain prove` checks it again. Folders
        that are missing are made.
    to_zero : bool
        Prove the branch down to amplitude zero, where it has the limit of the DpS equation. From
        the wave or the breather, or from the end of the branch with the lower frequency. The mean
        strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps <= eps_0 there
        is a solution within C eps^alpha of the one of the DpS equation with the first harmonic eps.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: branch.json, branch.png, and tables with their
        columns: branch.csv: omega_b, k_x (amplitude of the background, of beads), k_y (and of
        resonators), c_x (centre of the background, of beads), c_y (and of resonators), max_modulus
        (largest modulus of a multiplier), real (largest modulus of the real multipliers above 1),
        negative (of those below -1), quartet (of quartets). bifurcations.csv: kind, parameter,
        period, tau (half trace of the two multipliers that meet), omega_b. multipliers-outside.csv:
        re (real part), im (imaginary part), modulus, error (of the modulus), kind. branch.npz has
        every orbit; it is written every 20 points or 10 s as well. spectra.store has multipliers,
        from which the same command goes on.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather doubled", breather_doubled, locals())


def breather_evolve(
    orbit: str | os.PathLike[str],
    *,
    point: int | None = None,
    at: float | None = None,
    until: float = 1200,
    kick: float | None = None,
    mode: int = 0,
    tol: float = 1e-13,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Run the chain from a dark breather, with or without a kick.

    A kick is along one of the modes of the orbit. After every period the run measures the return
    error, which is the distance from the orbit, and the position of the kink.

    Parameters
    ----------
    orbit : str | os.PathLike[str]
        File dark-breather.npz or branch.npz, with the orbit to start from. dark-breather.npz is
        written by `breather dark`; branch.npz by `breather continue` and `breather doubled`, and
        needs `point` or `at`.
    point : int
        Number of the point of the branch, from 0; -1 is the last one.
    at : float
        Take the point of the branch whose parameter is nearest to this value. A finite number.
    until : float
        End time, in units of time. Rounded down to whole periods of the orbit. From one period to
        10^6 of them.
    kick : float
        Size of a kick along one mode, in units of the orbit's amplitude [default: none]. The
        largest change of an entry of the initial state; of either sign, not zero, at most 1 in
        modulus.
    mode : int
        Number of the multiplier along whose eigenvector the chain is kicked. Counted from 0 in the
        order of `breather dark --json`: the largest modulus first.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: evolution.json, evolution.png; evolution.npz with
        an array TABLE.COLUMN for each column of evolution.csv: t (time), e_b (largest change of a
        strain over the largest strain (eq:relerr)), position (site of the kink), period (number of
        periods from the start). motion.csv: from, to, velocity (sites per unit of time, of a line
        fitted to the positions), misfit (largest distance of a position from the line, in sites).
        evolution-x.csv and evolution-y.csv have the largest strains in time, a column a site.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather evolve", breather_evolve, locals())


def breather_barrier(
    *,
    from_: float | None = None,
    to: float | None = None,
    frequencies: int = 19,
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    precompression: float = 0,
    formulation: Literal["half-period", "full-period"] = "half-period",
    tol: float = 1e-13,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Compute the energy barrier between site- and bond-centred dark breathers.

    The Peierls-Nabarro barrier: energies of the two kinks relative to their common background, at
    the same frequency, and at the same action and length; also their largest multipliers. Exit code
    1 if an orbit is not found.

    Parameters
    ----------
    from_ : float
        Smallest frequency of the breathers [default: 1.005 omega]. In radians per unit of time,
        above omega = sqrt(kappa (1 + 1/rho)).
    to : float
        Largest frequency of the breathers [default: 1.05 omega]. In radians per unit of time, above
        `from_`.
    frequencies : int
        Number of frequencies, equally spaced. At least 2.
    sites : int
        Number of sites. The ring has an odd number of sites, n = -N .. N; about a site at least 5.
        Weak quartets of multipliers, and their number, depend on it. From 3 to 255.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    precompression : float
        Static overlap D of the contacts. The background has the vertical centre C_x = -D
        (eq:center); below 0 contacts have gaps. A finite number.
    formulation : Literal["half-period", "full-period"]
        Equations of Newton's method.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: barrier.json, barrier.png; barrier.npz with an
        array TABLE.COLUMN for each column of barrier.csv: omega_b, background_energy (energy of the
        background, per site), background_action (its action), background_length (its length),
        background_force (its mean contact force), site_energy (of the kink about a site, less the
        background), site_action (its action, less that of the background), site_length (its length,
        less that of the background), site_ring_energy (with the background), site_ring_action (with
        the background), site_ring_length (with the background), site_real (largest real multiplier;
        1 if none is above 1), site_largest (largest modulus of a multiplier), site_residual (of the
        orbit), bond_energy (of the kink about a bond, less the background), bond_action (its
        action, less that of the background), bond_length (its length, less that of the background),
        bond_ring_energy (with the background), bond_ring_action (with the background),
        bond_ring_length (with the background), bond_real (largest real multiplier; 1 if none is
        above 1), bond_largest (largest modulus of a multiplier), bond_residual (of the orbit),
        at_frequency (energy about a bond less that about a site), at_action_and_length (the same at
        the same action and length). barrier.store keeps every point as soon as it is computed; the
        same command resumes from it.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather barrier", breather_barrier, locals())


def breather_moving(
    *,
    omega_b: float | Sequence[float] | None = None,
    turns: int | Sequence[int] = (18, 22, 26),
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    until: float = 1200,
    kick: float = 0.01,
    tol: float = 1e-14,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Compute moving dark breathers as exact orbits, and run a kicked one.

    A moving breather is a relative periodic orbit: after K + 1/2 periods of the background (see
    `turns`) the chain has its initial state again, moved on by a site. Prints its tails and
    relative multipliers, and for comparison the motion of a breather at rest that is kicked. Exit
    code 1 if an orbit is not found.

    Parameters
    ----------
    omega_b : float | Sequence[float]
        Frequencies of the background, in radians per unit of time [default: 1.025 omega]. Separated
        by commas, each above omega = sqrt(kappa (1 + 1/rho)).
    turns : int | Sequence[int]
        Whole periods of the background for each site that the kink moves on. Separated by commas.
        With K the kink needs K + 1/2 periods for a site, so that its velocity is omega_b/(2 pi (K +
        1/2)). Each is from 1 to 100.
    sites : int
        Number of sites. The ring has an odd number of sites, from 9 to 255. The tails of the
        breather depend on it.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    until : float
        End time, in units of time. End of the run of the kicked breather, from one period of the
        background to 10^5 of them; 0 for no such run. It starts from the bond-centred breather at
        rest with the first frequency.
    kick : float
        Size of a kick along one mode, in units of the orbit's amplitude. The largest change of an
        entry of the initial state, along the mode that grows most; of either sign, not zero, at
        most 1 in modulus.
    tol : float
        Tolerance. The run aims at errors of all windows whose sum is at most T, relative to the
        size of the state; 4.5 T is the most that was measured. Where small changes grow, the error
        at the end is larger by the same factor. From 1e-15 to 0.1.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: moving.json, moving.png; moving.npz with an array
        TABLE.COLUMN for each column of moving.csv: omega_b (frequency of the background), turns
        (its whole periods for a site that the kink moves on), passage (time for a site), velocity
        (in sites per unit of time), residual (of the equations of the orbit), return_error
        (distance from the orbit after a passage), background (amplitude of the background), depth
        (local amplitude at the kink, in its units), tail (range of the local amplitude far from the
        kink, in its units), max_modulus (largest modulus of a multiplier), real (largest real
        multiplier; 1 if none is above 1), growth (of the largest multiplier, per unit of time),
        twist (change of the phase along the ring), tail_wave (wave number of the tail), tail_share
        (share of the tail that this wave explains), tail_amplitude (amplitude of this wave),
        resonant_wave (that of the modulation of the background which keeps its phase in the frame
        of the kink), energy (E of the kink), free_energy (its E - omega J - v P). envelope.csv:
        omega_b, turns, n (site), amplitude (local amplitude), phase (its phase), mean (mean
        strain). passages.csv: t (time of the passage of the kicked breather), bond (bond that its
        kink passes), velocity, depth, depth_of_moving (depth of the moving breather of this
        velocity). moving.store keeps every point as soon as it is computed; the same command
        resumes from it. moving-multipliers.store keeps multipliers and energies.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("breather moving", breather_moving, locals())


def orbit_driven(
    scene: Scene | Chain | str = "granular-crystal",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    amplitude: float | None = None,
    omega: float | None = None,
    turns: int = 1,
    settle: int = 300,
    dimensionless: bool = False,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Compute the periodic orbit to which a driven scene leads.

    The orbit is a fixed point of the stroboscopic map. Newton's method starts from the state that
    the scene has after some periods. Prints the Floquet multipliers, which may lie inside and
    outside the unit circle, and compares their product with Liouville's formula. Exit code 1 if no
    orbit is found.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have a `[[drive]]`: harmonics of
        one frequency, with or without a ramp. The orbit is that of the drive at its full height.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    amplitude : float
        Amplitude of the drive [default: that of the scene]. In the units of the scene, of its first
        harmonic with a frequency; the others keep their ratio to it. A finite number.
    omega : float
        Frequency of the drive, in radians per unit of time [default: that of the scene]. The
        fundamental one; all harmonics keep their ratio to it. In the units of the scene. Finite and
        positive.
    turns : int
        Periods of the drive in a period of the orbit. 2 for orbits of doubled period. From 1 to 64.
    settle : int
        Periods of the orbit for which the scene runs before the search. After its ramp. The search
        starts from the state that the scene has then; it starts earlier if the scene has become
        periodic. If no orbit is found from there, the search starts from the state after the ramp.
        From 0 to 1000000.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: driven-orbit.json, driven-orbit.png, and tables
        with their columns: leading-multipliers.csv: re (real part of leading multipliers, one of
        each conjugate pair, without those below their error), im (imaginary part), modulus, error
        (of the modulus). driven-orbit.csv has the displacements of all beads over a period;
        driven-orbit.npz has the orbit, from which `orbit continue --resume` goes on.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("orbit driven", orbit_driven, locals())


def orbit_continue(
    scene: Scene | Chain | str = "granular-crystal",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    amplitude: float | None = None,
    omega: float | None = None,
    turns: int = 1,
    settle: int = 300,
    dimensionless: bool = False,
    vary: Literal["amplitude", "omega", "damping"] = "amplitude",
    to: float | None = None,
    step: float | None = None,
    max_points: int = 1000,
    multipliers: bool | None = None,
    bifurcations: bool | None = None,
    switch: int | None = None,
    resume: str | os.PathLike[str] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Follow the orbit of a driven scene in one parameter.

    In the drive's amplitude or frequency, or in the damping, past folds; with multipliers, folds,
    period doublings and torus bifurcations, and with the branch that crosses at one of them. It
    begins with the scene's own value. Exit code 1 if a branch is lost on its way.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. The scene must have a `[[drive]]`: harmonics of
        one frequency, with or without a ramp. The orbit is that of the drive at its full height.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    amplitude : float
        Amplitude of the drive [default: that of the scene]. In the units of the scene, of its first
        harmonic with a frequency; the others keep their ratio to it. A finite number.
    omega : float
        Frequency of the drive, in radians per unit of time [default: that of the scene]. The
        fundamental one; all harmonics keep their ratio to it. In the units of the scene. Finite and
        positive.
    turns : int
        Periods of the drive in a period of the orbit. 2 for orbits of doubled period. From 1 to 64.
    settle : int
        Periods of the orbit for which the scene runs before the search. After its ramp. The search
        starts from the state that the scene has then; it starts earlier if the scene has become
        periodic. If no orbit is found from there, the search starts from the state after the ramp.
        From 0 to 1000000.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    vary : Literal["amplitude", "omega", "damping"]
        What varies along the branch.
    to : float
        Value of the parameter at which the branch ends. It begins with that of the scene or of
        other options. A finite number.
    step : float
        Largest change of the parameter from point to point. By default a twentieth of the range, of
        dark breathers a hundredth. Finite and positive.
    max_points : int
        Points of the branch at most. With those of a branch that is resumed. At least 2.
    multipliers : bool
        Compute multipliers, or not (=false). On by default where they take less time than the
        orbits: not of dark breathers.
    bifurcations : bool
        Locate bifurcations, or not (=false). They need multipliers. On by default where they take
        less time than the orbits: not of normal modes.
    switch : int
        Follow the branch that crosses at bifurcation K, too. A period doubling, for orbits of the
        doubled period, or a branch point; bifurcations are numbered from 1 as they are printed. It
        ends as the first branch does, or where orbits of doubled period come back to those of half
        the period. Its files are switched-branch.csv, switched-bifurcations.csv and
        switched-branch.npz. At least 1.
    resume : str | os.PathLike[str]
        Go on with what this file, or the file in this folder, has kept. A file of a branch, from
        its last point: to another `to`, by another `step`; then multipliers and bifurcations are
        computed anew. The results are written beside it unless `out` says where.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: driven-branch.json, driven-branch.png, and tables
        with their columns: driven-branch.csv: amplitude (what varies along the branch), response
        (largest half range of a free bead), max_modulus (largest modulus of a multiplier), unstable
        (multipliers outside the unit circle). bifurcations.csv: number, kind, amplitude (what
        varies along the branch), response (largest half range of a free bead), re (real part of the
        multiplier), im (imaginary part). driven-branch.npz has every orbit, and is written every 20
        points or 10 s as well. driven-spectra.store has what was found about them, from which the
        same command goes on. Each part of `shard` follows the branch itself and computes its share
        of this.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("orbit continue", orbit_continue, locals())


def orbit_mode(
    scene: Scene | Chain | str = "defect",
    *,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    linear_mode: int | None = None,
    to: float | None = None,
    step: float | None = None,
    max_points: int = 1000,
    multipliers: bool | None = None,
    bifurcations: bool | None = None,
    switch: int | None = None,
    dimensionless: bool = False,
    resume: str | os.PathLike[str] | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Follow a normal mode of a conservative scene from its linear mode on.

    Computes the linear modes about the equilibrium, and follows the periodic orbits that begin as
    one of them to larger amplitudes, also beyond the amplitude at which contacts open: frequency,
    energy, participation number, Floquet multipliers. Exit code 1 if the branch is lost on its way.

    Parameters
    ----------
    scene : Scene | Chain | str
        Name of a built-in scene, or a TOML file. Contacts of the scene are closed at rest: a static
        overlap, between walls or on a ring; or all beads just touch. Beads may differ. The initial
        state of the scene does not matter.
    set : Mapping[str, Any] | Sequence[str]
        Change a key of the scene, as in chain.rho=3; may be repeated. KEY is a key of the scene's
        TOML with its table (`hertzchain scenes template` has all of them), or an entry of a list,
        from 0, as in drive.1.amplitude=1e-8; VALUE is TOML; a name needs no quotation marks, as in
        chain.boundary=ring.
    linear_mode : int
        Number of the linear mode, the lowest frequency first [default: the most localised one]. The
        parameter of the branch is the amplitude: the displacement, at the start of the period, of
        the bead or resonator that moves most in this mode. The first amplitude is `step`, or a
        smaller one if the orbit found there is not near the mode. Beads that just touch between
        walls have no linear modes: there it is the mode under the static overlap 1 from which the
        load is taken away. Where such beads have springs of their own, the branch is that of the
        breather in the middle of the chain: about a bead if their number is odd, about a bond if it
        is even. At least 1.
    to : float
        Value of the parameter at which the branch ends. It begins with that of the scene or of
        other options. A finite number.
    step : float
        Largest change of the parameter from point to point. By default a twentieth of the range, of
        dark breathers a hundredth. Finite and positive.
    max_points : int
        Points of the branch at most. With those of a branch that is resumed. At least 2.
    multipliers : bool
        Compute multipliers, or not (=false). On by default where they take less time than the
        orbits: not of dark breathers.
    bifurcations : bool
        Locate bifurcations, or not (=false). They need multipliers. On by default where they take
        less time than the orbits: not of normal modes.
    switch : int
        Follow the branch that crosses at bifurcation K, too. A period doubling, for orbits of the
        doubled period, or a branch point; bifurcations are numbered from 1 as they are printed. It
        ends as the first branch does, or where orbits of doubled period come back to those of half
        the period. Its files are switched-branch.csv, switched-bifurcations.csv and
        switched-branch.npz. At least 1.
    dimensionless : bool
        Dimensionless results of a scene with `[units]`. A scene with a table `[units]` is in SI
        units, and so are options and results, except files for `resume`: metres, seconds,
        kilograms, newtons, joules. With this option results are dimensionless; what is given stays
        in SI units.
    resume : str | os.PathLike[str]
        Go on with what this file, or the file in this folder, has kept. A file of a branch, from
        its last point: to another `to`, by another `step`; then multipliers and bifurcations are
        computed anew. The results are written beside it unless `out` says where.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: mode.json, mode.png; mode.npz with an array
        TABLE.COLUMN for each column of linear-modes.csv: mode (number by frequency), omega
        (frequency), participation (number of sites that take part), site (of the bead or resonator
        that moves most), resonator (whether that is a resonator). mode-branch.csv: amplitude, omega
        (frequency), energy (above that of the equilibrium), participation (number of sites that
        take part), least_overlap (of all contacts at the two times of rest), max_modulus (largest
        |lambda|), unstable (multipliers outside the unit circle by more than their error).
        mode-bifurcations.csv: number, kind, amplitude, omega (frequency), tau ((lambda +
        1/lambda)/2 of the multipliers that meet). mode-branch.npz has every orbit, and is written
        every 20 points or 10 s as well. mode-spectra.store has what was found about them, from
        which the same command goes on. Each part of `shard` follows the branch itself and computes
        its share of this.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("orbit mode", orbit_mode, locals())


def dps_integrals(
    *,
    alpha: float = 1.5,
    kappa: float = 1,
    b: float,
    r: float,
    progress: Progress = False,
) -> Study:
    """Averages of the contact force over an oscillation, and their derivatives.

    g_alpha(b, r) of (eq:aux1), the mean, and h_alpha(b, r) of (eq:aux2), the first harmonic divided
    by r.

    Parameters
    ----------
    alpha : float
        Exponent of the contact force; 1.5 for spheres. Above 0 and at most 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    b : float
        Mean strain. The overlap of the bond is -b + 2 kappa r cos t; all values are zero for b >= 2
        kappa r. A finite number.
    r : float
        Amplitude r of the oscillation. Finite and at least 0.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("dps integrals", dps_integrals, locals())


def dps_homoclinic(
    *,
    alpha: float = 1.5,
    center: Literal["site", "bond"] = "site",
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Homoclinic solutions: profiles of bright breathers.

    They solve the stationary DpS equation.

    Parameters
    ----------
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    center : Literal["site", "bond"]
        What the profile is symmetric about.
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: homoclinic.json, homoclinic.png; homoclinic.npz
        with an array TABLE.COLUMN for each column of homoclinic.csv: n, a, ln_ln (ln|ln|a||: a line
        of slope ln alpha in the tails).
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("dps homoclinic", dps_homoclinic, locals())


def dps_dark(
    *,
    center: Literal["site", "bond"] = "site",
    sites: int = 41,
    alpha: float = 1.5,
    kappa: float = 1,
    rho: float = 0.3333333333333333,
    c: float = 0,
    omega_b: float | None = None,
    format: str | Sequence[str] = ("png",),
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Standing waves with a kink: profiles of dark breathers.

    They solve the generalised DpS equations. Also gives the strains from which a dark breather
    starts on the chain, to first order.

    Parameters
    ----------
    center : Literal["site", "bond"]
        What the profile is symmetric about. The kink is on the site 0, or on the bond between the
        sites 0 and 1.
    sites : int
        Number of sites. Length of the ring, an odd number from 3 to 100001.
    alpha : float
        Exponent of the contact force; 1.5 for spheres. From 1.01 to 10.
    kappa : float
        Spring constant of the resonators. Finite and positive.
    rho : float
        Mass ratio resonator to bead. Finite and at least 0: no dark breather has resonators at rest
        (inf).
    c : float
        Mean strain of the background at mu = 1. A finite number.
    omega_b : float
        Frequency of the breather, in radians per unit of time [default: 1.005 omega]. Above omega =
        sqrt(kappa (1 + 1/rho)).
    format : str | Sequence[str]
        Formats of pictures, separated by commas: png, svg.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: dark.json, dark.png; dark.npz with an array
        TABLE.COLUMN for each column of dark.csv: n, a (delta^- of the standing wave (eq:DpSsw2) at
        mu = 1), b (the same of its mean), x (strains of the breather at rest (eq:xy_sw)), y.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("dps dark", dps_dark, locals())


def prove(
    certificate: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    progress: Progress = False,
) -> Study:
    """Check the certificate of a wave, a breather or a branch: prove that it exists.

    By interval arithmetic, from the numbers of the certificate alone. Exit code 1 if nothing is
    proved.

    Parameters
    ----------
    certificate : str | os.PathLike[str]
        File that `certificate` of a wave, a breather or a branch of them has written.
    out : str | os.PathLike[str]
        Write the results to this folder. Files: proof.json, proof.npz.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("prove", prove, locals())


def paper_verify(
    *,
    section: int | None = None,
    out: str | os.PathLike[str] | None = None,
    shard: str | None = None,
    progress: Progress = False,
) -> Study:
    """Compare every number in the text of the paper with ours.

    For every number in Sec. 2 to 8: what the paper says, what we get, the verdict, and why if they
    differ. Exit code 0: every verdict is the known one, and where the paper is known to differ our
    numbers have not changed. Exit code 1: a verdict or such a number is another one, or a run
    failed.

    Parameters
    ----------
    section : int
        One section of the paper: 2, 3, 4, 5, 6, 7 or 8 [default: all].
    out : str | os.PathLike[str]
        Write the results to this folder. Files: verify.txt, verify.csv, verify.npz and verify.json;
        verify.store, which keeps what was computed for the next run.
    shard : str
        Compute only part K of N of the points; needs `out`. The points are kept in a store of their
        own in the folder of `out`. Parts may run at any time and on any machine that has this
        folder; start a part again if it was killed. Once all have ended, the same command without
        `shard` merges what they have kept, computes what is missing, and ends with the same files
        as one process.
    progress : bool or callable
        As in :func:`hertzchain.run`.
    """
    return called("paper verify", paper_verify, locals())
