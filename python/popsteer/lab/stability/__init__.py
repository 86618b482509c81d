"""How far the steering loops are from instability, and what that costs in bends.

`linear` has the controllers in small signals, `runs` their margins, `carrot` the offsets in a bend;
`table` and `figures` show them.
"""

from popsteer.lab.stability import table
from popsteer.lab.stability.carrot import carrot_offset, driven_offset, preview_offset
from popsteer.lab.stability.runs import Margins, Stability, dead_time_map, margins, run

__all__ = [
    "Margins",
    "Stability",
    "carrot_offset",
    "dead_time_map",
    "driven_offset",
    "margins",
    "preview_offset",
    "run",
    "table",
]
