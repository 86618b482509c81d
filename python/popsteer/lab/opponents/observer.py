"""What an opponent sees of its vehicle: by popsteer's own prediction and estimates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer._core import Path, PreviewPop, Vehicle
from popsteer.lab.opponents.ahead import Ahead

if TYPE_CHECKING:
    from numpy.typing import NDArray


# Below this speed, in wheelbases a second, laws are computed for this one.
_LEAST_SPEED = 1.0 / 3.0


class Seen(NamedTuple):
    """The no-slip point when the next command reaches the wheels, of a vehicle that drives forward.

    Where the path is driven backwards, it is the vehicle mirrored about that point.
    """

    error: float
    """Cross-track error [m], positive left of the path."""
    heading: float
    """Direction of its motion less that of the path [rad]; of the mirrored vehicle, too."""
    speed: float
    """Speed [m/s]; positive."""
    wheel: float
    """Angle of the wheels, offset and all [rad]."""
    length: float
    """Speed over turning rate, for small angles of the wheels [m]: wheelbase and understeer."""
    slope: float
    """How much the motion turns from the heading with the curvature [m]."""
    arc: float
    """Arc length of the path there [m]."""
    segment: int
    """Segment of the path there."""
    dt: float
    """Control period [s]."""
    left: float
    """Path that is left to the next cusp or to the end [m]; ``inf`` on a lap."""


class Observer:
    """Looks through a `PreviewPop` that is given the opponent's commands as those that are applied.

    From it come the vehicle's prediction through the dead time, the direction of travel and the
    estimates: steering offset, gain, dead time, slip.
    """

    def __init__(self, path: Path, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self._ahead = Ahead(path, vehicle)
        self.eye = PreviewPop(self._ahead.path, vehicle)
        point = vehicle.no_slip_point
        self._point = vehicle.rear_axle if point is None else point
        self._segment = -1
        self.steer, self.wheel, self.reverse = 0.0, 0.0, False

    def set_path(self, path: Path) -> None:
        """Follow another path from the next step on, from the place where the vehicle is."""
        self._ahead, self._segment = Ahead(path, self.vehicle), -1
        self.eye.set_path(self._ahead.path)

    def see(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Seen:
        """Take a pose [m, m, rad], a speed [m/s] and the time since the last one [s]."""
        command = self.eye.step(x, y, yaw, speed, dt, applied_steer=self.steer)
        estimate, car, path = self.eye.estimate, self.vehicle, self._ahead.path
        speed *= estimate.speed_scale
        self._move_wheels(dt)
        if self._segment < 0:
            state = self.eye.state
            self._segment = state.waypoint if (at := state.measured_waypoint) is None else at
        if command.reverse is not self.reverse:
            self.reverse = command.reverse
            self._segment = self._ahead.turning(self._segment, reverse=self.reverse)
        x, y = x + self._point * math.cos(yaw), y + self._point * math.sin(yaw)
        reach = 2.0 * car.wheelbase + abs(speed) * dt
        found = path.locate(x, y, yaw, self._segment, reach)
        self._segment = found.segment
        speed = max(abs(speed), _LEAST_SPEED * car.wheelbase)
        side = -1.0 if self.reverse else 1.0
        return Seen(
            command.predicted_cross_track_error,
            command.predicted_heading_error + estimate.slip,
            speed,
            side * (self.wheel + estimate.steer_offset),
            car.turning_length(speed) / estimate.gain,
            side * estimate.slip_length,
            found.arc_length + speed * estimate.dead_time,
            found.segment,
            dt,
            command.distance_to_stop,
        )

    def curvature(self, seen: Seen, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the path's mean curvatures [1/m] between distances ahead [m]."""
        headings = self._ahead.headings(seen.segment, seen.arc, distances)
        return np.diff(headings) / np.diff(distances)

    def bend(self, seen: Seen, ahead: float) -> float:
        """Give the curve's curvature so far ahead [1/m], over a tenth of the wheelbase."""
        ends = np.array([ahead, ahead + 0.1 * self.vehicle.wheelbase])
        return float(self.curvature(seen, ends)[0])

    def towards(self, seen: Seen, distance: float) -> tuple[float, float]:
        """Give distance and bearing [m, rad], from the vehicle, of the path's point so far ahead.

        Past the next cusp, or the end, the path is taken to go straight on.
        """
        within = min(distance, max(seen.left, 0.0))
        ends = np.array([0.0, within])
        yaw, far = self._ahead.headings(seen.segment, seen.arc, ends).tolist()
        (x, y), (to_x, to_y) = self._ahead.place(seen.arc), self._ahead.place(seen.arc + within)
        x, y = x - seen.error * math.sin(yaw), y + seen.error * math.cos(yaw)
        to_x += (distance - within) * math.cos(far)
        to_y += (distance - within) * math.sin(far)
        bearing = math.atan2(to_y - y, to_x - x) - yaw - seen.heading
        return math.hypot(to_x - x, to_y - y), math.remainder(bearing, math.tau)

    def commanded(self, wheel: float, seen: Seen) -> float:
        """Give the command that turns the wheels there [rad], within what the vehicle can do."""
        car = self.vehicle
        if car.max_lateral_acceleration is not None:
            most = math.atan(car.max_lateral_acceleration * seen.length / seen.speed**2)
            wheel = min(max(wheel, -most), most)
        steer = (-wheel if self.reverse else wheel) - self.eye.estimate.steer_offset
        if car.max_steer_rate is not None:
            change = car.max_steer_rate * seen.dt
            steer = min(max(steer, self.steer - change), self.steer + change)
        self.steer = min(max(steer, -car.max_steer), car.max_steer)
        return self.steer

    def _move_wheels(self, dt: float) -> None:
        """Move the wheels as their lag and their rate have it, to when the next command arrives."""
        car = self.vehicle
        share = 1.0 - math.exp(-dt / car.steer_lag) if car.steer_lag > 0.0 else 1.0
        turned = share * (self.steer - self.wheel)
        if car.max_steer_rate is not None:
            turned = min(max(turned, -car.max_steer_rate * dt), car.max_steer_rate * dt)
        self.wheel += turned


class Opponent:
    """What they have in common: a path, a vehicle, parameters, an observer."""

    def __init__(self, path: Path, vehicle: Vehicle, params: object) -> None:
        self.path, self.vehicle, self.params = path, vehicle, params
        self.reset()

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.observer = Observer(self.path, self.vehicle)
        self.tracked_point = self.observer.eye.tracked_point

    def set_path(self, path: Path) -> None:
        """Follow another path from the next step on."""
        self.path = path
        self.observer.set_path(path)

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Answer a pose [m, m, rad] and a speed [m/s] with the angle of the wheels [rad]."""
        seen = self.observer.see(x, y, yaw, speed, dt)
        return self.observer.commanded(self.wheels(seen), seen)

    def wheels(self, seen: Seen) -> float:
        """Give the angle that the wheels shall have [rad]; the law."""
        raise NotImplementedError
