"""What the parity tests and the invariants are fed with.

A path is drawn as a shape, a handful of numbers and a seed, and built with `random`: cheap to
make, and small where it fails.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hypothesis import strategies as st

if TYPE_CHECKING:
    from collections.abc import Sequence

XY = list[tuple[float, float]]

SEEDS = st.integers(0, 2**32 - 1)
KINDS = ("straight", "smooth", "collinear", "lattice", "jagged", "loop", "noisy", "staircase")


@dataclass(frozen=True)
class Shape:
    """A path to build."""

    kind: str = "straight"
    count: int = 10
    spacing: float = 1.0
    offset: tuple[float, float] = (0.0, 0.0)
    closed: bool = False
    with_speed: bool = False
    seed: int = 0

    def build(self) -> Waypoints:
        rng = random.Random(self.seed)
        closed = self.closed and self.count >= 3
        if self.kind == "loop" and closed:
            xy = _loop(rng, self)
        elif self.kind == "staircase":
            xy = _staircase(rng, self)
        else:
            xy = _walk(rng, self)
        if closed and math.dist(xy[-1], xy[0]) <= 1e-6 * self.spacing:
            # A walk on the lattice may come back to its start, which a closed path must not.
            xy[-1] = (xy[-1][0] + 0.37 * self.spacing, xy[-1][1] + 0.61 * self.spacing)
        speed = [rng.uniform(0.0, 40.0) for _ in xy] if self.with_speed else None
        return Waypoints(xy, speed, closed)


@dataclass(frozen=True)
class Waypoints:
    """The arguments of a path."""

    xy: XY
    speed: list[float] | None
    closed: bool
    reverse: list[bool] | None = None

    @property
    def lengths(self) -> list[float]:
        """Length of each segment."""
        ends = self.xy[1:] + self.xy[:1] if self.closed else self.xy[1:]
        return [math.dist(a, b) for a, b in zip(self.xy, ends, strict=False)]


def _walk(rng: random.Random, shape: Shape) -> XY:
    """Waypoint by waypoint, the next heading out of the last."""
    x, y = shape.offset
    heading = rng.uniform(-math.pi, math.pi)
    curvature = 0.0
    run = 0
    xy = [(x, y)]
    for _ in range(shape.count - 1):
        step = shape.spacing
        if shape.kind == "lattice":
            dx, dy = rng.choice([(1, 0), (0, 1), (-1, 0), (0, -1)])
            x, y = x + dx * step, y + dy * step
            xy.append((x, y))
            continue
        if shape.kind == "smooth":
            curvature = 0.8 * curvature + rng.uniform(-0.1, 0.1)
            heading += curvature
            step *= rng.uniform(0.7, 1.0)
        elif shape.kind == "collinear":
            if run == 0:
                run, heading = rng.randint(1, 6), rng.uniform(-math.pi, math.pi)
            run -= 1
        elif shape.kind == "jagged":
            heading += rng.uniform(-2.5, 2.5)
            step *= rng.uniform(0.1, 1.0)
        elif shape.kind == "noisy":
            # As recorded: some segments lead backwards.
            curvature = 0.8 * curvature + rng.uniform(-0.03, 0.03)
            heading += curvature
            x, y = x + step * math.cos(heading), y + step * math.sin(heading)
            xy.append((x + rng.gauss(0.0, 0.3 * step), y + rng.gauss(0.0, 0.3 * step)))
            continue
        x, y = x + step * math.cos(heading), y + step * math.sin(heading)
        xy.append((x, y))
    return xy


def _staircase(rng: random.Random, shape: Shape) -> XY:
    """A line that bends a little, in steps along x and along y."""
    x, y = shape.offset
    to_x, to_y = x, y
    heading = rng.uniform(-math.pi, math.pi)
    step = shape.spacing
    xy = [(x, y)]
    for _ in range(shape.count - 1):
        heading += rng.uniform(-0.1, 0.1)
        to_x, to_y = to_x + step * math.cos(heading), to_y + step * math.sin(heading)
        if abs(to_x - x) >= abs(to_y - y):
            x += math.copysign(step, to_x - x)
        else:
            y += math.copysign(step, to_y - y)
        xy.append((x, y))
    return xy


def _loop(rng: random.Random, shape: Shape) -> XY:
    """A dented circle."""
    radius = shape.count * shape.spacing / math.tau
    dents = [(k, rng.uniform(0.0, 0.2) / k, rng.uniform(0.0, math.tau)) for k in (2, 3)]
    turn = rng.choice([-1.0, 1.0])
    xy = []
    for k in range(shape.count):
        angle = turn * math.tau * k / shape.count
        r = radius * (1.0 + sum(a * math.cos(n * angle + phase) for n, a, phase in dents))
        xy.append((shape.offset[0] + r * math.cos(angle), shape.offset[1] + r * math.sin(angle)))
    return xy


def usually(usual: tuple[float, float], low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of [low, high]: mostly usual ones, both ends, and any."""
    return st.one_of(
        st.floats(*usual), st.floats(*usual), st.sampled_from([low, high]), st.floats(low, high)
    )


