"""Writes details-*.json: end states of chains whose beads differ, to 20 digits (needs mpmath).

    python3 details.py

Shares no code and no method with hertzchain. Between two events the motion is analytic in s, where t = a + (b - a) w(s) with
w = s^2 (3 - 2 s), which has a double zero at either end: half-integer powers of the time since an event or to the next one become powers
of s. There it is found by the Taylor-free rule of Gauss, order 2 NODES, on PIECES pieces with fixed-point iteration. The events are
changes of sign of the overlaps and, for contacts that dissipate, of the force before it is cut at zero; the time of each is found by the
secant method. "error" is the largest difference from a second computation with other nodes and pieces, and the energy, with what was
dissipated and driven, must be kept to that size.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from mpmath import ldexp, mp, mpf, sin, cos, sqrt

mp.dps = 32
# Sums of stages are of integers over 2^BITS.
BITS = 110

CASES = {
    # Masses, springs, mass ratios, contacts, exponents and static overlaps of their own; walls.
    "conservative": {
        "boundary": "fixed", "end": 9.0,
        "mass": [1.0, 0.5, 2.0, 0.75, 1.25], "kappa": [1.0, 0.5, 0.0, 2.0, 1.0], "rho": [0.5, "inf", 0.0, 0.25, 1.5],
        "contact": [2.0, 1.0, 0.5, 1.5, 1.0, 3.0], "alpha": [1.5, 1.5, 2.0, 2.5, 1.5, 1.5],
        "overlap": [0.0, 0.25, -0.125, 0.0, 0.0625, -0.25],
    },
    # The same beads, with drag, dashpots, viscoelastic contacts, a force and a bead that is moved.
    "open": {
        "boundary": "fixed", "end": 7.0,
        "mass": [1.0, 0.5, 2.0, 0.75, 1.25], "kappa": [0.0, 0.5, 0.0, 2.0, 1.0], "rho": [0.0, "inf", 0.0, 0.25, 1.5],
        "contact": [0.0, 1.0, 0.5, 1.5, 1.0, 3.0], "alpha": [1.5, 1.5, 2.5, 2.5, 1.5, 1.5],
        "overlap": [0.0, 0.25, -0.125, 0.0, 0.0625, -0.25],
        "drag": [0.0, 0.125, 0.25, 0.0, 0.0625], "dashpot": [0.0, 0.25, 0.0, 0.125, 0.0],
        "viscoelastic": [0.0, 0.125, 0.0, 0.25, 0.0625, 0.125],
        "moved": [0, 0.5, 1.75, 0.5], "pushed": [3, 0.25, 2.5, 0.0],
    },
    # Twelve beads and 200 contacts; drawn once, multiples of 1/64. By quad.c, see `by_quad`.
    "twelve": {
        "boundary": "fixed", "end": 107.0, "quad": True,
        "mass": [0.90625, 1.546875, 1.171875, 1.671875, 1.71875, 0.53125, 0.421875, 2.15625, 0.9375, 0.890625, 2.484375, 1.390625],
        "kappa": [2.140625, 1.34375, 1.703125, 0.625, 1.703125, 0.0, 1.453125, 1.9375, 1.78125, 0.4375, 1.96875, 1.59375],
        "rho": [0.75, 0.25, 1.765625, 0.0, 1.5, 1.78125, 1.484375, 1.859375, "inf", 1.640625, 0.0, 1.890625],
        "contact": [2.703125, 0.75, 0.84375, 1.046875, 2.90625, 1.59375, 2.0625, 1.25, 1.765625, 1.46875, 1.375, 1.96875, 1.953125],
        "alpha": [1.5, 1.5, 1.5, 1.5, 2.0, 1.5, 1.5, 2.5, 1.5, 1.5, 2.0, 1.5, 1.5],
        "overlap": [0.15625, 0.0625, 0.171875, 0.140625, 0.203125, 0.046875, -0.171875, 0.140625, 0.1875, 0.15625, 0.0, 0.078125, -0.15625],
    },
    # The same with drag, dashpots, a bead that is moved and one that is pushed.
    "driven": {
        "boundary": "fixed", "end": 107.0, "quad": True,
        "mass": [0.90625, 1.546875, 1.171875, 1.671875, 1.71875, 0.53125, 0.421875, 2.15625, 0.9375, 0.890625, 2.484375, 1.390625],
        "kappa": [2.140625, 1.34375, 1.703125, 0.0, 1.703125, 0.0, 1.453125, 1.9375, 1.78125, 0.4375, 1.96875, 1.59375],
        "rho": [0.75, 0.25, 1.765625, 0.0, 1.5, 1.78125, 1.484375, 1.859375, "inf", 1.640625, 0.0, 1.890625],
        "drag": [0.03125, 0.0, 0.0625, 0.0, 0.015625, 0.046875, 0.0, 0.03125, 0.0625, 0.0, 0.015625, 0.0],
        "dashpot": [0.0, 0.0625, 0.03125, 0.0, 0.0, 0.0, 0.015625, 0.046875, 0.03125, 0.0625, 0.0, 0.0],
        "contact": [2.703125, 0.75, 0.84375, 1.046875, 2.90625, 1.59375, 2.0625, 1.25, 1.765625, 1.46875, 1.375, 1.96875, 1.953125],
        "alpha": [1.5, 1.5, 1.5, 1.5, 2.0, 1.5, 1.5, 2.5, 1.5, 1.5, 2.0, 1.5, 1.5],
        "overlap": [0.15625, 0.0625, 0.171875, 0.140625, 0.203125, 0.046875, -0.171875, 0.140625, 0.1875, 0.15625, 0.0, 0.078125, -0.15625],
        "moved": [3, 0.25, 1.75, 0.5], "pushed": [8, 0.5, 1.25, 0.0],
    },
    # The same, driven harder, with contacts that dissipate.
    "dissipating": {
        "boundary": "fixed", "end": 107.0, "quad": True,
        "mass": [0.90625, 1.546875, 1.171875, 1.671875, 1.71875, 0.53125, 0.421875, 2.15625, 0.9375, 0.890625, 2.484375, 1.390625],
        "kappa": [2.140625, 1.34375, 1.703125, 0.0, 1.703125, 0.0, 1.453125, 1.9375, 1.78125, 0.4375, 1.96875, 1.59375],
        "rho": [0.75, 0.25, 1.765625, 0.0, 1.5, 1.78125, 1.484375, 1.859375, "inf", 1.640625, 0.0, 1.890625],
        "drag": [0.03125, 0.0, 0.0625, 0.0, 0.015625, 0.046875, 0.0, 0.03125, 0.0625, 0.0, 0.015625, 0.0],
        "dashpot": [0.0, 0.0625, 0.03125, 0.0, 0.0, 0.0, 0.015625, 0.046875, 0.03125, 0.0625, 0.0, 0.0],
        "contact": [2.703125, 0.75, 0.84375, 1.046875, 2.90625, 1.59375, 2.0625, 1.25, 1.765625, 1.46875, 1.375, 1.96875, 1.953125],
        "alpha": [1.5, 1.5, 1.5, 1.5, 2.0, 1.5, 1.5, 2.5, 1.5, 1.5, 2.0, 1.5, 1.5],
        "overlap": [0.15625, 0.0625, 0.171875, 0.140625, 0.203125, 0.046875, -0.171875, 0.140625, 0.1875, 0.15625, 0.0, 0.078125, -0.15625],
        "viscoelastic": [0.03125, 0.125, 0.0, 0.25, 0.0625, 0.015625, 0.09375, 0.0, 0.1875, 0.0625, 0.03125, 0.125, 0.0625],
        "moved": [3, 0.5, 1.75, 0.5], "pushed": [8, 1.0, 1.25, 0.0],
    },
}


def start(case):
    """u, v, u', v': doubles, taken as exact. A bead that is moved begins on its path."""
    n = len(case["mass"])
    u = [0.125 * ((7 * i) % 5 - 2) for i in range(n)]
    v = [0.0625 * ((3 * i) % 4 - 1) for i in range(n)]
    p = [0.25 * ((4 * i + 1) % 5 - 2) for i in range(n)]
    w = [0.125 * ((2 * i + 1) % 3 - 1) for i in range(n)]
    return u, v, p, w


def fixed(x):
    return int(ldexp(x, BITS))


class Motion:
    def __init__(self, case, nodes, pieces):
        self.case, self.n, self.pieces = case, len(case["mass"]), pieces
        get = lambda key, size, other: [mpf(x) if x != "inf" else None for x in case.get(key, [other] * size)]
        n = self.n
        self.mass, self.kappa, self.rho = get("mass", n, 1), get("kappa", n, 0), get("rho", n, 0)
        self.drag, self.dashpot = get("drag", n, 0), get("dashpot", n, 0)
        self.contact, self.alpha = get("contact", n + 1, 1), get("alpha", n + 1, 1.5)
        self.rest, self.gamma = get("overlap", n + 1, 0), get("viscoelastic", n + 1, 0)
        # None: no resonator; "wall": one at rest; else its mass.
        self.resonator = [
            None if k == 0 or r == 0 else "wall" if r is None else r * m for k, r, m in zip(self.kappa, self.rho, self.mass)
        ]
        self.closed, self.gauss = set(), gauss(nodes)

    def power(self, g, alpha):
        whole, half = divmod(int(2 * alpha), 2)
        return g**whole * (sqrt(g) if half else 1)

    def drive(self, key, t):
        """Value, rate and second derivative of amplitude sin(omega t + phase)."""
        _, a, omega, phase = self.case[key]
        x = mpf(omega) * t + mpf(phase)
        return a * sin(x), a * mpf(omega) * cos(x), -a * mpf(omega) ** 2 * sin(x)

    def overlap(self, y, b):
        n = self.n
        left = lambda k: y[k + b - 1] if b > 0 else mpf(0)
        right = lambda k: y[k + b] if b < n else mpf(0)
        return self.rest[b] + left(0) - right(0), left(2 * n) - right(2 * n)

    def force(self, y, b):
        """Force and elastic part of a bond that is in contact and pushes."""
        g, rate = self.overlap(y, b)
        elastic = self.contact[b] * self.power(abs(g), self.alpha[b])
        drag = self.contact[b] * self.gamma[b] * self.alpha[b] * self.power(abs(g), self.alpha[b] - 1) * rate if self.gamma[b] else mpf(0)
        return elastic + drag, elastic, rate

    def watched(self, y, b):
        """Overlap, and the sign of the force, which is that of g + gamma alpha g'."""
        g, rate = self.overlap(y, b)
        return g, g + self.gamma[b] * self.alpha[b] * rate

    def rates(self, t, y):
        n = self.n
        f, lost = [mpf(0)] * (n + 1), mpf(0)
        for b in range(n + 1):
            if (b, 0) in self.closed:
                force, elastic, rate = self.force(y, b)
                if self.gamma[b] and (b, 1) not in self.closed:
                    force = mpf(0)
                f[b] = force
                if self.gamma[b]:
                    lost += (force - elastic) * rate
        du, dv, dp, dw = [], [], [], []
        drag = dash = driven = mpf(0)
        for i in range(n):
            u, v, p, w = (y[k * n + i] for k in range(4))
            kind, push = self.resonator[i], f[i] - f[i + 1]
            pull = mpf(0)
            if kind is not None:
                moving = kind != "wall"
                stretch, slide = (u - v, p - w) if moving else (u, p)
                pull = self.kappa[i] * stretch + self.dashpot[i] * slide
                dash += self.dashpot[i] * slide * slide
            acceleration = (push - pull - self.drag[i] * p) / self.mass[i]
            drag += self.drag[i] * p * p
            if "pushed" in self.case and self.case["pushed"][0] == i:
                value = self.drive("pushed", t)[0]
                acceleration += value / self.mass[i]
                driven += value * p
            if "moved" in self.case and self.case["moved"][0] == i:
                _, first, second = self.drive("moved", t)
                driven += self.mass[i] * second * p - push * p
                p, acceleration = first, second
            du.append(p)
            dp.append(acceleration)
            moving = kind is not None and kind != "wall"
            dv.append(w if moving else mpf(0))
            dw.append(pull / kind if moving else mpf(0))
        return du + dv + dp + dw + [drag, dash, lost, driven]

    def over(self, t0, t1, y):
        """From t0 to t1, with square-root singularities allowed at both."""
        length, (c, a, b) = t1 - t0, self.gauss
        pieces = self.pieces + int(3 * length)
        for k in range(pieces):
            s = [(k + x) / pieces for x in c]
            times = [t0 + length * x * x * (3 - 2 * x) for x in s]
            speeds = [length * 6 * x * (1 - x) / pieces for x in s]
            whole = [fixed(x) for x in y]
            slope = lambda t, speed, z: [fixed(speed * r) for r in self.rates(t, z)]
            columns = list(zip(*[slope(t, speed, y) for t, speed in zip(times, speeds)]))
            move = lambda row: [ldexp(z + (sum(map(int.__mul__, row, column)) >> BITS), -BITS) for z, column in zip(whole, columns)]
            while True:
                new = list(zip(*[slope(t, speed, move(row)) for t, speed, row in zip(times, speeds, a)]))
                apart = max(abs(p - q) for x, z in zip(new, columns) for p, q in zip(x, z))
                columns = new
                if apart < 1 << (BITS - 76):
                    break
            y = move(b)
        return y

    def begin(self):
        case = self.case
        u, v, p, w = ([mpf(x) for x in part] for part in start(case))
        if "moved" in case:
            site = case["moved"][0]
            u[site], p[site], _ = self.drive("moved", mpf(0))
        for i, kind in enumerate(self.resonator):
            if kind is None or kind == "wall":
                v[i] = w[i] = mpf(0)
        y = u + v + p + w + [mpf(0)] * 4
        self.closed = {(b, k) for b in range(self.n + 1) for k in range(2) if self.watched(y, b)[k] > 0}
        return y

    def end(self, events):
        y, t = self.begin(), mpf(0)
        for (b, k), near in events:
            value = lambda z: self.watched(z, b)[k]
            t0, t1 = mpf(near), mpf(near) + mpf(10) ** -7
            z0, z1 = self.over(t, t0, y), self.over(t, t1, y)
            while abs(t1 - t0) > mpf(10) ** -14:
                g0, g1 = value(z0), value(z1)
                if g0 == g1:
                    break
                t0, t1, z0 = t1, t1 - g1 * (t1 - t0) / (g1 - g0), z1
                z1 = self.over(t, t1, y)
            y, t = z1, t1
            self.closed ^= {(b, k)}
        return self.over(t, mpf(self.case["end"]), y)

    def energy(self, y):
        n, total = self.n, mpf(0)
        for i in range(n):
            u, v, p, w = (y[k * n + i] for k in range(4))
            kind = self.resonator[i]
            total += self.mass[i] * p * p / 2
            if kind == "wall":
                total += self.kappa[i] * u * u / 2
            elif kind is not None:
                total += kind * w * w / 2 + self.kappa[i] * (u - v) ** 2 / 2
        for b in range(n + 1):
            g = self.overlap(y, b)[0]
            if g > 0:
                total += self.contact[b] * self.power(g, self.alpha[b] + 1) / (self.alpha[b] + 1)
        drag, dash, lost, driven = y[4 * n :]
        return total + drag + dash + lost - driven


