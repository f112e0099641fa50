"""The examples run and draw their pictures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "examples"
EXAMPLES = sorted(set(FOLDER.glob("*.py")) - {FOLDER / "many_runs.py"})


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("scipy")
    picture = tmp_path / "picture.png"
    line = [sys.executable, str(example), str(picture)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0, done.stderr
    assert picture.stat().st_size > 1000 and done.stdout


# Truth: collocation at 1e-13, and scipy; ten million runs a second would be no run at all.
def test_many_runs_are_timed_beside_others() -> None:
    pytest.importorskip("scipy")
    line = [sys.executable, str(FOLDER / "many_runs.py"), "16"]
    done = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    rows = [row.split() for row in done.splitlines() if " runs a second " in row]
    assert len(rows) >= 6 and all(0 < float(row[-6]) < 1e7 for row in rows)
    errors = {" ".join(row[:-6]): float(row[-1]) for row in rows}
    assert errors["collocation, tol 1e-9"] < 1e-9 < errors["strang-linear, step 0.01"] < 5e-5
    assert errors["corrected, step 0.05"] < 5e-7 and errors["scipy DOP853, tol 1e-06"] < 3e-4


def test_there_are_seven() -> None:
    assert len(EXAMPLES) == 7
