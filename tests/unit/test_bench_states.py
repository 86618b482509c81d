from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import PathError, tracks, vehicles
from popsteer.lab.bench.states import at_hand, embedded, recorded

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
        ({"trajectory": TRAJECTORY + "0.2, 1, nan, 3\n"}, "trajectory.csv: must hold"),
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
    assert at_hand(folder).states == at_hand().states


def test_at_hand_named_folder_missing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(PathError, match="cannot be read"):
        at_hand(tmp_path / "nowhere")


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