def gauss(m):
    """Nodes, matrix and weights of the rule with m points on [0, 1]."""
    import mpmath

    nodes = sorted((1 + x) / 2 for x in mpmath.polyroots(mpmath.taylor(lambda x: mpmath.legendre(m, x), 0, m)[::-1], maxsteps=500, extraprec=300))
    def integrals(i):
        others = [x for j, x in enumerate(nodes) if j != i]
        poly = [mpf(1)]
        for x in others:
            poly = [(poly[k - 1] if k > 0 else 0) - x * (poly[k] if k < len(poly) else 0) for k in range(len(poly) + 1)]
            poly = [mpf(z) for z in poly]
        scale = mpmath.fprod(nodes[i] - x for x in others)
        return lambda s: sum(c * s ** (k + 1) / (k + 1) for k, c in enumerate(poly)) / scale
    with mpmath.workdps(60):
        lagrange = [integrals(i) for i in range(m)]
        a = [[lagrange[j](nodes[i]) for j in range(m)] for i in range(m)]
        b = [lagrange[j](mpf(1)) for j in range(m)]
    return nodes, [[fixed(x) for x in row] for row in a], [fixed(x) for x in b]


def events(case, steps=20_000):
    """The order of events, and their times to about 1e-6: small steps in double precision."""
    mp_case = Motion(case, 1, 1)
    for name in ["mass", "kappa", "rho", "drag", "dashpot", "contact", "alpha", "rest", "gamma", "resonator"]:
        setattr(mp_case, name, [x if x is None or x == "wall" else float(x) for x in getattr(mp_case, name)])
    import math

    g = globals()
    saved = {name: g[name] for name in ["mpf", "sin", "cos", "sqrt"]}
    g.update(mpf=float, sin=math.sin, cos=math.cos, sqrt=math.sqrt)
    found = []
    try:
        y, h = mp_case.begin(), case["end"] / steps
        watch = [(b, k) for b in range(mp_case.n + 1) for k in range(2) if k == 0 or mp_case.gamma[b]]
        values = lambda y: [mp_case.watched(y, b)[k] for b, k in watch]

        def slope(t, y):
            mp_case.closed = {(b, k) for b in range(mp_case.n + 1) for k in range(2) if mp_case.watched(y, b)[k] > 0}
            return mp_case.rates(t, y)

        before = values(y)
        for step in range(steps):
            t = h * step
            a = slope(t, y)
            b = slope(t + h / 2, [y + h / 2 * d for y, d in zip(y, a)])
            c = slope(t + h / 2, [y + h / 2 * d for y, d in zip(y, b)])
            d = slope(t + h, [y + h * d for y, d in zip(y, c)])
            y = [y + h / 6 * (a + 2 * b + 2 * c + d) for y, a, b, c, d in zip(y, a, b, c, d)]
            after = values(y)
            for key, x, z in zip(watch, before, after):
                if (x > 0) != (z > 0):
                    found.append((key, h * (step + x / (x - z))))
            before = after
    finally:
        g.update(saved)
    return sorted(found, key=lambda event: event[1])


