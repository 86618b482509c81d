"""The scenarios of the suite and the conditions that they are driven under."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from popsteer import tracks
from popsteer._core import KinematicBicycle, Path, Vehicle
from popsteer.tracks.geometry import sample, straight, turn


def suite_car() -> KinematicBicycle:
    """Give the suite's own car: 2.7 m, wheels with a lag of 0.1 s that turn by 0.8 rad/s at most.

    Examples
    --------
    >>> suite_car().vehicle.max_steer_rate
    0.8
    """
    wheels: Any = {"max_steer": 0.6, "max_steer_rate": 0.8, "steer_lag": 0.1}
    size: Any = {"wheelbase": 2.7, "rear_axle": -1.35}
    return KinematicBicycle(Vehicle(**size, **wheels, drive_lag=0.2, steers_at_rest=True))


@dataclass(frozen=True)
class Scenario:
    """A path, and how it is driven: planned at 4 m/s² of lateral acceleration up to a speed."""

    title: str
    """What a reader recognises."""
    path: Callable[[], Path]
    """Makes what is followed: with tangents, so that all see one curve and errors are from it."""
    max_speed: float
    """Speed that is planned at most [m/s]."""
    start_offset: float = 0.0
    """How far to the left of the path the front axle starts [m]."""
    rolling: bool = True
    """Whether it begins at the planned speed, not at rest."""
    plant: Mapping[str, float] = field(default_factory=dict)
    """Fields of the plant that differ; the controllers are told."""


def _shipped(name: str) -> Path:
    track = tracks.get(name)
    return Path(track.xy, closed=track.closed, yaw="spline")


def _hairpin() -> Path:
    """Two straights of 40 m, joined by a half turn of 7 m radius behind clothoids of 6 m."""
    pieces = [*straight(40.0), *turn(180.0, 7.0, 6.0), *straight(40.0)]
    length = 80.0 + math.pi * 7.0 + 6.0
    return Path(sample(pieces, round(length / 0.5) + 1).xy, yaw="spline")


def arcs(
    pieces: Iterable[tuple[bool, float, float]],
) -> tuple[list[tuple[float, float, float]], list[bool]]:
    """Poses every 0.2 m along arcs from the origin [m, m, rad], and which are driven backwards.

    A piece says whether it is, its curvature to the left [1/m] and its length [m].
    """
    x = y = yaw = 0.0
    poses, reverse = [(x, y, yaw)], []
    for backwards, curvature, length in pieces:
        count = round(length / 0.2)
        step = (-length if backwards else length) / count
        for _ in range(count):
            half = 0.5 * step * curvature
            chord = step * float(np.sinc(half / math.pi))
            x, y = x + chord * math.cos(yaw + half), y + chord * math.sin(yaw + half)
            yaw += 2.0 * half
            poses.append((x, y, yaw))
            reverse.append(backwards)
    return poses, [*reverse, reverse[-1]]


def _bay() -> Path:
    """Past a bay and backwards into it: a bend of 90 degrees and 7 m, drawn as line and arcs."""
    poses, reverse = arcs(((False, 0.0, 6.0), (True, 1.0 / 7.0, 3.5 * math.pi), (True, 0.0, 4.0)))
    return Path([(x, y) for x, y, _ in poses], reverse=reverse, yaw="spline")


def _zigzag() -> Path:
    """Corners 50 m along and 30 m aside, with a waypoint a metre."""
    corners = np.array([(50.0 * k, 30.0 * (k % 2)) for k in range(6)])
    legs: list[NDArray[np.float64]] = []
    for start, end in itertools.pairwise(corners):
        count = int(np.hypot(*(end - start)))
        legs.append(start + np.arange(count)[:, None] / count * (end - start))
    return Path(np.vstack((*legs, corners[-1:])))


def _straight() -> Path:
    x = np.arange(0.0, 121.0)
    return Path(np.column_stack((x, np.zeros(len(x)))))


_SLOW: dict[str, Any] = {"max_steer_rate": 0.4, "steer_lag": 0.15}

SCENARIOS: dict[str, Scenario] = {
    "double-lane-change": Scenario(
        "Double lane change (ISO 3888-1)", lambda: _shipped("double-lane-change"), 15.0
    ),
    "obstacle-avoidance": Scenario(
        "Obstacle avoidance (ISO 3888-2)", lambda: _shipped("obstacle-avoidance"), 12.0
    ),
    "step-steer": Scenario("Step steer (ISO 7401)", lambda: _shipped("step-steer"), 12.0),
    "slalom": Scenario("Slalom", lambda: _shipped("slalom"), 10.0),
    "hairpin": Scenario("Hairpin of 7 m", _hairpin, 12.0),
    "racetrack": Scenario("Race track", lambda: _shipped("racetrack"), 25.0),
    "parking-bay": Scenario("Parking bay", _bay, 2.0, rolling=False),
    "zigzag": Scenario("Zigzag of corners", _zigzag, 10.0),
    "beside": Scenario("2 m beside, slow wheels", _straight, 8.0, 2.0, plant=_SLOW),
}
"""The scenarios of standard-2, by name."""


@dataclass(frozen=True)
class Condition:
    """What differs from a car that is as told and sensors that are exact."""

    title: str
    """What a reader recognises."""
    plant: Mapping[str, float] = field(default_factory=dict)
    """Fields of the plant that differ."""
    is_told: bool = True
    """Whether the controllers are told of these."""
    wheelbase: float = 1.0
    """The wheelbases that the controllers are told, as shares of the true ones."""
    position: float = 0.0
    """Noise of x and of y, standard deviation [m]."""
    yaw: float = 0.0
    """Noise of the heading [rad]."""
    path: float = 0.0
    """Noise of the waypoints of a path that is fresh every cycle [m]; 0: one path for all."""
    smoothed: bool = False
    """Whether all controllers get those waypoints smoothed, by the same local quadratics."""
    loss: float = 0.0
    """Share of the cycles in which no pose arrives."""
    play: float = 0.0
    """Play of the steering, from side to side [rad]."""
    grade: float = 0.0
    """Slope of the road along the path; nobody is told."""


_LATE = {"dead_time": 0.15}

CONDITIONS: dict[str, Condition] = {
    "as told": Condition("As told"),
    "dead time told": Condition("Dead time of 0.15 s, told", plant=_LATE),
    "dead time untold": Condition("Dead time of 0.15 s, not told", plant=_LATE, is_told=False),
    "noise": Condition("Noise of 5 cm and 0.01 rad", position=0.05, yaw=0.01),
    "play": Condition("Play of 1°", play=0.017453292519943295),
    "fresh path": Condition("A fresh path each cycle, 2 cm of noise", path=0.02),
    "smoothed path": Condition("... smoothed alike for all", path=0.02, smoothed=True),
    "loss": Condition("A fifth of the poses lost", loss=0.2),
    "wheelbase +20 %": Condition("Told a wheelbase 20 % too long", wheelbase=1.2),
    "wheelbase -20 %": Condition("Told a wheelbase 20 % too short", wheelbase=0.8),
    "slope": Condition("Slope of 8 %, not told", grade=0.08),
}
"""The conditions of standard-2, by name."""
