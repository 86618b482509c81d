"""The page of an identification: the measured car beside the simulated one."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from popsteer import vehicle_file
from popsteer._core import Vehicle
from popsteer.identification import Identification
from popsteer.lab.identify import caption, identified_table, smoothed
from popsteer.lab.report.colours import figure, named, rounded
from popsteer.lab.report.markup import badge, block, paragraphs, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, Section
from popsteer.lab.report.replay import broken
from popsteer.lab.report.scene import ANGLES, Actor, Panel, Scene, travelled

_PANELS = (
    Panel("yaw_rate", "Yaw rate, smoothed over 0.25 s [rad/s]", "yaw rate [rad/s]", 3),
    Panel("yaw_rate_residual", "Yaw rate, measured less simulated [rad/s]", "residual [rad/s]", 4),
    Panel("position_error", "Position, measured less simulated, to the left [m]", "off [m]", 3),
    ANGLES,
    Panel("speed", "Speed [m/s]", "v [m/s]", 2),
)


def of_identification(
    found: Identification, given: Vehicle | None = None, origin: Origin = NOWHERE
) -> bytes:
    """Make the page of an identification; `given` is the vehicle as it was known before.

    `origin` and errors are as `of_comparison` has them.
    """
    vehicle = block("The vehicle as found, for --vehicle", found.as_toml())
    if given is not None:
        vehicle += block("The vehicle as given before", vehicle_file.as_toml(given))
    head, _, rest = found.verdict.partition(": ")
    return Page(
        title=f"The vehicle of {found.log.name}",
        lead=caption(found),
        command=origin.command,
        results=badge(head, [rest], good=found.explains)
        + table(identified_table(found, given), "What was found, ± errors of noise and model")
        + paragraphs(found.notes),
        scenes=[_scene(found)],
        roles={"measured": named("pop"), "simulated": named("pid")},
        figures=_histograms(found),
        sections=[Section("vehicle", "Vehicle", vehicle)],
    ).content()


def _scene(found: Identification) -> Scene:
    log, records = found.log, found.records
    cut = partial(broken, gaps=log.gaps)
    time = records["t"] - records["t"][0]
    counts = np.asarray(records["counts"], dtype=np.bool_)
    residual = np.where(counts, records["yaw_rate"] - records["simulated_yaw_rate"], np.nan)
    common = {"time": time, "distance": travelled(time, log.speed)}
    measured = {
        **common,
        "x": cut(records["x"]),
        "y": records["y"],
        "yaw": log.yaw,
        "speed": cut(log.speed),
        "steer_deg": cut(np.degrees(log.steer)),
        "yaw_rate": smoothed(cut(records["yaw_rate"]), log.period),
        "yaw_rate_residual": smoothed(cut(residual), log.period),
        "position_error": cut(np.where(counts, records["position_error"], np.nan)),
    }
    # The simulation restarts at intervals; the line breaks where it jumps.
    x, y = records["simulated_x"], records["simulated_y"]
    jumps = np.hypot(np.diff(x), np.diff(y)) > 2.0 * np.abs(log.speed[1:]) * np.diff(time) + 0.05
    simulated = {
        **common,
        "x": broken(x, [*log.gaps, *(np.flatnonzero(jumps) + 1).tolist()]),
        "y": y,
        "yaw_rate": smoothed(cut(records["simulated_yaw_rate"]), log.period),
    }
    return Scene(
        title=log.name,
        actors=[
            Actor("measured", "measured", named("pop"), measured),
            Actor("simulated", "simulated, anew every 10 s", named("pid"), simulated, body="dot"),
        ],
        panels=_PANELS,
        vehicle=found.vehicle,
        distance_title="distance driven [m]",
    )


def _histograms(found: Identification) -> list[dict[str, Any]]:
    rate = found.records["yaw_rate"] - found.records["simulated_yaw_rate"]
    aside = found.records["position_error"]
    return [
        _histogram(found, "Yaw rate, measured less simulated", "rad/s", rate),
        _histogram(found, "Position, measured less simulated, to the left", "m", aside),
    ]


def _histogram(
    found: Identification, title: str, unit: str, residual: NDArray[Any]
) -> dict[str, Any]:
    values = residual[np.asarray(found.records["counts"], dtype=np.bool_)].astype(np.float64)
    values = values[np.isfinite(values)]
    counts, edges = np.histogram(values, 60) if len(values) else (np.zeros(1), np.zeros(2))
    rms = float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
    bars = {
        "type": "bar",
        "x": rounded(0.5 * (edges[1:] + edges[:-1]), 5),
        "y": [int(count) for count in counts],
        "marker": {"color": "@measured"},
        "hovertemplate": "%{y} samples around %{x:.3g}<extra></extra>",
    }
    note = f"{len(values)} samples, unsmoothed; root mean square {rms:.4f} {unit}."
    return figure(
        title, note, [bars], f"residual [{unit}]", "samples", bargap=0.02, showlegend=False
    )
