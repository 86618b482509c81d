"""From a figure to the bytes of its files."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import matplotlib as mpl

from popsteer.errors import ConfigError
from popsteer.report.figures.overview import overview_figure
from popsteer.report.figures.results import results_figure
from popsteer.report.figures.theme import THEMES

if TYPE_CHECKING:
    from popsteer.study import Comparison

__all__ = ["FIGURES", "render"]

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
    colours = THEMES[theme]
    content = {}
    with mpl.rc_context(colours.settings):
        drawn = FIGURES[figure](comparison, colours)
        # The layout takes longer than the drawing; once found, it serves both kinds of file.
        drawn.draw_without_rendering()
        drawn.set_layout_engine(None)
        for kind, metadata in _METADATA.items():
            stream = io.BytesIO()
            drawn.savefig(stream, format=kind, dpi=_DPI, metadata=metadata)
            content[kind] = stream.getvalue()
    return content
