"""What comes in: messages are converted, or refused and counted with the reason."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer import Path, PathError
from popsteer.adapters.ros2.conversions import Measured, MessageError, measured_of, path_of_bytes
from popsteer.adapters.ros2.messages import ODOMETRY, decode

if TYPE_CHECKING:
    from collections.abc import Callable

AHEAD = 0.05
"""How far a stamp may lie in the future before the clocks count as apart [s]."""


@dataclass
class Counted:
    """How many messages a topic has brought."""

    received: int = 0
    refused: int = 0
    """Those that could not be used."""
    reason: str = ""
    """Why the last of those could not."""
    lately: int = 0
    """How many could not since the last diagnostics."""

    def refuse(self, error: Exception) -> str:
        """Count a message that cannot be used; gives the reason."""
        self.refused += 1
        self.lately += 1
        self.reason = str(error)
        return self.reason


@dataclass(frozen=True, eq=False)
class Course:
    """A path that was received, with what has to be known about it."""

    path: Path
    frame: str
    stands: str
    """Why the vehicle is to stand on it; empty where it is to drive."""


class Intake:
    """The last message of each kind that can be used.

    Parameters
    ----------
    course_type : str
        The type of the path's messages.
    stale : float
        Odometry older than this is refused [s].
    closed : bool, default False
        Whether the last point of a path joins its first.

    Attributes
    ----------
    odometry, courses : Counted
        How many messages of each came in, how many were refused, and why the last one was.
    measured : Measured or None
        The last pose and speed that can be used.
    measured_at : float
        When they were measured, on the node's clock [s].
    course : Course or None
        The last path that can be used.
    course_number : int
        How many paths could be used.
    odometry_refused, course_refused : str
        Why the last message could not be used; empty where it could.
    course_refused_at : float
        Since when paths have been refused, on the node's clock [s].

    Examples
    --------
    >>> from popsteer.adapters.ros2 import conversions, messages
    >>> intake = Intake(messages.PATH, stale=0.3)
    >>> message = conversions.odometry_message(1.0, 2.0, 0.0, 5.0, 8_000_000_000, "map")
    >>> intake.take_odometry(messages.encode(message), 8.01)
    True
    >>> intake.measured.speed, intake.measured_at
    (5.0, 8.0)
    >>> intake.take_odometry(messages.encode(message), 9.0), intake.odometry.reason
    (False, 'stamp is 1.00 s old')
    """

    def __init__(self, course_type: str, stale: float, *, closed: bool = False) -> None:
        self.odometry = Counted()
        self.courses = Counted()
        self.measured: Measured | None = None
        self.measured_at = 0.0
        self.course: Course | None = None
        self.course_number = 0
        self.odometry_refused = self.course_refused = ""
        self.course_refused_at = 0.0
        self.stale = stale
        # Gives a measurement in another frame, or raises MessageError; None where nothing does.
        self.transform: Callable[[Measured, str], Measured] | None = None
        self._course_type = course_type
        self._closed = closed

    def take_odometry(self, data: bytes, now: float) -> bool:
        """Take the bytes of an odometry message at `now` [s]; says whether they can be used.

        If not, the message is counted with its reason.
        """
        self.odometry.received += 1
        try:
            measured = measured_of(_used(decode, ODOMETRY, data))
            at = 1e-9 * measured.stamp if measured.stamp else now
            self._check_time(at, now)
            wanted = measured.frame if self.course is None else self.course.frame
            if self.transform is not None:
                measured = self.transform(measured, wanted)
            if self.course is not None:
                _check_frame(measured.frame, "path", self.course.frame)
        except MessageError as error:
            self.odometry_refused = self.odometry.refuse(error)
            return False
        self.measured, self.measured_at = measured, min(at, now)
        self.odometry_refused = ""
        return True

    def take_course(self, data: bytes, now: float) -> bool:
        """Take the bytes of a path or of a trajectory at `now` [s]; says whether they can be used.

        If not, the message is counted with its reason, and the present path stays.
        """
        self.courses.received += 1
        try:
            path, frame = _used(path_of_bytes, self._course_type, data, closed=self._closed)
            # Odometry that is stale says nothing: both may have gone over to another frame.
            here = self.measured if now - self.measured_at <= self.stale else None
            if here is not None and self.transform is not None:
                self.transform(here, frame)
            elif here is not None:
                _check_frame(frame, "odometry", here.frame)
        except MessageError as error:
            if not self.course_refused:
                self.course_refused_at = now
            self.course_refused = self.courses.refuse(error)
            return False
        self.use(path, frame)
        return True

    def use(self, path: Path, frame: str) -> None:
        """Take a path that came by another way than a message."""
        stands = path.speed is not None and not path.speed.any()
        self.course = Course(path, frame, "the path's speeds are 0" if stands else "")
        self.course_number += 1
        self.course_refused = ""

    def stand(self, why: str) -> None:
        """Stand on the present path until another one comes."""
        if self.course is not None:
            self.course = replace(self.course, stands=why)

    def forget_odometry(self) -> None:
        """Wait for odometry of the clock as it is now, after that has jumped."""
        self.measured = None

    def _check_time(self, at: float, now: float) -> None:
        if at > now + AHEAD:
            raise MessageError(f"stamp is {at - now:.2f} s in the future")
        if now - at > self.stale:
            raise MessageError(f"stamp is {now - at:.2f} s old")
        if self.measured is not None and at < self.measured_at:
            raise MessageError(f"stamp is {self.measured_at - at:.3f} s before the last one")


def load_path(file: str, *, closed: bool) -> Path:
    """Read a path with speeds: popsteer's CSV, or a raceline whose columns are s; x; y; ...; vx."""
    lines = FilePath(file).read_text(encoding="utf-8").splitlines()
    text = [line for line in lines if line.strip() and not line.startswith("#")]
    if not text or ";" not in text[0]:
        return Path.from_csv(file, closed=closed)
    try:
        rows = np.loadtxt(text, delimiter=";", usecols=(1, 2, 5), ndmin=2)
    except ValueError as error:
        raise PathError(f"{file}: no raceline s; x; y; psi; kappa; vx; ax: {error}") from error
    return Path(rows[:, :2], speed=rows[:, 2], closed=closed, drop_duplicates=True)


def _check_frame(frame: str, other: str, wanted: str) -> None:
    if frame != wanted:
        raise MessageError(f"frame is {frame!r}, that of the {other} is {wanted!r}")


def _used(convert: Callable[..., Any], name: str, data: bytes, **options: bool) -> Any:  # noqa: ANN401
    """Convert a message; what rosbags stumbles over becomes one kind of error."""
    try:
        return convert(name, data, **options)
    except MessageError:
        raise
    except Exception as error:  # cut or altered bytes may break it anywhere
        raise MessageError(f"is no {name}: {type(error).__name__}") from error
