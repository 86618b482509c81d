"""The formulas of the shipped tracks, under their names."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from popsteer.ranges import check_known
from popsteer.tracks.geometry import Sampled, build, equal_steps, lemniscate, sample, straight, turn
from popsteer.tracks.manoeuvres import double_lane_change, obstacle_avoidance, step_steer

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.tracks.track import Track


def names() -> tuple[str, ...]:
    """Names of the shipped tracks.

    Returns
    -------
    tuple of str
        The names that `get` knows, the race track first.

    Examples
    --------
    >>> names()
    ('racetrack', 'straight', 'circle', 'figure-eight', 'slalom', 'step-steer', \
'double-lane-change', 'obstacle-avoidance')
    """
    return tuple(_MAKERS)


def get(name: str) -> Track:
    """Give a shipped track.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    Track
        The track; the same object each time.

    Raises
    ------
    ConfigError
        No track has this name.

    Examples
    --------
    >>> get("circle").closed
    True
    >>> get("monaco")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown track 'monaco'; known: racetrack, straight, circle, \
figure-eight, slalom, step-steer, double-lane-change, obstacle-avoidance
    """
    check_known("track", name, _MAKERS)
    return _made(name)


@cache
def _made(name: str) -> Track:
    return _MAKERS[name](name)


def _racetrack(name: str) -> Track:
    """Make one lap of a circuit, from its start line to 23 m before it."""
    pieces = [
        *straight(150.0),  # start and finish
        *turn(95.0, 42.0, 24.0),
        *straight(22.0),
        *turn(-85.0, 55.0, 26.0),
        *straight(40.0),
        # Hairpin. The centimetre keeps also a curvature estimated from waypoints below 1/25 m.
        *turn(200.0, 25.01, 20.0),
        *straight(75.0),
        *turn(-60.0, 27.0, 14.0),  # chicane, right ...
        *straight(4.0),
        *turn(60.0, 27.0, 14.0),  # ... and left
        *straight(60.0),
        *turn(-70.0, 60.0, 26.0),
        # This straight and the next but one bring the lap back to the line of the first.
        *straight(72.46),
        *turn(130.0, 38.0, 24.0),
        *straight(85.54),
        *turn(90.0, 60.0, 30.0),
        *straight(37.2),
    ]
    return build(
        name,
        "Race track, one lap of 1273 m",
        "A left-handed circuit with a start straight, sweepers to both sides, a hairpin of 25 m"
        " radius at the end of a neck, a right-left chicane and a long back section. Clothoids"
        " join straights and arcs, so the curvature is continuous. The path ends on the start"
        " straight, 23 m before it would close.",
        sample(pieces, 1274),
    )


def _straight(name: str) -> Track:
    return build(
        name,
        "Straight line, 200 m",
        "The x axis. Shows how a controller takes up an offset, and nothing else.",
        sample(straight(200.0), 201),
    )


def _circle(name: str) -> Track:
    radius, count = 50.0, 314
    angle = np.arange(count) * (2.0 * math.pi / count)
    xy = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    return build(
        name,
        "Circle of 50 m radius",
        "Constant curvature to the left, at constant speed. Shows the error that a controller"
        " keeps in a steady bend.",
        Sampled(xy, np.full(count, 1.0 / radius), 2.0 * math.pi * radius / count),
        closed=True,
    )


def _figure_eight(name: str) -> Track:
    return build(
        name,
        "Figure of eight, lemniscate of Bernoulli",
        "Two loops of 27 m least radius, one to each side, that cross at a right angle. Shows"
        " whether a tracker holds on to its branch where the path crosses itself.",
        lemniscate(80.0),
        closed=True,
    )


def _slalom(name: str) -> Track:
    amplitude, wavelength, waves = 3.0, 60.0, 5
    k = 2.0 * math.pi / wavelength

    fine = np.linspace(0.0, waves * wavelength, 100_001)
    x, step = equal_steps(np.column_stack((fine, amplitude * np.sin(k * fine))), fine)
    slope = amplitude * k * np.cos(k * x)
    return build(
        name,
        "Slalom, five waves of 60 m",
        "A sine of 3 m amplitude: bends of 30 m least radius, left and right in turn.",
        Sampled(
            np.column_stack((x, amplitude * np.sin(k * x))),
            -amplitude * k * k * np.sin(k * x) / (1.0 + slope * slope) ** 1.5,
            step,
        ),
    )


_MAKERS: dict[str, Callable[[str], Track]] = {
    "racetrack": _racetrack,
    "straight": _straight,
    "circle": _circle,
    "figure-eight": _figure_eight,
    "slalom": _slalom,
    "step-steer": step_steer,
    "double-lane-change": double_lane_change,
    "obstacle-avoidance": obstacle_avoidance,
}
