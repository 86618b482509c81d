"""A linear time-varying model-predictive controller on osqp: 20 stages of 50 ms.

What it is given of the car is its `popsteer.Vehicle`. The commands in flight are rolled through as
the controllers of popsteer do it, so that the problem begins where the next command reaches the
wheels; backwards the vehicle is mirrored about its rear axle. `mpc_problem` has the problem itself.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer._core import Vehicle, _InFlight
from popsteer.lab.baselines.ahead import Ahead
from popsteer.lab.baselines.mpc_params import MpcParams
from popsteer.lab.baselines.mpc_problem import Instant, Problem, within
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer import Path

# Below this speed, in wheelbases a second, the vehicle hardly answers to its wheels: the problem is
# set up for this speed instead.
_LEAST_SPEED = 1.0 / 3.0
# Farther from the path, in wheelbases, the linear model says nothing; from there on it is
# approached as from here.
_MOST_ERROR, _MOST_HEADING = 1.0, 1.0


class MpcCommand(NamedTuple):
    """The result of a step of the controller."""

    steer: float
    """Angle of the front wheels [rad]."""
    status: Status
    """``SATURATED`` where the angle is at its limit."""
    reverse: bool
    """Whether the path is driven backwards."""


class Mpc:
    """The controller, for `popsteer.sim.run` one of one's own.

    Its tracked point is the front axle, backwards the point a wheelbase behind the rear axle. The
    vehicle, ``Vehicle()`` by default and in `popsteer.sim.run` the plant's, says where the point
    lies whose pose `step` is given. The defaults of the parameters scale with it.
    """

    name = "mpc"

    def __init__(
        self, path: Path, vehicle: Vehicle | None = None, params: MpcParams | None = None
    ) -> None:
        self.path = path
        self.vehicle_given = vehicle is not None
        self.vehicle = vehicle = Vehicle() if vehicle is None else vehicle
        self.params = MpcParams() if params is None else params
        self.tracked_point = vehicle.front_axle
        resolved = self.params.resolved(vehicle)
        point = vehicle.no_slip_point
        self._no_slip = vehicle.rear_axle if point is None else point
        self._ahead = Ahead(path, vehicle)
        self._ends = resolved.stage_time * np.arange(resolved.stages + 1, dtype=np.float64)
        self._problem = Problem(vehicle, resolved)
        self.reset()

    def with_vehicle(self, vehicle: Vehicle) -> Mpc:
        """Give a fresh controller of another vehicle, on the same path."""
        return Mpc(self.path, vehicle, self.params)

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.previous_steer = 0.0
        self._segment: int | None = None
        self._reverse = False
        self._in_flight = _InFlight(self.vehicle)
        self._problem.reset()

    def step(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        /,
        *,
        reverse: bool | None = None,
    ) -> MpcCommand:
        """Answer a pose [m, m, rad] and a speed [m/s], negative while rolling backwards.

        `dt` is the time since the last step, and until the next [s]. `reverse` says whether the
        path is driven backwards where the rear axle is; left out, the direction stays, and no cusp
        is passed. Raises InputError where a number is not finite or beyond its bound, and
        PopsteerError where osqp finds no solution.
        """
        steer = self.steer(x, y, yaw, speed, dt, reverse=reverse)
        lowest, highest = self._problem.reach
        limited = not lowest < self._mirror(steer) < highest
        return MpcCommand(steer, Status.SATURATED if limited else Status.OK, self._reverse)

    def steer(self, *pose: float, reverse: bool | None = None) -> float:
        """Answer as `step` does, with the angle alone [rad]."""
        self.update(*pose, reverse=reverse)
        return self.solve()

    def update(self, *pose: float, reverse: bool | None = None) -> None:
        """Find the vehicle on the path, linearise ahead of it, hand the numbers to osqp."""
        x, y, yaw, speed, dt = pose
        # The no-slip point when the next command reaches the wheels.
        then = self._in_flight.advance(self.previous_steer, dt, x, y, yaw, speed)
        segment = self._find(x, y, yaw, reverse=reverse)
        x, y, yaw, speed, wheel = then

        # Backwards, mirrored to a vehicle that drives forward.
        length, slip = self.vehicle.wheelbase, self._no_slip - self.vehicle.rear_axle
        ahead = length - slip
        if self._reverse:
            yaw, ahead = math.remainder(yaw + math.pi, math.tau), length + slip
        x, y = x + ahead * math.cos(yaw), y + ahead * math.sin(yaw)
        reach = 2.0 * length + abs(speed) * dt
        projection = self.path.locate(x, y, yaw, segment, reach)
        self._segment = projection.segment
        speed = max(self._mirror(speed), _LEAST_SPEED * length)
        heading = self._ahead.headings(
            projection.segment, projection.arc_length, speed * self._ends
        )
        error = math.remainder(yaw - float(heading[0]), math.tau)
        offset, far = self.vehicle.steer_offset, _MOST_ERROR * length
        self._problem.update(
            Instant(
                curvature=np.diff(heading) / (speed * self.params.stage_time),
                speed=speed,
                ahead=ahead,
                cross_track=within(self._ahead.cross_track(projection), -far, far),
                heading=within(error, -_MOST_HEADING, _MOST_HEADING),
                wheel=self._mirror(wheel - offset),
                offset=self._mirror(offset),
                previous=self._mirror(self.previous_steer),
                dt=dt,
            )
        )

    def solve(self) -> float:
        """Solve for the angle [rad] from the last solution; PopsteerError if osqp finds none."""
        self.previous_steer = self._mirror(self._problem.solve())
        return self.previous_steer

    def _find(self, x: float, y: float, yaw: float, *, reverse: bool | None) -> int:
        """Give the segment at which to search for the vehicle, and set the direction."""
        segment = self._segment
        if segment is None:
            rear = self.vehicle.rear_axle
            x, y = x + rear * math.cos(yaw), y + rear * math.sin(yaw)
            segment = self.path.relocalise(x, y, yaw)
        if reverse is not None:
            segment = self._ahead.turning(segment, reverse=reverse)
        backwards = self._ahead.reverse(segment)
        if backwards is not self._reverse:
            # The last solution is of the vehicle that was not mirrored, or was.
            self._problem.reset()
            self._reverse = backwards
        return segment

    def _mirror(self, value: float) -> float:
        """Give an angle or a speed of the vehicle as that of the mirrored one, and back."""
        return -value if self._reverse else value
