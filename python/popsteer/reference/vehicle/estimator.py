"""What the motion of a vehicle shows of it: the one estimator of all controllers.

The turning is found by least squares that forget: with the turn a that the vehicle's own figures
expect and the turn b of one radian of steering offset, a measured turn is gain (a + steer_offset
b), linear in gain and gain steer_offset. A dead time that is wrong turns the vehicle too early or
too late: it is found from the turn that is left over and the rate at which the expected turn
changes. The slip, the angle of the motion to the heading, is found from the position by normalised
least mean squares.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from popsteer.reference.error import config_in_range, config_optional, input_in_range
from popsteer.reference.limits import MAX_COORDINATE, MAX_SPEED, MAX_YAW
from popsteer.reference.math import cos, exp, saturate, sin, wrap
from popsteer.reference.vehicle.state import VehicleState

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.wheels import Reached

__all__ = ["AdaptParams", "Corrections", "Estimate", "Estimator"]

ACCELERATION_TIME = 0.1
"""Time over which the acceleration is taken [s]."""
GAIN_PRIOR = 1e-4
"""Weight of the vehicle's own gain, 1, in the least squares [rad²].

Larger values make the estimate slower and steadier; 3e-4 is one turn of 1°.
"""
OFFSET_PRIOR = 0.1
"""Weight of the vehicle's own steering offset in the least squares.

Larger values make the estimate slower and steadier; 0.1 are three periods in which a radian turns
by 10°.
"""
CHANGE_PRIOR = 1e-2
"""Weight of the vehicle's own dead time in the least squares [rad²/s²]."""
MIN_GAIN, MAX_GAIN = 0.4, 2.5
"""Bounds of the gain: beyond them the figures are those of another vehicle."""
MAX_STEER_OFFSET = 0.15
"""The largest steering offset that is believed [rad]."""
MAX_SLIP = 0.15
"""The largest slip that is believed [rad]."""
SLIP_SPLIT = 0.03
"""Curvature, times the wheelbase, at which a slip sample updates both parts of the slip equally.

The parts are the constant and the curvature-dependent one. Below it a bend is treated as straight.
"""
LEAST_TRAVEL = 1e-9
"""Less than the slowest vehicle travels in the shortest period at its default `min_speed` [m].

A curvature over a distance much shorter than this could not be told from infinity.
"""
MAX_ACCELERATION = 20.0
"""The largest acceleration that is believed, in wheelbases [1/s²]."""
MAX_SUM = 1e100
"""More than a sum comes to within the bounds of the input."""
MAX_TURN = 1e30
"""More than a turn comes to, and little enough that squares of its changes keep to `MAX_SUM`."""


