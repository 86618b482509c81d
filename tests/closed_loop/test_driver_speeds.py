"""What the driver makes of a path's speeds; a vehicle that takes speeds carries them out."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import reference
from studies.driver import SUBSTEPS, Plant, Wear, car_of, road_of
from tests.helpers import looped

DT = 0.02


def straight(speeds: list[float], spacing: float = 5.0) -> popsteer.Path:
    """A path along x, forth where the speeds are positive and back where they are not."""
    x, points = 0.0, []
    for speed, following in zip(speeds, [*speeds[1:], 0.0], strict=True):
        points.append((x, 0.0))
        x += -spacing if speed < 0.0 or (speed == 0.0 and following < 0.0) else spacing
    return popsteer.Path(points, speed=speeds)


def driven(
    path: popsteer.Path, seconds: float, *, lag: float = 0.0, share: float = 1.0
) -> tuple[list[float], list[float], popsteer.Driver]:
    """Places and speeds of a vehicle that obeys, with a lag, a share of what it is told."""
    driver = popsteer.Driver(path)
    x, speed = float(path.x[0]), 0.0
    places, speeds = [x], [speed]
    for _ in range(round(seconds / DT)):
        wanted = share * signed(driver.step(x, 0.0, 0.0, speed, DT))
        speed = wanted if lag == 0.0 else speed + (wanted - speed) * DT / lag
        x += speed * DT
        places.append(x)
        speeds.append(speed)
    return places, speeds, driver


def signed(drive: popsteer.Drive) -> float:
    return -drive.speed if drive.reverse else drive.speed


@looped(
    ("speeds", "stop"),
    [
        ([5, 5, 5, 0, 0, 5, 5], 15.0),
        ([5, 5, 5, 0, 5, 5, 5], 15.0),
        ([0, 5, 5, 5, 5, 5, 0], 30.0),
        ([0, 0, 5, 5, 5, 5, 5], 30.0),
        ([5, 5, 0, -5, 0, -5, -5], 0.0),
        ([5, 5, 0, 0, -5, -5, -5], 0.0),
        ([0, 0, 0, 0, 0, 0, 0], 0.0),
    ],
)
def test_speed_of_zero_is_a_stop_but_for_a_start_a_cusp_and_the_end(
    speeds: list[float], stop: float
) -> None:
    path = straight([float(speed) for speed in speeds])
    places, ends, _ = driven(path, 45.0)
    assert places[-1] == pytest.approx(stop, abs=0.06)
    assert abs(ends[-1]) < 1e-9
    # The same to the speed tracker, and to the paths of core and reference: which way each segment
    # is driven, and that the speed goes down to 0 there.
    tracker = popsteer.SpeedTracker(path)
    x = speed = 0.0
    for _ in range(2250):
        command = tracker.step(x, 0.0, 0.0, speed, DT)
        gear = -1.0 if command.reverse else 1.0
        speed = gear * max(gear * speed + command.acceleration * DT, 0.0)
        x += speed * DT
    assert command.standing
    assert x == pytest.approx(stop, abs=0.06)
    twin = reference.Path(np.column_stack((path.x, path.y)), speed=path.speed)
    assert (path.reverse is None) == (twin.reverse is None)
    assert path.reverse is None or tuple(path.reverse) == twin.reverse
    for at in range(len(path)):
        known = path.reference_speed(path.x[at], 0.0, at)
        assert known == twin.reference_speed(path.x[at], 0.0, at)
        assert (known == 0.0) == (speeds[at] == 0)


def test_vehicle_stands_before_speeds_of_zero_and_stays() -> None:
    places, speeds, driver = driven(straight([5.0] * 10 + [0.0] * 11), 40.0)
    assert places[-1] == pytest.approx(50.0, abs=0.05)
    assert max(places) < 50.05
    assert speeds[-1] == 0.0
    assert driver.fault is None


@looped(
    ("path", "end"),
    [
        (straight([0.0] + [5.0] * 9 + [0.0]), 50.0),
        (straight([-3.0] * 10 + [0.0]), -50.0),
        (straight([3.0] * 4 + [0.0] + [-3.0] * 3 + [0.0]), 0.0),
    ],
)
def test_vehicle_stops_at_the_end_forth_back_and_after_a_cusp(
    path: popsteer.Path, end: float
) -> None:
    places, speeds, _ = driven(path, 45.0)
    assert places[-1] == pytest.approx(end, abs=0.05)
    assert abs(speeds[-1]) < 0.01
    assert np.abs(np.diff(speeds)).max() < 3.5 * DT + 1e-9


def test_drive_that_is_slow_and_gives_less_is_led_to_the_speed_of_the_path() -> None:
    _, speeds, _ = driven(straight([5.0] * 60), 30.0, lag=0.4, share=0.95)
    assert speeds[-1] == pytest.approx(5.0, abs=0.05)
    assert max(speeds) < 5.3


def test_drive_that_does_not_move_is_not_told_ever_more() -> None:
    driver = popsteer.Driver(straight([5.0] * 60))
    told = [driver.step(0.0, 0.0, 0.0, 0.0, DT).speed for _ in range(500)]
    # As much as 2 m/s² give in the drive's delay of 0.1 s and half a second.
    assert told[-1] == max(told) == pytest.approx(1.2)


def there_and_back(shift: float = 0.0) -> popsteer.Path:
    """To x = 48 m and back in reverse; `shift` moves all waypoints along, as a planner's do."""
    xs = [float(x) + shift for x in [*range(49), *range(47, -1, -1)]]
    speeds = [3.0] * 48 + [0.0] + [-3.0] * 47 + [0.0]
    return popsteer.Path([(x, 0.0) for x in xs], speed=speeds)


