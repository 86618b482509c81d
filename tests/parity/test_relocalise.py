from __future__ import annotations

import math
import random
from math import inf, nan, nextafter

from hypothesis import given
from hypothesis import strategies as st

from tests.parity.compare import make
from tests.parity.strategies import SPOTS, XY, Shape, Spot, shapes

BAD_POSES = [
    *((value, 1.0, 1.0) for value in (nan, inf, -inf, nextafter(1e9, inf), None)),
    *((1.0, value, 1.0) for value in (nan, inf, -inf, -nextafter(1e9, inf), None)),
    *((1.0, 1.0, value) for value in (nan, inf, -inf, nextafter(1e6, inf), None)),
    (nan, nan, nan),
    (1.0, nan, nan),
]


def figure_of_eight() -> XY:
    """A figure of eight that crosses itself at the origin, leading 27 and 153 degrees there."""
    turns = [math.tau * k / 200 for k in range(200)]
    return [(50.0 * math.sin(t), 12.5 * math.sin(2.0 * t)) for t in turns]


@given(
    shape=shapes(most=200),
    spot=SPOTS,
    yaw=st.none() | st.integers(-4, 4).map(lambda quarters: quarters * math.pi / 2),
)
def test_path_relocalise_matches_reference_random(
    shape: Shape, spot: Spot, yaw: float | None
) -> None:
    path = shape.build()
    pair = make("Path", path.xy, speed=path.speed, closed=path.closed)
    x, y, along, *_ = spot.at(path)
    assert pair.call("relocalise", x, y, along if yaw is None else yaw) is not None
    for opposite in (0.0, 3.0, 1e9):
        pair.call("relocalise", x, y, along + 3.0, opposite_distance=opposite)
    # On a waypoint itself.
    x, y = path.xy[len(path.xy) // 3]
    pair.call("relocalise", x, y, along)


def test_path_relocalise_matches_reference_edges() -> None:
    pair = make("Path", figure_of_eight(), closed=True)
    for x, y, yaw in BAD_POSES:
        assert pair.call("relocalise", x, y, yaw) is None
    for x, y in ((1e9, -1e9), (-1e9, 0.0), (0.0, -0.0)):
        for yaw in (1e6, -1e6, 0.0, -0.0, 5e-324):
            assert pair.call("relocalise", x, y, yaw) is not None
    for value in (nan, inf, -1.0, nextafter(1e9, inf)):
        assert pair.call("relocalise", 0.0, 0.0, 0.0, opposite_distance=value) is None


def test_path_relocalise_on_a_crossing_takes_the_branch_of_the_heading() -> None:
    pair = make("Path", figure_of_eight(), closed=True)
    for yaw, branch in ((0.464, 0), (math.pi - 0.464, 100)):
        for askew in (-0.5, 0.0, 0.5):
            for turn in (0.0, -math.tau, 20.0 * math.tau):
                found = pair.call("relocalise", 0.0, 0.0, yaw + askew + turn)
                assert found is not None
                # The closest point is the waypoint itself: the segment before it or after it.
                assert found.rust in (branch, (branch - 1) % 200)


def test_path_relocalise_on_a_long_path_matches_reference() -> None:
    # Beyond 512 segments the core has an index, and the reference a scan.
    turns = [0.003 * k for k in range(3000)]
    knot = [(400.0 * math.sin(t) + 0.5 * t, 300.0 * math.sin(1.7 * t + 0.3)) for t in turns]
    rng = random.Random(8)
    for closed in (False, True):
        pair = make("Path", knot, closed=closed)
        for _ in range(30):
            x, y = rng.choice(knot)
            angle, far = rng.uniform(-4.0, 4.0), rng.choice([0.0, 3.0, 60.0, 2000.0])
            yaw = rng.uniform(-4.0, 4.0)
            pair.call("relocalise", x + far * math.cos(angle), y + far * math.sin(angle), yaw)
