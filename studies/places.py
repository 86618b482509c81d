"""Drives in which a vehicle could lose its place on the path, or its time: how many go wrong.

    python -m studies.places 500

drives so many of each kind, each with a vehicle, a path and numbers of its own.
"""

from __future__ import annotations

import math
import sys
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import popsteer
from popsteer.tracks.cusps import parallel_parking, three_point_turn

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

PERIOD = 0.05
"""Of the control of a car [s]."""
CAR = 2.7
"""The wheelbase that lengths are scaled from [m]."""
LAWS = ("PreviewPop", "Stanley", "PurePursuit", "Pop", "Pid")


class Drive(NamedTuple):
    """What a drive came to."""

    wrong: bool
    said: str
    """The vehicle, the numbers, and how far off it was."""


class Car:
    """A bicycle whose wheels have a dead time and a lag; its speed is commanded."""

    def __init__(
        self, told: popsteer.Vehicle, dead_time: float, brakes: float, step: float = 0.1 * PERIOD
    ) -> None:
        self.wheelbase, self.lag, self.brakes = told.wheelbase, told.steer_lag, brakes
        self.step = step
        self.flight = deque([0.0] * round(dead_time / step))
        self.x = self.y = self.yaw = self.speed = self.wheel = 0.0

    def advance(self, steer: float, speed: float, steps: int = 10) -> None:
        """Drive on for so many steps."""
        for _ in range(steps):
            self.flight.append(steer)
            self.wheel += (self.flight.popleft() - self.wheel) * self.step / self.lag
            most = self.step * self.brakes
            self.speed += max(-most, min(most, speed - self.speed))
            way = self.step * self.speed
            self.x += way * math.cos(self.yaw)
            self.y += way * math.sin(self.yaw)
            self.yaw += way * math.tan(self.wheel) / self.wheelbase


def size(draw: np.random.Generator) -> float:
    """Draw a wheelbase [m]: a toy's to a truck's."""
    return float(np.exp(draw.uniform(math.log(0.16), math.log(12.0))))


def loops(draw: np.random.Generator, wheelbase: float) -> NDArray[np.float64]:
    """Draw three laps of a circle or of a figure of eight, in one open path that begins at 0."""
    radius = draw.uniform(7.0, 12.0) * wheelbase
    turn = np.arange(0.0, 3.0 * math.tau, draw.uniform(0.15, 0.4) * wheelbase / radius)
    if draw.random() < 0.5:
        return np.column_stack((radius * np.sin(turn), radius * (1.0 - np.cos(turn))))
    slow = turn / 2.0
    return 2.0 * radius * np.column_stack((np.sin(slow), 0.5 * np.sin(2.0 * slow)))


def laps(seed: int) -> Drive:
    """Drive three laps in one path; dead time and lag are told wrong by up to a fifth.

    Wrong if the distance to the stop is ever that of another lap or place: off by more than 1 m of
    a car's, besides how far the car is from the path.
    """
    draw = np.random.default_rng(seed)
    wheelbase = size(draw)
    scale = wheelbase / CAR
    clean = loops(draw, wheelbase)
    noise = draw.uniform(0.0, 0.05) * min(scale, 1.0)
    dead_time, lag = draw.uniform(0.0, 0.3), draw.uniform(0.02, 0.2)
    told = popsteer.Vehicle(
        wheelbase=wheelbase,
        max_steer=0.6,
        dead_time=dead_time * draw.uniform(0.8, 1.2),
        steer_lag=lag * draw.uniform(0.8, 1.2),
    )
    every = int(draw.choice([0, 2, 10]))

    def path() -> popsteer.Path:
        return popsteer.Path(clean + draw.normal(0.0, noise, clean.shape))

    law = str(draw.choice(LAWS))
    driven = path()
    controller = getattr(popsteer, law)(driven, told)
    tracker = popsteer.SpeedTracker(driven, told)
    car = Car(told.replace(steer_lag=lag), dead_time, 10.0 * scale)
    car.yaw = math.atan2(*(clean[1] - clean[0])[::-1])
    car.speed = min(2.5 * wheelbase, math.sqrt(1.5 * wheelbase * 6.0), 15.0)
    place, worst = 0, 0.0
    last = len(clean) - math.ceil(8.0 * wheelbase / math.dist(*clean[:2]))
    while place < last:
        if every and draw.integers(every) == 0:
            driven = path()
            controller.set_path(driven)
            tracker.set_path(driven)
        at = np.array([car.x, car.y])
        window = clean[place : place + 60]
        off = np.hypot(*(window - at).T)
        place += int(off.argmin())
        measured = (*(at + draw.normal(0.0, noise, 2)), car.yaw, car.speed, PERIOD)
        command, pace = controller.step(*measured), tracker.step(*measured)
        rest = float(driven.s[-1] - driven.s[place])
        for given in (command.distance_to_stop, pace.distance_to_stop):
            worst = max(worst, abs(given - rest) - float(off.min()))
        car.advance(command.steer, car.speed)
        if off.min() > 3.0 * wheelbase:  # that controller cannot keep to the path with this delay
            break
    said = f"{law}, {wheelbase:.2f} m, sent every {every}: {worst:.2f} m off along the path"
    return Drive(worst > 0.4 * wheelbase + math.dist(*clean[:2]), said)


