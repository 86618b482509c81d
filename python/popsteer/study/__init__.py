"""Studies: many runs, set side by side."""

from popsteer.study.compare import DEFAULT_LAWS, Comparison, compare
from popsteer.study.linear import Vehicle
from popsteer.study.paper import PAPER, PaperFigures, is_authors_path
from popsteer.study.stability import LINEAR_LAWS, Margins, Stability, margins, stability

__all__ = [
    "DEFAULT_LAWS",
    "LINEAR_LAWS",
    "PAPER",
    "Comparison",
    "Margins",
    "PaperFigures",
    "Stability",
    "Vehicle",
    "compare",
    "is_authors_path",
    "margins",
    "stability",
]
