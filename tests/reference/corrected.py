"""Contact-corrected splitting of three free beads, written from docs/corrected.md alone.

`.ci/python` runs it: with steps four times as short, the error at the end must be smaller by more
than 4^3.5.
"""

from math import log2, sqrt

alpha, mobility = 1.5, 2                  # three free beads, two contacts


def zeta(z, x, n=12):
    """Hurwitz' zeta function for z < 0, by the formula of Euler and Maclaurin."""
    y = x + n
    total = sum((k + x) ** -z for k in range(n)) + y ** (1 - z) / (z - 1) + y**-z / 2
    term = z * y ** (-z - 1)
    for j, b in enumerate([1 / 12, -1 / 720, 1 / 30240, -1 / 1209600, 1 / 47900160]):
        total, term = total + b * term, term * (z + 2 * j + 1) * (z + 2 * j + 2) / y**2
    return total


def slopes(g, r, a, theta, h):
    """dW/dg and dW/dg' at an event; g and r are overlap and rate at the time of the event."""
    def w(g, r):
        back = 2 * g / (r + sqrt(r * r - 2 * a * g))      # the zero is so much earlier
        c, x = r - a * back, max(theta + back / h, 0)
        second = c**alpha * a * h / 2 * zeta(-alpha - 2, x) / (1 + (a * h / c) ** 8)
        return h ** (alpha + 2) * (c ** (alpha + 1) * zeta(-alpha - 1, x) / (alpha + 1) + second)
    d = 1e-5 * r
    return (w(g + d * h, r) - w(g - d * h, r)) / (2 * d * h), (w(g, r + d) - w(g, r - d)) / (2 * d)


def force(g):
    return max(g, 0) ** alpha


def lack(g, e, h):
    """What a kick at the overlap g of the kernel lacks."""
    return h * (force(g + e) - force(g) - alpha * max(g, 0) ** (alpha - 1) * e)


def run(n, u=(0, 0.37, 0.71), v=(1, 0.1, -0.5), end=6.0):
    """Positions and velocities at the end; no beads touch at the start and at the end."""
    u, v, h, was = list(u), list(v), end / n, None
    for k in range(n + 1):
        g = [u[0] - u[1], u[1] - u[2]]
        f = [force(x) for x in g]
        for b in (0, 1) if was else ():
            if (g[b] > 0) == (was[0][b] > 0):
                continue
            sign = 1 if g[b] > 0 else -1
            p, q = was[1][1 - b], f[1 - b]                # s by the other contact at both kicks
            start, stop, jerk = was[0][b] + h * h / 12 * p, g[b] + h * h / 12 * q, (q - p) / h
            chord = (stop - start) / h + q * h / 2 - jerk * h * h / 6
            t = 0.0                                       # the zero of the path, before this kick
            for _ in range(20):
                rate = chord + q * t + jerk * t * t / 2
                t -= (stop + chord * t + q * t * t / 2 + jerk * t**3 / 6) / rate
            a, theta = q + jerk * t, -sign * t / h % 1
            by_g, by_r = slopes(0, sign * rate, a, theta, h)
            half = sign * mobility / 2
            by_g, by_r = slopes(-half * by_r, sign * rate + half * by_g, a, theta, h)
            earlier = lack(was[0][b], h * h / 12 * p, h)
            move = by_g * t + sign * by_r + earlier * h   # -by_g acts at t, earlier at -h
            push = -by_g + earlier + lack(g[b], h * h / 12 * q, h)
            for bead, side in ((b, -1), (b + 1, 1)):
                u[bead] += side * move
                v[bead] += side * push
        g = [u[0] - u[1], u[1] - u[2]]
        f = [force(x) for x in g]
        s = [f[1] - 2 * f[0], f[0] - 2 * f[1]]
        stiff = [alpha * max(x, 0) ** (alpha - 1) for x in g]
        kick = [h * (y + h * h / 12 * w * z) for y, w, z in zip(f, stiff, s)]
        share = 0.5 if k in (0, n) else 1
        v = [v[0] - share * kick[0], v[1] + share * (kick[0] - kick[1]), v[2] + share * kick[1]]
        was = g, f
        if k < n:
            u = [x + h * y for x, y in zip(u, v)]
    return u + v


truth = run(6400)
errors = [max(abs(x - y) for x, y in zip(run(n), truth)) for n in (100, 400)]
print(errors)
assert log2(errors[0] / errors[1]) / 2 > 3.5
