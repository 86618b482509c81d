"""From a figure to the bytes of its files, without a screen and without pyplot's global state."""

from __future__ import annotations

import io
import textwrap
from typing import TYPE_CHECKING

import matplotlib as mpl

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from popsteer.lab.common.theme import Theme

__all__ = ["drawn", "wrapped"]

_DPI = 150
_EM = 0.55  # mean width of a character, of the height of the font
# Without the date, so that the same figure is the same file.
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


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
    >>> from popsteer.lab.common.theme import THEMES
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


def wrapped(text: str, figure: Figure, size: float) -> str:
    """Break a line that is wider than a figure.

    Parameters
    ----------
    text : str
        The line.
    figure : matplotlib.figure.Figure
        Where it stands.
    size : float
        Size of the font [pt].

    Returns
    -------
    str
        As many lines as it takes.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> print(wrapped("one two three", Figure(figsize=(1, 1)), 12.0))
    one two
    three
    """
    return textwrap.fill(text, int(figure.get_figwidth() * 72.0 / (_EM * size)))
