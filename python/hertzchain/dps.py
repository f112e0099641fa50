"""Modulation theory: the averages of the contact force, profiles and flows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native, studies
from ._arrays import Vector, number, optional, unmasked, vector, whole, word
from ._errors import ParameterError
from ._values import read_only

__all__ = ["DarkProfile", "Profile", "dark_profile", "flow", "g", "h", "homoclinic"]


def _averages(b: ArrayLike, r: ArrayLike, alpha: float, kappa: float) -> tuple[Vector, Vector]:
    wide = np.broadcast_arrays(unmasked("b", b), unmasked("r", r))
    pairs = [vector(name, array.ravel()) for name, array in zip("br", wide)]
    values = _native.averages(number("alpha", alpha), number("kappa", kappa), pairs[0], pairs[1])
    shape = wide[0].shape
    return values[0].reshape(shape), values[1].reshape(shape)


def g(b: ArrayLike, r: ArrayLike, alpha: float = 1.5, kappa: float = 1.0) -> Vector:
    """The mean ``g_alpha(b, r)`` of the contact force over a period of the strain ``b + 2 kappa r cos``.

    Examples
    --------
    A contact that is closed by 1 and does not oscillate has the force 1.

    >>> from hertzchain import dps
    >>> round(float(dps.g(-1.0, 0.0)), 14)
    1.0
    """
    return _averages(b, r, alpha, kappa)[0]


def h(b: ArrayLike, r: ArrayLike, alpha: float = 1.5, kappa: float = 1.0) -> Vector:
    """The coupling ``h_alpha(b, r)``: the first harmonic of the contact force over ``r``.

    Examples
    --------
    At ``r = 0`` it is ``kappa alpha (-b)^(alpha - 1)``.

    >>> from hertzchain import dps
    >>> round(float(dps.h(-1.0, 0.0)), 14)
    1.5
    """
    return _averages(b, r, alpha, kappa)[1]


class Profile(NamedTuple):
    """Sites and amplitudes."""

    n: NDArray[np.int64]
    a: Vector


class DarkProfile(NamedTuple):
    """Sites, amplitudes, mean strains, and the residual of the equations."""

    n: NDArray[np.int64]
    a: Vector
    b: Vector
    residual: float


def homoclinic(center: str = "bond", alpha: float = 1.5) -> Profile:
    """The homoclinic solution ``a_n`` of the stationary DpS equation.

    Examples
    --------
    >>> from hertzchain import dps
    >>> n, a = dps.homoclinic("site")
    >>> bool(a[n == 1] == a[n == -1])
    True
    """
    about = word("center", center)
    of = studies.dps_homoclinic(center=about, alpha=number("alpha", alpha)).record  # type: ignore[arg-type]
    return Profile(read_only(np.array(of["n"], dtype=np.int64)), read_only(np.array(of["a"], dtype=np.float64)))


def dark_profile(
    center: str = "site",
    sites: int = 41,
    c: float = 0.0,
    rho: float = 1 / 3,
    kappa: float = 1.0,
    alpha: float = 1.5,
) -> DarkProfile:
    """The dark profile of the generalised DpS equations on a ring of an odd number of sites."""
    of = studies.dps_dark(
        center=word("center", center),  # type: ignore[arg-type]
        sites=whole("sites", sites),
        alpha=number("alpha", alpha),
        kappa=number("kappa", kappa),
        rho=number("rho", rho),
        c=number("c", c),
    ).record
    a, b = (read_only(np.array(of[name], dtype=np.float64)) for name in "ab")
    return DarkProfile(read_only(np.array(of["n"], dtype=np.int64)), a, b, of["residual"])


def flow(
    start: ArrayLike,
    times: ArrayLike,
    *,
    force: float | None = None,
    mean_strain: float | None = None,
    ends: str = "ring",
    form: str = "displacements",
    rho: float = 1 / 3,
    kappa: float = 1.0,
    alpha: float = 1.5,
    tol: float = 1e-10,
) -> NDArray[np.complex128]:
    """The flow of the generalised DpS equations, by DOP853.

    Parameters
    ----------
    start : array_like, shape (M,)
        Complex amplitudes ``A_n``, or strains ``D_n``.
    times : array_like
        Slow times, from 0 on and ascending.
    force, mean_strain : float
        Which constraint holds: a mean force ``C > 0``, or a mean strain of the ring.
    ends : {"ring", "free"}
        Whether the sites form a ring or a chain with free ends.
    form : {"displacements", "strains"}
        Whether the amplitudes are those of displacements ``A_n`` or of strains ``D_n``.
    tol : float
        Tolerance of a step.

    Returns
    -------
    complex ndarray, shape (times, M)

    Examples
    --------
    The norm is conserved.

    >>> import numpy as np
    >>> from hertzchain import dps
    >>> A = dps.flow([1, 0.2j, -0.3], [0.0, 1.0, 2.0], force=1.0)
    >>> bool(np.ptp((abs(A) ** 2).sum(axis=1)) < 1e-8)
    True
    """
    if word("ends", ends) not in ("ring", "free"):
        raise ParameterError(f"ends = {ends!r} is not valid: ring or free")
    if word("form", form) not in ("displacements", "strains"):
        raise ParameterError(f"form = {form!r} is not valid: displacements or strains")
    given = unmasked("start", start)
    if given.ndim != 1 or given.dtype.kind not in "fiuc":
        raise ParameterError(f"start of type {given.dtype} and shape {given.shape} is not valid: numbers in one dimension")
    amplitudes = given.astype(np.complex128)
    rows = _native.flow(
        [number("alpha", alpha), number("kappa", kappa), number("rho", rho)],
        np.concatenate([amplitudes.real, amplitudes.imag]),
        vector("times", times),
        optional("force", force),
        optional("mean_strain", mean_strain),
        ends == "ring",
        form == "strains",
        number("tol", tol),
    )
    half = rows.shape[1] // 2
    return np.asarray(rows[:, :half] + 1j * rows[:, half:])
