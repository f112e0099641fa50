"""Writes averages.csv: g_alpha, h_alpha and their derivatives to 30 digits (needs mpmath).

    python3 averages.py > averages.csv

The arguments are doubles, taken as exact. Values come from Gauss's hypergeometric function in 120 digits: for |s| < 1, s = b/(2 kappa r),
from Mehler's integral, else from the binomial series, which are different functions and agree at s = -1. Before a row is written
g and h are held against the defining integrals, by quadrature split at the contact's end, and every derivative against a central
difference of g and h: another route altogether, as no identity for derivatives enters it. A row that disagrees stops the program.
"""

import sys
from mpmath import mp, mpf, hyp2f1, gamma, sqrt, pi, cos, quad, nstr

mp.dps = 120
ALPHAS = [1e-3, 0.1, 0.3, 0.5, 0.7, 1 - 1e-9, 1.0, 1.25, 1.5, 1.5 + 1e-9, 2.0, 2.5, 3.0, 4.7, 10.0]
SPANS = [-1e8, -30.0, -3.0, -1.5, -1.15, -1.0625, -1.001, -1 - 1e-9, -1 - 2.0**-52, -1.0, -1 + 2.0**-53, -1 + 1e-9, -0.999,
         -0.8, -0.5, -0.49, -0.1, 0.0, 0.3, 0.75, 0.99, 1 - 1e-9, 1 - 2.0**-53]
# kappa, r; the last two of them leave 2 kappa r inexact in double precision.
PLACES = [(1.0, 1.0), (0.25, 2.0**70), (2.0**-30, 0.5), (0.7, 1.3), (3.3e5, 7.1e-3)]
# alpha, kappa, b, r: far scales and limits.
EXTREMES = [
    (1.5, 1.0, -1e200, 1e200), (1.5, 1.0, 1e200, 1e200), (1.5, 1.0, -1e-200, 1e-200), (1.5, 1.0, 0.0, 1e-200),
    (1.5, 1e-200, -1.0, 1e200), (1.5, 1e200, 0.3, 1e-200), (1.5, 1e200, -5.0, 1e-200), (0.7, 1e-200, -1e-200, 1e-200),
    (0.7, 1e-200, 0.0, 1e-200), (0.3, 1e200, 1.0, 1e200), (0.3, 1e200, -1e300, 1e200), (1.0, 1.0, -1e200, 1e-200),
    (2.5, 1.0, -1e100, 1e-200), (0.9, 1.0, -1e200, 1e-200), (2.7, 1.0, -1e100, 1e-100), (10.0, 1.0, -1e30, 1e30),
    (10.0, 1.0, 1e-30, 1e-30), (10.0, 1.0, -1e30, 1e-200), (10.0, 1e100, -1.0, 1e-105), (0.1, 1.0, -1e-200, 1e-200),
    (0.1, 1.0, -1e200, 1e200), (0.1, 1.0, -1e-200, 3e-201), (0.5, 1.0, 1e200, 5.000000000000001e199), (1.5, 1.0, -1.0, 0.0),
    (1.5, 0.3, -7.0, 1e-300), (0.5, 2.0, -1e-3, 0.0), (3.0, 1.0, -2.0, 1e-160), (1.5, 1.0, -1.0, 1e-8), (1.5, 1.0, 5.0, 1.0),
    (1.5, 1.0, 2.0, 1.0), (0.3, 1.0, 2.0, 1.0), (1.5, 1e-150, 0.0, 1e-150), (2.0, 1e-120, 1e-250, 1e-120),
]


def harmonic(n, alpha, s, swing):
    """1/(2 pi) int cos(n t) (-b + swing cos t)_+^alpha dt, b = s swing; alpha > -1."""
    if s >= 1:
        return mpf(0)
    if s > -1:
        w = (1 - s) / 2
        front = 2**alpha * gamma(alpha + 1) / (sqrt(pi) * gamma(alpha + mpf(3) / 2)) * w ** (alpha + mpf(1) / 2)
        return swing**alpha * front * hyp2f1(mpf(1) / 2 - n, mpf(1) / 2 + n, alpha + mpf(3) / 2, w, zeroprec=2000)
    if s == -1 and alpha <= mpf(-1) / 2:
        sign = mp.sign(mp.binomial(alpha, n))
        return sign * mp.inf
    front = (-s * swing) ** alpha * (-1 / (2 * s)) ** n * mp.binomial(alpha, n)
    return front * hyp2f1((n - alpha) / 2, (n + 1 - alpha) / 2, n + 1, 1 / s**2, zeroprec=2000)


