"""A suite of scenarios under conditions, with a version, for any controller and any plant.

``standard-2`` is fixed: what changes a figure of it makes ``standard-3``.

Examples
--------
>>> from popsteer.lab import suite
>>> suite.names()
('standard-2',)
>>> found = suite.run(["stanley"], ["suite-car"], scenarios=["slalom"], conditions=["as told"])
>>> [(cell.scenario, cell.condition, cell.success) for cell in found.cells]
[('slalom', 'as told', True)]
"""

from popsteer.lab.suite import table
from popsteer.lab.suite.runs import Cell, Suite, names, run
from popsteer.lab.suite.scenarios import Condition, Scenario, suite_car

__all__ = ["Cell", "Condition", "Scenario", "Suite", "names", "run", "suite_car", "table"]
