"""POP over a horizon: a bicycle with a lag, where the paper predicts a point over one step."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, decay, sin
from popsteer.reference.path.view import get_distance
from popsteer.reference.vehicle.predict import kinematic_bicycle, steps

if TYPE_CHECKING:
    from popsteer.reference.path.view import Point

__all__ = ["Model", "Rollout"]


@dataclass(frozen=True)
class Model:
    """What is predicted, and how far.

    Attributes
    ----------
    horizon : float
        How long the prediction looks ahead [s].
    wheelbase : float
        Distance of the axles [m].
    understeer : float
        Understeer [s²/m]: yaw rate = v tan δ / (wheelbase + understeer v²).
    steer_lag : float
        Time constant with which the wheels follow their command [s].
    reference_offset : float
        How far ahead of the rear axle the point lies that is to come near the target [m].
    """

    horizon: float
    wheelbase: float
    understeer: float
    steer_lag: float
    reference_offset: float

    def follow(self, wheel: float, steer: float, dt: float) -> float:
        """Return the wheels from `wheel` after `dt` [s] of the command `steer` [rad]."""
        return steer + (wheel - steer) * decay(dt, self.steer_lag)

    def rollout(self, yaw: float, speed: float, wheel: float, dt: float) -> Rollout:
        """Place the model with its reference point at the origin, its wheels at `wheel` [rad].

        Its steps are of `dt` [s], the control period, or longer.
        """
        count, period = steps(self.horizon, dt)
        return Rollout(
            count=count,
            period=period,
            kept=decay(period, self.steer_lag),
            length=self.wheelbase + self.understeer * speed * speed,
            reference_offset=self.reference_offset,
            x=-self.reference_offset * cos(yaw),
            y=-self.reference_offset * sin(yaw),
            yaw=yaw,
            speed=speed,
            wheel=wheel,
        )


@dataclass(frozen=True)
class Rollout:
    """The model at the origin, about to be rolled forward.

    Attributes
    ----------
    count : int
        The number of steps.
    period : float
        How long each is [s].
    kept : float
        What is left after a step of a difference between the wheels and their command.
    length : float
        What turns an angle into a curvature: tan δ / length [m].
    reference_offset : float
        How far ahead of the rear axle the reference point lies [m].
    x, y, yaw, speed, wheel : float
        The rear axle [m], heading [rad], speed [m/s] and wheels [rad] at the start.
    """

    count: int
    period: float
    kept: float
    length: float
    reference_offset: float
    x: float
    y: float
    yaw: float
    speed: float
    wheel: float

    def get_least_distance(self, steer: float, target: Point) -> float:
        """Return how near to `target` the reference point comes in any step under `steer` [m]."""
        x, y, yaw, wheel = self.x, self.y, self.yaw, self.wheel
        least = inf
        for _ in range(self.count):
            wheel = steer + (wheel - steer) * self.kept
            x, y, yaw, _ = kinematic_bicycle(
                x, y, yaw, self.speed, wheel, 0.0, self.length, self.period
            )
            reference = (
                x + self.reference_offset * cos(yaw),
                y + self.reference_offset * sin(yaw),
            )
            distance = get_distance(reference, target)
            if distance < least:
                least = distance
        return least

    def spread(self, span: float) -> float:
        """Return about how much the distances of candidates `span` [rad] apart differ [m]."""
        reach = self.count * self.period * self.speed
        turn = reach * span / self.length
        return reach * turn * turn
