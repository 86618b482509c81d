"""Stops on slopes, and speeds along the racetrack, by plant: tables of docs/planning.md."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from popsteer import Path, PreviewPop, SpeedTracker, Vehicle, planning, sim, tracks
from popsteer.lab.suite.drive import along, pedals_on, rms
from popsteer.sim.geometry import object_of, pose_of
from studies.layout import line

if TYPE_CHECKING:
    from numpy.typing import NDArray

PERIOD, STEP = 0.05, 0.005
"""Of the control and of the car's motion [s]."""


class OwnCar:
    """A bicycle of its own, on a slope towards +x.

    Its wheels have a dead time, a lag, a limit of their rate and play; its drive has a lag, its
    brakes act against the motion and hold at rest, and gravity moves it if nothing holds it.
    """

    stands = True

    def __init__(
        self, vehicle: Vehicle, speed: float = 0.0, grade: float = 0.0, play: float = 0.0
    ) -> None:
        self.vehicle, self.speed, self.play = vehicle, speed, play
        self.slope = along(grade)
        self.flight = deque([0.0] * round(vehicle.dead_time / STEP))
        self.x = self.y = self.yaw = self.wheel = self.road_wheel = self.pull = 0.0

    @property
    def state(self) -> tuple[float, float, float, float]:
        return self.x, self.y, self.yaw, self.speed

    def advance(self, steer: float, acceleration: float, *, reverse: bool) -> None:
        car = self.vehicle
        gear = -1.0 if reverse else 1.0
        rate = car.max_steer_rate or math.inf
        brakes = car.brake_deceleration or 6.0
        for _ in range(round(PERIOD / STEP)):
            self.flight.append(steer)
            turn = (self.flight.popleft() - self.wheel) / max(car.steer_lag, STEP)
            self.wheel += STEP * max(-rate, min(rate, turn))
            half = 0.5 * self.play
            self.road_wheel = max(self.wheel - half, min(self.road_wheel, self.wheel + half))
            self.pull += STEP / max(car.drive_lag, STEP) * (max(acceleration, -brakes) - self.pull)
            push = gear * max(self.pull, 0.0) + self.slope * math.cos(self.yaw)
            free = self.speed + STEP * push
            held = max(abs(free) + STEP * min(self.pull, 0.0), 0.0)
            self.speed = math.copysign(held, free)
            self.x += STEP * self.speed * math.cos(self.yaw)
            self.y += STEP * self.speed * math.sin(self.yaw)
            self.yaw += STEP * self.speed * math.tan(self.road_wheel) / car.wheelbase


class Shipped:
    """A plant of popsteer on its pedals; a slope is a throttle or a brake that is always on."""

    def __init__(self, name: str, path: Path, speed: float = 0.0, grade: float = 0.0) -> None:
        plant = object_of(name)
        self.vehicle, self.stands = plant.vehicle, name != "commonroad-mb-2"
        self.pedals = sim.PedalMap.of(plant)
        x, y = path.x[:2].tolist(), path.y[:2].tolist()
        yaw = math.atan2(y[1] - y[0], x[1] - x[0])
        start = pose_of((x[0], y[0], yaw), "rear", self.vehicle)
        settings = sim.Settings(dt=PERIOD, stop_distance=0.0, time_limit=300.0)
        self.run = sim.Simulation(path, plant, start=start, speed=speed, settings=settings)
        self.always = pedals_on(grade, self.pedals)

    @property
    def state(self) -> tuple[float, float, float, float]:
        return self.run.state

    def advance(self, steer: float, acceleration: float, *, reverse: bool) -> None:
        speed = self.run.state[3]
        pedals = self.pedals(acceleration, -speed if reverse else speed)
        throttle, brake = (min(a + b, 1.0) for a, b in zip(pedals, self.always, strict=True))
        self.run.step(steer, throttle, brake, reverse)


Moved: TypeAlias = OwnCar | Shipped
"""A vehicle that steers, pulls and brakes as commanded, and whether it can stand."""
LENGTH, SPEED = 200, 12.0
"""Of the straight [m], and of the start [m/s]."""
GRADES = (0.0, 0.02, -0.02, 0.05, -0.05, 0.08, -0.08, 0.1, -0.1)
COMFORT = (1.5, 3.0)
OWN = Vehicle(wheelbase=2.7, max_steer=0.6, drive_lag=0.3, brake_deceleration=6.0)
OWN_NAME = "of the study"
PLANTS = ("carla-identified", "commonroad-mb-2", OWN_NAME)
SETTLED = round(3.0 / PERIOD)
STAND = round(20.0 / PERIOD)
LEAST = 1.2
"""Below this speed [m/s] the multi-body model does not work."""
# What the plants' engines and drag leave on the racetrack.
DRIVEN = tuple(
    (float(v), min(2.0, max(0.05, 0.85 * (5.5 - 0.28 * v - 0.001 * v * v)))) for v in range(26)
)


