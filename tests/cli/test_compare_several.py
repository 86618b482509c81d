"""``popsteer compare`` of several plants and tracks: a table, files and a figure."""

from __future__ import annotations

import csv
import itertools
import json
import math
import platform
import statistics
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import lab, sim, tracks
from popsteer.cli import inputs
from popsteer.errors import ConfigError
from popsteer.lab.common.theme import THEMES
from popsteer.lab.compare.figures import effort_figure, results_figure
from popsteer.lab.compare.table import notes
from popsteer.sim.closed_loop import START_OFFSET
from tests.cli import command
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

PLANTS = ("carla-identified", "kinematic-bicycle")
LAWS = ("stanley", "pop")


@pytest.mark.usefixtures("_blank_figures")
def test_comparison_writes_every_combination(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = command.call(
        capsys,
        "compare",
        *("--controllers", ",".join(LAWS), "--plants", ",".join(PLANTS)),
        *("--tracks", "straight,slalom", "--step-time", "--out", str(out)),
    )
    assert (outcome.status, outcome.err) == (0, "")
    names = {f"matrix{dark}.{kind}" for dark in ("", "-dark") for kind in ("png", "svg")}
    assert {file.name for file in out.iterdir()} == names | {
        "matrix.csv",
        "matrix.json",
        "matrix.md",
    }
    lines = (out / "matrix.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    wanted = {(p, t, law) for p in PLANTS for t in ("straight", "slalom") for law in LAWS}
    assert {(row["plant"], row["track"], row["law"]) for row in rows} == wanted
    assert len(rows) == len(wanted)
    document = json.loads((out / "matrix.json").read_text(encoding="utf-8"))
    for comparison in document["comparisons"]:
        for name, figures in comparison["controllers"].items():
            row = next(
                row
                for row in rows
                if (row["plant"], row["track"], row["law"])
                == (comparison["plant"], comparison["path"]["name"], name)
            )
            assert float(row["step_time"]) == figures["step_time"] > 0.0
            column = "settled_mean_abs_cross_track_error"
            assert float(row[column]) == figures[column]
            assert row["ending"] == figures["ending"] == "finished"
    _check_markdown((out / "matrix.md").read_text(encoding="utf-8"), rows)


def _check_markdown(text: str, rows: list[dict[str, str]]) -> None:
    *blocks, machine = text.split("\n\n")
    for track, block in zip(("straight", "slalom"), blocks, strict=True):
        head, _, *body = block.splitlines()
        assert head == f"| {track} | errors at | {' | '.join(PLANTS)} | step [µs] |"
        wanted = []
        for law, title in zip(LAWS, ("Stanley", "POP"), strict=True):
            own = [row for row in rows if (row["law"], row["track"]) == (law, track)]
            errors = [
                f"{float(row['settled_mean_abs_cross_track_error']):.4f} / "
                f"{float(row['rear_axle_settled_mean_abs_cross_track_error']):.4f}"
                for row in own
            ]
            time = statistics.median(float(row["step_time"]) for row in own)
            wanted.append(f"| {title} | front | {' | '.join(errors)} | {1e6 * time:.2f} |")
        assert body == wanted
    assert machine.endswith(f"Python {platform.python_version()}.\n")


@looped(("count", "shape"), [(1, (1, 1)), (3, (1, 3)), (4, (2, 2)), (5, (2, 3))])
def test_matrix_figure_has_a_labelled_panel_for_each_plant(
    count: int, shape: tuple[int, int]
) -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(121)])
    aside = lab.compare.run_each({"a": path}, ["pop"], ["carla-identified"], start_offset=1.0)
    (one,) = aside
    names = [f"plant {k}" for k in range(count)]
    found = [replace(one, plant=name) for name in names]
    figure = effort_figure(found, THEMES["light"])
    panels = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title() for panel in panels] == names
    grid = figure.axes[0].get_gridspec()
    assert grid is not None
    assert grid.get_geometry() == shape
    lowest = panels[-shape[1] :]
    assert all(panel.get_xlabel() == "rate of the command, rms [deg/s]" for panel in lowest)
    assert all(len(panel.lines) == 1 for panel in panels)


