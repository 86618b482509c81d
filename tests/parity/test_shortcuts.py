"""Where the Rust core takes a shortcut, and the reference the plain loop.

The laws' search for the lookahead point jumps over grid points, and POP's choice of a candidate
is made without visiting each. The places drawn here are those where a jump could land wrong:
circles that touch a segment, thresholds met to within rounding, candidates that tie.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

from hypothesis import example, given
from hypothesis import strategies as st

import popsteer
from tests.parity.compare import Controller, Pair, make
from tests.parity.strategies import (
    KINDS,
    SPOTS,
    Shape,
    Spot,
    Waypoints,
    fitted,
    shapes,
    usually,
)

NUDGES = st.one_of(
    st.just(0.0), st.floats(-1e-15, 1e-15), st.floats(-1e-9, 1e-9), st.floats(-0.5, 0.5)
)


def _critical_lookaheads(path: Waypoints, x: float, y: float) -> list[float]:
    """Distances of (x, y) from waypoints, and from the lines through the segments."""
    found = [math.dist((x, y), waypoint) for waypoint in path.xy]
    ends = path.xy[1:] + path.xy[:1]
    for (x0, y0), (x1, y1), length in zip(path.xy, ends, path.lengths, strict=False):
        found.append(abs((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / length)
    return found


def _search(path: Waypoints, law: str, params: dict[str, Any]) -> Controller:
    made = make("Path", path.xy, closed=path.closed)
    return Controller(law, made, _tracking_the_pose(law), make(f"{law}Params", **params), {})


def _tracking_the_pose(law: str, **vehicle: Any) -> Pair:
    """A vehicle of which the controller tracks the point whose pose is given."""
    rear_axle = -3.0 if law == "Pop" else 0.0
    return make("Vehicle", rear_axle=rear_axle, max_lateral_acceleration=None, **vehicle)


@given(
    shape=shapes(KINDS, most=20),
    spot=SPOTS,
    which=st.floats(0.0, 1.0),
    off=st.sampled_from([0.0, 1.0, -1.0]),
    nudge=NUDGES,
    tolerance=usually((1e-9, 0.3), 1e-9, 1e3),
    window_ahead=usually((1.0, 40.0), 1e-3, 1e6),
    grid_spacing=usually((0.01, 2.0), 1e-3, 1e3),
)
# Rounding in proportion to a lookahead and a threshold far larger than the path.
@example(
    shape=Shape(count=2, spacing=0.5),
    spot=Spot(along=0.16782141355623817, turned=math.pi, speed=0.0),
    which=0.0,
    off=1.0,
    nudge=0.0,
    tolerance=1e3,
    window_ahead=1.0,
    grid_spacing=1.0,
)
def test_lookahead_search_of_laws_matches_reference_edges(
    shape: Shape,
    spot: Spot,
    which: float,
    off: float,
    nudge: float,
    tolerance: float,
    window_ahead: float,
    grid_spacing: float,
) -> None:
    path = shape.build()
    x, y, yaw, _, dt = spot.at(path)
    critical = _critical_lookaheads(path, x, y)
    # On the circle's edge, or its threshold's inner or outer one, to within the nudge.
    lookahead = critical[min(int(which * len(critical)), len(critical) - 1)] + off * tolerance
    search = fitted({"window_ahead": window_ahead, "grid_spacing": grid_spacing}, path, 2000)
    params = {
        **search,
        "min_lookahead": min(max(lookahead + nudge, 0.0), 1e4),
        "lookahead_tolerance": tolerance,
    }
    for law in ("PurePursuit", "Pop"):
        _search(path, law, params).call("step", x, y, yaw, 0.0, dt)


@given(
    start=st.floats(-20.0, 20.0),
    aside=st.sampled_from([0.0, 1e-12, 0.5, 2.0, 5.9999, 6.0, 6.0001]),
    lookahead=st.sampled_from([0.0, 0.5, 2.0, 6.0, 6.01]),
    length=st.sampled_from([0.3, 1.0, 5.0, 100.0]),
    grid_spacing=st.sampled_from([0.01, 0.1, 0.3, 1.0]),
    tolerance=st.sampled_from([1e-9, 0.01, 0.05, 0.5]),
    origin=st.sampled_from([0.0, 1e3, -1e7, 1e9 - 1e4]),
)
def test_lookahead_search_on_a_line_matches_reference_cases(
    start: float,
    aside: float,
    lookahead: float,
    length: float,
    grid_spacing: float,
    tolerance: float,
    origin: float,
) -> None:
    count = max(2, min(int(40.0 / length), 60))
    path = Waypoints([(origin + k * length, origin) for k in range(count)], None, closed=False)
    params = {
        "min_lookahead": lookahead,
        "grid_spacing": grid_spacing,
        "lookahead_tolerance": tolerance,
    }
    for law in ("PurePursuit", "Pop"):
        pair = _search(path, law, params)
        pair.call("step", origin + start, origin + aside, 0.3, 0.0, 0.05)


@given(
    shape=shapes(["straight", "smooth", "loop"], most=30, spacing=(0.3, 3.0)),
    spot=SPOTS,
    steps=st.integers(0, 8),
    beyond=st.floats(-0.3, 0.3),
    gain=st.floats(0.0, 0.9),
    speed=st.floats(0.5, 40.0),
    nudge=st.sampled_from([0.0, -math.inf, math.inf]),
)
def test_lookahead_threshold_met_to_the_last_bit_matches_reference_edges(
    shape: Shape, spot: Spot, steps: int, beyond: float, gain: float, speed: float, nudge: float
) -> None:
    path = shape.build()
    x, y, yaw, _, dt = spot.at(path)
    made = make("Path", path.xy, closed=path.closed)
    nearest = made.rust.nearest_waypoint(x, y)
    waypoint = path.xy[min(nearest + steps, len(path.xy) - 1)]
    distance = popsteer.paper.get_distance((x, y), waypoint)
    for law in ("PurePursuit", "Pop"):
        # The lookahead as the law takes it, and the threshold as far off as the waypoint is, or
        # the next number to it: the last bit of either says whether the waypoint is found.
        wanted = min(distance * (1.0 + beyond), 400.0)
        least = wanted * (1.0 - gain) if law == "Pop" else 0.0
        lookahead_gain = (wanted - least) / speed
        lookahead = least + lookahead_gain * speed
        exact = abs(distance - lookahead)
        tolerance = math.nextafter(exact, nudge) if nudge else exact
        if not 1e-9 <= tolerance <= 1e3:
            return
        # A grid of which each waypoint is a point.
        options = {"window_ahead": 30.0, "grid_spacing": 0.25}
        params = {**options, "lookahead_gain": lookahead_gain, "min_lookahead": least}
        pair = _search(path, law, {**params, "lookahead_tolerance": tolerance})
        pair.call("step", x, y, yaw, speed, dt)
        made.call("get_lookahead_point", x, y, lookahead, tolerance=tolerance, **options)


@given(
    # Where the target lies, in steps from the middle of the list: on a candidate, or half way
    # between two, where they tie.
    place=st.integers(-80, 80).map(lambda halves: halves / 2.0),
    nudge=NUDGES,
    half=st.integers(1, 30),
    span=usually((0.01, 0.5), 1e-6, math.pi),
    previous=st.one_of(st.floats(-1.0, 1.0), st.sampled_from([0.0, -0.0])),
    max_steer=usually((0.5, 1.3), 1e-3, 1.57),
    yaw=st.one_of(st.floats(-math.pi, math.pi), st.floats(-1e6, 1e6), st.just(0.0)),
    reach=usually((1.0, 30.0), 1e-3, 1e6),
    travel=st.one_of(st.floats(0.01, 2.0), st.floats(-12.0, 3.0).map(lambda e: 10.0**e)),
)
def test_pop_choice_between_candidates_matches_reference_edges(
    *,
    place: float,
    nudge: float,
    half: int,
    span: float,
    previous: float,
    max_steer: float,
    yaw: float,
    reach: float,
    travel: float,
) -> None:
    previous *= max_steer
    bearing = yaw + previous + (place + nudge) * span / half
    target = (reach * math.cos(bearing), reach * math.sin(bearing))
    # Everything is out of reach of this lookahead, so the last waypoint stands in for it.
    path = make("Path", [(2.0 * target[0], 2.0 * target[1]), target])
    params = make(
        "PopParams",
        min_lookahead=1e4 if reach < 4e3 else 0.0,
        lookahead_tolerance=1e-9,
        grid_spacing=min(max(1e-4, reach / 5.0), 1e3),
        steer_span=span,
        candidate_count=2 * half + 1,
    )
    car = _tracking_the_pose("Pop", max_steer=max_steer)
    pair = Controller("Pop", path, car, params, {})
    before = pair.rust.state
    pair.rust.state = before.replace(law=before.law.replace(previous_steer=previous))
    pair.follow_rust()
    dt = 0.1 if travel >= 1e-5 else 1e-4
    for method in ("step", "steer"):
        pair.call(method, 0.0, 0.0, yaw, min(travel / dt, 1e4), dt)
        pair.state()


def test_pop_of_any_resolution_matches_reference_edges() -> None:
    path = make("Path", [(float(k), 0.1 * k * k) for k in range(20)])
    car = make("Vehicle", max_lateral_acceleration=None)
    for count, span in itertools.product((3, 1001, 100_001), (1e-6, 0.05, math.pi)):
        params = make("PopParams", candidate_count=count, steer_span=span)
        pair = Controller("Pop", path, car, params, {})
        for speed, dt in ((0.0, 0.05), (10.0, 0.05), (1e4, 1e3)):
            pair.step(1.0, 0.5, 0.4, speed, dt)
