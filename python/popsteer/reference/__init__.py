"""The paper and its controllers once more, in plain Python and numpy.

Written to be read beside the paper, C. Samak, T. Samak, S. Kandhasamy, *Proximally Optimal
Predictive Control Algorithm for Path Tracking of Self-Driving Cars*: Algorithm 1 is `laws.pop`,
Equations 1 to 3 are `laws.pid`, `laws.pure_pursuit` and `laws.stanley`, Equations 4 to 6
`geometry`, `path.lookahead` and `vehicle.bicycle`, Equation 7 `speed.coupled`. `laws.preview_pop`
is the controller that the paper does not have. `tracker` steps a controller along a path.

It is what the tests hold the core to: on one machine the answers are those of `popsteer`, to the
last bit, by the same operations in the same order; within 1e-9 for preview POP, whose linear
algebra is written as in a textbook. What the core does besides, such as estimating its vehicle or
planning speeds, is held by other tests.

SI units and radians throughout, x forward, y left, yaw counter-clockwise, positive steering to
the left. The plain loops visit every point, so a path whose segments are very long for its
grid spacing takes long, and much memory.

Examples
--------
>>> from popsteer.reference import Path, Pop, Tracker, Vehicle
>>> car = Vehicle(wheelbase=2.7, rear_axle=-1.35)  # poses are of the point amid the axles
>>> tracker = Tracker(Pop(car), Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]))
>>> command = tracker.step(0.0, 0.5, 0.0, 5.0, 0.05)
>>> command.cross_track_error, str(command.status)
(0.5, 'ok')
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.reference import geometry, math
from popsteer.reference.bounds import MAX_YAW
from popsteer.reference.error import as_float, as_numbers, input_within
from popsteer.reference.laws.pid import Pid, PidParams, PidState
from popsteer.reference.laws.pop import Pop, PopParams, PopState
from popsteer.reference.laws.preview_pop import PreviewPop, PreviewPopParams, PreviewPopState
from popsteer.reference.laws.pure_pursuit import (
    PurePursuit,
    PurePursuitParams,
    PurePursuitState,
)
from popsteer.reference.laws.stanley import Stanley, StanleyParams, StanleyState
from popsteer.reference.path.lookahead import Lookahead
from popsteer.reference.path.owned import Path
from popsteer.reference.path.projection import Projection
from popsteer.reference.path.resample import Window
from popsteer.reference.speed.coupled import CoupledLongitudinal, CoupledLongitudinalParams
from popsteer.reference.speed.pedals import Pedals
from popsteer.reference.speed.pid import SpeedPid, SpeedPidParams, SpeedPidState
from popsteer.reference.tracker import Command, Tracker, TrackerState
from popsteer.reference.vehicle import Vehicle, bicycle
from popsteer.reference.vehicle.bicycle import kinematic_bicycle, state_transition
from popsteer.reference.vehicle.estimate import Estimate
from popsteer.reference.vehicle.state import checked_point

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.reference.geometry import Point

__all__ = [
    "Command",
    "CoupledLongitudinal",
    "CoupledLongitudinalParams",
    "Estimate",
    "Lookahead",
    "Path",
    "Pedals",
    "Pid",
    "PidParams",
    "PidState",
    "Pop",
    "PopParams",
    "PopState",
    "PreviewPop",
    "PreviewPopParams",
    "PreviewPopState",
    "Projection",
    "PurePursuit",
    "PurePursuitParams",
    "PurePursuitState",
    "SpeedPid",
    "SpeedPidParams",
    "SpeedPidState",
    "Stanley",
    "StanleyParams",
    "StanleyState",
    "Tracker",
    "TrackerState",
    "Vehicle",
    "Window",
    "get_distance",
    "get_predicted_location",
    "kinematic_bicycle",
    "saturate",
    "state_transition",
    "wrap",
]


# The plain functions of the controllers, with their arguments checked: what a user calls.


def wrap(angle: float, /) -> float:
    """Bring an angle into [-pi, pi] by whole turns.

    Parameters
    ----------
    angle : float
        Angle [rad], within 1e6.

    Returns
    -------
    float
        The same direction, in [-pi, pi]; an angle already there comes back unchanged.

    Raises
    ------
    InputError
        If the angle is not finite or beyond its bound.

    Examples
    --------
    >>> popsteer.paper.wrap(7.0)
    0.7168146928204138
    """
    return math.wrap(input_within("angle", angle, MAX_YAW))


def saturate(value: float, low: float, high: float, /) -> float:
    """Limit a number to a range.

    Parameters
    ----------
    value : float
        The number.
    low, high : float
        Ends of the range, ``low <= high``.

    Returns
    -------
    float
        `low`, `value` or `high`.

    Examples
    --------
    >>> popsteer.paper.saturate(3.0, -1.0, 1.0)
    1.0
    """
    return math.saturate(as_float(value), as_float(low), as_float(high))


def get_distance(a: Iterable[float], b: Iterable[float], /) -> float:
    """Measure the Euclidean distance of two points, the paper's Equation 4.

    Parameters
    ----------
    a, b : sequence of float
        Points (x, y) [m], within 1e9.

    Returns
    -------
    float
        Their distance [m].

    Raises
    ------
    InputError
        If a coordinate is not finite or beyond its bound.

    Examples
    --------
    >>> popsteer.paper.get_distance((0.0, 0.0), (3.0, 4.0))
    5.0
    """
    a, b = checked_point(as_numbers("a", a)), checked_point(as_numbers("b", b))
    return geometry.get_distance(a, b)


def get_predicted_location(
    x: float, y: float, yaw: float, speed: float, steer: float, dt: float, /
) -> Point:
    """Predict the vehicle's location one interval ahead, as POP does (the paper's Equation 6).

    ``x + cos(yaw + steer) dt speed``, ``y + sin(yaw + steer) dt speed``.

    Parameters
    ----------
    x, y : float
        Position [m].
    yaw : float
        Heading [rad].
    speed : float
        Speed [m/s].
    steer : float
        Steering angle [rad].
    dt : float
        Interval [s].

    Returns
    -------
    tuple of float
        Predicted (x, y) [m].

    Raises
    ------
    InputError
        If a number is not finite or beyond its bound.

    Examples
    --------
    >>> popsteer.paper.get_predicted_location(0.0, 0.0, 0.0, 10.0, 0.0, 0.05)
    (0.5, 0.0)
    """
    return bicycle.get_predicted_location(*bicycle.checked_motion(x, y, yaw, speed, steer, dt))
