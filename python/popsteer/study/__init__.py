"""Studies: many runs, set side by side."""

from popsteer.study.carrot import carrot_offset, driven_offset
from popsteer.study.compare import DEFAULT_LAWS, Comparison, compare, law_names, parameters
from popsteer.study.dead_time import DEAD_TIME, DEAD_TIME_LAWS, DeadTimeRow, dead_times
from popsteer.study.edges import EDGE_LAWS, EdgeRun, EdgeTrack, edge_tracks, edges
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

__all__ = [
    "DEAD_TIME",
    "DEAD_TIME_LAWS",
    "DEFAULT_LAWS",
    "EDGE_LAWS",
    "LINEAR_LAWS",
    "PAPER",
    "Comparison",
    "DeadTimeRow",
    "EdgeRun",
    "EdgeTrack",
    "Margins",
    "Matrix",
    "PaperFigures",
    "Stability",
    "carrot_offset",
    "compare",
    "dead_time_map",
    "dead_times",
    "driven_offset",
    "edge_tracks",
    "edges",
    "is_authors_path",
    "law_names",
    "margins",
    "matrix",
    "parameters",
    "preview_offset",
    "stability",
    "time_steps",
]
