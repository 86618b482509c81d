from __future__ import annotations

import pickle
from typing import TYPE_CHECKING

import numpy as np
import pytest

from popsteer import tracks
from popsteer.errors import ConfigError, PathError
from popsteer.tables import read_waypoints
from popsteer.tracks import Track
from popsteer.tracks.catalogue import _MAKERS
from popsteer.tracks.geometry import FIRST_SPEED
from tests.helpers import looped

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

NAMES = (
    "racetrack",
    "straight",
    "circle",
    "figure-eight",
    "slalom",
    "step-steer",
    "double-lane-change",
    "obstacle-avoidance",
)
# What rounding to a micrometre can add to a curvature estimated from points 1 m apart.
ROUNDING = 5e-6
TOP_SPEED, LATERAL, DRIVING, BRAKING = 25.0, 4.0, 2.0, 3.0


def _steps(track: Track) -> NDArray[np.float64]:
    """Vectors from each waypoint to the next, round to the first if the track is closed."""
    end = track.xy[:1] if track.closed else track.xy[:0]
    return np.diff(np.concatenate((track.xy, end)), axis=0)


def _curvature(track: Track) -> NDArray[np.float64]:
    """Turning angle over distance at every waypoint that has two neighbours, in their order."""
    steps = _steps(track)
    if track.closed:
        steps = np.concatenate((steps[-1:], steps))
    before, after = steps[:-1], steps[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    angle = np.arctan2(cross, (before * after).sum(axis=1))
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    return np.asarray(angle / (0.5 * (lengths[:-1] + lengths[1:])))


def _crossings(track: Track) -> int:
    """Number of pairs of segments, not neighbours, that touch."""
    begin, step = track.xy, _steps(track)
    begin = begin[: len(step)]
    first, second = np.triu_indices(len(step), 2)
    if track.closed:
        apart = ~((first == 0) & (second == len(step) - 1))
        first, second = first[apart], second[apart]
    a, b = step[first], step[second]
    gap = begin[second] - begin[first]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (gap[:, 0] * b[:, 1] - gap[:, 1] * b[:, 0]) / area
        across = (gap[:, 0] * a[:, 1] - gap[:, 1] * a[:, 0]) / area
    inside = (along >= 0) & (along <= 1) & (across >= 0) & (across <= 1)
    return int(np.count_nonzero(inside))


each_track = looped("track", map(tracks.get, NAMES))


def test_names_are_the_shipped_tracks() -> None:
    assert tracks.names() == NAMES


@looped("name", ["monaco", "", "Racetrack", None, 3, []])
def test_get_unknown_name_lists_the_known_ones(name: object) -> None:
    with pytest.raises(ConfigError) as caught:
        tracks.get(name)  # type: ignore[arg-type]
    hint = ", did you mean racetrack? Known" if name == "Racetrack" else "; known"
    assert str(caught.value) == f"unknown track {name!r}{hint}: {', '.join(NAMES)}"


@each_track
def test_track_describes_itself(track: Track) -> None:
    assert tracks.get(track.name) is track
    assert track.title
    assert "\n" not in track.title
    assert track.description.endswith(".")
    assert track.closed == (track.name in {"circle", "figure-eight"})


@each_track
def test_track_arrays_are_finite_doubles_that_cannot_be_written(track: Track) -> None:
    for array, shape in ((track.xy, (len(track.xy), 2)), (track.speed, (len(track.xy),))):
        assert array.shape == shape
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        assert np.isfinite(array).all()
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@each_track
def test_track_waypoints_are_a_metre_apart(track: Track) -> None:
    distances = np.hypot(*_steps(track).T)
    assert distances.min() >= 0.99
    assert distances.max() <= 1.01
    assert track.length == pytest.approx(distances.sum(), abs=1e-9)


@each_track
def test_track_speeds_stay_within_the_limits_of_the_car(track: Track) -> None:
    curvature = _curvature(track)
    speed = track.speed if track.closed else track.speed[1:-1]
    assert track.speed.min() > 0
    assert track.speed.max() <= TOP_SPEED
    assert (np.abs(curvature) * speed * speed).max() <= LATERAL * 1.001

    following = np.append(track.speed, track.speed[0]) if track.closed else track.speed
    along = np.diff(following**2) / (2.0 * np.hypot(*_steps(track).T))
    assert along.max() <= DRIVING * 1.002
    assert along.min() >= -BRAKING * 1.002


@looped("name", [n for n in NAMES if n not in ("circle", "figure-eight")])
def test_track_open_path_sets_off_slowly(name: str) -> None:
    track = tracks.get(name)
    assert track.speed[0] == FIRST_SPEED
    assert (np.diff(track.speed[:20]) > 0).all()


@each_track
def test_track_made_again_is_the_same(track: Track) -> None:
    again = _MAKERS[track.name](track.name)
    assert again.xy.tobytes() == track.xy.tobytes()
    assert again.speed.tobytes() == track.speed.tobytes()


@each_track
def test_track_numbers_are_whole_micrometres_so_that_machines_agree(track: Track) -> None:
    for array in (track.xy, track.speed):
        assert np.array_equal(array, np.round(array, 6))
        assert not np.signbit(array[array == 0.0]).any()


@each_track
def test_track_exported_and_read_again_has_the_same_bits(track: Track, tmp_path: Path) -> None:
    file = tmp_path / "new folder" / "track.csv"
    track.to_csv(file)
    found = read_waypoints(file)
    xy, speed = found.xy, found.speed
    assert xy.tobytes() == track.xy.tobytes()
    assert speed is not None
    assert speed.tobytes() == track.speed.tobytes()
    head = file.read_text(encoding="utf-8").splitlines()[:3]
    assert head[0] == f"# {track.name}: {track.title}"
    assert head[1].startswith("# closed" if track.closed else "# open")
    assert head[2] == "# x [m], y [m], speed [m/s]"


@each_track
def test_track_pickled_is_the_same_and_still_read_only(track: Track) -> None:
    twin = pickle.loads(pickle.dumps(track))
    assert twin.xy.tobytes() == track.xy.tobytes()
    assert (twin.name, twin.closed) == (track.name, track.closed)
    assert not twin.xy.flags.writeable


def test_track_made_by_hand_keeps_a_copy() -> None:
    xy, speed = np.array([[0.0, 0.0], [3.0, 4.0]]), np.array([1.0, 2.0])
    track = Track("own", "a\nb", "", xy, speed, closed=True)
    xy[0, 0] = speed[0] = 9.0
    assert (track.xy[0, 0], track.speed[0]) == (0.0, 1.0)
    assert track.length == 10.0


def test_track_title_with_line_break_stays_in_its_comment(tmp_path: Path) -> None:
    track = Track("own", "a\nb,c", "", np.eye(2), np.ones(2), closed=False)
    track.to_csv(tmp_path / "own.csv")
    assert len(read_waypoints(tmp_path / "own.csv").xy) == 2


@looped(
    ("xy", "speed", "message", "index"),
    [
        ([[0, 0]], [1], "xy must have shape", None),
        ([0, 1], [1, 1], "xy must have shape", None),
        ([[0, 0, 0], [1, 1, 1]], [1, 1], "xy must have shape", None),
        ([[0, 0], [1, 1]], [1], "speed must have shape", None),
        ([[0, 0], [np.nan, 1]], [1, 1], "waypoint 1 is not finite", 1),
        ([[0, 0], [1, 1]], [np.inf, 1], "waypoint 0 is not finite", 0),
    ],
)
def test_track_of_bad_arrays_is_refused(
    xy: list[object], speed: list[float], message: str, index: int | None
) -> None:
    with pytest.raises(PathError, match=message) as caught:
        Track("own", "own", "", np.array(xy), np.array(speed), closed=False)
    assert caught.value.index == index


def test_racetrack_is_an_open_lap_of_1274_waypoints() -> None:
    track = tracks.get("racetrack")
    assert track.xy.shape == (1274, 2)
    assert track.length == pytest.approx(1273.0, abs=1.0)
    assert track.xy[0].tolist() == [0.0, 0.0]
    assert 20.0 < np.hypot(*(track.xy[-1] - track.xy[0])) < 25.0


def test_racetrack_is_nowhere_sharper_than_25_m_and_reaches_it() -> None:
    assert 1.0 / 25.1 < np.abs(_curvature(tracks.get("racetrack"))).max() <= 1.0 / 25.0


def test_racetrack_curvature_is_continuous() -> None:
    # The shortest clothoid is that of the chicane: to 1/27 m within 14 m.
    steepest = 1.0 / (27.0 * 14.0)
    change = np.abs(np.diff(_curvature(tracks.get("racetrack"))))
    assert change.max() <= steepest * 1.001 + ROUNDING


def test_racetrack_keeps_clear_of_itself() -> None:
    track = tracks.get("racetrack")
    assert _crossings(track) == 0
    offsets = track.xy[:, None, :] - track.xy[None, :, :]
    index = np.arange(len(track.xy))
    apart = np.abs(index[:, None] - index[None, :]) > 80  # once round the hairpin
    assert np.hypot(offsets[..., 0], offsets[..., 1])[apart].min() > 20.0


def test_racetrack_has_straights_hairpin_chicane_and_sweepers_to_both_sides() -> None:
    curvature = _curvature(tracks.get("racetrack"))
    sign = np.where(np.abs(curvature) > 1e-4, np.sign(curvature), 0.0)
    joints = np.flatnonzero(np.diff(sign)) + 1
    parts = np.split(curvature, joints)
    kinds = [float(np.sign(part.sum())) if abs(part.sum()) > 0.01 else 0.0 for part in parts]
    turns = [float(np.degrees(part.sum())) for part in parts if abs(part.sum()) > 0.01]
    assert np.round(turns).tolist() == [95, -85, 200, -60, 60, -70, 130, 90]
    straights = [len(part) for part, kind in zip(parts, kinds, strict=True) if kind == 0.0]
    assert sum(length > 70 for length in straights) == 4


def test_racetrack_is_smooth_across_its_whole_length() -> None:
    assert np.degrees(_curvature(tracks.get("racetrack")).sum()) == pytest.approx(360.0, abs=0.1)


def test_circle_has_one_radius_and_one_speed() -> None:
    track = tracks.get("circle")
    assert np.allclose(_curvature(track), 1.0 / 50.0, atol=ROUNDING)
    assert np.ptp(track.speed) == 0.0


def test_straight_lies_on_the_x_axis() -> None:
    track = tracks.get("straight")
    assert not track.xy[:, 1].any()
    assert track.length == 200.0


def test_figure_eight_crosses_itself_and_turns_as_much_left_as_right() -> None:
    track = tracks.get("figure-eight")
    assert _crossings(track) > 0
    assert _curvature(track).sum() == pytest.approx(0.0, abs=1e-4)
    assert 1.0 / np.abs(_curvature(track)).max() == pytest.approx(80.0 / 3.0, rel=1e-3)


def test_slalom_bends_ten_times_in_turn() -> None:
    curvature = _curvature(tracks.get("slalom"))
    bends = np.sign(curvature[np.abs(curvature) > 1e-3])
    assert np.count_nonzero(np.diff(bends)) == 9
    assert 1.0 / np.abs(curvature).max() == pytest.approx(30.4, abs=0.1)
