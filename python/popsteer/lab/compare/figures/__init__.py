"""Figures of a comparison, drawn without a screen and without pyplot's global state."""

from popsteer.lab.common.theme import THEMES
from popsteer.lab.compare.figures.rendering import FIGURES, render

__all__ = ["FIGURES", "THEMES", "render"]
