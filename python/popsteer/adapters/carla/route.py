"""The waypoints that a planner of CARLA has before it."""

from __future__ import annotations

import math
import random
from collections import deque
from enum import IntEnum
from typing import TYPE_CHECKING

from popsteer import Path
from popsteer.adapters.carla.conversions import pose_of, thinned

if TYPE_CHECKING:
    from collections.abc import Iterable

    import carla

_DRIVEN = 50  # waypoints kept behind the vehicle, so that a path goes on through it
_NEAR = 4  # among so many points of the path from the last one on a waypoint is looked for
_STRAIGHT = math.radians(35.0)  # a branch that turns by less goes straight on, as agents see it


class RoadOption(IntEnum):
    """How one waypoint leads to the next; equal to that of CARLA's agents, which no package brings.

    Examples
    --------
    >>> RoadOption.LANEFOLLOW == 4
    True
    """

    VOID = -1
    LEFT = 1
    RIGHT = 2
    STRAIGHT = 3
    LANEFOLLOW = 4
    CHANGELANELEFT = 5
    CHANGELANERIGHT = 6


class Route:
    """Waypoints ahead, those just driven, and the path `offset` [m] to the right of all."""

    def __init__(self, begin: carla.Waypoint, offset: float = 0.0) -> None:
        self.ahead: deque[tuple[carla.Waypoint, int]] = deque([(begin, RoadOption.LANEFOLLOW)])
        self.offset = offset
        self.driven: deque[carla.Waypoint] = deque(maxlen=_DRIVEN)
        self._at: deque[float] = deque()  # where each waypoint ahead lies on the path [m]

    def add(self, plan: Iterable[tuple[carla.Waypoint, int]]) -> None:
        """Put a plan behind what there is."""
        self.ahead.extend((waypoint, option) for waypoint, option in plan)

    def replace(self, plan: Iterable[tuple[carla.Waypoint, int]], here: carla.Location) -> None:
        """Follow another plan, led in along its first lane from behind the vehicle."""
        self.ahead.clear()
        self.driven.clear()
        self._at.clear()
        self.add(plan)
        if self.ahead:
            self.driven.extend(_lead_in(self.ahead[0][0], here))

    def grow(self, count: int, spacing: float) -> None:
        """Go on along the lane, and along one of the branches where there are several."""
        for _ in range(count if self.ahead else 0):
            last = self.ahead[-1][0]
            following = list(last.next(spacing))
            if not following:
                break
            chosen = random.choice(following)  # noqa: S311 - as CARLA's planner roams
            option = RoadOption.LANEFOLLOW
            if len(following) > 1:
                option = option_between(last, (list(chosen.next(3.0)) or [chosen])[0])
            self.ahead.append((chosen, option))

    def pass_until(self, place: float, near: float, last: float) -> None:
        """Let go what lies less than `near` ahead of a place on the path, or `last` for the end."""
        while self.ahead and self._at:
            reach = near if len(self.ahead) > 1 else last
            if self._at[0] - place >= reach:
                break
            self.driven.append(self.ahead.popleft()[0])
            self._at.popleft()

    def path(self, speed: float | None) -> Path | None:
        """Give the path through what was driven and what lies ahead, at a speed [m/s] if at one.

        None where there is no path.
        """
        waypoints = [*self.driven, *(waypoint for waypoint, _ in self.ahead)]
        xy, index = thinned(waypoints, self.offset)
        if len(xy) < 2:
            return None
        path = Path(xy, speed=None if speed is None else [speed] * len(xy))
        arcs = _arcs(xy, path)
        self._at = deque(arcs[each] for each in index[len(self.driven) :])
        return path


def _arcs(xy: list[tuple[float, float]], path: Path) -> list[float]:
    """Say where points lie on the path that was made of them [m], some of which it may not have."""
    if len(path) == len(xy):
        return [float(s) for s in path.s]
    found, at = [], 0
    for place in xy:
        near = range(at, min(at + _NEAR, len(path)))
        at = min(near, key=lambda k: math.dist((path.x[k], path.y[k]), place))
        found.append(float(path.s[at]))
    return found


def option_between(before: carla.Waypoint, after: carla.Waypoint) -> RoadOption:
    """Say which way a branch leads."""
    turn = math.remainder(pose_of(after.transform)[2] - pose_of(before.transform)[2], math.tau)
    if abs(turn) < _STRAIGHT:
        return RoadOption.STRAIGHT
    return RoadOption.LEFT if turn > 0.0 else RoadOption.RIGHT


def _lead_in(first: carla.Waypoint, here: carla.Location) -> list[carla.Waypoint]:
    """Give the lane behind a waypoint, from a step behind the vehicle on."""
    spacing = 2.0
    steps = min(int(first.transform.location.distance(here) / spacing) + 2, _DRIVEN)
    behind: list[carla.Waypoint] = []
    for _ in range(steps):
        before = list((behind[-1] if behind else first).previous(spacing))
        if not before:
            break
        behind.append(min(before, key=lambda one: one.transform.location.distance(here)))
    return behind[::-1]