@looped("spread", [3.0, 6.0, 100.0, 1e5])
def test_labels_of_the_matrix_figure_do_not_overlap(spread: float) -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(121)])
    (one,) = lab.compare.run_each({"a": path}, ["pop"], ["carla-identified"])
    run = one.runs["pop"]
    rate, error = run.metrics.rms_steer_rate, run.metrics.settled_mean_abs_cross_track_error
    steeper: dict[str, Any] = {
        "rms_steer_rate": spread * rate,
        "settled_mean_abs_cross_track_error": 9.0 * error,
    }
    other = replace(run, metrics=replace(run.metrics, **steeper))
    many = [replace(one, plant=str(k), runs={"pop": (run, other)[k % 2]}) for k in range(4)]
    figure = effort_figure(many, THEMES["light"])
    figure.draw_without_rendering()
    for panel in figure.axes[2:]:  # the lower ones
        low, high = panel.get_xlim()
        ticks = [*panel.xaxis.get_major_ticks(), *panel.xaxis.get_minor_ticks()]
        ticks.sort(key=lambda tick: tick.get_loc())
        labels = [
            tick.label1.get_window_extent()
            for tick in ticks
            if low <= tick.get_loc() <= high and tick.label1.get_text()
        ]
        assert len(labels) >= 2
        assert all(one.x1 < next_.x0 for one, next_ in itertools.pairwise(labels))


def test_runs_that_have_no_place_on_the_axes_are_counted() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    exact = lab.compare.run_each({"line": path}, ["stanley", "pop"], ["kinematic-bicycle"])
    first = exact[0].first
    moved = replace(first.metrics, rms_steer_rate=0.1, settled_mean_abs_cross_track_error=0.1)
    runs = {"stanley": replace(first, metrics=moved), "pop": exact[0].runs["pop"]}
    assert exact[0].runs["pop"].metrics.settled_mean_abs_cross_track_error == 0.0
    figure = effort_figure([replace(exact[0], runs=runs)], THEMES["light"])
    assert figure.get_suptitle().endswith("; not drawn: 1 run without an error or an effort")
    figure = effort_figure([replace(exact[0], runs={"stanley": runs["stanley"]})], THEMES["light"])
    assert "not drawn" not in figure.get_suptitle()


def test_maps_of_a_comparison_have_the_same_limits() -> None:
    around = np.linspace(0.0, 2.0 * np.pi, 161)[:-1]
    loop = np.column_stack((4.0 * np.cos(around), 2.2 * np.sin(around)))
    car = popsteer.Vehicle(wheelbase=0.33, max_steer=0.42, max_speed=3.0)
    found = lab.compare.run(
        popsteer.Path(loop, closed=True), ["pop", "stanley"], sim.KinematicBicycle(car)
    )
    figure = results_figure(found, THEMES["light"])
    figure.draw_without_rendering()
    one, other = figure.axes[:2]  # the numbers stand at the first alone
    assert (one.get_xlim(), one.get_ylim()) == (other.get_xlim(), other.get_ylim())


def test_figures_of_several_are_those_of_each() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(121)])
    shares: list[float] = []
    found = lab.compare.run_each(
        {"a": path}, LAWS, PLANTS, progress=lambda _, share: shares.append(share)
    )
    for comparison, plant in zip(found, PLANTS, strict=True):
        alone = lab.compare.run(path, LAWS, plant)
        assert comparison.runs.keys() == alone.runs.keys()
        for name, run in comparison.runs.items():
            assert run.metrics == alone.runs[name].metrics
    assert shares == sorted(shares)
    # All is done at the last call, and not before.
    assert shares.index(1.0) == len(shares) - 1


