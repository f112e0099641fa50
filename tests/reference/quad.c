/* End states of chains whose beads differ, are damped and driven, with 33 digits: what details.py asks for where events are many.

   gcc -O2 quad.c -lquadmath -lm -o quad; ./quad NODES < CASE

   The method is that of details.py: between two events the motion is analytic in s, where t = a + (b - a) s^2 (3 - 2 s), and is found
   by the rule of Gauss, here on pieces that are halved until the last Legendre coefficients of all slopes are below LAST. The next event
   is first found by small steps of the classical scheme of Runge and Kutta, then to the last digit by the secant method. Where a contact
   dissipates, f = (A g^alpha + loss d/dt A g^alpha)_+, events are zeros of g, and of g + loss alpha g' while g > 0.

   CASE has the number of beads n, the end, and lists: mass, kappa, rho (0 for no resonator, inf for one at rest), drag, dashpot, contact,
   alpha, overlap, viscoelastic (n + 1 each, walls included), moved and pushed (site, or -1, amplitude, omega and phase of a sine), u, v,
   u', v'. Printed: the number of events, the change of energy + dissipated - driven, and the end state with what drag, dashpots and
   contacts dissipated, and what drives put in, each number as two doubles. */
#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef __float128 Q;
enum { MOST = 32, NODES = 16, DIM = 4 * MOST + 4 };
static const Q LAST = 1e-11Q, SETTLED = 1e-27Q;

/* Whether beads overlap, and whether they push if they do. */
static int n, m, closed[MOST + 1], pushing[MOST + 1];
static double mass[MOST], kappa[MOST], rho[MOST], drag[MOST], dashpot[MOST], moved[4], pushed[4], contact[MOST + 1], alpha[MOST + 1], rest[MOST + 1], loss[MOST + 1];
static Q node[NODES], weight[NODES], a[NODES][NODES], last[NODES];

static Q power(Q g, double p) {
    Q x = (int)(2 * p) % 2 ? sqrtq(g) : 1;
    for (int k = 0; k < (int)p; k++) x *= g;
    return x;
}

static Q overlap(const Q *y, int b) { return rest[b] + (b > 0 ? y[b - 1] : 0) - (b < n ? y[b] : 0); }

static Q approach(const Q *y, int b) { return (b > 0 ? y[2 * n + b - 1] : 0) - (b < n ? y[2 * n + b] : 0); }

/* Positive where a closed contact pushes. */
static Q pushes(const Q *y, int b) { return overlap(y, b) + loss[b] * alpha[b] * approach(y, b); }

/* Value, rate and second derivative of a sine. */
static void sine(const double *drive, Q t, Q *out) {
    Q x = drive[2] * t + drive[3];
    out[0] = drive[1] * sinq(x), out[1] = drive[1] * (drive[2] * cosq(x)), out[2] = -(Q)drive[2] * drive[2] * out[0];
}

/* y = u, v, u', v', drag, dashpots, contacts, driven. */
static void rates(Q t, const Q *y, Q *dy) {
    Q f[MOST + 1], s[3], *ledger = dy + 4 * n;
    for (int k = 0; k < 4; k++) ledger[k] = 0;
    for (int b = 0; b <= n; b++) {
        Q g = fabsq(overlap(y, b)), elastic = closed[b] ? contact[b] * power(g, alpha[b]) : 0, lost = 0;
        if (closed[b] && loss[b] > 0)
            lost = pushing[b] ? loss[b] * (contact[b] * alpha[b]) * power(g, alpha[b] - 1) * approach(y, b) : -elastic;
        f[b] = elastic + lost;
        ledger[2] += lost * approach(y, b);
    }
    for (int i = 0; i < n; i++) {
        int none = kappa[i] == 0 || rho[i] == 0, moving = !none && !isinfq(rho[i]);
        Q p = y[2 * n + i], slide = none ? 0 : p - (moving ? y[3 * n + i] : 0);
        Q pull = none ? 0 : kappa[i] * (y[i] - (moving ? y[n + i] : 0)) + dashpot[i] * slide;
        dy[i] = p;
        dy[n + i] = moving ? y[3 * n + i] : 0;
        dy[2 * n + i] = (f[i] - f[i + 1] - pull - drag[i] * p) / mass[i];
        ledger[0] += drag[i] * p * p, ledger[1] += dashpot[i] * slide * slide;
        if (i == pushed[0]) sine(pushed, t, s), dy[2 * n + i] += s[0] / mass[i], ledger[3] += s[0] * p;
        if (i == moved[0])
            sine(moved, t, s), dy[i] = s[1], dy[2 * n + i] = s[2], ledger[3] += mass[i] * s[2] * p - (f[i] - f[i + 1]) * p;
        dy[3 * n + i] = moving ? pull / ((Q)rho[i] * mass[i]) : 0;
    }
}

