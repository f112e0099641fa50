"""Contact-corrected splitting of three free beads, written from docs/corrected.md alone.

`.ci/python` runs it: with steps four times as short, errors must be smaller by more than 4^3.5, with
resonators and without, also where the run starts or ends within a contact, near its onset or its
release. Line 7, for grazing contacts, is left out.
"""

from math import cos, log2, sin, sqrt

alpha = 1.5


def zeta(z, x, n=12):
    """Hurwitz' zeta function for z < 0, by the formula of Euler and Maclaurin."""
    y = x + n
    total = sum((k + x) ** -z for k in range(n)) + y ** (1 - z) / (z - 1) + y**-z / 2
    term = z * y ** (-z - 1)
    for j, b in enumerate([1 / 12, -1 / 720, 1 / 30240, -1 / 1209600, 1 / 47900160]):
        total, term = total + b * term, term * (z + 2 * j + 1) * (z + 2 * j + 2) / y**2
    return total


def force(g):
    return max(g, 0) ** alpha


def stiffness(g):
    return alpha * max(g, 0) ** (alpha - 1)


def over(forces):
    """Of each bond the sum of the forces of the bonds beside it."""
    return [forces[1], forces[0]]


def beads(forces):
    """The force on each bead."""
    return [-forces[0], forces[0] - forces[1], forces[1]]


class Flow:
    """The exact linear flow of a bead and its resonator; kernels and their integrals."""

    def __init__(self, kappa, rho):
        self.rho, self.m = rho, 1 / (1 + rho)
        self.mu, self.omega = rho * self.m, sqrt(kappa * (1 + 1 / rho)) if rho else 1.0

    def __call__(self, y, t):
        u, v, p, q = y
        c, s = cos(self.omega * t), sin(self.omega * t)
        center, speed = self.m * (u + self.rho * v), self.m * (p + self.rho * q)
        x, r = self.mu * (u - v), self.mu * (p - q)
        x, r = x * c + r * s / self.omega, r * c - x * s * self.omega
        other = (x / self.rho, r / self.rho) if self.rho else (0, 0)
        return [center + speed * t + x, center + speed * t - other[0], speed + r, speed - other[1]]

    def motion(self, y, t):
        """Displacement of the bead at t, its rate and its acceleration."""
        now = self(y, t)
        return now[0], now[2], -self.omega**2 * self.mu * (now[0] - now[1])

    def kernel(self, t):
        """K'', K', K and its first two integrals."""
        w, m, mu = self.omega, self.m, self.mu
        c, s = cos(w * t), sin(w * t)
        return (-mu * w * s, m + mu * c, m * t + mu * s / w, m * t**2 / 2 + mu * (1 - c) / w**2,
                m * t**3 / 6 + mu * (w * t - s) / w**3)


def slopes(g, r, a, theta, h):
    """W_g and W_r."""
    def w(g, r):
        c = sqrt(max(r * r - 2 * a * g, 0))
        x = max(theta + 2 * g / (r + c) / h, 1e-300)
        second = c**alpha * a * h / 2 * zeta(-alpha - 2, x) / (1 + (a * h / c) ** 8)
        return h ** (alpha + 2) * (c ** (alpha + 1) * zeta(-alpha - 1, x) / (alpha + 1) + second)
    d = 1e-5 * r
    return (w(g + d * h, r) - w(g - d * h, r)) / (2 * d * h), (w(g, r + d) - w(g, r - d)) / (2 * d)


