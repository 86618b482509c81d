"""What the monitor remembers: the turns of the last second, the noise, and the steering offset."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from popsteer.reference.bounds import MAX_YAW
from popsteer.reference.error import input_in_range
from popsteer.reference.math import PI, saturate
from popsteer.reference.vehicle.estimator import MAX_GAIN, MAX_STEER_OFFSET, MIN_GAIN

__all__ = ["ALARM_TIME", "LEAST_TIME", "MAX_PERIOD", "MonitorState"]

WINDOW = 1.0
"""Time over which turns are compared [s]."""
SLOWER = 0.1
"""The slower response lags by so much more than the vehicle's parameters say [s]."""
QUICKER = 0.3
"""A quicker one is ahead by this share of that."""
OFFSET = 0.02
"""Unknown steering offset, before the motion has shown it [rad]."""
OFFSET_DOUBT = 2.0
"""How much motion halves it, as `offset_square` [1/s]: a quarter of a second at 8 m/s."""
OFFSET_PRIOR = 8.0
"""Weight of a steering offset of 0 in the least squares [1/s]. Smaller values mistake stuck wheels
for a steering offset; larger values mistake a steering offset for stuck wheels."""
OFFSET_TIME = 10.0
"""Time over which the steering offset is estimated [s]: too long for a fault to pass as one."""
NOISE_TIME = 2.0
"""Time over which the noise is measured [s]."""
NOISE_PRIOR = (0.005, 0.05)
"""Standard deviation of the noise before it is measured [rad], and for how long that counts."""
EXCESS = 0.5
"""The share of the excess of large angles that is let pass: at commands that oscillate from lock to
lock, the tangent amplifies every error of the modelled wheels."""
DEVIATIONS = 5.0
"""How many standard deviations of the noise are let pass."""
LEAST_TIME = 0.2
"""Nothing is concluded before the noise was measured for so long [s]."""
MAX_PERIOD = 0.3
"""Nothing is concluded from a longer period [s]: too much happens in it."""
ALARM_TIME = 2.0
"""How long the vehicle is implausible after it last was beyond what is explained [s]."""
MOST = 1e100
"""Bound that no valid input reaches."""
MOST_RESIDUAL = 1e49
"""The same for a residual: the square of its change is below `MOST`."""


class LastStep(NamedTuple):
    """The last step."""

    wheel: float
    """Angle of the wheels by the vehicle's parameters [rad]."""
    yaw: float | None
    """The yaw last measured [rad]; None where the motion since shows nothing."""
    residual: float | None
    """The turn measured in the last period less the one expected [rad]; None before it."""


class Turns(NamedTuple):
    """Sums over the last second, of which the old terms are forgotten."""

    measured: float = 0.0
    """Turns measured [rad]."""
    expected: float = 0.0
    """Turns expected of the commands [rad]."""
    delayed: float = 0.0
    """The same of a slower response [rad]."""
    rate: float = 0.0
    """The turning rate of the slower response [rad/s]."""
    reach: float = 0.0
    """Turn by a radian of steering offset [rad]: negative where the vehicle drove backwards."""
    excess: float = 0.0
    """How much more the commands would turn the vehicle than in proportion to their angle [rad]."""


class Evidence(NamedTuple):
    """What is known of the noise and of the steering offset."""

    time: float = NOISE_PRIOR[1]
    """How long the noise has been measured, up to `NOISE_TIME` [s]."""
    noise: float = NOISE_PRIOR[0] * NOISE_PRIOR[0]
    """Variance of the noise of the measured yaw [rad²]."""
    offset_square: float = 0.0
    """Turning rates of a radian of steering offset, squared, over the time [1/s]."""
    offset_sum: float = 0.0
    """The same rates times the residuals [rad/s]."""

    def with_noise(self, residual: float, last: float | None, dt: float) -> Evidence:
        """Take in the noise: a yaw with the variance s makes turns whose differences have 6 s."""
        time, noise = saturate(self.time + dt, 0.0, NOISE_TIME), self.noise
        if last is not None:
            change = residual - last
            weight = dt / time if dt < time else 1.0
            noise += (change * change / 6.0 - noise) * weight
        return self._replace(time=time, noise=noise)

    def with_offset(self, residual: float, share: float, dt: float) -> Evidence:
        """Take in the steering offset, by least squares that forget."""
        kept = OFFSET_TIME / (OFFSET_TIME + dt)
        most = MAX_STEER_OFFSET * abs(share) * dt
        return self._replace(
            offset_square=self.offset_square * kept + share * share * dt,
            offset_sum=self.offset_sum * kept + share * saturate(residual, -most, most),
        )


