"""Rewrites the tables of the pages."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from popsteer import controllers
from popsteer.files import write_text_atomic
from popsteer.lab import edges
from tests.closed_loop.cars_loop import loop_lines
from tests.closed_loop.replanning_page import input_rows, replanning_rows
from tests.closed_loop.test_cars_loop_shadow import age_lines
from tests.closed_loop.test_path_end import end_lines
from tests.pages.choose import choose_lines, paper_lines
from tests.pages.edges import dead_time_lines, dead_time_rows, edge_lines
from tests.pages.layout import DOCS, line, table, with_table
from tests.pages.preview_pop import preview_lines
from tests.pages.theory import carrot_lines, choice_lines, late_line, margin_lines

if TYPE_CHECKING:
    from collections.abc import Callable

TABLES: dict[str, tuple[str, Callable[[], list[str]]]] = {
    "edges": ("edges.md", lambda: edge_lines(edges.run())),
    "cars loop": ("loop.md", loop_lines),
    "replanning": ("loop.md", lambda: [line(*row) for row in replanning_rows()]),
    "missing inputs": ("loop.md", lambda: [line(*row) for row in input_rows()]),
    "pose age": ("edges.md", age_lines),
    "end": ("edges.md", lambda: end_lines("racetrack")),
    "dead time, racetrack": ("edges.md", lambda: dead_time_lines(dead_time_rows("racetrack"))),
    "dead time, authors": ("edges.md", lambda: dead_time_lines(dead_time_rows("authors"))),
    "carrot": ("theory.md", carrot_lines),
    "margins": ("theory.md", margin_lines),
    "late": ("theory.md", lambda: [late_line(name) for name in controllers.names()]),
    "choice": ("theory.md", choice_lines),
    "preview": ("preview_pop.md", preview_lines),
    # Of the tables before it and of README's matrix.
    "choose": ("choose.md", choose_lines),
    "paper": ("paper.md", paper_lines),
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
            file = DOCS / page
            write_text_atomic(file, with_table(file.read_text(encoding="utf-8"), name, new))


if __name__ == "__main__":
    main()