def manoeuvre(draw: np.random.Generator, scale: float) -> popsteer.Path:
    """Draw a path with cusps: out and back, a turn in three points, parallel parking."""
    kind = draw.integers(3)
    if kind == 0:
        out = np.arange(0.0, draw.uniform(15.0, 30.0), 0.5)
        x = np.concatenate((out, out[-2::-1]))
        reverse = np.arange(len(x)) >= len(out) - 1
        xy = scale * np.column_stack((x, np.zeros(len(x))))
        speed = 2.0 * math.sqrt(scale) * np.ones(len(x))
        return popsteer.Path(xy, speed=np.where(reverse, -speed, speed))
    made: Any = three_point_turn() if kind == 1 else parallel_parking()
    return popsteer.Path(scale * made.xy, speed=math.sqrt(scale) * made.speed)


def remaining(path: popsteer.Path) -> list[tuple[bool, float, NDArray[np.float64]]]:
    """Return of each leg: its direction, the arc where it ends [m], and its waypoints."""
    flags = path.reverse if path.reverse is not None else np.zeros(len(path), dtype=bool)
    ends = [*(k for k in range(1, len(path) - 1) if flags[k] != flags[k - 1]), len(path) - 1]
    starts = [0, *ends[:-1]]
    xy = np.column_stack((path.x, path.y))
    return [
        (bool(flags[a]), float(path.s[b]), xy[a : b + 1]) for a, b in zip(starts, ends, strict=True)
    ]


def cusps(seed: int) -> Drive:
    """Drive a manoeuvre to its end by a controller's gear, speed and distance to the stop alone.

    Wrong if gear and distance ever are of two legs, or if the end is missed by 0.1 m: of a vehicle
    shorter than 0.7 m by 0.15 wheelbases, of one longer than a car by as much more.
    """
    draw = np.random.default_rng(seed)
    wheelbase = size(draw)
    scale = wheelbase / CAR
    path = manoeuvre(draw, scale)
    # A small vehicle is as quick as gravity makes it (Froude): times are those of a car, scaled.
    quick = min(1.0, math.sqrt(scale))
    dead_time, brakes = draw.uniform(0.0, 0.3) * quick, draw.uniform(0.5, 3.0)
    period = PERIOD * quick
    told = popsteer.Vehicle(
        wheelbase=wheelbase,
        max_steer=0.6,
        dead_time=dead_time if draw.random() < 0.5 else 0.0,
        steer_lag=0.1 * quick,
    )
    # Manoeuvres bend at once: their curvature is not to be smoothed over most of a wheelbase.
    tuning = popsteer.PreviewPopParams(min_speed=math.sqrt(scale), smoothing_length=0.5 * scale)
    controller = popsteer.PreviewPop(path, told, tuning)
    car = Car(told, dead_time, brakes * scale, 0.1 * period)
    legs = remaining(path)
    leg, apart, near = 0, 0.0, 0.02 * scale
    for _ in range(4000):
        command = controller.step(car.x, car.y, car.yaw, car.speed, period)
        leg += command.reverse != legs[leg][0] and leg + 1 < len(legs)
        xy = legs[leg][2]
        closest = int(np.hypot(*(xy - [car.x, car.y]).T).argmin())
        behind = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
        rest = command.distance_to_stop
        apart = max(apart, abs(rest - (behind[-1] - behind[closest])))
        gear = -1.0 if command.reverse else 1.0
        most = math.sqrt(0.5 * brakes * scale * max(rest, 0.0))
        speed = min(abs(command.reference_speed or 0.0), most)
        if rest < near or gear * car.speed < -0.05 * math.sqrt(scale):
            speed = 0.0
        if rest < near and abs(car.speed) < 0.02 * scale and leg + 1 == len(legs):
            break
        car.advance(command.steer, gear * speed)
    missed = math.dist((car.x, car.y), legs[-1][2][-1])
    said = f"{wheelbase:.2f} m, dead time {dead_time:.2f} s, told {told.dead_time:.2f}, "
    said += f"brakes {brakes:.1f} m/s²; of a car's size: ends {missed / scale:.2f} m off, "
    said += f"gear and distance {apart / scale:.1f} m apart"
    return Drive(missed > 0.1 * max(min(1.0, 1.5 * wheelbase), scale) or apart > 1.5 * scale, said)


