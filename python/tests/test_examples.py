"""The examples run and draw their pictures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("scipy")
    picture = tmp_path / "picture.png"
    line = [sys.executable, str(example), str(picture)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0, done.stderr
    assert picture.stat().st_size > 1000 and done.stdout


def test_there_are_seven() -> None:
    assert len(EXAMPLES) == 7