OFFSETS = st.one_of(
    st.just((0.0, 0.0)),
    st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    st.tuples(st.floats(-1e7, 1e7), st.floats(-1e7, 1e7)),
)


def shapes(
    kinds: Sequence[str] = KINDS, *, most: int = 60, spacing: tuple[float, float] = (0.01, 100.0)
) -> st.SearchStrategy[Shape]:
    return st.builds(
        Shape,
        kind=st.sampled_from(kinds),
        count=st.integers(2, most),
        spacing=usually((max(0.5, spacing[0]), min(2.0, spacing[1])), *spacing),
        offset=OFFSETS,
        closed=st.booleans(),
        with_speed=st.booleans(),
        seed=SEEDS,
    )


DTS = usually((0.005, 0.2), 1e-6, 1e3)
SPEEDS = st.one_of(
    st.floats(0.0, 40.0),
    st.floats(0.0, 40.0),
    st.sampled_from([0.0, -0.0, -1e4, 1e4]),
    st.floats(-5.0, 0.0),
    st.floats(-1e4, 1e4),
)


@dataclass(frozen=True)
class Spot:
    """Where the vehicle is, told by the path."""

    along: float = 0.0
    aside: float = 0.0
    turned: float = 0.0
    speed: float = 5.0
    dt: float = 0.05

    def at(self, path: Waypoints) -> tuple[float, float, float, float, float]:
        """The arguments of a step: x, y, yaw, speed, dt."""
        segments = len(path.lengths)
        place = self.along * segments
        segment = min(max(int(place), 0), segments - 1)
        (x0, y0), (x1, y1) = path.xy[segment], path.xy[(segment + 1) % len(path.xy)]
        yaw = math.atan2(y1 - y0, x1 - x0)
        t = place - segment
        x = x0 + t * (x1 - x0) - self.aside * math.sin(yaw)
        y = y0 + t * (y1 - y0) + self.aside * math.cos(yaw)
        return x, y, max(-1e6, min(1e6, yaw + self.turned)), self.speed, self.dt


_WILD_SPOTS = st.builds(
    Spot,
    # Before the start and beyond the end too.
    along=st.one_of(st.floats(0.0, 1.0), st.floats(-0.2, 1.2)),
    aside=st.one_of(st.just(0.0), st.floats(-3.0, 3.0), st.floats(-1e4, 1e4)),
    turned=st.one_of(
        st.floats(-0.3, 0.3), st.floats(-math.pi, math.pi), st.floats(-1e6, 1e6), st.just(math.pi)
    ),
    speed=SPEEDS,
    dt=DTS,
)
CALM_SPOTS = st.builds(
    Spot,
    along=st.floats(0.0, 1.0),
    aside=st.floats(-2.0, 2.0),
    turned=st.floats(-0.5, 0.5),
    speed=st.floats(0.5, 30.0),
    dt=st.floats(0.01, 0.2),
)
"""What a vehicle on its way is like."""
SPOTS = CALM_SPOTS | _WILD_SPOTS
"""That, and far off the path, at rest, rolling backwards, turned any way."""


def fitted(
    params: dict[str, Any], path: Waypoints, most: int, wheelbase: float = 3.0
) -> dict[str, Any]:
    """The parameters of a search, its grid coarse enough for a plain loop over `most` points."""
    lengths = path.lengths
    ahead = _or_default(params, "window_ahead", 20.0 / 3.0 * wheelbase)
    reach = min(sum(lengths), ahead + 3.0 * max(lengths))
    least = reach / max(most - len(lengths), 1)
    spacing = _or_default(params, "grid_spacing", wheelbase / 300.0)
    if spacing >= least:
        return params
    fitted = {**params, "grid_spacing": min(least, 1e3)}
    # As the threshold goes with the grid, or the circle would hardly ever be met.
    if _or_default(params, "lookahead_tolerance", wheelbase / 300.0) <= spacing:
        fitted["lookahead_tolerance"] = min(max(0.6 * least, 1e-9), 1e3)
    return fitted


def _or_default(params: dict[str, Any], name: str, default: float) -> float:
    given = params.get(name)
    return default if given is None else float(given)


Ranges = dict[str, tuple[tuple[float, float], tuple[float, float]]]

