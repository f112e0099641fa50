"""Travelling waves and bright breathers of the modulation theory."""

from __future__ import annotations

from typing import Any

from . import _native
from ._arrays import Vector, number, optional, whole, word
from ._chain import STRAIN_RING, Chain, Scene
from ._errors import ParameterError
from ._values import Made, Value


class TravellingWave(Made, Value):
    """The first-order wave ``x_n = epsilon b + 2 kappa epsilon a cos(n q - omega_tw t + phi)``.

    Parameters
    ----------
    q : float
        Wave number, radians per site.
    a : float
        Amplitude.
    b : float
        Mean strain.
    epsilon, detuning : float
        Size of the wave, or its frequency minus ``omega``; exactly one of the two.
    phi : float
        Phase.
    rho, kappa, alpha : float
        Parameters of the chain.

    Attributes
    ----------
    omega_tw, epsilon : float
        Frequency and size.

    Examples
    --------
    >>> import math, hertzchain as hc
    >>> wave = hc.TravellingWave(q=math.pi / 5, a=1.0, b=0.5, epsilon=0.01)
    >>> wave.omega_tw > 2.0
    True
    >>> wave.scene(sites=20, periods=2).sites
    20
    """

    def __init__(
        self,
        q: float,
        a: float,
        b: float,
        epsilon: float | None = None,
        detuning: float | None = None,
        phi: float = 0.0,
        rho: float = 1 / 3,
        kappa: float = 1.0,
        alpha: float = 1.5,
    ) -> None:
        self._params = [number("alpha", alpha), number("kappa", kappa), number("rho", rho)]
        shape = [number("q", q), number("a", a), number("b", b), number("phi", phi)]
        size = (optional("epsilon", epsilon), optional("detuning", detuning))
        self._given = dict(zip(("q", "a", "b", "phi", "epsilon", "detuning", "alpha", "kappa", "rho"), (*shape, *size, *self._params)))
        self._wave = _native.Wave(self._params, shape, *size)

    @staticmethod
    def of(scene: Scene) -> TravellingWave:
        """The wave of a scene."""
        if not isinstance(scene, Scene):
            raise ParameterError(f"scene = {scene!r} is not valid: a Scene")
        wave = TravellingWave.__new__(TravellingWave)
        wave._wave, wave._given, wave._maker = _native.wave_of(scene._scene), {"scene": scene}, TravellingWave.of
        chain = scene.chain
        wave._params = [chain.alpha, chain.kappa, chain.rho]
        return wave

    @property
    def omega_tw(self) -> float:
        """Frequency of the wave."""
        return self._wave.omega_tw

    @property
    def epsilon(self) -> float:
        """Size of the wave."""
        return self._wave.epsilon

    def at(self, t: float, sites: int) -> dict[str, Vector]:
        """Strains and their rates, ``x, y, vx, vy`` of shape (sites,), at a time."""
        table = self._wave.sites(whole("sites", sites), number("t", t))
        return {name: table[:, k].copy() for k, name in enumerate(("x", "y", "vx", "vy"))}

    def scene(self, sites: int, periods: float) -> Scene:
        """The scene of a strain ring that starts as the wave, for a number of its periods."""
        alpha, kappa, rho = self._params
        chain = Chain(sites, alpha, kappa, rho, STRAIN_RING)
        return chain.scene(self.at(0.0, sites), number("periods", periods) * 2 * 3.141592653589793 / self.omega_tw)


class BrightBreather(Made, Value):
    """The long-lived bright breather with heavy resonators, from a homoclinic solution of DpS.

    Parameters
    ----------
    center : {"site", "bond"}
        What the profile is symmetric about.
    epsilon : float
        Size: beads start at ``2 epsilon a_n``.
    sites : int
        Number of sites.
    rho, kappa, alpha : float
        Parameters of the chain.

    Examples
    --------
    >>> import hertzchain as hc
    >>> breather = hc.BrightBreather("bond", epsilon=0.01, sites=40, rho=1000.0)
    >>> 0 < breather.period < 6.3
    True
    """

    def __init__(
        self, center: str, epsilon: float, sites: int, rho: float = 1000.0, kappa: float = 1.0, alpha: float = 1.5
    ) -> None:
        self._params = [number("alpha", alpha), number("kappa", kappa), number("rho", rho)]
        self._sites = whole("sites", sites)
        shape = (word("center", center), number("epsilon", epsilon), self._sites)
        self._given = dict(zip(("center", "epsilon", "sites", "alpha", "kappa", "rho"), (*shape, *self._params)))
        self._breather = _native.Bright(self._params, *shape)

    @property
    def omega_b(self) -> float:
        """Frequency."""
        return self._breather.omega_b

    @property
    def period(self) -> float:
        """Period ``2 pi/omega_b``."""
        return self._breather.period

    @property
    def horizon(self) -> float:
        """Time up to which the theorem on long-lived breathers bounds the norms."""
        return self._breather.horizon

    def at(self, t: float) -> dict[str, Vector]:
        """The approximate state at a time: ``u, v, pu, pv`` of shape (sites,)."""
        table = self._breather.sites(number("t", t))
        rho = self._params[2]
        arrays: dict[str, Any] = {name: table[:, k].copy() for k, name in enumerate(("u", "v", "pu", "pv"))}
        arrays["pv"] *= rho
        return arrays

    def scene(self, periods: float, boundary: str = "free") -> Scene:
        """The scene of a chain that starts as the breather, for a number of its periods."""
        if word("boundary", boundary) == STRAIN_RING:
            raise ParameterError(f"boundary = {boundary!r} is not valid: a bright breather is a state of displacements")
        alpha, kappa, rho = self._params
        chain = Chain(self._sites, alpha, kappa, rho, boundary)
        y0 = self.at(0.0) if chain.resonators else {key: self.at(0.0)[key] for key in ("u", "pu")}
        return chain.scene(y0, number("periods", periods) * self.period)
