"""Logs of cars that nobody has described: driven by Stanley, with noise in what is logged."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

import popsteer
from popsteer import plants, sim, tracks
from popsteer.errors import PlantLimit

if TYPE_CHECKING:
    from popsteer.identification import Identification

OFFSET = math.radians(1.0)
DEAD_TIME = 0.15
CARS = ("carla-identified", "commonroad-st-2", "commonroad-mb-2", "mujoco-car")
BICYCLE = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, steer_lag=0.12, understeer=0.002, max_steer=0.6
)
"""A car of the model's own structure."""
SHARE_OF_SPEED = 0.75
"""Of the track's reference speeds: with all of them no margin is left for 0.15 s of dead time."""
LEAST_SPEED = 5.0


def plant(name: str, dead_time: float = DEAD_TIME, offset: float = OFFSET) -> Any:
    """Give a plant with a dead time and a steering offset."""
    if name == "kinematic-bicycle":
        car = BICYCLE.replace(dead_time=dead_time, steer_offset=offset)
        return sim.KinematicBicycle(car)
    if name == "carla-identified":
        made = sim.CarlaIdentified()
        vehicle = made.vehicle.replace(dead_time=dead_time, steer_offset=offset)
        return made.replace(vehicle=vehicle)
    if name == "mujoco-car":
        from popsteer.plants.mujoco_car import MujocoCar

        return MujocoCar(dead_time=dead_time, steer_offset=offset)
    from popsteer.plants.commonroad import CommonRoad

    _, model, number = name.split("-")
    return CommonRoad(model, int(number), dead_time=dead_time, steer_offset=offset)


def course() -> popsteer.Path:
    track = tracks.get("racetrack")
    speed = np.maximum(SHARE_OF_SPEED * track.speed, LEAST_SPEED)
    return popsteer.Path(track.xy, speed=speed, closed=True)


@functools.cache
def drive(
    name: str,
    seconds: float = 120.0,
    seed: int = 0,
    noise: float = 1.0,
    dt: float = 0.05,
    dead_time: float = DEAD_TIME,
    offset: float = OFFSET,
    logged: int | None = None,
) -> dict[str, Any]:
    """Drive a plant over the race track; the columns of its log.

    `seed` draws the noise of what Stanley is given, and what the log has. With `logged` the log has
    noise of its own: the same drive, logged again.
    """
    path, mover = course(), plant(name, dead_time, offset)
    vehicle = sim.vehicle_of(mover)
    settings = sim.Settings(dt=dt, time_limit=seconds, give_up_distance=50.0)
    start = sim.default_start(path, vehicle=vehicle)
    run = sim.Simulation(path, mover, start=start, speed=LEAST_SPEED, settings=settings)
    stanley = popsteer.Stanley(path, vehicle)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    random = np.random.default_rng(seed)
    again = None if logged is None else np.random.default_rng(logged)
    rows = []
    for k in range(round(seconds / dt)):
        measured = _measured(run.state, noise, random)
        steer = stanley.step(*measured, dt).steer
        throttle, brake = pedals.step(measured[3], run.reference_speed or LEAST_SPEED, dt)
        x, y, yaw, speed = measured if again is None else _measured(run.state, noise, again)
        rows.append((k * dt, x, y, math.remainder(yaw, math.tau), speed, steer))
        run.step(steer, throttle, brake)
        if run.ending not in (None, "finished"):
            break
    columns = np.array(rows).T
    return dict(zip(("t", "x", "y", "yaw", "speed", "steer"), columns, strict=True))


def _measured(
    state: tuple[float, float, float, float], noise: float, random: np.random.Generator
) -> tuple[float, float, float, float]:
    """Add noise to position, heading and speed."""
    x, y = np.array(state[:2]) + noise * 0.02 * random.standard_normal(2)
    yaw = state[2] + noise * 0.002 * random.standard_normal()
    return x, y, yaw, state[3] + noise * 0.02 * random.standard_normal()


def whole_errors(found: Identification) -> dict[str, float]:
    """Give the errors of noise and of the model together."""
    noise = {"delay": found.delay_error, "turning_length": found.turning_length_error}
    noise |= found.errors
    return {name: math.hypot(noise[name], model) for name, model in found.model_errors.items()}