def by_quad(case, nodes):
    """Number of events, change of energy and end state, by the program quad.c (needs gcc and libquadmath)."""
    here, n = Path(__file__).parent, len(case["mass"])
    with tempfile.TemporaryDirectory() as folder:
        program = f"{folder}/quad"
        subprocess.run(["gcc", "-O2", str(here / "quad.c"), "-lquadmath", "-lm", "-o", program], check=True)
        parts = start(case)
        gone = [k == 0 or r in (0, "inf") for k, r in zip(case["kappa"], case["rho"])]
        for part in (parts[1], parts[3]):
            part[:] = [0.0 if none else x for none, x in zip(gone, part)]
        zeros, still = [0.0] * n, [-1, 0.0, 0.0, 0.0]
        other = {"drag": zeros, "dashpot": zeros, "viscoelastic": [0.0] * (n + 1), "moved": still, "pushed": still}
        keys = ["mass", "kappa", "rho", "drag", "dashpot", "contact", "alpha", "overlap", "viscoelastic", "moved", "pushed"]
        lists = [case[key] if key in case else other[key] for key in keys] + list(parts)
        text = "\n".join([f"{n} {case['end']}"] + [" ".join(str(x) for x in row) for row in lists])
        out = subprocess.run([program, str(nodes)], input=text, text=True, capture_output=True, check=True).stdout.split()
    numbers = [mpf(a) + mpf(b) for a, b in zip(out[2::2], out[3::2])]
    return int(out[0]), float(out[1]), numbers if "drag" in case else numbers[: 4 * n]