def corrections(seed: int) -> Drive:
    """Correct the localisation by 0.05 to 3 wheelbases: on a leg of a path out and back, in a lap.

    Wrong if the controller drives the other way afterwards, or if the distance to the stop is not
    the corrected one within a second and a half.
    """
    draw = np.random.default_rng(seed)
    wheelbase = size(draw)
    jump = draw.uniform(0.05, 3.0) * wheelbase * draw.choice([-1.0, 1.0])
    law = str(draw.choice(LAWS))
    told = popsteer.Vehicle(wheelbase=wheelbase, dead_time=float(draw.choice([0.0, 0.1, 0.2])))
    along = draw.uniform(0.5, 1.0)  # of it along the path, the rest aside
    ahead, aside = along * jump, (1.0 - along) * jump
    speed = wheelbase
    if draw.random() < 0.5:
        return _correct_on_legs(law, told, (ahead, aside), speed, draw)
    radius = 8.0 * wheelbase
    spacing = 0.2 * wheelbase
    turn = np.arange(0.0, 3.0 * math.tau, spacing / radius)
    xy = radius * np.column_stack((np.sin(turn), 1.0 - np.cos(turn)))
    path = popsteer.Path(xy)
    controller = getattr(popsteer, law)(path, told)
    arc, shift, worst = 0.0, 0.0, 0.0
    when = draw.uniform(0.3, 2.5) * math.tau * radius
    corrected = 0
    while arc < when + 60.0 * speed * PERIOD:
        if arc >= when:
            shift, corrected = ahead, corrected + 1
        angle, out = (arc + shift) / radius, aside if corrected else 0.0
        x, y = (radius - out) * math.sin(angle), radius - (radius - out) * math.cos(angle)
        command = controller.step(x, y, angle, speed, PERIOD)
        if not 0 < corrected < 30:
            worst = max(worst, abs(command.distance_to_stop - (path.s[-1] - arc - shift)))
        arc += speed * PERIOD
    said = f"{law}, {wheelbase:.2f} m, lap, {jump / wheelbase:+.2f} wheelbases: {worst:.2f} m off"
    return Drive(worst > 0.5 * wheelbase, said)


