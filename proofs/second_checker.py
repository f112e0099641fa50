"""A second checker of certificates, in ball arithmetic, of one wave or one breather of a ring.

    python proofs/second_checker.py FILE...

It shares no code with the checker in Rust, only the format of certificates and the equations of
docs/proofs.md. Numbers are balls of 113 bits (python-flint), the force is integrated by Gauss and
Legendre, pieces by Taylor's formula about their centres, and the conclusion is that of a Hoelder
continuous derivative. Lines of multipliers are not checked; branches and breathers of the infinite
chain are refused. Exit code 0: all are proved. 1: some are not. 2: some are no certificates.
"""

import struct
import sys
from functools import lru_cache

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
    most = ZERO
    for ball in balls:
        most = most.max(up(ball))
    return most


def total(balls):
    return sum(balls, ZERO)


def norm(balls):
    return total(ball * ball for ball in balls).sqrt()


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
            demand(key not in entries and words, f"the line {line!r} is empty, or there twice")
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
        self.wave = entries["kind"] == ["wave"]
        self.power, kappa, omega = one("alpha"), one("kappa"), one("omega")
        self.rho = None if entries["rho"] == ["inf"] else one("rho")
        self.mean, self.block, self.last = arb(one("mean")), int(entries["block"][0]), int(entries["enclosed"][0])
        positive = self.power > 1 and kappa > 0 and omega > 0 and (self.rho is None or self.rho >= 0)
        demand(positive, "alpha > 1, kappa > 0, omega > 0, rho >= 0")
        self.alpha = arb(self.power)
        if self.wave:
            demand(len(self.a) == 1, "a wave has one row")
            turns = one("q_over_pi")
            self.a = [[self.mean, *self.a[0]]]
            lattice = [2 - 2 * arb.cos_pi_fmpq(k * turns) for k in range(self.last + 1)]
            self.ring, self.numbers, self.site = 1, [0], False
        else:
            lattice = [ONE] * (self.last + 1)
            self.ring, self.site = int(entries["sites"][0]), entries["center"] == ["site"]
            half = self.ring // 2
            self.numbers = list(range(half + 1)) if self.site else list(range(1, half + 2))
            demand(entries["center"] in (["site"], ["bond"]), "a centre is a site or a bond")
            demand(self.ring % 2 and len(self.a) == half + 1, "sites must be odd, with a row for each of the half")
            demand(self.rho is not None, "the resonators of a breather move")
            demand(not (self.site and any(value != 0 for value in self.a[0][1::2])), "the centre has even harmonics only")
        harmonics = len(self.a[0]) - 1
        fits = 1 <= self.block <= harmonics <= self.last and 4 * self.block <= self.last
        demand(fits, "1 <= block <= harmonics <= enclosed, 4 block <= enclosed")
        rho, self.l = self.rho, [ZERO]
        den = lambda k: kappa - (omega * k) ** 2 if rho is None else kappa * (1 + rho) - rho * (omega * k) ** 2
        for k in range(1, self.last + 1):
            if den(k) == 0:
                raise Refused(f"harmonic {k} is resonant")
            w = (omega * k) ** 2
            self.l.append(lattice[k] * arb(1 / den(k) if rho is None else (rho * w - kappa) / (w * den(k))))
        # |l_k| <= c/k^2 beyond, since den < 0 there and |den| grows
        den = den(self.last + 1)
        if rho != 0 and den >= 0:
            raise Refused("harmonics beyond are not above the resonance")
        extra = 0 if rho == 0 else (kappa if rho is None else kappa * rho) / -den
        self.decay = (4 if self.wave else 1) * arb((1 + extra) / omega**2)

    def fold(self, n):
        """The row of a site of the ring, and whether it is that of half a period later."""
        n %= self.ring
        if n in self.numbers:
            return self.numbers.index(n), False
        return (self.numbers.index(-n % self.ring), True) if self.site else (self.numbers.index((1 - n) % self.ring), False)

    def coupled(self, i, k):
        """e_nm(k) by row."""
        if self.wave:
            return {0: 1}
        found = {}
        for step, factor in ((0, 2), (1, -1), (-1, -1)):
            row, turned = self.fold(self.numbers[i] + step)
            found[row] = found.get(row, 0) + (-factor if turned and k % 2 else factor)
        return found

    def moduli(self, i):
        """A bound of |e_nm| for all k, by row."""
        even, odd = self.coupled(i, 0), self.coupled(i, 1)
        return {m: max(abs(even[m]), abs(odd[m])) for m in even}

    def has(self, i, k):
        return not (self.site and i == 0 and k % 2)