def track(name: str, vehicle: popsteer.Vehicle, seconds: float = 50.0, dt: float = 0.05) -> float:
    """Drive preview POP that believes a vehicle; mean error of the rear axle after 5 s [m]."""
    path, mover = course(), plant(name)
    start = sim.default_start(path, vehicle=sim.vehicle_of(mover))
    settings = sim.Settings(dt=dt, time_limit=seconds, give_up_distance=50.0)
    run = sim.Simulation(path, mover, start=start, speed=LEAST_SPEED, settings=settings)
    controller = popsteer.PreviewPop(path, vehicle)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    for _ in range(round(seconds / dt)):
        x, y, yaw, speed = run.state
        steer = controller.step(x, y, yaw, speed, dt).steer
        run.step(steer, *pedals.step(speed, run.reference_speed or LEAST_SPEED, dt))
        if run.ending is not None:
            break
    records = run.records()
    settled = records["time"] > 5.0
    return float(np.abs(records["rear_cross_track_error"][settled]).mean())


def response(name: str, speed: float = 9.0, frequency: float = 1.0, dt: float = 0.05) -> float:
    """Measure how late the yaw rate is behind the command of a plant without dead time [s].

    The phase of the heading under a slow sine of 0.03 rad, less half a period for which a command
    holds.
    """
    path = popsteer.Path([(5.0 * k, 0.0) for k in range(200)], speed=[speed] * 200)
    settings = sim.Settings(dt=dt, give_up_distance=900.0, time_limit=60.0)
    mover = plant(name, dead_time=0.0, offset=0.0)
    run = sim.Simulation(path, mover, start=(0.0, 0.0, 0.0), speed=speed, settings=settings)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    t = dt * np.arange(round(8.0 * math.pi / frequency / dt))
    heading = np.empty_like(t)
    for k, time in enumerate(t):
        heading[k] = run.state[2]
        now = run.state[3]
        run.step(0.03 * math.sin(frequency * time), *pedals.step(now, speed, dt))
    late = t > 2.0 * math.pi / frequency
    waves = np.column_stack([np.sin(frequency * t), np.cos(frequency * t), np.ones_like(t), t])[
        late
    ]
    sine, cosine, *_ = np.linalg.lstsq(waves, heading[late], rcond=None)[0]
    return float(np.arctan2(-sine, -cosine)) / frequency - 0.5 * dt


def table(seed: int = 0) -> str:
    """Identify each car, and set what was found beside what it is."""
    from popsteer.logs import Log

    lines = [
        (
            "| car | offset [deg] | dead time [s] | dead time and lag [s] | rear axle [m] |"
            " preview POP, given / identified [mm] |"
        ),
        "|---|---|---|---|---|---|",
    ]
    for name in CARS:
        found = popsteer.identify(Log(**drive(name, seed=seed), name=name))
        whole = whole_errors(found)
        car, itself = found.vehicle, sim.vehicle_of(plant(name))
        late = DEAD_TIME + response(name, found.speed)
        told = track(name, itself)
        identified = track(name, car.replace(max_steer_rate=itself.max_steer_rate))
        own = itself.rear_axle if itself.no_slip_point is None else itself.no_slip_point
        lines.append(
            f"| {name} | {math.degrees(car.steer_offset):.3f} (1) | {car.dead_time:.3f}"
            f" ± {whole['dead_time']:.3f} (0.15) | {found.delay:.3f} ±"
            f" {whole['delay']:.3f} ({late:.3f}) | {round(car.rear_axle, 2) + 0.0:.2f} ({own:g}) |"
            f" {1e3 * told:.1f} / {1e3 * identified:.1f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())  # noqa: T201 - a program


class Bicycle:
    """The core's kinematic bicycle, whose wheels turn at once, with its pose at the rear axle."""

    name, reverses = "python-bicycle", True

    def __init__(self, last_x: float = math.inf, vehicle: popsteer.Vehicle | None = None) -> None:
        self.params, self.last_x = sim.KinematicBicycle(), last_x
        self.vehicle = self.params.vehicle if vehicle is None else vehicle
        self.state = (math.nan,) * 4

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        self.state = x, y, yaw, speed

    def advance(
        self,
        steer: float,
        throttle: float,
        brake: float,
        dt: float,
        substeps: int,
        reverse: bool,
        /,
    ) -> plants.PlantState:
        p, curvature = self.params, math.tan(steer) / self.vehicle.wheelbase
        gear = -1.0 if reverse else 1.0
        x, y, yaw, speed = self.state
        for _ in range(substeps):
            yaw_rate, travel = speed * curvature, speed * dt
            heading = yaw + 0.5 * (travel * curvature)
            x, y = x + travel * math.cos(heading), y + travel * math.sin(heading)
            yaw += travel * curvature
            along = gear * speed
            braking = math.copysign(p.braking * brake, along)
            after = along + (p.drive * throttle - braking - p.drag * along) * dt
            speed = gear * (min(after, 0.0) if along < 0.0 else max(after, 0.0))
        self.state = x, y, yaw, speed
        if self.state[0] > self.last_x:
            raise PlantLimit("the end of the world")
        return plants.PlantState(*self.state, yaw_rate, steer)
