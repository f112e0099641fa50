"""Contact collocation of one bond by the rules of docs/collocation.md, in an order of its own.

Two beads, each with a resonator, move as mirror images and meet again and again. Numbers of nodes
and the bound S stay as they begin: they change the work and not the rules. `.ci/python` runs it:
errors at the end must stay below three tolerances.
"""

from math import cos, hypot, inf, sin, sqrt

import hertzchain as hc
import numpy as np
from numpy.polynomial import chebyshev, legendre


class Pair:
    """The bond, its kernel, and the constants of panels with some number of nodes."""

    def __init__(self, alpha, kappa, rho, nodes):
        self.alpha, self.rho = alpha, rho
        self.m, self.omega = 1 / (1 + rho), sqrt(kappa * (1 + 1 / rho))
        self.mu = 1 - self.m
        self.q = next(q for q in range(1, 9) if (q * alpha).is_integer() or q * (alpha + 1) >= 8)
        self.x, self.w = legendre.leggauss(nodes)
        integrals = [legendre.legval(self.x, legendre.legint(row, lbnd=-1)) for row in np.eye(nodes)]
        self.a = np.linalg.solve(legendre.legvander(self.x, nodes - 1).T, np.array(integrals)).T
        self.series = np.linalg.inv(chebyshev.chebvander(self.x, nodes - 1))

    def force(self, g):
        return np.maximum(g, 0) ** self.alpha

    def stiffness(self, g):
        return self.alpha * max(g, 0) ** (self.alpha - 1)

    def path(self, numbers, t):
        r, v, c, s = numbers
        return r + v * t + c * np.cos(self.omega * t) + s * np.sin(self.omega * t)

    def kernel(self, t):
        return self.m * t + self.mu / self.omega * np.sin(self.omega * t)

    def by_power(self, k, t):
        """The displacement of a bead by the force t^k, for k = 0, 1, 2."""
        w = self.omega
        turned = [1 - np.cos(w * t), w * t - np.sin(w * t), (w * t) ** 2 - 2 * (1 - np.cos(w * t))][k]
        return self.m * t ** (k + 2) / ((k + 1) * (k + 2)) + self.mu * turned / w ** (k + 2)


class Panel:
    """A panel from `start` to `end`: time is origin + sign * sigma^power."""

    def __init__(self, pair, start, end, origin, sign, power):
        self.pair, self.start, self.end = pair, start, end
        self.origin, self.sign, self.power = origin, sign, power
        self.first, last = self.sigma(start), self.sigma(end)
        self.half = (last - self.first) / 2
        sigma = self.first + self.half * (pair.x + 1)
        self.t = origin + sign * sigma**power
        self.dt = sign * power * sigma ** (power - 1) * self.half
        self.own = pair.a * pair.kernel(self.t[:, None] - self.t)

    def sigma(self, t):
        return max(self.sign * (t - self.origin), 0) ** (1 / self.power)

    def overlap(self, t):
        """The overlap, interpolated."""
        x = (self.sigma(t) - self.first) / self.half - 1
        return chebyshev.chebval(x, self.pair.series @ self.g)

    def slope(self, end):
        """The slope of the overlap at the first node, or at the last one for -1."""
        t, g = self.t - self.t[end], self.g - self.g[end]
        far = np.flatnonzero(abs(t) > 1e-3 * (self.end - self.start))[end]
        return g[far] / t[far]

    def left(self):
        """What the force of the panel adds to the four numbers of a bead."""
        pair, impulses = self.pair, self.pair.w * self.dt * self.f
        turn, swing = pair.omega * self.t, pair.mu / pair.omega
        rows = [-pair.m * self.t, np.full_like(self.t, pair.m), -swing * np.sin(turn), swing * np.cos(turn)]
        return np.array(rows) @ impulses


