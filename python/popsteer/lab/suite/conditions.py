"""The conditions of the suite: what is not as in the laboratory."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Condition:
    """What differs from a car that is as told and sensors that are exact."""

    title: str
    """What a reader recognises."""
    plant: Mapping[str, float] = field(default_factory=dict)
    """Fields of the plant that differ."""
    is_told: bool = True
    """Whether the controllers are told of these."""
    wheelbase: float = 1.0
    """The wheelbases that the controllers are told, as shares of the true ones."""
    position: float = 0.0
    """Noise of x and of y, standard deviation [m]."""
    yaw: float = 0.0
    """Noise of the heading [rad]."""
    path: float = 0.0
    """Noise of the waypoints of a path that is fresh every cycle [m]; 0: one path for all."""
    smoothed: bool = False
    """Whether all controllers get those waypoints smoothed, by the same local quadratics."""
    loss: float = 0.0
    """Share of the cycles in which no pose arrives."""
    play: float = 0.0
    """Play of the steering, from side to side [rad]."""
    grade: float = 0.0
    """Slope of the road along the path; nobody is told."""


_LATE = {"dead_time": 0.15}

CONDITIONS: dict[str, Condition] = {
    "as told": Condition("As told"),
    "dead time told": Condition("Dead time of 0.15 s, told", plant=_LATE),
    "dead time untold": Condition("Dead time of 0.15 s, not told", plant=_LATE, is_told=False),
    "noise": Condition("Noise of 5 cm and 0.01 rad", position=0.05, yaw=0.01),
    "play": Condition("Play of 1°", play=0.017453292519943295),
    "fresh path": Condition("A fresh path each cycle, 2 cm of noise", path=0.02),
    "smoothed path": Condition("... smoothed alike for all", path=0.02, smoothed=True),
    "loss": Condition("A fifth of the poses lost", loss=0.2),
    "wheelbase +20 %": Condition("Told a wheelbase 20 % too long", wheelbase=1.2),
    "wheelbase -20 %": Condition("Told a wheelbase 20 % too short", wheelbase=0.8),
    "slope": Condition("Slope of 8 %, not told", grade=0.08),
}
"""The conditions of standard-2, by name."""