@looped(
    ("options", "said"),
    [
        (("--controllers", "pop,lqr"), "unknown controller 'lqr'"),
        (("--plants", "tank"), "unknown plant 'tank'"),
        (("--controllers", "pop,pid", "--record", "a.mcap"), "--record must be given with one con"),
        (("--tracks", "monza"), "unknown track 'monza'"),
        (("--tracks", "slalom,circle", "--start=0,0,0"), "--start must be given with one track"),
        (("--plants", "kinematic-bicycle,mujoco-car", "--set-plant", "friction=1"), "friction"),
        (("--start-offset", "nan"), "start_offset must be in [-1000, 1000], got nan"),
        (("--controllers", "mpc", "--preset", "paper"), "preset must be left out"),
        (("--vehicle", "paper"), "rear_axle must be that of the plant, -1.94, got 0.0"),
    ],
)
def test_several_of_bad_input_are_refused(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str
) -> None:
    outcome = command.call(capsys, "compare", *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err


def test_comparison_of_nothing_is_refused() -> None:
    path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
    with pytest.raises(ConfigError, match="plants must be at least one"):
        lab.compare.run_each({"a": path}, ["pop"], [])


@pytest.mark.usefixtures("_blank_figures")
def test_several_tracks_are_begun_as_far_to_the_left_as_it_is_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    options = ("--controllers", "pop", "--tracks", "straight,slalom", "--start-offset", "1.5")
    plants = ("--plants", "kinematic-bicycle")
    outcome = command.call(capsys, "compare", *options, *plants, "--out", str(tmp_path))
    assert (outcome.status, outcome.err) == (0, "")
    document = json.loads((tmp_path / "matrix.json").read_text(encoding="utf-8"))
    assert len(document["comparisons"]) == 2
    for comparison in document["comparisons"]:
        track = tracks.get(comparison["path"]["name"])
        (x, y), (ahead_x, ahead_y) = track.xy[:2]
        start = comparison["start"]
        assert start["yaw"] == math.atan2(ahead_y - y, ahead_x - x)
        # The pose is the rear axle's; the front axle is what starts there.
        start["x"] += 3.0 * math.cos(start["yaw"])
        start["y"] += 3.0 * math.sin(start["yaw"])
        along = math.hypot(ahead_x - x, ahead_y - y)
        left = (ahead_x - x) * (start["y"] - y) - (ahead_y - y) * (start["x"] - x)
        assert left / along == pytest.approx(1.5)
        assert math.hypot(start["x"] - x, start["y"] - y) == pytest.approx(1.5)


def test_several_that_begin_otherwise_say_which_does() -> None:
    fast = popsteer.Path([(float(x), 0.0) for x in range(81)], speed=[6.0] * 81)
    slow = popsteer.Path([(float(x), 0.0) for x in range(81)])
    found = lab.compare.run_each({"fast": fast, "slow": slow}, ["pop"], ["kinematic-bicycle"])
    starts = [note for note in notes(*found) if "tarts with" in note]
    assert [note.partition(" with ")[0] for note in starts] == [
        "On fast: starts",
        "On slow: starts",
    ]
    assert len([note for note in notes(found[0], found[0]) if note.startswith("Starts ")]) == 1


def test_several_begin_by_default_where_one_does() -> None:
    path = popsteer.Path([(float(x), 0.5 * x) for x in range(81)])
    (comparison,) = lab.compare.run_each({"a": path}, ["pop"], ["carla-identified"])
    car = sim.vehicle_of("carla-identified")
    assert comparison.first.start == sim.default_start(path, 0.0, car)
    assert comparison.first.start == lab.compare.run(path, ["pop"]).first.start
    assert "front axle on the path, at its first waypoint, at 0 m/s" in comparison.begins
    # The paper's alone is beside it.
    papers = lab.compare.paper.run(path)
    assert papers.first.start == sim.default_start(path, -START_OFFSET, car)


@pytest.mark.usefixtures("_blank_figures")
def test_comparison_of_cars_of_ones_own_tells_one_for_the_other(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    files = {name: str(tmp_path / f"{name}.toml") for name in ("empty", "loaded")}
    empty = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)
    empty.save(files["empty"])
    empty.replace(understeer=0.004).save(files["loaded"])
    outcome = command.call(
        capsys,
        "compare",
        *(
            "--controllers",
            "preview-pop",
            "--tracks",
            "slalom",
            "--plants",
            ",".join(files.values()),
        ),
        *("--vehicle", files["empty"], "--out", str(tmp_path / "out")),
    )
    assert (outcome.status, outcome.err) == (0, "")
    assert "loaded.toml, believed understeer 0\n" in outcome.out
    document = json.loads((tmp_path / "out" / "matrix.json").read_text(encoding="utf-8"))
    plants = {each["plant"]: each for each in document["comparisons"]}
    assert list(plants) == ["empty.toml", "loaded.toml"]
    assert [each["plant_vehicle"]["understeer"] for each in plants.values()] == [0.0, 0.004]
    for each in plants.values():
        assert each["controllers"]["preview-pop"]["vehicle"] == empty.as_dict()


@looped("name", ["compare", "tune"])
def test_waypoints_of_one_name_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    files = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "course.csv").write_text("0,0\n9,0\n", encoding="utf-8")
        files += ["--waypoints", str(tmp_path / folder / "course.csv")]
    outcome = command.call(capsys, name, *files)
    assert (outcome.status, outcome.out) == (2, "")
    assert "--waypoints must be files and tracks of different names, got 'course" in outcome.err


@pytest.mark.parametrize("theme", THEMES)
def test_every_law_that_can_be_compared_has_a_colour_of_its_own(theme: str) -> None:
    colours = THEMES[theme].laws
    assert set(colours) == set(lab.common.names.controller_names())
    assert len(set(colours.values())) == len(colours)


@pytest.mark.usefixtures("_blank_figures")
def test_former_name_of_the_command_drives_the_same_with_a_warning(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    options = ("--controllers", "pop", "--tracks", "straight,slalom", "--out", str(tmp_path))
    now, former = (command.call(capsys, name, *options) for name in ("compare", "matrix"))
    assert (former.status, former.out) == (0, now.out)
    assert former.err == "popsteer: warning: matrix will go; it is compare now\n"


def test_plants_of_files_of_one_name_are_told_by_their_folders(tmp_path: Path) -> None:
    files = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        files.append(str(tmp_path / folder / "car.toml"))
        popsteer.Vehicle().save(files[-1])
    assert list(inputs.movers(f"kinematic-bicycle,{files[0]}")) == ["kinematic-bicycle", "car.toml"]
    assert list(inputs.movers(",".join(files))) == files
