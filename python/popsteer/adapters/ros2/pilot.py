"""From what is known to what is commanded: drives, holds, or brakes to a standstill."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from popsteer import Command, Path, SpeedCommand, SpeedTracker, SpeedTrackerParams, Status, Vehicle
from popsteer._core import _speed_defaults
from popsteer.errors import InputError

if TYPE_CHECKING:
    from popsteer.adapters.ros2.conversions import Measured
    from popsteer.controllers import Controller

# What the vehicle does not limit, as `SpeedTracker` and the closed loop of `popsteer.sim` have it.
_ACCELERATION = _speed_defaults["max_acceleration"]
_DECELERATION = _speed_defaults["max_deceleration"]
_STOP_DECELERATION = _speed_defaults["stop_deceleration"]
_SPEED = SpeedTrackerParams()
# A planner's next path has moved by less than this [m], ...
_SHIFT = 0.3
# ... and a vehicle on it is not farther along than this [m].
_ADVANCE = 20.0
# After a longer gap the controller begins anew: the vehicle may be elsewhere.
_GAP = 1.0
# Below so many wheelbases a second a yaw rate's noise of 0.02 rad/s is that of 0.04 rad and more.
_SLOW = 0.5
# What the first step counts as [s]: the time since the cycle before it says nothing.
_FIRST = 0.02


class State(Enum):
    """What the node does."""

    DRIVING = "driving"
    """It steers along the path."""
    HOLDING = "holding"
    """Something is missing: the last command stays, for a moment."""
    BRAKING = "braking"
    """Something is missing for longer: it brakes to a standstill."""
    STANDING = "standing"
    """It has braked to a standstill, and waits for what is missing."""


class DriveCommand(NamedTuple):
    """What is commanded."""

    steer: float
    """Angle of the front wheels [rad], positive to the left."""
    speed: float
    """Speed [m/s], negative backwards."""
    acceleration: float
    """Acceleration in the direction of driving [m/s²], negative brakes."""
    limit: float
    """How fast the speed may change [m/s²]."""


class Pilot:
    """A controller and a speed tracker, and the safe stop if they cannot continue.

    Parameters
    ----------
    controller : Controller
        What steers; its path is the first one.
    hold : float, default 0.2
        How long the last command is held before it brakes [s].

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.adapters.ros2.conversions import Measured
    >>> path = popsteer.Path([(0.0, 0.0), (90.0, 0.0)], speed=[5.0, 0.0])
    >>> pilot = Pilot(popsteer.Stanley(path))
    >>> here = Measured(0.0, 0.0, 0.0, 5.0, 0, "map", "base_link")
    >>> round(pilot.step(here, 0.0, 0.02).speed, 3), pilot.state.value
    (4.981, 'driving')
    >>> for _ in range(12):
    ...     drive = pilot.step(None, 0.0, 0.02, "no odometry")
    >>> drive.speed < 5.0, pilot.state.value, pilot.reason
    (True, 'braking', 'no odometry')
    """

    def __init__(self, controller: Controller, *, hold: float = 0.2) -> None:
        self.command: Command | None = None
        self.state = State.STANDING
        self.reason = ""
        self.hold = hold
        self._speed: float | None = None
        self._steer = 0.0
        self._passed = 0.0
        self._concerned = 0.0
        self.begin(controller)

    def begin(self, controller: Controller) -> None:
        """Start with a controller and its path; nothing of those before counts, nor a fault.

        The angle goes on from that of the wheels: as a sensor measures it, or as the odometry's yaw
        rate shows it. The speed goes on from the commanded one, or after a stand from the measured.
        """
        self.controller = controller
        self._tracker = SpeedTracker(controller.path, controller.vehicle, _SPEED)
        self.fault = ""
        self._passed, self._begins = 0.0, True
        if not self._speed:
            self._speed = None

    def limit_speed(self, most: float) -> None:
        """Drive no faster than this from now on [m/s]; infinity: as path and vehicle allow."""
        car = self.vehicle.replace(max_speed=most if most < math.inf else None)
        state = self._tracker.state
        self._tracker = SpeedTracker(self._tracker.path, car, _SPEED)
        self._tracker.state = state

    @property
    def vehicle(self) -> Vehicle:
        """What is driven: the controller's."""
        return self.controller.vehicle

    def yaw_rate(self, drive: DriveCommand) -> float:
        """Give the yaw rate of a command [rad/s]: v tan(angle) / (L + understeer v²).

        The wheels' angle is the commanded one and the steering offset.
        """
        car, speed = self.vehicle, drive.speed
        return speed * math.tan(drive.steer + car.steer_offset) / car.turning_length(speed)

    def set_path(self, path: Path) -> None:
        """Go on along another path, without a jump."""
        old, before = self.controller.path, self.controller.state
        self.controller.set_path(path)
        if _is_on_another_leg(old, before.waypoint, path, self.controller.state.waypoint):
            self.controller.state = before
        self._tracker.set_path(path)
        found = self._tracker.state
        if found.waypoint is None and self.controller.state.waypoint is not None:
            # Where legs or laps overlap, the controller knows on which one the vehicle was.
            last = len(self._tracker.path) - 2
            waypoint = min(self.controller.state.waypoint, last)
            self._tracker.state = found.replace(waypoint=waypoint)

    def release(self) -> str:
        """Forget the fault that it brakes for, and say what it was: it drives again, if it can."""
        fault, self.fault = self.fault, ""
        return fault

    def reset(self) -> None:
        """Start again from the present angle, after a jump of time or of position."""
        limit = self.vehicle.max_steer
        self.controller.reset(steer=max(-limit, min(self._steer, limit)))
        self._tracker.reset()
        self._passed = 0.0

    def step(
        self,
        measured: Measured | None,
        age: float,
        dt: float,
        concern: str = "",
        wheel: float | None = None,
    ) -> DriveCommand:
        """Take one step.

        Parameters
        ----------
        measured : Measured or None
            Where the vehicle is; None where that is not known.
        age : float
            How long ago that was measured [s].
        dt : float
            Time since the last step [s]; the first one counts as 0.02 s.
        concern : str, optional
            What is missing; where nothing is, it drives.
        wheel : float, optional
            The angle of the wheels now, as a sensor measured it [rad].

        Returns
        -------
        DriveCommand
            What to command.
        """
        if self.command is None:
            dt, self._passed = _FIRST, 0.0
        self._passed += dt
        known = self._steer_along(measured, age, dt, wheel) if measured is not None else None
        if known is None and not concern:
            concern = "the controller refuses the odometry"
        if not concern and not self.fault and self.command is not None:
            # It stays until `release`: what has failed once may not drive again by itself.
            self.fault = "|".join(
                str(each) for each in Status if each & self.command.status and each.level == "fault"
            )
        self._concerned = self._concerned + dt if concern else 0.0
        self.reason = concern or self.fault
        moves = self.state in (State.DRIVING, State.HOLDING) and not self.fault
        if concern and moves and self._concerned <= self.hold:
            self.state = State.HOLDING
            return DriveCommand(self._steer, self._speed or 0.0, 0.0, self._limit(braking=True))
        if self.reason or known is None:
            return self._brake(dt)
        self.state = State.DRIVING
        return self._drive(known)

    def _steer_along(
        self, measured: Measured, age: float, dt: float, wheel: float | None
    ) -> SpeedCommand | None:
        """Steer; what the pedals are to do, None where the input is refused."""
        if self._begins:
            at = self._wheel(measured) if wheel is None else wheel
            if at:
                limit = self.vehicle.max_steer
                self.controller.reset(steer=max(-limit, min(at, limit)))
        elif self._passed > _GAP:
            self.reset()
        passed = self._passed or min(dt, _GAP)
        pose = measured.x, measured.y, measured.yaw
        try:
            age = min(max(age, 0.0), 1.0)
            command = self.controller.step(
                *pose, measured.speed, passed, pose_age=age, measured_steer=wheel
            )
            speed = self._tracker.step(*pose, measured.speed, passed, pose_age=age)
        except InputError:
            return None
        self._passed, self._begins = 0.0, False
        self.command, self._steer = command, command.steer
        if self._speed is None:
            self._speed = measured.speed
        return speed

    def _wheel(self, measured: Measured) -> float:
        """Give the angle that the odometry's yaw rate shows [rad]; 0 where it is too slow to."""
        car, speed = self.vehicle, measured.speed
        if measured.yaw_rate == 0.0 or abs(speed) < _SLOW * car.wheelbase:
            return 0.0
        return math.atan(measured.yaw_rate * car.turning_length(speed) / speed) - car.steer_offset

    def _drive(self, wanted: SpeedCommand) -> DriveCommand:
        limit = self._limit(braking=wanted.acceleration < 0.0 or wanted.standing)
        limit = max(limit, -wanted.acceleration)
        if wanted.cannot_stop:
            self.reason = "it cannot stop in time"
        self._speed = -wanted.speed if wanted.reverse else wanted.speed
        return DriveCommand(self._steer, self._speed, wanted.acceleration, limit)

    def _brake(self, dt: float) -> DriveCommand:
        limit = self.vehicle.max_deceleration or _STOP_DECELERATION
        speed = self._speed or 0.0
        self._speed = math.copysign(max(abs(speed) - limit * dt, 0.0), speed)
        self.state = State.BRAKING if self._speed else State.STANDING
        return DriveCommand(self._steer, self._speed, -limit, limit)

    def _limit(self, *, braking: bool) -> float:
        car = self.vehicle
        most = car.max_deceleration if braking else car.max_acceleration
        return (most or (_DECELERATION if braking else _ACCELERATION)) + _SPEED.reserve


def _is_on_another_leg(old: Path, was: int | None, new: Path, now: int | None) -> bool:
    """Say whether the place on a new path lies on another leg or lap than on the old one.

    So it may be found where legs lie on each other. The place stays if the segment `was` is in the
    new path too, moved at most by a planner's noise.
    """
    if was is None or now is None or was == now or was + 1 >= min(len(old), len(new)):
        return False
    ends = slice(was, was + 2)
    shift = np.hypot(old.x[ends] - new.x[ends], old.y[ends] - new.y[ends]).max()
    reverse = _is_backwards(old, was)
    if shift > _SHIFT or _is_backwards(new, was) != reverse:
        return False
    return _is_backwards(new, now) != reverse or abs(new.s[now] - new.s[was]) > _ADVANCE


def _is_backwards(path: Path, waypoint: int) -> bool:
    return path.reverse is not None and bool(path.reverse[waypoint])
