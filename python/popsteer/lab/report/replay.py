"""The page of a replay: the recorded drive, and what each controller would have commanded."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.replay import Replay
from popsteer.lab.replay.table import NOTE, caption, replay_table, statuses
from popsteer.lab.report.colours import colours_of, figure, named, stairs
from popsteer.lab.report.compare import PANELS
from popsteer.lab.report.markup import badge, paragraphs, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, tuning, vehicles
from popsteer.lab.report.scene import ANGLES, Actor, Panel, Scene, travelled

_DRIVER = "driver"
_PANELS = (
    ANGLES,
    Panel("difference_deg", "Angle less the driver's [deg]", "less driver's [deg]", 2),
    *(panel for panel in PANELS if panel is not ANGLES),
)


def of_replay(found: Replay, origin: Origin = NOWHERE) -> bytes:
    """Make the page of a replay; `origin` and errors are as `of_comparison` has them.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.lab import replay
    >>> from popsteer.logs import Log
    >>> t = np.arange(0.0, 10.0, 0.05)
    >>> log = Log(t, 8.0 * t, 0.0 * t, 0.0 * t, 8.0 + 0.0 * t, 0.0 * t)
    >>> page = of_replay(replay.run(log, {"stanley": None}, popsteer.Vehicle()))
    >>> page.startswith(b"<!doctype html>")
    True
    """
    titles = ", ".join([title_of(name, found.shadows) for name in found.shadows])
    return Page(
        title=f"{titles} beside the driver of {found.log.name}",
        lead=caption(found),
        command=origin.command,
        results=verdict(found)
        + table(replay_table(found), "Angles beside the driver's")
        + paragraphs([*statuses(found), *found.log.remarks, NOTE]),
        scenes=[_scene(found)],
        roles=colours_of(found.shadows) | {_DRIVER: named("faint")},
        figures=[_histogram(found)],
        sections=[vehicles(("given", found.vehicle, found.vehicle)), tuning(origin)],
    ).content()


def verdict(found: Replay) -> str:
    """Say how many controllers would have driven the log without a fault."""
    shares = {each.name: each.share("fault") for each in found.shadows.values()}
    wrong = [
        f"{title_of(name, shares)} (fault in {100.0 * share:.1f} % of the rows)"
        for name, share in shares.items()
        if share > 0.0
    ]
    head = f"{len(shares) - len(wrong)} of {counted(len(shares), 'controller')}"
    return badge(f"{head} reported no fault along the drive", wrong, good=not wrong)


def _scene(found: Replay) -> Scene:
    log = found.log
    cut = partial(broken, gaps=log.gaps)
    colours = colours_of(found.shadows)
    time = log.t - log.t[0]
    common = {"time": time, "distance": travelled(time, log.speed)}
    common |= {"x": cut(log.x), "y": log.y, "yaw": log.yaw}
    driven = {**common, "speed": cut(log.speed), "steer_deg": cut(np.degrees(log.steer))}
    actors = [Actor(_DRIVER, "driver", named("faint"), driven, width=3.0)]
    for name, shadow in found.shadows.items():
        columns = {
            **common,
            "steer_deg": cut(np.degrees(shadow.steer)),
            "difference_deg": cut(np.degrees(shadow.steer - log.steer)),
            "cross_track_error": cut(shadow.cross_track_error),
            "heading_error_deg": cut(np.degrees(shadow.heading_error)),
            "status": shadow.status,
        }
        title = title_of(name, found.shadows)
        actors.append(Actor(name, title, colours[name], columns, body="ray"))
    return Scene(
        title=log.name,
        actors=actors,
        panels=_PANELS,
        vehicle=found.vehicle,
        paths=[next(iter(found.shadows.values())).path],
        distance_title="distance driven [m]",
    )


def broken(values: NDArray[Any], gaps: Sequence[int]) -> NDArray[np.float64]:
    """Break a line at the gaps of a log, with NaN at the first row after each."""
    column = np.array(values, dtype=np.float64)
    column[list(gaps)] = np.nan
    return column


def _histogram(found: Replay) -> dict[str, Any]:
    differences = {
        name: np.degrees(shadow.steer - found.log.steer) for name, shadow in found.shadows.items()
    }
    end = max(float(np.max(np.abs(each))) for each in differences.values()) or 1.0
    edges, hover = np.linspace(-end, end, 62), "%{y:.2f} % of the rows from %{x:.2f}°"
    traces = []
    for name, each in differences.items():
        counts, _ = np.histogram(each, edges)
        shares = (*(100.0 * counts / len(each)), 0.0)
        traces.append(stairs(name, found.shadows, edges, shares, 1.6, hover))
    up = {"title": {"text": "rows [%]"}, "rangemode": "tozero"}
    note = "Share of the log's rows."
    return figure("Angle less the driver's", note, traces, "difference [deg]", up)
