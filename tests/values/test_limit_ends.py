"""Plans at the ends of their limits: joins, standstill, slow limits, jerk, unlike pedals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import popsteer
from popsteer import planning, sim
from popsteer.planning import SpeedLimits, speed_profile, speeds_along
from tests.planned import closed_spline, excess, spacing_of

CAR = popsteer.Vehicle(wheelbase=2.7)
STRAIGHT = popsteer.Path([(float(x), 0.0) for x in range(101)])


def _there_and_back() -> popsteer.Path:
    """A lap that goes out forwards and comes back backwards: cusps at both ends, one the join."""
    x = np.concatenate((np.arange(0.0, 40.0), np.arange(40.0, 0.0, -1.0)))
    y = 2.0 * np.sin(x / 20.0)
    return popsteer.Path(np.column_stack((x, y)), closed=True, reverse=np.arange(80) >= 40)


def test_lap_with_a_cusp_at_its_join_stops_there_from_any_first_waypoint() -> None:
    path = _there_and_back()
    for more in ({}, {"max_jerk": 3.0}):
        if more:
            pytest.importorskip("scipy")
        bounds = np.full(80, 20.0)
        bounds[17] = 0.0
        profile = speed_profile(path, SpeedLimits(**more), CAR, speed_limits=bounds)
        assert np.flatnonzero(profile.speed == 0.0).tolist() == [0, 17, 40]
        profile = speed_profile(path, SpeedLimits(**more), CAR)
        assert np.flatnonzero(profile.speed == 0.0).tolist() == [0, 40]
        assert profile.speed.max() > 5.0
        for name, beyond in excess(profile).items():
            assert beyond <= 1e-6, name
        xy = np.column_stack((path.x, path.y))
        assert path.reverse is not None
        rolled = popsteer.Path(
            np.roll(xy, -15, axis=0), closed=True, reverse=np.roll(path.reverse, -15)
        )
        other = speed_profile(rolled, SpeedLimits(**more), CAR)
        assert np.roll(other.speed, 15) == pytest.approx(profile.speed, abs=2e-3)


def test_closed_plan_keeps_its_limits_over_the_join() -> None:
    path = popsteer.Path(closed_spline(4), closed=True)
    pytest.importorskip("scipy")
    for more in ({}, {"max_jerk": 2.0}):
        profile = speed_profile(path, SpeedLimits(max_acceleration=1.0, **more), CAR)
        spacing = spacing_of(path)
        squared = profile.speed**2
        along = 0.5 * (np.append(squared[1:], squared[0]) - squared) / spacing
        assert along == pytest.approx(profile.acceleration, abs=1e-9)
        assert along.max() <= 1.0 + 1e-6
        assert along.min() >= -3.0 - 1e-6
        if more:
            between = 0.5 * (spacing + np.roll(spacing, 1))
            jerk = (along - np.roll(along, 1)) * profile.speed / between
            assert np.abs(jerk).max() <= 2.0 * (1.0 + 1e-6)


def test_plans_brake_by_the_limit_of_braking_and_drive_by_that_of_driving() -> None:
    pytest.importorskip("scipy")
    for drive, brake in ((1.0, 3.0), (3.0, 1.0)):
        limits = {"max_acceleration": drive, "max_deceleration": brake}
        for more in ({}, {"max_jerk": 20.0}):
            profile = speed_profile(STRAIGHT, SpeedLimits(**limits, **more), CAR)
            assert profile.acceleration.max() == pytest.approx(drive, rel=1e-3)
            assert profile.acceleration.min() == pytest.approx(-brake, rel=1e-3)
            shares = profile.shares()
            names = {"driving", "braking", "jerk"} if more else {"driving", "braking"}
            assert names & set(shares)
            if not more:
                # Where both meet: v² = 2 a s = 2 b (l - s).
                meet = brake / (drive + brake)
                assert shares["driving"] == pytest.approx(meet, abs=0.015)
                assert profile.speed.max() == pytest.approx(math.sqrt(200.0 * drive * meet), 0.01)


def test_tables_over_speed_are_read_where_the_speed_is() -> None:
    limits = SpeedLimits(max_acceleration=[(0.0, 3.0), (10.0, 1.0)], max_deceleration=2.0)
    profile = speed_profile(STRAIGHT, limits, CAR)
    driving = profile.acceleration > 0.1
    allowed = np.interp(np.maximum(profile.speed[:-1], profile.speed[1:]), [0, 10], [3, 1])
    assert profile.acceleration[driving][2:-1] == pytest.approx(allowed[driving][2:-1], abs=0.02)


def test_jerk_from_standstill_builds_the_acceleration_up() -> None:
    pytest.importorskip("scipy")
    for spacing in (0.25, 1.0):
        path = popsteer.Path([(spacing * k, 0.0) for k in range(round(60.0 / spacing))])
        most = 0.8
        profile = speed_profile(path, SpeedLimits(max_jerk=most), CAR)
        # Over the first segment at rest: half of it in the time in which the jerk gives it.
        first = (most**2 * spacing) ** (1.0 / 3.0)
        assert profile.acceleration[0] <= first * (1.0 + 1e-6)
        assert profile.acceleration[-1] >= -first * (1.0 + 1e-6)
        assert profile.acceleration[0] > 0.5 * first
        assert profile.time < 2.0 * speed_profile(path, None, CAR).time


def test_plans_within_a_jerk_keep_the_grip_of_the_tyres_and_reach_it() -> None:
    pytest.importorskip("scipy")
    bend = popsteer.Path(closed_spline(2, 120, 40.0), closed=True)
    bounds = np.full(120, 20.0)
    bounds[60] = 1.0
    for exponent, jerk in ((1.0, 20.0), (2.0, 1.0), (math.inf, 0.5)):
        limits = SpeedLimits(longitudinal_grip=1.1, exponent=exponent, max_jerk=jerk)
        profile = speed_profile(bend, limits, CAR, speed_limits=bounds)
        for name, beyond in excess(profile).items():
            assert beyond <= 1e-6, (exponent, name)
        assert np.abs(profile.acceleration).max() > (0.9 if jerk > 1.0 else 0.5)


def test_bend_is_too_sharp_from_the_curvature_of_full_lock_on() -> None:
    car = CAR.replace(max_steer=0.6, turning_wheelbase=2.5, understeer=0.01)
    most = math.tan(0.6) / 2.5
    bends = np.array([0.0, 0.999, -0.999, 1.001, -1.001, 0.5]) * most
    path = popsteer.Path([(float(x), 0.0) for x in range(6)])
    profile = speed_profile(path, None, car, curvature=bends)
    assert profile.too_sharp.tolist() == [3, 4]


def test_limits_below_a_metre_a_second_are_reached_and_kept() -> None:
    pytest.importorskip("scipy")
    for more in ({}, {"max_jerk": 1.0}):
        for most in (0.05, 0.5):
            profile = speed_profile(STRAIGHT, SpeedLimits(max_speed=most, **more), CAR)
            assert profile.speed.max() == pytest.approx(most, rel=1e-4)
            assert profile.speed[5:-5].min() > 0.9 * most
            assert profile.time == pytest.approx(100.0 / most, rel=0.05)


def test_bend_is_driven_at_the_lateral_limit_and_its_curvature_has_its_sign() -> None:
    for side in (1.0, -1.0):
        angle = np.arange(120) * (2.0 * math.pi / 120)
        circle = np.column_stack((20.0 * np.sin(angle), side * (20.0 - 20.0 * np.cos(angle))))
        path = popsteer.Path(circle, closed=True)
        bends = planning.curvature(path)
        assert bends == pytest.approx([side / 20.0] * 120, rel=2e-3)
        profile = speed_profile(path, SpeedLimits(max_lateral_acceleration=2.0), CAR)
        assert profile.speed == pytest.approx([math.sqrt(2.0 * 20.0)] * 120, rel=2e-3)
        assert set(profile.shares()) == {"lateral"}
        assert profile.time == pytest.approx(2.0 * math.pi * 20.0 / math.sqrt(40.0), rel=3e-3)
        named = planning.curvature(path, 1.0)
        assert np.abs(named - bends).max() < 1e-3


def test_ends_of_an_open_plan_have_the_speeds_that_were_asked_for() -> None:
    limits = SpeedLimits(start_speed=4.0, end_speed=2.0, max_speed=6.0)
    profile = speed_profile(STRAIGHT, limits, CAR)
    assert profile.speed[[0, 50, -1]] == pytest.approx([4.0, 6.0, 2.0])
    along = speeds_along(
        [0.0] * 101, 1.0, SpeedLimits(max_speed=6.0), CAR, start_speed=4.0, end_speed=2.0
    )
    assert along == pytest.approx(profile.speed)
    free = speeds_along([0.0] * 101, 1.0, SpeedLimits(max_speed=6.0), CAR)
    assert free.tolist() == [6.0] * 101


def test_speed_limit_of_a_zone_is_kept_at_its_first_and_last_waypoint() -> None:
    bounds = np.full(101, 50.0)
    bounds[40:61] = 3.0
    speed = speed_profile(STRAIGHT, None, CAR, speed_limits=bounds).speed
    assert speed[40:61] == pytest.approx([3.0] * 21)
    # 3 m/s² before it, 2 m/s² after it.
    assert speed[39] == pytest.approx(math.sqrt(9.0 + 6.0))
    assert speed[61] == pytest.approx(math.sqrt(9.0 + 4.0))
    everywhere = speed_profile(STRAIGHT, None, CAR, speed_limits=3.0)
    assert everywhere.speed.max() == 3.0


def test_friction_shares_what_the_bend_leaves() -> None:
    # At half of the lateral limit an ellipse leaves 0.866 along, a rhombus 0.5, a rectangle all.
    for exponent, left in ((2.0, math.sqrt(0.75)), (1.0, 0.5), (math.inf, 1.0)):
        limits = SpeedLimits(
            max_lateral_acceleration=4.0, max_acceleration=2.0, exponent=exponent, max_speed=50.0
        )
        bend = 2.0 / 10.0**2
        speed = speeds_along([bend] * 3, 1e-3, limits, CAR, start_speed=10.0)
        along = 0.5 * np.diff(speed**2) / 1e-3
        assert along[0] == pytest.approx(2.0 * left, rel=2e-3), exponent
    limits = SpeedLimits(max_lateral_acceleration=4.0, max_acceleration=2.0, longitudinal_grip=1.0)
    speed = speeds_along([bend] * 3, 1e-3, limits, CAR, start_speed=10.0)
    assert 0.5 * np.diff(speed**2)[0] / 1e-3 == pytest.approx(math.sqrt(0.75), rel=2e-3)


def test_course_file_has_the_time_and_the_signed_speeds() -> None:
    profile = speed_profile(_there_and_back(), None, CAR)
    lines = profile.as_csv().splitlines()
    assert lines[0] == f"# closed path, 80 waypoints, planned time {profile.time:.2f} s"
    rows = np.array([[float(each) for each in line.split(",")] for line in lines[2:]])
    assert rows[:, 2].min() < -3.0
    means = [0.5 * (a + b) for a, b in pairwise([*profile.speed, profile.speed[0]])]
    assert profile.time == pytest.approx((spacing_of(profile.path) / means).sum())


def test_constant_speed_keeps_its_sign_and_refuses_beyond_its_ends() -> None:
    path = _there_and_back()
    kept, pedals = sim.closed_loop.at_constant_speed(path, 2.5)
    assert path.reverse is not None
    assert kept.speed is not None
    assert np.array_equal(kept.speed, np.where(path.reverse, -2.5, 2.5))
    assert kept.closed
    assert pedals.params == popsteer.SpeedPidParams(kp=1.0, ki=0.5)
    for speed in (0.0, 100.0):
        sim.closed_loop.at_constant_speed(path, speed)
    for speed in (-1e-9, 100.0 + 1e-9, math.nan):
        with pytest.raises(popsteer.ConfigError, match=r"constant_speed must be in \[0, 100\]"):
            sim.closed_loop.at_constant_speed(path, speed)


def test_limits_along_a_path_only_lower_the_speeds_that_are_kept() -> None:
    from popsteer.cli.plan import _bounds

    path = popsteer.Path([(float(x), 0.0) for x in range(11)], speed=[2.0] * 5 + [-6.0] * 6)
    assert _bounds(path, [], keep_speeds=False) is None
    found = _bounds(path, ["3:8:4"], keep_speeds=True)
    assert found is not None
    assert found.tolist() == [2.0] * 5 + [4.0] * 4 + [6.0] * 2
    found = _bounds(path, ["0:3:5", "2:4.5:3"], keep_speeds=False)
    assert found is not None
    assert found.tolist() == [5.0, 5.0, 3.0, 3.0, 3.0, 3.0, *[1e4] * 5]


def test_last_speed_of_a_plan_has_the_sign_of_the_segment_that_leads_there() -> None:
    xy = [(float(x), 0.0) for x in (*range(31), *range(29, -1, -1))]
    for signs in (1.0, -1.0):
        there = np.where(np.arange(61) < 30, signs, -signs)
        path = popsteer.Path(xy, reverse=there < 0.0)
        speed = speed_profile(path, SpeedLimits(end_speed=1.0), CAR).path.speed
        assert speed is not None
        assert speed[-1] == pytest.approx(-signs)
        assert (np.sign(speed[1:30]) == signs).all()
        assert (np.sign(speed[31:]) == -signs).all()
