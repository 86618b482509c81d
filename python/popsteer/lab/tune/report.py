"""How good a tuning is, on the tracks and cars of the search and on others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from statistics import fmean
from typing import TYPE_CHECKING, NamedTuple

from popsteer import tracks
from popsteer._core import Path
from popsteer.lab.common.layout import add_names, add_numbers, blank_table
from popsteer.lab.common.names import where_they_differ
from popsteer.lab.tune.problem import Problem, Score
from popsteer.lab.tune.study import Tuned

if TYPE_CHECKING:
    from rich.table import Table


class Judged(NamedTuple):
    """The tuning that it began with, and the one that was chosen, on the same runs."""

    problem: Problem
    usual: Score
    """Of the tuning that it began with."""
    tuned: Score
    """Of the one that was chosen."""
    seen: bool
    """Whether the search was judged by these runs."""


def judge(tuned: Tuned, progress: Callable[[str, float], object] | None = None) -> list[Judged]:
    """Judge the choice on the search's tracks and cars, on other cars, and on other tracks."""
    problem = tuned.problem
    shipped = [tracks.get(name) for name in tracks.names() if name not in problem.paths]
    others = {each.name: Path(each.xy, speed=each.speed, closed=each.closed) for each in shipped}
    fresh = problem.seed + 1_000_003
    parts = [(problem, True)]
    if problem.cars:  # without them the same runs would be judged twice
        parts.append((replace(problem, seed=fresh), False))
    if others:
        parts.append((replace(problem, paths=others, seed=fresh), False))
    found = []
    for done, (part, seen) in enumerate(parts):
        if progress is not None:
            progress("judging", done / len(parts))
        usual, chosen = part.score(problem.base), part.score(tuned.params)
        found.append(Judged(part, usual, chosen, seen))
    return found


def caption(tuned: Tuned) -> str:
    """Say in one line what was found: the tuning, or that it stays as it was."""
    name, count = tuned.problem.controller, len(tuned.trials)
    if tuned.chosen is None:
        return (
            f"{name}: none of {count} trials is better within {tuned.effort_limit:g} times the"
            " effort; the tuning stays as it was"
        )
    values = ", ".join(f"{k} {getattr(tuned.params, k):.4g}" for k in tuned.chosen.values)
    return f"{name}, the best of {count} trials: {values}"


def tables(judged: list[Judged]) -> list[Table]:
    """Set out the tracks, a row each."""
    table = blank_table(gap=1)
    add_names(table, "track", (name for part in judged for name in part.problem.paths))
    table.add_column("seen", no_wrap=True)
    for head in ("mean\n[m]", "worst\n[m]", "steering\n[rad/s]"):
        add_numbers(table, f"{head}\nbefore", "\n\nafter")
    for part in judged:
        for name in part.problem.paths:
            old, new = part.usual.errors[name], part.tuned.errors[name]
            efforts = part.usual.efforts[name], part.tuned.efforts[name]
            known = "cars no" if name in judged[0].problem.paths else "no"
            values = *map(fmean, (old, new)), *map(max, (old, new)), *map(fmean, efforts)
            table.add_row(name, "yes" if part.seen else known, *map(_number, values))
    return [table]


class _Loss(NamedTuple):
    """What is told to be worse than before where it has grown by more than a share of itself."""

    what: str
    figures: Callable[[Score], Mapping[str, tuple[float, ...]]]
    of: Callable[[Iterable[float]], float]
    share: float
    unit: str
    form: str
    least: float = 0.0


_LOSSES = (
    _Loss("mean error", lambda score: score.errors, fmean, 0.02, "m", ".4f", 1e-3),
    _Loss("worst error", lambda score: score.errors, max, 0.05, "m", ".4f", 1e-3),
    _Loss("steering", lambda score: score.efforts, fmean, 0.1, "rad/s", ".3f"),
)


def losses(judged: list[Judged]) -> list[str]:
    """Say where the tuning that was chosen is worse than the one that it began with."""
    said, limits = [], []
    for loss in _LOSSES:
        least = f" and {loss.least:g} {loss.unit}" if loss.least else ""
        limits.append(f"{loss.what} more than {100.0 * loss.share:g} %{least}")
        found = []
        for part in judged:
            for name in part.problem.paths:
                both = (loss.figures(part.usual)[name], loss.figures(part.tuned)[name])
                before, after = map(loss.of, both)
                if after > (1.0 + loss.share) * before and after - before > loss.least:
                    where = f"{name}{'' if part.seen else ' (not seen)'}"
                    found.append(f"{where} {before:{loss.form}} → {after:{loss.form}} {loss.unit}")
        if found:
            said.append(f"{limits[-1].capitalize()} above before: {', '.join(found)}.")
    return said or [
        f"On none of these tracks is {', '.join(limits[:-1])} or {limits[-1]} above before."
    ]


def notes(tuned: Tuned, judged: list[Judged]) -> list[str]:
    """Say what the table has no room for."""
    vary = ", ".join(f"{name} {each}" for name, each in tuned.problem.vary.items())
    settled = tuned.problem.settled
    judged_by = (
        f"Mean |cross-track error| {settled}, of each of {tuned.problem.cars + 1} cars, and their"
        " worst; a run that does not finish counts as 100 m. The first car is the vehicle itself;"
        f" of the others vary {vary or 'nothing'}."
    )
    chosen = (
        "Chosen: the least of (mean + worst) / 2 over the tracks and cars of the search with at"
        f" most {tuned.effort_limit:g} times the steering rate."
    )
    begun = tuned.problem.beginnings()
    said = [judged_by, chosen]
    said += where_they_differ(((name,), itself) for name, itself, _ in begun)
    differ = where_they_differ(((name,), others) for name, _, others in begun if others)
    said += [f"The cars that differ: {each[0].lower()}{each[1:]}" for each in differ]
    if tuned.chosen is not None:
        for name, each in tuned.problem.search.items():
            value = tuned.chosen.values[name]
            lower = value < each.quantile(0.02) and each.bounds[0] != 0.0  # below 0 is nothing
            if lower or value > each.quantile(0.98):
                said.append(f"{name} is at an end of {each}: search farther.")
    return said + losses(judged)


def _number(value: float) -> str:
    """At most six characters up to 9999."""
    return f"{value:.4f}" if value < 10.0 else f"{value:.1f}"
