from __future__ import annotations

import csv
import io
import json
import math
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from matplotlib import image
from matplotlib.collections import LineCollection

import popsteer
from popsteer import lab, sim, tracks
from popsteer.lab.common.layout import WIDE
from popsteer.lab.common.theme import THEMES
from popsteer.lab.compare.figures import _LABELS as LABELS
from popsteer.lab.compare.figures import overview_figure, results_figure
from tests.cli import command
from tests.helpers import authors_data

if TYPE_CHECKING:
    from pathlib import Path

    from tests.cli.command import Outcome

COLUMNS = "--columns", "x,y,speed"  # of a file that names none
FIGURES = ("results", "results-dark", "overview", "overview-dark")
LAWS = ("pid", "pure-pursuit", "stanley", "pop")
METRICS = (
    "mean_abs_cross_track_error",
    "rms_cross_track_error",
    "max_abs_cross_track_error",
    "settled_mean_abs_cross_track_error",
    "mean_abs_heading_error",
    "max_abs_steer",
    "rms_steer_rate",
    "time",
)


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Outcome, Path]:
    """The main job, once, as anybody would start it."""
    out = tmp_path_factory.mktemp("demo") / "new" / "out"
    return command.run("compare", "--out", str(out)), out


def test_compare_prints_one_table_without_control_characters(demo: tuple[Outcome, Path]) -> None:
    outcome, out = demo
    assert outcome.status == 0
    assert outcome.err == ""
    assert "\x1b" not in outcome.out
    assert "…" not in outcome.out
    for title in ("PID", "Pure-Pursuit", "Stanley", "POP"):
        assert sum(line.startswith(f"{title} ") for line in outcome.out.splitlines()) == 1
    assert "racetrack, 1274 waypoints, 1273 m, plant carla-identified" in outcome.out
    assert "ratio" not in outcome.out  # to the paper, whose track this is not
    assert str(out) in outcome.out


def test_compare_writes_all_files_and_no_other(demo: tuple[Outcome, Path]) -> None:
    _, out = demo
    files = {str(file.relative_to(out)) for file in out.rglob("*") if file.is_file()}
    expected = {"metrics.json"}
    expected |= {f"runs/{law}.csv" for law in LAWS}
    expected |= {f"{figure}.{kind}" for figure in FIGURES for kind in ("png", "svg")}
    assert files == expected


