"""Studies by name and by the functions of hertzchain.studies: the bits of the program, its tables, its refusals."""

from __future__ import annotations

import csv
import inspect
import math
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import _thread
import numpy as np
import pytest

import hertzchain as hc

FUNCTIONS = [function for _, function in inspect.getmembers(hc.studies, inspect.isfunction) if function.__module__ == "hertzchain.studies"]

CHEAP: list[tuple[str, dict[str, Any]]] = [
    ("dps integrals", {"b": -0.25, "r": 0.1 + 0.2, "kappa": np.float64(1.3)}),
    ("dps homoclinic", {"center": "bond", "alpha": 2}),
    ("breather dark", {"sites": 7, "omega_b": 2.05}),
    ("breather continue", {"from_": 2.02, "to": 2.04, "sites": 7, "step": 0.01, "bifurcations": True}),
    ("wave exact", {"q_over_pi": 0.8, "sites": 10, "amplitude": 0.1}),
    ("orbit driven", {"scene": "granular-crystal", "set": {"chain.sites": 6, "initial.site": 1}, "settle": 20, "dimensionless": True}),
    ("orbit mode", {"scene": "defect", "to": 0.2, "step": 0.1, "multipliers": False}),
]


def flags(options: dict[str, Any]) -> list[str]:
    """The options as the user of a shell would write them."""
    words = []
    for name, value in options.items():
        flag = "--" + name.strip("_").replace("_", "-")
        if name == "scene":
            words.append(value)
        elif isinstance(value, dict):
            words += [f"{flag}={key}={one}" for key, one in value.items()]
        elif value is True and name != "bifurcations":
            words.append(flag)
        else:
            words.append(f"{flag}={str(value).lower()}")
    return words


def same(cell: str, value: Any) -> bool:
    if isinstance(value, str):
        return cell == value.replace(",", ";").replace("\n", " ")
    return float(cell) == value or math.isnan(float(cell)) and math.isnan(value)


@pytest.mark.parametrize(("command", "options"), CHEAP)
def test_a_study_has_the_bits_tables_and_files_of_its_command(program: Any, tmp_path: Path, command: str, options: dict[str, Any]) -> None:
    function = getattr(hc.studies, command.replace(" ", "_"))
    folder = ["--out", str(tmp_path / "program")] if "out" in inspect.signature(function).parameters else []
    printed = program(*command.split(), *flags(options), *folder)
    done = hc.study(command, **options)
    assert done.record == printed and done.failure is None and repr(done) == done.text.rstrip()
    assert function(**options).record == printed
    if not folder:
        return
    done.save(tmp_path / "saved")
    saved = sorted(file.name for file in (tmp_path / "saved").iterdir() if not file.name.startswith("."))
    assert any(name.endswith(".png") for name in saved)
    for name in saved:
        assert (tmp_path / "saved" / name).read_bytes() == (tmp_path / "program" / name).read_bytes(), name
    for name, table in done.tables.items():
        with (tmp_path / "program" / f"{name}.csv").open(newline="") as file:
            head, *rows = csv.reader(file)
        assert table.dtype.names == tuple(head) and len(table) == len(rows), name
        assert all(same(cell, value) for row, values in zip(rows, table.tolist()) for cell, value in zip(row, values)), name


def test_columns_have_types() -> None:
    modes = hc.study("orbit mode", scene="defect", to=0.2, step=0.1).tables["linear-modes"]
    kinds = {name: modes.dtype[name].kind for name in modes.dtype.names or ()}
    assert kinds["omega"] == "f" and kinds["site"] == "i" and kinds["resonator"] == "b", kinds
    outside = hc.study("breather dark", sites=7, omega_b=2.05).tables["multipliers-outside"]
    assert outside["kind"].dtype.kind == "U" and set(outside["kind"]) <= {"real", "negative", "quartet", "circle", "trivial"}


def test_numbers_arrive_to_the_bit() -> None:
    numbers = [0.1 + 0.2, math.nextafter(1.0, 2.0), 1e-300, np.pi, np.float32(0.1), 3]
    for r in numbers:
        record = hc.studies.dps_integrals(b=-1.0, r=r).record  # type: ignore[arg-type]
        assert record["r"] == float(r)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: str(function.__name__))
def test_every_study_can_be_called_and_refuses_in_the_words_of_python(function: Callable[..., hc.Study]) -> None:
    options = inspect.signature(function).parameters
    number = [name for name, one in options.items() if one.annotation.startswith(("float", "int")) and "Sequence" not in one.annotation]
    name = next((name for name in (*number, "shard", "scene") if name in options), None)
    if name is None:
        # `prove` has a file only.
        with pytest.raises((hc.Error, OSError), match="no-such-file"):
            function("no-such-file")
        return
    required = {name: "impact" for name, one in options.items() if one.default is one.empty}
    words = f"^invalid value 'x' for '{name}|^{name} = x is not valid: |^unknown {name} .x.; one of"
    with pytest.raises((hc.ParameterError, hc.UnknownNameError), match=words) as caught:
        function(**{**required, name: "x"})
    assert "--" not in str(caught.value)


