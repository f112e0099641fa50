"""A first run and its picture: one bead strikes a chain at rest."""

import sys

import numpy as np

import hertzchain as hc

chain = hc.Chain(sites=60)
run = hc.run(chain, y0={"pu": np.eye(60)[0]}, until=60.0, tol=1e-10, events=True)
print(run)
print(f"energy error {run.energy_error:.1e}, {len(run.contacts)} contacts")

# Most of the momentum leaves in one solitary wave.
front = run.pu[-1].argmax()
print(f"the wave is at bead {front}")
assert run.energy_error < 1e-9
if len(sys.argv) > 1:
    run.plot().figure.savefig(sys.argv[1], dpi=120)
