"""A dark breather, its spectrum, and a kick."""

import sys

import numpy as np

import hertzchain as hc

orbit = hc.DarkBreather("bond", omega_b=2.05, rho=1 / 3, sites=21).solve()
print(orbit)
print(f"residual {orbit.residual:.1e}, estimated error of the largest multiplier {orbit.errors[0]:.1e}")
assert orbit.residual < 1e-12

# Along its most unstable direction, the distance from the orbit grows by the largest multiplier.
size, periods = 1e-7, 60
state = np.concatenate([orbit.x, orbit.y, np.zeros(42)]) + size * orbit.modes[0]
run = hc.run(orbit.chain, y0=state, until=periods * orbit.period, at=periods, tol=1e-13)
away = np.hypot(abs(run.x - orbit.x).max(axis=1), abs(run.y - orbit.y).max(axis=1))
rate = np.polyfit(np.arange(20, periods + 1), np.log(away[20:]), 1)[0]
print(f"growth a period {np.exp(rate):.5f}, largest multiplier {abs(orbit.multipliers).max():.5f}")
assert abs(np.exp(rate) - abs(orbit.multipliers).max()) < 1e-3
if len(sys.argv) > 1:
    orbit.plot().figure.savefig(sys.argv[1], dpi=120)
