"""Columns without names show what they are; coarse waypoints, that they lie on a curve."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from popsteer import Path, PathError, planning
from popsteer.tables import read_waypoints
from tests.unit.test_table_kinds import WRAPPED, YAW, N, S, X, Y, _rows, _write


def test_speed_without_a_name_is_shown_by_bends_and_nothing_else_is_taken_for_one(
    tmp_path: Any,
) -> None:
    turns = np.linspace(0.0, 4.0 * np.pi, 400)
    radius = 40.0 + 25.0 * np.cos(3.0 * turns / 2.0)
    xy = np.column_stack((radius * np.cos(turns / 2.0), radius * np.sin(turns / 2.0)))
    yaw = np.arctan2(*np.gradient(xy, axis=0).T[::-1])
    fast = np.asarray(planning.speed_profile(Path(xy)).speed)
    waves = (6.0 + 2.6 * np.sin(each * turns + 1.0) for each in (0.5, 1.0, 2.0, 3.0, 5.0, 9.0))
    for columns in ((*xy.T, fast), (*xy.T, yaw, fast)):
        path = Path.from_csv(_write(tmp_path, _rows(columns)))
        assert path.speed is not None
        assert np.asarray(path.speed) == pytest.approx(fast, abs=1e-8)
    # One in km/h is too fast for its bends, a throttle is below 1, a constant may be anything.
    for other in (3.6 * fast, fast / fast.max(), 0.0 * fast + 5.0, *waves):
        with pytest.raises(PathError, match=r"column 3 .* --columns x,y,speed"):
            Path.from_csv(_write(tmp_path, _rows((*xy.T, other))))
        with pytest.raises(PathError, match=r"column 4 .* --columns x,y,yaw,speed"):
            Path.from_csv(_write(tmp_path, _rows((*xy.T, yaw, other))))


def test_speed_without_a_name_is_shown_by_the_distances_of_a_recorder(tmp_path: Any) -> None:
    speed = 3.0 + 2.0 * np.sin(S / 4.0)  # 10 rows a second
    gone = np.concatenate(([0.0], np.cumsum(0.05 * (speed[1:] + speed[:-1]))))
    x, y = 30.0 * np.sin(gone / 30.0), 30.0 * np.cos(gone / 30.0)
    path = Path.from_csv(_write(tmp_path, _rows((x, y, speed))))
    assert path.speed is not None
    assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-8)
    for scale in (3.6, 1.0 / 0.44704, 3600.0 / 1852.0, 100.0, 1000.0, 1.0 / 3.3):  # or a throttle
        with pytest.raises(PathError, match="column 3"):
            Path.from_csv(_write(tmp_path, _rows((x, y, scale * speed))))


def test_rows_that_tell_a_logger_tell_its_columns(tmp_path: Any) -> None:
    speed = 0.5 + 0.2 * np.sin(S)
    columns = (X, Y, WRAPPED, speed)
    path = Path.from_csv(_write(tmp_path, _rows(columns, ", ", "%f")))  # as F1TENTH's writes
    assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-6)
    with pytest.raises(PathError, match="column 4"):
        Path.from_csv(_write(tmp_path, _rows(columns, ", ", "%.9f")))


def test_all_columns_of_a_raceline_along_x_are_found(tmp_path: Any) -> None:
    # Of which s and x would be waypoints, and y their direction.
    s = 0.2 * np.arange(90)
    bend = 0.1 + 0.1 * np.sin(s / 3.0)
    yaw = 0.06 + np.concatenate(([0.0], np.cumsum(0.1 * (bend[1:] + bend[:-1]))))
    steps = 0.2 * np.exp(0.5j * (yaw[1:] + yaw[:-1]))
    there = np.concatenate(([0.0], np.cumsum(steps)))
    speed = 5.0 - 20.0 * bend
    a = np.gradient(0.5 * speed * speed, s)
    path = Path.from_csv(_write(tmp_path, _rows((s, there.real, there.imag, yaw, bend, speed, a))))
    assert np.asarray(path.y) == pytest.approx(there.imag, abs=1e-8)
    assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-8)


def test_no_column_is_a_speed_by_chance(tmp_path: Any) -> None:
    draw = np.random.default_rng(11)
    x, y, along = _lap()
    waves = np.arange(1, 8)[:, None]
    for _ in range(40):
        phases, sizes = draw.uniform(0.0, 6.3, (7, 1)), draw.normal(0.0, 1.0, (7, 1))
        wave = np.sum(sizes * np.cos(waves * along + phases), axis=0)
        width = 2.0 + 3.0 * (wave - wave.min()) / np.ptp(wave)
        with pytest.raises(PathError, match="column 3"):
            Path.from_csv(_write(tmp_path, _rows((x, y, width))))
    # Nor is a time behind the waypoints, of a drive that is slow in the bends.
    speed = np.asarray(planning.speed_profile(Path(np.column_stack((x, y)))).speed)
    steps = np.hypot(np.diff(x), np.diff(y))
    time = np.concatenate(([0.0], np.cumsum(2.0 * steps / (speed[1:] + speed[:-1]))))
    for each in (time, time[-1] - time):
        with pytest.raises(PathError, match="column 3"):
            Path.from_csv(_write(tmp_path, _rows((x, y, each))))


def _lap(count: int = 300) -> tuple[Any, Any, Any]:
    """A lap of bends to either side: x, y, and how far along it each waypoint is [rad]."""
    along = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    radius = 20.0 + 8.0 * np.cos(3.0 * along)
    return radius * np.cos(along), radius * np.sin(along), along


def test_widths_beside_the_middle_of_a_lap_are_left_out(tmp_path: Any) -> None:
    x, y, along = _lap()
    draw = np.random.default_rng(7)
    road = 1.2 + 0.3 * np.sin(2.0 * along)
    sides = [road + draw.normal(0.0, 0.05, len(along)) for _ in "lr"]
    path = Path.from_csv(_write(tmp_path, _rows((x, y, *sides))))
    assert path.speed is None
    assert str(path.source).count("half of the width") == 2
    # A speed and the one that was wanted are alike, too: slower in bends, hardly changing, or of a
    # drive that is no lap; and other columns may be anything.
    profile = np.asarray(planning.speed_profile(Path(np.column_stack((x, y)), closed=True)).speed)
    far = slice(None, 200)
    for columns in (
        (x, y, profile, 1.02 * profile + draw.normal(0.0, 0.02, len(x))),
        tuple(each[far] for each in (x, y, *sides)),
        (x, y, *sides, 1.0 + along),
        (x, y, *(2.0 + 0.02 * side for side in sides)),
        (x, y, sides[0], 1.3 * sides[1]),
    ):
        with pytest.raises(PathError, match="column 3"):
            Path.from_csv(_write(tmp_path, _rows(columns)))


def test_heading_that_lags_behind_a_lap_is_known_and_left_out(tmp_path: Any) -> None:
    x, y, _ = _lap()
    yaw = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x))) - 0.25
    path = Path.from_csv(_write(tmp_path, _rows((x, y, (yaw + np.pi) % (2 * np.pi) - np.pi))))
    assert path.yaw is None
    assert "column 3 is a heading, which is left out" in str(path.source)
    # So it is between waypoints that stand in noise.
    draw = np.random.default_rng(3).normal(0.0, 0.05, (2, 3 * len(x)))
    noisy = (np.repeat(x, 3) + draw[0], np.repeat(y, 3) + draw[1], np.repeat(yaw, 3))
    assert "column 3 is a heading" in str(read_waypoints(_write(tmp_path, _rows(noisy))).source())
    for other in (yaw - 0.25, 0.5 * yaw, np.sin(yaw)):
        with pytest.raises(PathError, match="column 3"):
            Path.from_csv(_write(tmp_path, _rows((x, y, other))))


def test_recorded_heading_is_found_among_noise_at_rest(tmp_path: Any) -> None:
    draw = np.random.default_rng(4)
    rest = 60
    x = np.concatenate((np.full(rest, X[0]), np.repeat(X, 5))) + draw.normal(0, 0.02, rest + 5 * N)
    y = np.concatenate((np.full(rest, Y[0]), np.repeat(Y, 5))) + draw.normal(0, 0.02, rest + 5 * N)
    yaw = np.concatenate((np.full(rest, YAW[0]), np.repeat(WRAPPED, 5)))
    found = read_waypoints(_write(tmp_path, _rows((x, y, yaw))))
    assert found.more["yaw"] == pytest.approx(yaw)


def _hairpin(step: float, radius: float = 8.0) -> Any:
    """Two straights and half a circle between them, `step` [m] apart."""
    bend, straight = math.pi * radius, 8.0 * step
    s = np.arange(0.0, 2.0 * straight + bend, step)
    angle = np.clip(s - straight, 0.0, bend) / radius
    x = radius * np.sin(angle) + np.minimum(s, straight) - np.maximum(s - straight - bend, 0.0)
    return x, radius * (1.0 - np.cos(angle))


def test_coarse_waypoints_of_a_hairpin_are_a_curve(tmp_path: Any) -> None:
    said = "coarse bends, which lie on a curve"
    path = Path.from_csv(_write(tmp_path, _rows(_hairpin(4.0))))
    assert said in str(path.source)
    assert path.curvature is not None
    assert np.asarray(path.curvature)[12:15] == pytest.approx(1.0 / 8.0, rel=0.1)
    assert path.yaw is not None
    # As they are: fine ones, noise, a corner, and what is driven backwards.
    x, y = _hairpin(4.0)
    draw = np.random.default_rng(2).normal(0.0, 0.8, (2, len(x)))
    corner = np.concatenate((np.arange(0.0, 40.0, 4.0), np.full(10, 40.0)))
    for columns in (
        _hairpin(1.0),
        (x + draw[0], y + draw[1]),
        (corner, corner[::-1]),
    ):
        path = Path.from_csv(_write(tmp_path, _rows(columns)))
        assert path.yaw is None
        assert said not in str(path.source)
    back = Path.from_csv(_write(tmp_path, "x,y,v\n" + _rows((x, y, -np.ones(len(x))))))
    assert back.yaw is None
    lap = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    file = _write(tmp_path, _rows((20.0 * np.cos(lap), 20.0 * np.sin(lap))))
    curved = np.asarray(Path.from_csv(file, closed=True).curvature)
    assert curved == pytest.approx(0.05, rel=0.03)


def test_no_column_beside_a_heading_is_a_speed_that_cannot_be_one(tmp_path: Any) -> None:
    x, y, _ = _lap()
    s = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    yaw = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    bend = np.gradient(yaw, s)
    noise = np.random.default_rng(2).normal(0.0, 1e-3, (2, len(x)))
    others = {
        "time": s / 4.0,
        "wheels, in degrees": np.degrees(np.abs(np.arctan(2.7 * bend))),
        "throttle": 0.9 - 0.5 * np.abs(bend) / np.abs(bend).max(),
        "height": 310.0 + np.sin(s / 9.0),
    }
    for other in others.values():
        file = _write(tmp_path, _rows((x + noise[0], y + noise[1], yaw, other)))
        with pytest.raises(PathError, match=r"column 4 .* is: .*--columns x,y,yaw,-"):
            Path.from_csv(file)
    # A second heading is one, and no speed.
    file = _write(tmp_path, _rows((x, y, np.degrees(yaw) % 360.0, yaw % (2.0 * np.pi))))
    path = Path.from_csv(file)
    assert path.speed is None
    assert "column 4 is a heading, too" in str(path.source)


def test_time_beside_a_speed_without_a_name_says_its_unit(tmp_path: Any) -> None:
    x, y, _ = _lap()
    speed = np.asarray(planning.speed_profile(Path(np.column_stack((x, y)))).speed)
    steps = np.hypot(np.diff(x), np.diff(y))
    time = np.concatenate(([0.0], np.cumsum(2.0 * steps / (speed[1:] + speed[:-1]))))
    for unit, scale in (("km/h", 3.6), ("mph", 1.0 / 0.44704)):
        path = Path.from_csv(_write(tmp_path, _rows((time, x, y, scale * speed))))
        assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-6)
        assert f"column 4 is speed in {unit}, as time and distances are" in str(path.source)
        stamp = [f"{1.7e18 + 1e9 * each:.0f}" for each in time]
        path = Path.from_csv(_write(tmp_path, _rows((stamp, x, y, scale * speed))))
        assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-6)


def test_speed_that_is_at_the_top_for_most_of_the_way_is_shown_by_its_limits(tmp_path: Any) -> None:
    # It speeds up and brakes slowly, and is at its top in wide bends between straights.
    parts = [220, 100, 220, 30, 220, 160, 220, 40]
    bend = np.repeat([0.0, 1 / 140, 0.0, 1 / 30, 0.0, -1 / 140, 0.0, -1 / 30], parts)
    corner = np.repeat([22.0, 22.0, 22.0, 10.0] * 2, parts)
    yaw = np.cumsum(bend)
    x, y = np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))
    speed = [
        float(np.min(corner + 0.06 * np.abs(np.arange(len(corner)) - k)))
        for k in range(len(corner))
    ]
    path = Path.from_csv(_write(tmp_path, _rows((x, y, yaw, np.array(speed)))))
    assert np.asarray(path.speed) == pytest.approx(speed, abs=1e-8)


def test_straight_line_beside_its_arc_length_is_x_and_y(tmp_path: Any) -> None:
    x = np.linspace(2.0, 150.0, 80)
    y, yaw, s = 3.0 + 0.1 * x, 0.0 * x + math.atan(0.1), math.hypot(1.0, 0.1) * (x - x[0])
    with pytest.raises(PathError, match=r"column 3 .*--columns x,y,-,-"):  # s and yaw are no x, y
        Path.from_csv(_write(tmp_path, _rows((x, y, yaw, s))))
    path = Path.from_csv(_write(tmp_path, _rows((s / 5.0, x, y, 0.0 * x + 5.0))))
    assert np.asarray(path.x) == pytest.approx(x, abs=1e-8)
    assert np.asarray(path.speed) == pytest.approx(5.0)
    with pytest.raises(PathError, match="column 4"):  # a constant that is but near the speed
        Path.from_csv(_write(tmp_path, _rows((s / 5.0, x, y, 0.0 * x + 5.08))))


def test_constant_beside_a_time_is_no_speed_in_other_units(tmp_path: Any) -> None:
    x, y, _ = _lap()
    steps = np.hypot(np.diff(x), np.diff(y))
    time = np.concatenate(([0.0], np.cumsum(steps / 5.0)))  # at 5 m/s
    rows = _rows((time, x, y, 0.0 * x + 18.0))  # km/h, or a width
    with pytest.raises(PathError, match="column 4"):
        Path.from_csv(_write(tmp_path, rows))


def test_arc_length_in_front_of_a_road_along_y_is_no_coordinate(tmp_path: Any) -> None:
    s = 2.0 * np.arange(200)
    x, y = 9.0 * np.sin(s / 60.0), s - 0.01125 * s
    s = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    for place, columns in ((1, (s, x, y)), (0, (y, x, s))):
        path = Path.from_csv(_write(tmp_path, _rows(columns)))
        assert np.asarray(path.x) == pytest.approx(columns[place], abs=1e-6)


def test_count_behind_a_stamp_is_no_coordinate(tmp_path: Any) -> None:
    turns = np.linspace(0.0, 6.28, 263)
    x, y = 8.0 * np.sin(turns), -8.0 * np.cos(turns)
    stamp = [str(17 * 10**17 + 10**8 * k) for k in range(263)]
    count = np.arange(263.0)
    path = Path.from_csv(_write(tmp_path, _rows((stamp, count, x, y), style="%.3f")))
    assert np.asarray(path.x) == pytest.approx(x, abs=1e-3)
    # What is near the direction of y against a small number is none, and x is no clock for it.
    small = np.random.default_rng(4).normal(0.0, 0.03, 263)
    jumps = 3.0 + 4.0 * (count == 90)
    columns = (5.0 * count, 3.0 * count + 20.0 * np.sin(count / 40.0), jumps, small)
    with pytest.raises(PathError, match=r"would be --columns x,y,"):
        Path.from_csv(_write(tmp_path, _rows(columns)))
    # Nor is a constant one.
    rises = 5.0 * count
    other = 0.1 + 0.2 * np.sin(count / 9.0) ** 2
    with pytest.raises(PathError, match="columns without names"):
        Path.from_csv(
            _write(tmp_path, _rows((rises, 60.0 * np.sin(count / 40.0), other, 0.0 * x + 6.2)))
        )


def test_second_coordinate_that_rises_is_no_clock(tmp_path: Any) -> None:
    # As NCLT has it: time in us, x, y, z, roll, pitch, heading. All but the last few rise or vary.
    x, y = 1.9 * S, 3.0 * np.sin(S / 20.0) + S
    yaw = np.arctan2(0.15 * np.cos(S / 20.0) + 1.0, 1.9)
    tilt, rise = 0.01 * np.sin(3.0 * S), 0.02 * np.cos(S)
    time = [str(10**12 + 10**5 * k) for k in range(N)]
    with pytest.raises(PathError, match=r"do not say what .*--columns -,x,y,"):
        Path.from_csv(_write(tmp_path, _rows((time, x, y, rise, tilt, 0.5 * tilt, yaw))))


def test_waypoints_in_front_of_a_yaw_are_not_passed_over(tmp_path: Any) -> None:
    # x, y, yaw, speed and yaw rate, of which y and yaw would be waypoints as well.
    bend = 0.06 * np.sin(2.0 * np.pi * np.linspace(0.0, 2.0, 120))
    yaw = np.cumsum(bend)
    x, y = np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))
    speed = 8.0 + np.sin(np.arange(120) / 4.0)
    with pytest.raises(PathError, match=r"would be --columns x,y,yaw,"):
        Path.from_csv(_write(tmp_path, _rows((x, y, yaw, speed, speed * bend))))
