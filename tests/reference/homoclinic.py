"""Reference values of the homoclinic solutions of (dpsstat), written to homoclinic.csv beside this file.

With a_n = (-1)^n b_n the equation is b_n = (b_n + b_{n+1})^alpha + (b_{n-1} + b_n)^alpha. Here it is solved by shooting: from b_0 (site) or b_1 = b_0
(bond) the map gives all others, and bisection finds the value between those that leave below zero and those that turn up again. 1000 digits carry the
shots down to the smallest normal double. Needs mpmath; nothing else uses this script.
"""

import csv
import pathlib
from mpmath import mp, mpf

mp.dps = 1000
SMALLEST = mpf(2) ** -1022


def shot(alpha, first, center, most=200):
    """The values up to where they leave, and on which side: -1 below zero, 1 upwards, 0 neither."""
    before = first if center == "bond" else None
    values = [first]
    while len(values) < most:
        b = values[-1]
        if before is None:
            rest = b / 2
        else:
            rest = b - (before + b) ** alpha
        if rest <= 0:
            return values, -1
        after = rest ** (1 / alpha) - b
        if after <= 0:
            return values, -1
        if after >= b:
            return values, 1
        before = b
        values.append(after)
        if after < SMALLEST / 10 ** 40:
            return values, 0
    return values, 0


def homoclinic(alpha, center):
    # The uniform solution b = 2 (2b)^alpha turns up at once; twice as much leaves.
    low = mpf(2) ** (-(alpha + 1) / (alpha - 1))
    high = low
    side = {}
    while True:
        high *= mpf("1.02")
        if shot(alpha, high, center)[1] == -1:
            break
        low = high
    for _ in range(int(mp.prec) + 10):
        middle = (low + high) / 2
        values, where = shot(alpha, middle, center)
        if where == 0:
            break
        if where == -1:
            high = middle
        else:
            low = middle
    return values


with open(pathlib.Path(__file__).with_name("homoclinic.csv"), "w", newline="") as file:
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["alpha", "center", "n", "b"])
    for alpha in ["1.5", "2.5", "5", "10"]:
        for center in ["site", "bond"]:
            first = 0 if center == "site" else 1
            for k, b in enumerate(homoclinic(mpf(alpha), center)):
                if b < SMALLEST:
                    break
                out.writerow([alpha, center, first + k, mp.nstr(b, 25)])
