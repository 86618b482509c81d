"""A car that is not popsteer's: equations of its own, an odd rate, and sensors that fail.

A bicycle whose wheels turn slowly behind a lag, a dead time and a play, its pose given at its
centre. `drive` is the loop of a user: a path, perhaps a fresh one every cycle, and a controller.
"""

from __future__ import annotations

import functools
import itertools
import math
import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicSpline

import popsteer

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Curve = NDArray[np.float64]
    Pose = tuple[float, float, float, float]
    Sense = Callable[[float, Pose], Pose]

TOLD = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    max_steer_rate=0.4,
    steer_lag=0.15,
    dead_time=0.15,
)

START = 10.0
"""When sensors begin to fail [s]."""


@dataclass
class Car:
    """A bicycle in steps of 2 ms; x, y and yaw are those of the rear axle."""

    wheelbase: float = 2.7
    lag: float = 0.15
    dead_time: float = 0.15
    rate: float = 0.4
    most: float = 0.6
    offset: float = 0.0
    play: float = 0.0
    understeer: float = 0.0
    centre: float = 1.35
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    speed: float = 0.0
    time: float = 0.0
    column: float = 0.0
    wheel: float = 0.0
    applied: float = 0.0
    coming: list[tuple[float, float]] = field(default_factory=list)

    def command(self, steer: float) -> None:
        """Give a command, which reaches the wheels after the dead time."""
        self.coming.append((self.time + self.dead_time, steer))

    def advance(self, dt: float, speed: float) -> None:
        """Drive for `dt`, from the present speed to `speed`."""
        steps = max(1, math.ceil(dt / 0.002 - 1e-9))
        step, start = dt / steps, self.speed
        for k in range(steps):
            while self.coming and self.coming[0][0] <= self.time + 1e-9:
                self.applied = self.coming.pop(0)[1]
            wanted = (self.applied + self.offset - self.column) / max(self.lag, step)
            turned = self.column + step * max(-self.rate, min(self.rate, wanted))
            self.column = max(-self.most, min(self.most, turned))
            half = 0.5 * self.play
            self.wheel = max(self.column - half, min(self.column + half, self.wheel))
            speed_now = start + (speed - start) * (k + 0.5) / steps
            length = self.wheelbase + self.understeer * speed_now**2
            rate = speed_now * math.tan(self.wheel) / length
            heading = self.yaw + 0.5 * step * rate
            self.x += step * speed_now * math.cos(heading)
            self.y += step * speed_now * math.sin(heading)
            self.yaw += step * rate
            self.time += step
        self.speed = speed

    def pose(self) -> Pose:
        """Return the pose of the centre, and the speed."""
        ahead = (self.centre * math.cos(self.yaw), self.centre * math.sin(self.yaw))
        return self.x + ahead[0], self.y + ahead[1], self.yaw, self.speed


@functools.cache
def bends(spacing: float = 0.5, length: float = 260.0, stretch: float = 1.0) -> Curve:
    """Bend to either side along a sine of 4 m: 25 m in radius, in square with `stretch`."""
    x = np.arange(0.0, length, 0.01)
    xy = np.column_stack((x, 4.0 * np.sin(x / (10.0 * stretch))))
    arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T)))
    at = np.arange(0.0, arc[-1], spacing)
    return np.column_stack([np.interp(at, arc, each) for each in xy.T])


def straight(length: float = 300.0) -> Curve:
    """A straight line with a waypoint a metre."""
    x = np.arange(0.0, length)
    return np.column_stack((x, np.zeros(len(x))))


