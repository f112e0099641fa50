"""Y0 and Z1 of proofs/README.md in floating point, for the test `bounds_are_those_of_the_formulas`.

Written from the formulas, with quadrature by mpmath between the zeros of X; needs mpmath and numpy.
"""

from math import cos, inf, pi, sqrt

import numpy as np
from mpmath import mp, mpf, quad, findroot, cos as mcos

mp.dps = 20


def moments(a, alpha, count):
    """n_k, d_k for k <= count, the means of N^2 and D^2, and the largest overlap."""
    x = lambda t: sum(mpf(c) * mcos(k * t) for k, c in enumerate(a))
    grid = [mp.pi * i / 400 for i in range(401)]
    values = [x(t) for t in grid]
    ends = [grid[0]]
    for s, t, u, v in zip(grid, grid[1:], values, values[1:]):
        if u * v < 0:
            ends.append(findroot(x, (s, t), solver="anderson"))
    ends.append(grid[-1])
    force = lambda t: max(-x(t), 0) ** alpha
    stiff = lambda t: alpha * max(-x(t), 0) ** (alpha - 1)
    mean = lambda f: float(sum(quad(f, [s, (s + t) / 2, t]) for s, t in zip(ends, ends[1:])) / mp.pi)
    coefficients = lambda f: [(2 if k else 1) * mean(lambda t: f(t) * mcos(k * t)) for k in range(count + 1)]
    overlap = float(max(0, *[-v for v in values]))
    return coefficients(force), coefficients(stiff), mean(lambda t: force(t) ** 2), mean(lambda t: stiff(t) ** 2), overlap


def tail(series, square, last):
    return sqrt(max(0, 2 * (square - series[0] ** 2) - sum(f * f for f in series[1 : last + 1])))


def matrix(d, rows, columns):
    """D as a matrix on cosines."""
    h = lambda l: d[0] if l == 0 else d[l] / 2
    entry = lambda k, j: d[k] if j == 0 else h(j) if k == 0 else h(abs(k - j)) + h(k + j)
    return np.array([[entry(k, j) for j in columns] for k in rows])


def inverse_l(k, kappa, rho, omega):
    if rho == inf:
        return 1 / (kappa - (omega * k) ** 2)
    w = rho * (omega * k) ** 2
    return -(kappa - w) / ((omega * k) ** 2 * (kappa * (1 + rho) - w))


def decay(last, kappa, rho, omega):
    w = (omega * (last + 1)) ** 2
    extra = kappa / (w - kappa) if rho == inf else kappa * rho / (rho * w - kappa * (1 + rho))
    return (1 + extra) / omega**2


def wave(alpha, kappa, rho, omega, q, mean, a, K, last):
    x = [mean, *a]
    n, d, n2, d2, overlap = moments(x, alpha, last)
    x += [0] * (last + 1 - len(x))
    c = [0] + [(2 - 2 * cos(k * q)) * inverse_l(k, kappa, rho, omega) for k in range(1, last + 1)]
    edge = 4 * decay(last, kappa, rho, omega) / sqrt(3 * last**3)
    t = sqrt(sum(v * v for v in c[K + 1 :]) + edge**2)
    block = range(1, K + 1)
    C = np.diag(c[1 : K + 1])
    A = np.linalg.inv(np.eye(K) + C @ matrix(d, block, block))
    M = A @ C
    R = sum(np.linalg.norm(row) for row in M)
    g = [x[k] - c[k] * n[k] for k in range(last + 1)]
    y0 = np.abs(A @ g[1 : K + 1]).sum() + sum(abs(v) for v in g[K + 1 :]) + edge * tail(n, n2, last)
    J = last - K
    far = range(K + 1, J + 1)
    columns = np.abs(M @ matrix(d, block, far)).sum(axis=0).max()
    m = alpha * overlap ** (alpha - 1)
    z1 = max(columns, R * tail(d, d2, J - K) / sqrt(2)) + t * min(m, sqrt(2 * d2))
    return y0, z1


