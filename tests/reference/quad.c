/* End states of conservative chains whose beads differ, with 33 digits: what details.py asks for where events are many.

   gcc -O2 quad.c -lquadmath -lm -o quad; ./quad NODES < CASE

   The method is that of details.py: between two events the motion is analytic in s, where t = a + (b - a) s^2 (3 - 2 s), and is found
   by the rule of Gauss, here on pieces that are halved until the last Legendre coefficients of all slopes are below LAST. Events are
   first found by small steps of the classical scheme of Runge and Kutta, then to the last digit by the secant method. CASE has the number of beads n, the end,
   and lists: mass, kappa, rho (0 for no resonator, inf for one at rest), contact, alpha, overlap (n + 1 each, walls included), u, v, u',
   v'. Printed: the number of events, the change of energy, and the end state, each number as two doubles. */
#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef __float128 Q;
enum { MOST = 32, NODES = 16, EVENTS = 4096 };
static const Q LAST = 1e-11Q, SETTLED = 1e-27Q;

static int n, m, closed[MOST + 1];
static double mass[MOST], kappa[MOST], rho[MOST], contact[MOST + 1], alpha[MOST + 1], rest[MOST + 1];
static Q node[NODES], weight[NODES], a[NODES][NODES], last[NODES];

static Q power(Q g, double p) {
    Q x = (int)(2 * p) % 2 ? sqrtq(g) : 1;
    for (int k = 0; k < (int)p; k++) x *= g;
    return x;
}

static Q overlap(const Q *y, int b) { return rest[b] + (b > 0 ? y[b - 1] : 0) - (b < n ? y[b] : 0); }

/* y = u, v, u', v'. */
static void rates(const Q *y, Q *dy) {
    Q f[MOST + 1];
    for (int b = 0; b <= n; b++) f[b] = closed[b] ? contact[b] * power(fabsq(overlap(y, b)), alpha[b]) : 0;
    for (int i = 0; i < n; i++) {
        int none = kappa[i] == 0 || rho[i] == 0, moving = !none && !isinfq(rho[i]);
        Q pull = none ? 0 : kappa[i] * (y[i] - (moving ? y[n + i] : 0));
        dy[i] = y[2 * n + i];
        dy[n + i] = moving ? y[3 * n + i] : 0;
        dy[2 * n + i] = (f[i] - f[i + 1] - pull) / mass[i];
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
static int piece(Q length, Q from, Q to, Q *y) {
    static Q slope[NODES][4 * MOST], next[NODES][4 * MOST];
    int dim = 4 * n;
    Q speed[NODES], z[4 * MOST], apart = 1;
    for (int j = 0; j < m; j++) {
        Q s = from + (to - from) * node[j];
        speed[j] = length * 6 * s * (1 - s) * (to - from);
        rates(y, slope[j]);
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
            rates(z, next[j]);
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

static void over(Q length, Q from, Q to, Q *y) {
    if (piece(length, from, to, y)) return;
    if (to - from < 1e-12Q) exit(1);
    over(length, from, (from + to) / 2, y);
    over(length, (from + to) / 2, to, y);
}

static Q energy(const Q *y) {
    Q e = 0;
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
    for (int b = 0; b <= n; b++) closed[b] = overlap(y, b) > 0;
}

static struct { int bond; Q t; } event[EVENTS];
static int by_time(const void *x, const void *y) {
    Q d = ((Q *)x)[1] - ((Q *)y)[1];
    return d < 0 ? -1 : d > 0;
}

/* Events by the classical scheme of Runge and Kutta. */
static int find(const Q *start, Q end, int steps) {
    static Q y[4 * MOST], z[4 * MOST], k[4][4 * MOST], before[MOST + 1];
    int count = 0;
    Q h = end / steps, c[4] = {0, h / 2, h / 2, h};
    memcpy(y, start, sizeof y);
    for (int b = 0; b <= n; b++) before[b] = overlap(y, b);
    for (int step = 0; step < steps; step++) {
        for (int s = 0; s < 4; s++) {
            for (int i = 0; i < 4 * n; i++) z[i] = y[i] + (s ? c[s] * k[s - 1][i] : 0);
            close_all(z);
            rates(z, k[s]);
        }
        for (int i = 0; i < 4 * n; i++) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        for (int b = 0; b <= n; b++) {
            Q now = overlap(y, b);
            if ((now > 0) != (before[b] > 0)) event[count].bond = b, event[count++].t = h * (step + before[b] / (before[b] - now));
            before[b] = now;
        }
    }
    qsort(event, count, sizeof *event, by_time);
    return count;
}

static void list(double *x, int count) {
    for (int i = 0; i < count; i++)
        if (scanf("%lf", x + i) != 1) exit(2);
}

int main(int argc, char **argv) {
    static double end, x[4 * MOST];
    static Q y[4 * MOST], z[2][4 * MOST], start[4 * MOST];
    m = argc > 1 ? atoi(argv[1]) : 12;
    if (scanf("%d %lf", &n, &end) != 2 || n > MOST || m + 2 > NODES) return 2;
    list(mass, n), list(kappa, n), list(rho, n), list(contact, n + 1), list(alpha, n + 1), list(rest, n + 1), list(x, 4 * n);
    for (int i = 0; i < 4 * n; i++) start[i] = y[i] = x[i];
    gauss();
    int events = find(start, end, (int)(4000 * end));
    close_all(y);
    Q t = 0;
    for (int k = 0; k < events; k++) {
        Q at[2] = {event[k].t, event[k].t + 1e-9Q}, g[2];
        for (int turn = 0; turn < 50; turn++) {
            for (int j = turn ? 1 : 0; j < 2; j++) {
                memcpy(z[j], y, sizeof y);
                over(at[j] - t, 0, 1, z[j]);
                g[j] = overlap(z[j], event[k].bond);
            }
            if (fabsq(at[1] - at[0]) < 1e-16Q || g[0] == g[1]) break;
            Q better = at[1] - g[1] * (at[1] - at[0]) / (g[1] - g[0]);
            at[0] = at[1], g[0] = g[1], at[1] = better;
        }
        memcpy(y, z[1], sizeof y);
        t = at[1];
        closed[event[k].bond] ^= 1;
    }
    over(end - t, 0, 1, y);
    printf("%d %.3e\n", events, (double)fabsq(energy(y) - energy(start)));
    for (int i = 0; i < 4 * n; i++) printf("%.17g %.17g\n", (double)y[i], (double)(y[i] - (double)y[i]));
    return 0;
}
