"""From a figure to the bytes of its files."""

from __future__ import annotations

import io
from functools import partial
from typing import TYPE_CHECKING

import matplotlib as mpl

from popsteer.errors import ConfigError
from popsteer.report.figures.overview import overview_figure
from popsteer.report.figures.results import results_figure
from popsteer.report.figures.theme import THEMES

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from popsteer.report.figures.theme import Theme
    from popsteer.study import Comparison

__all__ = ["FIGURES", "drawn", "render"]

FIGURES = {"results": results_figure, "overview": overview_figure}
"""What draws each figure, by its name."""

_DPI = 150
# Without the date, so that the same figure is the same file.
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


def render(comparison: Comparison, figure: str, theme: str = "light") -> dict[str, bytes]:
    r"""Draw a figure.

    Parameters
    ----------
    comparison : Comparison
        The runs, with their records.
    figure : {"results", "overview"}
        ``results``: as the paper's figure of results, a column for each law with the path driven,
        cross-track error, heading error and angle. ``overview``: the laws on one axis, and their
        figures beside the paper's.
    theme : {"light", "dark"}, default "light"
        The background.

    Returns
    -------
    dict
        The content of the file by its kind, ``png`` and ``svg``.

    Raises
    ------
    ConfigError
        No figure, or no theme, has this name.

    Examples
    --------
    >>> import popsteer
    >>> from popsteer.study import compare
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> comparison = compare(path, ["pop"])
    >>> render(comparison, "results")["png"][:4]
    b'\x89PNG'
    """
    if figure not in FIGURES:
        raise ConfigError.unknown("figure", figure, FIGURES)
    if theme not in THEMES:
        raise ConfigError.unknown("theme", theme, THEMES)
    return drawn(partial(FIGURES[figure], comparison), THEMES[theme])


def drawn(draw: Callable[[Theme], Figure], theme: Theme) -> dict[str, bytes]:
    """Draw a figure in a theme.

    Parameters
    ----------
    draw : callable
        Makes the figure from the theme.
    theme : Theme
        The colours.

    Returns
    -------
    dict
        The content of the file by its kind, ``png`` and ``svg``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> sorted(drawn(lambda theme: Figure(figsize=(1, 1)), THEMES["light"]))
    ['png', 'svg']
    """
    content = {}
    with mpl.rc_context(theme.settings):
        figure = draw(theme)
        # The layout takes longer than the drawing; once found, it serves both kinds of file.
        figure.draw_without_rendering()
        figure.set_layout_engine(None)
        for kind, metadata in _METADATA.items():
            stream = io.BytesIO()
            figure.savefig(stream, format=kind, dpi=_DPI, metadata=metadata)
            content[kind] = stream.getvalue()
    return content
