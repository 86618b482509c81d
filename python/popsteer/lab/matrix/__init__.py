"""Controllers × plants × tracks: the error of each against the time of its step."""

from popsteer.lab.matrix import table
from popsteer.lab.matrix.runs import Matrix, run

__all__ = ["Matrix", "run", "table"]
