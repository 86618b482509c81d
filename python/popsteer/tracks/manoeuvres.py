"""Standard manoeuvres whose dimensions can be changed.

The lane changes are *in the style of* ISO 3888-1 and ISO 3888-2: the lengths of their sections are
those commonly quoted from the standards, the rest is a choice stated with each parameter.
**No conformance with any standard is claimed.** The standards give lanes of cones, not a line to
follow; what line a test driver takes between them, from which edges the offset of the lanes is
measured, and where the last lane lies differ from one description to the next. Whoever needs the
standard's own figures takes them from the standard and passes them in.

The line through the lanes is straight in the middle of each, and between two lanes the polynomial
of least jerk in x: y = h (10 τ³ - 15 τ⁴ + 6 τ⁵) with τ = x / X, for a change by h over X. Its slope
and its curvature vanish at both ends, so the curvature of the whole line is continuous.

Examples
--------
>>> from popsteer.tracks.manoeuvres import double_lane_change
>>> wide = double_lane_change(offset=4.0)
>>> float(wide.xy[:, 1].max())
4.0
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from popsteer.errors import ConfigError
from popsteer.ranges import check_in_range
from popsteer.tracks.geometry import Piece, Sampled, build, equal_steps, sample, straight

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from popsteer.tracks.track import Track

_NO_CLAIM = "No conformance with the standard is claimed: its disputed dimensions are parameters."


def step_steer(
    name: str = "step-steer",
    *,
    run_up: float = 80.0,
    transition: float = 20.0,
    radius: float = 40.0,
    arc: float = 120.0,
) -> Track:
    """Lead from a straight through a clothoid onto a circle, and stay there.

    The curvature is 0 for `run_up`, grows linearly to 1/R over `transition`, and stays: what a
    steering wheel turned at a constant rate, then held, drives.

    Parameters
    ----------
    name : str, default "step-steer"
        What to call it.
    run_up : float, default 80.0
        Length of the straight [m].
    transition : float, default 20.0
        Length of the clothoid [m].
    radius : float, default 40.0
        Radius R of the circle [m]; negative to the right.
    arc : float, default 120.0
        Length driven on the circle [m].

    Returns
    -------
    Track
        Waypoints about 1 m apart, with reference speeds.

    Raises
    ------
    ConfigError
        A dimension is out of its range.

    Examples
    --------
    >>> track = step_steer(radius=-60.0)
    >>> track.xy[80].tolist(), bool(track.xy[-1, 1] < 0.0)
    ([80.0, 0.0], True)
    """
    for field, value in (("run_up", run_up), ("transition", transition), ("arc", arc)):
        check_in_range(field, value, 1.0, 1e4)
    check_in_range("radius", abs(radius), 2.0, 1e5)
    curvature = 1.0 / radius
    pieces = [
        *straight(run_up),
        Piece(transition, 0.0, curvature),
        Piece(arc, curvature, curvature),
    ]
    length = run_up + transition + arc
    return build(
        name,
        f"Step steer: straight, clothoid, circle of {abs(radius):g} m radius",
        f"A straight of {run_up:g} m, a clothoid of {transition:g} m, and {arc:g} m of the circle."
        " Shows how a controller takes up a bend, and the error that it then keeps.",
        sample(pieces, round(length) + 1),
    )


def double_lane_change(
    name: str = "double-lane-change",
    *,
    sections: Sequence[float] = (15.0, 30.0, 25.0, 25.0, 15.0, 15.0),
    offset: float = 3.5,
    return_offset: float = 0.0,
    run_up: float = 80.0,
    run_out: float = 40.0,
) -> Track:
    """Change to the lane on the left and back, in the style of ISO 3888-1.

    Parameters
    ----------
    name : str, default "double-lane-change"
        What to call it.
    sections : sequence of 6 float, default (15, 30, 25, 25, 15, 15)
        Lengths [m]: first lane, change, second lane, change back, third lane, exit lane.
    offset : float, default 3.5
        From the middle of the first lane to that of the second [m], positive to the left. Disputed:
        descriptions also measure it between edges of the lanes, whose widths differ.
    return_offset : float, default 0.0
        From the middle of the first lane to that of the third [m]. Disputed: 0 here, while lanes of
        growing width that share an edge would shift their middles.
    run_up, run_out : float
        Straights before and after [m], not part of the manoeuvre.

    Returns
    -------
    Track
        Waypoints about 1 m apart. The reference speed from the first to the last section is
        constant: the highest that the sharpest bend of the line allows.

    Raises
    ------
    ConfigError
        A dimension is out of its range.

    Examples
    --------
    >>> track = double_lane_change()
    >>> float(track.xy[-1, 0]), float(track.xy[:, 1].max())
    (245.0, 3.5)
    """
    return _lane_changes(
        name,
        "Double lane change in the style of ISO 3888-1",
        f"Into the lane {offset:g} m beside and back, at one speed. {_NO_CLAIM}",
        (6, sections),
        (offset, return_offset),
        (run_up, run_out),
    )


def obstacle_avoidance(
    name: str = "obstacle-avoidance",
    *,
    sections: Sequence[float] = (12.0, 13.5, 11.0, 12.5, 12.0),
    car_width: float = 1.8,
    gap: float = 1.0,
    return_offset: float = 0.0,
    run_up: float = 60.0,
    run_out: float = 40.0,
) -> Track:
    """Swerve round an obstacle and back, in the style of ISO 3888-2.

    The first lane is 1.1 b + 0.25 m wide and the second b + 1 m, for a car of width b, with a gap
    between their edges; their middles are half of both widths and the gap apart.

    Parameters
    ----------
    name : str, default "obstacle-avoidance"
        What to call it.
    sections : sequence of 5 float, default (12, 13.5, 11, 12.5, 12)
        Lengths [m]: first lane, change, second lane, change back, third lane.
    car_width : float, default 1.8
        Width b of the car [m]. Disputed: with or without its mirrors.
    gap : float, default 1.0
        From the left edge of the first lane to the right edge of the second [m]. Disputed: some
        descriptions give the offset of the middles instead.
    return_offset : float, default 0.0
        From the middle of the first lane to that of the third [m]. Disputed, as the third lane is
        wider: 0 here, half the difference of the widths where they share their right edge.
    run_up, run_out : float
        Straights before and after [m], not part of the manoeuvre.

    Returns
    -------
    Track
        Waypoints about 1 m apart. The reference speed from the first to the last section is
        constant: the highest that the sharpest bend of the line allows. A driver who uses the width
        of the lanes takes wider bends, and is faster.

    Raises
    ------
    ConfigError
        A dimension is out of its range.

    Examples
    --------
    >>> float(obstacle_avoidance().xy[:, 1].max())
    3.515
    """
    check_in_range("car_width", car_width, 0.1, 10.0)
    check_in_range("gap", gap, 0.0, 100.0)
    offset = 0.5 * (1.1 * car_width + 0.25) + gap + 0.5 * (car_width + 1.0)
    return _lane_changes(
        name,
        "Obstacle avoidance in the style of ISO 3888-2",
        f"A swerve of {offset:.2f} m and back, at one speed, on short sections: the sharpest of the"
        f" lane changes. {_NO_CLAIM}",
        (5, sections),
        (offset, return_offset),
        (run_up, run_out),
    )


def _lane_changes(
    name: str,
    title: str,
    description: str,
    lengths: tuple[int, Sequence[float]],
    offsets: tuple[float, float],
    run: tuple[float, float],
) -> Track:
    """Make the line through three lanes: there, second and fourth section, and back."""
    sections = list(lengths[1])
    if len(sections) != lengths[0]:
        raise ConfigError("sections", lengths[1], f"{lengths[0]} lengths")
    for section in sections:
        check_in_range("sections", section, 1.0, 1e4)
    for field, value in zip(("run_up", "run_out"), run, strict=True):
        check_in_range(field, value, 1.0, 1e4)
    for field, value in zip(("offset", "return_offset"), offsets, strict=True):
        check_in_range(field, value, -100.0, 100.0)
    begin = run[0]
    first = begin + sections[0]
    second = first + sections[1] + sections[2]
    end = begin + sum(sections)
    length = end + run[1]
    back = offsets[1] - offsets[0]
    changes = ((first, sections[1], offsets[0]), (second, sections[3], back))

    def curve(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        y, slope, bend = np.zeros((3, *x.shape))
        for start, stretch, offset in changes:
            tau = np.clip((x - start) / stretch, 0.0, 1.0)
            y += offset * tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)
            slope += offset / stretch * 30.0 * tau**2 * (1.0 - tau) ** 2
            bend += offset / stretch**2 * 60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau)
        return np.column_stack((x, y)), bend / (1.0 + slope**2) ** 1.5

    fine = np.linspace(0.0, length, 100_001)
    xy, curvature = curve(fine)
    x, step = equal_steps(xy, fine)
    sharpest = float(np.abs(curvature).max())
    limiting = np.where((x >= begin) & (x <= end), sharpest, 0.0)
    return build(name, title, description, Sampled(curve(x)[0], limiting, step))
