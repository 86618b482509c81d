"""The functions of the paper, one by one.

What the controllers compute in one step, as the paper defines it. `popsteer.reference` has the same
names in plain Python, to read; these are the ones of the Rust core.

Examples
--------
>>> from popsteer import paper
>>> paper.saturate(0.7, -0.6, 0.6)
0.6
"""

from popsteer._core import (
    get_distance,
    get_predicted_location,
    kinematic_bicycle,
    saturate,
    state_transition,
    wrap,
)

__all__ = [
    "get_distance",
    "get_predicted_location",
    "kinematic_bicycle",
    "saturate",
    "state_transition",
    "wrap",
]