def breather(alpha, kappa, rho, omega, center, sites, mean, a, K, last):
    half = len(a)
    known = [moments(row, alpha, last) for row in a]
    site = center == "site"
    numbers = list(range(half)) if site else list(range(1, half + 1))

    def fold(n):
        """Site of the half, and whether its strain is that of half a period later."""
        n = n % sites
        if n in numbers:
            return numbers.index(n), False
        return (numbers.index(-n % sites), True) if site else (numbers.index((1 - n) % sites), center == "doubled")

    def second(i, k):
        row = np.zeros(half)
        for step, factor in ((0, 2), (1, -1), (-1, -1)):
            j, turned = fold(numbers[i] + step)
            row[j] += -factor if turned and k % 2 else factor
        return row

    moduli = np.array([second(i, 0) * 0 for i in range(half)])
    for i in range(half):
        for step, factor in ((0, 2), (1, 1), (-1, 1)):
            moduli[i][fold(numbers[i] + step)[0]] += factor
    share = np.array([sum(fold(n)[0] == i for n in range(sites)) for i in range(half)]) / sites
    alone = {"site": 0, "bond": None, "doubled": half - 1}[center]
    has = lambda i, k: not (i == alone and k % 2)
    unknowns = [(i, k) for i in range(half) for k in range(K + 1) if has(i, k)]
    size = len(unknowns) + 1
    l = [0] + [inverse_l(k, kappa, rho, omega) for k in range(1, last + 1)]
    edge = decay(last, kappa, rho, omega) / sqrt(3 * last**3)
    t = sqrt(sum(v * v for v in l[K + 1 :]) + edge**2)
    D = [matrix(one[1], range(K + 1), range(last - K + 1)) for one in known]
    B = np.zeros((size, size - 1))
    P = np.zeros((size, size))
    for r, (i, k) in enumerate(unknowns):
        for s, (j, p) in enumerate(unknowns):
            if k == 0:
                B[r, s] = -1.0 if (i, k) == (j, p) else 0
            elif p == k:
                B[r, s] = second(i, k)[j] * l[k]
        P[r, r] = 0 if k == 0 else 1
        if k == 0:
            P[r, -1] = -1
            P[-1, r] = share[i]
    full = np.zeros((size - 1, size - 1))
    for r, (i, k) in enumerate(unknowns):
        for s, (j, p) in enumerate(unknowns):
            full[r, s] = D[i][k, p] if i == j else 0
    DG = P.copy()
    DG[:, :-1] += B @ full
    A = np.linalg.inv(DG)
    M = A @ B
    w = lambda k: sqrt(2) if k == 0 else 1
    rows_of = lambda i: [r for r, (j, _) in enumerate(unknowns) if j == i]
    R = np.array([
        [
            sum(w(unknowns[r][1]) * sqrt(sum((M[r, s] / w(unknowns[s][1])) ** 2 for s in rows_of(j))) for r in rows_of(i))
            for j in range(half)
        ]
        for i in range(half)
    ])
    contact = R + t * moduli
    W = np.ones(half)
    for _ in range(50):
        W = contact @ W
        W = np.clip(W / W.max(), 0.01, 1)
    get = lambda i, k: a[i][k] if k < len(a[i]) else 0
    defect = lambda i, k: get(i, k) - l[k] * sum(f * known[j][0][k] for j, f in enumerate(second(i, k)))
    c0 = known[0][0][0]
    G = [known[i][0][0] - c0 if k == 0 else defect(i, k) for i, k in unknowns] + [share @ [row[0] for row in a] - mean]
    step = np.abs(A @ G)
    tails = moduli @ [tail(one[0], one[2], last) for one in known]
    y0 = max(
        (sum(w(unknowns[r][1]) * step[r] for r in rows_of(i)) + sum(abs(defect(i, k)) for k in range(K + 1, last + 1) if has(i, k)) + edge * tails[i]) / W[i]
        for i in range(half)
    )
    J = last - K
    largest = np.zeros((half, half))
    for j in range(half):
        far = tail(known[j][1], known[j][3], J - K) / sqrt(2)
        inner = [k for i, k in unknowns if i == j]
        for i in range(half):
            columns = [R[i, j] * far]
            for p in (p for p in range(K + 1, J + 1) if has(j, p)):
                column = M[:, rows_of(j)] @ D[j][inner, p]
                columns.append(sum(w(unknowns[r][1]) * abs(column[r]) for r in rows_of(i)))
            largest[i, j] = max(columns)
    steepest = [min(alpha * one[4] ** (alpha - 1), sqrt(2 * one[3])) for one in known]
    z1 = max((largest @ W + t * (moduli @ (steepest * W))) / W)
    return y0, z1


WAVE = [0.0083, -1.7e-5, 3e-6, 1e-6]
ROWS = {
    "site": [[-0.04, 0, 0.006, 0], [0.002, -0.15, 0.001, 0.002], [-0.003, 0.16, -0.002, 0.001]],
    "bond": [[-0.03, 0.08, 0.003, 0.001], [0.01, -0.15, 0.004, 0.002], [-0.02, 0.16, -0.002, 0.001]],
    "doubled": [[-0.03, 0.08, -0.1, 0.004], [0.01, -0.03, 0.15, 0.002], [-0.02, 0, -0.16, 0]],
}
for q, arguments in [
    ("1/5", (1.5, 1, 1 / 3, 2.001, pi / 5, 0, WAVE, 2, 8)),
    ("4/5", (2.5, 2, inf, 1.9, 0.8 * pi, -0.001, [100 * a for a in WAVE], 2, 8)),
    ("1/2", (1.2, 1, 3, 1.2, pi / 2, 0.002, WAVE, 1, 6)),
]:
    print("wave", q, arguments[:4], "%.9e, %.9e" % wave(*arguments))
for center, rows in ROWS.items():
    omega = 1.033 if center == "doubled" else 2.05
    print("breather", center, "%.9e, %.9e" % breather(1.5, 1, 1 / 3, omega, center, 5, 0.01, rows, 2, 8))
