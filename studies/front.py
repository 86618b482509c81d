"""Costs of preview POP over the suite: error, noise, effort and margins, for preview_pop.md.

python -m studies.front
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from popsteer import PreviewPopParams, lab
from popsteer.lab.stability import margins
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.runs import mean_error
from studies.layout import cells, line, write_figures, write_table

if TYPE_CHECKING:
    from popsteer.lab.common.theme import Theme

STEER_RATE = (6.0, 12.0, 24.0, 48.0, 100.0, 200.0)
"""Shares of the wheelbase that `steer_rate_cost` is; the default is the second."""
HEADING = (1.0, 0.5)
"""Wheelbases that `heading_cost` is; the default is the first."""
UNDER = ("as told", "noise", "play", "dead time untold")


def front_line(steer_rate: float, heading: float) -> str:
    """Drive the suite on its car, and word a row."""
    car = suite_car().vehicle
    length = car.wheelbase
    given = PreviewPopParams(steer_rate_cost=length / steer_rate, heading_cost=heading * length)
    driven = lab.suite.run({"preview-pop": given}, ["suite-car"], conditions=UNDER).cells
    found = []
    for condition in UNDER:
        runs = [each for each in driven if each.condition == condition]
        failed = sum(each.ending != "finished" for each in runs)
        found.append(f"{1e3 * mean_error(runs):.1f}" + (f" ({failed})" if failed else ""))
        if condition == "noise":
            effort = sum(each.steer_rate for each in runs) / len(runs)
    slow, fast = (margins(given, car, speed) for speed in (10.0, 20.0))
    found += [
        f"{effort:.2f}",
        f"{slow.gain:.1f}",
        f"{1e3 * slow.dead_time:.0f}",
        f"{1e3 * fast.dead_time:.0f}",
    ]
    costs = f"L/{steer_rate:g}", "L" if heading == 1.0 else f"L/{1.0 / heading:g}"
    if (steer_rate, heading) == (STEER_RATE[1], HEADING[0]):
        costs = f"**{costs[0]}**", f"**{costs[1]}**"
    return line(*costs, *found)


def front_figure(lines: list[str], theme: Theme) -> Figure:
    """Draw the error in noise over that as told, the margin beside each point."""
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    panel = figure.subplots()
    for title, role in (("L", "preview-pop"), ("L/2", "pop")):
        own = [row for row in map(cells, lines) if row[1] == title]
        x, y = ([float(row[at]) for row in own] for at in (2, 3))
        panel.plot(
            x, y, "o-", color=theme.colour(role), label=f"heading_cost {title}", markersize=6
        )
        for row, right, up in zip(own, x, y, strict=True):
            # Away from its curve, and from the other one.
            shift, side = ((-6, -10), "right") if title == "L" else ((7, 4), "left")
            if right > 3.0:
                shift, side = (0, 9 if title == "L" else -13), "center"
            text = f"{row[0]}, {row[8]} ms"
            label = panel.annotate(
                text, (right, up), xytext=shift, textcoords="offset points", fontsize=7, ha=side
            )
            label.set_path_effects([withStroke(linewidth=3.0, foreground=theme.background)])
    panel.set_xlabel("mean |cross-track error| as told [mm]")
    panel.set_ylabel("in noise of 5 cm and 0.01 rad [mm]")
    panel.margins(0.2, 0.15)
    panel.set_title("steer_rate_cost, and the dead time that may be added at 10 m/s", fontsize=10)
    panel.legend()
    return figure


def main() -> None:
    """Put the table and the figure into docs/."""
    lines = [front_line(rate, heading) for heading in HEADING for rate in STEER_RATE]
    write_table("preview_pop.md", "front", lines)
    write_figures({"front": partial(front_figure, lines)})
    print("\n".join(lines))


if __name__ == "__main__":
    main()
