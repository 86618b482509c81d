"""`Path` as a user makes it: from what, and from what not."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import InputError, PathError, presets
from studies.cars_loop import CAR, recorded
from tests.helpers import looped
from tests.trust.car import bends

XY = [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]


@pytest.mark.parametrize(
    "xy",
    [
        XY,
        tuple(XY),
        [list(point) for point in XY],
        [(0, 0), (3, 0), (3, 4)],
        np.array(XY),
        np.array(XY, dtype=np.float32),
        np.array(XY, dtype=np.int16),
        np.array(XY, order="F"),
        np.array(XY, dtype=">f8"),
        np.array(XY[::-1])[::-1],
        np.array([(x, 9.0, y, 9.0) for x, y in XY])[:, ::2],
        np.array(XY * 2)[:3],
    ],
    ids=lambda xy: type(xy).__name__,
)
def test_path_of_any_array_like_holds_the_same_numbers(xy: Any) -> None:
    path = popsteer.Path(xy)
    assert path.x.tolist() == [0.0, 3.0, 3.0]
    assert path.y.tolist() == [0.0, 0.0, 4.0]
    assert path.s.tolist() == [0.0, 3.0, 7.0]
    assert (path.length, path.closed, path.speed, len(path)) == (7.0, False, None, 3)
    assert {path.x.dtype, path.y.dtype, path.s.dtype} == {np.dtype(np.float64)}


def test_path_read_only_array_is_taken() -> None:
    xy = np.array(XY)
    xy.flags.writeable = False
    assert popsteer.Path(xy, speed=xy[:, 0]).length == 7.0


def test_path_closed_measures_the_closing_segment() -> None:
    path = popsteer.Path(XY, closed=True, speed=[1, 2, 3])
    assert (path.length, path.closed, len(path)) == (12.0, True, 3)
    assert path.speed is not None
    assert path.speed.tolist() == [1.0, 2.0, 3.0]
    assert repr(path) == "<Path of 3 waypoints, 12.0 m, closed>"


def test_path_later_changes_of_the_array_do_not_matter() -> None:
    xy, speed = np.array(XY), np.array([1.0, 2.0, 3.0])
    path = popsteer.Path(xy, speed=speed)
    pop = popsteer.Pop(path)
    xy[:] = -5.0
    speed[:] = -5.0
    assert path.x.tolist() == [0.0, 3.0, 3.0]
    assert path.speed is not None
    assert path.speed.tolist() == [1.0, 2.0, 3.0]
    shown = path.x
    shown[:] = 7.0
    assert path.x.tolist() == [0.0, 3.0, 3.0]
    step = (-3.0, 0.5, 0.0, 1.0, 0.05)
    fresh = popsteer.Path(XY, speed=[1.0, 2.0, 3.0])
    assert pop.step(*step) == popsteer.Pop(fresh).step(*step)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("speed", [None, [1.0, 2.0, 3.0]])
@pytest.mark.parametrize(
    "duplicate", [copy.copy, copy.deepcopy, lambda path: pickle.loads(pickle.dumps(path))]
)
def test_path_copied_or_pickled_is_the_same(closed: bool, speed: Any, duplicate: Any) -> None:
    path = popsteer.Path(XY, speed=speed, closed=closed)
    twin = duplicate(path)
    assert isinstance(twin, popsteer.Path)
    for field in ("x", "y", "s"):
        assert getattr(twin, field).tolist() == getattr(path, field).tolist()
    assert (twin.length, twin.closed, len(twin)) == (path.length, closed, 3)
    assert twin.reference_speed(1.0, 0.0) == path.reference_speed(1.0, 0.0)


@pytest.mark.parametrize(
    ("xy", "shape"),
    [
        (1.0, "()"),
        ([], "(0,)"),
        ([1.0, 2.0], "(2,)"),
        ([(1.0, 2.0, 3.0)] * 2, "(2, 3)"),
        ([(1.0,)] * 2, "(2, 1)"),
        ([XY], "(1, 3, 2)"),
        (np.zeros((2, 5)), "(2, 5)"),
    ],
    ids=str,
)
def test_path_of_wrong_shape_is_refused_with_the_shape(xy: Any, shape: str) -> None:
    with pytest.raises(PathError) as caught:
        popsteer.Path(xy)
    assert str(caught.value) == f"xy must have shape (N, 2), got {shape}"
    assert caught.value.index is None


@pytest.mark.parametrize("xy", ["ab", [("a", "b")], [(0, 0), (1,)], object(), [(1j, 0), (1, 1)]])
def test_path_of_no_numbers_is_refused_in_words(xy: Any) -> None:
    with pytest.raises(PathError, match=r"xy must be an array of numbers of shape \(N, 2\)"):
        popsteer.Path(xy)


@pytest.mark.parametrize("speed", [1.0, [[1.0], [2.0], [3.0]], "abc", [1.0, "a", 2.0]])
def test_path_speed_of_wrong_shape_or_kind_is_refused(speed: Any) -> None:
    with pytest.raises(PathError, match="speed must"):
        popsteer.Path(XY, speed=speed)


@pytest.mark.parametrize(
    ("xy", "options", "message", "index"),
    [
        ([(0, 0)], {}, "a path needs at least 2 waypoints, got 1", None),
        (np.zeros((0, 2)), {}, "a path needs at least 2 waypoints, got 0", None),
        (XY[:2], {"closed": True}, "a path needs at least 3 waypoints, got 2", None),
        (XY, {"speed": [1.0]}, "speed has 1 entries for 3 waypoints", None),
        (XY, {"speed": []}, "speed has 0 entries for 3 waypoints", None),
        ([*XY, XY[-1]], {"mend": False}, "waypoints 2 and 3 coincide", 2),
        ([(0, 0), (1e-9, 0)], {}, "waypoints 0 and 1 coincide", 0),
        ([*XY, XY[0]], {"closed": True, "mend": False}, "waypoints 3 and 0 coincide", 3),
        (
            [(0, 0), (1, float("nan"))],
            {},
            "y of waypoint 1 must be in [-1e+09, 1e+09], got nan",
            1,
        ),
        (
            [(float("-inf"), 0), (1, 0)],
            {},
            "x of waypoint 0 must be in [-1e+09, 1e+09], got -inf",
            0,
        ),
        ([(0, 0), (2e9, 0)], {}, "x of waypoint 1 must be in [-1e+09, 1e+09], got 2000000000.0", 1),
        (
            XY,
            {"speed": [0, 1, 2e4]},
            "speed of waypoint 2 must be in [-10000, 10000], got 20000.0",
            2,
        ),
    ],
)
def test_path_of_bad_waypoints_names_the_waypoint(
    xy: Any, options: dict[str, Any], message: str, index: int | None
) -> None:
    with pytest.raises(PathError) as caught:
        popsteer.Path(xy, **options)
    assert (str(caught.value), caught.value.index) == (message, index)


def test_path_of_x_and_y_says_how_to_pass_them() -> None:
    make: Any = popsteer.Path
    with pytest.raises(TypeError, match=r"Path\(numpy\.column_stack\(\(x, y\)\)"):
        make([0, 1, 2], [0, 0, 0])


def test_path_open_may_return_to_its_start() -> None:
    assert popsteer.Path([*XY, XY[0]]).length == 12.0


@pytest.mark.parametrize("options", [{"closed": 1}, {"closed": None}, {"loop": True}])
def test_path_of_wrong_options_is_a_type_error(options: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        popsteer.Path(XY, **options)
    with pytest.raises(TypeError):
        popsteer.Path()  # type: ignore[call-arg]


def test_path_crossing_before_the_start_is_the_lookahead_away() -> None:
    xy = [(float(k), 0.0) for k in range(9)]
    line = popsteer.Path(xy)
    assert line.get_crossing(-20.0, 3.0, 5.0, 0) == ((-16.0, 0.0), True)
    assert line.get_crossing(-3.0, 3.0, 5.0, 0) == ((1.0, 0.0), True)


def test_path_keeps_the_last_of_neighbours_that_coincide() -> None:
    # The third coincides with both before, which do not with each other.
    xy = [(0.0, 0.0), (1.2e-9, 0.0), (0.6e-9, 0.0), (1.0, 0.0)]
    assert list(popsteer.Path(xy).x) == [0.6e-9, 1.0]


def test_path_is_frozen() -> None:
    path = popsteer.Path(XY)
    for field in ("x", "length", "closed"):
        with pytest.raises(AttributeError):
            setattr(path, field, 0.0)


@pytest.mark.parametrize("index", [3, -1, 10**9])
def test_path_question_about_no_waypoint_is_refused_by_name(index: int) -> None:
    path = popsteer.Path(XY)
    for field, ask in (
        ("waypoint", lambda: path.locate(0.0, 0.0, 0.0, index, 5.0)),
        ("segment", lambda: path.get_crossing(0.0, 0.0, 1.0, index)),
        ("nearest", lambda: path.project(0.0, 0.0, index)),
        ("nearest", lambda: path.path_yaw_behind(index)),
        ("nearest", lambda: path.window(index)),
        ("nearest", lambda: path.get_lookahead_point(0.0, 0.0, 1.0, nearest=index)),
    ):
        with pytest.raises(InputError, match="must be below 3") as caught:
            ask()
        assert (caught.value.field, caught.value.value) == (field, index)


def test_path_resample_starts_at_the_waypoint_behind_and_ends_with_the_window() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(50)])
    grid = path.resample(10, ahead=20.0, spacing=0.1)
    assert path.window(10, 20.0) == (9, 21)
    assert grid.shape == (211, 2)
    assert grid[0].tolist() == [9.0, 0.0]
    assert grid[-1].tolist() == [30.0, 0.0]
    assert np.abs(np.diff(grid[:, 0])).max() <= 0.1 + 1e-12


def test_path_lookahead_point_is_the_first_near_the_circle() -> None:
    path = popsteer.Path([(float(k), 0.0) for k in range(50)])
    found = path.get_lookahead_point(10.0, 0.0, 6.0)
    assert found.found
    assert found.point[0] == pytest.approx(15.99)
    assert found.point[1] == 0.0
    assert found.index == path.get_lookahead_point_index(10.0, 0.0, 6.0)
    assert path.resample(10)[found.index].tolist() == list(found.point)
    assert repr(found) == f"Lookahead(index={found.index}, point={found.point}, found=True)"
    lost = path.get_lookahead_point(10.0, 0.0, 60.0)
    assert (lost.point, lost.found) == ((30.0, 0.0), False)
    assert lost != found


def test_path_keeps_speed_and_direction_of_the_last_of_several() -> None:
    xy = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 0.5)]
    speed, reverse = [1.0, 2.0, 3.0, 4.0], [False, False, True, True]
    path = popsteer.Path(xy, speed=speed, reverse=reverse)
    assert len(path) == 3
    assert path.speed is not None
    assert list(path.speed) == [1.0, 3.0, 4.0]
    assert path.reverse is not None
    assert list(path.reverse) == [False, True, True]


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
    # The PID's filter takes some of the noise, too.
    printed = {"derivative_filter": 0.0} if law == "pid" else {}
    by_segment = np.subtract(angles(law, path, steps, smoothing_length=0.0, **printed), smooth)
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