def cut(pair, start, end, onset, release, halvings):
    """The panels of a contact in a window."""
    reach = (0.5 if (2 * pair.alpha).is_integer() else 0.75) * (end - start)
    begins, ends = start - onset < reach and pair.q > 1, release - end < reach and pair.q > 1
    if begins and ends:
        middle = (start + end) / 2
        return cut(pair, start, middle, onset, inf, halvings) + cut(pair, middle, end, -inf, release, halvings)
    origin, sign, power = (onset, 1, pair.q) if begins else (release, -1, pair.q) if ends else (start, 1, 1)
    whole = Panel(pair, start, end, origin, sign, power)
    inner = whole.first + 2 * whole.half * np.arange(1, 2**halvings) / 2**halvings
    times = [start, *(origin + sign * inner**power), end]
    return [Panel(pair, a, b, origin, sign, power) for a, b in zip(times, times[1:])]


def contacts_of(g, h, bound, onset):
    """Onsets and releases; `onset` is that of a contact which is open at the start, or None."""
    zeros = []

    def part(a, b, at_a, at_b):
        width = b - a
        one_side = (at_a > 0) == (at_b > 0)
        if one_side and min(abs(at_a), abs(at_b)) > bound * width**2 / 8:
            return
        if width > 1e-12 * h and (one_side or abs(at_a - at_b) <= bound * width**2):
            middle = g((a + b) / 2)
            part(a, (a + b) / 2, at_a, middle)
            part((a + b) / 2, b, middle, at_b)
        elif not one_side:
            for _ in range(60):
                middle = (a + b) / 2
                a, b = (middle, b) if (g(middle) > 0) == (at_a > 0) else (a, middle)
            zeros.append((a + b) / 2)

    # The sign at the start is known.
    at_start = abs(g(0)) if onset is not None else -abs(g(0))
    part(0, 2.5 * h, at_start, g(2.5 * h))
    events = ([] if onset is None else [onset]) + zeros + [inf]
    return [list(pair) for pair in zip(events[::2], events[1::2]) if pair[0] < h]


