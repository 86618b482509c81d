"""The tables of docs/edges.md."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import popsteer
from popsteer.lab import delay
from popsteer.lab.common.names import title_of
from popsteer.lab.delay.table import error_text
from popsteer.lab.edges.table import share_text
from tests.closed_loop.paths import track
from tests.helpers import authors_data
from tests.pages.layout import line

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.lab.delay import DeadTimeRow
    from popsteer.lab.edges import EdgeRun

RUNS = ("late", "predicted", "short", "long", "early", "later")


def edge_lines(runs: Iterable[EdgeRun]) -> list[str]:
    return [
        line(
            run.track,
            title_of(run.law),
            run.ending,
            f"{run.time:.1f}",
            f"{run.max_error:.2f}",
            f"{math.degrees(run.max_jump):.1f}",
            share_text(run),
        )
        for run in runs
    ]


def dead_time_rows(course: str) -> list[DeadTimeRow]:
    if course == "racetrack":
        return delay.run(track(course))
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    return delay.run(path, start=(-183.8, 78.7, -1.574), start_at="front")


def dead_time_lines(rows: Iterable[DeadTimeRow]) -> list[str]:
    return [
        line(
            title_of(row.law),
            f"{row.prompt.mean_abs_cross_track_error:.3f}",
            *(error_text(row, getattr(row, run)) for run in RUNS),
        )
        for row in rows
    ]
