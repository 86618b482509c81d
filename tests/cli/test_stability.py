from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import Vehicle
from popsteer.lab import stability
from popsteer.lab.common.theme import THEMES
from popsteer.lab.stability import figures as drawing
from popsteer.lab.stability import margins
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path


def _rows(out: str) -> dict[str, list[list[str]]]:
    """Cells of each row after the law's name, by law."""
    rows: dict[str, list[list[str]]] = {}
    law = ""
    for line in out.partition("──\n")[2].partition("\n\nSmall")[0].splitlines():
        cells = line.split()
        if cells and not line[0].isspace():
            law, cells = line[:14].strip(), line[14:].split()
        if cells:
            rows.setdefault(law, []).append(cells)
    return rows


def test_stability_prints_the_margins_of_each_controller_at_each_speed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    outcome = command.call(capsys, "stability", "--speeds", "5,25")
    assert outcome.status == 0
    rows = _rows(outcome.out)
    assert list(rows) == ["PID", "Pure-Pursuit", "Stanley", "POP", "Preview POP"]
    expected = stability.run(["pop"], Vehicle(), [5.0, 25.0]).margins["pop"]
    for cells, speed, found in zip(rows["POP"], ("5", "25"), expected, strict=True):
        distance = "7.0" if speed == "5" else "11.0"
        phase = f"{np.degrees(found.phase):.1f}"
        assert cells == [
            speed,
            distance,
            f"{found.gain:.2f}",
            phase,
            f"{1e3 * found.dead_time:.0f}",
        ]
    assert rows["PID"][1] == ["25", "–", "–", "–"]
    assert "[m/s]" in outcome.out


@pytest.mark.usefixtures("_coarse", "_blank_figures")
def test_stability_takes_the_vehicle_from_a_file_and_as_it_is_changed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out, car = tmp_path / "new", tmp_path / "car.toml"
    Vehicle(wheelbase=2.7, rear_axle=-1.35, steer_lag=0.2).save(car)
    options = ("--vehicle", str(car), "--set-vehicle", "dead_time=0.05")
    law = ("--controllers", "pop", "--set", "min_lookahead=9", "--speeds", "8")
    outcome = command.call(capsys, "stability", *options, *law, "--out", str(out))
    assert outcome.status == 0
    assert f"Written to {out}/: " in outcome.out
    document = json.loads((out / "stability.json").read_text(encoding="utf-8"))
    vehicle = Vehicle(wheelbase=2.7, rear_axle=-1.35, steer_lag=0.2, dead_time=0.05)
    assert document["vehicle"] == document["plant_vehicle"] == vehicle.as_dict()
    assert document["params"]["pop"]["min_lookahead"] == 9.0
    found = margins(popsteer.PopParams(min_lookahead=9.0), vehicle, 8.0)
    assert document["laws"]["pop"] == [{"speed": 8.0, "lookahead": 10.6, **found._asdict()}]


@pytest.mark.usefixtures("_coarse", "_blank_figures")
def test_stability_of_a_plant_that_nobody_told_says_what_was_believed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "stability.json"
    arguments = ("--controllers", "stanley", "--speeds", "10", "--out", str(tmp_path))
    late = ("--set-plant", "dead_time=0.1", "--set-plant", "max_steer_rate=0.4")
    outcome = command.call(capsys, "stability", *arguments, *late)
    believed = "dead time 0.1 s, believed dead_time 0 and max_steer_rate none, preset default"
    assert believed in outcome.out
    (row,) = json.loads(file.read_text(encoding="utf-8"))["laws"]["stanley"]
    prompt = margins(popsteer.StanleyParams(), Vehicle(), 10.0).dead_time
    assert row["dead_time"] == pytest.approx(prompt - 0.1, abs=1e-4)
    known = command.call(capsys, "stability", *arguments, "--set-vehicle", "dead_time=0.1")
    assert "believed" not in known.out
    (predicted,) = json.loads(file.read_text(encoding="utf-8"))["laws"]["stanley"]
    assert predicted["dead_time"] > 1.3 * row["dead_time"]
    other = ("--vehicle", "paper", "--plant", "carla-identified", "--speeds", "10")
    outcome = command.call(capsys, "stability", *other)
    assert "axles at 1.06 and -1.94 m" in outcome.out
    assert "believed rear_axle 0 and no_slip_point none" in outcome.out
    # As in the other commands, the controllers know the plant where nothing else is said.
    same = ("--plant", "carla-identified", "--set-plant", "dead_time=0.2", "--speeds", "10")
    outcome = command.call(capsys, "stability", *same)
    assert "dead time 0.2 s, believed dead_time 0, preset" in outcome.out


