from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest

from popsteer import ConfigError, Path, PathError, PopsteerError, planning, tracks
from popsteer.planning import SpeedLimits, smooth, speed_profile
from popsteer.tracks import edges
from tests.helpers import looped
from tests.planned import spacing_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

TOLERANCE = 0.1


def _recorded(xy: NDArray[np.float64], closed: bool, seed: int) -> NDArray[np.float64]:
    """A log of a line: every 0.2 m, 5 cm of noise, two gaps, and a while of standing still."""
    rng = np.random.default_rng(seed)
    ends = np.concatenate((xy, xy[:1])) if closed else xy
    steps = np.diff(ends, axis=0)
    arc = np.append(0.0, np.cumsum(np.sqrt((steps * steps).sum(axis=1))))
    stations = np.arange(0.0, arc[-1], 0.2)
    line = np.column_stack([np.interp(stations, arc, column) for column in ends.T])
    line += rng.normal(0.0, 0.05, line.shape)
    count = len(line)
    gaps = np.r_[count // 4 : count // 4 + 20, count // 2 : count // 2 + 12]
    standing = line[count // 3] + rng.normal(0.0, 0.05, (40, 2))
    line = np.insert(line, count // 3, standing, axis=0)
    return np.delete(line, gaps[gaps != count // 3], axis=0)


def _distance(path: Path, line: Path) -> float:
    """The largest distance of a path from the line that was recorded."""
    ends = np.column_stack((line.x, line.y))
    starts = ends if line.closed else ends[:-1]
    along = np.roll(ends, -1, axis=0)[: len(starts)] - starts
    worst = 0.0
    for place in zip(path.x, path.y, strict=True):
        to = np.array(place) - starts
        share = np.clip((to * along).sum(axis=1) / (along * along).sum(axis=1), 0.0, 1.0)
        off = to - share[:, None] * along
        worst = max(worst, float(np.sqrt((off * off).sum(axis=1)).min()))
    return worst


@looped("name", [n for n in tracks.names() if n != "racetrack"])
@looped("seed", [1, 2])
def test_smoothed_recording_stays_within_the_tolerance(name: str, seed: int) -> None:
    track = tracks.get(name)
    line = Path(track.xy, closed=track.closed)
    recorded = _recorded(track.xy, track.closed, seed)
    path = smooth(recorded, TOLERANCE, closed=track.closed)
    assert path.closed == track.closed
    assert _distance(path, line) <= TOLERANCE
    assert abs(path.length - line.length) < 1.0
    # Its curvature is continuous: that of the waypoints themselves, not smoothed again.
    bends = planning.curvature(path, 0.02)
    assert np.abs(np.diff(bends)).max() < 0.02
    assert np.abs(bends).max() < 1.4 * np.abs(planning.curvature(line)).max() + 0.005
    # And it may be driven about as fast as the line, where the recording may not.
    fast = speed_profile(path).time
    assert fast == pytest.approx(speed_profile(line).time, rel=0.04)


def test_smoothed_spacing_is_as_asked_for() -> None:
    recorded = _recorded(tracks.get("slalom").xy, False, 4)
    spacing = spacing_of(smooth(recorded, TOLERANCE, spacing=1.0))
    assert spacing.min() > 0.98
    assert spacing.max() < 1.02


def test_smooth_keeps_cusps_and_directions() -> None:
    way = edges.three_point_turn()
    rng = np.random.default_rng(5)
    xy = way.xy + rng.normal(0.0, 0.01, way.xy.shape)
    path = smooth(Path(xy, speed=way.speed), 0.05)
    assert path.reverse is not None
    turns = np.flatnonzero(path.reverse[1:-1] != path.reverse[:-2])
    assert turns.size == 2
    profile = speed_profile(path)
    assert (profile.speed[turns + 1] == 0.0).all()
    assert _distance(path, Path(way.xy, speed=way.speed)) < 0.06


def test_smooth_of_clean_waypoints_changes_little() -> None:
    track = tracks.get("slalom")
    path = smooth(Path(track.xy), 0.01, spacing=1.0)
    assert _distance(path, Path(track.xy)) < 0.02


@looped(
    ("xy", "words"),
    [
        (np.zeros((5, 3)), "waypoints must be finite and of shape"),
        (np.full((9, 2), np.nan), "waypoints must be finite and of shape"),
        (np.zeros((9, 2)), "1 waypoints are left, fewer than 6"),
        (np.column_stack((np.arange(5.0), np.zeros(5))), "5 waypoints are left"),
        (
            np.column_stack((np.r_[np.arange(50.0), np.arange(48.0, 0.0, -1.0)], np.zeros(98))),
            "run back by .* negative speeds mark",
        ),
    ],
)
def test_bad_recordings_are_told(xy: NDArray[np.float64], words: str) -> None:
    with pytest.raises(PathError, match=words):
        smooth(xy, 0.1)


def test_bad_tolerance_and_missing_extra_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    xy = np.column_stack((np.arange(50.0), np.zeros(50)))
    with pytest.raises(ConfigError, match="tolerance must be in"):
        smooth(xy, 0.0)
    with pytest.raises(ConfigError, match="spacing must be in"):
        smooth(xy, 0.1, spacing=0.0)
    monkeypatch.setitem(sys.modules, "scipy", None)
    with pytest.raises(PopsteerError, match='smoothing needs the extra "lab"'):
        smooth(xy, 0.1)
    with pytest.raises(PopsteerError, match='a limit of the jerk needs the extra "lab"'):
        speed_profile(Path(xy), SpeedLimits(max_jerk=1.0))


def test_smooth_keeps_the_tolerance_at_the_ends_of_lines_that_begin_in_a_bend() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(2)
    for _ in range(8):
        knots = np.arange(0.0, 61.0, 15.0)
        line = interpolate.CubicSpline(
            knots, np.column_stack((knots, rng.normal(0.0, 3.0, len(knots))))
        )
        driven = line(np.linspace(0.0, 60.0, 300))
        path = planning.smooth(driven + rng.normal(0.0, 0.05, driven.shape), 0.1)
        for end, place in ((0, 0.0), (-1, 60.0)):
            (dx, dy), off = line(place, 1), np.array([path.x[end], path.y[end]]) - line(place)
            assert abs(dx * off[1] - dy * off[0]) / math.hypot(dx, dy) < 0.1


def test_smooth_keeps_the_tolerance_along_clothoids_with_noise_of_half_of_it() -> None:
    for seed in (6, 20, 30, 31, 37, 43, 45, 93):  # lines of 6 to 15 m radius at both ends
        rng = np.random.default_rng(seed)
        arc = np.arange(0.0, rng.uniform(40.0, 90.0), 0.2)
        yaw = np.cumsum((arc / arc[-1] - 0.5) * 2.0 / rng.uniform(6.0, 15.0)) * 0.2
        line = np.cumsum(np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0) * 0.2
        path = smooth(line + rng.normal(0.0, 0.05, line.shape), TOLERANCE)
        led_on = np.vstack((4.0 * line[0] - 3.0 * line[1], line, 4.0 * line[-1] - 3.0 * line[-2]))
        assert _distance(path, Path(led_on)) <= TOLERANCE


def test_smooth_keeps_a_wide_tolerance_at_the_ends_of_lines_in_tight_bends() -> None:
    for seed in range(12):  # a bend, 50 m straight on, a bend
        rng = np.random.default_rng(seed)
        first, last = rng.choice((-1.0, 1.0), 2) / rng.uniform(8.0, 15.0, 2)
        arc = np.arange(-3.0, 123.0, 0.05)
        bends = np.interp(arc, (30.0, 38.0, 80.0, 88.0), (first, 0.0, 0.0, last))
        yaw = np.cumsum(bends) * 0.05
        line = np.cumsum(np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0) * 0.05
        driven = line[60:-60:15]
        path = smooth(driven + rng.normal(0.0, 0.1, driven.shape), 0.5)
        assert _distance(path, Path(line)) <= 0.5, seed