static Q legendre(int k, Q x) {
    Q p = 1, q = x;
    if (k == 0) return p;
    for (int j = 1; j < k; j++) {
        Q r = ((2 * j + 1) * x * q - j * p) / (j + 1);
        p = q, q = r;
    }
    return q;
}

/* Nodes on [0, 1], weights, integrals of the Lagrange polynomials up to each node. */
static void gauss(void) {
    for (int k = 0; k < m; k++) {
        Q x = -cosq(M_PIq * (k + 0.75Q) / (m + 0.5Q)), slope = 0;
        for (int turn = 0; turn < 10; turn++) {
            slope = m * (legendre(m - 1, x) - x * legendre(m, x)) / (1 - x * x);
            x -= legendre(m, x) / slope;
        }
        node[k] = (1 + x) / 2, weight[k] = 1 / ((1 - x * x) * slope * slope);
    }
    for (int k = 0; k < m; k++) {
        last[k] = weight[k] * legendre(m - 1, 2 * node[k] - 1) * (2 * m - 1);
        for (int j = 0; j < m; j++) {
            Q x = 2 * node[j] - 1, z = 2 * node[k] - 1;
            a[j][k] = weight[k] * (x + 1) / 2;
            for (int i = 1; i < m; i++) a[j][k] += weight[k] * legendre(i, z) * (legendre(i + 1, x) - legendre(i - 1, x)) / 2;
        }
    }
}

/* One piece; 0 if it must be halved. */
static int piece(Q start, Q length, Q from, Q to, Q *y) {
    static Q slope[NODES][DIM], next[NODES][DIM];
    int dim = 4 * n + 4;
    Q time[NODES], speed[NODES], z[DIM], apart = 1;
    for (int j = 0; j < m; j++) {
        Q s = from + (to - from) * node[j];
        speed[j] = length * 6 * s * (1 - s) * (to - from);
        time[j] = start + length * s * s * (3 - 2 * s);
        rates(time[j], y, slope[j]);
        for (int i = 0; i < dim; i++) slope[j][i] *= speed[j];
    }
    for (int turn = 0; apart > SETTLED; turn++) {
        if (turn == 100) return 0;
        apart = 0;
        for (int j = 0; j < m; j++) {
            for (int i = 0; i < dim; i++) {
                z[i] = y[i];
                for (int k = 0; k < m; k++) z[i] += a[j][k] * slope[k][i];
            }
            rates(time[j], z, next[j]);
            for (int i = 0; i < dim; i++) {
                next[j][i] *= speed[j];
                apart = fmaxq(apart, fabsq(next[j][i] - slope[j][i]));
            }
        }
        memcpy(slope, next, sizeof slope);
    }
    for (int i = 0; i < dim; i++) {
        Q tail = 0;
        for (int j = 0; j < m; j++) tail += last[j] * slope[j][i];
        if (fabsq(tail) > LAST) return 0;
    }
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < m; j++) y[i] += weight[j] * slope[j][i];
    return 1;
}

static void over(Q start, Q length, Q from, Q to, Q *y) {
    if (piece(start, length, from, to, y)) return;
    if (to - from < 1e-12Q) exit(1);
    over(start, length, from, (from + to) / 2, y);
    over(start, length, (from + to) / 2, to, y);
}

static Q energy(const Q *y) {
    Q e = y[4 * n] + y[4 * n + 1] + y[4 * n + 2] - y[4 * n + 3];
    for (int i = 0; i < n; i++) {
        int none = kappa[i] == 0 || rho[i] == 0, moving = !none && !isinfq(rho[i]);
        Q x = y[i] - (moving ? y[n + i] : 0);
        e += mass[i] * y[2 * n + i] * y[2 * n + i] / 2 + (none ? 0 : kappa[i] * x * x / 2);
        e += moving ? (Q)rho[i] * mass[i] * y[3 * n + i] * y[3 * n + i] / 2 : 0;
    }
    for (int b = 0; b <= n; b++)
        if (overlap(y, b) > 0) e += contact[b] * power(overlap(y, b), alpha[b] + 1) / (alpha[b] + 1);
    return e;
}

