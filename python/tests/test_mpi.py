"""Sweeps from inside a job of mpi4py."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# Ranks add the values of their points to a store each; all of them get all values. What one rank
# prints is gathered, so that lines do not mix.
JOB = """
import json, sys
from mpi4py import MPI
import hertzchain as hc
import numpy as np

comm = MPI.COMM_WORLD
store, count = sys.argv[1], int(sys.argv[2])
called = []

def energy(k):
    called.append(k)
    chain = hc.Chain(sites=4 + k)
    return hc.run(chain, y0={"pu": np.eye(4 + k)[0]}, until=3.0, tol=1e-10).u[-1].tolist()

values = hc.sweep(energy, range(count), workers=1, comm=comm, store=store or None, version=1)
each = comm.gather((values, called))
if comm.rank == 0:
    print(json.dumps({"size": comm.size, "each": each}))
"""


def job(tmp_path: Path, ranks: int, count: int, store: str = "") -> dict[str, object]:
    pytest.importorskip("mpi4py")
    if shutil.which("mpirun") is None:
        pytest.skip("no mpirun")
    file = tmp_path / "job.py"
    file.write_text(JOB)
    # What Open MPI asks for where there are few cores, and of root.
    allowed = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    line = ["mpirun", "--oversubscribe", "-n", str(ranks), sys.executable, str(file), store, str(count)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, env={**os.environ, **allowed})
    assert done.returncode == 0, done.stderr
    told: dict[str, object] = json.loads(done.stdout)
    return told


def test_ranks_share_the_points_and_all_get_the_values_of_one(tmp_path: Path) -> None:
    one, three = (job(tmp_path, ranks, 7) for ranks in (1, 3))
    assert (one["size"], three["size"]) == (1, 3)
    values = one["each"][0][0]  # type: ignore[index]
    assert len(values) == 7 and all(each[0] == values for each in three["each"])  # type: ignore[attr-defined]
    assert [each[1] for each in three["each"]] == [[0, 3, 6], [1, 4], [2, 5]]  # type: ignore[attr-defined]


def test_a_job_goes_on_from_the_stores_of_another_number_of_ranks(tmp_path: Path) -> None:
    store = str(tmp_path / "store")
    first, second = (job(tmp_path, 3, count, store) for count in (5, 5))
    assert [each[1] for each in second["each"]] == [[], [], []]  # type: ignore[attr-defined]
    other = job(tmp_path, 2, 5, store)
    assert other["each"][0] == [first["each"][0][0], []]  # type: ignore[index]
