"""Where the vehicle will be.

The paper's one-step prediction, the kinematic bicycle, and a vehicle rolled forward through its
commands.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from popsteer.reference.error import as_numbers, input_in_range, input_within
from popsteer.reference.math import PI, ceil, cos, divide, saturate, sin, tan
from popsteer.reference.vehicle.state import VehicleState, checked_dt
from popsteer.reference.vehicle.wheels import move_wheel

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from popsteer.reference.geometry import Point
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Estimate

MAX_STEPS = 20
"""The largest number of steps of a prediction."""
STEP = 0.05
"""The longest step of a rollout [s]; larger values cut bends short, smaller ones cost more."""


def steps(horizon: float, dt: float) -> tuple[int, float]:
    """Tell how many steps a prediction takes over `horizon` [s], and how long each is [s].

    The control period `dt` [s], or longer where that would be too many.
    """
    whole = int(saturate(horizon / dt + 1e-6, 1.0, float(MAX_STEPS)))
    period = horizon / whole
    return whole, dt if period < dt else period


def get_predicted_location(
    x: float, y: float, yaw: float, speed: float, steer: float, dt: float
) -> Point:
    """Predict the vehicle's location after `dt`: the first two rows of Equation 6, unchecked."""
    heading = yaw + steer
    return x + cos(heading) * dt * speed, y + sin(heading) * dt * speed


def state_transition(
    state: Iterable[float], control: Iterable[float], steer: float, dt: float, /
) -> tuple[float, float, float, float, float]:
    """Apply the paper's state-transition equation whole (Equation 6).

    ``A(yaw + steer, dt) z + B u``. As printed, the control adds to speed and yaw rate without
    ``dt``.

    Parameters
    ----------
    state : sequence of float
        z = (x, y, yaw, speed, yaw rate) [m, m, rad, m/s, rad/s].
    control : sequence of float
        u = (longitudinal, lateral) control, added to speed and yaw rate.
    steer : float
        Steering angle [rad] in the direction of travel, ``yaw + steer``.
    dt : float
        Interval [s].

    Returns
    -------
    tuple of float
        The state one interval later.

    Raises
    ------
    InputError
        If a number is not finite or beyond its bound.

    Examples
    --------
    >>> popsteer.paper.state_transition((0.0, 0.0, 0.0, 10.0, 0.1), (0.5, 0.0), 0.0, 0.5)
    (5.0, 0.0, 0.05, 10.5, 0.1)
    """
    x, y, yaw, speed, yaw_rate = as_numbers("state", state)
    longitudinal, lateral = as_numbers("control", control)
    x, y, yaw, speed, steer, dt = checked_motion(x, y, yaw, speed, steer, dt)
    z = (x, y, yaw, speed, input_within("yaw_rate", yaw_rate, 1e6))
    u = (input_within("longitudinal", longitudinal, 1e6), input_within("lateral", lateral, 1e6))
    heading = yaw + steer
    c, s = cos(heading) * dt, sin(heading) * dt
    a = (
        (1.0, 0.0, 0.0, c, 0.0),
        (0.0, 1.0, 0.0, s, 0.0),
        (0.0, 0.0, 1.0, 0.0, dt),
        (0.0, 0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 0.0, 1.0),
    )
    b = (
        (0.0, 0.0),
        (0.0, 0.0),
        (0.0, 0.0),
        (1.0, 0.0),
        (0.0, 1.0),
    )
    x, y, yaw, speed, yaw_rate = (
        _dot(row_a, z) + _dot(row_b, u) for row_a, row_b in zip(a, b, strict=True)
    )
    return x, y, yaw, speed, yaw_rate