def test_compare_metrics_have_the_documented_layout(demo: tuple[Outcome, Path]) -> None:
    metrics = json.loads((demo[1] / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["schema"] == 3
    assert metrics["dt"] == 0.05
    assert metrics["plant"] == "carla-identified"
    assert metrics["path"]["waypoints"] == 1274
    assert metrics["path"]["length"] == pytest.approx(1273, abs=1)
    car = sim.vehicle_of("carla-identified")
    assert metrics["plant_vehicle"] == car.as_dict()
    assert list(metrics["controllers"]) == list(LAWS)
    assert all(each["vehicle"] == car.as_dict() for each in metrics["controllers"].values())
    for controller in metrics["controllers"].values():
        assert all(math.isfinite(controller[name]) for name in METRICS)
        assert all(math.isfinite(controller["rear_axle"][name]) for name in METRICS[:5])
        assert controller["finished"] is True
        assert isinstance(controller["steps"], int)
    assert metrics["paper"] == {
        law: lab.compare.paper.PAPER[law]._asdict() for law in metrics["paper"]
    }
    assert set(metrics["paper"]) == set(LAWS)


def test_compare_table_shows_the_figures_of_the_metrics(demo: tuple[Outcome, Path]) -> None:
    outcome, out = demo
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    row = next(line for line in outcome.out.splitlines() if line.startswith("POP "))
    pop = metrics["controllers"]["pop"]
    assert f"{pop['mean_abs_cross_track_error']:.4f}" in row
    assert f"{pop['rear_axle']['mean_abs_cross_track_error']:.4f}" in row
    assert f"{math.degrees(pop['max_abs_steer']):.1f}" in row


def test_compare_runs_read_back_to_the_bits_that_were_measured(demo: tuple[Outcome, Path]) -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed, closed=track.closed)
    run = lab.compare.run(path, ["stanley"]).runs["stanley"]
    text = (demo[1] / "runs" / "stanley.csv").read_text(encoding="utf-8")
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert any("cross_track_error [m]" in line for line in comments)
    rows = csv.DictReader(io.StringIO("".join(text.splitlines(keepends=True)[len(comments) :])))
    columns: dict[str, list[str]] = {name: [] for name in rows.fieldnames or ()}
    for row in rows:
        for name, value in row.items():
            columns[name].append(value)
    assert columns.keys() == run.records.keys()
    for name, column in run.records.items():
        read = np.array(columns[name], dtype=column.dtype)
        assert np.array_equal(read.view(np.uint8), column.view(np.uint8)), name


@pytest.mark.parametrize("figure", FIGURES)
def test_compare_figures_are_real_pictures(demo: tuple[Outcome, Path], figure: str) -> None:
    pixels = image.imread(demo[1] / f"{figure}.png")
    height, width = pixels.shape[:2]
    assert min(height, width) >= 800
    brightness = float(pixels[..., :3].mean())
    assert brightness < 0.3 if "dark" in figure else brightness > 0.7
    assert float(pixels[..., :3].std()) > 0.03  # something is drawn
    svg = ET.parse(demo[1] / f"{figure}.svg").getroot()
    assert svg.tag.endswith("svg")
    assert len(list(svg.iter())) > 100


def test_compare_of_the_authors_run_reproduces_the_paper(
    capsys: pytest.CaptureFixture[str],
) -> None:
    waypoints = authors_data() / "waypoints.csv"
    outcome = command.call(capsys, "paper", "--waypoints", str(waypoints), *COLUMNS)
    assert outcome.status == 0
    assert "PID row could not be reproduced" in outcome.out
    assert "another track" not in outcome.out
    pop = next(line for line in outcome.out.splitlines() if line.startswith("POP ")).split()
    assert pop[1:4] == ["finished", "reproduction", "front"]
    assert float(pop[6]) == pytest.approx(1.0, abs=0.05)  # the ratio to the paper


def test_waypoints_with_speeds_are_driven_at_them(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "course.csv"
    rows = "".join(f"{x},0,4\n" for x in range(60))
    file.write_text(f"x,y,speed\n{rows}", encoding="utf-8")
    on = ("--waypoints", str(file), "--controllers", "stanley", "--start-offset")
    for options, seconds, said in (
        (("1",), 16.0, "1.00 m left of the path, beside its first waypoint, at 0 m/s; speed-tr"),
        (
            ("0", "--speed", "4"),
            14.8,
            "on the path, at its first waypoint, at 4 m/s; speed-tracker",
        ),
        (("0", "--longitudinal", "coupled"), 5.2, "towards 69.44 m/s, not the speeds of the way"),
        (("0", "--constant-speed", "6"), 9.8, "at 6 m/s; 6 m/s are kept."),
    ):
        outcome = command.call(capsys, "compare", *on, *options)
        row = next(line for line in outcome.out.splitlines() if line.startswith("Stanley ")).split()
        assert abs(float(row[-1]) - seconds) < 1.5, (options, row)
        assert "Starts with the front axle " in outcome.out, outcome.out
        assert said in outcome.out, outcome.out


def test_start_is_the_pose_of_the_vehicles_point_unless_it_is_said_to_be_an_axles(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("popsteer.lab.common.draw.drawn", lambda *arguments: {})
    waypoints = str(authors_data() / "waypoints.csv")
    yaw = -1.574
    # Where CARLA's front axle stood: 1.06 m ahead of the point whose pose is predicted.
    front = (-183.8, 78.7)
    point = (front[0] - 1.06 * math.cos(yaw), front[1] - 1.06 * math.sin(yaw))
    rear = (front[0] - 3.0 * math.cos(yaw), front[1] - 3.0 * math.sin(yaw))
    assert point == pytest.approx((-183.797, 79.760), abs=1e-3)
    starts = {
        "front": ("--start=-183.8,78.7,-1.574", "--start-at", "front"),
        "pose": ("--start=-183.797,79.760,-1.574",),
        "rear": (f"--start={rear[0]!r},{rear[1]!r},{yaw!r}", "--start-at", "rear"),
    }
    for name, start in starts.items():
        out = tmp_path / name
        arguments = (
            "compare",
            "--controllers",
            "pop",
            "--waypoints",
            waypoints,
            *COLUMNS,
            *start,
            "--out",
            str(out),
        )
        assert command.call(capsys, *arguments).status == 0
        first = _records(out / "runs" / "pop.csv")[0]
        assert (first["x"], first["y"], first["yaw"]) == pytest.approx((*point, yaw), abs=1e-3)
        reference = (first["reference_x"], first["reference_y"])
        assert reference == pytest.approx(front, abs=1e-3)
        begun = json.loads((out / "metrics.json").read_text(encoding="utf-8"))["start"]
        assert (begun["x"], begun["y"], begun["yaw"]) == (first["x"], first["y"], first["yaw"])


def _records(file: Path) -> list[dict[str, float]]:
    lines = file.read_text(encoding="utf-8").splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return [{name: float(value) for name, value in row.items()} for row in rows]


def test_compare_with_a_car_of_ones_own_says_what_the_controllers_believed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    car = tmp_path / "car.toml"
    popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, dead_time=0.15).save(car)
    arguments = ("compare", "--track", "slalom", "--controllers", "preview-pop,stanley")
    plant = ("--plant", str(car))
    predicted = command.call(capsys, *arguments, *plant)
    assert (predicted.status, predicted.err) == (0, "")
    assert "plant car.toml, dt" in predicted.out
    late = command.call(capsys, *arguments, *plant, "--set-vehicle", "dead_time=0")
    assert "plant car.toml, believed dead_time 0, dt" in late.out
    assert late.out != predicted.out
    elsewhere = command.call(capsys, *arguments, *plant, "--vehicle", "paper")
    assert (elsewhere.status, elsewhere.out) == (2, "")
    assert "rear_axle must be that of the plant, -1.35, got 0.0" in elsewhere.err


def test_runs_tell_what_the_bits_of_a_status_mean(demo: tuple[Outcome, Path]) -> None:
    text = (demo[1] / "runs" / "pop.csv").read_text(encoding="utf-8")
    assert "status [bits: 1 saturated | 2 lookahead-lost | 4 end-of-path | 8 off-path" in text


@pytest.mark.parametrize("preset", ["default", "paper", "published-code", "reproduction"])
@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_compare_with_each_preset_and_plant_says_so(
    capsys: pytest.CaptureFixture[str], preset: str, plant: str
) -> None:
    arguments = ("compare", "--track", "slalom", "--preset", preset, "--plant", plant)
    outcome = command.call(capsys, *arguments)
    assert outcome.status == 0
    assert f"plant {plant}, dt" in outcome.out
    rows = [line.split() for line in outcome.out.splitlines()]
    tuning = {
        row[0]: row[row.index(preset) :][:2]
        for row in rows
        if row and row[0] in {"POP", "Pure-Pursuit"}
    }
    assert tuning == {"POP": [preset, "front"], "Pure-Pursuit": [preset, "rear"]}


def test_compare_drives_a_car_of_ones_own_as_the_library_does(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """No tuning and no pedals of the paper's car: a car of 0.33 m keeps to bends of 1.5 m."""
    car = popsteer.Vehicle(
        wheelbase=0.33, max_steer=0.4, max_steer_rate=3.0, steer_lag=0.05, max_speed=2.0
    )
    car.save(tmp_path / "rc.toml")
    angle = np.linspace(0.0, 4.5, 90)
    xy = np.column_stack((1.5 * np.sin(angle), 1.5 - 1.5 * np.cos(angle)))
    np.savetxt(tmp_path / "rc.csv", xy, delimiter=",")
    own = ["--plant", str(tmp_path / "rc.toml"), "--waypoints", str(tmp_path / "rc.csv")]
    own += ["--start-offset", "0"]
    command.call(
        capsys, "compare", *own, "--controllers", "pop,pure-pursuit,stanley", "--out", str(tmp_path)
    )
    metrics = json.loads((tmp_path / "metrics.json").read_text(encoding="utf-8"))
    for name, found in metrics["controllers"].items():
        assert (found["tuning"], found["finished"]) == ("default", True)
        assert found["mean_abs_cross_track_error"] < 0.25, name
        made = popsteer.controllers.get(name).controller(popsteer.Path(xy), car)
        assert found["params"] == made.params.resolved(car).as_dict()
    speeds = _records(tmp_path / "runs" / "stanley.csv")
    assert 1.0 < max(row["speed"] for row in speeds) < 2.1


def test_plant_that_cannot_start_from_rest_is_driven_as_it_is(
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("vehiclemodels")
    outcome = command.call(
        capsys,
        "compare",
        "--plant",
        "commonroad-mb-2",
        "--track",
        "slalom",
        "--controllers",
        "stanley",
    )
    assert (outcome.status, outcome.err) == (0, "")
    assert "at 1 m/s (this plant cannot start from rest); speed-tracker" in outcome.out
    row = next(line for line in outcome.out.splitlines() if line.startswith("Stanley "))
    assert row.split()[1] == "finished"


def test_compare_keeps_the_order_of_the_controllers_and_drops_repetitions(
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = ("compare", "--track", "straight", "--controllers", "pop, stanley,pop,pid")
    outcome = command.call(capsys, *arguments)
    titles = ["POP", "Stanley", "PID"]
    rows = [line.partition(" ")[0] for line in outcome.out.splitlines()]
    assert [row for row in rows if row in titles] == titles


def test_compare_closed_waypoints_go_round(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    command.call(capsys, "tracks", "--tracks", "circle", "--out", str(tmp_path))
    file = tmp_path / "circle.csv"
    arguments = ("compare", "--waypoints", str(file), "--controllers", "pop")
    opened = command.call(capsys, *arguments)
    closed = command.call(capsys, *arguments, "--closed")
    assert "314 waypoints, 313 m" in opened.out
    assert "314 waypoints, 314 m" in closed.out


def test_compare_where_drawing_fails_writes_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from popsteer.lab.common import draw

    def fail(*arguments: Any) -> Any:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(draw, "drawn", fail)
    out = tmp_path / "out"
    outcome = command.call(capsys, "compare", "--track", "straight", "--out", str(out))
    assert (outcome.status, outcome.err) == (2, "popsteer: No space left on device\n")
    assert list(tmp_path.iterdir()) == []


def test_compare_again_in_another_process_writes_the_same_files(demo: tuple[Outcome, Path]) -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed, closed=track.closed)
    (comparison,) = lab.compare.run_each(
        {track.name: path}, LAWS, ["carla-identified"], joined=True
    )
    for name, data in lab.compare.files.files(comparison).items():
        assert (demo[1] / name).read_bytes() == data, name


def test_table_has_the_largest_error_after_settling() -> None:
    path = popsteer.Path(tracks.get("slalom").xy)
    found = lab.compare.run(path, ["pop"], constant_speed=8.0)
    (shown,) = lab.compare.table.tables(found)
    heads = [str(column.header) for column in shown.columns]
    (cell,) = shown.columns[heads.index("max [m]\nafter\n5 s")].cells
    assert str(cell) == f"{found.first.metrics.settled_max_abs_cross_track_error:.3f}"


def test_settling_time_that_is_given_counts_and_not_when_the_vehicle_has_joined(
    capsys: pytest.CaptureFixture[str],
) -> None:
    brief = ("compare", "--controllers", "pop", "--track", "slalom", "--constant-speed", "8")
    shown = command.call(capsys, *brief, "--set-run", "time_limit=6").out
    assert "joins its path" in shown
    shown = command.call(
        capsys, *brief, "--set-run", "time_limit=6", "--set-run", "settling_time=3"
    ).out
    assert "joins its path" not in shown
    assert " 3 s " in shown


def test_start_is_faint_and_does_not_own_the_axes() -> None:
    path = popsteer.Path(tracks.get("slalom").xy)
    start = sim.default_start(path, -2.44, sim.vehicle_of("carla-identified"))
    laws = ["pop", "preview-pop", "stanley"]
    found = lab.compare.run(path, laws, constant_speed=8.0, start=start)
    figure = results_figure(found, THEMES["dark"])
    rows = [[panel for panel in figure.axes if panel.get_ylabel() == label] for label in LABELS]
    settled = max(run.metrics.settled_max_abs_cross_track_error for run in found.runs.values())
    (panel,) = rows[0]
    assert settled <= panel.get_ylim()[1] < 1.5 * settled < 2.44
    faint, clear = (
        line
        for line in panel.lines
        if len(line.get_xdata()) > 2  # type: ignore[arg-type]
    )
    assert (faint.get_alpha(), clear.get_alpha()) == (0.35, 1.0)
    assert clear.get_xdata()[0] == pytest.approx(5.0)  # type: ignore[index]
    # What is beyond is marked at the edge, where it lies.
    (mark,) = (line for line in panel.lines if line.get_marker() == "v")
    assert list(mark.get_ydata()) == [panel.get_ylim()[0]]  # type: ignore[arg-type]


def test_map_is_coloured_by_the_error_and_lines_differ_by_their_dashes() -> None:
    found = lab.compare.run(popsteer.Path(tracks.get("slalom").xy), LAWS)
    figure = results_figure(found, THEMES["light"])
    shown = [each for panel in figure.axes for each in panel.collections if len(panel.lines) < 4]
    driven = [each for each in shown if isinstance(each, LineCollection)]
    for line, run in zip(driven, found.runs.values(), strict=False):
        errors = np.abs(run.records["cross_track_error"][1:])
        assert np.array_equal(np.asarray(line.get_array()), errors)
    assert len(driven) >= len(LAWS)
    overview = overview_figure(found, THEMES["light"]).axes[0]
    legend = overview.get_legend()
    assert legend is not None
    dashes = {str(line._dash_pattern) for line in legend.get_lines()}  # type: ignore[attr-defined]
    assert len(dashes) == len(LAWS)


def test_faults_stand_below_the_picture_of_the_papers_track(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = popsteer.Path(tracks.get("slalom").xy)
    strict = popsteer.MonitorParams(deviation_limit=0.05)
    found = lab.compare.run(path, ["pop"], constant_speed=8.0, monitor=strict)
    monkeypatch.setattr("popsteer.lab.compare.figures.is_authors_path", lambda _: True)
    figure = overview_figure(found, THEMES["light"])
    assert figure.get_supxlabel().startswith("✗ Fault of POP: deviating")
    assert "\n" not in figure.get_supxlabel()


@pytest.mark.parametrize("width", [80, WIDE])
def test_table_of_all_laws_fits_its_width(width: int) -> None:
    from rich.console import Console

    comparison = lab.compare.run(
        popsteer.Path(tracks.get("racetrack").xy),
        LAWS,
    )
    stream = io.StringIO()
    console = Console(file=stream, width=width)
    for table in lab.compare.table.tables(comparison, width=width):
        console.print(table)
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    assert "…" not in stream.getvalue()


def test_metrics_of_a_single_step_hold_null_for_what_is_not_a_number() -> None:
    settings = popsteer.sim.Settings(time_limit=0.05)
    path = popsteer.Path(tracks.get("straight").xy)
    document = lab.compare.files.metrics_document(lab.compare.run(path, ["pop"], settings=settings))
    pop = document["controllers"]["pop"]
    assert pop["steps"] == 1
    assert pop["settled_mean_abs_cross_track_error"] is None
    assert pop["rms_steer_rate"] is None
    json.dumps(document, allow_nan=False)


def test_files_of_a_single_step_can_be_drawn() -> None:
    settings = popsteer.sim.Settings(time_limit=0.05)
    path = popsteer.Path([(0.0, 0.0), (0.0, 30.0)])
    content = lab.compare.files.files(lab.compare.run(path, ["stanley", "pop"], settings=settings))
    assert content["results.png"].startswith(b"\x89PNG")
