"""Keeps the speed that a path allows, and stops where it has to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.bounds import MAX_SPEED
from popsteer.reference.error import config_in_range, input_below, input_within
from popsteer.reference.math import saturate, sqrt
from popsteer.reference.path.follow import Follow
from popsteer.reference.path.stop import section_end
from popsteer.reference.speed.curvature import path_curvature
from popsteer.reference.speed.limits import Limits, OverSpeed
from popsteer.reference.speed.profile import Course, plan_speeds
from popsteer.reference.vehicle import Vehicle
from popsteer.reference.vehicle.state import VehicleState, checked_dt

if TYPE_CHECKING:
    from popsteer.reference.path.owned import Path
    from popsteer.reference.path.view import PathView

__all__ = ["SpeedCommand", "SpeedTracker", "SpeedTrackerParams", "SpeedTrackerState"]

TOP_SPEED, LATERAL, DRIVING, BRAKING = 25.0, 4.0, 2.0, 3.0
"""What stands for a limit that the vehicle does not say [m/s, m/s²]."""
BENDS = 0.9
"""Share of the lateral acceleration that bends may take; the rest corrects the steering."""
SMOOTHING = 2.0 / 3.0
"""Length over which the curvature is smoothed, in wheelbases."""
CREEP = 0.1
"""Speed of the last stretch before a stop, in wheelbases a second."""
ARRIVED = 1.0 / 120.0
"""The vehicle has come to a stop when it is this near, in wheelbases."""
TURNING = 1.0 / 100.0
"""It goes on the other way when it is this near to a cusp, in wheelbases."""
LAST = 1.0 / 15.0
"""The last stretch before a stop, in wheelbases."""
MARGIN = 1.0 / 60.0
"""How far before a stop braking aims, in wheelbases: what brakes late does not pass it."""
STEEP = 0.8
"""From this share of the deceleration on, braking for a stop is by what remains of the way."""
HOLD = 0.5
"""Share of the deceleration that holds a vehicle where it stands."""
NEAR = 1.0 / 6.0
"""Farther off the speed than this the integral rests, so that it does not wind up, in wheelbases a
second."""
MOST_INTEGRAL = 1.0
"""Bound of the integral's share [m/s²]."""


@dataclass(frozen=True, kw_only=True)
class SpeedTrackerParams:
    """Parameters of `SpeedTracker`.

    Attributes
    ----------
    kp : float
        Acceleration for an error of the speed [1/s].
    ki : float
        Its integral [1/s²].
    max_jerk : float
        Largest change of the acceleration [m/s³].
    reserve : float
        Acceleration beyond that of the plan that may correct an error [m/s²].
    drive_delay : float
        Time from a command to its first effect on the drive [s].

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> SpeedTrackerParams(kp=2)
    SpeedTrackerParams(kp=2.0, ki=0.2, max_jerk=20.0, reserve=0.4, drive_delay=0.0)
    """

    kp: float = 1.5
    ki: float = 0.2
    max_jerk: float = 20.0
    reserve: float = 0.4
    drive_delay: float = 0.0

    def __post_init__(self) -> None:
        config_in_range(self, "kp", 0.0, 1e3)
        config_in_range(self, "ki", 0.0, 1e3)
        config_in_range(self, "max_jerk", 1e-3, 1e6)
        config_in_range(self, "reserve", 0.0, 1e3)
        config_in_range(self, "drive_delay", 0.0, 10.0)


@dataclass(frozen=True, kw_only=True)
class SpeedTrackerState:
    """What `SpeedTracker` remembers.

    Attributes
    ----------
    waypoint : int or None
        Where the segment beside the rear axle starts; None before the first step.
    acceleration : float
        The last command [m/s²].
    integral : float
        The integral's share of the command [m/s²].

    Examples
    --------
    >>> SpeedTrackerState()
    SpeedTrackerState(waypoint=None, acceleration=0.0, integral=0.0)
    """

    waypoint: int | None = None
    acceleration: float = 0.0
    integral: float = 0.0