def window(pair, numbers, h, onset, e, size, longest):
    """The numbers after a window, the onset of a contact that goes on, the stiffness, the number of
    sweeps and whether panels were halved; None if the window is given up."""
    alpha, w = pair.alpha, pair.omega
    g0, rate = numbers[0] + numbers[2], numbers[1] + w * numbers[3]
    swing = w * hypot(numbers[2], numbers[3])
    speed = abs(numbers[1]) + swing
    free, power = g0 + speed * h, alpha + 1
    stopped = (max(g0, 0) ** power + speed**2 * power / 4) ** (1 / power)
    lasts = h if g0 >= 0 else h + g0 / speed
    if lasts > 0 and pair.stiffness(min(free, stopped)) * lasts**2 > longest:
        return None
    f = [pair.force(g0), pair.stiffness(g0) * rate]
    predicted = lambda t: pair.path(numbers, t) - 2 * sum(f[k] * pair.by_power(k, t) for k in range(len(f)))
    # K'' is at most 1 and the integral of |K''| - 1 over the time ahead at most this.
    bound = lambda force: w * swing + 2 * force * (1 + pair.mu * w * min(2.5 * h, w * (2.5 * h) ** 2))
    contacts = contacts_of(predicted, h, bound(f[0] + 2.5 * h * abs(f[1])), onset)
    f.append((pair.force(predicted(h)) - f[0] - f[1] * h) / h**2)
    found = lambda t: pair.path(numbers, t) - 2 * sum(f[k] * pair.by_power(k, t) for k in range(3))
    epsilon, sweeps, halvings = max(e / 100, 1e-18) * size, 0, 0

    def laid_out():
        """Panels of all contacts, with forces of the overlaps found so far."""
        spans = [(max(a, 0), min(b, h), a, b) for a, b in contacts]
        groups = [cut(pair, *span, halvings) if span[0] < span[1] else [] for span in spans]
        for panel in sum(groups, []):
            panel.f = pair.force(np.array([found(t) for t in panel.t]))
        return groups

    def solved(groups):
        """The overlap as a function of time by the panels that were swept."""
        panels, sums = sum(groups, []), [numbers]
        for panel in panels:
            sums.append(sums[-1] - 2 * panel.left())
        def g(t):
            before = sum(panel.end < t for panel in panels)
            inside = before < len(panels) and panels[before].start <= t
            return panels[before].overlap(t) if inside else pair.path(sums[before], t)
        return g, sums[-1]

    for _ in range(10):
        groups, count, moved = laid_out(), 0, True
        while moved or 4 * stiffness / ((2 * count + 1) * (2 * count + 2)) * change > epsilon:
            sweeps, count = sweeps + 1, count + 1
            if sweeps > 40:
                return None
            before, change, stiffness, moved = numbers, 0.0, 0.0, False
            for group, contact in zip(groups, contacts):
                for panel in group:
                    panel.g = pair.path(before, panel.t) - 2 * panel.own @ (panel.dt * panel.f)
                    was, panel.f = panel.f, pair.force(panel.g)
                    change += pair.w @ (panel.dt * np.abs(panel.f - was))
                    stiffness = max(stiffness, pair.stiffness(panel.g.max()) * h**2)
                    before = before - 2 * panel.left()
                for k in (0, 1):
                    if group and 0 < contact[k] <= h:
                        panel = group[-k]
                        off = panel.overlap((panel.start, panel.end)[k])
                        step = max(-off / panel.slope(-k), -contact[k])
                        if pair.force(abs(off)) * abs(step) > epsilon / 10:
                            contact[k], moved = contact[k] + step, True
            if moved:
                found, _ = solved(groups)
                groups, count = laid_out(), 0
        found, after = solved(groups)
        panels = sum(groups, [])
        excess = 0.0
        for panel in panels:
            impulse, turn = panel.dt * panel.f, w * panel.t
            terms = max(abs(pair.series @ (impulse * by))[-2:].max() for by in (1, np.cos(turn), np.sin(turn)))
            slow = panel.power < pair.q and panel.g.min() < 0.15 * panel.g.max()
            allowed = max((4000 * e) ** 0.8, 1e-14)
            excess = max(excess, terms / size / (min(allowed, 200 * e) if slow else allowed))
            if impulse.max() > e * size:
                excess = max(excess, terms / (0.3 * impulse.max()))
        if stiffness > longest or excess > 1 and halvings == 4:
            return None
        again = contacts_of(found, h, bound(1.2 * max([panel.f.max() for panel in panels], default=0)), onset)
        inside = lambda contact: [0 < contact[0], contact[1] <= h]
        longer = lambda one, other: max(min(c[1], h) - max(c[0], 0) for c in (one, other))
        common = lambda one, other: min(one[1], other[1], h) - max(one[0], other[0], 0)
        alike = [inside(one) == inside(other) and 2 * common(one, other) >= longer(one, other)
                 for one, other in zip(contacts, again)]
        if len(again) != len(contacts) or not all(alike):
            contacts = again
        elif excess > 1:
            halvings += 1
        else:
            onset = contacts[-1][0] - h if contacts and contacts[-1][1] > h else None
            return after, onset, stiffness, sweeps, halvings
    return None


