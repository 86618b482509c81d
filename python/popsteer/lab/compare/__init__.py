"""Several controllers on one plant and one path: their errors beside the paper's.

`runs` drives them and times a step of each, `paper` holds the paper's figures; `table` is what the
command prints, `files` what it writes, with `figures`.
"""

from popsteer.lab.common.experiment import controller
from popsteer.lab.compare import files, paper, table
from popsteer.lab.compare.runs import Comparison, parameters, run, time_steps

__all__ = [
    "Comparison",
    "controller",
    "files",
    "paper",
    "parameters",
    "run",
    "table",
    "time_steps",
]
