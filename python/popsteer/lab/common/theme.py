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
    def settings(self) -> Any:
        """Settings of matplotlib that go with the theme, for ``matplotlib.rc_context``."""
        coloured = {
            self.background: ("axes.facecolor", "figure.facecolor", "savefig.facecolor"),
            self.text: ("axes.labelcolor", "axes.titlecolor", "legend.labelcolor", "text.color"),
            self.faint: ("xtick.labelcolor", "ytick.labelcolor"),
            self.grid: ("axes.edgecolor", "grid.color", "xtick.color", "ytick.color"),
        }
        return {
            **{name: colour for colour, names in coloured.items() for name in names},
            **dict.fromkeys(("axes.labelsize", "font.size"), 9.5),
            **dict.fromkeys(("axes.spines.right", "axes.spines.top", "legend.frameon"), False),
            "axes.grid": True,
            "axes.titlesize": 12.0,
            "axes.titleweight": "bold",
            "axes.unicode_minus": True,
            "font.family": "DejaVu Sans",  # comes with matplotlib: the same picture everywhere
            "grid.linewidth": 0.6,
            "lines.solid_joinstyle": "round",
            "svg.hashsalt": "popsteer",  # the same figure is the same file
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
# Of each field of the themes what it is on light and on dark.
_COLOURS: dict[str, tuple[Any, ...]] = {
    "background": ("#ffffff", "#0d1117"),
    "text": ("#1f2328", "#e6edf3"),
    "faint": ("#59636e", "#9aa4af"),
    "grid": ("#dfe3e8", "#2b323b"),
    "path": ("#c3c9d1", "#4c5661"),
    "laws": tuple({name: each[k] for name, each in _LAW_COLOURS.items()} for k in (0, 1)),
    "others": (
        ("#332288", "#117733", "#882255", "#44aa99"),
        ("#b7a8ff", "#88ccee", "#ff9da7", "#ddcc77"),
    ),
    "speed": ("#8a6d00", "#f0e442"),
}

THEMES: Mapping[str, Theme] = MappingProxyType(
    {
        name: Theme(**{field: each[k] for field, each in _COLOURS.items()})
        for k, name in enumerate(("light", "dark"))
    }
)
"""The themes by name."""
