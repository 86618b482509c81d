"""The result of planning the speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer._core import Path, Vehicle, _with_speed
from popsteer.files import write_text_atomic

if TYPE_CHECKING:
    import os

    from numpy.typing import NDArray

    from popsteer.planning.limits import SpeedLimits

LIMITS = (
    "top speed",
    "speed limit",
    "lateral",
    "steer angle",
    "steer rate",
    "stop",
    "driving",
    "braking",
    "jerk",
)
"""What limits the speed at a waypoint, by its number in `SpeedProfile.limit`."""


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speeds along a path, and what limits them.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> profile = popsteer.planning.speed_profile(path)
    >>> profile.path.speed is not None, profile.limit.shape
    (True, (101,))
    >>> {name: round(share, 2) for name, share in profile.shares().items()}
    {'driving': 0.6, 'braking': 0.39, 'stop': 0.01}
    """

    path: Path
    """The path with the speeds, negative where it is driven backwards."""
    speed: NDArray[np.float64]
    """Speed at each waypoint [m/s], shape (N,), never negative."""
    acceleration: NDArray[np.float64]
    """Acceleration along each segment [m/s²], shape (N - 1,) of an open path, (N,) of a closed."""
    curvature: NDArray[np.float64]
    """Curvature at each waypoint [1/m], shape (N,)."""
    limit: NDArray[np.uint8]
    """What limits the speed at each waypoint, as an index of `LIMITS`, shape (N,)."""
    limits: SpeedLimits
    """The limits, all filled in."""
    vehicle: Vehicle
    """What drives."""

    @classmethod
    def of(cls, path: Path, speed: NDArray[np.float64], *others: Any) -> SpeedProfile:  # noqa: ANN401
        """Put the speeds to a path; the others are the attributes that follow `acceleration`."""
        reverse = path.reverse
        signed = speed if reverse is None else np.where(reverse, -speed, speed)
        if reverse is not None and not path.closed:
            signed[-1] = -speed[-1] if reverse[-2] else speed[-1]
        # In place: a long path has no room for more copies.
        acceleration = np.square(speed)
        after = acceleration[:1] if path.closed else ()
        acceleration = np.diff(acceleration, append=after)
        acceleration *= 0.5
        acceleration /= spacing_of(path)
        return cls(_with_speed(path, signed), speed, acceleration, *others)

    @property
    def time(self) -> float:
        """Time that the path takes [s], of a closed one a lap."""
        time = np.roll(self.speed, -1)
        time += self.speed
        spacing = spacing_of(self.path)
        time = np.divide(spacing, time[: spacing.size], out=spacing)
        return 2.0 * float(time.sum())

    def shares(self) -> dict[str, float]:
        """Tell what limits the speed along which share of the length.

        Returns
        -------
        dict of str to float
            The limits that bind, the largest share first; together 1.
        """
        spacing = spacing_of(self.path)
        weight = np.zeros(len(self.path))
        segments = np.arange(spacing.size)
        np.add.at(weight, segments, 0.5 * spacing)
        np.add.at(weight, (segments + 1) % len(self.path), 0.5 * spacing)
        found = np.bincount(self.limit, weight, len(LIMITS)) / spacing.sum()
        order = np.argsort(-found, kind="stable")
        return {LIMITS[index]: float(found[index]) for index in order if found[index] > 0.0}

    @property
    def too_sharp(self) -> NDArray[np.intp]:
        """The waypoints where the path bends more sharply than the wheels turn.

        Returns
        -------
        (M,) ndarray
            Their indices; the vehicle leaves the path there at any speed.
        """
        most = math.tan(self.vehicle.max_steer) / self.vehicle.turning_length(0.0)
        return np.flatnonzero(np.abs(self.curvature) > most)

    def as_csv(self) -> str:
        """Word the course as the text of a CSV file.

        Returns
        -------
        str
            Rows of x [m], y [m] and speed [m/s], negative where the path is driven backwards, as
            `Path.from_csv` reads them.
        """
        kind = "closed" if self.path.closed else "open"
        lines = [
            f"# {kind} path, {len(self.path)} waypoints, planned time {self.time:.2f} s",
            "# x [m], y [m], speed [m/s]",
        ]
        speed = self.path.speed
        table = np.column_stack((self.path.x, self.path.y, self.speed if speed is None else speed))
        lines += [f"{x!r},{y!r},{speed!r}" for x, y, speed in (table + 0.0).tolist()]
        return "\n".join(lines) + "\n"

    def to_csv(self, file: str | os.PathLike[str]) -> None:
        r"""Write the course as a CSV file, whole or not at all.

        The text is that of `as_csv`.

        Parameters
        ----------
        file : str or os.PathLike
            The file to write; folders that are missing are made.

        Raises
        ------
        OSError
            The file cannot be written; what stood there before still does.

        Examples
        --------
        >>> import pathlib, tempfile, popsteer
        >>> path = popsteer.Path([(0.0, 0.0), (8.0, 0.0), (16.0, 0.0)])
        >>> profile = popsteer.planning.speed_profile(path)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder) / "course.csv"
        ...     profile.to_csv(file)
        ...     print(file.read_text(encoding="utf-8").splitlines()[-2])
        8.0,0.0,5.656854249492381
        """
        write_text_atomic(file, self.as_csv())


def spacing_of(path: Path) -> NDArray[np.float64]:
    """Give the length of each segment [m]."""
    return np.diff(np.append(path.s, path.length) if path.closed else path.s)