@dataclass(frozen=True, kw_only=True)
class AdaptParams:
    """How fast a controller adapts to its vehicle.

    Attributes
    ----------
    turn_time : float
        Time over which turning gain, steering offset and dead time are estimated [s]; 0 never.
        Shorter: sooner right, and more noise of the heading passed on.
    slip_time : float
        Time over which the slip is estimated, straight on and in bends [s]; 0 never. Shorter:
        sooner right, and more noise of the position passed on.
    min_speed : float or None
        Below this speed the slip is not estimated [m/s]: the position moves too little to show it;
        None is 5/3 wheelbases a second.

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> AdaptParams(turn_time=20)
    AdaptParams(turn_time=20.0, slip_time=5.0, min_speed=None)
    """

    turn_time: float = 10.0
    slip_time: float = 5.0
    min_speed: float | None = None

    def __post_init__(self) -> None:
        config_in_range(self, "turn_time", 0.0, 1e6)
        config_in_range(self, "slip_time", 0.0, 1e6)
        config_optional(self, "min_speed", 0.0, 1e3)


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What is known of the vehicle: its own figures, corrected by what its motion has shown.

    Attributes
    ----------
    gain : float
        How many times more the vehicle turns than its figures say. Controllers use it where the
        vehicle has a dead time; elsewhere it is only shown.
    steer_offset : float
        Angle of the wheels at the command 0 [rad].
    dead_time : float
        Time from a command to its first effect on the wheels [s].
    slip : float
        Angle of the motion of the point that does not slip to the heading, straight on [rad].
    slip_length : float
        How much that angle grows with the curvature [m].
    acceleration : float
        Acceleration [m/s²].

    Examples
    --------
    >>> from popsteer.reference import Path, PreviewPop, Vehicle
    >>> controller = PreviewPop(Path([(0.0, 0.0), (9.0, 0.0)]), Vehicle(dead_time=0.2))
    >>> controller.estimate.gain, controller.estimate.dead_time
    (1.0, 0.2)
    """

    gain: float = 1.0
    steer_offset: float = 0.0
    dead_time: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0


@dataclass(frozen=True)
class Corrections:
    """What is known of the vehicle beyond its own figures; `Estimate` in the Rust core.

    Attributes
    ----------
    gain : float
        How many times more the vehicle turns than its figures say; as a controller uses it, 1
        without a dead time.
    steer_offset : float
        Angle of the wheels at the command 0, beyond the vehicle's `steer_offset` [rad].
    longer_dead_time : float
        How much longer the dead time is than the vehicle's [s].
    slip : float
        Angle of the motion of the point that does not slip to the heading, straight on [rad].
    slip_length : float
        How much that angle grows with the curvature [m].
    acceleration : float
        Acceleration [m/s²].
    """

    gain: float = 1.0
    steer_offset: float = 0.0
    longer_dead_time: float = 0.0
    slip: float = 0.0
    slip_length: float = 0.0
    acceleration: float = 0.0

    def speed_after(self, speed: float, time: float) -> float:
        """Return the speed `time` [s] on from `speed` [m/s]; a vehicle that brakes stops.

        Examples
        --------
        >>> Corrections(acceleration=-4.0).speed_after(1.0, 0.5)
        0.0
        """
        following = speed + self.acceleration * time
        if speed >= 0.0:
            return saturate(following, 0.0, MAX_SPEED)
        return saturate(following, -MAX_SPEED, 0.0)

    def of(self, vehicle: Vehicle) -> Estimate:
        """Return the corrected figures of `vehicle`."""
        return Estimate(
            gain=self.gain,
            steer_offset=vehicle.steer_offset + self.steer_offset,
            dead_time=vehicle.dead_time + self.longer_dead_time,
            slip=self.slip,
            slip_length=self.slip_length,
            acceleration=self.acceleration,
        )


@dataclass(frozen=True)
class Estimator:
    """What an estimate rests on; sums of which the old terms are forgotten.

    Attributes
    ----------
    last_measured : VehicleState or None
        The point that does not slip as it was last seen; None where the motion since shows
        nothing.
    turn_turn : float
        Turns expected, squared [rad²].
    turn_offset : float
        Turns expected times those of a radian of offset [rad].
    offset_offset : float
        Turns of a radian of offset, squared.
    turn_measured : float
        Turns expected times those measured [rad²].
    offset_measured : float
        Turns of a radian of offset times those measured [rad].
    turn : float
        The turn expected for the last period [rad].
    change : float
        Rates at which the expected turns changed, squared [rad²/s²].
    estimate : Corrections
        What is known by now.

    Examples
    --------
    The motion over 0.1 s of a vehicle whose figures say that it goes straight on:

    >>> from popsteer.reference.vehicle import Vehicle
    >>> from popsteer.reference.vehicle.wheels import Reached
    >>> estimator = Estimator(last_measured=VehicleState(0.0, 0.0, 0.0, 10.0))
    >>> now = VehicleState(1.0, 0.0, 0.01, 10.0)
    >>> for _ in range(100):
    ...     estimator = estimator.observe_turn(
    ...         AdaptParams(), Vehicle(), now, Reached(turn=0.0, slope=0.1), dt=0.1
    ...     )
    >>> round(estimator.estimate.steer_offset, 2)  # 0.01 rad a metre, times the wheelbase
    0.03
    """

    last_measured: VehicleState | None = None
    turn_turn: float = 0.0
    turn_offset: float = 0.0
    offset_offset: float = 0.0
    turn_measured: float = 0.0
    offset_measured: float = 0.0
    turn: float = 0.0
    change: float = 0.0
    estimate: Corrections = Corrections()

    def observe_turn(
        self,
        params: AdaptParams,
        vehicle: Vehicle,
        now: VehicleState,
        reached: Reached,
        dt: float,
    ) -> Estimator:
        """Take in the turn since the last step, and how the speed changed.

        The step was `dt` [s] ago, and `reached` reached the wheels since; `now` is the state of
        the point that does not slip.
        """
        before = self.last_measured
        if before is None:
            return replace(self, turn=0.0)
        speed = 0.5 * (before.speed + now.speed)
        share = speed / vehicle.turning_length(speed)
        turn, by_offset = share * reached.turn, share * reached.slope
        acceleration = _acceleration(vehicle, self.estimate, before, now, dt)
        after = self
        if params.turn_time > 0.0:
            measured = wrap(now.yaw - before.yaw)
            after = self._fit_turning(params.turn_time, vehicle, turn, by_offset, measured, dt)
        estimate = replace(after.estimate, acceleration=acceleration)
        return replace(after, turn=turn, estimate=estimate)

    def _fit_turning(
        self,
        time: float,
        vehicle: Vehicle,
        turn: float,
        by_offset: float,
        measured: float,
        dt: float,
    ) -> Estimator:
        """Least squares that forget, for gain, steering offset and dead time.

        No sample counts for more than a turn thrice as large as expected with twice the largest
        offset, or than the longest dead time: a jump of the localisation shows nothing.
        """

        def expected(estimate: Corrections) -> float:
            return estimate.gain * (turn + estimate.steer_offset * by_offset)

        most = 2.0 * (abs(turn) + MAX_STEER_OFFSET * abs(by_offset))
        before = expected(self.estimate)
        measured = before + saturate(measured - before, -most, most)
        kept = exp(-dt / time)
        after = replace(
            self,
            turn_turn=self.turn_turn * kept + turn * turn,
            turn_offset=self.turn_offset * kept + turn * by_offset,
            offset_offset=self.offset_offset * kept + by_offset * by_offset,
            turn_measured=self.turn_measured * kept + turn * measured,
            offset_measured=self.offset_measured * kept + by_offset * measured,
        )
        estimate = self.estimate
        fitted = after.fitted_gain()
        if fitted is not None:
            # Without commands in flight the gain is left to the feedback: one that is fitted
            # through a lag that is not quite right would cost it margin.
            gain = fitted if vehicle.dead_time > 0.0 else 1.0
            # The offset that goes with the gain, also where that is not the free one.
            offset_turn = after.offset_measured - after.turn_offset * gain
            offset = offset_turn / (after.offset_offset + OFFSET_PRIOR) / gain
            offset = saturate(offset, -MAX_STEER_OFFSET, MAX_STEER_OFFSET)
            estimate = replace(estimate, gain=gain, steer_offset=offset)

        change = (self.turn - turn) / dt
        most_longer = _most_longer(vehicle)
        residual = measured - expected(estimate)
        most = abs(change) * most_longer
        changes = self.change * kept + change * change
        correction = saturate(residual, -most, most) * change / (changes + CHANGE_PRIOR)
        correction = saturate(correction, -dt, dt)
        longer = saturate(estimate.longer_dead_time + correction, -most_longer, most_longer)
        estimate = replace(estimate, longer_dead_time=longer)
        return replace(after, change=changes, estimate=estimate)

    def fitted_gain(self) -> float | None:
        """Return the gain by the normal equations of gain and gain times steering offset."""
        aa, ab = self.turn_turn + GAIN_PRIOR, self.turn_offset
        bb = self.offset_offset + OFFSET_PRIOR
        ay, by = self.turn_measured + GAIN_PRIOR, self.offset_measured
        determinant = aa * bb - ab * ab
        if not determinant > 0.0:
            return None
        return saturate((ay * bb - ab * by) / determinant, MIN_GAIN, MAX_GAIN)

    def known(self) -> Corrections:
        """Return what is known by now, with the gain also where no controller uses it."""
        gain = self.fitted_gain()
        return self.estimate if gain is None else replace(self.estimate, gain=gain)

    def observe_slip(
        self,
        params: AdaptParams,
        vehicle: Vehicle,
        now: VehicleState,
        curvature: Callable[[float], float],
        dt: float,
    ) -> Estimator:
        """Take in the motion since the last step, `dt` [s] ago.

        `curvature` tells by how much the path turns [1/m] over a distance travelled [m], counted
        in the direction in which the vehicle looks. It is the path's: the vehicle's own answers to
        the errors of the position, which are in the sample too, would be taken for slip.
        """
        before = self.last_measured
        if before is None or not params.slip_time > 0.0:
            return self
        pace = 5.0 / 3.0 * vehicle.wheelbase if params.min_speed is None else params.min_speed
        speed = 0.5 * (before.speed + now.speed)
        travel = speed * dt
        if abs(speed) < pace or abs(travel) < LEAST_TRAVEL:
            return self
        direction = before.yaw + 0.5 * wrap(now.yaw - before.yaw)
        aside = (now.y - before.y) * cos(direction) - (now.x - before.x) * sin(direction)
        bend = curvature(travel)
        sample = saturate(aside / travel, -4.0 * MAX_SLIP, 4.0 * MAX_SLIP)
        split = SLIP_SPLIT / vehicle.wheelbase
        estimate = self.estimate
        missed = sample - (estimate.slip + estimate.slip_length * bend)
        share = dt / params.slip_time if dt < params.slip_time else 1.0
        step = share * missed / (split * split + bend * bend)
        slip = saturate(estimate.slip + step * (split * split), -MAX_SLIP, MAX_SLIP)
        slip_length = saturate(
            estimate.slip_length + step * bend, -vehicle.wheelbase, vehicle.wheelbase
        )
        return replace(self, estimate=replace(estimate, slip=slip, slip_length=slip_length))

    def checked(self, vehicle: Vehicle) -> Estimator:
        """Return the estimator, as floats, where `vehicle` could have shown it.

        Raises
        ------
        InputError
            Naming the field that is not.
        """
        last_measured = self.last_measured
        if last_measured is not None:
            most = 2.0 * MAX_COORDINATE
            last_measured = VehicleState(
                x=input_in_range("last_measured", last_measured.x, -most, most),
                y=input_in_range("last_measured", last_measured.y, -most, most),
                yaw=input_in_range("last_measured", last_measured.yaw, -MAX_YAW, MAX_YAW),
                speed=input_in_range("last_measured", last_measured.speed, -MAX_SPEED, MAX_SPEED),
            )
        sums = {
            field: input_in_range(field, getattr(self, field), low, MAX_SUM)
            for field, low in (
                ("turn_turn", 0.0),
                ("turn_offset", -MAX_SUM),
                ("offset_offset", 0.0),
                ("turn_measured", -MAX_SUM),
                ("offset_measured", -MAX_SUM),
                ("change", 0.0),
            )
        }
        turn = input_in_range("turn", self.turn, -MAX_TURN, MAX_TURN)
        estimate = self.estimate
        gain = input_in_range("gain", estimate.gain, MIN_GAIN, MAX_GAIN)
        others = {
            field: input_in_range(field, getattr(estimate, field), -most, most)
            for field, most in (
                ("steer_offset", MAX_STEER_OFFSET),
                ("longer_dead_time", _most_longer(vehicle)),
                ("slip", MAX_SLIP),
                ("slip_length", vehicle.wheelbase),
                ("acceleration", MAX_ACCELERATION * vehicle.wheelbase),
            )
        }
        estimate = Corrections(gain=gain, **others)
        return Estimator(last_measured=last_measured, turn=turn, estimate=estimate, **sums)


def _most_longer(vehicle: Vehicle) -> float:
    """Return how far an estimated dead time may be from the vehicle's [s]."""
    return 0.5 * vehicle.dead_time


def _acceleration(
    vehicle: Vehicle, estimate: Corrections, before: VehicleState, now: VehicleState, dt: float
) -> float:
    """Return the acceleration after a period [m/s²]: its mean, of which the old is forgotten."""
    most = MAX_ACCELERATION * vehicle.wheelbase
    gained = (now.speed - before.speed) / dt - estimate.acceleration
    weight = 1.0 - exp(-dt / ACCELERATION_TIME)
    return saturate(estimate.acceleration + weight * gained, -most, most)
