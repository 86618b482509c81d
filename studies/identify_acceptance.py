"""Whether what `identify` states holds: drives of cars that share no code with popsteer.

    python -m studies.identify_acceptance [N]

N drives of each of twelve kinds (`studies.logged`): how many 95 % intervals contain the truth, and
how many stated values lie beyond three errors: the table of docs/identify.md. And by how much the
delay is off where poses repeat and where the steering has play. A test of tests/unit runs it with a
few.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import popsteer
from popsteer.logs import Log, LogError
from popsteer.sim import PedalMap
from studies import logged
from studies.layout import line, write_table

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.identification import Identification

KINDS: tuple[tuple[str, dict[str, Any]], ...] = (
    *((kind, {}) for kind in logged.KINDS),
    ("lines", {"pose_rate": 5.0}),
    ("blocks", {"play": 1.0, "ahead": True}),
    ("brisk", {"play": 0.5}),
    ("laps", {"noise": 2.0}),
    ("brisk", {"rate": math.inf}),
)
"""A drive, and what is otherwise: poses that repeat [Hz], play [degrees], a driver who looks ahead,
more noise, no limit."""

_OF_THE_LOG = ("pose_rate", "noise", "digits", "ahead", "dt")


class Stated(NamedTuple):
    """A value that was stated, and the truth."""

    name: str
    value: float
    error: float
    truth: float

    @property
    def off(self) -> float:
        """By how many errors it is off."""
        return abs(self.value - self.truth) / self.error


def car_of(seed: int, **changes: Any) -> logged.Car:
    """Draw a car, with play in degrees."""
    play = math.radians(changes.pop("play", 0.0))
    return replace(logged.drawn(np.random.default_rng(1000 + seed)), play=play, **changes)


def identified(
    kind: str, seed: int, *, steps: float = 0.0, **changes: Any
) -> tuple[logged.Car, Identification | None]:
    """Identify a drawn car from a drive whose log rounds steer; None where the log is refused."""
    own = {key: changes.pop(key) for key in _OF_THE_LOG if key in changes}
    car = car_of(seed, **changes)
    columns = logged.log(kind, car, seed, **own)
    if steps:
        columns["steer"] = steps * np.round(columns["steer"] / steps)
    try:
        return car, popsteer.identify(Log(**columns))
    except LogError:
        return car, None


def stated(car: logged.Car, found: Identification) -> list[Stated]:
    """Set what was stated beside the truth."""
    truth = {
        "wheelbase": car.length,
        "understeer": car.understeer,
        "steer_offset": car.offset,
        "steer_lag": car.lag,
        "dead_time": car.delay,
        "max_steer_rate": car.rate,
        "steer_play": car.play,
        "rear_axle": -car.point,
    }
    values = {
        **found.vehicle.as_dict(),
        "delay": found.delay,
        "turning_length": found.turning_length,
    }
    values["steer_play"] = found.fit.values.get("steer_play", 0.0)
    errors = {**found.errors, "delay": found.delay_error}
    errors["turning_length"] = found.turning_length_error
    truth["delay"] = car.lag + car.delay
    truth["turning_length"] = car.length + car.understeer * found.speed**2
    return [
        Stated(name, values[name], math.hypot(error, found.model_errors[name]), truth[name])
        for name, error in errors.items()
        if name in truth
    ]


def shares(each: Iterable[Stated]) -> tuple[float, float, int]:
    """Give the share within 1.96 errors, the share beyond three, and of how many."""
    off = np.array([one.off for one in each])
    return float(np.mean(off < 1.96)), float(np.mean(off > 3.0)), len(off)


def delay_off(kind: str, seeds: Iterable[int], **changes: Any) -> float:
    """Give by how much the delay is off at most [s], of those that state one."""
    off = [0.0]
    for seed in seeds:
        car, found = identified(kind, seed, **changes)
        if found is not None and found.delay_error < 0.02:
            off.append(abs(found.delay - car.lag - car.delay))
    return max(off)


def pedalled(seed: int) -> logged.Car:
    """Draw a car with a drive."""
    random = np.random.default_rng(seed)
    drive = {
        "drive_delay": 0.005 * int(random.integers(10, 80)),
        "drive_lag": float(random.uniform(0.05, 0.5)),
        "throttle": float(random.uniform(2.0, 6.0)),
        "braking": float(random.uniform(4.0, 9.0)),
        "drag": float(random.uniform(0.02, 0.2)),
    }
    return replace(logged.drawn(random, float(random.uniform(0.5, 5.0))), **drive)


def drive_log(car: logged.Car, seed: int, **options: Any) -> Log:
    """Give the log of three stops and starts with throttle and brake."""
    columns = logged.stops(car, seed, **options)
    poses = {name: columns.pop(name) for name in ("t", "x", "y", "yaw", "speed", "steer")}
    return Log(**poses, signals=columns)


def beyond_stop(car: logged.Car, file: Path, seed: int, dt: float = 0.05) -> float:
    """Drive a straight path to its end with a vehicle file: how far beyond it the car rests [m]."""
    pedals, random = PedalMap.load(file), np.random.default_rng(seed)
    top = float(random.uniform(2.0, 4.0)) * min(car.length, 2.5)
    told = popsteer.Vehicle.load(file).replace(
        max_speed=top, max_acceleration=1.2, max_deceleration=1.5
    )
    # Poses are the rear axle's: what is driven is a line.
    end = max(10.0 * top, 10.0 * car.length)
    line_on = [(x, 0.0) for x in np.arange(0.0, end, 0.1 * car.length)]
    driver = popsteer.Driver(popsteer.Path(line_on), told.replace(rear_axle=0.0))
    h, at, speed, pull = 0.1 * dt, 0.0, 0.0, 0.0
    late = [0.0] * round(car.drive_delay / h)
    for _ in range(round(90.0 / dt)):
        noise = 0.005 * min(car.length, 1.0) * random.standard_normal(2)
        answer = driver.step(at + noise[0], 0.0, 0.0, speed + noise[1], dt=dt)
        throttle, brake = pedals(answer.acceleration, speed)
        brake = max(brake, 0.3) if answer.hold else brake
        for _ in range(10):
            late.append(car.throttle * throttle - car.braking * brake)
            wanted, before = late.pop(0), speed
            pull = wanted + (pull - wanted) * math.exp(-h / car.drive_lag)
            speed = max(speed + (pull - car.drag * speed) * h, 0.0)
            at += 0.5 * (before + speed) * h
        if answer.phase == "standing" and speed == 0.0:
            break
    return at - line_on[-1][0]


def main() -> None:
    """Print what is stated of all drives, put the table onto its page, and print the delays."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    everything: list[Stated] = []
    rows, drives = [], 0
    for kind, changes in KINDS:
        each = [identified(kind, seed, **changes) for seed in range(count)]
        pairs = [(car, found) for car, found in each if found is not None]
        those = [one for car, found in pairs for one in stated(car, found)]
        everything += those
        drives += len(pairs)
        own = (key if value is True else f"{key} {value:g}" for key, value in changes.items())
        words = ", ".join((kind, *own))
        rows.append(_row(words, those, len(pairs)))
        print(rows[-1], flush=True)
    rows.append(_row("all", everything, drives))
    print(rows[-1], flush=True)
    write_table("identify.md", "errors", rows)
    for name in dict.fromkeys(one.name for one in everything):
        those = [one for one in everything if one.name == name]
        print(_row(name, those, len(those)), flush=True)
    seeds = range(max(2, count // 10))
    for rate in (2.0, 3.0, 4.0, 7.0, 10.0):
        off = delay_off("brisk", seeds, pose_rate=rate)
        print(f"poses at {rate:g} Hz in rows of 20 Hz: the delay is off by {1e3 * off:.1f} ms")
    for play in (0.5, 1.0, 2.0):
        off = delay_off("blocks", seeds, play=play)
        print(f"play of {play:g} degrees: the delay is off by {1e3 * off:.1f} ms")
    file, stops = Path("car.toml"), []
    for seed in seeds:
        car = pedalled(seed)
        log = Log(**logged.log("brisk", car, seed))
        popsteer.identify(log, stops=drive_log(car, seed)).save(file)
        stops.append(abs(beyond_stop(car, file, seed)))
    print(f"a stop with the file of three stops and starts: {100.0 * max(stops):.1f} cm off")


def _row(name: str, those: list[Stated], drives: int) -> str:
    within, beyond, total = shares(those)
    return line(name, f"{100 * within:.1f} %", f"{100 * beyond:.1f} %", str(total), str(drives))


if __name__ == "__main__":
    main()
