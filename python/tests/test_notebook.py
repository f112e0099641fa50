"""Progress in a notebook that a kernel runs: by tqdm, and without it."""

from __future__ import annotations

from typing import Any

import pytest

RUN = """
import sys
{before}
import hertzchain as hc
hc.run(hc.Scene.load("tw-q15"), method="verlet", step=1e-4, progress=True).end["x"].size
"""


@pytest.mark.parametrize("before", ["", "sys.modules['tqdm.auto'] = None"], ids=["tqdm", "line"])
def test_a_long_run_shows_its_share(before: str) -> None:
    nbformat: Any = pytest.importorskip("nbformat")
    nbclient: Any = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    if not before:
        pytest.importorskip("tqdm")
    cell = nbformat.v4.new_code_cell(RUN.format(before=before))
    nbclient.NotebookClient(nbformat.v4.new_notebook(cells=[cell]), timeout=120).execute()
    # Every write to standard error is kept, also those that a carriage return hides.
    shown = "".join(output.get("text", "") for output in cell.outputs if output.output_type == "stream")
    assert "tw-q15:" in shown and "Warning" not in shown
    assert ("100 %|" in shown) == (not before)
    (size,) = (output["data"]["text/plain"] for output in cell.outputs if output.output_type == "execute_result")
    assert size == "50"
