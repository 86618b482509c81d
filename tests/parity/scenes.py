"""Runs to drive: fixed ones, and drawn ones."""

from __future__ import annotations

from hypothesis import strategies as st

from tests.parity.checks import Rollout
from tests.parity.strategies import CALM_SPOTS, KINDS, SEEDS, Shape, Spot, shapes

# The paper's kind of path first: waypoints about 1 m apart.
CASES = {
    "bends": Rollout(Shape("smooth", 150, with_speed=True, seed=3), Spot(0.0, 2.44), seed=1),
    "loop": Rollout(Shape("loop", 120, closed=True, seed=4), Spot(0.1, -1.0), laps=1.3, seed=2),
    "straight far off": Rollout(Shape("straight", 100), Spot(0.1, 300.0, 2.0), rough=1.0, seed=3),
    "lattice": Rollout(Shape("lattice", 80, 2.0, seed=5), Spot(0.3, 0.5), rough=0.5, seed=4),
    "jagged far from the origin": Rollout(
        Shape("jagged", 60, 5.0, (-3e6, 7e6), seed=6), Spot(0.2, 0.1, 1e5), rough=0.2, seed=5
    ),
}


def drives() -> st.SearchStrategy[Rollout]:
    return st.builds(
        Rollout,
        shape=shapes(KINDS),
        start=CALM_SPOTS,
        steps=st.integers(200, 240),
        laps=st.floats(0.05, 2.0),
        rough=st.sampled_from([0.0, 0.0, 0.1, 1.0]),
        seed=SEEDS,
    )
