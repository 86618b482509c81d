"""Pages to look at: one self-contained HTML file for what an experiment came to.

Each has a map on which the cars drive when played, errors, angles, speeds and statuses over time or
distance with one cursor for all, tables, histograms, the vehicle and the parameters that made it,
and the command that repeats it. The library that draws (plotly, of the extra ``lab``) is inside,
so a page needs nothing from the network.

Examples
--------
>>> import popsteer
>>> from popsteer.lab import compare, report
>>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
>>> page = report.of_comparison(compare.run(path, ["stanley", "pop"]))
>>> page.startswith(b"<!doctype html>")
True
"""

from popsteer.lab.report.compare import of_comparison
from popsteer.lab.report.identify import of_identification
from popsteer.lab.report.page import Origin
from popsteer.lab.report.plan import of_plan
from popsteer.lab.report.replay import of_replay
from popsteer.lab.report.stability import of_stability
from popsteer.lab.report.sweep import of_sweep
from popsteer.lab.report.tune import of_tuning

__all__ = [
    "Origin",
    "of_comparison",
    "of_identification",
    "of_plan",
    "of_replay",
    "of_stability",
    "of_sweep",
    "of_tuning",
]
