"""The chain from a command to the heading, simulated along a log with numpy.

    shaft' = clip((command(t - dead_time) + steer_offset - shaft) / steer_lag, ±max_steer_rate)
    wheel  = shaft within half of steer_play, which it leaves only when it is pushed
    yaw'   = v tan(wheel) / (turning_wheelbase + understeer v²)

That is `Vehicle`'s chain, where the lag is that of the wheels. In most cars the larger part of it
is that of the yaw rate behind the wheels; on tyres it changes with the speed. At constant speed the
three cannot be distinguished. If a car brakes into a bend and accelerates out of it, they differ by
up to 10 ms of delay, so the fit tries them all. Cars have both: `tyre_lag` is the part of the
wheels' lag that tyres have behind them.

Also, braking loads the front tyres, and the car turns more; with `load_shift`

    understeer + load_shift v'

replaces `understeer`. A controller does not use it. Without it the fit would attribute its effect
to the delay: the dead time of a CommonRoad car on a race track comes out 20 ms too short.

And tyres slip, by `front_slip` of the force across the front wheels, and by what understeer leaves
of that at the rear axle. The tangent is of the rest of the angle:

    front = front_slip v yaw',  rear = (front_slip - understeer) v yaw'
    yaw'  = v (tan(wheel - front / cos(wheel)) + front + tan(rear) - rear) / length
    length = turning_wheelbase + understeer v²

Without this the length of a car that turns sharply comes out 0.5 % too long, its commands look as
if they asked for smaller angles, and its understeer is off by several of its errors. The lag of
these tyres, of the linear bicycle's poles less that of its zero, is

    v (T / length + understeer - front_slip)

with a T of cornering stiffnesses and inertia (M. Mitschke, H. Wallentowitz, *Dynamik der
Kraftfahrzeuge*, 2004). The lag at the usual speed gives it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from popsteer._core import _lagged, _Wheels
from popsteer.identification.arrays import chords, summed

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.identification.drive import Array, PreparedLog

LagOf = Literal["wheels", "yaw rate", "tyres"]
CLEARLY = 1.2
"""What asks for this many times the limit of the rate, at least, is against it."""
LONGEST = 0.1
"""A command that comes later than this after the last [s] is a step."""
_MOST_ANGLE = 1.5
_REMEMBERED = 24
_Found = TypeVar("_Found")


def kept(wheels: _Wheels) -> float:
    """Give for how long wheels kept the limit of their rate [s], where it is clearly exceeded.

    In stretches in which a command asks for `CLEARLY` times as much.
    """
    if wheels.rate is None:
        return 0.0
    times, turning, changes = wheels.times, wheels.turning, np.diff(wheels.commands)
    between = np.diff(times[1:][changes != 0.0])
    interval = min(float(np.median(between)) if len(between) else LONGEST, LONGEST)
    asked = np.concatenate(([False], np.abs(changes) > CLEARLY * wheels.rate * interval))
    # A stretch at the limit ends with the first command that the wheels reach.
    stretch = np.cumsum(np.append(0, turning[:-1] < 0.999 * np.diff(times)))
    most = np.bincount(stretch, turning)
    return float(most[np.bincount(stretch, asked) > 0].sum())


@dataclass(eq=False)
class Chain:
    """The simulated car of a drive; it remembers what it computed last of its wheels."""

    drive: PreparedLog
    lag_of: LagOf = "yaw rate"
    _remembered: dict[tuple[float | None, ...], Any] = field(default_factory=dict)

    def yaw(self, **values: float) -> Array:
        """Simulate the heading [rad] at the log's samples, 0 at the first, as `rate` does."""
        rate, drive = self.rate(**values), self.drive
        found: Array = np.interp(drive.t, drive.edges, summed(rate) * drive.cell)
        cells, bent = self._within
        if bent.any():  # between edges the heading is no straight line: lag would take that up
            found -= bent * np.gradient(rate)[cells]
        return found

    @cached_property
    def _within(self) -> tuple[NDArray[np.int64], Array]:
        """The cell of each sample; how 1 rad/s more in the next one bends the heading there."""
        at = (self.drive.t - self.drive.edges[0]) / self.drive.cell
        cells = np.clip(at.astype(np.int64), 0, len(self.drive.speed) - 1)
        since = np.round(at - cells, 6)
        return cells, 0.5 * self.drive.cell * since * (1.0 - since)

    def place(self, **values: float) -> NDArray[np.complex128]:
        """Simulate where the no-slip point is at the samples, east + i north [m], 0 at first."""
        heading = summed(self.rate(**values)) * self.drive.cell
        driven = summed(self.drive.speed * chords(heading)) * self.drive.cell
        found: NDArray[np.complex128] = np.interp(self.drive.t, self.drive.edges, driven)
        return found

    def rate(  # noqa: PLR0913 - a parameter of the vehicle each
        self,
        *,
        turning_wheelbase: float,
        understeer: float,
        steer_offset: float,
        steer_lag: float,
        dead_time: float,
        load_shift: float = 0.0,
        front_slip: float = 0.0,
        tyre_lag: float = 0.0,
        max_steer_rate: float | None = None,
        steer_play: float = 0.0,
        steer_scale: float = 1.0,
    ) -> Array:
        """Simulate the mean yaw rate of each cell [rad/s].

        The parameters are those of `Vehicle`; each m/s² of acceleration adds `load_shift` v²
        [s⁴/m²] to the turning wheelbase, each m/s² across the front wheels `front_slip` [rad s²/m]
        to the slip of their tyres, and a command of 1 asks for `steer_scale` [rad]. Of the lag
        `tyre_lag` is behind the wheels: so much at the usual speed.
        """
        behind = tyre_lag if self.lag_of == "wheels" else steer_lag
        wheels = self.wheels(steer_lag - behind, max_steer_rate)
        given = (dead_time, steer_scale, steer_offset)
        wheel, tangent = self._once(
            (wheels.lag, wheels.rate, *given, steer_play),
            lambda: self._turned(wheels, given, steer_play),
        )
        speed = self.drive.speed
        slope = understeer + load_shift * self.drive.acceleration
        # Far from the answer the length may cross zero; it is kept from there.
        length = np.maximum(turning_wheelbase + slope * speed * speed, 1e-3)
        turning: Array = speed * tangent / length
        for _ in range(2 if front_slip else 0):  # the slip is that of the turn that it leaves
            aside = speed * turning
            front, rear = front_slip * aside, (front_slip - slope) * aside
            bent = np.tan(wheel - front / np.cos(wheel)) + front + np.tan(rear) - rear
            turning = speed * bent / length
        if behind == 0.0:
            return turning
        lag = np.full_like(turning, behind)
        if self.lag_of != "yaw rate":
            usual, of_zero = self.drive.usual_speed, max(front_slip - understeer, 0.0)
            usual_length = max(turning_wheelbase + understeer * usual * usual, 1e-3)
            of_poles = (behind / usual + of_zero) * usual_length / length
            lag = np.abs(speed) * (of_poles - of_zero)
        return _lagged(turning, np.maximum(lag, 0.0), self.drive.cell)

    def wheels(self, lag: float, rate: float | None = None) -> _Wheels:
        """Give the wheels with a lag of their own, without dead time and offset."""
        key = (max(lag, 0.0) if self.lag_of == "wheels" else 0.0, rate)
        return self._once(key, lambda: _Wheels(self.drive.times, self.drive.commands, *key))

    def _turned(
        self, wheels: _Wheels, given: tuple[float, float, float], play: float
    ) -> tuple[Array, Array]:
        """Give the mean angle of the wheels in each cell, and its tangent."""
        edges, (dead_time, scale, offset) = self.drive.edges, given
        if play > 0.0:
            total = wheels.behind_play(edges, *given, play)
        else:
            key = (wheels.lag, wheels.rate, dead_time)
            integral = self._once(key, lambda: wheels.integral(edges - dead_time))
            total = integral * scale + offset * edges
        wheel = np.clip(np.diff(total) / self.drive.cell, -_MOST_ANGLE, _MOST_ANGLE)
        return wheel, np.tan(wheel)

    def _once(self, key: tuple[float | None, ...], make: Callable[[], _Found]) -> _Found:
        """Make it, or remember it: a derivative changes one parameter of all at a time."""
        if key not in self._remembered:
            if len(self._remembered) >= _REMEMBERED:
                del self._remembered[next(iter(self._remembered))]
            self._remembered[key] = make()
        found: _Found = self._remembered[key]
        return found
