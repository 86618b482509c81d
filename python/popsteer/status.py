"""How a control step went: shared by the Rust-backed laws and the pure-Python reference."""

from __future__ import annotations

import enum

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
    """No point of the window lies on the lookahead circle; the last one stands in for it."""
    SATURATED = "saturated"
    """The law wants a larger angle than `max_steer`, or than the lateral acceleration allows."""
