"""The paper's experiment: what it reports, and the run to be put beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from popsteer import presets, tracks
from popsteer._core import CarlaIdentified, CoupledLongitudinal, Path
from popsteer.lab.compare import runs
from popsteer.lab.compare.comparison import Comparison
from popsteer.sim.closed_loop import START_OFFSET, default_start


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


START = (-183.8, 78.7, -1.574)
"""Where the front axle starts on the authors' path [m, m, rad]."""


def run(
    path: Path | None = None,
    preset: str = presets.REPRODUCTION,
    progress: Callable[[str, float], object] | None = None,
) -> Comparison:
    """Drive the paper's experiment: its controllers, tuning and pedals, on the identified plant.

    Parameters
    ----------
    path : Path, optional
        What is followed: the embedded race track by default. On the authors' own path the start is
        theirs, on others as far to the right of the path.
    preset : str, default "reproduction"
        Which reading of the paper tunes the controllers; see `popsteer.presets`.
    progress : callable, optional
        As `popsteer.lab.compare.run` has it.

    Returns
    -------
    Comparison
        The runs.

    Raises
    ------
    ConfigError
        The preset is not known.

    Examples
    --------
    >>> path = Path([(float(x), 0.0) for x in range(81)])
    >>> run(path).tuning["pop"]
    'reproduction'
    """
    if path is None:
        path = Path(tracks.get("racetrack").xy)
    plant = CarlaIdentified()
    there: dict[str, Any] = {"start": default_start(path, -START_OFFSET, plant.vehicle)}
    if is_authors_path(path):
        there = {"start": START, "start_at": "front"}
    pedals = CoupledLongitudinal()
    return runs.run(
        path, plant=plant, preset=preset, longitudinal=pedals, progress=progress, **there
    )