class Stopped(NamedTuple):
    """What a straight came to; a row has the largest of several."""

    place: float
    """Distance from the end [m]; not a number where the model cannot stand."""
    rms: float
    """Of the speed's error after 3 s [m/s]."""
    beyond: float
    """Deceleration beyond the plan's [m/s²]."""
    changes: float
    """Of standing, in 20 s of noise."""


def mover(name: str, path: Path, speed: float, grade: float = 0.0) -> Moved:
    """Put a plant on the first waypoint."""
    if name == OWN_NAME:
        return OwnCar(OWN, speed, grade)
    return Shipped(name, path, speed, grade)


def drive(car: Moved, path: Path, vehicle: Vehicle) -> tuple[NDArray[np.float64], float, int]:
    """Drive to the end: speed, planned speed, yaw a period, and after 20 s of standing the rear
    axle's x [m], not a number for a model that cannot stand, and how often it stood no more.
    """
    steering, pace = PreviewPop(path, car.vehicle), SpeedTracker(path, vehicle)
    noise = np.random.default_rng(1)
    rows: list[tuple[float, float, float]] = []
    stood = changes = 0
    while stood < STAND and len(rows) < 300.0 / PERIOD:
        x, y, yaw, speed = car.state
        dx, dy = noise.normal(0.0, 0.02, 2) if stood else (0.0, 0.0)
        measured = (x + dx, y + dy, yaw, speed, PERIOD)
        command = pace.step(*measured)
        if not car.stands and speed < LEAST and command.distance_to_stop < 1.0:
            return np.array(rows), math.nan, 0
        if stood or (command.standing and speed < 1e-3):
            stood += 1
            changes += not command.standing
        else:
            rows.append((speed, command.reference_speed, yaw))
        car.advance(steering.steer(*measured), command.acceleration, reverse=False)
    return np.array(rows), car.state[0] + car.vehicle.rear_axle, changes


def stop(name: str, grade: float, comfort: float, *, slope_told: bool, lag_told: bool) -> Stopped:
    """Drive one straight to its end, and stand there for 20 s with 2 cm of noise."""
    x = np.arange(LENGTH + 1.0)
    told = np.full(len(x), grade if slope_told else 0.0)
    path = Path(np.column_stack((x, 0.0 * x)), speed=np.full(len(x), SPEED), grade=told)
    car = mover(name, path, SPEED, grade)
    lag = car.vehicle.drive_lag if lag_told else 0.0
    vehicle = car.vehicle.replace(max_deceleration=comfort, brake_deceleration=6.0, drive_lag=lag)
    rows, end, changes = drive(car, path, vehicle)
    speed, wanted, _ = rows[SETTLED:].T
    hardest = -float(np.diff(speed).min()) / PERIOD
    return Stopped(abs(end - LENGTH), rms(speed - wanted), hardest - comfort, changes)


def stop_lines() -> list[str]:
    """Word a row for each plant, and for what the tracker was told of slope and drive lag."""
    lines: list[str] = []
    for name in PLANTS:
        for slope_told, lag_told in ((True, True), (True, False), (False, True), (False, False)):
            if not lag_told and name == "commonroad-mb-2":
                continue  # it has none
            runs = [
                stop(name, grade, comfort, slope_told=slope_told, lag_told=lag_told)
                for grade in GRADES
                for comfort in COMFORT
            ]
            most = Stopped(*(max(each) for each in zip(*runs, strict=True)))
            place = "cannot stand" if math.isnan(most.place) else f"{most.place:.2f}"
            has_lag = lag_told and name != "commonroad-mb-2"
            told = ("slope" if slope_told else "", "drive lag" if has_lag else "")
            cells = (f"{most.rms:.2f}", f"{max(most.beyond, 0.0):.2f}", f"{most.changes:.0f}")
            words = ", ".join(filter(None, told)) or "neither"
            lines.append(line(name, words, place, *cells))
    return lines


def speed_lines() -> list[str]:
    """Word the racetrack at planned speeds, a row a plant."""
    lines: list[str] = []
    for name in ("carla-identified", "commonroad-mb-2", "mujoco-car"):
        track = Path(tracks.get("racetrack").xy)
        own = mover(name, track, LEAST).vehicle
        limits = planning.SpeedLimits(max_acceleration=DRIVEN)
        car = own.replace(
            max_speed=25.0, max_acceleration=2.0, max_deceleration=3.0, max_lateral_acceleration=4.0
        )
        profile = planning.speed_profile(track, limits, car)
        moved = mover(name, profile.path, 2.0 if name == "commonroad-mb-2" else 0.0)
        (speed, wanted, yaw), *_ = (each.T for each in drive(moved, profile.path, car)[:1])
        along = np.gradient(speed, PERIOD)[5:-5]
        side = np.abs(np.gradient(np.unwrap(yaw), PERIOD) * speed)[5:-5]
        most = (along.max(), -along.min(), side.max())
        cells = (f"{rms(speed - wanted):.2f}", ", ".join(f"{each:.1f}" for each in most))
        lines.append(line(name, *cells, f"{len(speed) * PERIOD / profile.time:.3f}"))
    return lines
