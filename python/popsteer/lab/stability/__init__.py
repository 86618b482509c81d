"""How far the steering loops are from instability.

`linear` has the controllers in small signals, `runs` their margins; `table` and `figures`
show them.
"""

from popsteer.lab.stability import table
from popsteer.lab.stability.runs import Margins, Stability, dead_time_map, margins, run

__all__ = ["Margins", "Stability", "dead_time_map", "margins", "run", "table"]