def bisect(inside, low, high):
    """Where `inside` becomes false between low, where it is true, and high."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if inside(middle) else (low, middle)
    return low


class Run:
    def __init__(self, flow, y, h):
        self.flow, self.h, self.y = flow, h, [list(one) for one in y]

    def overlaps(self, y=None):
        y = y or self.y
        return [y[b][0] - y[b + 1][0] for b in (0, 1)]

    def motion(self, b, t):
        left, right = (self.flow.motion(self.y[i], t) for i in (b, b + 1))
        return [x - y for x, y in zip(left, right)]

    def give(self, b, impulse, displacement, at):
        for bead, side in ((b, -1), (b + 1, 1)):
            change = self.flow([side * displacement, 0, side * impulse, 0], -at)
            self.y[bead] = [x + c for x, c in zip(self.y[bead], change)]

    def process(self, share, near):
        def moved(y, share, at):
            g = self.overlaps(at)
            rates = [0 if b in near else stiffness(g[b]) * (at[b][2] - at[b + 1][2]) for b in (0, 1)]
            jet = zip(y, beads([force(x) for x in g]), beads(rates))
            return [[u + share * a, v, p - share * da, q] for (u, v, p, q), a, da in jet]
        self.y = moved(self.y, share, moved(self.y, share / 2, self.y))

    def events(self, reach):
        """Bond, time, speed, acceleration and kind of the zeros on either side of closed bonds."""
        g = self.overlaps()
        for b, s in enumerate(over([force(x) for x in g])):
            def path(t):
                _, k1, k, integral, _ = self.flow.kernel(t)
                return [x + s * y for x, y in zip(self.motion(b, t), (integral, k, k1))]
            for side in (-1, 1) if g[b] > 0 else ():
                times = [side * reach * k / 60 for k in range(61)]
                for low, high in zip(times, times[1:]):
                    if path(high)[0] <= 0:
                        t = bisect(lambda t: path(t)[0] > 0, low, high)
                        yield b, t, abs(path(t)[1]), path(t)[2], side
                        break

    def ends(self, sigma, near):
        h, given = self.h, []
        for b, t, c, a, side in self.events(6 * h):
            x = abs(t) / h
            z0, z1 = (zeta(-z, 1 + x) + x**z / 2 + x ** (z + 1) / (z + 1) for z in (alpha, alpha + 1))
            q = x ** (alpha - 1) / 12
            known = 0 if b in near else q
            bent = alpha * a * h / (2 * c) * (z1 + (alpha + 1) * x * known) if abs(a) * h < c else 0
            e = c**alpha * h ** (alpha + 1) * (z0 + alpha * known + bent)
            given.append((b, sigma * side * e, sigma * c**alpha * h ** (alpha + 2) * (z1 - x * z0 + x * q)))
        for b, impulse, displacement in given:
            self.give(b, impulse, displacement, 0)

    def correction(self, b, onset, g, s):
        """Impulse, displacement and time of an event; those of the two kicks beside it."""
        h, flow = self.h, self.flow
        e, jerk = [h * h / 12 * x for x in s], (s[1] - s[0]) / h
        def pulled(t):
            k2, k1, k, one, two = flow.kernel(t)
            return s[1] * one + jerk * two, s[1] * k + jerk * one, s[1] * k1 + jerk * k
        w = (e[0] - e[1] - pulled(-h)[0]) / flow.kernel(-h)[2]
        def path(t):
            k2, k1, k, _, _ = flow.kernel(t)
            parts = zip(self.motion(b, t), (e[1] + w * k, w * k1, w * k2), pulled(t))
            return [sum(part) for part in parts]
        t = bisect(lambda t: (path(t)[0] > 0) != onset, -1.25 * h, 0.25 * h)
        sign = 1 if onset else -1
        r, a, theta = sign * path(t)[1], path(t)[2], (-t / h if onset else 1 + t / h) % 1
        by_g, by_r = slopes(0, r, a, theta, h)
        by_g, by_r = slopes(-sign * by_r, r + sign * by_g, a, theta, h)  # M/2 is 1
        lack = [h * (force(x + y) - force(x) - stiffness(x) * y) for x, y in zip(g, e)]
        return (-by_g, sign * by_r, t), (lack[0], 0, -h), (lack[1], 0, 0)

    def run(self, n, line8=True):
        h, was = self.h, None
        closed = [x > 0 for x in self.overlaps()]
        near = {event[0] for event in self.events(2 * h)} if line8 else set()
        if line8:
            self.ends(1, near)
        self.process(-h * h / 12, near)
        for k in range(n + 1):
            g = self.overlaps()
            f = [force(x) for x in g]
            changed = [b for b in (0, 1) if was and (g[b] > 0) != closed[b]]
            pairs = {b: ((was[0][b], g[b]), (over(was[1])[b], over(f)[b])) for b in changed}
            given = [(b, self.correction(b, g[b] > 0, *pairs[b])) for b in changed]
            for b, gifts in given:
                closed[b] = not closed[b]
                for gift in gifts:
                    self.give(b, *gift)
            g = self.overlaps()
            f = [force(x) for x in g]
            pulls = [x - 2 * y for x, y in zip(over(f), f)]
            kicks = [y + h * h / 12 * stiffness(x) * s for x, y, s in zip(g, f, pulls)]
            for y, kick in zip(self.y, beads(kicks)):
                y[2] += h * kick * (0.5 if k in (0, n) else 1)
            was = g, f
            if k < n:
                self.y = [self.flow(y, h) for y in self.y]
        near = {event[0] for event in self.events(2 * h)} if line8 else set()
        self.process(h * h / 12, near)
        if line8:
            self.ends(-1, near)
        return [list(y) for y in self.y]


def orders(flow, step, start=lambda h: gap, **how):
    """Mean orders of beads from 50 to 200 and 100 to 400 steps, against 16 times as many."""
    errors = []
    for n in (50, 100, 200, 400):
        h = step(n)
        truth = Run(flow, start(h), h / 16).run(16 * n)
        end = Run(flow, start(h), h).run(n, **how)
        errors.append(max(abs(p - q) for a, b in zip(truth, end) for p, q in zip(a[::2], b[::2])))
    return [log2(p / q) / 2 for p, q in zip(errors, errors[2:])]


def after(flow, t):
    """The state at the time t."""
    n = int(2400 * t)
    return Run(flow, gap, t / n).run(n)


# The first onset and the last release of either chain.
for kappa, rho, onset, release in ((0, 0, 0.41217, 3.97495), (1, 1 / 3, 0.42490, 4.95595)):
    flow = Flow(kappa, rho)
    at = [0.37, 0.71] if rho else [0, 0]
    gap = [[0, 0, 1, 0], [0.37, at[0], 0.1, 0.1 * (rho > 0)], [0.71, at[1], -0.5, -0.5 * (rho > 0)]]
    found = {"gaps": orders(flow, lambda n: 6 / n)}
    for x in (0.4, 1.3, 3.7):
        found[f"ends {x} steps before a release"] = orders(flow, lambda n: release / (n + x))
        near = lambda h: after(flow, onset + x * h)
        found[f"starts {x} steps after an onset"] = orders(flow, lambda n: 2 / n, near)
    for name, two in found.items():
        print(f"rho = {rho:.2f}, {name}:", [f"{one:.2f}" for one in two])
        assert min(two) > 3.5
    assert orders(flow, lambda n: release / (n + 0.4), line8=False)[1] < 2.6
