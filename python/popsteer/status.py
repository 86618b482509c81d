"""How a control step went: shared by the Rust-backed laws and the pure-Python reference."""

from __future__ import annotations

import enum
from typing import Literal

__all__ = ["Status"]


class Status(str, enum.Enum):
    """How a control step went; each member is also the string that is its value.

    Examples
    --------
    >>> Status("lookahead-lost") is Status.LOOKAHEAD_LOST, Status.OK == "ok"
    (True, True)
    """

    OK = "ok"
    """As the law wants it."""
    LOOKAHEAD_LOST = "lookahead-lost"
    """Degraded: no point ahead lies on the lookahead circle. A stand-in is aimed at."""
    SATURATED = "saturated"
    """Degraded: the law wants a larger angle than `max_steer` or the lateral acceleration allows,
    or a faster move than the actuator makes. The command is limited."""
    END_OF_PATH = "end-of-path"
    """Degraded: the reference point is past the end of the path. The last segment is followed on
    as a straight line."""
    OFF_PATH = "off-path"
    """Degraded: the vehicle was farther than `lost_distance` from its place on the path, and was
    looked for on the whole of it. The law steers to where it was found."""
    INPUT_HELD = "input-held"
    """Degraded: the input was refused. The last angle is held."""
    INPUT_LOST = "input-lost"
    """Fault: more inputs in a row were refused than are held. The last angle stands; stop."""

    @property
    def level(self) -> Literal["ok", "degraded", "fault"]:
        """How bad it is.

        Returns
        -------
        str
            "ok", "degraded" or "fault".

        Examples
        --------
        >>> Status.OK.level, Status.SATURATED.level, Status.INPUT_LOST.level
        ('ok', 'degraded', 'fault')
        """
        if self is Status.OK:
            return "ok"
        return "fault" if self is Status.INPUT_LOST else "degraded"