def test_path_that_is_published_again_keeps_the_leg_that_is_driven() -> None:
    driver = popsteer.Driver(there_and_back())
    x, speed = 0.0, 0.0
    for k in range(1800):
        if k % 10 == 9:
            driver.set_path(there_and_back(1e-3 * (k % 7)))
        speed = signed(driver.step(x, 0.0, 0.0, speed, DT))
        x += speed * DT
        if k > 1200:  # it is on the way back, and does not turn round again
            assert speed <= 0.0
    assert x == pytest.approx(0.0, abs=0.1)


def test_shifted_path_of_two_laps_keeps_the_lap() -> None:
    angles = np.linspace(0.0, 4.0 * np.pi, 401)
    driver = popsteer.Driver(popsteer.Path(20.0 * _circle(angles)))
    for k in range(3 * 340):
        angle = k * 4.0 * DT / 20.0
        x, y = 20.0 * _circle(angle)
        yaw = angle + np.pi / 2.0
        driver.step(x, y, yaw, 4.0, DT)
        if k % 10 == 9:
            driver.set_path(popsteer.Path((20.0 + 1e-3 * (k % 7)) * _circle(angles)))
            waypoint = driver.state.tracker.place.segment
            assert waypoint == pytest.approx(angle / (4.0 * np.pi) * 400.0, abs=8)


def _circle(angle: Any) -> Any:
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def test_explicit_reverse_counts_where_speeds_have_no_sign() -> None:
    flags = np.arange(9) >= 4
    xs = [0.0, 5.0, 10.0, 15.0, 20.0, 15.0, 10.0, 5.0, 0.0]
    path = popsteer.Path([(x, 0.0) for x in xs], speed=[3, 3, 3, 3, 0, 0, 3, 3, 0], reverse=flags)
    places, speeds, _ = driven(path, 40.0)
    assert max(places) == pytest.approx(20.0, abs=0.1)
    assert places[-1] == pytest.approx(0.0, abs=0.1)
    parked = popsteer.Path(
        [(-x, 0.0) for x in range(9)], speed=[1, 1, 1, 1, 1, 0, 0, 0, 0], reverse=[True] * 9
    )
    places, speeds, _ = driven(parked, 20.0)
    assert places[-1] == pytest.approx(-5.0, abs=0.05)
    assert speeds[-1] == 0.0


@pytest.mark.parametrize("wrong", [50.0, -50.0, 5000.0])
def test_one_wrong_speed_in_a_while_is_no_fault_and_moves_nothing(wrong: float) -> None:
    for seed in range(6):
        draw = np.random.default_rng([13, seed])
        car = car_of(draw)
        path = road_of(car, draw)
        driver, plant = popsteer.Driver(path, car), Plant(car, path, Wear())
        for k in range(600):
            x, y, yaw, speed = plant.sensed()
            drive = driver.step(x, y, yaw, speed + (wrong if k % 43 == 42 else 0.0), 0.05)
            assert drive.fault is None, (seed, k)
            plant.go(drive, SUBSTEPS)
            off = path.project(plant.x, plant.y).cross_track_error
            assert abs(off) < 0.1 * car.wheelbase, (seed, k)


