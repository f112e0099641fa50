"""A branch of bond-centred breathers in their frequency, with its bifurcations."""

import sys

import hertzchain as hc

start = hc.DarkBreather("bond", omega_b=2.01, sites=11).solve()
branch = hc.continue_branch(start, "omega_b", to=2.10, step=0.005)
print(branch)
for point in branch[::4]:
    print(f"omega_b {point.omega_b:.4f}  amplitude {point.k_x:.6f}  largest |lambda| {point.max_modulus:.6f}")
for one in branch.bifurcations:
    print(f"{one['kind']} at omega_b = {one['parameter']:.6f}")
assert branch.end == "reached"
if len(sys.argv) > 1:
    branch.plot(y="max_modulus").figure.savefig(sys.argv[1], dpi=120)