@dataclass(frozen=True)
class SpeedCommand:
    """What a step of `SpeedTracker` answers."""

    acceleration: float
    """Acceleration in the direction of driving [m/s²]; negative brakes."""
    reference_speed: float
    """Speed that the path allows beside the rear axle [m/s], never negative."""
    distance_to_stop: float
    """Distance along the path to the next cusp or the end [m]; infinite where there is none."""
    reverse: bool
    """Whether the vehicle is to drive backwards."""
    standing: bool
    """Whether the vehicle is to be held where it stands."""


class SpeedTracker:
    """Keeps the speed that a path allows, and stops at its cusps and its end.

    The speeds are planned when it is made, within the vehicle's limits and at most those of the
    path. A step takes the plan's acceleration where the vehicle will be when the command takes
    effect, and corrects the error of the speed.

    Parameters
    ----------
    path : Path
        The path; its speeds, where it has any, are the most that is driven.
    vehicle : Vehicle, optional
        What drives.
    params : SpeedTrackerParams, optional
        The parameters.
    """

    def __init__(
        self,
        path: Path,
        vehicle: Vehicle | None = None,
        params: SpeedTrackerParams | None = None,
    ) -> None:
        self._path = path
        self._vehicle = Vehicle() if vehicle is None else vehicle
        self._params = SpeedTrackerParams() if params is None else params
        self._state = SpeedTrackerState()
        car = self._vehicle
        self._driving = DRIVING if car.max_acceleration is None else car.max_acceleration
        self._braking = BRAKING if car.max_deceleration is None else car.max_deceleration
        self._follow = replace(
            Follow.of(car, car.rear_axle, 0.0),
            lost_distance=10.0 * car.wheelbase,
            arrival_distance=TURNING * car.wheelbase,
        )
        self._plan = _planned(path, car, self._driving, self._braking)

    @property
    def plan(self) -> list[float]:
        """The planned speed at each waypoint [m/s], never negative."""
        return list(self._plan)

    @property
    def path(self) -> Path:
        """The path that it was given."""
        return self._path

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that it believes to drive."""
        return self._vehicle

    @property
    def params(self) -> SpeedTrackerParams:
        """The parameters."""
        return self._params

    @property
    def state(self) -> SpeedTrackerState:
        """What it remembers; may be set to a state saved before.

        Raises
        ------
        InputError
            Where it is no state that it could have on its path; the state is then unchanged.
        """
        return self._state

    @state.setter
    def state(self, state: SpeedTrackerState) -> None:
        if state.waypoint is not None:
            input_below("waypoint", state.waypoint, len(self._path))
        input_within("acceleration", state.acceleration, MAX_SPEED)
        input_within("integral", state.integral, MOST_INTEGRAL)
        self._state = state

    def set_path(self, path: Path) -> None:
        """Keep the speeds of another path from the next step on; they are planned at once.

        The command and the integral continue. So does the place, if the segment beside the vehicle
        is the same; else the next step finds it on the whole of the new path.
        """
        self._plan = _planned(path, self._vehicle, self._driving, self._braking)
        last, old = self._state.waypoint, self._path
        if last is not None:
            segment = old.segment_at(last)
            goes_on = (
                segment < path.segments
                and path.segment(segment) == old.segment(segment)
                and path.is_reverse(segment) == old.is_reverse(segment)
            )
            if not goes_on:
                self._state = replace(self._state, waypoint=None)
        self._path = path

    def reset(self) -> None:
        """Forget all steps taken so far."""
        self._state = SpeedTrackerState()

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> SpeedCommand:
        """Take one control step; the pose is that of the vehicle's point.

        Raises
        ------
        InputError
            A number is not finite or beyond its bound; the state is then unchanged.
        """
        vehicle = VehicleState(x, y, yaw, speed).checked()
        dt = checked_dt(dt)
        path, params, car, state = self._path, self._params, self._vehicle, self._state
        at = self._follow.locate(path, state.waypoint, vehicle, dt)
        arc = at.closest.arc_length(path)
        end = section_end(path, at.closest.segment)
        stop = inf if end is None else _end_of(path, end, at.closest.segment)
        left = stop - arc
        forward = at.vehicle.speed
        # When the command takes effect, in the middle of the time that it is held.
        later = params.drive_delay + car.drive_lag + 0.5 * dt
        moving = forward if forward > 0.0 else 0.0
        here, rise = self._lookup(arc, at.closest.segment, end)
        _, wanted = self._lookup(arc + moving * later, at.closest.segment, end)
        reference = sqrt(here)
        creep = CREEP * car.wheelbase
        room = left if left > 0.0 else 0.0
        nearing = sqrt(self._braking * room)
        # Where the path says 0 from here on the vehicle stands; it creeps away from a start, past a
        # single 0, and up to a stop.
        stands = here <= 0.0 and rise <= 0.0
        slowest = 0.0 if stands else creep if creep < nearing else nearing
        if reference < slowest:
            reference = slowest
        # The last stretch is crept along, whatever the plan still allows there.
        target = slowest if room < LAST * car.wheelbase else reference
        error = target - forward
        if forward < slowest and wanted < 0.0:
            wanted = 0.0
        turned = at.direction_changed
        last = 0.0 if turned else state.acceleration
        integral = 0.0 if turned else state.integral
        arrived = left <= ARRIVED * car.wheelbase and end is not None
        standing = (arrived or stands) and forward < creep
        if standing:
            command, integral = -HOLD * self._braking, 0.0
        else:
            if abs(error) <= NEAR * car.wheelbase:
                integral += params.ki * error * dt
                integral = saturate(integral, -MOST_INTEGRAL, MOST_INTEGRAL)
            command = wanted + params.kp * error + integral
            arriving = forward + last * later
            if arriving < 0.0:
                arriving = 0.0
            rest = left - MARGIN * car.wheelbase - 0.5 * (forward + arriving) * later
            needed = arriving * arriving / (2.0 * rest) if rest > 1e-3 else inf
            if needed >= STEEP * self._braking and forward > slowest and left < inf:
                command = -needed
        command = saturate(command, -self._braking - params.reserve, self._driving + params.reserve)
        change = params.max_jerk * dt
        command = saturate(command, last - change, last + change)
        self._state = SpeedTrackerState(
            waypoint=at.closest.segment, acceleration=command, integral=integral
        )
        return SpeedCommand(command, reference, left, at.reverse, standing)

    def _lookup(self, arc: float, segment: int, end: int | None) -> tuple[float, float]:
        """Return the square of the planned speed at `arc` [m], and the acceleration there.

        `arc` is counted on across the seam of a closed path; `segment` is where the vehicle is, and
        `end` the last segment of its section.
        """
        path = self._path
        if end is not None and arc >= _end_of(path, end, segment):
            found, share = end, 1.0
        elif arc <= path.s[segment]:
            found, share = segment, 0.0
        else:
            wrapped = arc - path.length if path.closed and arc >= path.length else arc
            found = path.segment_by_arc(wrapped)
            share = saturate((wrapped - path.s[found]) / path.segment_length(found), 0.0, 1.0)
        following = path.next(found)
        here = self._plan[found] * self._plan[found]
        after = here if following is None else self._plan[following] * self._plan[following]
        rise = after - here
        return here + share * rise, 0.5 * rise / path.segment_length(found)


def _end_of(path: PathView, end: int, segment: int) -> float:
    """Return the arc length at the end of a section [m], counted on across the seam."""
    arc = path.segment_end(end)
    return arc + path.length if end < segment else arc


def _planned(path: PathView, car: Vehicle, driving: float, braking: float) -> list[float]:
    """Plan the speeds of a path within a vehicle's limits and at most the path's own [m/s]."""
    segments = path.segments
    cusps = [False] * len(path)
    for segment in range(segments):
        following = path.next_segment(segment)
        if following is not None and path.is_reverse(following) != path.is_reverse(segment):
            cusps[following] = True
    most = TOP_SPEED if car.max_speed is None else car.max_speed
    lateral = car.max_lateral_acceleration
    bounds = None if path.speed is None else [abs(speed) for speed in path.speed]
    course = Course(
        path_curvature(path, SMOOTHING * car.wheelbase),
        [path.segment_length(segment) for segment in range(segments)],
        path.closed,
        cusps,
        bounds,
        None,
        0.0,
    )
    limits = Limits(
        most,
        BENDS * (LATERAL if lateral is None else lateral),
        OverSpeed((0.0,), (driving,)),
        OverSpeed((0.0,), (braking,)),
        None,
        2.0,
        car,
    )
    return plan_speeds(course, limits)[0]
