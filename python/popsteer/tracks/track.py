"""A track: waypoints with reference speeds, and a name to call it by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.errors import PathError
from popsteer.files import write_text_atomic

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Track:
    """A track to drive.

    Parameters
    ----------
    name : str
        Name, as `popsteer.tracks.get` takes it.
    title : str
        One line that says what it is.
    description : str
        What it is made of and good for, in a few sentences.
    xy : (N, 2) array_like of float
        The waypoints [m], N >= 2, in driving order.
    speed : (N,) array_like of float
        The reference speed at each waypoint [m/s].
    closed : bool
        Whether the last waypoint joins the first; the first is not repeated at the end.

    Raises
    ------
    PathError
        The arrays have other shapes or hold a number that is not finite.

    Notes
    -----
    `xy` and `speed` are kept as read-only copies. Tracks compare by identity.

    Examples
    --------
    >>> track = Track("pair", "Two points", "", [[0, 0], [3, 4]], [1, 2], closed=False)
    >>> track.length
    5.0
    """

    name: str
    title: str
    description: str
    xy: NDArray[np.float64]
    speed: NDArray[np.float64]
    closed: bool

    def __post_init__(self) -> None:
        xy = np.array(self.xy, dtype=np.float64, order="C")
        speed = np.array(self.speed, dtype=np.float64)
        if xy.ndim != 2 or xy.shape[0] < 2 or xy.shape[1] != 2:
            raise PathError(f"xy must have shape (N, 2) with N >= 2, got {xy.shape}")
        if speed.shape != xy.shape[:1]:
            raise PathError(f"speed must have shape {xy.shape[:1]}, got {speed.shape}")
        broken = np.flatnonzero(~(np.isfinite(xy).all(axis=1) & np.isfinite(speed)))
        if broken.size:
            raise PathError(f"waypoint {broken[0]} is not finite", int(broken[0]))
        for field, array in (("xy", xy), ("speed", speed)):
            array.flags.writeable = False
            object.__setattr__(self, field, array)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, since numpy does not keep "read-only" in a pickle.
        fields = (self.name, self.title, self.description, self.xy, self.speed, self.closed)
        return Track, fields

    @property
    def length(self) -> float:
        """Length along the waypoints [m], with the joining segment if the track is closed."""
        end = self.xy[:1] if self.closed else self.xy[:0]
        steps = np.diff(np.concatenate((self.xy, end)), axis=0)
        return float(np.sqrt((steps * steps).sum(axis=1)).sum())

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        r"""Write the track as a CSV file, whole or not at all.

        The columns are x [m], y [m] and speed [m/s], under a head of ``#`` comments. Numbers are
        written so that `popsteer.Path.from_csv` returns the same bits.

        Parameters
        ----------
        path : str or os.PathLike
            The file to write; folders that are missing are made.

        Raises
        ------
        OSError
            The file cannot be written; what stood there before still does.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> from popsteer import tracks
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder) / "straight.csv"
        ...     tracks.get("straight").to_csv(file)
        ...     print("\n".join(file.read_text(encoding="utf-8").splitlines()[:4]))
        # straight: Straight line, 200 m
        # open path, 201 waypoints
        # x [m], y [m], speed [m/s]
        0.0,0.0,1.5
        """
        kind = "closed path, the last waypoint joins the first" if self.closed else "open path"
        head = (f"{self.name}: {self.title}", f"{kind}, {len(self.xy)} waypoints")
        lines = [f"# {' '.join(line.split())}" for line in head]  # a line break would end it
        lines.append("# x [m], y [m], speed [m/s]")
        table = np.column_stack((self.xy, self.speed)).tolist()
        lines += [f"{x!r},{y!r},{speed!r}" for x, y, speed in table]
        write_text_atomic(path, "\n".join(lines) + "\n")
