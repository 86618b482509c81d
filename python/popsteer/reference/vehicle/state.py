"""Pose and speed of the vehicle, checked at every step."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING

from popsteer.reference.bounds import MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT
from popsteer.reference.error import as_float, input_in_range, input_within
from popsteer.reference.math import cos, saturate, sin, wrap

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.reference.geometry import Point


@dataclass(frozen=True)
class VehicleState:
    """Pose of the vehicle's point, and speed."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # heading [rad], counter-clockwise from x
    speed: float  # forward [m/s]; negative while rolling backwards

    def checked(self) -> VehicleState:
        """Return the state, as floats, each finite and within its bound; else raise InputError."""
        return VehicleState(
            x=input_within("x", self.x, MAX_COORDINATE),
            y=input_within("y", self.y, MAX_COORDINATE),
            yaw=input_within("yaw", self.yaw, MAX_YAW),
            speed=input_within("speed", self.speed, MAX_SPEED),
        )

    def bounded(self) -> VehicleState:
        """Return a predicted state brought within the bounds of one that is given.

        Places and speeds beyond them are put onto them, a yaw beyond them is turned back by whole
        turns.
        """
        return VehicleState(
            x=saturate(self.x, -MAX_COORDINATE, MAX_COORDINATE),
            y=saturate(self.y, -MAX_COORDINATE, MAX_COORDINATE),
            yaw=self.yaw if abs(self.yaw) <= MAX_YAW else wrap(self.yaw),
            speed=saturate(self.speed, -MAX_SPEED, MAX_SPEED),
        )

    def ahead(self, offset: float) -> VehicleState:
        """Return the same vehicle by the pose of a point `offset` [m] farther ahead."""
        if abs(offset) <= 0.0:
            return self
        x, y = self.point_ahead(offset)
        return VehicleState(x, y, self.yaw, self.speed)

    def left(self, offset: float) -> VehicleState:
        """Return the same vehicle by the pose of a point `offset` [m] farther left, bounded."""
        if abs(offset) <= 0.0:
            return self
        x, y = self.x - offset * sin(self.yaw), self.y + offset * cos(self.yaw)
        return VehicleState(x, y, self.yaw, self.speed).bounded()

    def point_ahead(self, offset: float) -> Point:
        """Return the point `offset` [m] ahead along the heading."""
        return self.x + offset * cos(self.yaw), self.y + offset * sin(self.yaw)

    def forward_speed(self) -> float:
        """Return the speed while rolling forward, else 0 [m/s]: what controllers steer by."""
        return self.speed if self.speed > 0.0 else 0.0


def checked_dt(dt: float) -> float:
    """Return `dt` [s], where it is a control period that a step can take; else raise InputError."""
    return input_in_range("dt", dt, MIN_DT, MAX_DT)


def period(dt: float) -> float | None:
    """Return `dt` [s] as a step takes it; None where it is finite and no control period.

    So it is where a clock was set or repeats a stamp. Raises InputError for one that is not finite.
    """
    dt = as_float(dt)
    return checked_dt(dt) if MIN_DT <= dt <= MAX_DT or not isfinite(dt) else None


def checked_point(point: Iterable[float]) -> Point:
    """Return a point whose coordinates are finite and within their bound; else `InputError`."""
    x, y = point
    return input_within("x", x, MAX_COORDINATE), input_within("y", y, MAX_COORDINATE)
