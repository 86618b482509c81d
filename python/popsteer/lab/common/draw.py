"""From a figure to the bytes of its files, without a screen and without pyplot's global state."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from popsteer.lab.common.layout import figure_name
from popsteer.lab.common.theme import THEMES, Theme
from popsteer.sim import Run

_DPI = 150
_MOST_POINTS = 4000  # of a line; more cannot be told apart
_HEAD = 10.0  # pt
_MANY = 300.0  # from end to end of an axis, as a ratio
# Without the date, so that the same figure is the same file.
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


def drawn(draw: Callable[[Theme], Figure], theme: Theme) -> dict[str, bytes]:
    """Draw a figure in a theme, and give the content of its files by kind: ``png`` and ``svg``."""
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


def files_of(
    figures: Mapping[str, Callable[[Theme], Figure]],
    progress: Callable[[str, float], object] | None = None,
) -> dict[str, bytes]:
    """Draw figures into the files that `popsteer.lab.common.layout.figure_names` names."""
    content = {}
    tell = progress or (lambda *_: None)
    wanted = [(stem, draw, name) for stem, draw in figures.items() for name in THEMES]
    for done, (stem, draw, name) in enumerate(wanted):
        tell("figures", done / len(wanted))
        for kind, data in drawn(draw, THEMES[name]).items():
            content[figure_name(stem, name, kind)] = data
    tell("figures", 1.0)
    return content


def plot_broken(
    panel: Axes, x: NDArray[Any], y: NDArray[Any], breaks: Sequence[int], **style: Any
) -> None:
    """Draw a line that breaks before the rows `breaks`, with no more points than can be seen."""
    y = np.array(y, dtype=np.float64)
    y[list(breaks)] = np.nan
    every = max(1, len(x) // _MOST_POINTS)
    panel.plot(x[::every], y[::every], **style)


def headline(figure: Figure, text: str, theme: Theme) -> None:
    """Write a line above a figure, broken where it is wider."""
    figure.suptitle(text, fontsize=_HEAD, color=theme.faint, wrap=True)


class _Decades(LogLocator):
    """Ticks at 1, 2 and 5 of each decade; over many decades at 1 alone, for which there is room."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        self.set_params(subs=(1.0, 2.0, 5.0) if vmax < _MANY * vmin else (1.0,))
        return super().tick_values(vmin, vmax)


def logarithmic(panel: Axes, names: str = "y") -> None:
    """Make axes logarithmic, with plain numbers at ticks that have room."""
    for name in names:
        panel.set(**{f"{name}scale": "log"})
        axis = getattr(panel, f"{name}axis")
        axis.set_major_locator(_Decades())
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def limit(run: Run, record: str) -> float:
    """Bound a record: its largest value after settling, of a run that is over before of all.

    It is 0 for a run that did not finish, which would flatten the others.
    """
    if not run.metrics.finished:
        return 0.0
    values = np.abs(run.records[record])
    settled = values[starting(run) :]
    return float((settled if len(settled) else values).max(initial=0.0))


def starting(run: Run) -> int:
    """Count the rows of a run's records that are before it settles."""
    return int(np.searchsorted(run.records["time"], run.settings.settling_time))


def plot_settling(
    panel: Axes, x: NDArray[Any], y: NDArray[Any], first: int, bound: float, **style: Any
) -> None:
    """Draw a line whose `first` points are faint, and mark its peaks beyond ``-bound, bound``."""
    alpha = style.pop("alpha", 1.0)
    label = style.pop("label", None)
    panel.plot(x[: first + 1], y[: first + 1], alpha=0.35 * alpha, **style)
    panel.plot(x[first:], y[first:], alpha=alpha, label=label, **style)
    beyond = np.flatnonzero(np.abs(y) > bound)
    for part in np.split(beyond, np.flatnonzero(np.diff(beyond) > 1) + 1):
        if len(part):
            peak = part[np.argmax(np.abs(y[part]))]
            up = y[peak] > 0.0
            mark = "^" if up else "v"
            place = [x[peak]], [bound if up else -bound]
            look = {"markersize": 5.0, "color": style["color"], "clip_on": False, "zorder": 5.0}
            panel.plot(*place, mark, **look)


def nice_limit(limits: Iterable[float]) -> float:
    """Round the largest of some bounds up to two digits, with room for a note; 1 if all are 0."""
    largest = 1.35 * max(limits)
    if largest <= 0.0:
        return 1.0
    step = 10.0 ** (math.floor(math.log10(largest)) - 1)
    return round(math.ceil(largest / step) * step, 12)