def _correct_on_legs(
    law: str,
    told: popsteer.Vehicle,
    jump: tuple[float, float],
    speed: float,
    draw: np.random.Generator,
) -> Drive:
    wheelbase = told.wheelbase
    out = np.arange(0.0, 20.0 * wheelbase, 0.2 * wheelbase)
    x = np.concatenate((out, out[-2::-1]))
    reverse = np.arange(len(x)) >= len(out) - 1
    path = popsteer.Path(np.column_stack((x, np.zeros(len(x)))), reverse=reverse)
    controller = getattr(popsteer, law)(path, told)
    end = float(out[-1])
    on_the_way_back = bool(draw.random() < 0.5)
    place, v, corrected, wrong, worst = end - 12.0 * wheelbase, speed, 0, False, 0.0
    if not on_the_way_back:
        place = 4.0 * wheelbase
    where = draw.uniform(8.0, 12.0) * wheelbase
    for _ in range(2000):
        is_back = v < 0.0
        if is_back == on_the_way_back and (place < where if is_back else place > where):
            corrected += 1
        ahead, aside = jump if corrected else (0.0, 0.0)
        command = controller.step(place + ahead, aside, 0.0, v, PERIOD)
        if command.reverse and not is_back and not corrected:
            v = -speed
        elif command.reverse != is_back:
            wrong = True
        if corrected >= 30:
            rest = place + ahead if is_back else end - place - ahead
            worst = abs(command.distance_to_stop - rest)
            break
        place += v * PERIOD
    said = f"{law}, {wheelbase:.2f} m, {'back' if on_the_way_back else 'out'}, "
    said += f"{math.hypot(*jump) / wheelbase:.2f} wheelbases: wrong way {wrong}, {worst:.2f} m off"
    return Drive(wrong or worst > 0.5 * wheelbase or corrected < 30, said)


def clocks(seed: int) -> Drive:
    """Give a drive the stamps of a clock that is coarse, or leaps once forward or back.

    Wrong if it is farther off the path than with even stamps by more than a tenth of a wheelbase,
    or if it says more than one fault that it does not say with those.
    """
    draw = np.random.default_rng(seed)
    wheelbase = size(draw)
    scale = wheelbase / CAR
    kind = int(draw.integers(3))
    period = PERIOD * float(draw.choice([0.2, 0.5, 1.0]))
    tick = period * float(draw.integers(2, 4))
    leap = float(10.0 ** draw.uniform(-3.0, 5.0)) * (1.0 if kind == 1 else -1.0)
    when = draw.uniform(5.0, 8.0)
    told = popsteer.Vehicle(wheelbase=wheelbase, dead_time=0.15, max_steer=0.6, max_steer_rate=0.6)
    law = str(draw.choice(LAWS))
    x = np.arange(0.0, 120.0, 0.5)
    xy = scale * np.column_stack((x, 3.0 * np.sin(x / 12.0)))

    def off(stamp: Callable[[float], float]) -> tuple[float, int]:
        controller = getattr(popsteer, law)(popsteer.Path(xy), told)
        car = Car(told, 0.15, 10.0, 0.1 * period)
        car.yaw, car.speed = 0.24, 3.0 * wheelbase / max(1.0, math.sqrt(scale))
        last, worst, faults = -period, 0.0, 0
        for k in range(round(12.0 / period)):
            now = stamp(k * period)
            dt, last = now - last, now
            command = controller.step_or_hold(car.x, car.y, car.yaw, car.speed, dt)
            faults += command.status.level == "fault"
            worst = max(worst, float(np.hypot(*(xy - [car.x, car.y]).T).min()))
            car.advance(command.steer, car.speed)
        return worst, faults

    even, usual = off(lambda now: now)
    stamps: list[Callable[[float], float]] = [
        lambda now: tick * math.floor(now / tick + 1e-9),
        *2 * [lambda now: now + (leap if now > when else 0.0)],
    ]
    found, faults = off(stamps[kind])
    how = f"ticks of {tick:.3f} s" if kind == 0 else f"leaps by {leap:+.3g} s"
    said = (
        f"{law}, {wheelbase:.2f} m, {period:.3f} s, {how}: {found:.2f} m off, {even:.2f} evenly, "
    )
    said += f"{faults} faults, {usual} evenly"
    return Drive(found > even + 0.1 * wheelbase or faults > usual + 1, said)


KINDS: dict[str, Callable[[int], Drive]] = {
    "laps": laps,
    "cusps": cusps,
    "corrections": corrections,
    "clocks": clocks,
}


def wrong(kind: str, count: int) -> list[str]:
    """Drive so often, and say what went wrong."""
    drives = (KINDS[kind](seed) for seed in range(count))
    return [drive.said for drive in drives if drive.wrong]


def main() -> None:
    """Drive each kind, and print how many went wrong."""
    count, *kinds = sys.argv[1:]
    for kind in kinds or KINDS:
        found = wrong(kind, int(count))
        print(f"{kind}: {len(found)} of {count} wrong", *found[:20], sep="\n  ")


if __name__ == "__main__":
    main()
