"""Colours and letters of the figures, on a light and on a dark background."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import cycle
from types import MappingProxyType
from typing import Any, NamedTuple


class Theme(NamedTuple):
    """Colours on one background."""

    background: str
    text: str
    faint: str
    """Ticks, notes and frames."""
    grid: str
    path: str
    laws: Mapping[str, str]
    """Colour of each controller of popsteer and of each baseline."""
    others: tuple[str, ...]
    """Colours for controllers of one's own, in turn."""
    speed: str
    """A limit of the speed itself."""

    def colour(self, role: str) -> str:
        """Give the colour of a controller, or of a field of the theme."""
        return self.laws[role] if role in self.laws else str(getattr(self, role))

    def colours(self, names: Iterable[str]) -> dict[str, str]:
        """Give each controller a colour."""
        others = cycle(self.others)
        return {name: self.laws[name] if name in self.laws else next(others) for name in names}

    def styles(self, names: Iterable[str]) -> dict[str, Any]:
        """Give each controller a style of its line, so that not its colour alone tells it."""
        known = dict(zip(self.laws, _DASHES, strict=True))
        others = cycle(_DASHES)
        return {name: known[name] if name in known else next(others) for name in names}

    @property
    def settings(self) -> Any:  # noqa: ANN401 - matplotlib lists the keys, which change with it
        """Settings of matplotlib that go with the theme, for ``matplotlib.rc_context``."""
        return {
            "axes.edgecolor": self.grid,
            "axes.facecolor": self.background,
            "axes.grid": True,
            "axes.labelcolor": self.text,
            "axes.labelsize": 9.5,
            "axes.spines.right": False,
            "axes.spines.top": False,
            "axes.titlecolor": self.text,
            "axes.titlesize": 12.0,
            "axes.titleweight": "bold",
            "axes.unicode_minus": True,
            "figure.facecolor": self.background,
            "font.family": "DejaVu Sans",  # comes with matplotlib: the same picture everywhere
            "font.size": 9.5,
            "grid.color": self.grid,
            "grid.linewidth": 0.6,
            "legend.frameon": False,
            "legend.labelcolor": self.text,
            "lines.solid_joinstyle": "round",
            "savefig.facecolor": self.background,
            "svg.hashsalt": "popsteer",  # the same figure is the same file
            "text.color": self.text,
            "xtick.color": self.grid,
            "xtick.labelcolor": self.faint,
            "ytick.color": self.grid,
            "ytick.labelcolor": self.faint,
        }


# The colours of Okabe and Ito, which colour-blind readers can tell apart; on the dark background
# the blue and the green are lighter, so that they stand out as far as the others.
_LAW_COLOURS = {
    "pid": ("#d55e00", "#ff8c42"),
    "pure-pursuit": ("#009e73", "#2fd0a0"),
    "stanley": ("#b5589a", "#e79ccb"),
    "pop": ("#0072b2", "#56b4e9"),
    "preview-pop": ("#111111", "#ffffff"),
    "mpc": ("#5b21e6", "#8163ff"),
}
# Dashes in the order of these, as matplotlib takes them.
_DASHES: tuple[Any, ...] = (
    *("--", "-.", (0, (1.0, 1.2)), "-"),
    *((0, (7.0, 1.5)), (0, (4.0, 1.0, 1.0, 1.0, 1.0, 1.0))),
)
_LIGHT, _DARK = ({name: each[k] for name, each in _LAW_COLOURS.items()} for k in (0, 1))

THEMES: Mapping[str, Theme] = MappingProxyType(
    {
        "light": Theme(
            background="#ffffff",
            text="#1f2328",
            faint="#59636e",
            grid="#dfe3e8",
            path="#c3c9d1",
            laws=_LIGHT,
            others=("#332288", "#117733", "#882255", "#44aa99"),
            speed="#8a6d00",
        ),
        "dark": Theme(
            background="#0d1117",
            text="#e6edf3",
            faint="#9aa4af",
            grid="#2b323b",
            path="#4c5661",
            laws=_DARK,
            others=("#b7a8ff", "#88ccee", "#ff9da7", "#ddcc77"),
            speed="#f0e442",
        ),
    }
)
"""The themes by name."""
