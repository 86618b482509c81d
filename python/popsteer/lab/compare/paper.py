"""What the paper reports, to be put beside what is measured."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer._core import Path


class PaperFigures(NamedTuple):
    """One row of the paper's table of tracking metrics."""

    mean_abs_cross_track_error: float
    """Mean of the absolute cross-track error [m]."""
    mean_abs_heading_error: float
    """Mean of the absolute heading error [rad]."""


PAPER: Mapping[str, PaperFigures] = MappingProxyType(
    {
        "pid": PaperFigures(0.4958, 0.0121),
        "pure-pursuit": PaperFigures(0.3662, 0.0219),
        "stanley": PaperFigures(0.3383, 0.0141),
        "pop": PaperFigures(0.1761, 0.0079),
    }
)
"""The paper's table by controller: CARLA's race track, the authors' vehicle, steps of 50 ms."""

# Of the waypoints that the authors published with their code.
_WAYPOINTS = 1724
_LENGTH = 1755.724
_FIRST = (-181.3353, 80.5399)


def is_authors_path(path: Path) -> bool:
    """Whether the paper's figures were measured on a path: number, length and first waypoint."""
    return (
        len(path) == _WAYPOINTS
        and not path.closed
        and abs(path.length - _LENGTH) < 0.01
        and abs(float(path.x[0]) - _FIRST[0]) < 0.001
        and abs(float(path.y[0]) - _FIRST[1]) < 0.001
    )