def doubles(x):
    high = float(x)
    return [repr(high), repr(float(x - mpf(high)))]


def main(names):
    for name in names or CASES:
        case = CASES[name]
        if case.get("quad"):
            (count, drift, y), (_, _, z) = by_quad(case, 12), by_quad(case, 11)
            bound = 1e-13
        else:
            turns = events(case)
            count = len(turns)
            fine, other = Motion(case, 12, 3), Motion(case, 11, 4)
            y, z = fine.end(turns), other.end(turns)
            drift = float(abs(fine.energy(y) - fine.energy(Motion.begin(fine))))
            bound = 1e-17
        error = float(max(abs(a - b) for a, b in zip(y, z)))
        print(f"{name}: {count} events, error {error:.1e}, energy {drift:.1e}", flush=True)
        assert error < bound and drift < bound
        u, v, p, w = start(case)
        value = {
            "what": "u, v, u', v', drag, dashpots, contacts, driven as unevaluated sums of two doubles",
            "by": "tests/reference/details.py: Gauss collocation between events",
            "case": case, "events": count, "error": error,
            "start": {"u": u, "v": v, "u_dot": p, "v_dot": w},
            "state": [doubles(x) for x in y],
        }
        path = Path(__file__).with_name(f"details-{name}.json")
        path.write_text(json.dumps(value, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