def values(alpha, kappa, b, r):
    """g, h, dg_db, dg_dr, dh_db, dh_dr; r = 0 by its limit, zeros for b >= 2 kappa r."""
    if b >= 2 * kappa * r:
        return [mpf(0)] * 6
    if r == 0:
        d = -b
        slope = -kappa * alpha * (alpha - 1) * d ** (alpha - 2)
        return [d**alpha, kappa * alpha * d ** (alpha - 1), -alpha * d ** (alpha - 1), mpf(0), slope, mpf(0)]
    swing = 2 * kappa * r
    s = b / swing
    g, first = (harmonic(n, alpha, s, swing) for n in (0, 1))
    q = [harmonic(n, alpha - 1, s, swing) for n in (0, 1, 2)]
    return [g, first / r, -alpha * q[0], 2 * kappa * alpha * q[1], -alpha * q[1] / r, 2 * kappa * alpha * q[2] / r]


def by_quadrature(alpha, kappa, b, r):
    """g and h from the definition; the contact's end with t = t_c (1 - x), the overlap as a product without cancellation."""
    swing = 2 * kappa * r
    s = b / swing
    short = -1 < s
    t_c = 2 * mp.atan2(sqrt(1 - s), sqrt(1 + s)) if short else pi

    def overlap(x):
        """Over the largest, as the quadrature's tolerance is absolute."""
        t = t_c * (1 - x)
        return (2 * mp.sin(t_c * (1 - x / 2)) * mp.sin(t_c * x / 2) if short else cos(t) - s) / (1 - s)

    # Graded towards the end, where the overlap is near singular for s near -1.
    splits = [mpf(0)] + [mpf(10) ** -k for k in range(8 if abs(1 + s) > 1e-3 else 24, 0, -2)] + [mpf(1)]
    front = (swing - b) ** alpha * t_c / pi
    g = quad(lambda x: overlap(x) ** alpha, splits) * front
    first = quad(lambda x: overlap(x) ** alpha * cos(t_c * (1 - x)), splits) * front
    return g, first / r


def close(x, y, scale, digits):
    return x == y or abs(x - y) <= mpf(10) ** -digits * max(abs(x), abs(y), scale)


def check(alpha, kappa, b, r, row):
    g, h, *slopes = row
    if b < 2 * kappa * r and r > 0:
        mp.dps = 50
        if 1e-20 < abs(2 * kappa * r / b if b else 1) and abs(b) < 1e6 * 2 * kappa * r:
            g_quad, h_quad = by_quadrature(alpha, kappa, b, r)
            assert close(g, g_quad, 0, 24) and close(h, h_quad, g / r * mpf(10) ** -4, 24), (alpha, kappa, b, r, g, g_quad, h, h_quad)
        # A swing far below b moves g in digits far behind the first.
        mp.dps = 120 + (int(3 * mp.log10(abs(b) / (kappa * r))) if abs(b) > kappa * r else 0)
        gap = min(abs(b - 2 * kappa * r), abs(b + 2 * kappa * r))
        if gap > 0:
            step = gap * mpf(10) ** -22
            db = [(p - m) / (2 * step) for p, m in zip(values(alpha, kappa, b + step, r)[:2], values(alpha, kappa, b - step, r)[:2])]
            step = min(gap / (2 * kappa), r) * mpf(10) ** -22
            dr = [(p - m) / (2 * step) for p, m in zip(values(alpha, kappa, b, r + step)[:2], values(alpha, kappa, b, r - step)[:2])]
            natural = [g / gap, 2 * kappa * g / gap, h / gap, 2 * kappa * h / gap]
            for slope, difference, scale in zip(slopes, [db[0], dr[0], db[1], dr[1]], natural):
                assert close(slope, difference, scale * mpf(10) ** -3, 36), (alpha, kappa, b, r, slope, difference)
        mp.dps = 120


def main():
    rows = [(a, *PLACES[(i + j) % len(PLACES)], s) for i, a in enumerate(ALPHAS) for j, s in enumerate(SPANS)]
    points = [(a, k, s * (2 * k * r), r) for a, k, r, s in rows] + EXTREMES
    for line in __doc__.strip().splitlines():
        print("# " + line if line else "#")
    print("alpha,kappa,b,r,g,h,dg_db,dg_dr,dh_db,dh_dr")
    for point in points:
        row = values(*map(mpf, point))
        check(*map(mpf, point), row)
        print(",".join([repr(float(x)) for x in point] + [nstr(x, 30, strip_zeros=False, min_fixed=1, max_fixed=0) for x in row]))
        sys.stdout.flush()


main()
