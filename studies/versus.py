"""Draws README's figure: four controllers on the paper's track, and on a plant from elsewhere.

python -m studies.versus
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from popsteer import lab, sim
from popsteer.lab.common.names import title_of
from studies.layout import course, write_figures

if TYPE_CHECKING:
    from popsteer.lab.common.theme import Theme
    from popsteer.lab.compare import Comparison

CONTROLLERS = ("pop", "stanley", "pure-pursuit", "preview-pop")
PANELS = (
    ("authors", "carla-identified", "the paper's track, the car identified from its run"),
    ("slalom", "commonroad-mb-2", "slalom, CommonRoad's multi-body BMW 320i"),
)


def driven(track: str, plant: str) -> Comparison:
    """Drive all four, at 10 m/s from 1 m beside the path, as README's matrix does."""
    path, _ = course(track)
    start = sim.default_start(path, 1.0, sim.vehicle_of(plant))
    return lab.compare.run(path, CONTROLLERS, plant, start=start, constant_speed=10.0)


def versus_figure(found: list[Comparison], theme: Theme) -> Figure:
    """Draw the rear axle's errors over the distance: one point for all, and all of them."""
    figure = Figure(figsize=(10.0, 5.4), layout="constrained")
    for panel, each, (_, _, title) in zip(figure.subplots(2, 1), found, PANELS, strict=True):
        styles = theme.styles(each.runs)
        for name, run in each.runs.items():
            far = np.cumsum(np.abs(run.records["speed"])) * run.dt
            mean = run.metrics.rear_axle_settled_mean_abs_cross_track_error
            label = f"{title_of(name)}: {mean:.4f} m"
            errors = run.records["rear_cross_track_error"]
            look = {"color": theme.colour(name), "linestyle": styles[name]}
            panel.plot(far, errors, label=label, **look)
        panel.axvline(50.0, color=theme.faint, lw=0.8, ls=":")
        panel.margins(x=0.0)
        panel.set_title(title, fontsize=10.5, loc="left")
        panel.set_ylabel("error of the rear axle [m]")
        panel.legend(
            title="mean after 5 s", loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2
        )
    panel.set_xlabel("distance driven [m]")
    return figure


def main() -> None:
    """Drive and draw."""
    found = [driven(track, plant) for track, plant, _ in PANELS]
    write_figures({"versus": partial(versus_figure, found)})


if __name__ == "__main__":
    main()
