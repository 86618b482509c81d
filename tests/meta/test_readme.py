"""What README shows is what its commands print, and its example runs."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import controllers, lab, sim, tracks
from popsteer.lab.common.names import title_of
from studies.matrix import FIGURES, update
from tests.helpers import ROOT, authors_data

if TYPE_CHECKING:
    from pathlib import Path

README = (ROOT / "README.md").read_text(encoding="utf-8")


def rows(after: str) -> dict[str, list[str]]:
    """The first table after a text: the cells of each row by the first one."""
    table = README.partition(after)[2].partition("| controller |")[2].partition("\n\n")[0]
    lines = re.findall(r"^\| (.+) \|$", table, flags=re.MULTILINE)
    cells = [[cell.strip() for cell in line.split("|")] for line in lines]
    return {first: rest for first, *rest in cells if first in TITLES}


TITLES = {controllers.get(name).title: name for name in controllers.names()}


def test_readme_table_of_the_embedded_track_is_what_compare_measures() -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed)
    comparison = lab.compare.run(path)
    shown = rows("<!-- table of: popsteer compare -->")
    assert set(shown) == {"PID", "Pure-Pursuit", "Stanley", "POP"}
    for title, cells in shown.items():
        metrics = comparison.runs[TITLES[title]].metrics
        assert cells == [
            f"{metrics.mean_abs_cross_track_error:.4f}",
            f"{metrics.mean_abs_heading_error:.4f}",
            f"{metrics.max_abs_cross_track_error:.2f}",
            f"{metrics.settled_mean_abs_cross_track_error:.4f}",
            f"{metrics.rear_axle_mean_abs_cross_track_error:.4f}",
        ]


def test_readme_table_of_the_authors_track_is_what_compare_measures() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    comparison = lab.compare.run(path, start=(-183.8, 78.7, -1.574), start_at="front")
    shown = rows("--start=-183.8,78.7,-1.574")
    assert set(shown) == {"PID", "Pure-Pursuit", "Stanley", "POP"}
    for title, cells in shown.items():
        metrics = comparison.runs[TITLES[title]].metrics
        paper = lab.compare.paper.PAPER[TITLES[title]]
        assert cells == [
            f"{metrics.mean_abs_cross_track_error:.4f}",
            f"{paper.mean_abs_cross_track_error:.4f}",
            f"{metrics.mean_abs_heading_error:.4f}",
            f"{paper.mean_abs_heading_error:.4f}",
        ]


def test_readme_example_runs_in_a_loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    rows = "".join(f"{x}, 0.0, 5.0\n" for x in range(50))
    (tmp_path / "waypoints.csv").write_text(f"x, y, speed\n{rows}")
    monkeypatch.chdir(tmp_path)
    poses = iter(
        [
            *((0.0, 0.5, 0.0, 5.0), (float("nan"), 0.0, 0.0, 5.0), (0.5, 0.4, 0.0, 5.0)),
            *[(0.5, 0.4, 0.0, 5.0)] * 40,
            *((0.75 + 0.25 * k, 0.4, 0.0, 5.0) for k in range(3)),
        ]
    )
    stopped: list[str] = []
    turns = iter([True] * 46 + [False])
    logged: list[Any] = []
    actuated: list[tuple[float, float, bool]] = []
    exec(
        compile(example.group(1), "README.md", "exec"),
        {
            "driving": lambda: next(turns),
            "localise": lambda: next(poses),
            "present_angle": lambda: 0.01,
            "log": logged.append,
            "actuate": lambda *values: actuated.append(values),
            "watch": lambda *values: None,
            "stop": stopped.append,
        },
    )
    assert len(actuated) == 45
    # The pose stood still for 2 s at 5 m/s: a fault, whose first reason stays when it thaws.
    assert len(stopped) > 20
    assert set(stopped) == {"implausible|pose-stale"}
    actuated = actuated[:2]
    assert 0.01 > actuated[0][0] > actuated[1][0]
    # The path allows 5 m/s, and it is driven: neither pushed nor braked by more than noise.
    assert all(abs(acceleration) < 0.3 and not reverse for _, acceleration, reverse in actuated)
    assert [error.field for error in logged] == ["x"]


_LISTS = ("controllers", "plants", "tracks")
BLOCK = README.partition("<!-- matrix: begin")[2].partition("<!-- matrix: end")[0]


def _command(text: str) -> list[str]:
    """The words of the first call of `popsteer matrix` with options."""
    found = re.search(r"popsteer matrix --.*?(?<!\\)\n", text, flags=re.DOTALL)
    assert found is not None
    return shlex.split(found[0].replace("\\\n", " "))


def _options() -> dict[str, str]:
    words = _command(README)[2:]
    return dict(zip(words[::2], words[1::2], strict=True))


def _rows() -> list[list[str]]:
    lines = re.findall(r"^\| (.+) \|$", BLOCK, flags=re.MULTILINE)
    return [[cell.strip() for cell in line.split("|")] for line in lines]


def test_command_of_the_matrix_is_that_of_make() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    folder = re.search(r"^MATRIX := (\S+)$", makefile, flags=re.MULTILINE)
    assert folder is not None
    assert _command(makefile.replace("$(MATRIX)", folder[1])) == _command(README)


def test_table_of_the_matrix_has_the_rows_and_columns_of_its_command() -> None:
    options = _options()
    names, plants, courses = (options[f"--{which}"].split(",") for which in _LISTS)
    head, _, *body, steps = _rows()
    assert head == ["plant", "track", *map(title_of, names)]
    assert [row[:2] for row in body] == [[plant, track] for plant in plants for track in courses]
    assert steps[0] == "step, median [µs]"
    for row in (*body, steps):
        assert len(row) == len(head)
        assert all(float(cell.strip("()")) > 0.0 for cell in row[2:])


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_errors_of_the_matrix_are_those_that_are_driven(plant: str) -> None:
    options = _options()
    names = options["--controllers"].split(",")
    checked = [name for name in names if name in popsteer.controllers.names()]
    assert len(checked) == len(names) - 1  # the MPC's digits are those of a release of osqp
    shown = {row[1]: row[2:] for row in _rows() if row[0] == plant}
    for track, cells in shown.items():
        course = tracks.get(track)
        path = popsteer.Path(course.xy, speed=course.speed, closed=course.closed)
        start = sim.default_start(path, float(options["--start-offset"]), sim.vehicle_of(plant))
        speed = float(options["--constant-speed"])
        found = lab.compare.run(path, checked, plant, start=start, constant_speed=speed)
        for name in checked:
            metrics = found.runs[name].metrics
            assert metrics.finished
            error = f"{metrics.settled_mean_abs_cross_track_error:.4f}"
            assert cells[names.index(name)] == error, (track, name)


def test_update_of_the_matrix_replaces_the_block_and_the_figures(tmp_path: Path) -> None:
    run, checkout = tmp_path / "run", tmp_path / "checkout"
    run.mkdir()
    (checkout / "docs" / "figures").mkdir(parents=True)
    (checkout / "README.md").write_text(README, encoding="utf-8")
    (run / "matrix.md").write_text("| new |\n\nA machine.\n", encoding="utf-8")
    for name in FIGURES:
        (run / name).write_bytes(name.encode())
    update(run, checkout)
    new = (checkout / "README.md").read_text(encoding="utf-8")
    assert "make matrix) -->\n| new |\n\nA machine.\n<!-- matrix: end -->\n" in new
    kept = (text.partition("<!-- matrix: begin")[0] for text in (new, README))
    assert len(set(kept)) == 1
    for name in FIGURES:
        assert f"docs/figures/{name}" in README
        assert (checkout / "docs" / "figures" / name).read_bytes() == name.encode()
        assert (ROOT / "docs" / "figures" / name).is_file()