def test_stability_of_a_named_vehicle_begins_with_its_figures(
    capsys: pytest.CaptureFixture[str],
) -> None:
    outcome = command.call(capsys, "stability", "--vehicle", "carla-identified", "--speeds", "5")
    assert outcome.out.startswith(
        "wheelbase 3 m, turns as 3.553 m, understeer 0.00029 s²/m, axles at 1.06 and -1.94 m,"
        " lag 0.1 s, dead time 0 s, preset default"
    )


@pytest.mark.usefixtures("_coarse", "_blank_figures")
def test_stability_json_has_null_where_there_is_no_number(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "stability.json"
    arguments = ("--controllers", "pid", "--speeds", "25", "--out", str(tmp_path))
    assert command.call(capsys, "stability", *arguments).status == 0
    row = json.loads(file.read_text(encoding="utf-8"))["laws"]["pid"][0]
    assert row["stable"] is False
    assert [row[name] for name in ("lookahead", "gain", "phase", "dead_time")] == [None] * 4


@pytest.mark.usefixtures("_coarse")
def test_stability_figures_are_drawn_on_both_backgrounds(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    outcome = command.call(capsys, "stability", "--speeds", "5", "--out", str(tmp_path / "f"))
    assert outcome.status == 0
    figures = {"stability-margins", "stability-loops", "stability-map"}
    names = {f"{name}{suffix}.png" for name in figures for suffix in ("", "-dark")}
    assert {file.name for file in (tmp_path / "f").iterdir()} == names | {"stability.json"}
    for name in names:
        assert name in outcome.out
        assert (tmp_path / "f" / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("_coarse", "_blank_figures")
def test_stability_figures_of_a_law_without_lookahead_are_fewer() -> None:
    reported: list[float] = []
    drawn = drawing.stability_figures(
        stability.run(["stanley"]), lambda what, share: reported.append(share)
    )
    wanted = {f"stability-{of}{dark}.png" for of in ("margins", "loops") for dark in ("", "-dark")}
    assert set(drawn) == wanted
    assert reported == sorted(reported)
    assert reported[-1] == pytest.approx(1.0)


def test_controllers_without_an_answer_to_the_step_are_named() -> None:
    result = stability.run(["pid", "pure-pursuit"], Vehicle(), [25.0])
    figure = drawing.loops_figure(result, drawing.responses(result), THEMES["light"])
    assert [each.stable for (each,) in result.margins.values()] == [False, True]
    assert figure.get_suptitle().endswith("unstable, so without an answer to the step: PID")


@looped(
    ("arguments", "message"),
    [
        (("--controllers", "lqr"), "unknown controller 'lqr'"),
        (("--speeds", "fast"), "--speeds must be numbers [m/s], separated by commas, got 'fast'"),
        (("--speeds", ","), "--speeds must be numbers [m/s]"),
        (("--speeds", "0"), "speed must be in [0.001, 1000], got 0.0"),
        (("--set-vehicle", "steer_lag=-1"), "steer_lag must be in [0, 10], got -1.0"),
        (("--set-vehicle", "wheelbase=nan"), "wheelbase must be in"),
        (("--set-plant", "wheelbase=none"), "wheelbase must be a number, got 'none'"),
        (("--set-vehicle", "lag=1"), "unknown parameter of the vehicle 'lag'; known: wheelbase,"),
        (("--vehicle", "tank"), "unknown vehicle 'tank'; known: paper, carla-identified,"),
        (("--plant", "tank"), "unknown vehicle 'tank'"),
        (("--vehicle", "missing.toml"), "missing.toml: "),
        (
            ("--set", "amplitude=1"),
            "unknown parameter of pid or pure-pursuit or stanley or pop or preview-pop",
        ),
        (("--dt", "0"), "dt must be in"),
    ],
)
def test_stability_of_bad_input_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], message: str
) -> None:
    outcome = command.call(capsys, "stability", *arguments)
    assert outcome.status == 2
    assert outcome.out == ""
    assert outcome.err.startswith(f"popsteer: {message}")
    assert outcome.err.count("\n") == 1