def run(alpha, kappa, rho, state, end, tolerance):
    """Overlap g, difference of the resonators, their rates, at the end; and the number of windows."""
    nodes = next((m for m, least in ((4, 1e-3), (6, 1e-5), (8, 1e-6), (10, 1e-8)) if tolerance >= least), 12)
    pair = Pair(alpha, kappa, rho, nodes if (2 * alpha).is_integer() else max(nodes, 8))
    g, apart, g_dot, apart_dot = state
    m, mu, w = pair.m, pair.mu, pair.omega
    numbers = np.array([m * g + mu * apart, m * g_dot + mu * apart_dot, mu * (g - apart), mu * (g_dot - apart_dot) / w])
    # Each bead has half the rate of the overlap.
    size = (abs(numbers[1]) + w * hypot(numbers[2], numbers[3])) / 2
    size = max(size, sqrt(2 * pair.force(g) * max(g, 0)))
    reach = abs(numbers[0]) + hypot(numbers[2], numbers[3])
    h = 0.3 / max(sqrt(pair.stiffness(reach)), w)
    t, windows, onset = 0.0, 0, -inf if g > 0 else None
    while t < end:
        h = min(h, end - t)
        e = max(tolerance * h / end, 1e-6 * tolerance)
        outcome = window(pair, numbers, h, onset, e, size, 0.5 if tolerance >= 1e-4 else 1.5)
        if outcome is None:
            h /= 2
            continue
        (r, v, c, s), onset, stiffness, sweeps, halvings = outcome
        turn = [cos(w * h), sin(w * h)]
        numbers = np.array([r + v * h, v, c * turn[0] + s * turn[1], s * turn[0] - c * turn[1]])
        t, windows = t + h, windows + 1
        longest = h * sqrt(0.04 / stiffness) if stiffness > 0 else inf
        h = min(h * (2 if stiffness == 0 else 0.9 if sweeps > 5 or halvings else 1.06), longest)
    r, v, c, s = numbers
    share = 0 if rho == inf else 1 / rho
    return np.array([r + c, r - share * c, v + w * s, v - share * w * s]), windows


def struck(alpha, contacts):
    """Time and state half a unit of time after so many contacts of beads with fixed resonators,
    kappa = 1, that begin just apart with g' = -1: there g'^2 = 1 - g^2 - 4 g^b/b, b = alpha + 1."""
    b, low, high = alpha + 1, 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if middle**2 + 4 * middle**b / b < 1 else (low, middle)
    # g = low sin^10(phi): the integrand is smooth.
    x, weights = legendre.leggauss(100)
    phi = np.pi / 4 * (x + 1)
    power = lambda k: -np.expm1(k / 2 * np.log1p(-np.cos(phi) ** 2))
    rate = np.sqrt(low**2 * power(20) + 4 * low**b / b * power(10 * b))
    lasts = 2 * weights @ (10 * low * np.sin(phi) ** 9 * np.cos(phi) / rate) * np.pi / 4
    return contacts * (np.pi + lasts) + 0.5, np.array([-sin(0.5), 0, -cos(0.5), 0])


for alpha in (1.2, 1.5, 2.0, 2.5):
    end, truth = struck(alpha, 5)
    for tolerance in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        found, windows = run(alpha, 1.0, inf, (0.0, 0.0, -1.0, 0.0), end, tolerance)
        error = abs(found - truth).max()
        print(f"alpha = {alpha}, T = {tolerance:.0e}: {windows} windows, error {error:.1e}")
        assert error < 3 * tolerance

for rho in (1 / 3, 3.0):
    state, end = (-0.3, 0.4, 0.7, 0.2), 12.0
    g, apart, g_dot, apart_dot = state
    mirrored = lambda x: np.array([x / 2, -x / 2])
    chain = hc.Chain(sites=2, alpha=1.5, kappa=4.0, rho=rho, boundary="free")
    start = {"u": mirrored(g), "v": mirrored(apart), "pu": mirrored(g_dot), "pv": rho * mirrored(apart_dot)}
    ran = hc.run(chain, y0=start, until=end, tol=1e-13, method="dop853-regularised", events=True)
    last = ran.end
    truth = np.array([np.subtract(*last["u"]), np.subtract(*last["v"]), np.subtract(*last["pu"]), np.subtract(*last["pv"]) / rho])
    print(f"rho = {rho:.2f}: {len(ran.contacts)} contacts")
    for tolerance in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        found, windows = run(1.5, 4.0, rho, state, end, tolerance)
        error = abs(found - truth).max()
        print(f"T = {tolerance:.0e}: {windows} windows, error {error:.1e}")
        assert error < 3 * tolerance
