"""How a control step went: shared by the Rust-backed controllers and the pure-Python reference."""

from __future__ import annotations

import enum
from typing import Literal


class Status(enum.IntFlag):
    """How a control step went: a set of conditions, each of which may hold beside the others.

    None of them is `OK`. The bits are the same in Rust, Python, arrays (uint32) and files.

    Examples
    --------
    >>> status = Status.SATURATED | Status.END_OF_PATH
    >>> str(status), status.level, int(status)
    ('saturated|end-of-path', 'degraded', 5)
    >>> Status.SATURATED in status, Status.OFF_PATH in status, status == Status.OK
    (True, False, False)
    """

    OK = 0
    """As the controller wants it."""
    SATURATED = 1
    """Degraded: a larger angle, a larger lateral acceleration or a faster move of the wheels is
    wanted than the vehicle allows. The command is limited."""
    LOOKAHEAD_LOST = 2
    """Degraded: no point ahead lies on the lookahead circle. The controller aims at a
    substitute."""
    END_OF_PATH = 4
    """Degraded: the tracked point is past the end of the path. The last segment is followed on as
    a straight line."""
    OFF_PATH = 8
    """Degraded: the vehicle was farther than `lost_distance` from its place, and was searched for
    on the whole path. The controller steers to the place that was found."""
    INPUT_HELD = 16
    """Degraded: the input was refused, or its `dt` is no control period. The last command is
    held."""
    INPUT_LOST = 32
    """Fault: the same of more inputs in a row than `hold_limit`. The last command is repeated;
    stop."""
    DEVIATING = 64
    """Fault: the measured cross-track error is beyond `deviation_limit`, once it was within."""
    IMPLAUSIBLE = 128
    """Fault: what is measured does not belong together. Within the last 2 s the vehicle turned
    otherwise than the commands explain (a wrong sign of the steering, stuck wheels, an unknown dead
    time or lag), or its poses moved otherwise than its speed says, or not at all."""
    PLAN_CUT_SHORT = 256
    """Degraded: the best plan within the vehicle's limits was not found in the time that a step
    may take. The command is that of the best plan found, which keeps them."""
    POSE_STALE = 512
    """Degraded: the position repeats the last one, though the vehicle drives. The pose is rolled
    forward; after 0.6 s that is `IMPLAUSIBLE`."""
    OUTLIER = 1024
    """Degraded: the pose is farther off than speed and wheels explain. The expected one takes its
    place, until poses that agree with each other show that the localisation has jumped."""
    STEER_LIMIT = 2048
    """Degraded, with `SATURATED`: it is the largest angle of the wheels that limits."""
    RATE_LIMIT = 4096
    """Degraded, with `SATURATED`: it is the rate of the wheels."""
    LATERAL_LIMIT = 8192
    """Degraded, with `SATURATED`: it is the lateral acceleration."""
    TOO_FAST = 16384
    """Degraded: the vehicle's lateral acceleration is beyond its `max_lateral_acceleration` by the
    measured turn, or, for preview POP, will be in a bend ahead even if it brakes in comfort; or
    POP, Stanley or PID join the path faster than wheels of `max_steer_rate` can end the turn."""

    @property
    def level(self) -> Literal["ok", "degraded", "fault"]:
        """How bad the worst of the conditions is.

        Returns
        -------
        str
            "ok", "degraded" or "fault".

        Examples
        --------
        >>> Status.OK.level, Status.SATURATED.level, (Status.OFF_PATH | Status.INPUT_LOST).level
        ('ok', 'degraded', 'fault')
        """
        if self & _FAULTS:
            return "fault"
        return "degraded" if self else "ok"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the conditions that hold, from the lowest bit up.

        Returns
        -------
        tuple of str
            None for `OK`.

        Examples
        --------
        >>> (Status.INPUT_LOST | Status.LOOKAHEAD_LOST).names, Status.OK.names
        (('lookahead-lost', 'input-lost'), ())
        """
        return tuple(name for condition, name in _NAMES if self & condition)

    def __str__(self) -> str:
        return "|".join(self.names) or "ok"

    def __format__(self, spec: str) -> str:
        return format(str(self), spec)


_NAMES = tuple(
    (condition, name.lower().replace("_", "-"))
    for name, condition in Status.__members__.items()
    if condition
)
_FAULTS = Status.INPUT_LOST | Status.DEVIATING | Status.IMPLAUSIBLE
