"""Several controllers on one plant and one path, or on each of several.

`runs` drives them, `comparison` is what they did and times their steps, `paper` holds the paper's
figures; `table` is what the command prints, `files` what it writes, with `figures`.
"""

from popsteer.lab.compare import files, paper, table
from popsteer.lab.compare.comparison import Comparison, time_steps
from popsteer.lab.compare.runs import parameters, run, run_each

__all__ = ["Comparison", "files", "paper", "parameters", "run", "run_each", "table", "time_steps"]