VEHICLE_RANGES: Ranges = {
    "wheelbase": ((1e-3, 1e3), (1.0, 4.0)),
    "width": ((1e-3, 1e2), (0.5, 3.0)),
    "antenna_left": ((-1e2, 1e2), (-1.0, 1.0)),
    "antenna_height": ((0.0, 1e2), (0.0, 3.0)),
    "rear_axle": ((-1e3, 1e3), (-3.0, 1.0)),
    "no_slip_point": ((-1e3, 1e3), (-3.0, 3.0)),
    "turning_wheelbase": ((1e-3, 1e3), (1.0, 5.0)),
    "understeer": ((0.0, 1e3), (0.0, 0.01)),
    "steer_offset": ((-0.5, 0.5), (-0.05, 0.05)),
    "steer_lag": ((0.0, 10.0), (0.0, 0.5)),
    "dead_time": ((0.0, 10.0), (0.0, 0.3)),
    "max_steer": ((1e-3, 1.57), (0.3, 1.3)),
    "max_steer_rate": ((1e-3, 1e6), (0.1, 2.0)),
    "steer_play": ((0.0, 0.5), (0.0, 0.03)),
    "max_lateral_acceleration": ((1e-3, 1e6), (1.0, 12.0)),
    "max_speed": ((1e-3, 1e4), (5.0, 60.0)),
    "max_acceleration": ((1e-3, 1e3), (1.0, 5.0)),
    "max_deceleration": ((1e-3, 1e3), (1.0, 9.0)),
    "brake_deceleration": ((1e-3, 1e3), (1.0, 9.0)),
    "drive_delay": ((0.0, 10.0), (0.0, 0.5)),
    "drive_lag": ((0.0, 10.0), (0.0, 1.0)),
    "stop_point": ((-1e3, 1e3), (-3.0, 6.0)),
}
"""The fields of a vehicle: the range of each, and where it usually is."""
VEHICLE_OPTIONAL = (
    *("width", "no_slip_point", "turning_wheelbase", "max_steer_rate", "max_lateral_acceleration"),
    *("max_speed", "max_acceleration", "max_deceleration", "brake_deceleration", "stop_point"),
)
ADAPT_RANGES: Ranges = {
    "turn_time": ((0.0, 1e6), (0.05, 20.0)),
    "slip_time": ((0.0, 1e6), (0.05, 20.0)),
}
"""The parameters of how a controller adapts."""
MONITOR_RANGES: Ranges = {
    "deviation_limit": ((0.0, 1e9), (0.05, 3.0)),
    "turn_tolerance": ((0.0, 1e9), (0.001, 0.1)),
}
"""The parameters of how a controller watches its vehicle."""
MONITOR_OPTIONAL = ("deviation_limit",)


def some(
    ranges: Ranges, optional: Sequence[str], *, calm: bool = False
) -> st.SearchStrategy[dict[str, Any]]:
    """Some of the fields, the others by default; `calm` for usual values alone."""
    drawn: dict[str, st.SearchStrategy[Any]] = {}
    for name, (whole, usual) in ranges.items():
        # 0 says that there is no such thing: no lag, no dead time, an estimate never made.
        zero = whole[0] <= 0.0 <= whole[1]
        usual_ones = st.floats(*usual) | st.just(0.0) if zero else st.floats(*usual)
        drawn[name] = usual_ones if calm else usually(usual, *whole)
        if name in optional:
            drawn[name] = st.none() | drawn[name]
    return st.fixed_dictionaries({}, optional=drawn)


def _that_may_steer_at_rest(fields: st.SearchStrategy[dict[str, Any]]) -> Any:
    return st.builds(lambda car, does: {**car, "steers_at_rest": does}, fields, st.booleans())


VEHICLES = _that_may_steer_at_rest(some(VEHICLE_RANGES, VEHICLE_OPTIONAL))
"""Arguments of a `Vehicle`."""
CALM_VEHICLES = _that_may_steer_at_rest(some(VEHICLE_RANGES, VEHICLE_OPTIONAL, calm=True))
"""Arguments of a `Vehicle` that is a car."""
ADAPTS = st.one_of(
    st.just("auto"),
    st.none(),
    some(ADAPT_RANGES, ()),
    some(ADAPT_RANGES, (), calm=True),
)
"""How a controller adapts: by default, not at all, or arguments of `AdaptParams`."""
ESTIMATES: st.SearchStrategy[dict[str, float]] = st.just({}) | st.fixed_dictionaries(
    {},
    optional={
        "gain": st.floats(0.4, 2.5),
        "steer_offset": st.floats(-0.15, 0.15),
        "slip": st.floats(-0.15, 0.15),
        "slip_length": st.floats(-0.9, 0.9),
        "acceleration": st.floats(-19.0, 19.0),
    },
)
"""What a controller believes of its vehicle; the last two in wheelbases."""
