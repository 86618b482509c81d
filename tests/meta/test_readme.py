"""What README shows is what its commands print, and its loops run."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import lab, sim, tracks
from popsteer.lab.common.names import title_of
from studies.matrix import FIGURES, TRACK, update
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path

README = (ROOT / "README.md").read_text(encoding="utf-8")
LOOP = (ROOT / "docs" / "loop.md").read_text(encoding="utf-8").partition("## The whole loop")[2]
COURSE = "x, y, speed\n" + "".join(f"{x}, 0.0, 5.0\n" for x in range(50))
CHOOSE = (ROOT / "docs" / "choose.md").read_text(encoding="utf-8")


def test_readme_is_one_page() -> None:
    assert len(README.splitlines()) <= 120


def test_readme_loop_drives_and_stops_for_a_fault_that_it_tells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example = re.search(r"```python\n(.*?)```", README, flags=re.DOTALL)
    assert example is not None
    rows = "".join(f"{x}, 0.0, 5.0\n" for x in range(50))
    (tmp_path / "waypoints.csv").write_text(f"x, y, speed\n{rows}")
    monkeypatch.chdir(tmp_path)
    poses = iter([(0.25 * k, 0.5, 0.0, 5.0) for k in range(8)] + [(1.75, 0.5, 0.0, 5.0)] * 40)
    turns = iter([True] * 48 + [False])
    actuated: list[tuple[float, float, bool, bool]] = []
    told: list[str] = []
    exec(
        compile(example.group(1), "README.md", "exec"),
        {
            "driving": lambda: next(turns),
            "localise": lambda: next(poses),
            "actuate": lambda *values: actuated.append(values),
            "tell": told.append,
        },
    )
    assert len(actuated) == 48
    assert all(steer < 0.0 for steer, *_ in actuated[:8])
    assert all(abs(acceleration) < 0.3 for _, acceleration, *_ in actuated[:8])
    # The pose stood still for 2 s at 5 m/s: the fault stays, and the car brakes in comfort.
    assert len(told) > 20
    assert set(told) == {"position"}
    assert actuated[-1][1] == pytest.approx(-3.0)


def test_whole_loop_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = re.search(r"```python\n(.*?)```", LOOP, flags=re.DOTALL)
    assert example is not None
    (tmp_path / "waypoints.csv").write_text(COURSE)
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
        compile(example.group(1), "loop.md", "exec"),
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
BLOCK = CHOOSE.partition("<!-- matrix: begin")[2].partition("<!-- matrix: end")[0]
SHOWN = README.partition("<!-- matrix: begin")[2].partition("<!-- matrix: end")[0]


def _command(text: str) -> list[str]:
    """The words of the first call of `popsteer compare` over more than one line."""
    found = re.search(r"popsteer compare --[^\n]*\\\n.*?(?<!\\)\n", text, flags=re.DOTALL)
    assert found is not None
    return shlex.split(found[0].replace("\\\n", " "))


def _options() -> dict[str, str]:
    words = [word for word in _command(README)[2:] if word != "--step-time"]
    return dict(zip(words[::2], words[1::2], strict=True))


def _tables() -> dict[str, list[list[str]]]:
    """The rows of the table of each track."""
    tables = {}
    for block in BLOCK.partition("\n")[2].split("\n\n")[:-1]:
        lines = block.splitlines()
        head, _, *rows = ([cell.strip() for cell in line[1:-1].split("|")] for line in lines)
        assert head[1:] == ["errors at", *_options()["--plants"].split(","), "step [µs]"]
        tables[head[0]] = rows
    return tables


def test_command_of_the_matrix_is_that_of_make() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    folder = re.search(r"^MATRIX := (\S+)$", makefile, flags=re.MULTILINE)
    assert folder is not None
    assert _command(makefile.replace("$(MATRIX)", folder[1])) == _command(README)


def test_tables_of_the_matrix_have_the_rows_of_its_command() -> None:
    options = _options()
    tables = _tables()
    assert list(tables) == options["--tracks"].split(",")
    for rows in tables.values():
        assert [row[0] for row in rows] == list(map(title_of, options["--controllers"].split(",")))
    (one,) = (each for each in BLOCK.split("\n\n") if f"| {TRACK} |" in each)
    assert one.strip() == SHOWN.partition("\n")[2].strip()


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
def test_errors_of_the_matrix_are_those_that_are_driven(plant: str) -> None:
    options = _options()
    names = options["--controllers"].split(",")
    checked = [name for name in names if name in popsteer.controllers.names()]
    assert len(checked) == len(names) - 1  # the MPC's digits are those of a release of osqp
    at = 2 + options["--plants"].split(",").index(plant)
    for track, rows in _tables().items():
        course = tracks.get(track)
        path = popsteer.Path(course.xy, speed=course.speed, closed=course.closed)
        start = sim.default_start(path, float(options["--start-offset"]), sim.vehicle_of(plant))
        speed = float(options["--constant-speed"])
        found = lab.compare.run(path, checked, plant, start=start, constant_speed=speed)
        for name in checked:
            metrics = found.runs[name].metrics
            assert metrics.finished
            row = rows[names.index(name)]
            assert found.points[name] in row[1].split(", ")
            assert row[at] == (
                f"{metrics.settled_mean_abs_cross_track_error:.4f} / "
                f"{metrics.rear_axle_settled_mean_abs_cross_track_error:.4f}"
            ), (track, name)


def test_stanley_of_the_matrix_is_as_a_loop_of_ones_own_drives_it() -> None:
    """Its defaults on the exact car: millimetres, at the front axle that it tracks."""
    at = 2 + _options()["--plants"].split(",").index("kinematic-bicycle")
    for track, rows in _tables().items():
        (row,) = (each for each in rows if each[0] == "Stanley")
        assert float(row[at].partition(" / ")[0]) < 0.01, track


def test_update_of_the_matrix_replaces_the_block_and_the_figures(tmp_path: Path) -> None:
    run, checkout = tmp_path / "run", tmp_path / "checkout"
    run.mkdir()
    (checkout / "docs" / "figures").mkdir(parents=True)
    (checkout / "README.md").write_text(README, encoding="utf-8")
    (checkout / "docs" / "choose.md").write_text(CHOOSE, encoding="utf-8")
    tables = "| other |\n| 1 |\n\n| slalom |\n| 2 |\n\nA machine.\n"
    (run / "matrix.md").write_text(tables, encoding="utf-8")
    for name in FIGURES:
        (run / name).write_bytes(name.encode())
    update(run, checkout)
    new = (checkout / "README.md").read_text(encoding="utf-8")
    assert "make matrix) -->\n| slalom |\n| 2 |\n<!-- matrix: end -->\n" in new
    all_of_them = (checkout / "docs" / "choose.md").read_text(encoding="utf-8")
    assert f"make matrix) -->\n{tables}<!-- matrix: end -->\n" in all_of_them
    kept = (text.partition("<!-- matrix: begin")[0] for text in (new, README))
    assert len(set(kept)) == 1
    for name in FIGURES:
        assert f"figures/{name}" in CHOOSE
        assert (checkout / "docs" / "figures" / name).read_bytes() == name.encode()
        assert (ROOT / "docs" / "figures" / name).is_file()
