"""How long a control step takes when it is called from Python.

`latency` measures, `states` holds the drive that the controllers are shown, `calls` the calls that
are timed, `yardsticks` those from outside; `report` is what comes of it, with its table.
Measuring needs numpy alone, the table the extra ``lab``, the yardsticks numba and osqp.
"""

from popsteer.lab.bench.latency import measure, run

__all__ = ["measure", "run"]