def circuit(seed: int, spacing: float = 0.1) -> Curve:
    """A closed spline of 500 to 800 m with hairpins of 7 to 12 m."""
    rng = random.Random(seed)
    while True:
        count = rng.randint(8, 12)
        angles = [2.0 * math.pi * (k + rng.uniform(-0.3, 0.3)) / count for k in range(count)]
        distance = np.array([rng.uniform(35.0, 130.0) for _ in angles])
        angle = np.sort(angles)
        points = np.column_stack((distance * np.cos(angle), distance * np.sin(angle)))
        points = np.vstack((points, points[:1]))
        knots = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T) ** 0.5))
        curve = CubicSpline(knots, points, bc_type="periodic")
        at = np.linspace(0.0, knots[-1], 20000)
        (dx, dy), (ddx, ddy) = curve(at, 1).T, curve(at, 2).T
        tightest = 1.0 / np.max(np.abs(dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3)
        if 7.0 < tightest < 12.0:
            xy = curve(at)
            arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T)))
            at = np.arange(0.0, arc[-1] - 0.5 * spacing, spacing)
            return np.column_stack([np.interp(at, arc, each) for each in xy.T])


def zigzag(along: float, aside: float) -> Curve:
    """Corners along and aside of the way, with a waypoint a metre."""
    corners = [(along * k, aside * (k % 2)) for k in range(7)]
    points = []
    for (x, y), (to_x, to_y) in itertools.pairwise(corners):
        count = int(math.hypot(to_x - x, to_y - y))
        share = np.arange(count) / count
        points.append(np.column_stack((x + share * (to_x - x), y + share * (to_y - y))))
    return np.vstack(points)


def out_and_back(spacing: float) -> popsteer.Path:
    """Lead 20 m out and back on one line, backwards."""
    there = np.arange(0.0, 20.0 + 1e-9, spacing)
    x = np.append(there, there[-2::-1])
    back = np.arange(len(x)) >= len(there) - 1
    return popsteer.Path(np.column_stack((x, np.zeros(len(x)))), reverse=back)


