"""The files of a comparison: all computed before the first is written."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from popsteer.errors import ConfigError
from popsteer.lab.compare.metrics_json import metrics_json
from popsteer.lab.compare.runs_csv import run_csv

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from popsteer.lab.compare import Comparison

_METRICS = "metrics.json"


def files(
    comparison: Comparison, progress: Callable[[str, float], object] | None = None
) -> dict[str, bytes]:
    """Compute the files of a comparison, by name.

    They are ``runs/LAW.csv`` for each controller, ``results`` and ``overview`` as ``.png`` and
    ``.svg``, each for a light and, as ``-dark``, for a dark background, and ``metrics.json``.
    `progress` is called with what is being done and the share of it that is done, 0 to 1. Raises
    ConfigError where the runs kept no records.
    """
    from popsteer.lab.compare.figures import FIGURES, THEMES, render

    if not comparison.first.settings.keep_records:
        raise ConfigError("keep_records", value=False, requirement="true where files are wanted")
    content = {_record_name(name): run_csv(run).encode() for name, run in comparison.runs.items()}
    wanted = [(figure, theme) for figure in FIGURES for theme in THEMES]
    for done, (figure, theme) in enumerate(wanted):
        if progress is not None:
            progress("figures", done / len(wanted))
        for kind, data in render(comparison, figure, theme).items():
            content[_figure_name(figure, theme, kind)] = data
    if progress is not None:
        progress("figures", 1.0)
    # Written last: where it exists, the others do too.
    content[_METRICS] = metrics_json(comparison).encode()
    return content


def file_names(laws: Iterable[str]) -> list[str]:
    """Give the names that `files` will give, before there is a comparison."""
    from popsteer.lab.compare.figures import FIGURES, THEMES

    figures = [
        _figure_name(figure, theme, kind)
        for figure in FIGURES
        for theme in THEMES
        for kind in ("png", "svg")
    ]
    return [*map(_record_name, laws), *figures, _METRICS]


def _record_name(law: str) -> str:
    return f"runs/{re.sub(r'[^A-Za-z0-9._-]+', '-', law)}.csv"


def _figure_name(figure: str, theme: str, kind: str) -> str:
    return f"{figure}{'' if theme == 'light' else f'-{theme}'}.{kind}"
