"""The length of path that Stanley and PID take its heading over, `smoothing_length`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import presets
from studies.cars_loop import CAR, bends, recorded
from tests.helpers import looped

LAWS: dict[str, Any] = {"stanley": popsteer.Stanley, "pid": popsteer.Pid}
Step = tuple[float, float, float, float]
PARAMS: dict[str, Any] = {"stanley": popsteer.StanleyParams, "pid": popsteer.PidParams}
# Cars whose pose is that of the point that Stanley and PID track: the front axle, and where it
# would be if the car, which backs up, were to drive forward.
AHEAD = popsteer.Vehicle(rear_axle=-3.0, max_lateral_acceleration=None)
ASTERN = AHEAD.replace(rear_axle=3.0)
each_law = looped("law", LAWS)


def angles(law: str, path: popsteer.Path, steps: list[Step], **params: Any) -> list[float]:
    """The angles of some steps of the tracked point."""
    car = ASTERN if steps[0][3] < 0.0 else AHEAD
    controller = LAWS[law](path, car, PARAMS[law](**params))
    return [controller.steer(*step, 0.05) for step in steps]


def along(points: np.ndarray[Any, Any], speed: float, count: int = 3) -> list[Step]:
    """Poses on the points, every fifth of them, looking where the vehicle does."""
    chosen = points[40 : 41 + 5 * count : 5]
    ahead = math.copysign(1.0, speed) * np.diff(chosen, axis=0)
    return [
        (float(x), float(y), math.atan2(dy, dx), speed)
        for (x, y), (dx, dy) in zip(chosen, ahead, strict=False)
    ]


def circle(spacing: float = 0.1, radius: float = 20.0) -> np.ndarray[Any, Any]:
    angle = np.arange(0.0, 4.0, spacing / radius)
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


@each_law
@looped("speed", [5.0, -5.0])
def test_heading_length_on_a_smooth_path_steers_as_its_segments_do(law: str, speed: float) -> None:
    points = circle()
    path = popsteer.Path(points, speed=speed * np.ones(len(points)))
    poses = along(points, speed)
    # 5 cm from one waypoint to the next is 0.005 rad at this radius.
    smoothed, segments = angles(law, path, poses), angles(law, path, poses, smoothing_length=0.0)
    assert smoothed == pytest.approx(segments, abs=0.01)
    assert smoothed != segments
    # A circle leads as far to the left behind as ahead: Stanley steers for none of it.
    assert max(map(abs, smoothed)) < 0.03


@each_law
def test_heading_length_ends_where_the_vehicle_turns_round(law: str) -> None:
    # 20 m along x, then backwards along y: a right angle at the cusp.
    x = np.concatenate((np.arange(0.0, 20.0, 0.1), np.full(201, 20.0)))
    y = np.concatenate((np.zeros(200), np.arange(0.0, 20.05, 0.1)))
    speed = np.where(np.arange(len(x)) < 200, 3.0, -3.0)
    path = popsteer.Path(np.column_stack((x, y)), speed=speed)
    before = [(at, 0.1, 0.0, 3.0) for at in (19.0, 19.15, 19.3)]
    assert angles(law, path, before, smoothing_length=20.0) == pytest.approx(
        angles(law, path, before, smoothing_length=0.0), abs=1e-9
    )
    # The vehicle backs up along y, so it looks the other way, and its rear axle leads.
    after = [(20.1, at, -0.5 * math.pi, -3.0) for at in (3.2, 3.35, 3.5)]
    assert angles(law, path, after, smoothing_length=20.0) == pytest.approx(
        angles(law, path, after, smoothing_length=0.0), abs=1e-9
    )


@each_law
@looped("closed", [False, True])
def test_heading_length_longer_than_the_path_is_answered(law: str, closed: bool) -> None:
    path = popsteer.Path([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], closed=closed)
    poses = [(0.5, 0.1, 0.0, 2.0), (0.6, 0.1, 0.0, 2.0)]
    assert np.isfinite(angles(law, path, poses, smoothing_length=1e4)).all()


@each_law
def test_heading_length_of_waypoints_with_noise_steers_calmly(law: str) -> None:
    steps = along(bends(spacing=0.2), 8.0, count=30)
    path = popsteer.Path(recorded())
    smooth = angles(law, popsteer.Path(bends(spacing=0.2)), steps)
    noisy = np.subtract(angles(law, path, steps), smooth)
    by_segment = np.subtract(angles(law, path, steps, smoothing_length=0.0), smooth)
    assert np.abs(noisy).max() < 0.1
    assert np.abs(by_segment).max() > 0.15


@looped("preset", ["paper", "published-code", "reproduction"])
@each_law
def test_preset_of_the_paper_takes_the_heading_as_printed(law: str, preset: str) -> None:
    params: Any = presets.get(law, preset)
    assert params.resolved(CAR).smoothing_length == 0.0
    path, steps = popsteer.Path(recorded()), along(bends(spacing=0.2), 8.0)
    printed = LAWS[law](path, AHEAD, params)
    smoothed = LAWS[law](path, AHEAD, params.replace(smoothing_length=3.0, **_NOT_BEHIND[law]))
    segment = LAWS[law](path, AHEAD, params.replace(smoothing_length=0.0))
    angles = [[each.steer(*step, 0.05) for step in steps] for each in (printed, segment, smoothed)]
    assert angles[0] == angles[1] != angles[2]


_NOT_BEHIND: dict[str, dict[str, Any]] = {"stanley": {"heading_behind": False}, "pid": {}}
