"""The page of a comparison: each controller a car on one map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from popsteer.errors import ConfigError
from popsteer.lab.common.names import title_of
from popsteer.lab.compare.table import caption, notes, tables
from popsteer.lab.report.colours import colours_of
from popsteer.lab.report.markup import paragraphs, table
from popsteer.lab.report.origin import Origin, settings_block, tuning, vehicles
from popsteer.lab.report.page import Page, page_bytes
from popsteer.lab.report.scene import ANGLES, Actor, Panel, Scene, distances
from popsteer.lab.report.times import latency_figure, latency_table
from popsteer.lab.report.verdict import of_runs

if TYPE_CHECKING:
    from popsteer.lab.compare import Comparison
    from popsteer.lab.report.colours import Colour
    from popsteer.sim import Run

PANELS = (
    Panel("cross_track_error", "Cross-track error [m]", "e [m]", 3),
    Panel("heading_error_deg", "Heading error [deg]", "ψe [deg]", 2),
    ANGLES,
    Panel("speed", "Speed [m/s]", "v [m/s]", 2),
    Panel("status", "Status (thin: degraded, thick: fault)", "status"),
)
"""What is drawn of a run."""


def of_comparison(comparison: Comparison, origin: Origin | None = None) -> bytes:
    """Make the page of a comparison.

    The page is one HTML file, which needs nothing from the network. `origin` is the command and the
    parameters that made it. Raises ConfigError where the runs kept no records, and
    ModuleNotFoundError where plotly is not installed; the extra ``lab`` brings it.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import compare
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> page = of_comparison(compare.run(path, ["stanley", "pop"]))
    >>> page.startswith(b"<!doctype html>"), len(page) < 2_500_000
    (True, True)
    """
    origin = Origin() if origin is None else origin
    if not comparison.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where a report is wanted")
    titles = [title_of(name) for name in comparison.runs]
    shown = titles[0] if len(titles) == 1 else f"{', '.join(titles[:-1])} and {titles[-1]}"
    place = f" on {comparison.track}" if comparison.track else ""
    results = "".join(table(each, "Errors of the controllers") for each in tables(comparison))
    return page_bytes(
        Page(
            title=f"{shown}{place}",
            lead=caption(comparison),
            command=origin.command,
            results=of_runs([comparison]) + results + paragraphs(notes(comparison)),
            below=latency_table(comparison),
            scenes=[scene_of(comparison)],
            roles=colours_of(comparison.runs),
            sections=[
                vehicles(
                    {comparison.plant: comparison.vehicle}, {comparison.plant: comparison.believed}
                ),
                tuning(origin, settings_block(comparison.first.settings)),
            ],
        )
    )


def scene_of(comparison: Comparison) -> Scene:
    """Let the cars of a comparison drive on one map; the runs need their records."""
    colours = colours_of(comparison.runs)
    parts = (comparison.plant, comparison.track)
    return Scene(
        title=", ".join(part for part in parts if part),
        actors=[
            actor_of(run, name, title_of(name), colours[name])
            for name, run in comparison.runs.items()
        ],
        panels=PANELS,
        vehicle=comparison.vehicle,
        paths=[comparison.path],
        figures=latency_figure(comparison),
    )


def actor_of(run: Run, name: str, title: str, colour: Colour) -> Actor:
    """Make a car of a run, which needs its records."""
    records = run.records
    x, y, yaw, speed = (records[key] for key in ("x", "y", "yaw", "speed"))
    columns = {
        "time": records["time"],
        "distance": distances(run.path, x, y, yaw, speed),
        "x": x,
        "y": y,
        "yaw": yaw,
        "speed": speed,
        "steer_deg": np.degrees(records["steer"]),
        "cross_track_error": records["cross_track_error"],
        "heading_error_deg": np.degrees(records["heading_error"]),
        "status": records["status"],
    }
    return Actor(name, title, colour, columns)
