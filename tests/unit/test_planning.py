from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from popsteer import ConfigError, Path, PathError, Vehicle, planning, sim, tracks
from popsteer.planning import SpeedLimits, speed_profile, speeds_along
from popsteer.tracks import edges
from tests.helpers import looped
from tests.planned import closed_spline, excess, random_course, spacing_of

TABLE = ((0.0, 3.0), (8.0, 2.0), (20.0, 0.5))
RISING = ((0.0, 0.5), (5.0, 3.0), (9.0, 1.0))
ACCELERATIONS = st.floats(0.5, 6.0) | st.sampled_from([TABLE, RISING])


@given(
    seed=st.integers(0, 10**6),
    closed=st.booleans(),
    fields=st.fixed_dictionaries(
        {
            "max_speed": st.floats(2.0, 50.0),
            "max_lateral_acceleration": st.floats(0.5, 10.0),
            "max_acceleration": ACCELERATIONS,
            "max_deceleration": ACCELERATIONS,
            "exponent": st.sampled_from([1.0, 1.4, 2.0, 3.0, math.inf]),
            "longitudinal_grip": st.none() | st.floats(1.0, 8.0),
        }
    ),
    car=st.fixed_dictionaries(
        {
            "understeer": st.sampled_from([0.0, 0.002, 0.02]),
            "max_steer_rate": st.none() | st.floats(0.05, 1.0),
            "wheelbase": st.floats(1.0, 5.0),
        }
    ),
)
def test_profile_of_any_path_breaks_no_limit(
    seed: int, closed: bool, fields: dict[str, Any], car: dict[str, Any]
) -> None:
    xy = closed_spline(seed) if closed else random_course(seed)
    vehicle = Vehicle(**car, max_lateral_acceleration=None)
    profile = speed_profile(Path(xy, closed=closed), SpeedLimits(**fields), vehicle)
    for name, beyond in excess(profile).items():
        assert beyond <= 1e-6, (name, beyond)
    assert profile.speed.min() >= 0.0
    assert math.isfinite(profile.time)


@pytest.mark.parametrize("make", [edges.three_point_turn, edges.parallel_parking])
def test_profile_stops_at_cusps_and_breaks_no_limit(make: Any) -> None:
    way = make()
    path = Path(way.xy, speed=way.speed, closed=way.closed)
    profile = speed_profile(path, vehicle=Vehicle(wheelbase=2.7, max_steer_rate=0.5))
    assert path.reverse is not None
    cusps = np.flatnonzero(path.reverse[1:-1] != path.reverse[:-2]) + 1
    assert cusps.size >= 2
    assert (profile.speed[[0, *cusps, -1]] == 0.0).all()
    assert (profile.speed > 0.0).sum() == len(path) - 2 - cusps.size
    assert profile.path.speed is not None
    assert profile.path.reverse is not None
    assert (profile.path.reverse == path.reverse).all()
    assert (profile.path.speed[:-1][path.reverse[:-1]] <= 0.0).all()
    for name, beyond in excess(profile).items():
        assert beyond <= 1e-6, name


def test_profile_of_a_closed_path_is_the_same_from_any_waypoint() -> None:
    xy = closed_spline(3)
    first = speed_profile(Path(xy, closed=True))
    second = speed_profile(Path(np.roll(xy, -150, axis=0), closed=True))
    assert np.abs(np.roll(second.speed, 150) - first.speed).max() < 1e-4


def test_profile_of_a_waypoint_slower_than_needed_is_the_fastest() -> None:
    # Raising the speed at any one waypoint breaks a limit: nothing is given away.
    path = Path(random_course(5))
    profile = speed_profile(path)
    spacing = np.diff(path.s)
    for index in range(1, len(path) - 1):
        raised = profile.speed.copy()
        raised[index] *= 1.001
        other = planning.SpeedProfile.of(
            path, raised, profile.curvature, profile.limit, profile.limits, profile.vehicle
        )
        assert max(excess(other).values()) > 1e-6, (index, profile.limit[index], spacing[index])


