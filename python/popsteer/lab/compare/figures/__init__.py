"""Figures of a comparison, drawn without a screen and without pyplot's global state."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from popsteer.errors import ConfigError
from popsteer.lab.common.draw import drawn
from popsteer.lab.common.theme import THEMES
from popsteer.lab.compare.figures.overview import overview_figure
from popsteer.lab.compare.figures.results import results_figure

if TYPE_CHECKING:
    from popsteer.lab.compare import Comparison

__all__ = ["FIGURES", "THEMES", "render"]

FIGURES = {"results": results_figure, "overview": overview_figure}
"""What draws each figure, by its name."""


def render(comparison: Comparison, figure: str, theme: str = "light") -> dict[str, bytes]:
    """Draw a figure: the content of the file by its kind, ``png`` and ``svg``.

    ``results`` is as the paper's figure of results, a column for each controller with the path
    driven, cross-track error, heading error and angle. ``overview`` has the controllers on one
    axis, and their figures beside the paper's. The runs need their records. `theme` is "light" or
    "dark". Raises ConfigError where no figure, or no theme, has this name.
    """
    if figure not in FIGURES:
        raise ConfigError.unknown("figure", figure, FIGURES)
    if theme not in THEMES:
        raise ConfigError.unknown("theme", theme, THEMES)
    return drawn(partial(FIGURES[figure], comparison), THEMES[theme])
