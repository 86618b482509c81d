"""The whole vehicle in one step, from Python."""

from __future__ import annotations

import copy
import math
import pickle
from math import inf, nan
from typing import TypeAlias

import numpy as np
import pytest

import popsteer

CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, max_steer=0.6, max_steer_rate=0.5, dead_time=0.15, max_speed=8.0
)
PATH = popsteer.Path([(0.5 * k, 3.0 * math.sin(0.05 * k)) for k in range(200)])
TUNINGS = [
    popsteer.PreviewPopParams(),
    popsteer.StanleyParams(),
    popsteer.PurePursuitParams(),
    popsteer.PidParams(),
    popsteer.PopParams(),
]
Pose: TypeAlias = tuple[float, float, float, float]
POSE = (1.35, 0.1, 0.3, 3.0)


def moved(pose: Pose, steer: float) -> Pose:
    """The pose of the car's centre 0.05 s later, with the wheels at the angle of the command."""
    x, y, yaw, speed = pose
    turn = 0.05 * speed * math.tan(steer) / 2.7
    mean = yaw + 0.5 * turn
    x += 0.05 * speed * math.cos(mean) - 1.35 * turn * math.sin(mean)
    y += 0.05 * speed * math.sin(mean) + 1.35 * turn * math.cos(mean)
    return x, y, yaw + turn, speed


def made(tuning: object = None) -> popsteer.Driver:
    return popsteer.Driver(PATH, CAR, tuning)  # type: ignore[arg-type]


@pytest.mark.parametrize("tuning", TUNINGS, ids=lambda tuning: type(tuning).__name__)
def test_driver_steers_as_the_controller_of_its_tuning_does(tuning: object) -> None:
    kind = getattr(popsteer, type(tuning).__name__.removesuffix("Params"))
    controller, driver = kind(PATH, CAR, tuning), made(tuning)
    pose: Pose = POSE
    angles = [0.0, 0.0, 0.0]
    for _ in range(100):
        command, drive = controller.step(*pose, 0.05), driver.step(*pose, 0.05)
        angles.append(drive.steer)
        pose = moved(pose, angles[-4])
        assert drive.steer == command.steer
        assert drive.cross_track_error == command.cross_track_error
        assert drive.status == command.status
    assert driver.controller == tuning
    assert driver.tracked_point == controller.tracked_point


@pytest.mark.parametrize("tuning", TUNINGS, ids=lambda tuning: type(tuning).__name__)
def test_driver_state_goes_out_and_comes_back_by_pickle_and_copy(tuning: object) -> None:
    driver = made(tuning)
    for k in range(30):
        driver.step(1.35 + 0.15 * k, 0.1, 0.3, 3.0, 0.05)
    driver.step(nan, nan, 0.3, 3.0, 0.05)
    second = made(tuning)
    second.state = driver.state
    for twin in (second, pickle.loads(pickle.dumps(driver)), copy.deepcopy(driver)):
        assert twin.state == driver.state
        once_more = copy.deepcopy(driver)
        assert twin.step(6.0, 0.2, 0.2, 3.0, 0.05) == once_more.step(6.0, 0.2, 0.2, 3.0, 0.05)


def test_driver_state_of_another_controller_or_a_wrong_number_is_refused() -> None:
    driver = made()
    driver.step(*POSE, 0.05)
    with pytest.raises(popsteer.InputError):
        made(popsteer.StanleyParams()).state = driver.state
    spoilt = driver.state.replace(fault="tyres")
    with pytest.raises(popsteer.InputError, match="fault"):
        driver.state = spoilt


@pytest.mark.parametrize("odd", [nan, inf, -inf, 1e300, None])
def test_driver_answers_every_number_with_finite_ones(odd: float | None) -> None:
    for place in range(5):
        driver = made()
        for k in range(60):
            values: list[float | None] = [1.35 + 0.15 * k, 0.1, 0.1, 3.0, 0.05]
            if k >= 5:
                values[place] = odd
            drive = driver.step(*values)
            assert math.isfinite(drive.steer)
            assert math.isfinite(drive.acceleration)
        # A clock that stands is a fault later than a signal that does not come.
        assert drive.fault == ("position", "position", "heading", "speed", None)[place]
        assert drive.acceleration < 0.0 or place == 4


def test_driver_before_anything_is_known_holds_and_is_no_fault() -> None:
    driver = made()
    for _ in range(100):
        drive = driver.step(nan, nan, nan, nan, 0.05)
        assert drive.hold
        assert drive.fault is None
        assert "input-held" in str(drive.status)
        # A loop that ends where it stands at its stop waits.
        assert (drive.phase, drive.distance_to_stop) == ("stopped", inf)
    assert not driver.step(*POSE, 0.05).hold


def test_driver_released_without_inputs_brakes_and_says_so_again() -> None:
    driver = made()
    pose: Pose = POSE
    for _ in range(20):
        pose = moved(pose, driver.step(*pose, 0.05).steer)
    while driver.step(nan, nan, nan, nan, 0.05).fault is None:
        pass
    assert driver.release() == "input"
    blind = [driver.step(nan, nan, nan, nan, 0.05) for _ in range(20)]
    assert {(drive.acceleration, drive.speed) for drive in blind} == {(-3.0, 0.0)}
    assert [drive.fault for drive in blind] == [None] * 10 + ["input"] * 10
    assert driver.release() == "input"
    assert driver.step(*pose, 0.05).fault is None
    assert driver.step(*pose, 0.05).acceleration > -3.0


