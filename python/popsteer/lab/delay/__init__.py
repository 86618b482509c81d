"""Dead time between command and wheels, and controllers that predict through it."""

from popsteer.lab.delay import table
from popsteer.lab.delay.runs import DeadTimeRow, run

__all__ = ["DeadTimeRow", "run", "table"]
