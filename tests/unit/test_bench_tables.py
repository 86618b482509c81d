"""The states that the benchmark drives through, and its tables."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from benches.latency.states import at_hand, embedded, recorded
from popsteer import PathError, tracks, vehicles
from studies import bench as tables
from studies.layout import replace_block
from tests.helpers import ROOT

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROW = {"p50": 200, "p99": 300, "p999": 1500, "max": 4_000_000, "net_p50": 150.0}
STAGE = ROW | {"p50": 60_000, "net_p50": None}
EMPTY = ROW | {"p50": 100, "net_p50": 25.0}
LATENCY: dict[str, Any] = {
    "results": {
        "pop_step_ns": ROW,
        "pop_command_ns": ROW,
        "empty_call_ns": EMPTY,
        "numba_step_ns": None,
        "mpc_step_ns": STAGE | {"net_p50": 70_000.0},
        "mpc_solve_ns": STAGE,
    },
    "ratios": {"step_over_empty_call": 2.0, "numba_over_step": None},
    "net_ratios": {"step_over_empty_call": 6.0, "numba_over_step": None},
    "absent": {"numba_step_ns": "not installed"},
    "states": {"source": "a drive", "count": 12},
    "machine": {"cpu": "A CPU", "cores": "2", "python": "CPython 3.11", "platform": "p"},
    "timing": {"calls": {"pop_step_ns": 1_000_003}, "timer_floor_ns": 40.0},
}
COUNTS = {
    "toolchain": {"rustc": "rustc 1", "libc": "glibc 2", "processor": "x86_64"},
    "counts": {"pop steer": 1151.82},
    "parts": {"pop steer": {"path": 1000.6, "tracker": 151.22}},
}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """What `make bench` leaves: criterion's folder with a bench of this run and an older one."""
    (tmp_path / "latency.json").write_text(json.dumps(LATENCY), encoding="utf-8")
    (tmp_path / "instruction_counts.json").write_text(json.dumps(COUNTS), encoding="utf-8")
    (tmp_path / "started").touch()
    os.utime(tmp_path / "started", (1000, 1000))
    benches = (("pop/steer", 2000), ("pop/removed", 999), ("pop/100", 2000), ("pop/21", 2000))
    for name, written in benches:
        folder = tmp_path / "criterion" / name / "new"
        folder.mkdir(parents=True)
        interval = {"lower_bound": 61.0, "upper_bound": 62.04}
        median = {"point_estimate": 61.26, "confidence_interval": interval}
        (folder / "estimates.json").write_text(json.dumps({"median": median}), encoding="utf-8")
        (folder / "benchmark.json").write_text(json.dumps({"full_id": name}), encoding="utf-8")
        os.utime(folder / "estimates.json", (written, written))
    return tmp_path


def test_figures_hold_the_numbers_of_the_run(run: Path) -> None:
    made = tables.figures(run, run / "criterion", "rustc 1")
    assert set(made) == {"figures", "steps"}
    assert all("A CPU, 2 cores; CPython 3.11; rustc 1." in text for text in made.values())
    short = [line for line in made["steps"].splitlines() if line.startswith("| ")]
    assert short[2:] == ["| POP | 200 ns | 300 ns | 1.50 µs | 4.00 ms |"]
    for text in (made["figures"],):
        for line in (
            "| POP, angle | 200 ns | 300 ns | 1.50 µs | 4.00 ms | 150 ns | 2.00 | 6.00 | 1.00 |",
            "| POP in numba | not installed |  |  |  |  |  |  |  |",
            "| MPC on osqp | 60.0 µs | 300 ns | 1.50 µs | 4.00 ms | 70.0 µs | 600 | 2,800 | 300 |",
            "| &nbsp;&nbsp;its solve | 60.0 µs | 300 ns | 1.50 µs | 4.00 ms | - | 600 | - | 300 |",
        ):
            assert line in text.splitlines()
    figures = made["figures"].splitlines()
    assert "| `step_over_empty_call` | 2.00 | 6.00 |" in figures
    assert "| `numba_over_step` | - | - |" in figures
    assert "| call | instructions | path | tracker |" in figures
    assert "| `pop steer` | 1,152 | 1,001 | 151 |" in figures
    assert "POP, angle 1,000,003" in made["figures"]
    assert "Over the length" not in made["figures"]


