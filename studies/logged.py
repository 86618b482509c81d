"""Logs of working drives of cars that share no code with popsteer: a dozen lines of numpy each.

A bicycle with dead time, lag, rate limit and play between the command and its wheels, and a drive
with delay, lag, pedals and drag; what is measured of it has noise.

    python -m studies.logged      # writes lines.csv, stops.csv and gentle.csv
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

Columns = dict[str, Any]
KINDS = ("lines", "parking", "blocks", "laps", "brisk", "slalom", "stop and go")
"""Lines of a field with U-turns at their ends; parking; blocks of a town; laps; brisk bends; bends
to and fro; brisk bends with stops."""


@dataclass(frozen=True)
class Car:
    """The truth: SI units and radians; `play` is the whole of it, `point` that of the pose."""

    length: float = 2.7
    understeer: float = 0.002
    offset: float = 0.01
    lag: float = 0.12
    delay: float = 0.2
    rate: float = math.inf
    play: float = 0.0
    point: float = 1.35
    drive_delay: float = 0.15
    drive_lag: float = 0.25
    throttle: float = 4.0
    braking: float = 8.0
    drag: float = 0.08


def drawn(random: np.random.Generator, length: float | None = None) -> Car:
    """Draw a car of 0.16 to 12 m between its axles."""
    size = float(np.exp(random.uniform(math.log(0.16), math.log(12.0))))
    size = size if length is None else length
    return Car(
        length=size,
        # It grows by 0 to 30 % at 8 m/s of a car of 2.7 m, at like speeds of others.
        understeer=float(random.uniform(0.0, 0.3) * 2.7 / 64.0),
        offset=float(random.uniform(-0.02, 0.02)),
        lag=float(random.uniform(0.05, 0.25)),
        delay=0.005 * int(random.integers(10, 70)),
        rate=float(random.uniform(0.25, 0.8)),
        point=float(random.uniform(0.0, 0.6) * size),
    )


def _legs(kind: str, random: np.random.Generator) -> list[tuple[float, float, float]]:
    """Give a drive as legs: seconds, speed of a car of 2.7 m, angle of its wheels."""
    side = 1.0
    legs: list[tuple[float, float, float]] = []
    while sum(leg[0] for leg in legs) < 230.0:
        if kind == "lines":
            legs.append((random.uniform(12.0, 20.0), 4.0, 0.0))
            legs.append((math.pi * 2.7 / (2.2 * math.tan(0.5)), 2.2, side * 0.5))
            side = -side
        elif kind == "parking":
            way, angle = 1.5 if len(legs) % 2 else -1.5, random.uniform(-0.55, 0.55)
            legs.append((random.uniform(2.0, 6.0), way, angle))
        elif kind == "blocks":
            legs.append((random.uniform(5.0, 12.0), random.uniform(7.0, 12.0), 0.0))
            angle = 0.3 * random.choice([-1.0, 1.0])
            legs.append((0.5 * math.pi * 2.7 / (4.0 * math.tan(0.3)), 4.0, angle))
        elif kind == "laps":
            legs.append((random.uniform(2.0, 5.0), random.uniform(5.0, 10.0), 0.0))
            angle = random.choice([0.05, 0.1, 0.15, -0.08])
            legs.append((random.uniform(2.0, 4.0), random.uniform(5.0, 8.0), angle))
        elif kind == "slalom":
            legs.append((random.uniform(1.0, 2.0), random.uniform(4.0, 7.0), side * 0.15))
            side = -side
        else:
            angle = random.uniform(-0.25, 0.25)
            legs.append((random.uniform(1.0, 3.0), random.uniform(3.0, 8.0), angle))
            if kind == "stop and go" and random.uniform() < 0.4:
                legs.append((random.uniform(4.0, 8.0), 0.0, angle))
    return legs


def commands(kind: str, car: Car, dt: float, random: np.random.Generator) -> tuple[Any, Any, Any]:
    """Give times, speeds and commanded angles of a drive: legs, and a driver who corrects."""
    pace = math.sqrt(car.length / 2.7)
    legs = _legs(kind, random)
    ends = np.cumsum([leg[0] for leg in legs]) * pace
    t = dt * np.arange(round(min(ends[-1], 230.0) / dt))
    leg = np.minimum(np.searchsorted(ends, t), len(legs) - 1)
    wanted = np.array(legs)[leg]
    speed, steer = pace * wanted[:, 1], wanted[:, 2].copy()
    hand, corrected, smooth, fastest = 0.0, 0.0, 0.0, 2.0 * dt * pace
    v, rows, speeds = speed[0], np.empty(len(t)), np.empty(len(t))
    for k in range(len(t)):
        hand += max(-0.6 * dt / pace, min(steer[k] - hand, 0.6 * dt / pace))
        corrected += -corrected * dt / (0.4 * pace) + 0.03 * math.sqrt(dt) * random.normal()
        smooth += (corrected - smooth) * dt / (0.4 * pace + dt)
        v += max(-fastest, min(speed[k] - v, fastest))
        rows[k], speeds[k] = hand + smooth - car.offset, v
    return t, speeds, rows


def pursued(
    kind: str, car: Car, dt: float, random: np.random.Generator, substeps: int = 10
) -> tuple[Any, Any, Any, Any]:
    """Give times, speeds, commanded angles and poses of a driver who looks ahead along the path.

    The driver pursues a point of the path, brakes before bends and stops where the gear changes:
    the angles are smooth, and answer what the car did.
    """
    pace = math.sqrt(car.length / 2.7)
    step, fastest = 0.1 * car.length, 2.0 * pace
    legs: list[tuple[list[complex], list[float]]] = []
    place, course, before = 0j, 0.0, 0.0
    for seconds, fast, angle in _legs(kind, random):
        if fast * before <= 0.0:
            legs.append(([], []))
        for _ in range(max(1, round(seconds * pace**2 * abs(fast) / step))):
            place += math.copysign(step, fast) * cmath.exp(1j * course)
            course += math.copysign(step, fast) * math.tan(angle) / car.length
            legs[-1][0].append(place)
            legs[-1][1].append(pace * abs(fast))
        before = fast
    paths = [tuple(map(np.array, each)) for each in legs]
    h = dt / substeps
    kept, late = math.exp(-h / car.lag), round(car.delay / h)
    at, yaw, v, leg, near, hand, smooth = 0j, 0.0, 0.0, 0, 0, 0.0, 0.0
    actuator = wheel = car.offset
    rows: list[tuple[float, float, float, float]] = []
    given: list[float] = []
    while len(rows) < round(230.0 / dt) and leg < len(paths):
        points, tops = paths[leg]
        near += int(np.argmin(np.abs(points[near : near + 40] - at)))
        if near >= len(points) - 2:
            leg, near = leg + 1, 0
            continue
        way = math.copysign(1.0, ((points[1] - points[0]) * cmath.exp(-1j * yaw)).real)
        braking = np.arange(len(points) - near) * step * 1.2 * fastest
        slow = np.append(tops[near:-1], 0.3 * pace)
        wanted = way * math.sqrt(float(np.min(slow**2 + braking)))
        goal = near + int(max(1.1 * car.length, abs(v) * (0.8 + car.delay + car.lag)) / step)
        over = max(goal - len(points) + 1, 0) * (points[-1] - points[-2])
        off = (points[min(goal, len(points) - 1)] + over - at) * cmath.exp(-1j * yaw)
        hand += -hand * dt / 0.4 + 0.02 * math.sqrt(dt) * random.normal()
        smooth += (hand - smooth) * dt / (0.2 + dt)
        bend = 2.0 * off.imag / abs(off) ** 2 * (car.length + car.understeer * v * v)
        given.append(max(-0.6, min(0.6, math.atan(bend) + smooth)))
        rows.append((at.real, at.imag, yaw, v))
        pull = max(-fastest, min((wanted - v) / dt, fastest))
        for j in range(len(given) * substeps - substeps, len(given) * substeps):
            target, held, was = given[max(j - late, 0) // substeps] + car.offset, wheel, v
            turn = (target - actuator) * (1.0 - kept)
            actuator += max(-car.rate * h, min(turn, car.rate * h))
            wheel = max(actuator - 0.5 * car.play, min(wheel, actuator + 0.5 * car.play))
            v += pull * h
            mean = 0.5 * (v + was)
            turn = mean * math.tan(0.5 * (held + wheel)) / (car.length + car.understeer * mean**2)
            at += mean * h * cmath.exp(1j * (yaw + 0.5 * turn * h))
            yaw += turn * h
    x, y, heading, speed = np.array(rows).T
    x, y = x + car.point * np.cos(heading), y + car.point * np.sin(heading)
    return dt * np.arange(len(x)), speed, np.array(given), np.column_stack([x, y, heading])


def driven(car: Car, t: Any, speed: Any, steer: Any, substeps: int = 10) -> Any:
    """Drive a car along speeds and commands: the pose of its point at each time, (N, 3)."""
    dt = float(t[1] - t[0])
    h, late = dt / substeps, car.delay
    fine = t[0] + h * np.arange(len(t) * substeps)
    held = steer[np.clip(np.floor((fine + 0.5 * h - late - t[0]) / dt).astype(int), 0, None)]
    v = np.interp(fine + 0.5 * h, t, speed)
    actuator = wheel = held[0] + car.offset
    kept = math.exp(-h / car.lag) if car.lag > 0.0 else 0.0
    wheels = np.empty(len(fine))
    for k, target in enumerate((held + car.offset).tolist()):
        step, before = (target - actuator) * (1.0 - kept), wheel
        actuator += max(-car.rate * h, min(step, car.rate * h))
        wheel = max(actuator - 0.5 * car.play, min(wheel, actuator + 0.5 * car.play))
        wheels[k] = 0.5 * (before + wheel)
    turn = v * np.tan(wheels) / (car.length + car.understeer * v * v) * h
    yaw = np.concatenate(([0.0], np.cumsum(turn)))[:-1]
    middle = yaw + 0.5 * turn
    x = np.concatenate(([0.0], np.cumsum(v * np.cos(middle) * h)))[:-1] + car.point * np.cos(yaw)
    y = np.concatenate(([0.0], np.cumsum(v * np.sin(middle) * h)))[:-1] + car.point * np.sin(yaw)
    return np.column_stack([x, y, yaw])[::substeps]


def log(
    kind: str,
    car: Car,
    seed: int = 0,
    *,
    dt: float = 0.05,
    noise: float = 1.0,
    pose_rate: float | None = None,
    digits: int | None = None,
    ahead: bool = False,
) -> Columns:
    """Give the columns of a log; poses come at `pose_rate` [Hz] and repeat until the next one.

    With `ahead` the driver is that of `pursued`.
    """
    random = np.random.default_rng(seed)
    if ahead:
        t, speed, steer, pose = pursued(kind, car, dt, random)
    else:
        t, speed, steer = commands(kind, car, dt, random)
        pose = driven(car, t, speed, steer)
    size = min(car.length / 2.7, 1.0)
    sizes = (0.02 * size, 0.02 * size, 0.002)
    if pose_rate is not None:
        # Of a clock of its own; the noise is that of a sample.
        own = np.arange(0.0, t[-1], 1.0 / pose_rate)
        samples = np.array([np.interp(own, t, values) for values in pose.T])
        samples += noise * random.standard_normal(samples.shape) * np.reshape(sizes, (3, 1))
        pose = samples.T[np.searchsorted(own, t + 1e-9, side="right") - 1]
    else:
        pose += noise * random.standard_normal(pose.shape) * sizes
    speed = speed + noise * 0.02 * size * random.standard_normal(len(t))
    columns = [pose[:, 0], pose[:, 1], pose[:, 2], speed, steer]
    if digits is not None:
        columns = [np.round(values, digits) for values in columns]
    return dict(zip(("t", "x", "y", "yaw", "speed", "steer"), [t, *columns], strict=True))


def with_play(car: Car, degrees: float) -> Car:
    """Give the car with play."""
    return replace(car, play=math.radians(degrees))


def stops(
    car: Car,
    seed: int = 0,
    *,
    starts: int = 3,
    dt: float = 0.05,
    substeps: int = 10,
    hills: float = 0.0,
) -> Columns:
    """Give the log of a car that starts and stops, straight on: pedals, and the height.

    `hills` is the steepest slope. Throttle and brake are pressed in steps, as a driver does.
    """
    random = np.random.default_rng(seed)
    throttle: list[float] = []
    brake: list[float] = []
    for _ in range(starts):
        for pedal, level, seconds in (
            (throttle, random.uniform(0.4, 0.8), random.uniform(2.5, 4.0)),
            (throttle, random.uniform(0.1, 0.3), random.uniform(1.5, 3.0)),
            (brake, random.uniform(0.2, 0.5), 6.0),
            (brake, 0.3, 1.0),
        ):
            count = round(seconds / dt)
            pedal.extend([level] * count)
            (brake if pedal is throttle else throttle).extend([0.0] * count)
    t = dt * np.arange(len(throttle))
    h, speed, pull, x = dt / substeps, 0.0, 0.0, 0.0
    rows = np.empty((len(t), 3))
    whole = round(car.drive_delay / h)
    for k in range(len(t) * substeps):
        slope = hills * math.sin(x / 15.0)
        if k % substeps == 0:
            rows[k // substeps] = x, speed, 15.0 * hills * (1.0 - math.cos(x / 15.0))
        late = max(k - whole, 0) // substeps
        wanted = car.throttle * throttle[late] - car.braking * brake[late] if k >= whole else 0.0
        begun, before = pull, speed
        pull = wanted + (pull - wanted) * math.exp(-h / car.drive_lag)
        mean = 0.5 * (begun + pull) - car.drag * speed - 9.80665 * slope
        speed = max(speed + mean * h, 0.0)
        x += 0.5 * (before + speed) * h
    noise = random.standard_normal((len(t), 5)) * (0.02, 0.02, 0.002, 0.02, 0.01)
    columns = (rows[:, 0], 0.0 * t, 0.0 * t, rows[:, 1], rows[:, 2])
    x, y, yaw, v, z = (values + each for values, each in zip(columns, noise.T, strict=True))
    pedals = {"throttle": np.array(throttle), "brake": np.array(brake), "z": z}
    return {"t": t, "x": x, "y": y, "yaw": yaw, "speed": v, "steer": 0.0 * t, **pedals}


def main() -> None:
    """Write the logs that docs/identify.md shows: of lines, of three stops, of a gentle drive."""
    car = Car(rate=0.4)
    t = 0.05 * np.arange(1200)
    bend = 0.04 * np.sin(0.25 * t) - car.offset
    pose = driven(car, t, 0.0 * t + 8.0, bend)
    pose += np.random.default_rng(1).standard_normal(pose.shape) * (0.02, 0.02, 0.002)
    gentle = {"t": t, **dict(zip(("x", "y", "yaw"), pose.T, strict=True))}
    gentle |= {"speed": 0.0 * t + 8.0, "steer": bend}
    logs = {"lines": log("lines", car, 1), "stops": stops(car, 1), "gentle": gentle}
    for name, columns in logs.items():
        rows = np.column_stack(list(columns.values()))
        np.savetxt(f"{name}.csv", rows, "%.6g", ",", header=",".join(columns), comments="")


if __name__ == "__main__":
    main()
