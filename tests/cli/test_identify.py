from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from tests.bags import write_bag
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def columns() -> dict[str, Any]:
    return command.drive()


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, columns: dict[str, Any]) -> Path:
    return command.write_csv(tmp_path_factory.mktemp("log") / "drive.csv", columns)


def test_identify_writes_a_vehicle_and_what_it_was_made_of(
    capsys: pytest.CaptureFixture[str], file: Path, tmp_path: Path
) -> None:
    out, document, rows = (
        tmp_path / "new" / name for name in ("car.toml", "car.json", "car-motion.csv")
    )
    outcome = command.call(capsys, "identify", str(file), "--out", str(out))
    assert (outcome.status, outcome.err) == (0, "")
    car = popsteer.Vehicle.load(out)
    assert car.wheelbase == pytest.approx(2.7, abs=0.03)
    assert car.steer_offset == pytest.approx(0.01, abs=math.radians(0.05))
    assert car.dead_time + car.steer_lag == pytest.approx(0.25, abs=0.01)
    assert car.rear_axle == pytest.approx(-1.35, abs=0.08)
    assert "# NOT FOUND: the wheels were not seen against a limit of their rate" in out.read_text()
    assert "± 0.000" not in outcome.out
    assert "given" not in outcome.out.partition("The vehicle ")[0]
    found = json.loads(document.read_text())
    assert found["vehicle"]["wheelbase"] == car.wheelbase
    assert len(rows.read_text().splitlines()) == 802
    for name in ("car.png", "car-dark.svg"):
        assert (out.parent / name).stat().st_size > 10_000
        assert name in outcome.out
    assert len(list(out.parent.iterdir())) == 7
    for part in (
        "drive.csv: 40.0 s, 800 rows",
        "wheelbase",
        "dead time and lag together",
        "± noise",
        "± model",
        "The vehicle explains the heading to within the noise of the log",
        "drive steps of 0.2 rad and more",
    ):
        assert part in outcome.out
    assert max(map(len, outcome.out.split("\nThe vehicle ")[0].splitlines())) <= 80


@pytest.mark.usefixtures("_blank_figures")
def test_lines_of_the_figure_are_told_by_more_than_their_colours(file: Path) -> None:
    from popsteer.lab.common.theme import THEMES
    from popsteer.lab.identify.figure import identified_figure

    figure = identified_figure(popsteer.identify(popsteer.logs.read(file)), THEMES["dark"])
    panels = [panel for part in figure.subfigs for panel in part.axes]
    assert len(panels) == 7
    told: list[Any] = [panel.get_legend_handles_labels()[0] for panel in panels]
    assert max(map(len, told)) >= 4  # the profile likelihoods
    for lines in told:
        looks = {(each.get_marker(), each.get_linewidth()) for each in lines}
        assert len(looks) == len(lines)


def test_identify_of_an_mcap_with_a_tape_measure_keeps_what_it_says(
    capsys: pytest.CaptureFixture[str], columns: dict[str, Any], tmp_path: Path
) -> None:
    pytest.importorskip("rosbags")
    bag, out = write_bag(tmp_path / "bag", columns), tmp_path / "car.toml"
    given = tmp_path / "given.toml"
    given.write_text("wheelbase = 2.65\nmax_speed = inf\n")
    changes = ("rear_axle=-1.35", "max_steer=1.22")  # of which one is its default
    told = ["--vehicle", str(given), *(f"--set-vehicle={each}" for each in changes)]
    outcome = command.call(capsys, "identify", str(bag), "--out", str(out), *told)
    assert outcome.status == 0
    lines = out.read_text().splitlines()
    for line in ("# max_speed =", "max_steer = 1.22", "wheelbase = 2.65"):
        assert lines[lines.index(line) - 1] == "# given"
    car = popsteer.Vehicle.load(out)
    assert (car.wheelbase, car.rear_axle) == (2.65, -1.35)
    assert car.turning_wheelbase == pytest.approx(2.7, abs=0.03)


@looped(
    ("arguments", "message"),
    [
        (["--columns", "steer=delta"], "no column 'delta'; there are: t, x, y, yaw, speed, steer"),
        (["--columns", "stear=delta"], "columns must be one of t, x, y"),
        (["--unit", "steer=furlong"], "unit of steer must be rad, deg, mrad, a number"),
        (["--unit", "steer=-1"], "turns right where steer says left"),
        (["--topic", "steer=/drive"], "topics are of bags; a table has columns"),
        (["--unit", "speed=0.001"], "move 1000 times as far as speed says: x and y are in mm"),
        (["--vehicle", "none.toml"], "none.toml: No such file"),
        (["--out", "car.json"], "--out must be a file *.toml"),
        (["--figures", "pictures"], "No such option: --figures; it is --out now"),
    ],
)
def test_identify_of_wrong_input_is_one_line_and_writes_nothing(
    capsys: pytest.CaptureFixture[str],
    file: Path,
    tmp_path: Path,
    arguments: list[str],
    message: str,
) -> None:
    out = tmp_path / "car.toml"
    outcome = command.call(capsys, "identify", str(file), "--out", str(out), *arguments)
    assert (outcome.status, outcome.out) == (2, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_identify_into_a_folder_that_cannot_be_is_refused_at_once(
    capsys: pytest.CaptureFixture[str], file: Path
) -> None:
    outcome = command.call(capsys, "identify", str(file), "--out", "/dev/null/car.toml")
    assert outcome.status == 2
    assert "/dev/null/car.toml" in outcome.err


def test_identify_interrupted_says_nothing_and_writes_nothing(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    file: Path,
    tmp_path: Path,
) -> None:
    from popsteer import identification

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(identification, "identify", interrupted)
    outcome = command.call(capsys, "identify", str(file), "--out", str(tmp_path / "car.toml"))
    assert (outcome.status, outcome.out, outcome.err) == (130, "", "")
    assert not any(tmp_path.iterdir())
