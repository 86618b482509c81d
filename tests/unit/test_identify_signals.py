"""Signals that disagree are refused by their name, and right with the option that converts them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import logs
from popsteer.identification.checks import refuse_steer
from popsteer.identification.drive import _on_clock, prepare
from popsteer.identification.signals import (
    BLOCK,
    EARLY,
    LONGEST,
    checked,
    excited,
    looks,
    unrepeated,
)
from popsteer.logs import Log, LogError
from studies import logged

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")

CAR = logged.Car(rate=math.inf)
SMALL = logged.Car(length=0.33, understeer=0.004, point=0.1, lag=0.05, delay=0.1)


def _degrees(yaw: Any) -> Any:
    return (np.degrees(yaw) + 180.0) % 360.0 - 180.0


WRONG: dict[str, tuple[str, Any, str]] = {
    # What is done to a column, and the option that the refusal names.
    "yaw in degrees": ("yaw", _degrees, "yaw=deg"),
    "heading from north": ("yaw", lambda yaw: 0.5 * math.pi - yaw, "yaw=rad-north"),
    "compass": ("yaw", lambda yaw: (90.0 - np.degrees(yaw)) % 360.0, "yaw=deg-north"),
    "clockwise": ("yaw", np.negative, "yaw=-1"),
    "mirrored": ("y", np.negative, "y=-1"),
    "km/h": ("speed", lambda v: 3.6 * v, "speed=km/h"),
    "mph": ("speed", lambda v: v / 0.44704, "speed=mph"),
    "knots": ("speed", lambda v: v * 3600.0 / 1852.0, "speed=kn"),
    "cm": ("speed", lambda v: 100.0 * v, "speed=cm/s"),
    "normalised": ("steer", lambda angle: angle / 0.58, "steer=MAX_STEER"),
}


@pytest.fixture(scope="module", params=["car", "model car"])
def columns(request: pytest.FixtureRequest) -> dict[str, Any]:
    return logged.log("brisk", CAR if request.param == "car" else SMALL, seed=4)


@pytest.fixture(scope="module")
def plain(columns: dict[str, Any]) -> Any:
    return popsteer.identify(Log(**columns))


@pytest.mark.parametrize("kind", list(WRONG))
def test_signal_that_disagrees_is_refused_by_name_and_right_with_the_option(
    columns: dict[str, Any], plain: Any, kind: str, tmp_path: Path
) -> None:
    column, wrong, option = WRONG[kind]
    changed = columns | {column: wrong(columns[column])}
    file = tmp_path / "drive.csv"
    rows = np.column_stack(list(changed.values()))
    np.savetxt(file, rows, delimiter=",", header=",".join(changed), comments="")
    with pytest.raises(LogError, match=f"--unit {option}") as refused:
        popsteer.identify(Log(**changed))
    assert str(refused.value).count("\n") == 0
    with pytest.raises(LogError, match=f"--unit {option}"):
        popsteer.identify(logs.read(file))
    name, _, unit = option.partition("=")
    unit = {"MAX_STEER": "0.58"}.get(unit, unit)
    read = logs.read(file, units={name: unit})
    for column, wanted in columns.items():
        off = getattr(read, column) - wanted
        off = np.remainder(off + math.pi, math.tau) - math.pi if column == "yaw" else off
        assert np.max(np.abs(off)) < 1e-9, column
    checked(read)
    if kind == "compass":  # its headings jump by a whole turn as well
        found = popsteer.identify(read)
        for field in ("wheelbase", "steer_offset", "steer_lag", "dead_time"):
            value = getattr(plain.vehicle, field)
            assert getattr(found.vehicle, field) == pytest.approx(value, rel=1e-3, abs=1e-4), field


def test_positions_in_centimetres_are_named_and_not_the_steering(
    columns: dict[str, Any], tmp_path: Path
) -> None:
    changed = columns | {name: 100.0 * columns[name] for name in ("x", "y")}
    file = tmp_path / "drive.csv"
    rows = np.column_stack(list(changed.values()))
    np.savetxt(file, rows, delimiter=",", header=",".join(changed), comments="")
    for read in (lambda: logs.read(file), lambda: popsteer.identify(Log(**changed))):
        with pytest.raises(LogError, match="--unit x=cm --unit y=cm"):
            read()


def test_speed_signal_off_by_a_fifth_is_scaled_and_said(
    columns: dict[str, Any], plain: Any
) -> None:
    found = popsteer.identify(Log(**columns | {"speed": columns["speed"] / 0.8}))
    assert found.vehicle.wheelbase == pytest.approx(plain.vehicle.wheelbase, rel=1e-3)
    (note,) = (note for note in found.notes if "--unit speed=" in note)
    assert float(note.partition("--unit speed=")[2].rstrip(")")) == pytest.approx(0.8, rel=2e-3)


@pytest.mark.parametrize("degrees", [-45.0, 2.0])
def test_heading_sensor_askew_is_advised_to_half_a_degree(degrees: float) -> None:
    columns = logged.log("blocks", CAR, seed=5)
    found = popsteer.identify(Log(**columns | {"yaw": columns["yaw"] + math.radians(degrees)}))
    (note,) = (note for note in found.notes if "turn the sensor's heading by that" in note)
    words = note.split()
    said = float(words[4]) * (1.0 if words[8] == "left" else -1.0)
    assert abs(math.remainder(said - degrees, 360.0)) < 0.5
    assert found.vehicle.rear_axle == pytest.approx(-CAR.point, abs=0.05)


def test_heading_sensor_askew_is_turned_back_whatever_its_angle() -> None:
    columns = logged.log("blocks", CAR, seed=5)
    plain = checked(Log(**columns))
    for degrees in (20.0, 90.0, 135.0, 180.0, -100.0):
        askew = math.radians(degrees)
        seen = checked(Log(**columns | {"yaw": columns["yaw"] + askew}))
        assert abs(math.remainder(seen.heading_bias + askew - plain.heading_bias, math.tau)) < 1e-6
        off = np.remainder(seen.log.yaw - plain.log.yaw + math.pi, math.tau) - math.pi
        assert np.max(np.abs(off)) < 1e-6


def test_speed_without_its_sign_is_refused_where_the_car_drives_backwards() -> None:
    columns = logged.log("parking", CAR, seed=1)
    with pytest.raises(LogError, match="speed must be negative backwards"):
        checked(Log(**columns | {"speed": np.abs(columns["speed"])}))
    assert abs(checked(Log(**columns)).heading_bias) < math.radians(0.5)


def test_course_over_ground_is_refused_and_taken_with_the_option() -> None:
    columns = logged.log("brisk", CAR, seed=2)
    place = columns["x"] + 1j * columns["y"]
    for course in (np.angle(np.gradient(place)), np.angle(np.diff(place, append=2 * place[-1]))):
        with pytest.raises(LogError, match=r"course over ground.*--course"):
            checked(Log(**columns | {"yaw": course}))
    # Without noise of the positions, the course leads the heading of the car; the option mends it.
    still = logged.log("brisk", CAR, seed=2, noise=0.0)
    course = np.unwrap(np.angle(np.gradient(still["x"] + 1j * still["y"])))
    log = Log(**still | {"yaw": course})
    headings = looks(log, CAR.point).yaw
    assert np.max(np.abs(course - still["yaw"])[40:]) > 0.05
    assert np.max(np.abs(headings - still["yaw"])[40:-1]) < 0.01
    told = popsteer.Vehicle(wheelbase=CAR.length, rear_axle=-CAR.point)
    found = popsteer.identify(log, told, course=True)
    assert found.vehicle.turning_wheelbase == pytest.approx(CAR.length, rel=0.01)
    assert found.delay == pytest.approx(CAR.lag + CAR.delay, abs=0.02)


@pytest.mark.parametrize("ahead", [1.2, -0.8])
def test_course_of_a_point_before_or_behind_the_axle_becomes_the_heading(ahead: float) -> None:
    t = 0.05 * np.arange(1200)
    speed, bend = 8.0 + 2.0 * np.sin(0.1 * t), np.tan(0.15 * np.sin(0.4 * t)) / 2.7
    yaw = np.cumsum(0.05 * speed * bend)
    course = yaw + np.arctan(ahead * bend)
    x, y = np.cumsum(0.05 * speed * (np.cos(course), np.sin(course)), axis=1)
    found = looks(Log(t, x, y, course, speed, np.arctan(2.7 * bend)), ahead).yaw
    assert np.max(np.abs(course - yaw)) > 0.04
    assert np.max(np.abs(found - yaw)[60:-60]) < 0.002


def test_long_log_keeps_the_commands_in_flight_where_a_part_of_it_begins() -> None:
    t = np.arange(0.0, 2.0 * LONGEST, 0.1)
    begins = 3 * BLOCK
    lively = (t >= begins) & (t < begins + LONGEST)
    steer = np.where(lively, 0.1 * np.sin(t), 0.0)
    yaw = np.cumsum(0.2 * steer)
    log = Log(
        t, np.cumsum(0.5 * np.cos(yaw)), np.cumsum(0.5 * np.sin(yaw)), yaw, 0.0 * t + 5.0, steer
    )
    part = excited(log)
    assert begins <= part.t[0] < begins + 0.5
    assert part.commands is not None
    assert part.commands[0][[0, -1]] == pytest.approx([begins - EARLY, begins + LONGEST - 0.1])


def test_long_log_keeps_the_steps_of_its_commands() -> None:
    t = np.arange(0.0, 1.5 * LONGEST, 0.01)  # its rows become means over 40 ms
    steer = 0.02 * np.round(10.0 * np.sin(0.3 * t))
    yaw, speed = 0.1 * np.sin(0.2 * t), np.full(len(t), 5.0)
    part = excited(Log(t, 5.0 * t, 0.0 * t, yaw, speed, steer))
    ready = prepare(part)
    assert ready.steer_step == pytest.approx(0.02)
    assert ready.least_noise["steer"] == pytest.approx(0.02 / np.sqrt(12.0))
    assert ready.commands is not ready.recorded


def test_normalised_steer_that_reaches_one_is_refused() -> None:
    columns = logged.log("brisk", CAR, seed=2)
    steer = np.clip(columns["steer"] / 0.2, -1.0, 1.0)
    with pytest.raises(LogError, match=r"it is normalised \(--unit steer=MAX_STEER"):
        checked(Log(**columns | {"steer": steer}))


@pytest.mark.parametrize("rate", [2.0, 3.0, 4.0, 7.0, 10.0])
def test_poses_that_repeat_are_samples_with_their_age(rate: float) -> None:
    columns = logged.log("brisk", CAR, seed=3, pose_rate=rate)
    log, error = unrepeated(Log(**columns))
    assert error < 0.01
    assert len(log) == pytest.approx(rate * columns["t"][-1], abs=2.0)
    # They were measured at whole multiples of their interval.
    off = log.t * rate - np.round(log.t * rate)
    assert np.max(np.abs(off)) / rate < 0.003
    found = popsteer.identify(Log(**columns))
    assert any("poses repeat in" in note for note in found.notes)
    assert not any("replaced" in note for note in found.notes)
    assert found.delay == pytest.approx(CAR.lag + CAR.delay, abs=0.01)
    # A pose that is new in each row is left as it is, and so is one that never moves.
    plain = Log(**logged.log("brisk", CAR, seed=3))
    assert unrepeated(plain) == (plain, 0.0)


@pytest.mark.parametrize(("rate", "first"), [(10.0, 3), (4.0, 4), (7.3, 2)])
def test_poses_that_no_row_is_of_have_their_age(rate: float, first: int) -> None:
    fine = logged.log("brisk", CAR, seed=3, dt=0.01, pose_rate=rate)
    columns = {name: values[first::5] for name, values in fine.items()}
    commands = fine["t"], fine["steer"]
    log, error = unrepeated(Log(**columns, commands=commands))
    off = log.t[1:] * rate  # nobody knows how old the first one is
    assert np.max(np.abs(off - np.round(off))) / rate < max(0.004, 3.0 * error)
    found = popsteer.identify(Log(**columns, commands=commands))
    assert found.delay == pytest.approx(CAR.lag + CAR.delay, abs=0.01)
    # Where the speed comes with the pose nothing shows the age: the error of the delay has it.
    new = np.append(True, np.diff(columns["x"]) != 0.0)
    held = columns["speed"][np.maximum.accumulate(np.where(new, np.arange(len(new)), 0))]
    log = Log(**columns | {"speed": held}, commands=commands)
    _, error = unrepeated(log)
    assert error == pytest.approx(0.05 / math.sqrt(3.0))
    other = popsteer.identify(log)
    for name in ("delay", "dead_time"):
        assert other.model_errors[name] >= error
    assert other.delay == pytest.approx(CAR.lag + CAR.delay, abs=2.0 * error)


def test_commands_with_times_of_their_own_stay_with_poses_that_are_thinned() -> None:
    t = 0.02 * np.arange(400)
    held = np.floor(t / 0.1 + 1e-9) * 0.1
    own = 0.01 * np.arange(900), 0.1 * np.sin(0.03 * np.arange(900))
    columns = (
        t,
        5.0 * held,
        0.0 * t,
        0.05 * np.sin(held),
        np.full(400, 5.0),
        0.1 * np.sin(3.0 * t),
    )
    for given, kept in ((own, own), (None, (t, columns[-1]))):
        thin, _ = unrepeated(Log(*columns, name="drive", commands=given))
        assert len(thin) == 80
        assert thin.commands is not None
        for found, wanted in zip(thin.commands, kept, strict=True):
            np.testing.assert_array_equal(found, wanted)


def test_commands_that_are_no_angles_of_the_wheels_are_refused() -> None:
    def found(length: float, scale: float = 1.0, gain: float = 0.0, count: int = 1) -> Any:
        return SimpleNamespace(
            values={"turning_wheelbase": length},
            root=np.ones(count),
            profile=lambda _, scales, **__: [gain if s == scale else -1.0 for s in scales],
        )

    for given, length, refused in (
        (2.0, 3.19, False),
        (2.0, 3.21, True),
        (2.0, 1.26, False),
        (2.0, 1.24, True),
        (None, 14.9, False),
        (None, 15.1, True),
    ):
        car = None if given is None else popsteer.Vehicle(wheelbase=given)
        if refused:
            with pytest.raises(LogError, match=r"is steer normalised .*--unit steer="):
                refuse_steer(found(length), car, "log")
        else:
            refuse_steer(found(length), car, "log")
    # The tangent shows it without a tape measure, where it is clear.
    refuse_steer(found(4.6, 0.6, 7.9), None, "log")
    with pytest.raises(LogError, match=r"0\.6 times the angle of steer"):
        refuse_steer(found(4.6, 0.6, 8.1), None, "log")
    # As one parameter more it has its price: half the logarithm of how many residuals there are.
    refuse_steer(found(4.6, 0.6, 11.4, 1000), None, "log")
    with pytest.raises(LogError, match=r"0\.6 times the angle of steer"):
        refuse_steer(found(4.6, 0.6, 11.5, 1000), None, "log")
    # A tape measure tells better: a scale that takes the length away from it is none.
    refuse_steer(found(2.7, 0.7, 20.0), popsteer.Vehicle(wheelbase=2.7), "log")
    with pytest.raises(LogError, match=r"0\.6 times the angle of steer"):
        refuse_steer(found(4.4, 0.6, 20.0), popsteer.Vehicle(wheelbase=2.8), "log")


def test_commands_in_a_gap_keep_their_distance_to_its_end() -> None:
    log, clock = np.array([0.0, 0.1, 0.2, 60.0, 60.1]), np.array([0.0, 0.1, 0.2, 5.2, 5.3])
    found = _on_clock(np.array([-0.05, 0.15, 30.0, 59.0, 60.05, 61.0]), log, clock)
    assert found == pytest.approx([-0.05, 0.15, 0.2, 4.2, 5.25, 6.2], abs=1e-7)


def _on_tyres(length: float, seconds: float = 100.0, kept: float = 0.0) -> tuple[Log, float]:
    """Drive a car on linear tyres through brisk bends; its understeer besides [s²/m].

    A bicycle with two axles that slip: 60 and 75 m/s² for a radian, and 0.15 s of dead time; the
    wheels keep a share of what is left of their way in each step of 2.5 ms.
    """
    front, front_grip, rear_grip, dt, substeps = 0.45 * length, 60.0, 75.0, 0.05, 20
    rear, random, h = length - front, np.random.default_rng(4), dt / substeps
    t = dt * np.arange(round(seconds / dt))
    steps = np.repeat(random.uniform(-1.0, 1.0, len(t) // 40), 40)
    speed = 7.0 + 3.0 * np.sin(0.23 * t)
    steer = np.convolve(steps * np.minimum(0.25, 4.5 * length / speed**2), np.ones(6) / 6, "same")
    rows, x, y, yaw, aside, turn, wheel = [], 0.0, 0.0, 0.0, 0.0, 0.0, float(steer[0])
    for k, v in enumerate(speed.tolist()):
        rows.append((x, y, yaw))
        wanted = float(steer[max(k - 3, 0)])
        for _ in range(substeps):
            wheel = wanted + (wheel - wanted) * kept
            of_front = front_grip * (wheel - np.arctan2(aside + front * turn, v))
            of_rear = -rear_grip * np.arctan2(aside - rear * turn, v)
            across = of_front * np.cos(wheel)
            moment = (front * across - rear * of_rear) / (front * rear)
            aside, turn = aside + (across + of_rear - v * turn) * h, turn + moment * h
            sideways = aside - rear * turn  # of the rear axle
            x += (v * np.cos(yaw) - sideways * np.sin(yaw)) * h
            y += (v * np.sin(yaw) + sideways * np.cos(yaw)) * h
            yaw += turn * h
    poses = np.array(rows) + random.standard_normal((len(t), 3)) * (0.02, 0.02, 0.002)
    speed = speed + 0.02 * random.standard_normal(len(t))
    understeer = (rear * rear_grip - front * front_grip) / (front_grip * rear_grip * length)
    columns: list[Any] = [t, *poses.T, speed, steer]
    return Log(*columns), understeer


@pytest.mark.parametrize("length", [2.4, 3.5])
def test_tyres_that_slip_are_no_command_of_another_scale(length: float) -> None:
    # They take from the angle whose tangent bends: without them its commands look too large.
    log, understeer = _on_tyres(length)
    found = popsteer.identify(log)
    error = np.hypot(found.turning_length_error, found.model_errors["turning_length"])
    truth = length + understeer * found.speed**2
    assert found.turning_length == pytest.approx(truth, abs=3.0 * error)
    assert error < 0.005 * truth
    assert found.vehicle.wheelbase == pytest.approx(length, rel=0.02)
    # Their force is across turned wheels: taken across the car it is off by more than that.
    own = float(np.hypot(found.errors["understeer"], found.model_errors["understeer"]))
    assert found.vehicle.understeer == pytest.approx(understeer, abs=2.0 * own)
    assert own < 0.01 * understeer


def test_lag_of_the_tyres_is_told_from_that_of_the_wheels() -> None:
    lag, length, front_grip, rear_grip = 0.15, 3.0, 60.0, 75.0
    log, understeer = _on_tyres(length, kept=math.exp(-0.0025 / lag))
    found = popsteer.identify(log)
    assert found.explains
    v, front, rear = found.speed, 0.45 * length, 0.55 * length
    # The mean delay of the linear bicycle, from the slope of its response at 0 Hz.
    turns = rear * rear_grip - front * front_grip
    squares = front**2 * front_grip + rear**2 * rear_grip
    axles = front * rear
    system = [
        [-(front_grip + rear_grip) / v, turns / v - v],
        [turns / v / axles, -squares / v / axles],
    ]
    gain = np.linalg.solve(system, [front_grip, front * front_grip / axles])
    late = np.linalg.solve(system, gain)[1] / gain[1]
    # What is simulated in steps of 2.5 ms is early by up to two of them.
    assert found.delay == pytest.approx(0.15 + lag - late, abs=0.005)
    assert found.fit.values["steer_lag"] - found.fit.values["tyre_lag"] == pytest.approx(
        lag, abs=0.02
    )
    truth = length + understeer * v**2
    error = np.hypot(found.turning_length_error, found.model_errors["turning_length"])
    assert found.turning_length == pytest.approx(truth, abs=3.0 * error)
