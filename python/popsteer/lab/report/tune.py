"""The page of a tuning: what was tried, and how good the choice is."""

from __future__ import annotations

from typing import Any

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.report.colours import dots, figure, line, log_axis, named
from popsteer.lab.report.markup import badge, block, paragraphs, table
from popsteer.lab.report.page import Origin, Page, Section, vehicles
from popsteer.lab.tune import Tuned, report
from popsteer.lab.tune.report import Judged
from popsteer.params_file import as_toml


def of_tuning(tuned: Tuned, judged: list[Judged], origin: Origin | None = None) -> bytes:
    """Make the page of a tuning as `popsteer.lab.tune.report.judge` judged it."""
    origin = Origin() if origin is None else origin
    problem = tuned.problem
    losses = report.losses(judged)
    good = tuned.chosen is not None
    said = report.caption(tuned)
    results = "".join(table(each, "Errors before and after") for each in report.tables(judged))
    return Page(
        title=f"{title_of(problem.controller)}, tuned on {', '.join(problem.paths)}",
        lead=f"{counted(len(tuned.trials), 'trial')}, {counted(problem.cars + 1, 'car')}",
        command=origin.command,
        results=badge(said, losses, good=good) + results + paragraphs(report.notes(tuned, judged)),
        figures=[_trials(tuned)],
        roles={"before": named("pid"), "chosen": named("pop")},
        sections=[
            Section(
                "parameters",
                "Parameters",
                block("The tuning, for --params", as_toml(tuned.params, problem.controller)),
            ),
            vehicles({"plant": problem.whole.vehicle}, {"plant": problem.given}),
        ],
    ).content()


def _trials(tuned: Tuned) -> dict[str, Any]:
    shown = [each for each in tuned.trials if each.error < 50.0] or list(tuned.trials)
    usual, front = tuned.usual, tuned.front
    values = [", ".join(f"{k} {v:.4g}" for k, v in each.values.items()) for each in shown]
    hover = "%{text}: %{y:.4f} m, %{x:.4f} rad/s"
    traces = [
        dots("trials", *_places(shown), values, {"color": "@faint", "size": 6}, hover),
        line("Pareto front", *_places(front), "@chosen", shape="hv"),
        dots("before", *_places([usual]), ["before"], {"color": "@before", "size": 11}, hover),
    ]
    if tuned.chosen is not None:
        look = {"color": "@chosen", "size": 12, "symbol": "diamond"}
        traces.append(dots("chosen", *_places([tuned.chosen]), ["chosen"], look, hover))
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


def _places(tried: Any) -> tuple[list[float], list[float]]:  # noqa: ANN401 - trials or scores
    return [each.effort for each in tried], [each.error for each in tried]