def angles(centre, count):
    """cos k theta and sin k theta, at a share of the half-period."""
    theta = arb.pi() * centre
    cos, sin = [ONE, theta.cos()], [ZERO, theta.sin()]
    for k in range(2, count + 1):
        i, j = k // 2, k - k // 2
        cos.append(cos[i] * cos[j] - sin[i] * sin[j])
        sin.append(sin[i] * cos[j] + cos[i] * sin[j])
    return cos[: count + 1], sin[: count + 1]


@lru_cache(maxsize=256)
def nodes(index, level, count):
    """The cosines at the nodes of a piece, and the weights."""
    half = ONE / 2 ** (level + 1)
    rows = [angles((2 * index + 1) * half + half * node, count)[0] for node, _ in NODE]
    return arb_mat(rows), [arb.pi() * half * weight for _, weight in NODE]


class Moments:
    """Series of N = (-X)_+^alpha and D = alpha (-X)_+^(alpha-1), their mean squares, and sup(-X)."""

    def __init__(self, a, alpha, count):
        padded = a + [ZERO] * (count + 1 - len(a))
        column, slopes = arb_mat(count + 1, 1, padded), [k * x for k, x in enumerate(a)]
        first = next(level for level in range(20) if 2**level * 6 >= count)
        force, stiff, squares = [ZERO] * (count + 1), [ZERO] * (count + 1), [ZERO, ZERO]
        errors, self.overlap = {}, ZERO
        # a bound of |X''| up to the height of the ellipses of a level, or, for None, on the real axis
        height = lambda level: arb.pi() / 2 ** (level + 1) * (RHO - ONE / RHO) / 2
        growth = lambda level, k: ONE if level is None else (k * height(level)).cosh()
        bent = lru_cache(None)(lambda level: total(k * abs(x) * growth(level, k) for k, x in enumerate(slopes)))
        pieces = [(i, first) for i in range(2**first)]
        for _ in range(20000):
            if not pieces:
                break
            index, level = pieces.pop()
            half = arb.pi() / 2 ** (level + 1)
            cos, sin = angles(arb(fmpq(2 * index + 1, 2 ** (level + 1))), len(a) - 1)
            x = total(c * v for c, v in zip(cos, a))
            slope = abs(total(s * v for s, v in zip(sin, slopes)))
            most = up(-x + slope * half + bent(None) * half * half / 2)
            self.overlap = self.overlap.max(most)
            if most <= 0:
                continue
            reach = half * (RHO + ONE / RHO) / 2
            apart = slope * reach + bent(level) * reach * reach / 2
            if -x - apart > 0:
                size, matrix, weights = up(-x + apart), *nodes(index, level, count)
                strains = (matrix * column).tolist()
                overlaps = [-row[0] for row in strains]
                laws = [[w * g**alpha for g, w in zip(overlaps, weights)]]
                laws.append([alpha * w * g ** (alpha - 1) for g, w in zip(overlaps, weights)])
                added = (arb_mat(laws) * matrix).tolist()
                for sums, own in ((force, added[0]), (stiff, added[1])):
                    sums[:] = [s + o for s, o in zip(sums, own)]
                for i, law in enumerate(laws):
                    squares[i] += total(v * v / w for v, w in zip(law, weights))
                # |I - I_n| <= 8 M rho^{-2n}/(1 - 1/rho), M on the ellipse
                share = half * 8 * ONE / RHO ** (2 * NODES) / (1 - ONE / RHO)
            elif level >= DEEPEST:
                size, share, level = most, 2 * half, None
            else:
                pieces += [(2 * index, level + 1), (2 * index + 1, level + 1)]
                continue
            sizes = [size**alpha, alpha * size ** (alpha - 1)]
            errors[level] = [e + share * v for e, v in zip(errors.get(level, [ZERO, ZERO]), sizes)]
            squares = [s + arb(0, up(share * v * v)) for s, v in zip(squares, sizes)]
        else:
            raise Refused("the contact force could not be enclosed")
        for level, (own, steep) in errors.items():
            for k in range(count + 1):
                force[k] += arb(0, up(own * growth(level, k)))
                stiff[k] += arb(0, up(steep * growth(level, k)))
        mean = lambda sums: [(2 if k else 1) * s / arb.pi() for k, s in enumerate(sums)]
        self.force, self.stiff = mean(force), mean(stiff)
        self.squares = [s / arb.pi() for s in squares]

    def tail(self, which, last):
        """A bound of (sum_{k > last} f_k^2)^(1/2), by Parseval."""
        series = (self.force, self.stiff)[which]
        rest = 2 * (self.squares[which] - series[0] ** 2) - total(f * f for f in series[1 : last + 1])
        return up(rest).max(ZERO).sqrt()


def product(d, k, j):
    """The coefficient of cos k theta in D cos j theta."""
    h = lambda l: d[l] / (2 if l else 1)
    return d[k] if j == 0 else h(j) if k == 0 else h(abs(k - j)) + h(k + j)