def test_there_are_as_many_functions_as_studies() -> None:
    assert len(FUNCTIONS) >= 30
    with pytest.raises(hc.UnknownNameError, match="did you mean 'wave_exact'"):
        hc.study("wave exakt")
    with pytest.raises(hc.UnknownNameError, match="unknown study"):
        hc.study("run", scene="impact")


REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("wave exact", {"q_over_pi": -0.5}, "^q_over_pi = -0.5 is not valid: "),
    ("wave exact", {"q_ovr_pi": 0.5}, "^unknown option 'q_ovr_pi'; did you mean 'q_over_pi'"),
    ("wave exact", {"json": True}, "^unknown option"),
    ("breather continue", {"from": 2.0}, "^unknown option"),
    ("breather continue", {"from_": 1.0, "to": 2.1}, "^from_ = 1 is not valid: "),
    ("breather continue", {"vary": "rho"}, "needs `from_` and `to`"),
    ("breather continue", {"sites": 2.5}, "'2.5' for 'sites <N>'"),
    ("breather continue", {"shard": "1/2"}, "^shard = 1/2 is not valid: .*give `out`"),
    ("breather continue", {"resume": "f", "sites": 5}, "'sites <N>' cannot be used with 'resume <PATH>'"),
    ("breather dark", {"formulation": "full-perod"}, 'unknown formulation "full-perod"; did you mean "full-period"'),
    ("compare", {"scene": "impact", "integrators": ["verlett"]}, 'did you mean "verlet"'),
    ("study theorem", {"epsilons": []}, "epsilons"),
    ("dps integrals", {"b": 1j, "r": 1.0}, "^b = 1j is not valid: a number"),
    ("sweep", {"template": "maybe"}, "template"),
    ("orbit driven", {"scene": hc.Scene.load("granular-crystal"), "set": {"chain.rho": -1}}, "^scene granular-crystal: .*rho"),
]


@pytest.mark.parametrize(("command", "options", "message"), REFUSED)
def test_refusals_speak_the_names_of_python(command: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(hc.Error, match=message) as caught:
        hc.study(command, **options)
    assert not isinstance(caught.value, hc.InternalError) and " --" not in str(caught.value)


def test_a_scene_of_ones_own_is_the_scene_of_a_study(program: Any, tmp_path: Path) -> None:
    scene = hc.Scene.load("granular-crystal", {"chain.sites": 6, "initial.site": 1})
    file = tmp_path / "mine.toml"
    file.write_text(scene.to_toml())
    done = hc.studies.orbit_driven(scene, settle=20)
    assert done.record == program("orbit", "driven", str(file), "--settle", "20")
    chain = hc.Chain(sites=3, boundary="fixed", precompression=1 / 3)
    assert hc.studies.orbit_mode(chain, to=0.01).record["scene"] == "chain"


def test_ctrl_c_stops_a_study_which_leaves_what_was_done() -> None:
    told: list[float] = []
    timer = threading.Timer(1.0, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        hc.study("breather continue", sites=11, from_=2.02, to=2.04, step=1e-6, max_points=100_000, progress=told.append)
    timer.join()
    partial = caught.value.partial  # type: ignore[attr-defined]
    assert isinstance(partial, hc.Study) and partial.record["end"] == "stopped" and partial.tables
    assert told and all(0 <= share <= 1 for share in told)


def test_a_study_with_a_folder_keeps_its_points_there(tmp_path: Path) -> None:
    options: dict[str, Any] = {"sites": 5, "from_": 2.02, "to": 2.04, "step": 0.0005, "bifurcations": True}
    parts = [hc.study("breather continue", shard=f"{k}/2", out=tmp_path, **options) for k in (1, 2)]
    assert [part.record["shard"] for part in parts] == ["1/2", "2/2"] and "kept" in parts[0].text
    whole = hc.study("breather continue", out=tmp_path, format=["svg"], **options)
    assert whole.record == hc.study("breather continue", **options).record
    assert (tmp_path / "branch.npz").read_bytes() == whole.file("branch.npz")
    assert list(tmp_path.glob("*.svg")) and not list(tmp_path.glob("*.png"))
    with pytest.raises(hc.ParameterError, match="one of branch.csv"):
        whole.file("brunch.npz")


def test_a_study_that_fails_warns() -> None:
    with pytest.warns(RuntimeWarning, match="not at"):
        lost = hc.studies.breather_continue(sites=7, from_=2.02, to=2.2, step=0.01, max_points=3)
    assert lost.failure is not None and len(lost.record["points"]) == 3
