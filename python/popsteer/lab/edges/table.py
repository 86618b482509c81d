"""The table of the pathological paths, for people and for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from popsteer._core import __version__
from popsteer.lab.common.layout import add_names, add_numbers, blank_table, csv_text, json_text
from popsteer.lab.common.names import title_of
from popsteer.lab.common.vehicle import differences
from popsteer.lab.edges.runs import EDGE_CHANGES, EDGE_PLANT
from popsteer.sim import plant_name, vehicle_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from popsteer._core import Vehicle
    from popsteer.lab.edges.runs import EdgeRun
    from popsteer.sim import Plant

__all__ = ["edges_caption", "edges_csv", "edges_json", "edges_notes", "edges_table", "share_text"]

SCHEMA = 2
"""Version of the document's layout."""


def edges_caption(plant: Plant = EDGE_PLANT, vehicle: Vehicle | None = None) -> str:
    """Say in one line what the runs have in common: plant, speeds, largest angle, kind of error.

    `vehicle` is what the controllers were given; the plant's own by default.

    Examples
    --------
    >>> edges_caption()
    'plant kinematic-bicycle, speeds of the paths, largest angle 34°; errors of the rear axle'
    """
    itself = vehicle_of(plant)
    believed = "" if vehicle is None else differences(vehicle, itself)
    return (
        f"plant {plant_name(plant)}{believed}, speeds of the paths, largest angle"
        f" {math.degrees(itself.max_steer):.0f}°; errors of the rear axle"
    )


def edges_table(rows: Sequence[EdgeRun]) -> Table:
    """Set out the runs, a row for each controller on each track.

    Examples
    --------
    >>> from popsteer.lab.edges import edge_tracks
    >>> from popsteer.lab import edges
    >>> edges_table(edges.run(["pop", "stanley"], edge_tracks()[:1])).row_count
    2
    """
    table = blank_table(1)
    add_names(table, "track", (row.track for row in rows))
    add_names(table, "controller", (title_of(row.law) for row in rows))
    add_numbers(table, "fin-\nished", "time\n[s]", "max |e|\n[m]", "max jump\n[deg]")
    table.add_column("status, share of the steps", overflow="fold", min_width=14)
    for index, row in enumerate(rows):
        last = index + 1 == len(rows) or rows[index + 1].track != row.track
        first = index == 0 or rows[index - 1].track != row.track
        table.add_row(
            row.track if first else "",
            title_of(row.law),
            "yes" if row.finished else "no",
            f"{row.time:.1f}",
            f"{row.max_error:.3f}",
            f"{math.degrees(row.max_jump):.2f}",
            share_text(row),
            end_section=last,
        )
    return table


def edges_notes(rows: Sequence[EdgeRun]) -> list[str]:
    """Say of each run that did not reach the end why.

    Examples
    --------
    >>> from popsteer.lab import edges
    >>> edges_notes(edges.run(["pop"], edges.edge_tracks()[:1]))
    []
    """
    return [
        f"{title_of(row.law)} on {row.track} ended after {row.time:.1f} s: {row.ending}."
        for row in rows
        if not row.finished
    ]


def share_text(row: EdgeRun) -> str:
    """Say in what share of the steps each condition held, in whole percent.

    The most frequent comes first; it is "ok" where none held. The shares of several conditions that
    held in the same steps add up to more than the whole.

    Examples
    --------
    >>> from popsteer.lab.edges import edge_tracks
    >>> from popsteer.lab import edges
    >>> share_text(edges.run(["pop"], edge_tracks()[:1])[0])
    'ok 100 %'
    """
    shares = {status: 100.0 * count / row.steps for status, count in row.statuses.items()}
    return ", ".join(
        f"{status} {f'{share:.0f}' if share >= 0.5 else '<1'} %" for status, share in shares.items()
    )


def edges_csv(rows: Sequence[EdgeRun]) -> str:
    """Write the runs as CSV, a row for each controller on each track, in SI units and radians.

    The last column says in how many steps each condition held.

    Examples
    --------
    >>> from popsteer.lab.edges import edge_tracks
    >>> from popsteer.lab import edges
    >>> edges_csv(edges.run(["pop"], edge_tracks()[:1])).splitlines()[1]
    'track,law,finished,ending,time,max_error,max_jump,statuses'
    """
    lines = []
    for row in rows:
        counts = " ".join(f"{status}={count}" for status, count in row.statuses.items())
        numbers = map(repr, (row.time, row.max_error, row.max_jump))
        lines.append((row.track, row.law, str(row.finished).lower(), row.ending, *numbers, counts))
    comment = "time in s, max_error in m, max_jump in rad, statuses in steps"
    names = ["track", "law", "finished", "ending", "time", "max_error", "max_jump", "statuses"]
    return csv_text([comment], names, lines)


def edges_json(
    rows: Sequence[EdgeRun], plant: Plant = EDGE_PLANT, vehicle: Vehicle | None = None
) -> str:
    """Write the runs as JSON, in SI units and radians.

    `vehicle` is what the controllers were given; the plant's own by default.

    Examples
    --------
    >>> import json
    >>> from popsteer.lab.edges import edge_tracks
    >>> from popsteer.lab import edges
    >>> json.loads(edges_json(edges.run(["pop"], edge_tracks()[:1])))["runs"][0]["finished"]
    True
    """
    itself = vehicle_of(plant)
    document = {
        "schema": SCHEMA,
        "version": __version__,
        "plant": plant_name(plant),
        "plant_vehicle": itself.as_dict(),
        "vehicle": (itself if vehicle is None else vehicle).as_dict(),
        "max_steer": itself.max_steer,
        "changes": {law: dict(changes) for law, changes in EDGE_CHANGES.items()},
        "runs": [_entry(row) for row in rows],
    }
    return json_text(document)


def _entry(row: EdgeRun) -> dict[str, Any]:
    return {
        "track": row.track,
        "law": row.law,
        "finished": row.finished,
        "ending": row.ending,
        "time": row.time,
        "max_error": row.max_error,
        "max_jump": row.max_jump,
        "steps": row.steps,
        "statuses": {str(status): count for status, count in row.statuses.items()},
    }
