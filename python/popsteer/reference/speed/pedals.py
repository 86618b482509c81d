"""Throttle and brake."""

from __future__ import annotations

from typing import NamedTuple

from popsteer.reference.math import saturate


class Pedals(NamedTuple):
    """Throttle and brake, each in 0 to 1; never both."""

    throttle: float
    """Throttle, 0 to 1."""
    brake: float
    """Brake, 0 to 1."""

    @classmethod
    def from_command(cls, command: float) -> Pedals:
        """Throttle where `command` is positive, brake where it is negative."""
        return cls(saturate(command, 0.0, 1.0), saturate(-command, 0.0, 1.0))