@pytest.mark.parametrize("period", [0.02, 0.05])
def test_driver_brakes_hard_off_its_path_in_acceleration_and_speed(period: float) -> None:
    driver = made(popsteer.StanleyParams())
    x, speed, since = 0.0, 6.0, 0.0
    drives = []
    while speed > 1.0:
        aside = 0.0 if x < 3.0 else 2.0
        drive = driver.step(x, 3.0 * math.sin(0.1 * x) + aside, 0.3, speed, period)
        x += speed * period
        if drive.fault is not None:
            speed += drive.acceleration * period
            since += period
            drives.append((since, drive))
    # Once the jerk allows it, harder than in comfort; and the speed falls as the vehicle's.
    hard = [(t, drive) for t, drive in drives if t > 0.4]
    assert {drive.fault for _, drive in hard} == {"deviation"}
    assert max(drive.acceleration for _, drive in hard) < -5.0
    (start, first), (end, last) = hard[0], hard[-1]
    assert (first.speed - last.speed) / (end - start) > 5.0


def test_driver_held_released_and_gone_on() -> None:
    driver = made()
    assert driver.release() is None
    driver.step(*POSE, 0.05)
    driver.hold()
    driver.step(*POSE, 0.05)
    assert driver.step(*POSE, 0.05).acceleration < 0.0
    driver.go()
    for _ in range(20):
        drive = driver.step(nan, nan, nan, nan, 0.05)
    assert drive.fault == driver.fault == "input"
    # What comes again does not drive by itself.
    assert driver.step(*POSE, 0.05).fault == "input"
    assert driver.release() == "input"
    assert driver.step(*POSE, 0.05).fault is None


def test_driver_set_path_plans_anew_and_keeps_its_place() -> None:
    driver = made()
    for k in range(20):
        before = driver.step(1.35 + 0.15 * k, 0.1, 0.3, 3.0, 0.05)
    slow = popsteer.Path(np.c_[PATH.x, PATH.y], speed=np.full(len(PATH), 2.0))
    driver.set_path(slow)
    assert driver.path is slow
    assert driver.plan.max() <= 2.0
    after = driver.step(1.35 + 0.15 * 20, 0.1, 0.3, 3.0, 0.05)
    assert after.distance_to_stop == pytest.approx(before.distance_to_stop, abs=0.2)
    assert abs(after.steer - before.steer) <= 0.5 * 0.05 + 1e-12


def test_driver_predicts_where_it_will_be_from_its_start_to_its_stop() -> None:
    # A drive whose pedals answer after 0.2 s and with a lag of 0.3 s, by its equations.
    car = CAR.replace(rear_axle=0.0, dead_time=0.0, drive_delay=0.2, drive_lag=0.3, max_speed=5.0)
    s = np.arange(0.0, 40.0, 0.5)
    line = popsteer.Path(np.c_[30.0 * np.sin(s / 30.0), 30.0 - 30.0 * np.cos(s / 30.0)])
    driver = popsteer.Driver(line, car)
    with pytest.raises(popsteer.InputError):
        driver.predict()
    x = y = yaw = speed = pull = wheel = 0.0
    pulls, went, ahead = [0.0] * 40, [], []
    for _ in range(700):
        command = driver.step(x, y, yaw, speed, 0.02)
        went.append((x, y))
        ahead.append(driver.predict(2.0, 0.1))
        for _ in range(4):
            pulls.append(command.acceleration)
            pull += (pulls.pop(0) - pull) * (1.0 - np.exp(-0.005 / 0.3))
            turn = (command.steer - wheel) / max(car.steer_lag, 0.005)
            wheel += 0.005 * np.clip(turn, -0.5, 0.5)
            speed = max(speed + 0.005 * pull, 0.0)
            yaw += 0.005 * speed * np.tan(wheel) / car.wheelbase
            x, y = x + 0.005 * speed * np.cos(yaw), y + 0.005 * speed * np.sin(yaw)
    assert command.phase == "standing"
    for seconds, most in ((1.0, 0.05), (2.0, 0.15)):
        k, steps = round(seconds / 0.1), round(seconds / 0.02)
        off = [
            np.hypot(each.x[k] - there[0], each.y[k] - there[1])
            for each, there in zip(ahead, went[steps:], strict=False)
        ]
        assert max(off) < most, seconds


def test_prediction_of_a_driver_turns_round_at_a_cusp_and_stops_for_a_fault() -> None:
    x = np.r_[np.arange(0.0, 10.1, 0.5), np.arange(9.5, -0.1, -0.5)]
    there = popsteer.Path(np.c_[x, 0.0 * x], speed=[2.0] * 21 + [-2.0] * 20)
    driver = popsteer.Driver(there, CAR.replace(rear_axle=0.0))
    for k in range(40):
        driver.step(4.0 + 0.1 * k, 0.0, 0.0, 2.0, 0.05)
    seen = driver.predict(12.0, 0.05)
    assert seen.x.max() == pytest.approx(10.0, abs=0.1)
    assert seen.speed.min() < -1.0
    assert seen.x[-1] == pytest.approx(0.0, abs=0.05)
    for _ in range(20):
        driver.step(np.nan, np.nan, np.nan, np.nan, 0.05)
    assert driver.fault == "input"
    assert driver.predict(5.0).speed[-1] == pytest.approx(0.0, abs=1e-9)


def test_driver_repr_names_what_it_is_made_of() -> None:
    text = repr(made(popsteer.StanleyParams()))
    assert text.startswith("Driver(<Path of 200 waypoints")
    assert "StanleyParams(" in text
