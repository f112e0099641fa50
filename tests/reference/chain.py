"""Writes chain-6-alpha-*.json: end states of the order study's six beads to 30 digits (standard library only).

    python3 chain.py

Shares no code and no method with hertzchain. Numbers are integers over 2^BITS. Between two events the motion is analytic in s, where
t = a + l s^2 after the event at a and t = b - l (1 - s)^2 before the one at b; it is found there by Gauss collocation (order 2 NODES) and
fixed-point iteration. The time b of the next event is the zero of that bond's overlap, by Newton's method. The order of the events comes
from a run in double precision with many small steps of the classical fourth-order method. "error" is the largest difference from a
second computation with other nodes, other pieces and other turning points of the map, and the energy must be kept to that size.
"""

import json
import math
from fractions import Fraction
from pathlib import Path

ALPHAS = [1.5, 2.0, 2.5, 3.0]
BEADS, KAPPA, RHO, END = 6, 1.0, 1.0 / 3.0, 12.0
BITS = 160
ONE = 1 << BITS
# A correction below this ends an iteration.
SMALL = 1 << 36


def fixed(x):
    return int(Fraction(x) * ONE)


def mul(a, b):
    return a * b >> BITS


def div(a, b):
    return (a << BITS) // b


STIFFNESS, MASS = fixed(KAPPA), fixed(RHO)
MASS_INVERSE = div(ONE, MASS)


def power(g, alpha):
    """g^alpha for g > 0 and 2 alpha a whole number."""
    whole, half = divmod(int(2 * alpha), 2)
    result = math.isqrt(g << BITS) if half else ONE
    for _ in range(whole):
        result = mul(result, g)
    return result


def start():
    """`generic_state` of src/study/integrators/order: every value is a double, taken as exact."""
    noise = lambda k: math.fmod(0.71055039 * k + 0.0925164, 1.0) - 0.5
    x = [n - 0.5 * (BEADS - 1.0) for n in range(BEADS)]
    u = [(x[n] + 0.3 * noise(2 * n)) / 7.0 for n in range(BEADS)]
    return u + [x / 7.0 for x in x] + [0.6 * noise(2 * n + 1) - 0.2 * x[n] for n in range(BEADS)] + [0.0] * BEADS


# --- The order of events, in double precision ---


def slope(y, alpha):
    u, v = y[:BEADS], y[BEADS : 2 * BEADS]
    f = [0.0] + [max(u[n - 1] - u[n], 0.0) ** alpha for n in range(1, BEADS)] + [0.0]
    spring = [KAPPA * (u[n] - v[n]) for n in range(BEADS)]
    return y[2 * BEADS :] + [f[n] - f[n + 1] - spring[n] for n in range(BEADS)] + [s / RHO for s in spring]


def events(alpha, steps=40_000):
    """Bond, whether it closes, and time to about 1e-6, of all changes of sign."""
    y, h, found = start(), END / steps, []
    overlaps = lambda y: [y[n - 1] - y[n] for n in range(1, BEADS)]
    for k in range(steps):
        before = overlaps(y)
        a = slope(y, alpha)
        b = slope([y + 0.5 * h * d for y, d in zip(y, a)], alpha)
        c = slope([y + 0.5 * h * d for y, d in zip(y, b)], alpha)
        d = slope([y + h * d for y, d in zip(y, c)], alpha)
        y = [y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d) for y, a, b, c, d in zip(y, a, b, c, d)]
        for n, (g, after) in enumerate(zip(before, overlaps(y))):
            if (g > 0.0) != (after > 0.0):
                found.append((n + 1, after > 0.0, h * (k + g / (g - after))))
    return sorted(found, key=lambda event: event[2])


# --- Gauss collocation on [0, 1] ---


