"""Figures of a comparison, drawn without a screen and without pyplot's global state."""

from popsteer.report.figures.render import FIGURES, render
from popsteer.report.figures.theme import THEMES

__all__ = ["FIGURES", "THEMES", "render"]