def test_speed_profile_of_a_spline_keeps_the_lateral_limit_at_its_own_curvature() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    rng = np.random.default_rng(3)
    knots = np.arange(12.0)
    for _ in range(5):
        line = interpolate.CubicSpline(knots, np.column_stack((8.0 * knots, rng.normal(0, 4, 12))))
        (x, y), (dx, dy), (ax, ay) = (line(np.linspace(0.0, 11.0, 1500), k).T for k in range(3))
        bends = (dx * ay - dy * ax) / np.hypot(dx, dy) ** 3
        path = popsteer.Path(np.column_stack((x, y)))
        limits = planning.SpeedLimits(max_lateral_acceleration=4.0)
        asked = [
            float(
                (
                    planning.speed_profile(path, limits, curvature=given).speed ** 2 * abs(bends)
                ).max()
            )
            for given in (bends, None)
        ]
        assert 0.99 * 4.0 < asked[0] <= 4.0 * (1.0 + 1e-9) < asked[1]
    with pytest.raises(PathError, match=r"curvature must have shape \(1500,\), got \(3,\)"):
        planning.speed_profile(path, curvature=[0.0] * 3)
    with pytest.raises(PathError, match="curvature of waypoint 7 is not finite"):
        planning.speed_profile(path, curvature=[*[0.0] * 7, math.nan, *[0.0] * 1492])


@pytest.mark.parametrize("name", tracks.names())
@pytest.mark.parametrize("spacing", [1, 2])
def test_curvature_of_noisy_waypoints_does_not_ruin_the_speeds(name: str, spacing: int) -> None:
    track = tracks.get(name)
    xy = track.xy[::spacing]
    rng = np.random.default_rng(1)
    clean = speed_profile(Path(xy, closed=track.closed))
    noisy = speed_profile(Path(xy + rng.normal(0.0, 0.02, xy.shape), closed=track.closed))
    assert noisy.time == pytest.approx(clean.time, rel=0.03)
    slower = (noisy.speed - clean.speed) / np.maximum(clean.speed, 1.0)
    assert np.abs(slower).max() < 0.2


def test_wheels_that_are_slow_slow_the_bend() -> None:
    track = tracks.get("obstacle-avoidance")
    quick = speed_profile(Path(track.xy), vehicle=Vehicle(max_steer_rate=2.0))
    slow = speed_profile(Path(track.xy), vehicle=Vehicle(max_steer_rate=0.1))
    assert slow.time > quick.time + 1.0
    assert "steer rate" in slow.shares()


def test_speed_limits_hold_where_they_are() -> None:
    path = Path([(float(x), 0.0) for x in range(301)])
    bounds = np.full(301, 50.0)
    bounds[100:151] = 8.0
    profile = speed_profile(path, speed_limits=bounds)
    assert profile.speed[100:151].max() == 8.0
    assert profile.speed[200] > 12.0
    assert profile.shares()["speed limit"] == pytest.approx(0.17, abs=0.01)


def test_limits_left_out_are_the_vehicles() -> None:
    car = Vehicle(max_speed=9.0, max_acceleration=1.0, max_deceleration=1.5)
    path = Path([(float(x), 0.0) for x in range(301)])
    profile = speed_profile(path, vehicle=car)
    assert profile.speed.max() == 9.0
    assert profile.acceleration.max() == pytest.approx(1.0)
    assert profile.acceleration.min() == pytest.approx(-1.5)


def test_course_is_read_back_from_its_file(tmp_path: Any) -> None:
    way = edges.three_point_turn()
    profile = speed_profile(Path(way.xy, speed=way.speed))
    profile.to_csv(tmp_path / "course.csv")
    read = Path.from_csv(tmp_path / "course.csv")
    assert read.speed is not None
    assert profile.path.speed is not None
    assert read.speed.tolist() == profile.path.speed.tolist()
    assert read.reverse is not None
    assert profile.path.reverse is not None
    assert read.reverse[:-1].tolist() == profile.path.reverse[:-1].tolist()


def test_course_is_driven_by_a_controller_of_speeds() -> None:
    profile = speed_profile(Path(closed_spline(2), closed=True), vehicle=Vehicle(wheelbase=2.7))
    run = sim.run(popsteer.PreviewPop(profile.path), longitudinal=popsteer.SpeedPid(), speed=5.0)
    assert run.metrics.finished


STRAIGHT = Path([(float(x), 0.0) for x in range(21)])


