"""What several tests need."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest


@pytest.fixture(scope="session")
def program() -> Any:
    """The program with its arguments: its JSON."""

    def call(*arguments: str) -> dict[str, Any]:
        line = [sys.executable, "-m", "hertzchain", *arguments, "--json"]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        value: dict[str, Any] = json.loads(done.stdout)
        return value

    return call
