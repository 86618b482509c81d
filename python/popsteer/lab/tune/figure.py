"""What was tried: error against steering effort, and the front that no trial beats."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure

from popsteer.lab.common.draw import logarithmic
from popsteer.lab.common.names import counted, title_of
from popsteer.lab.common.theme import Theme
from popsteer.lab.tune.study import Tuned, places


def tune_figure(tuned: Tuned, theme: Theme) -> Figure:
    """Draw the trials, their Pareto front, and the tuning before and after."""
    figure = Figure(figsize=(7.4, 5.2), layout="constrained")
    panel = figure.subplots()
    usual, front = tuned.usual, tuned.front
    blue, red = theme.laws["pop"], theme.laws["pid"]
    limit, every = tuned.effort_limit * usual.effort, tuned.trials
    right = max([usual.effort, limit, *(each.effort for each in front)])
    left = min([usual.effort, *(each.effort for each in every)])
    edge = right + 0.35 * (right - left)
    shown = [each for each in every if each.error < 50.0 and each.effort <= edge] or list(every)
    said = "trials" if len(shown) == len(every) else f"trials ({len(shown)} of {len(every)})"
    panel.scatter(*places(shown), label=said, s=16, color=theme.faint, alpha=0.55, linewidths=0.0)
    panel.step(*places(front), where="post", color=blue, linewidth=1.4, label="Pareto front")
    allowed = f"{tuned.effort_limit:g} × the effort before"
    panel.axvline(limit, color=theme.faint, linestyle="--", linewidth=1.0, label=allowed)
    mark = partial(panel.plot, linestyle="")
    mark(*places([usual]), "s", color=red, markersize=8, label="before")
    if tuned.chosen is not None:
        mark(*places([tuned.chosen]), "D", color=blue, markersize=9, label="chosen")
    logarithmic(panel)
    panel.set_xlim(left - 0.08 * (right - left), edge)
    panel.set_xlabel("steering effort: rms rate of the wheels, mean of all runs [rad/s]")
    panel.set_ylabel("|cross-track error| after settling:\n(mean + worst run) / 2 [m]")
    figure.legend(loc="outside lower center", ncols=5)
    tracks = ", ".join(tuned.problem.paths)
    trials, cars = counted(len(tuned.trials), "trial"), counted(tuned.problem.cars + 1, "car")
    title = f"{title_of(tuned.problem.controller)}: {trials} on {tracks}, {cars}"
    figure.suptitle(title, fontsize=11, wrap=True)
    return figure
