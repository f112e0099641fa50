"""A second checker of certificates, in ball arithmetic, of one wave or one breather of a ring.

    python proofs/second_checker.py FILE...

It shares no code with the checker in Rust, only the format of certificates and the equations of
README.md beside it. Numbers are balls of 113 bits (python-flint), the force is integrated by Gauss and
Legendre, pieces by Taylor's formula about their centres, and the conclusion is that of a Hoelder
continuous derivative. Lines of multipliers are not checked; branches and breathers of the infinite
chain are refused. Exit code 0: all are proved. 1: some are not. 2: some are no certificates.
"""

import struct
import sys
from functools import lru_cache, reduce

from flint import arb, arb_mat, ctx, fmpq

ctx.prec = 113
NODES = 20  # of a piece
RHO = 4  # parameter of Bernstein's ellipse
DEEPEST = 36  # pieces of this share 2^-DEEPEST of the half-period are bounded only
ZERO, ONE = arb(0), arb(1)
NODE = [arb.legendre_p_root(NODES, i, weight=True) for i in range(NODES)]


class Refused(Exception):
    """Why nothing is proved."""


def demand(holds, rule):
    if not holds:
        raise ValueError(rule)


def up(x):
    """The upper bound of a ball, as an exact ball."""
    if not x.is_finite():
        raise Refused("a number is not finite")
    return arb(x.upper())


def largest(balls):
    """A bound of the largest of numbers that are not negative."""
    return reduce(lambda most, ball: most.max(up(ball)), balls, ZERO)


def norm(balls):
    return sum(ball * ball for ball in balls).sqrt()


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def read(text):
    """The entries of a certificate, a list of words each, and the rows of coefficients."""
    lines = text.splitlines()
    demand(lines and lines[0] == "hertzchain certificate 2", "the first line is not that of a certificate")
    entries, rows = {}, []
    for line in lines[1:]:
        key, *words = line.split(" ")
        if key == "a":
            demand(all(len(word) == 16 for word in words), "a double has 16 hexadecimal digits")
            rows.append([arb(struct.unpack(">d", bytes.fromhex(word))[0]) for word in words])
        else:
            demand(words and (key == "multiplier" or key not in entries), f"the line {line!r} is empty, or there twice")
            entries[key] = words
    demand(rows and all(value.is_finite() for row in rows for value in row), "coefficients must be there, and finite")
    demand(len({len(row) for row in rows}) == 1, "rows have different lengths")
    return entries, rows


def fraction(word):
    above, _, below = word.partition("/")
    return fmpq(int(above), int(below or "1"))


