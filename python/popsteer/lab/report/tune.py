"""The page of a tuning: what was tried, and how good the choice is."""

from __future__ import annotations

from typing import Any

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.report.colours import dots, figure, line, log_axis, named
from popsteer.lab.report.markup import badge, block, paragraphs, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, Section, vehicles
from popsteer.lab.tune import Tuned, report
from popsteer.lab.tune.report import Judged
from popsteer.lab.tune.study import places
from popsteer.params_file import as_toml


def of_tuning(tuned: Tuned, judged: list[Judged], origin: Origin = NOWHERE) -> bytes:
    """Make the page of a tuning as `popsteer.lab.tune.report.judge` judged it."""
    problem = tuned.problem
    losses = report.losses(judged)
    good = tuned.chosen is not None
    said, text = report.caption(tuned), as_toml(tuned.params, problem.controller)
    results = "".join(table(each, "Errors before and after") for each in report.tables(judged))
    return Page(
        title=f"{title_of(problem.controller)}, tuned on {', '.join(problem.paths)}",
        lead=f"{counted(len(tuned.trials), 'trial')}, {counted(problem.cars + 1, 'car')}",
        command=origin.command,
        results=badge(said, losses, good=good) + results + paragraphs(report.notes(tuned, judged)),
        figures=[_trials(tuned)],
        roles={"before": named("pid"), "chosen": named("pop")},
        sections=[
            Section("parameters", "Parameters", block("The tuning, for --params", text)),
            vehicles(("plant", problem.whole.vehicle, problem.given)),
        ],
    ).content()


def _trials(tuned: Tuned) -> dict[str, Any]:
    shown = [each for each in tuned.trials if each.error < 50.0] or list(tuned.trials)
    usual, front = tuned.usual, tuned.front
    values = [", ".join(f"{k} {v:.4g}" for k, v in each.values.items()) for each in shown]
    hover = "%{text}: %{y:.4f} m, %{x:.4f} rad/s"
    traces = [
        dots("trials", *places(shown), values, {"color": "@faint", "size": 6}, hover),
        line("Pareto front", *places(front), "@chosen", shape="hv"),
        dots("before", *places([usual]), ["before"], {"color": "@before", "size": 11}, hover),
    ]
    if tuned.chosen is not None:
        look = {"color": "@chosen", "size": 12, "symbol": "diamond"}
        traces.append(dots("chosen", *places([tuned.chosen]), ["chosen"], look, hover))
    errors = [*(each.error for each in shown), usual.error]
    limit = tuned.effort_limit * usual.effort
    return figure(
        "Error over steering effort",
        f"Chosen is the least error with at most {limit:.4f} rad/s, {tuned.effort_limit:g} times"
        " the effort before; point at a trial for its parameters.",
        traces,
        "steering effort: rms rate of the wheels, mean of all runs [rad/s]",
        log_axis("(mean + worst) / 2 [m]", min(errors), max(errors)),
        hovermode="closest",
    )