static void close_all(const Q *y) {
    for (int b = 0; b <= n; b++) closed[b] = overlap(y, b) > 0, pushing[b] = pushes(y, b) > 0;
}

/* Event k of bond k/2: a zero of its overlap, or of what is positive where it pushes. */
static Q event(const Q *y, int k) { return k % 2 ? pushes(y, k / 2) : overlap(y, k / 2); }

/* The next event by the classical scheme of Runge and Kutta, and about when; -1 if there is none before the end. */
static int find(const Q *start, Q t, Q end, Q *at) {
    static Q y[DIM], z[DIM], k[4][DIM];
    Q h = 2.5e-4Q, c[4] = {0, h / 2, h / 2, h}, before[2 * MOST + 2];
    int over[MOST + 1], push[MOST + 1], next = -1;
    memcpy(over, closed, sizeof over), memcpy(push, pushing, sizeof push);
    memcpy(y, start, sizeof y);
    for (; next < 0 && t < end; t += h) {
        for (int e = 0; e < 2 * n + 2; e++) before[e] = event(y, e);
        for (int s = 0; s < 4; s++) {
            for (int i = 0; i < 4 * n + 4; i++) z[i] = y[i] + (s ? c[s] * k[s - 1][i] : 0);
            close_all(z);
            rates(t + c[s], z, k[s]);
        }
        for (int i = 0; i < 4 * n + 4; i++) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        for (int e = 0; e < 2 * n + 2; e++) {
            Q now = event(y, e), share = (now > 0) != (before[e] > 0) ? before[e] / (before[e] - now) : 0.5Q;
            int side = e % 2 ? push[e / 2] : over[e / 2];
            if ((e % 2 && !(over[e / 2] && loss[e / 2] > 0)) || (now > 0) == side || (next >= 0 && *at < t + h * share)) continue;
            next = e, *at = t + h * share;
        }
    }
    memcpy(closed, over, sizeof over), memcpy(pushing, push, sizeof push);
    return next >= 0 && *at < end ? next : -1;
}

static void list(double *x, int count) {
    for (int i = 0; i < count; i++)
        if (scanf("%lf", x + i) != 1) exit(2);
}

int main(int argc, char **argv) {
    static double end, x[DIM];
    static Q y[DIM], z[2][DIM], start[DIM], s[3];
    m = argc > 1 ? atoi(argv[1]) : 12;
    if (scanf("%d %lf", &n, &end) != 2 || n > MOST || m + 2 > NODES) return 2;
    list(mass, n), list(kappa, n), list(rho, n), list(drag, n), list(dashpot, n), list(contact, n + 1), list(alpha, n + 1);
    list(rest, n + 1), list(loss, n + 1), list(moved, 4), list(pushed, 4), list(x, 4 * n);
    for (int i = 0; i < 4 * n; i++) start[i] = x[i];
    if (moved[0] >= 0) sine(moved, 0, s), start[(int)moved[0]] = s[0], start[2 * n + (int)moved[0]] = s[1];
    memcpy(y, start, sizeof y);
    gauss();
    close_all(y);
    Q t = 0, about = 0;
    int events = 0;
    for (int next; (next = find(y, t, end, &about)) >= 0; events++) {
        Q at[2] = {about, about + 1e-9Q}, g[2];
        for (int turn = 0; turn < 50; turn++) {
            for (int j = turn ? 1 : 0; j < 2; j++) {
                memcpy(z[j], y, sizeof y);
                over(t, at[j] - t, 0, 1, z[j]);
                g[j] = event(z[j], next);
            }
            if (fabsq(at[1] - at[0]) < 1e-16Q || g[0] == g[1]) break;
            Q better = at[1] - g[1] * (at[1] - at[0]) / (g[1] - g[0]);
            at[0] = at[1], g[0] = g[1], at[1] = better;
        }
        memcpy(y, z[1], sizeof y);
        t = at[1];
        if (next % 2) pushing[next / 2] ^= 1;
        else closed[next / 2] ^= 1, pushing[next / 2] = closed[next / 2];
    }
    over(t, end - t, 0, 1, y);
    printf("%d %.3e\n", events, (double)fabsq(energy(y) - energy(start)));
    for (int i = 0; i < 4 * n + 4; i++) printf("%.17g %.17g\n", (double)y[i], (double)(y[i] - (double)y[i]));
    return 0;
}