class Chain:
    """The equations of one orbit: a_nk = l_k sum_m e_nm(k) n_mk for k >= 1."""

    def __init__(self, text):
        entries, self.a = read(text)
        if entries["kind"] not in (["wave"], ["breather"]) or {"to", "first"} & set(entries):
            raise Refused("only single waves and breathers of rings are checked here")
        one = lambda key: fraction(entries[key][0])
        self.power, kappa, omega = one("alpha"), one("kappa"), one("omega")
        rho = None if entries["rho"] == ["inf"] else one("rho")
        self.mean, self.block, self.last = arb(one("mean")), int(entries["block"][0]), int(entries["enclosed"][0])
        demand(self.power > 1 and kappa > 0 and omega > 0, "alpha > 1, kappa > 0, omega > 0")
        demand(rho is None or rho >= 0, "rho must be at least 0")
        self.site = entries["kind"] == ["breather"] and entries["center"] == ["site"]
        if entries["kind"] == ["wave"]:
            demand(len(self.a) == 1, "a wave has one row")
            self.a, self.ring, self.steps = [[self.mean, *self.a[0]]], 1, [(0, 1)]
            lattice = [2 - 2 * arb.cos_pi_fmpq(k * one("q_over_pi")) for k in range(self.last + 1)]
        else:
            self.ring, self.steps = int(entries["sites"][0]), [(0, 2), (1, -1), (-1, -1)]
            lattice, odd = [ONE] * (self.last + 1), self.site and any(value != 0 for value in self.a[0][1::2])
            demand(self.site or entries["center"] == ["bond"], "a centre is a site or a bond")
            demand(self.ring % 2 and 2 * len(self.a) == self.ring + 1, "sites are odd, with a row for each of the half")
            demand(rho is not None and not odd, "the resonators of a breather move, its centre has even harmonics only")
        fits = 1 <= self.block < len(self.a[0]) <= self.last + 1 and 4 * self.block <= self.last
        demand(fits, "1 <= block <= harmonics <= enclosed, 4 block <= enclosed")
        den = lambda w: kappa - w if rho is None else kappa * (1 + rho) - rho * w
        self.l = [ZERO]
        for k in range(1, self.last + 1):
            w = (omega * k) ** 2
            if den(w) == 0:
                raise Refused(f"harmonic {k} is resonant")
            self.l.append(lattice[k] * arb(1 / den(w) if rho is None else (rho * w - kappa) / (w * den(w))))
        # |l_k| <= c/k^2 beyond, since den < 0 there and |den| grows
        beyond = den((omega * (self.last + 1)) ** 2)
        if rho != 0 and beyond >= 0:
            raise Refused("harmonics beyond are not above the resonance")
        extra = 0 if rho == 0 else (kappa if rho is None else kappa * rho) / -beyond
        self.decay = (4 if self.ring == 1 else 1) * arb((1 + extra) / omega**2)

    def fold(self, n):
        """The row of a site of the ring, and whether it is that of half a period later."""
        row = min((n if self.site else n - 1) % self.ring, -n % self.ring)
        return row, self.site and n % self.ring > self.ring // 2

    def coupled(self, i, k):
        """e_nm(k) by row."""
        found = {}
        for step, factor in self.steps:
            row, turned = self.fold(i + step + (not self.site))
            found[row] = found.get(row, 0) + (-factor if turned and k % 2 else factor)
        return found

    def spread(self, i, values):
        """sum_m |e_nm| values_m, with a bound of |e_nm| for all k."""
        even, odd = self.coupled(i, 0), self.coupled(i, 1)
        return sum(max(abs(even[m]), abs(odd[m])) * values[m] for m in even)

    def has(self, i, k):
        return not (self.site and i == 0 and k % 2)


@lru_cache(maxsize=256)
def nodes(index, level, count):
    """The cosines at the nodes of a piece, and the weights."""
    shares = [(2 * index + 1 + node) / 2 ** (level + 1) for node, _ in NODE]
    rows = [[(k * share).cos_pi() for k in range(count + 1)] for share in shares]
    return arb_mat(rows), [arb.pi() / 2 ** (level + 1) * weight for _, weight in NODE]


