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
from popsteer.reference.error import input_in_range, input_within
from popsteer.reference.laws.pid import Pid, PidParams, PidState
from popsteer.reference.laws.pop import Pop, PopParams, PopState
from popsteer.reference.laws.preview_pop import PreviewPop, PreviewPopParams, PreviewPopState
from popsteer.reference.laws.pure_pursuit import (
    PurePursuit,
    PurePursuitParams,
    PurePursuitState,
)
from popsteer.reference.laws.stanley import Stanley, StanleyParams, StanleyState
from popsteer.reference.math import PI, saturate
from popsteer.reference.path.lookahead import Lookahead
from popsteer.reference.path.owned import Path
from popsteer.reference.path.projection import Projection
from popsteer.reference.path.resample import Window
from popsteer.reference.speed.coupled import CoupledLongitudinal, CoupledLongitudinalParams
from popsteer.reference.speed.pedals import Pedals
from popsteer.reference.speed.pid import SpeedPid, SpeedPidParams, SpeedPidState
from popsteer.reference.tracker import Command, Tracker, TrackerState
from popsteer.reference.vehicle import Vehicle, bicycle
from popsteer.reference.vehicle.estimate import Estimate
from popsteer.reference.vehicle.state import VehicleState, checked_dt, checked_point

if TYPE_CHECKING:
    from collections.abc import Sequence

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


# The plain functions, with their arguments checked: what a user calls. They raise `InputError`
# where a number is not finite or beyond its bound. The controllers call those behind them.


def wrap(angle: float, /) -> float:
    """Bring an angle [rad], within 1e6, into [-π, π] by whole turns; see `math.wrap`.

    Examples
    --------
    >>> wrap(7.0)
    0.7168146928204138
    """
    return math.wrap(input_within("angle", angle, MAX_YAW))


def get_distance(a: Point, b: Point, /) -> float:
    """Measure the Euclidean distance of two points (x, y) [m]: Equation 4.

    Examples
    --------
    >>> get_distance((0.0, 0.0), (3.0, 4.0))
    5.0
    """
    return geometry.get_distance(checked_point(a), checked_point(b))


def get_predicted_location(
    x: float, y: float, yaw: float, speed: float, steer: float, dt: float, /
) -> Point:
    """Predict the location after `dt` [s]: Equation 6; see `bicycle.get_predicted_location`.

    Examples
    --------
    >>> get_predicted_location(0.0, 0.0, 0.0, 10.0, 0.0, 0.05)
    (0.5, 0.0)
    """
    return bicycle.get_predicted_location(*_checked_motion(x, y, yaw, speed, steer, dt))


def state_transition(
    state: Sequence[float], control: Sequence[float], steer: float, dt: float, /
) -> tuple[float, float, float, float, float]:
    """Predict the whole state after `dt` [s]: Equation 6; see `bicycle.state_transition`.

    Examples
    --------
    >>> state_transition((0.0, 0.0, 0.0, 10.0, 0.1), (0.5, 0.0), 0.0, 0.5)
    (5.0, 0.0, 0.05, 10.5, 0.1)
    """
    x, y, yaw, speed, yaw_rate = state
    longitudinal, lateral = control
    x, y, yaw, speed, steer, dt = _checked_motion(x, y, yaw, speed, steer, dt)
    yaw_rate = input_within("yaw_rate", yaw_rate, 1e6)
    longitudinal = input_within("longitudinal", longitudinal, 1e6)
    lateral = input_within("lateral", lateral, 1e6)
    return bicycle.state_transition(
        (x, y, yaw, speed, yaw_rate), (longitudinal, lateral), steer, dt
    )


def kinematic_bicycle(
    x: float,
    y: float,
    yaw: float,
    speed: float,
    steer: float,
    acceleration: float,
    wheelbase: float,
    dt: float,
    /,
) -> tuple[float, float, float, float]:
    """Move the kinematic bicycle by `dt` [s]; see `bicycle.kinematic_bicycle`.

    Examples
    --------
    >>> kinematic_bicycle(0.0, 0.0, 0.0, 10.0, 0.0, 1.0, 3.0, 0.5)
    (5.0, 0.0, 0.0, 10.5)
    """
    x, y, yaw, speed, steer, dt = _checked_motion(x, y, yaw, speed, steer, dt)
    acceleration = input_within("acceleration", acceleration, 1e6)
    wheelbase = input_in_range("wheelbase", wheelbase, 1e-3, 1e3)
    return bicycle.kinematic_bicycle(x, y, yaw, speed, steer, acceleration, wheelbase, dt)


def _checked_motion(
    x: float, y: float, yaw: float, speed: float, steer: float, dt: float
) -> tuple[float, float, float, float, float, float]:
    vehicle = VehicleState(x, y, yaw, speed).checked()
    steer = input_within("steer", steer, PI)
    dt = checked_dt(dt)
    return vehicle.x, vehicle.y, vehicle.yaw, vehicle.speed, steer, dt
