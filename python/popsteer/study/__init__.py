"""Studies: many runs, set side by side."""

from popsteer.study.compare import DEFAULT_LAWS, Comparison, compare
from popsteer.study.paper import PAPER, PaperFigures, is_authors_path

__all__ = [
    "DEFAULT_LAWS",
    "PAPER",
    "Comparison",
    "PaperFigures",
    "compare",
    "is_authors_path",
]