@looped(
    ("limits", "car", "words"),
    [
        ({"max_speed": 20.0}, {"max_speed": 10.0}, "max_speed must be at most the vehicle's, 10.0"),
        ({"max_lateral_acceleration": 4.1}, {}, "_acceleration must be at most the vehicle's, 4.0"),
        ({"max_acceleration": 2.1}, {"max_acceleration": 2.0}, "at most the vehicle's, 2.0, got"),
        (
            {"max_deceleration": [(0.0, 1.0), (9.0, 3.1)]},
            {"max_deceleration": 3.0},
            "vehicle's, 3.0",
        ),
        ({"start_speed": 30.0}, {}, "start_speed must be at most max_speed, 25.0, got 30.0"),
        ({"end_speed": 30.0}, {}, "end_speed must be at most max_speed"),
        ({"start_speed": 20.0}, {}, "start_speed must be at most 10.954.*'braking'"),
        ({"exponent": math.nan}, {}, "exponent must be in"),
        ({"max_acceleration": 0.0}, {}, "max_acceleration must be in"),
        ({"max_acceleration": []}, {}, "max_acceleration must be a number or pairs"),
        ({"max_acceleration": [(5.0, 1.0), (4.0, 1.0)]}, {}, "a table whose speeds increase"),
        ({"max_deceleration": [(5.0, -1.0)]}, {}, "max_deceleration must be in"),
        ({"max_deceleration": "much"}, {}, "max_deceleration must be a number or pairs"),
    ],
)
def test_limits_that_contradict_each_other_are_named(
    limits: dict[str, Any], car: dict[str, Any], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        speed_profile(STRAIGHT, SpeedLimits(**limits), Vehicle(**car))


def test_bad_paths_and_bounds_are_named() -> None:
    with pytest.raises(PathError, match="too short to start and stop"):
        speed_profile(Path([(0.0, 0.0), (10.0, 0.0)]))
    with pytest.raises(PathError, match="speed_limits has 3 entries for 21 waypoints"):
        speed_profile(STRAIGHT, speed_limits=[1.0, 2.0, 3.0])
    with pytest.raises(PathError, match="speed_limits of waypoint 4 must be in"):
        speed_profile(STRAIGHT, speed_limits=[5.0] * 4 + [5e-4] + [5.0] * 16)
    for bends, spacing, words in (
        ([0.0], 1.0, "curvature must have shape"),
        ([0.0, 1.0], [1.0, 2.0], "spacing must have shape"),
        ([0.0, math.nan], 1.0, "curvature of waypoint 1"),
        ([0.0, 1.0], [0.0], "spacing after waypoint 0"),
        ([0.0, 1.0, 1.0, 1.0], [1.0, 1.0, float("inf")], "spacing after waypoint 2"),
    ):
        with pytest.raises(PathError, match=words):
            speeds_along(bends, spacing)
    with pytest.raises(ConfigError, match="smoothing_length must be in"):
        planning.curvature(STRAIGHT, 0.0)


def test_limits_and_plans_survive_a_pickle() -> None:
    limits = SpeedLimits(max_acceleration=TABLE)
    assert pickle.loads(pickle.dumps(limits)) == limits
    profile = speed_profile(STRAIGHT, limits)
    again = pickle.loads(pickle.dumps(profile))
    assert again.time == profile.time
    assert np.array_equal(again.path.speed, again.speed)


def test_too_sharp_a_bend_is_told() -> None:
    xy = [(float(x), 0.0) for x in range(20)] + [(19.0, float(y)) for y in range(1, 20)]
    profile = speed_profile(Path(xy), vehicle=Vehicle(max_steer=0.3))
    assert profile.too_sharp.size > 0
    assert abs(profile.too_sharp.mean() - 19) < 3
    assert not speed_profile(STRAIGHT).too_sharp.size


def _jerk(profile: Any) -> Any:
    """Changes of the acceleration by the times between the middles of the segments."""
    spacing = spacing_of(profile.path)
    squared = profile.speed[: spacing.size + 1] ** 2
    squared = np.append(squared, squared[0]) if squared.size == spacing.size else squared
    ends, middles = np.sqrt(squared), np.sqrt(0.5 * (squared[1:] + squared[:-1]))
    before = spacing[:-1] / (middles[:-1] + ends[1:-1])
    return np.abs(np.diff(profile.acceleration)[: before.size]) / (
        before + spacing[1:] / (middles[1:] + ends[1:-1])
    )


def test_jerk_on_coarse_waypoints_keeps_its_limit_and_the_start() -> None:
    xy = [(8.0 * k, 8.0 * math.sin(0.4 * k)) for k in range(25)]
    for most, start in ((1.0, 0.0), (4.0, 0.0), (4.0, 6.0)):
        profile = speed_profile(Path(xy), SpeedLimits(max_jerk=most, start_speed=start))
        assert _jerk(profile).max() <= 1.01 * most
        assert profile.speed[0] == pytest.approx(start, abs=1e-2)
    straight = Path([(float(x), 0.0) for x in range(20)])
    with pytest.raises(ConfigError, match=r"start_speed must be at most .* which is what max_jerk"):
        speed_profile(straight, SpeedLimits(max_jerk=0.5, start_speed=10.0))


@pytest.mark.parametrize("name", ["straight", "slalom", "figure-eight", "double-lane-change"])
@pytest.mark.parametrize("most", [1.0, 5.0])
def test_jerk_stays_within_its_limit(name: str, most: float) -> None:
    track = tracks.get(name)
    path = Path(track.xy, closed=track.closed)
    free = speed_profile(path)
    profile = speed_profile(path, SpeedLimits(max_jerk=most))
    assert _jerk(profile).max() <= most * (1.0 + 1e-6)
    assert free.time <= profile.time < 1.25 * free.time
    assert max(excess(profile).values()) <= 1e-6
    assert "jerk" in profile.shares()


def test_plan_within_a_jerk_asks_for_what_a_slope_leaves() -> None:
    pytest.importorskip("scipy")
    xy = [(float(x), 0.0) for x in range(301)]
    weak = Vehicle(max_speed=15.0, max_deceleration=2.0, brake_deceleration=2.5)
    for grade, car in (
        (0.1, Vehicle(max_speed=15.0)),
        (-0.15, weak),
        (-0.4, Vehicle(max_speed=15.0)),
        (0.4, Vehicle(max_speed=3.0)),  # no drive left: a tenth of it is planned with
    ):
        path = Path(xy, grade=[grade] * 301)
        most = speed_profile(path, vehicle=car).acceleration
        found = speed_profile(path, SpeedLimits(max_jerk=0.5), car).acceleration
        assert found.max() <= most.max() + 1e-6, grade
        assert found.min() >= most.min() - 1e-6, grade


def test_segment_where_a_slope_begins_has_what_its_steeper_end_leaves() -> None:
    from popsteer.planning import jerk

    car = Vehicle(max_speed=15.0, max_deceleration=2.0, brake_deceleration=2.5)
    limits = SpeedLimits().resolved(car)
    xy = [(float(x), 0.0) for x in range(21)]
    for grade, which in ((-0.15, 1), (0.1, 0)):
        for slope in ([0.0] * 10 + [grade] * 11, [grade] * 11 + [0.0] * 10):
            path = Path(xy, grade=slope)
            bound = jerk._bounds(path, np.full(21, 9.0), np.zeros(21), limits, car)[which]
            push = 9.80665 * abs(grade) / math.hypot(1.0, grade)
            steep = (2.5 if which else 2.0) - push
            begins = 9 if slope[0] == 0.0 else 10
            assert bound[begins] == pytest.approx(steep, rel=1e-4)
            flat = bound[:begins] if slope[0] == 0.0 else bound[begins + 1 :]
            assert flat == pytest.approx([2.0] * len(flat))


def test_limits_of_neither_plan_nor_vehicle_are_the_documented_ones() -> None:
    bare = Vehicle(max_lateral_acceleration=None)
    straight = speeds_along([0.0] * 2001, 1.0, None, bare, start_speed=0.0, end_speed=0.0)
    # 2 m/s² from rest to 25 m/s, and 3 m/s² to rest again.
    assert straight[[0, 50, 1000, 1900, 2000]] == pytest.approx(
        [0.0, math.sqrt(2.0 * 2.0 * 50.0), 25.0, math.sqrt(2.0 * 3.0 * 100.0), 0.0]
    )
    # In bends 0.9 of the vehicle's lateral acceleration, or of 4 m/s².
    bend = [0.04] * 9
    for car, lateral in ((bare, 4.0), (Vehicle(max_lateral_acceleration=5.0), 5.0)):
        speeds = speeds_along(bend, 1.0, None, car, closed=True)
        assert speeds == pytest.approx([math.sqrt(0.9 * lateral / 0.04)] * 9)
