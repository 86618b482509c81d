"""Studies: many runs, set side by side."""

from popsteer.study.carrot import carrot_offset, driven_offset
from popsteer.study.compare import DEFAULT_LAWS, Comparison, compare, law_names, parameters
from popsteer.study.matrix import Matrix, matrix
from popsteer.study.paper import PAPER, PaperFigures, is_authors_path
from popsteer.study.preview_bend import preview_offset
from popsteer.study.stability import (
    LINEAR_LAWS,
    Margins,
    Stability,
    dead_time_map,
    margins,
    stability,
)
from popsteer.study.step_time import time_steps
from popsteer.study.vehicle import Vehicle

__all__ = [
    "DEFAULT_LAWS",
    "LINEAR_LAWS",
    "PAPER",
    "Comparison",
    "Margins",
    "Matrix",
    "PaperFigures",
    "Stability",
    "Vehicle",
    "carrot_offset",
    "compare",
    "dead_time_map",
    "driven_offset",
    "is_authors_path",
    "law_names",
    "margins",
    "matrix",
    "parameters",
    "preview_offset",
    "stability",
    "time_steps",
]