def _dot(row: Sequence[float], column: Sequence[float]) -> float:
    """Multiply a row of a matrix with a column, from left to right."""
    # Begun with the first product, not with 0.0, which would lose the sign of a zero; and no
    # sum(), which compensates its rounding from Python 3.12 on.
    total = row[0] * column[0]
    for j in range(1, len(row)):
        total += row[j] * column[j]
    return total


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
    """Move the kinematic bicycle about its rear axle by one interval.

    ``yaw rate = speed tan(steer) / wheelbase``; the position moves along the heading of
    mid-step (second order in ``dt``), the speed changes at the end.

    Parameters
    ----------
    x, y : float
        Position of the rear axle [m].
    yaw : float
        Heading [rad].
    speed : float
        Speed [m/s].
    steer : float
        Steering angle [rad].
    acceleration : float
        Acceleration [m/s^2].
    wheelbase : float
        Distance of the axles [m].
    dt : float
        Interval [s].

    Returns
    -------
    tuple of float
        (x, y, yaw, speed) one interval later.

    Raises
    ------
    InputError
        If a number is not finite or beyond its bound.

    Examples
    --------
    >>> popsteer.paper.kinematic_bicycle(0.0, 0.0, 0.0, 10.0, 0.0, 1.0, 3.0, 0.5)
    (5.0, 0.0, 0.0, 10.5)
    """
    x, y, yaw, speed, steer, dt = checked_motion(x, y, yaw, speed, steer, dt)
    acceleration = input_within("acceleration", acceleration, 1e6)
    wheelbase = input_in_range("wheelbase", wheelbase, 1e-3, 1e3)
    travel = speed * dt
    turn = travel * tan(steer) / wheelbase
    heading = yaw + 0.5 * turn
    return (
        x + travel * cos(heading),
        y + travel * sin(heading),
        yaw + turn,
        speed + acceleration * dt,
    )


def checked_motion(
    x: float, y: float, yaw: float, speed: float, steer: float, dt: float
) -> tuple[float, float, float, float, float, float]:
    """Return a vehicle's state, its angle and its interval, as floats; else raise InputError."""
    vehicle = VehicleState(x, y, yaw, speed).checked()
    steer = input_within("steer", steer, PI)
    return vehicle.x, vehicle.y, vehicle.yaw, vehicle.speed, steer, checked_dt(dt)


def advance(vehicle: VehicleState, travel: float, curvature: float, slip: float) -> VehicleState:
    """Move a vehicle along an arc of length `travel` [m], at the angle `slip` [rad] to its heading.

    The position moves along the direction of mid-arc (second order in `travel`); the speed stays.
    """
    turn = travel * curvature
    direction = vehicle.yaw + 0.5 * turn + slip
    return VehicleState(
        x=vehicle.x + travel * cos(direction),
        y=vehicle.y + travel * sin(direction),
        yaw=vehicle.yaw + turn,
        speed=vehicle.speed,
    )


class Rollout:
    """A vehicle rolled forward through commands that last for their time each.

    ::

        curvature = gain tan(wheel + steer_offset) / turning_length,   yaw' = speed curvature

    What the estimate knows better than the vehicle counts. The speed changes by the acceleration
    that is estimated, and the turning length is that of the first speed.

    `state` is that of the no-slip point, at first as it was given.
    """

    def __init__(self, vehicle: Vehicle, estimate: Estimate, state: VehicleState) -> None:
        self._vehicle = vehicle
        self._estimate = estimate
        self.state = state
        self._length = vehicle.turning_length(state.speed) / estimate.gain
        self._start, self._time = state.speed, 0.0

    def turn(self, wheel: float, time: float) -> None:
        """Drive for `time` [s] with the wheels at the mean angle `wheel` [rad]: one step."""
        estimate, state = self._estimate, self.state
        self._time += time
        speed = estimate.speed_after(self._start, self._time)
        travel = 0.5 * (state.speed + speed) * time
        angle = self._vehicle.at_wheels(wheel + estimate.steer_offset)
        curvature = tan(angle) / self._length
        slip = estimate.slip + estimate.slip_length * curvature
        self.state = replace(advance(state, travel, curvature, slip), speed=speed)

    def drive(self, wheel: float, commands: Iterable[tuple[float, float]]) -> float:
        """Drive through `commands`, angles [rad] with how long each lasts [s].

        From the angle `wheel` of the wheels [rad] on; returns that at the end [rad].
        """
        for steer, duration in commands:
            steps = ceil(duration / STEP)
            step = divide(duration, steps)
            for _ in range(steps):
                moved = move_wheel(self._vehicle, wheel, steer, step)
                self.turn(moved.mean, step)
                wheel = moved.wheel
        return wheel
