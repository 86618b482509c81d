"""Studies: many runs, set side by side."""

from popsteer.study.compare import DEFAULT_LAWS, Comparison, compare, law_names, parameters
from popsteer.study.matrix import Matrix, matrix
from popsteer.study.paper import PAPER, PaperFigures, is_authors_path
from popsteer.study.step_time import time_steps

__all__ = [
    "DEFAULT_LAWS",
    "PAPER",
    "Comparison",
    "Matrix",
    "PaperFigures",
    "compare",
    "is_authors_path",
    "law_names",
    "matrix",
    "parameters",
    "time_steps",
]
