"""The table of the edges, for people and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer._core import __version__
from popsteer.report.layout import blank_table, json_text
from popsteer.report.table import title_of
from popsteer.study.edges import EDGE_CHANGES, EDGE_PLANT, MAX_STEER

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from popsteer.study.edges import EdgeRun

__all__ = ["EDGES_CAPTION", "edges_csv", "edges_json", "edges_table", "share_text"]

SCHEMA = 1
"""Version of the document's layout."""
EDGES_CAPTION = (
    f"plant {EDGE_PLANT}, speeds of the paths, largest angle {math.degrees(MAX_STEER):.0f}°; errors"
    " of the rear axle"
)
"""What the runs of the table have in common, in one line."""


def edges_table(rows: Sequence[EdgeRun]) -> Table:
    """Set out the runs, a row for each law on each track.

    Parameters
    ----------
    rows : sequence of EdgeRun
        The runs.

    Returns
    -------
    rich.table.Table
        To be printed.

    Examples
    --------
    >>> from popsteer.study import edge_tracks, edges
    >>> edges_table(edges(["pop", "stanley"], edge_tracks()[:1])).row_count
    2
    """
    table = blank_table()
    for head in ("track", "law"):
        table.add_column(head, no_wrap=True)
    table.add_column("ending")
    for head in ("time\n[s]", "max |e|\n[m]", "max jump\n[deg]"):
        table.add_column(head, justify="right", no_wrap=True)
    table.add_column("status, share of the steps", overflow="fold")
    for index, row in enumerate(rows):
        last = index + 1 == len(rows) or rows[index + 1].track != row.track
        first = index == 0 or rows[index - 1].track != row.track
        table.add_row(
            row.track if first else "",
            title_of(row.law),
            row.ending,
            f"{row.time:.1f}",
            f"{row.max_error:.3f}",
            f"{math.degrees(row.max_jump):.2f}",
            share_text(row),
            end_section=last,
        )
    return table


def share_text(row: EdgeRun) -> str:
    """Say what share of the steps had which status, in whole percent.

    Parameters
    ----------
    row : EdgeRun
        The run.

    Returns
    -------
    str
        The most frequent first.

    Examples
    --------
    >>> from popsteer.study import edge_tracks, edges
    >>> share_text(edges(["pop"], edge_tracks()[:1])[0])
    'ok 100 %'
    """
    total = sum(row.statuses.values())
    shares = {status: 100.0 * count / total for status, count in row.statuses.items()}
    return ", ".join(
        f"{status.value} {f'{share:.0f}' if share >= 0.5 else '<1'} %"
        for status, share in shares.items()
    )


def edges_csv(rows: Sequence[EdgeRun]) -> str:
    """Write the runs as CSV, a row for each law on each track.

    Parameters
    ----------
    rows : sequence of EdgeRun
        The runs.

    Returns
    -------
    str
        The text; SI units and radians, and in the last column how many steps had which status.

    Examples
    --------
    >>> from popsteer.study import edge_tracks, edges
    >>> edges_csv(edges(["pop"], edge_tracks()[:1])).splitlines()[1]
    'track,law,finished,ending,time,max_error,max_jump,statuses'
    """
    lines = [
        "# time in s, max_error in m, max_jump in rad, statuses in steps",
        "track,law,finished,ending,time,max_error,max_jump,statuses",
    ]
    for row in rows:
        counts = " ".join(f"{status.value}={count}" for status, count in row.statuses.items())
        cells = (
            row.track,
            row.law,
            str(row.finished).lower(),
            row.ending,
            *map(repr, (row.time, row.max_error, row.max_jump)),
            counts,
        )
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def edges_json(rows: Sequence[EdgeRun]) -> str:
    """Write the runs as JSON.

    Parameters
    ----------
    rows : sequence of EdgeRun
        The runs.

    Returns
    -------
    str
        The document; SI units and radians.

    Examples
    --------
    >>> import json
    >>> from popsteer.study import edge_tracks, edges
    >>> json.loads(edges_json(edges(["pop"], edge_tracks()[:1])))["runs"][0]["finished"]
    True
    """
    document = {
        "schema": SCHEMA,
        "version": __version__,
        "plant": EDGE_PLANT,
        "max_steer": MAX_STEER,
        "changes": {law: dict(changes) for law, changes in EDGE_CHANGES.items()},
        "runs": [_entry(row) for row in rows],
    }
    return json_text(document)


def _entry(row: EdgeRun) -> dict[str, Any]:
    statuses = {status.value: count for status, count in row.statuses.items()}
    return {
        "track": row.track,
        "law": row.law,
        "finished": row.finished,
        "ending": row.ending,
        "time": row.time,
        "max_error": row.max_error,
        "max_jump": row.max_jump,
        "statuses": statuses,
    }
