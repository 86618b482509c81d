"""What comes in: messages are converted, or refused and counted with the reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.adapters.ros2.conversions import Measured, MessageError, measured_of, path_of
from popsteer.adapters.ros2.messages import ODOMETRY, decode

if TYPE_CHECKING:
    from popsteer import Path

__all__ = ["AHEAD", "Counted", "Course", "Intake"]

AHEAD = 0.05
"""How far a stamp may lie in the future before the clocks count as apart [s]."""


@dataclass
class Counted:
    """How many messages a topic has brought."""

    received: int = 0
    """All of them."""
    refused: int = 0
    """Those that could not be used."""
    reason: str = ""
    """Why the last of those could not."""


@dataclass(frozen=True, eq=False)
class Course:
    """A path that was received, with what has to be known about it."""

    path: Path
    frame: str
    stands: bool
    """Whether all of its speeds are 0: a planner's word that the vehicle is to stand."""


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
        self._course_type = course_type
        self._stale = stale
        self._closed = closed
        self._last: tuple[bytes, int] = b"", 0

    def take_odometry(self, data: bytes, now: float) -> bool:
        """Take the bytes of an odometry message.

        Parameters
        ----------
        data : bytes
            The message.
        now : float
            The time of the node's clock [s].

        Returns
        -------
        bool
            Whether it can be used; if not, it is counted with its reason.
        """
        self.odometry.received += 1
        try:
            measured = measured_of(_decoded(ODOMETRY, data))
            at = 1e-9 * measured.stamp if measured.stamp else now
            self._check_time(at, now)
            if self.course is not None:
                _check_frame(measured.frame, "path", self.course.frame)
        except MessageError as error:
            self.odometry.refused += 1
            self.odometry.reason = self.odometry_refused = str(error)
            return False
        self.measured, self.measured_at = measured, min(at, now)
        self.odometry_refused = ""
        return True

    def is_repeated(self, data: bytes, reader: int) -> bool:
        """Say whether a path has come already, by another reader.

        Parameters
        ----------
        data : bytes
            The message.
        reader : int
            Which reader it comes by: a publisher that keeps its messages is heard by two.

        Returns
        -------
        bool
            Whether it has.
        """
        if data == self._last[0] and reader != self._last[1]:
            return True
        self._last = data, reader
        return False

    def take_course(self, data: bytes, now: float) -> bool:
        """Take the bytes of a path or of a trajectory.

        Parameters
        ----------
        data : bytes
            The message.
        now : float
            The time of the node's clock [s].

        Returns
        -------
        bool
            Whether it can be used; if not, it is counted with its reason, and the present path
            stays.
        """
        self.courses.received += 1
        try:
            path, frame = path_of(_decoded(self._course_type, data), closed=self._closed)
            # Odometry that is stale says nothing: both may have gone over to another frame.
            here = self.measured if now - self.measured_at <= self._stale else None
            if here is not None:
                _check_frame(frame, "odometry", here.frame)
        except MessageError as error:
            self.courses.refused += 1
            self.courses.reason = self.course_refused = str(error)
            return False
        stands = path.speed is not None and not path.speed.any()
        self.course = Course(path, frame, stands)
        self.course_number += 1
        self.course_refused = ""
        return True

    def forget_odometry(self) -> None:
        """Wait for odometry of the clock as it is now, after that has jumped."""
        self.measured = None

    def _check_time(self, at: float, now: float) -> None:
        if at > now + AHEAD:
            raise MessageError(f"stamp is {at - now:.2f} s in the future")
        if now - at > self._stale:
            raise MessageError(f"stamp is {now - at:.2f} s old")
        if self.measured is not None and at < self.measured_at:
            raise MessageError(f"stamp is {self.measured_at - at:.3f} s before the last one")


def _check_frame(frame: str, other: str, wanted: str) -> None:
    if frame != wanted:
        raise MessageError(f"frame is {frame!r}, that of the {other} is {wanted!r}")


def _decoded(name: str, data: bytes) -> object:
    """Decode a message; what rosbags stumbles over becomes one kind of error."""
    try:
        return decode(name, data)
    except Exception as error:  # cut or altered bytes may break it anywhere
        raise MessageError(f"is no {name}: {type(error).__name__}") from error