@pytest.mark.parametrize("wheelbase", [0.2, 0.33, 1.0, 2.7])
@pytest.mark.parametrize("rate", [0.6, 1.2])
def test_wheels_that_turn_while_it_drives_follow_a_turn_of_three_arcs(
    wheelbase: float, rate: float
) -> None:
    # Each arc bends to the other side of the vehicle, whose wheels may not turn at rest. They
    # turned in proportion to the way below 5/3 wheelbases a second, within too short a horizon, and
    # the plan sped up as if they were there: 3 of 8 stopped for their deviation.
    radius, spacing = 2.5 * wheelbase, 0.05 * wheelbase
    most = 1.5 * math.sqrt(wheelbase)
    (x, y, yaw), points, speeds, cusps = (0.0, 0.0, 0.0), [(0.0, 0.0)], [most], []
    for gear, bend in ((1.0, 1.0), (-1.0, -1.0), (1.0, 1.0)):
        for _ in range(round(1.5 * radius / spacing)):
            half = 0.5 * gear * spacing * bend / radius
            yaw += half
            x, y = x + gear * spacing * math.cos(yaw), y + gear * spacing * math.sin(yaw)
            yaw += half
            points.append((x, y))
            speeds.append(gear * most)
        cusps.append((x, y))
    car = popsteer.Vehicle(
        wheelbase=wheelbase, max_steer=0.6, max_steer_rate=rate, steer_lag=0.1, max_speed=most
    )
    driver = popsteer.Driver(popsteer.Path(points, speed=speeds), car)
    x = y = yaw = speed = wheel = 0.0
    nearest = [math.inf] * 3
    for _ in range(4000):
        command = driver.step(x, y, yaw, speed, 0.02)
        assert command.fault is None
        for _ in range(4):
            wheel += 0.005 * min(max((command.steer - wheel) / 0.1, -rate), rate)
            gear = -1.0 if command.reverse else 1.0
            # Brakes hold, and do not push back.
            driven = max(gear * speed + 0.005 * command.acceleration, 0.0)
            speed = 0.0 if command.hold else gear * driven
            yaw += 0.005 * speed * math.tan(wheel) / wheelbase
            x, y = x + 0.005 * speed * math.cos(yaw), y + 0.005 * speed * math.sin(yaw)
        for k, cusp in enumerate(cusps):
            nearest[k] = min(nearest[k], math.dist((x, y), cusp))
    assert command.phase == "standing"
    assert math.dist((x, y), cusps[-1]) < 0.2 * min(wheelbase, 1.0)
    assert max(nearest) < 0.2 * min(wheelbase, 1.0)


@looped(
    ("wheelbase", "speed", "age", "dt", "delay", "lag", "steer_lag"),
    [
        (0.36, 1.1, 0.42, 0.02, 0.16, 0.26, 0.0),
        (0.33, 1.6, 0.32, 0.02, 0.14, 0.04, 0.0),
        (0.30, 2.1, 0.50, 0.05, 0.20, 0.12, 0.0),
        (0.53, 2.2, 0.50, 0.02, 0.08, 0.12, 0.0),
        (2.70, 5.0, 0.30, 0.05, 0.10, 0.20, 0.0),
        (0.36, 1.1, 0.42, 0.02, 0.16, 0.26, 0.1),
        (0.43, 1.9, 0.20, 0.02, 0.10, 0.10, 0.2),
    ],
)
def test_vehicle_stops_at_its_end_by_poses_that_are_old(
    *,
    wheelbase: float,
    speed: float,
    age: float,
    dt: float,
    delay: float,
    lag: float,
    steer_lag: float,
) -> None:
    # Its place was moved on with the acceleration of a vehicle that was not yet braking: it braked
    # too soon, came to rest 0.06 to 0.2 m short, and said that it could not stop. Wheels that do
    # not lag, though told so, were taken for ones that turn it by half more: it swung, and said
    # `steering`.
    bend = 0.2 / wheelbase
    ends = 6.0 * wheelbase + 3.0 * speed
    arcs = np.linspace(0.0, ends, 200)
    points = np.column_stack((np.sin(bend * arcs), 1.0 - np.cos(bend * arcs))) / bend
    car = popsteer.Vehicle(
        wheelbase=wheelbase,
        max_steer_rate=1.0,
        steer_lag=steer_lag,
        max_speed=speed,
        max_deceleration=3.0,
        drive_delay=delay,
        drive_lag=lag,
    )
    driver = popsteer.Driver(popsteer.Path(points), car)
    x = y = yaw = driven = pull = wheel = 0.0
    poses, pedals = [(x, y, yaw, driven)] * (round(age / dt) + 1), [0.0] * round(delay / 0.01)
    for _ in range(round(60.0 / dt)):
        command = driver.step(*poses[-1 - round(age / dt)], dt, pose_age=age)
        assert command.fault is None
        for _ in range(round(dt / 0.01)):
            wheel += max(min(command.steer - wheel, 0.01), -0.01)
            pedals.append(command.acceleration)
            pull += (pedals.pop(0) - pull) * (1.0 - math.exp(-0.01 / lag))
            driven = 0.0 if command.hold and driven < 0.01 else max(driven + 0.01 * pull, 0.0)
            yaw += 0.01 * driven * math.tan(wheel) / wheelbase
            x, y = x + 0.01 * driven * math.cos(yaw), y + 0.01 * driven * math.sin(yaw)
        poses.append((x, y, yaw, driven))
    assert command.phase == "standing"
    assert math.dist((x, y), points[-1]) < 0.01 + 0.03 * wheelbase