def legendre(m, x):
    """P_0 .. P_m at x."""
    p = [ONE, x]
    for k in range(1, m):
        p.append(((2 * k + 1) * mul(x, p[k]) - k * p[k - 1]) // (k + 1))
    return p


class Gauss:
    def __init__(self, nodes):
        self.c, self.b, rows = [], [], []
        for i in range(nodes):
            x, by = fixed(math.cos(math.pi * (nodes - i - 0.25) / (nodes + 0.5))), ONE
            while abs(by) > SMALL:
                p = legendre(nodes, x)
                rise = div(nodes * (p[nodes - 1] - mul(x, p[nodes])), ONE - mul(x, x))
                by = div(p[nodes], rise)
                x -= by
            p = legendre(nodes, x)
            rise = div(nodes * p[nodes - 1], ONE - mul(x, x))
            self.c.append((ONE + x) // 2)
            self.b.append(div(ONE, mul(mul(rise, rise), ONE - mul(x, x))))
            # Integrals of P_k from -1 to x.
            rows.append((p, [ONE + x] + [(p[k + 1] - p[k - 1]) // (2 * k + 1) for k in range(1, nodes)]))
        # a_ij = b_j sum_k (2 k + 1) P_k(x_j) int_{-1}^{x_i} P_k / 2
        weight = lambda i, j: sum((2 * k + 1) * mul(rows[j][0][k], rows[i][1][k]) for k in range(nodes)) // 2
        self.a = [[mul(self.b[j], weight(i, j)) for j in range(nodes)] for i in range(nodes)]


# --- The motion between events ---


class Motion:
    """All runs with one rule: nodes of a piece, pieces a unit of time, and where a stretch is halved."""

    def __init__(self, alpha, nodes, pieces, middle):
        self.alpha, self.gauss, self.pieces, self.middle = alpha, Gauss(nodes), pieces, middle
        self.closed = {n for n in range(1, BEADS) if start()[n - 1] > start()[n]}

    def rates(self, y):
        u, v = y[:BEADS], y[BEADS : 2 * BEADS]
        f = [0] * (BEADS + 1)
        for n in self.closed:
            f[n] = power(max(u[n - 1] - u[n], 0), self.alpha)
        spring = [mul(STIFFNESS, u[n] - v[n]) for n in range(BEADS)]
        return y[2 * BEADS :] + [f[n] - f[n + 1] - spring[n] for n in range(BEADS)] + [mul(s, MASS_INVERSE) for s in spring]

    def piece(self, y, speeds):
        """The state after a piece; `speeds` are dt at the nodes, with the piece's length as unit of s."""
        gauss, guess = self.gauss, [y] * len(speeds)
        while True:
            slopes = [[mul(speed, rate) for rate in self.rates(z)] for z, speed in zip(guess, speeds)]
            columns = list(zip(*slopes))
            move = lambda row: [y + (sum(map(int.__mul__, row, column)) >> BITS) for y, column in zip(y, columns)]
            new = [move(row) for row in gauss.a]
            apart = max(abs(p - q) for a, b in zip(new, guess) for p, q in zip(a, b))
            guess = new
            if apart < SMALL:
                return move(gauss.b)

    def half(self, y, length, ends):
        """Over t = a + length s^2, or the mirror image of it if the half ends at an event."""
        pieces = 3 + (self.pieces * length >> BITS)
        for k in range(pieces):
            s = [(ONE * k + c) // pieces for c in self.gauss.c]
            y = self.piece(y, [2 * mul(length, ONE - s if ends else s) // pieces for s in s])
        return y

    def stretch(self, y, a, event):
        """From the time a to an event, or to the end; the state there, and the time."""
        bond, _, near = event
        half = a + mul(fixed(near) - a, fixed(self.middle))
        centre, b = self.half(y, half - a, False), fixed(near)
        while True:
            y = self.half(centre, b - half, True)
            if bond is None:
                return y, b
            by = div(y[bond - 1] - y[bond], y[2 * BEADS + bond - 1] - y[2 * BEADS + bond])
            b -= by
            if abs(by) < SMALL << 16:
                return y, b

    def end(self, events):
        y, t = [fixed(x) for x in start()], 0
        for event in events + [(None, None, END)]:
            y, t = self.stretch(y, t, event)
            if event[0] is not None:
                (self.closed.add if event[1] else self.closed.remove)(event[0])
        return y

    def energy(self, y):
        u, v, p, w = (y[k * BEADS : (k + 1) * BEADS] for k in range(4))
        square = lambda x: mul(x, x) // 2
        sites = sum(square(p) + mul(MASS, square(w)) + mul(STIFFNESS, square(u - v)) for u, v, p, w in zip(u, v, p, w))
        overlaps = [max(u[n - 1] - u[n], 0) for n in range(1, BEADS)]
        return sites + sum(div(power(g, self.alpha + 1), fixed(self.alpha + 1)) for g in overlaps if g > 0)


def doubles(x):
    """x as a sum of two doubles, as texts."""
    high = float(Fraction(x, ONE))
    return [repr(part) for part in (high, float(Fraction(x, ONE) - Fraction(high)))]


def main():
    for alpha in ALPHAS:
        turns = events(alpha)
        fine, other = Motion(alpha, 24, 6, 0.5), Motion(alpha, 22, 6, 0.4)
        y, z = fine.end(turns), other.end(turns)
        size = lambda x: float(Fraction(abs(x), ONE))
        error = max(size(a - b) for a, b in zip(y, z))
        drift = size(fine.energy(y) - fine.energy([fixed(x) for x in start()]))
        print(f"alpha = {alpha}: {len(turns)} events, error {error:.1e}, energy {drift:.1e}")
        assert error < 1e-30 and drift < 1e-30
        value = {
            "what": "u, v, u', v' as unevaluated sums of two doubles",
            "by": "tests/reference/chain.py: Gauss collocation between events",
            "start": "hertzchain::study::generic_state",
            "alpha": alpha, "kappa": KAPPA, "rho": RHO, "boundary": "free", "beads": BEADS, "t": END,
            "error": error,
            "state": [doubles(x) for x in y],
        }
        path = Path(__file__).with_name(f"chain-{BEADS}-alpha-{alpha:g}.json")
        path.write_text(json.dumps(value, indent=2) + "\n")


if __name__ == "__main__":
    main()