def check(text):
    """The radius, Y0 and Z1 of a certificate; or Refused, or ValueError if it is none."""
    it = Chain(text)
    block, last, sites = it.block, it.last, len(it.a)
    alpha, beyond, weight = it.alpha, it.last - it.block, lambda k: ONE if k else arb(2).sqrt()
    known = [Moments(row, alpha, last) for row in it.a]
    places = [(i, k) for i in range(sites) for k in range(block + 1) if it.has(i, k)]
    index, size = {place: r for r, place in enumerate(places)}, len(places)
    own = [[index[i, k] for k in range(block + 1) if (i, k) in index] for i in range(sites)]
    share = [arb(fmpq(sum(it.fold(n)[0] == i for n in range(it.ring)), it.ring)) for i in range(sites)]
    plain, force, full = arb_mat(size, size), arb_mat(size, size), arb_mat(size, size)
    for r, (i, k) in enumerate(places):
        if k:
            plain[r, r] = ONE
            for m, e in it.coupled(i, k).items():
                if (m, k) in index:
                    force[r, index[m, k]] = e * it.l[k]
        elif i + 1 < sites:
            force[r, r], force[r, index[i + 1, 0]] = -ONE, ONE
        else:
            for m in range(sites):
                plain[r, index[m, 0]] = share[m]
        for c in own[i]:
            full[r, c] = product(known[i].stiff, k, places[c][1])
    # DN = -D, so DG = P + B D
    near = (plain + force * full).mid().inv().mid()
    through = near * force

    def defect(i, k):
        value = it.a[i][k] if k < len(it.a[i]) else ZERO
        return value - it.l[k] * total(e * known[m].force[k] for m, e in it.coupled(i, k).items())

    means = lambda i: known[i].force[0] - known[i + 1].force[0] if i + 1 < sites else (
        total(s * row[0] for s, row in zip(share, it.a)) - it.mean
    )
    residual = [defect(i, k) if k else means(i) for i, k in places]
    steps = [row[0] for row in (near * arb_mat(size, 1, residual)).tolist()]
    edge = it.decay / (3 * arb(last) ** 3).sqrt()
    t = norm([*it.l[block + 1 :], edge])
    by_site = lambda values: [total(weight(places[r][1]) * abs(values[r]) for r in rows) for rows in own]
    y0 = by_site(steps)
    for i in range(sites):
        y0[i] += total(abs(defect(i, k)) for k in range(block + 1, last + 1) if it.has(i, k))
        y0[i] += edge * total(e * known[m].tail(0, last) for m, e in it.moduli(i).items())
    entries, kept = through.tolist(), (near * plain).tolist()
    column = lambda r, m: norm(entries[r][c] / weight(places[c][1]) for c in own[m])
    reach = [by_site([column(r, m) for r in range(size)]) for m in range(sites)]
    contact = [[reach[m][i] + t * it.moduli(i).get(m, 0) for m in range(sites)] for i in range(sites)]
    w = [1.0] * sites
    for _ in range(50):
        w = [sum(float(c.mid()) * v for c, v in zip(row, w)) for row in contact]
        w = [min(1.0, max(0.01, v / max(w))) for v in w]
    w = [arb(v) for v in w]
    z1 = [ZERO] * sites
    for m in range(sites):
        d, tail = known[m].stiff, known[m].tail(1, last - 2 * block)
        image = arb_mat([[product(d, places[c][1], j) for j in range(beyond + 1)] for c in own[m]])
        image = (arb_mat([[row[c] for c in own[m]] for row in entries]) * image).tolist()
        most = [tail * r / arb(2).sqrt() for r in reach[m]]
        for j in (j for j in range(beyond + 1) if it.has(m, j)):
            c = index.get((m, j))
            values = [row[j] for row in image]
            if c is not None:
                values = [(ONE if r == c else ZERO) - kept[r][c] - v for r, v in enumerate(values)]
            most = [up(a).max(up(b / weight(j))) for a, b in zip(most, by_site(values))]
        for i in range(sites):
            z1[i] += w[m] * most[i]
    steep = [up(alpha * o.overlap.max(ZERO) ** (alpha - 1)).min(up((2 * o.squares[1]).sqrt())) for o in known]
    for i in range(sites):
        z1[i] += t * total(e * w[m] * steep[m] for m, e in it.moduli(i).items())

    def change(m, r):
        """|D(s) - D(t)| for |s - t| <= r, near the cosine sum."""
        if it.power <= 2:
            return alpha * r ** (alpha - 1)
        return alpha * (alpha - 1) * (known[m].overlap.max(ZERO) + r) ** (alpha - 2) * r

    def q(r):
        change_of = [w[m] * change(m, w[m] * r) for m in range(sites)]
        return largest((z1[i] + total(c * v for c, v in zip(contact[i], change_of))) / w[i] for i in range(sites))

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