class Moments:
    """Series of N = (-X)_+^alpha and D = alpha (-X)_+^(alpha-1), their mean squares, and sup(-X)."""

    def __init__(self, a, alpha, count):
        column, slopes = arb_mat(count + 1, 1, a + [ZERO] * (count + 1 - len(a))), [k * x for k, x in enumerate(a)]
        laws = lambda overlap: [overlap**alpha, alpha * overlap ** (alpha - 1)]
        series, squares, self.overlap = [[ZERO] * (count + 1)] * 2, [ZERO, ZERO], ZERO
        # up to the height of the ellipses of a level, for None of real z: |cos k z|, |sin k z|; |X''|
        height = lambda level: 0 if level is None else arb.pi() / 2 ** (level + 1) * (RHO - ONE / RHO) / 2
        growth = lru_cache(None)(lambda level: [(k * height(level) * ONE).cosh() for k in range(count + 1)])
        bent = lru_cache(None)(lambda level: dot(growth(level), (k * abs(x) for k, x in enumerate(slopes))))
        first = next(level for level in range(20) if 2**level * 6 >= count)
        pieces = [(i, first) for i in range(2**first)]
        for _ in range(20000):
            if not pieces:
                break
            index, level = pieces.pop()
            half, centre = arb.pi() / 2 ** (level + 1), arb(fmpq(2 * index + 1, 2 ** (level + 1)))
            x = sum((k * centre).cos_pi() * value for k, value in enumerate(a))
            slope = abs(sum((k * centre).sin_pi() * value for k, value in enumerate(slopes)))
            most = up(-x + slope * half + bent(None) * half * half / 2)
            self.overlap = self.overlap.max(most)
            if most <= 0:
                continue
            reach = half * (RHO + ONE / RHO) / 2
            apart = slope * reach + bent(level) * reach * reach / 2
            if -x - apart > 0:
                matrix, weights = nodes(index, level, count)
                values = zip(*(laws(-row[0]) for row in (matrix * column).tolist()))
                values = arb_mat([[w * v for v, w in zip(law, weights)] for law in values])
                series = [[s + o for s, o in zip(*both)] for both in zip(series, (values * matrix).tolist())]
                square = lambda law: sum(v * v / w for v, w in zip(law, weights))
                squares = [s + square(law) for s, law in zip(squares, values.tolist())]
                # |I - I_n| <= 8 M rho^{-2n}/(1 - 1/rho), M on the ellipse
                size, share = up(-x + apart), half * 8 * ONE / RHO ** (2 * NODES) / (1 - ONE / RHO)
            elif level >= DEEPEST:
                size, share, level = most, 2 * half, None
            else:
                pieces += [(2 * index, level + 1), (2 * index + 1, level + 1)]
                continue
            error = lambda v: [arb(0, up(share * v * g)) for g in growth(level)]
            series = [[s + e for s, e in zip(sums, error(v))] for sums, v in zip(series, laws(size))]
            squares = [s + arb(0, up(share * v * v)) for s, v in zip(squares, laws(size))]
        else:
            raise Refused("the contact force could not be enclosed")
        self.force, self.stiff = [[(2 if k else 1) * s / arb.pi() for k, s in enumerate(sums)] for sums in series]
        self.squares = [s / arb.pi() for s in squares]

    def tail(self, which, last):
        """A bound of (sum_{k > last} f_k^2)^(1/2), by Parseval."""
        series = (self.force, self.stiff)[which]
        rest = 2 * (self.squares[which] - series[0] ** 2) - sum(f * f for f in series[1 : last + 1])
        return up(rest).max(ZERO).sqrt()


