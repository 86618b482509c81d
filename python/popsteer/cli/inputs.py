"""What the commands are given, as the library takes it."""

from __future__ import annotations

import os
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, NamedTuple

from popsteer import tracks
from popsteer._core import Path
from popsteer.errors import ConfigError
from popsteer.sim import default_start

if TYPE_CHECKING:
    from popsteer.sim.run import Pose

__all__ = ["DEFAULT_TRACK", "Course", "course", "names", "start"]

DEFAULT_TRACK = "racetrack"
"""The track that is driven unless told otherwise."""


class Course(NamedTuple):
    """A path, and what to call it."""

    path: Path
    name: str


def course(waypoints: FilePath | None, track: str | None, *, closed: bool) -> Course:
    """Give the path that the options ask for.

    Parameters
    ----------
    waypoints : pathlib.Path, optional
        A file of waypoints.
    track : str, optional
        Name of a shipped track; `DEFAULT_TRACK` where neither is given.
    closed : bool
        Whether the last waypoint of the file joins its first.

    Returns
    -------
    Course
        The path and its name.

    Raises
    ------
    ConfigError
        No track has this name, or the options exclude each other.
    PathError
        The file makes no path.

    Examples
    --------
    >>> course(None, "circle", closed=False).name
    'circle'
    """
    if waypoints is not None:
        if track is not None:
            raise ConfigError("--track", track, "left out where --waypoints is given")
        return Course(Path.from_csv(os.fspath(waypoints), closed=closed), waypoints.name)
    if closed:
        raise ConfigError("--closed", closed, "given with --waypoints; a track knows by itself")
    shipped = tracks.get(DEFAULT_TRACK if track is None else track)
    return Course(Path(shipped.xy, speed=shipped.speed, closed=shipped.closed), shipped.name)


def names(text: str) -> list[str]:
    """Split a list of names at its commas.

    Parameters
    ----------
    text : str
        The list; it may be empty here and there.

    Returns
    -------
    list of str
        The names, each once, in the order given.

    Raises
    ------
    ConfigError
        There is none.

    Examples
    --------
    >>> names("pid, pop,,pid")
    ['pid', 'pop']
    """
    found = list(dict.fromkeys(name for name in map(str.strip, text.split(",")) if name))
    if not found:
        raise ConfigError("--controllers", text, "names of laws, separated by commas")
    return found


def start(path: Path, text: str | None, offset: float | None) -> Pose | None:
    """Give the pose that the options ask for.

    Parameters
    ----------
    path : Path
        What is followed.
    text : str or None
        ``X,Y,YAW`` [m, m, rad].
    offset : float or None
        How far to the left of the first waypoint [m], as `popsteer.sim.default_start` has it.

    Returns
    -------
    tuple of float or None
        The three numbers; None where neither is given.

    Raises
    ------
    ConfigError
        They are not three numbers, the offset is out of its range, or both are given.

    Examples
    --------
    >>> start(Path([(0.0, 0.0), (9.0, 0.0)]), "-183.8,78.7,-1.574", None)
    (-183.8, 78.7, -1.574)
    >>> start(Path([(0.0, 0.0), (9.0, 0.0)]), None, 1.0)
    (0.0, 1.0, 0.0)
    """
    if text is None:
        return None if offset is None else default_start(path, offset)
    if offset is not None:
        raise ConfigError("--start-offset", offset, "left out where --start is given")
    try:
        x, y, yaw = (float(part) for part in text.split(","))
    except ValueError:
        raise ConfigError("--start", text, "three numbers X,Y,YAW [m, m, rad]") from None
    return x, y, yaw