def test_figures_take_criterions_benches_of_this_run_alone_in_order(run: Path) -> None:
    text = tables.figures(run, run / "criterion", "rustc 1")["figures"]
    names = ["pop/21", "pop/100", "pop/steer"]
    assert [line for line in text.splitlines() if line.startswith("| `pop/")] == [
        f"| `{name}` | 61.3 | 61.0 to 62.0 |" for name in names
    ]


def test_figures_hold_the_bench_over_the_length_where_it_ran(run: Path) -> None:
    rows = [
        {"waypoints": 1000, "step p50 [ns]": 151.24, "path [bytes]": None},
        {"waypoints": 10_000_000, "step p50 [ns]": 160.0, "path [bytes]": 32.0},
    ]
    (run / "path_scale.json").write_text(json.dumps({"rows": rows}), encoding="utf-8")
    lines = tables.figures(run, run / "criterion", "rustc 1")["figures"].splitlines()
    assert "| waypoints | 1,000 | 10,000,000 |" in lines
    assert "| step p50 [ns] | 151.2 | 160 |" in lines
    assert "| path [bytes] | - | 32 |" in lines


def test_figures_without_a_bench_in_rust_are_refused(run: Path) -> None:
    os.utime(run / "started", (3000, 3000))
    with pytest.raises(SystemExit, match="no bench of this run"):
        tables.figures(run, run / "criterion", "rustc 1")


@pytest.mark.parametrize("missing", ["latency.json", "instruction_counts.json"])
def test_figures_of_half_a_run_are_refused(run: Path, missing: str) -> None:
    (run / missing).unlink()
    with pytest.raises(SystemExit, match=f"{missing}: .*run the whole of"):
        tables.figures(run, run / "criterion", "rustc 1")


def test_figures_without_counts_say_why(run: Path) -> None:
    counted = {"counts": None, "reason": "valgrind is not on the path"}
    (run / "instruction_counts.json").write_text(json.dumps(counted), encoding="utf-8")
    text = tables.figures(run, run / "criterion", "rustc 1")["figures"]
    assert "Not counted in this run: valgrind is not on the path." in text


def test_replace_block_keeps_its_marks_and_what_is_around() -> None:
    text = "a\n<!-- figures: begin (generated) -->\nold\n| \\1 |\n<!-- figures: end -->\nz\n"
    new = replace_block(text, "figures", "| \\2 |\n\nnew")
    assert new == (
        "a\n<!-- figures: begin (generated) -->\n| \\2 |\n\nnew\n<!-- figures: end -->\nz\n"
    )
    assert replace_block(new, "figures", "| \\2 |\n\nnew") == new
    assert replace_block(text, "other", "new") == text


def test_replace_block_twice_is_refused() -> None:
    block = "<!-- figures: begin -->\n<!-- figures: end -->\n"
    with pytest.raises(SystemExit, match="more than one"):
        replace_block(2 * block, "figures", "new")


def test_readme_of_the_benches_has_the_block() -> None:
    readme = (ROOT / "benches" / "README.md").read_text(encoding="utf-8")
    assert replace_block(readme, "figures", "") != replace_block(readme, "figures", "new")


RECORDING = Path(__file__).parents[3] / "shared" / "data" / "carla_racetrack"
FRONT = 1.06

HEADING_ERROR = (0.0, 0.1, -0.2)
WAYPOINTS = "0, 0, 1\n0, 10, 1\n0, 20, 1\n"  # due north
TRAJECTORY = "0, 9, 9, 0\n0.05, 0.5, 3, 1\n0.10, 0.4, 11, 2\n0.15, 0.3, 14, 3\n"
ERRORS = "".join(f"0.5, {error}\n" for error in HEADING_ERROR)


def _write(folder: Path, **changed: str) -> Path:
    files = {"waypoints": WAYPOINTS, "trajectory": TRAJECTORY, "tracking_error": ERRORS} | changed
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder


def test_recorded_gives_yaw_and_pose_behind_the_front(tmp_path: Path) -> None:
    drive = recorded(_write(tmp_path))
    assert len(drive.path) == 3
    assert drive.vehicle == vehicles.get("carla-identified")
    assert drive.vehicle.front_axle == FRONT
    expected = [(0.5, 3.0, 1.0), (0.4, 11.0, 2.0), (0.3, 14.0, 3.0)]
    assert len(drive.states) == len(expected)
    for state, (x, y, speed), error in zip(drive.states, expected, HEADING_ERROR, strict=True):
        yaw = math.pi / 2.0 - error
        assert state[2] == pytest.approx(yaw, abs=1e-15)
        assert state[0] + FRONT * math.cos(yaw) == pytest.approx(x, abs=1e-12)
        assert state[1] + FRONT * math.sin(yaw) == pytest.approx(y, abs=1e-12)
        assert state[3] == speed
        assert all(type(value) is float for value in state)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"trajectory": ""}, "trajectory.csv"),
        ({"trajectory": "0, 1, 2\n0.05, 1, 2\n"}, "trajectory.csv: must hold"),
        ({"trajectory": TRAJECTORY + "0.2, 1, nan, 3\n"}, "'nan' is not finite"),
        ({"trajectory": TRAJECTORY + "0.2, 1, north, 3\n"}, "trajectory.csv"),
        ({"tracking_error": ERRORS + "0, 0\n"}, "tracking_error.csv: has 4 rows for 3 states"),
        ({"waypoints": "0, 0\n"}, "waypoints.csv"),
    ],
)
def test_recorded_broken_file_is_named(tmp_path: Path, changed: dict[str, str], said: str) -> None:
    with pytest.raises(PathError, match=said):
        recorded(_write(tmp_path, **changed))


def test_recorded_missing_file_is_named(tmp_path: Path) -> None:
    (_write(tmp_path) / "trajectory.csv").unlink()
    with pytest.raises(PathError, match=r"trajectory\.csv: cannot be read"):
        recorded(tmp_path)


def test_embedded_drives_the_whole_race_track() -> None:
    drive = embedded()
    assert np.array_equal(drive.path.x, tracks.get("racetrack").xy[:, 0])
    first, last = np.array(drive.states[0]), np.array(drive.states[-1])
    assert first[3] == 0.0
    start = drive.path.project(first[0], first[1])
    assert start.cross_track_error == pytest.approx(2.44, abs=1e-9)
    assert drive.path.project(last[0], last[1]).arc_length > drive.path.length - 5.0


def test_at_hand_without_recording_takes_the_embedded_track(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "embedded" in at_hand().source


def test_at_hand_with_recording_takes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "shared" / "data" / "carla_racetrack"
    folder.mkdir(parents=True)
    _write(folder)
    (tmp_path / "checkout").mkdir()
    monkeypatch.chdir(tmp_path / "checkout")
    assert "recorded" in at_hand().source
    assert at_hand().states == recorded(folder).states


def test_recorded_folder_missing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(PathError, match="cannot be read"):
        recorded(tmp_path / "nowhere")


@pytest.mark.skipif(not RECORDING.is_dir(), reason="the authors' recorded run is not at hand")
def test_recorded_yaw_of_the_authors_run_points_where_it_goes() -> None:
    drive = recorded(RECORDING)
    assert len(drive.states) == 2146
    table: NDArray[np.float64] = np.array(drive.states)
    # The point that the pose is of does not slip: it moves along the yaw.
    moved = table[2:, :2] - table[:-2, :2]
    yaw, speed = table[1:-1, 2], table[1:-1, 3]
    aside = moved[:, 1] * np.cos(yaw) - moved[:, 0] * np.sin(yaw)
    along = moved[:, 0] * np.cos(yaw) + moved[:, 1] * np.sin(yaw)
    off = np.abs(np.arctan2(aside, along))[speed > 5.0]
    assert np.median(off) < 0.002
    pop = popsteer.Pop(drive.path, drive.vehicle)
    errors = [abs(pop.step(*state, 0.05).cross_track_error) for state in drive.states]
    assert np.mean(errors) == pytest.approx(0.167, abs=0.002)
