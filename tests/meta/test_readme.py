"""What README shows is what the commands print, and its example runs."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import popsteer
from popsteer import controllers, lab, tracks
from tests.helpers import ROOT, authors_data

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

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
    (tmp_path / "waypoints.csv").write_text("".join(f"{x}, 0.0, 5.0\n" for x in range(50)))
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