def flips(every: int | None, controller: type) -> tuple[int, float]:
    """Drive out and back; how often the direction changes, and when the car is back."""
    car = Car(x=2.0)
    steering = controller(out_and_back(0.5), TOLD)
    reverses, speed = [], 2.0
    for k in range(600):
        if every and k and k % every == 0:
            steering.set_path(out_and_back(0.4 if k // every % 2 else 0.5))
        command = steering.step(*car.pose(), 0.05)
        reverses.append(command.reverse)
        speed = -2.0 if command.reverse else 2.0
        car.command(command.steer)
        car.advance(0.05, speed)
        if command.reverse and car.x < 2.0:
            break
    return int(np.sum(np.diff(reverses) != 0)), car.time


def somebody(rng: random.Random) -> Car:
    """Return a car whose wheelbase, lag, dead time and rate are within 10 % of what is told."""
    share = [rng.uniform(0.9, 1.1) for _ in range(4)]
    return Car(2.7 * share[0], 0.15 * share[1], 0.15 * share[2], 0.4 * share[3])


def freezing(seconds: float, *, yaw_alive: bool = False) -> Sense:
    """A localisation that repeats its last pose from `START` on; the speed stays alive."""
    held: list[Pose] = []

    def sense(time: float, pose: Pose) -> Pose:
        if not START <= time < START + seconds:
            return pose
        if not held:
            held.append(pose)
        x, y, yaw, _ = held[0]
        return x, y, pose[2] if yaw_alive else yaw, pose[3]

    return sense


def glitching(times: Sequence[float], aside: float = 0.0, turned: float = 0.0) -> Sense:
    """Single poses that are off."""

    def sense(time: float, pose: Pose) -> Pose:
        x, y, yaw, speed = pose
        if any(abs(time - each) < 0.01 for each in times):
            return x - aside * math.sin(yaw), y + aside * math.cos(yaw), yaw + turned, speed
        return pose

    return sense


def jitter(share: float, dt: float = 0.05) -> Callable[[int, random.Random], float]:
    """Periods that differ from `dt` by up to this share."""
    return lambda _, rng: dt * (1.0 + share * (2.0 * rng.random() - 1.0))


def alternating(*periods: float) -> Callable[[int, random.Random], float]:
    """Periods that take turns."""
    return lambda k, _: periods[k % len(periods)]


@dataclass
class Drive:
    """How a drive went: time and signed error of the rear axle, time and status of each step."""

    errors: list[tuple[float, float]]
    statuses: list[tuple[float, popsteer.Status]]
    steers: list[tuple[float, float]]
    estimate: popsteer.Estimate
    tracked: float = 0.0
    """Largest distance of the point that the controller tracks from the path [m]."""

    def mean(self, since: float = 5.0) -> float:
        """Mean distance from the path after a time [m]."""
        return float(np.mean([abs(error) for time, error in self.errors if time >= since]))

    def largest(self, since: float = 5.0) -> float:
        """Largest distance from the path after a time [m]."""
        return max(abs(error) for time, error in self.errors if time >= since)

    def first(self, condition: popsteer.Status) -> float:
        """When a condition held first [s]; infinite if never."""
        return next((time for time, status in self.statuses if condition in status), math.inf)

    def first_fault(self) -> float:
        """When there was a fault first [s]; infinite if never."""
        return next((time for time, each in self.statuses if each.level == "fault"), math.inf)

    def error_at(self, when: float) -> float:
        """Return the distance from the path at a time [m]."""
        return next((abs(error) for time, error in self.errors if time >= when), math.inf)


def drive(
    controller: Any = popsteer.PreviewPop,
    *,
    car: Car | None = None,
    told: popsteer.Vehicle = TOLD,
    course: Curve | None = None,
    speed: float | Callable[[float], float] = 8.0,
    periods: Callable[[int, random.Random], float] | None = None,
    seconds: float = 25.0,
    noise: tuple[float, float, float] = (0.0, 0.0, 0.0),
    waypoint_noise: float = 0.0,
    fresh: bool = False,
    loss: float = 0.0,
    seed: int = 1,
    beside: float = 0.0,
    sense: Sense | None = None,
    report: Callable[[Car], dict[str, float]] | None = None,
    waypoints: Curve | None = None,
    **options: Any,
) -> Drive:
    """Drive a car by a controller in a loop; `sense` makes of the true pose the measured one.

    The path is the course, or that of other `waypoints`.
    """
    rng, arrays = random.Random(seed), np.random.default_rng(seed)
    car = car or Car()
    course = bends() if course is None else course
    periods = periods or jitter(0.0)

    def planned() -> popsteer.Path:
        xy = course if waypoints is None else waypoints
        return popsteer.Path(xy + arrays.normal(0.0, waypoint_noise, xy.shape))

    def wanted(time: float) -> float:
        return speed(time) if callable(speed) else speed

    truth, path = popsteer.Path(course), planned()
    steering = controller(path, told, **options)
    along = course[1] - course[0]
    car.yaw = math.atan2(along[1], along[0])
    car.x = course[0, 0] - beside * math.sin(car.yaw)
    car.y = course[0, 1] + beside * math.cos(car.yaw)
    car.speed = wanted(0.0)
    drive = Drive([], [], [], steering.estimate)
    passed, period, steer, k = 0.0, periods(0, rng), 0.0, 0
    while car.time < seconds:
        place = truth.project(car.x, car.y)
        if place.arc_length > truth.length - 4.0:
            break
        drive.errors.append((car.time, place.cross_track_error))
        pose = car.pose()
        ahead = steering.tracked_point
        at = pose[0] + ahead * math.cos(pose[2]), pose[1] + ahead * math.sin(pose[2])
        drive.tracked = max(drive.tracked, abs(truth.project(*at).cross_track_error))
        x, y, yaw, sensed = (
            value + (rng.gauss(0.0, by) if by else 0.0)
            for value, by in zip(pose, (noise[0], noise[0], noise[1], noise[2]), strict=True)
        )
        pose = (x, y, yaw, sensed)
        if sense is not None:
            pose = sense(car.time, pose)
        if fresh and k:
            steering.set_path(planned())
        passed += period
        if not (loss and rng.random() < loss):
            command = steering.step(*pose, passed, **(report(car) if report else {}))
            passed, steer = 0.0, command.steer
            drive.statuses.append((car.time, command.status))
            drive.steers.append((car.time, steer))
        period = periods(k, rng)
        car.command(steer)
        car.advance(period, wanted(car.time + period))
        k += 1
    drive.estimate = steering.estimate
    return drive
