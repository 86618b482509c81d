"""The functions of the paper, one by one.

What the controllers compute in one step, as the paper defines it, in plain Python: those of
`popsteer.reference`.

Examples
--------
>>> from popsteer import paper
>>> paper.saturate(0.7, -0.6, 0.6)
0.6
"""

from popsteer.reference import (
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
