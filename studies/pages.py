"""Rewrites the tables of the pages of docs/; each is computed here and held by a test.

python -m studies.pages            # all of them
python -m studies.pages edges end  # the tables of these names
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from popsteer import controllers
from studies import edges, limits
from studies.cars_loop import loop_lines
from studies.cases import case_lines
from studies.choose import adapting_lines, choose_lines, paper_lines, pid_lines
from studies.dead_time import age_lines, dead_time_lines, dead_time_rows
from studies.driver import fault_lines
from studies.grip import grip_lines
from studies.layout import table, write_table
from studies.parking import parking_lines
from studies.preview_pop import preview_lines, slip_lines
from studies.replanning import input_lines, replanning_lines
from studies.slopes import speed_lines, stop_lines
from studies.suite import curve_lines
from studies.theory import carrot_lines, choice_lines, late_line, margin_lines

if TYPE_CHECKING:
    from collections.abc import Callable

TABLES: dict[str, tuple[str, Callable[[], list[str]]]] = {
    "edges": ("edges.md", lambda: edges.edge_lines(edges.run())),
    "cars loop": ("loop.md", loop_lines),
    "cases": ("loop.md", case_lines),
    "driver": ("driver.md", fault_lines),
    "driver worn": ("driver.md", lambda: fault_lines(healthy=1000, worn=True)),
    "replanning": ("loop.md", replanning_lines),
    "missing inputs": ("loop.md", input_lines),
    "stops": ("planning.md", stop_lines),
    "speeds": ("planning.md", speed_lines),
    "grip": ("planning.md", grip_lines),
    "parking": ("planning.md", parking_lines),
    "pose age": ("edges.md", age_lines),
    "end": ("edges.md", edges.end_lines),
    "dead time, racetrack": ("edges.md", lambda: dead_time_lines(dead_time_rows("racetrack"))),
    "dead time, authors": ("edges.md", lambda: dead_time_lines(dead_time_rows("authors"))),
    "carrot": ("theory.md", carrot_lines),
    "margins": ("theory.md", margin_lines),
    "late": ("theory.md", lambda: [late_line(name) for name in controllers.names()]),
    "choice": ("theory.md", choice_lines),
    "preview": ("preview_pop.md", lambda: list(preview_lines())),
    "slip": ("preview_pop.md", lambda: list(slip_lines())),
    "limits, slalom": ("preview_pop.md", limits.slalom_lines),
    "limits, straight": ("preview_pop.md", limits.straight_lines),
    "limits, sweep": ("preview_pop.md", limits.sweep_lines),
    # Of the tables before it and of the page's matrix.
    "choose": ("choose.md", choose_lines),
    "adapting": ("choose.md", adapting_lines),
    "curve": ("results.md", curve_lines),
    "paper": ("paper.md", paper_lines),
    "pid": ("paper.md", pid_lines),
}


def main() -> None:
    """Compute the tables that are named, or all, and show the rows that differ."""
    names = sys.argv[1:] or list(TABLES)
    for name in names:
        if name not in TABLES:
            raise SystemExit(f"no table {name!r}; there are {', '.join(TABLES)}")
    for name in names:
        page, compute = TABLES[name]
        old, new = table(page, name), compute()
        print(f"{page}, {name}: {'as it was' if old == new else 'changed'}", flush=True)
        for row in old:
            if row not in new:
                print(f"- {row}")
        for row in new:
            if row not in old:
                print(f"+ {row}", flush=True)
        if old != new:
            write_table(page, name, new)


if __name__ == "__main__":
    main()
