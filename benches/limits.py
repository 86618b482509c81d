"""Preview POP behind wheels that turn slowly: the tables and the map of docs/preview_pop.md.

    python -m benches.limits slalom     # slow wheels on the slalom, beside the MPC
    python -m benches.limits straight   # beside a straight: overshoot, and the time until it is joined
    python -m benches.limits sweep      # wheelbases, rates, speeds, offsets, headings, dead times, lags
    python -m benches.limits map        # overshoot over speed and rate, before and after, as a figure

`--write` puts what was measured into docs. The plant of all but the slalom is a bicycle in plain
Python, no part of popsteer.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import popsteer
from benches.tables import ROOT
from tests.closed_loop.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Iterator

PAGE = ROOT / "docs" / "preview_pop.md"
FIGURE = ROOT / "docs" / "figures" / "limits-map.png"
DT = 0.05
TIME = 20.0
SETTLED = 15.0
LINE = popsteer.Path([(float(x), 0.0) for x in range(-50, 1600)])


@dataclass(frozen=True)
class Straight:
    """A vehicle beside a straight; speed and offset are those of one of 2.7 m, and scale with it."""

    rate: float
    speed: float
    offset: float
    heading_deg: float = 0.0
    wheelbase: float = 2.7
    dead_time: float = 0.0
    lag: float = 0.15

    @property
    def scale(self) -> float:
        """How many times as long as one of 2.7 m it is."""
        return self.wheelbase / 2.7

    def car(self) -> popsteer.Vehicle:
        """Give the vehicle."""
        return popsteer.Vehicle(
            wheelbase=self.wheelbase,
            steer_lag=self.lag,
            dead_time=self.dead_time,
            max_steer=0.6,
            max_steer_rate=self.rate,
        )

    def chain(self) -> Chain:
        """Give the vehicle on its place."""
        pose = 0.0, self.offset * self.scale, math.radians(self.heading_deg)
        return Chain(self.car(), pose, self.speed * self.scale, DT)


class Joined(NamedTuple):
    """How a straight was joined; lengths are those of a vehicle of 2.7 m."""

    overshoot: float
    """Farthest to the other side [m]."""
    within: float
    """Time until within 0.1 m for good [s]; infinite for never."""
    late: float
    """Largest error after 15 s [m]."""


def join(case: Straight, *, inside: bool = True) -> Joined:
    """Drive; `inside` False plans without limits and cuts the angle afterwards, as 0.1.0 did."""
    car, chain = case.car(), case.chain()
    if inside:
        controller = popsteer.PreviewPop(LINE, car)
    else:
        free = car.replace(max_steer_rate=None, max_lateral_acceleration=None)
        params = popsteer.PreviewPopParams(steer_span_rate=1e3)
        controller = popsteer.PreviewPop(LINE, free, params)
    widest = largest_angle(case)
    errors, last = [], 0.0
    for _ in range(round(TIME / DT)):
        errors.append(chain.y / case.scale)
        steer = controller.steer(*chain.pose, chain.speed, DT)
        if not inside:
            steer = max(-widest, min(steer, widest))
            steer = max(last - case.rate * DT, min(steer, last + case.rate * DT))
            told = controller.state.as_dict() | {"steer": steer, "previous_steer": steer}
            controller.state = popsteer.PreviewPopState(**told)
        last = steer
        chain.advance(steer)
    far = [k for k, error in enumerate(errors) if abs(error) > 0.1]
    within = (far[-1] + 1) * DT if far else 0.0
    return Joined(
        overshoot=max(0.0, -min(errors)),
        within=within if within < TIME else math.inf,
        late=max(abs(error) for error in errors[round(SETTLED / DT) :]),
    )


def largest_angle(case: Straight) -> float:
    """Give the largest angle of the wheels within the lateral acceleration [rad]."""
    car, speed = case.car(), case.speed * case.scale
    assert car.max_lateral_acceleration is not None
    return min(car.max_steer, math.atan(car.max_lateral_acceleration * car.wheelbase / speed**2))


def least_overshoot(case: Straight) -> float:
    """Give the least overshoot under these limits, lag and dead time, of any plan [m].

    A vehicle that heads for the path turns away from it as fast as its limits let it: the commands
    go at the full rate to the largest angle and stay there, until it drives along the path.
    Whatever else it did, it would come farther.
    """
    chain, steer = case.chain(), 0.0
    if chain.yaw >= 0.0:
        return 0.0
    while chain.yaw < 0.0:
        steer = min(steer + case.rate * DT, largest_angle(case))
        chain.advance(steer)
    return max(0.0, -chain.y / case.scale)


def sweep() -> Iterator[Straight]:
    """Give the cases of the sweep."""
    yield from itertools.starmap(
        Straight,
        itertools.product(
            (0.2, 0.4, 0.7, 1.0),
            (3.0, 8.0, 15.0, 25.0),
            (0.5, 1.0, 3.0),
            (-20.0, -10.0, 0.0, 10.0, 20.0),
            (0.33, 2.7, 6.0),
            (0.0, 0.2),
            (0.05, 0.15, 0.3),
        ),
    )


def allowed(case: Straight) -> float:
    """Give the overshoot that is allowed: a tenth of the offset, or 5 cm beyond the least [m]."""
    return max(0.1 * case.offset, 0.05 + least_overshoot(case))


def check(case: Straight) -> tuple[Straight, Joined, float]:
    """Drive a case of the sweep."""
    return case, join(case), allowed(case)