class MonitorState(NamedTuple):
    """What the monitor remembers."""

    last_step: LastStep
    """The last step."""
    turns: Turns
    """The last second."""
    evidence: Evidence
    """The time before."""
    alarm: float
    """Remaining time of the alarm [s]."""
    within: bool
    """Whether the vehicle was within the limit of the deviation."""

    @classmethod
    def settled(cls, wheel: float) -> MonitorState:
        """Give the state with nothing seen yet; the wheels stand at the angle `wheel` [rad]."""
        return cls(LastStep(wheel, None, None), Turns(), Evidence(), alarm=0.0, within=False)

    @classmethod
    def of(cls, state: MonitorState) -> MonitorState:
        """Give the state of plain tuples."""
        last_step, turns, evidence, alarm, within = state
        return cls(LastStep(*last_step), Turns(*turns), Evidence(*evidence), alarm, within)

    def interrupted(self) -> MonitorState:
        """Give the state when the motion until the next step shows nothing."""
        last_step = LastStep(self.last_step.wheel, None, None)
        return self._replace(last_step=last_step, turns=Turns(rate=self.turns.rate))

    def observed(
        self, turn: float, rate: float, excess: float, share: float, dt: float
    ) -> MonitorState:
        """Take in a turn.

        Parameters
        ----------
        turn : float
            What was measured [rad].
        rate : float
            How fast the commands made the vehicle turn [rad/s].
        excess : float
            How much faster the last command would than in proportion to its angle [rad/s].
        share : float
            ... and a radian of steering offset [1/s].
        dt : float
            How long it took [s].

        Returns
        -------
        MonitorState
            The state after it.
        """
        expected = rate * dt
        residual = turn - expected
        kept = WINDOW / (WINDOW + dt)
        slower = self.turns.rate + (rate - self.turns.rate) * (dt / (SLOWER + dt))
        turns = Turns(
            measured=(self.turns.measured + turn) * kept,
            expected=(self.turns.expected + expected) * kept,
            delayed=(self.turns.delayed + slower * dt) * kept,
            rate=slower,
            reach=(self.turns.reach + share * dt) * kept,
            excess=(self.turns.excess + abs(excess) * dt) * kept,
        )
        evidence = self.evidence.with_noise(residual, self.last_step.residual, dt)
        evidence = evidence.with_offset(residual, share, dt)
        last_step = self.last_step._replace(residual=residual)
        return self._replace(last_step=last_step, turns=turns, evidence=evidence)

    def is_beyond(self, tolerance: float) -> bool:
        """Tell whether the turns are beyond what is explained by more than `tolerance` [rad].

        What is expected of the commands is itself explained, so most steps are done with that.
        """
        turns = self.turns
        gap = abs(turns.measured - turns.expected)
        return gap > tolerance and self.unexplained() > tolerance

    def unexplained(self) -> float:
        """Give how far the turns are beyond what is explained, noise taken off [rad]."""
        turns, evidence = self.turns, self.evidence
        offset = evidence.offset_sum / (evidence.offset_square + OFFSET_PRIOR)
        doubt = OFFSET * OFFSET_DOUBT / (OFFSET_DOUBT + evidence.offset_square)
        right, left = (offset - doubt, doubt) if offset < 0.0 else (-doubt, offset + doubt)
        if turns.reach < 0.0:
            right, left = left, right
        quicker = turns.expected + QUICKER * (turns.expected - turns.delayed)
        if quicker < turns.delayed:
            least, most = quicker, turns.delayed
        else:
            least, most = turns.delayed, quicker
        least, most = least + right * turns.reach, most + left * turns.reach
        least = least * (MIN_GAIN if least > 0.0 else MAX_GAIN)
        most = most * (MAX_GAIN if most > 0.0 else MIN_GAIN)
        below, above = least - turns.measured, turns.measured - most
        beyond = below if below > above else above
        return beyond - EXCESS * turns.excess - DEVIATIONS * sqrt(evidence.noise)

    def checked(self) -> MonitorState:
        """Return the same, as floats, where a vehicle could have shown it.

        Raises
        ------
        InputError
            Where it could not.
        """
        (wheel, yaw, residual), turns, evidence = self.last_step, self.turns, self.evidence

        def number(value: float, low: float = -MOST, high: float = MOST) -> float:
            return input_in_range("monitor", value, low, high)

        last_step = LastStep(
            number(wheel, -0.5 * PI, 0.5 * PI),
            None if yaw is None else number(yaw, -MAX_YAW, MAX_YAW),
            None if residual is None else number(residual, -MOST_RESIDUAL, MOST_RESIDUAL),
        )
        return MonitorState(
            last_step,
            Turns(
                number(turns.measured),
                number(turns.expected),
                number(turns.delayed),
                number(turns.rate),
                number(turns.reach),
                number(turns.excess, 0.0),
            ),
            Evidence(
                number(evidence.time, 0.0, NOISE_TIME),
                number(evidence.noise, 0.0),
                number(evidence.offset_square, 0.0),
                number(evidence.offset_sum),
            ),
            number(self.alarm, 0.0, ALARM_TIME),
            self.within,
        )