def check(text):
    """The radius, Y0 and Z1 of a certificate; or Refused, or ValueError if it is none."""
    it = Chain(text)
    block, last, sites, alpha = it.block, it.last, range(len(it.a)), arb(it.power)
    weight = lambda k: ONE if k else arb(2).sqrt()
    half = lambda d, l: d[l] / (2 if l else 1)
    # the coefficient of cos k theta in D cos j theta
    product = lambda d, k, j: d[k] if j == 0 else half(d, abs(k - j)) + half(d, k + j) if k else half(d, j)
    known = [Moments(row, alpha, last) for row in it.a]
    places = [(i, k) for i in sites for k in range(block + 1) if it.has(i, k)]
    index, size = {place: r for r, place in enumerate(places)}, len(places)
    own = [[index[i, k] for k in range(block + 1) if (i, k) in index] for i in sites]
    share = [arb(fmpq(sum(it.fold(n)[0] == i for n in range(it.ring)), it.ring)) for i in sites]
    plain, force, full = arb_mat(size, size), arb_mat(size, size), arb_mat(size, size)
    for r, (i, k) in enumerate(places):
        if k:
            plain[r, r] = ONE
            for m, e in it.coupled(i, k).items():
                if (m, k) in index:
                    force[r, index[m, k]] = e * it.l[k]
        elif i + 1 in sites:
            force[r, r], force[r, index[i + 1, 0]] = -ONE, ONE
        else:
            for m in sites:
                plain[r, index[m, 0]] = share[m]
        for c in own[i]:
            full[r, c] = product(known[i].stiff, k, places[c][1])
    # DN = -D, so DG = P + B D
    near = (plain + force * full).mid().inv().mid()
    entries, kept = (near * force).tolist(), (near * plain).tolist()
    closing = dot(share, (row[0] for row in it.a)) - it.mean
    means = lambda i: known[i].force[0] - known[i + 1].force[0] if i + 1 in sites else closing
    force_of = lambda i, k: sum(e * known[m].force[k] for m, e in it.coupled(i, k).items())
    strain = lambda i, k: it.a[i][k] if k < len(it.a[i]) else ZERO
    defect = lambda i, k: strain(i, k) - it.l[k] * force_of(i, k) if k else means(i)
    steps = [row[0] for row in (near * arb_mat(size, 1, [defect(i, k) for i, k in places])).tolist()]
    edge = it.decay / (3 * arb(last) ** 3).sqrt()
    t = norm([*it.l[block + 1 :], edge])
    by_site = lambda values: [sum(weight(places[r][1]) * abs(values[r]) for r in rows) for rows in own]
    tails = [one.tail(0, last) for one in known]
    rest = lambda i: sum(abs(defect(i, k)) for k in range(block + 1, last + 1) if it.has(i, k))
    y0 = [head + rest(i) + edge * it.spread(i, tails) for i, head in enumerate(by_site(steps))]
    column = lambda r, m: norm(entries[r][c] / weight(places[c][1]) for c in own[m])
    reach = [by_site([column(r, m) for r in range(size)]) for m in sites]
    # what one unit of sqrt 2 |g|_{L2} at site m does at site i
    contact = [[reach[m][i] + t * it.spread(i, [ONE if n == m else ZERO for n in sites]) for m in sites] for i in sites]
    w = [1.0 for _ in sites]
    for _ in range(50):
        w = [sum(float(c.mid()) * v for c, v in zip(row, w)) for row in contact]
        w = [min(1.0, max(0.01, v / max(w))) for v in w]
    w = [arb(v) for v in w]
    near_columns = []
    for m in sites:
        d, most = known[m].stiff, [known[m].tail(1, last - 2 * block) * r / arb(2).sqrt() for r in reach[m]]
        image = arb_mat([[product(d, places[c][1], j) for j in range(last - block + 1)] for c in own[m]])
        image = (arb_mat([[row[c] for c in own[m]] for row in entries]) * image).tolist()
        for j in (j for j in range(last - block + 1) if it.has(m, j)):
            c = index.get((m, j))
            values = [-row[j] if c is None else (r == c) - kept[r][c] - row[j] for r, row in enumerate(image)]
            most = [up(a).max(up(b / weight(j))) for a, b in zip(most, by_site(values))]
        near_columns.append(most)
    steep = [up(alpha * o.overlap.max(ZERO) ** (alpha - 1)).min(up((2 * o.squares[1]).sqrt())) for o in known]
    steep = [v * s for v, s in zip(w, steep)]
    z1 = [dot(w, (most[i] for most in near_columns)) + t * it.spread(i, steep) for i in sites]
    # |D(s) - D(t)| for |s - t| <= r, near the cosine sum
    bent = lambda m, r: alpha * (alpha - 1) * (known[m].overlap.max(ZERO) + r) ** (alpha - 2) * r
    change = lambda m, r: alpha * r ** (alpha - 1) if it.power <= 2 else bent(m, r)
    changes = lambda r: [v * change(m, v * r) for m, v in enumerate(w)]
    q = lambda r: largest((z1[i] + dot(contact[i], changes(r))) / w[i] for i in sites)
    defects, derivative = (largest(y / v for y, v in zip(values, w)) for values in (y0, z1))
    r = defects * arb(1.001) / (1 - derivative)
    while derivative < 1 and q(r) < 1:
        radius = up(defects / (1 - q(r)))
        if radius <= r:
            if not any(abs(row[1]) > v * radius for row, v in zip(it.a, w)):
                raise Refused("the ball may hold the state at rest, or an orbit of a shorter period")
            return [float(x) for x in (radius, defects, derivative)]
        r = r * arb(1.05)
    raise Refused(f"Y0 = {float(defects):.2e}, Z1 = {float(derivative):.2e} admit no radius")


def main(files):
    code = 0
    for file in files:
        try:
            with open(file, encoding="utf-8") as text:
                print(file, "proved: radius %.3e, Y0 %.3e, Z1 %.4f" % tuple(check(text.read())))
        except Refused as why:
            code = max(code, 1)
            print(file, "not proved:", why)
        except (ValueError, KeyError, IndexError, ZeroDivisionError) as why:
            code = 2
            print(file, "no certificate:", why)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
