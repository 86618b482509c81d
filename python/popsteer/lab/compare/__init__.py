"""Several controllers on one plant and one path, or on each of several.

`runs` drives them, `steps` times a step of each, `paper` holds the paper's figures; `table` is what
the command prints, `files` what it writes, with `figures` of one plant and path and `effort` of
several.
"""

from popsteer.lab.common.experiment import controller
from popsteer.lab.compare import files, paper, table
from popsteer.lab.compare.comparison import Comparison, time_steps
from popsteer.lab.compare.runs import parameters, run, run_each

__all__ = [
    "Comparison",
    "controller",
    "files",
    "paper",
    "parameters",
    "run",
    "run_each",
    "table",
    "time_steps",
]