class _Noisy:
    """A car of one's own on a straight road, whose pose and speed are measured in noise."""

    def __init__(self, wheelbase: float, speed: float, noise: float, dt: float, seed: int) -> None:
        self.random, self.noise, self.dt = random.Random(seed), noise, dt
        road = [(0.2 * k * max(wheelbase, speed), 0.0) for k in range(61)]
        self.car = popsteer.Vehicle(
            wheelbase=wheelbase, max_speed=speed, drive_delay=0.1, drive_lag=0.1
        )
        self.driver = popsteer.Driver(popsteer.Path(road), self.car)
        self.end = road[-1][0]
        self.x = self.y = self.yaw = self.speed = self.pull = self.wheel = 0.0
        self.pedals = [0.0] * round(0.1 / 0.005)

    def step(self, sign: float = 1.0) -> popsteer.Drive:
        gauss = self.random.gauss
        command = self.driver.step(
            self.x + gauss(0.0, 0.005),
            self.y + gauss(0.0, 0.005),
            self.yaw + gauss(0.0, 0.002),
            sign * self.speed + gauss(0.0, self.noise),
            self.dt,
        )
        for _ in range(round(self.dt / 0.005)):
            self.pedals.append(command.acceleration)
            self.pull += (self.pedals.pop(0) - self.pull) * 0.05
            self.speed = max(self.speed + 0.005 * self.pull, 0.0)
            self.wheel += (command.steer - self.wheel) * 0.05
            self.yaw += 0.005 * self.speed * math.tan(self.wheel) / self.car.wheelbase
            self.x += 0.005 * self.speed * math.cos(self.yaw)
            self.y += 0.005 * self.speed * math.sin(self.yaw)
        return command


@pytest.mark.parametrize(
    ("wheelbase", "speed", "noise", "dt", "seed"),
    [
        (0.33, 1.6, 0.05, 0.05, 1),
        (0.33, 1.6, 0.1, 0.02, 2),
        (1.5, 4.0, 0.1, 0.02, 3),
        (1.5, 4.0, 0.2, 0.05, 4),
        (2.7, 8.0, 0.2, 0.02, 5),
        (7.5, 8.0, 0.1, 0.1, 6),
        (10.0, 8.0, 0.2, 0.02, 7),
    ],
)
def test_vehicle_whose_speed_is_noisy_starts_and_stands_as_one_whose_is_not(
    *, wheelbase: float, speed: float, noise: float, dt: float, seed: int
) -> None:
    # At rest noise was a vehicle that rolls: it waited up to 19 s for its gear, crept before its
    # end for minutes, and said `cannot-stop`, `speed` or `position` there.
    car = _Noisy(wheelbase, speed, noise, dt, seed)
    started = None
    for k in range(round(60.0 / dt)):
        command = car.step()
        assert command.fault is None
        if started is None and car.speed > 0.1:
            started = dt * k
        assert dt * k < 3.0 or started is not None
    assert command.phase == "standing"
    assert abs(car.x - car.end) < 0.05 + 0.03 * wheelbase + 0.2 * noise


def test_nothing_is_learnt_from_noise_at_rest() -> None:
    # Noise of the speed was a way that the car did not go and turns that it did not make: after 7 s
    # it had a gain of 0.4 and a slip of 0.1 rad, and took its speed for two thirds on its way.
    for seed in range(6):
        car = _Noisy(0.25, 2.0, 0.07, 0.035, seed)
        car.driver.hold()
        for _ in range(200):
            car.step()
        rest = car.driver.estimate
        assert abs(rest.gain - 1.0) < 0.02
        assert abs(rest.slip) < 0.08
        car.driver.go()
        for _ in range(60):
            car.step()
            assert 0.8 < car.driver.estimate.speed_scale < 1.2


def test_sign_of_a_speed_that_changes_on_the_way_is_said_at_once() -> None:
    # Two messages were believed whatever they said, and every pose was an outlier then: the car
    # sped up for 1.1 s, and the speed by the poses swung by 80 m/s.
    car = _Noisy(2.7, 10.0, 0.05, 0.05, 1)
    for _ in range(160):
        assert car.step().fault is None
    before = car.speed
    faults = [car.step(sign=-1.0).fault for _ in range(5)]
    assert faults[-1] == "speed"
    for _ in range(400):
        car.step(sign=-1.0)
        assert car.speed < before + 0.5
        believed = car.driver.state.signals.believed.speed
        assert abs(believed - car.speed) < 1.0
    assert car.speed == 0.0
