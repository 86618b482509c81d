"""What comes in: messages are converted, or refused and counted with the reason."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from popsteer.adapters.ros2.conversions import Measured, MessageError, measured_of
from popsteer.adapters.ros2.messages import ODOMETRY, decode
from popsteer.adapters.ros2.paths import Points, Pose, inverse, placed, points_of_bytes

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Protocol

    class Frames(Protocol):
        """What knows of frames, as tf does."""

        def transform(self, measured: Measured, frame: str) -> Measured:
            """Give what is measured in another frame; MessageError where that is not known."""

        def clear(self) -> None:
            """Forget what was heard, of a time that has begun anew."""

    from popsteer import Path

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
    """In the frame of `Intake.measured`."""
    frame: str
    """What its message is in."""
    stands: str
    """Why the vehicle is to stand on it; empty where it is to drive."""
    anew: bool = False
    """Whether nothing is carried over to it from the path before: not the place, not a fault."""


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
        The last pose and speed that can be used. A path in another frame than the one before does
        not change the frame that they are in: the path is taken into that one, by where the vehicle
        was in both, so that all that is remembered of the drive stays true.
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
    frames : Frames or None
        What knows of frames; without, odometry has to be in the frame of the path.
    seen_from : Pose or None
        The pose of the path's frame in that of `measured`; None where they are the same.
    goals : bool
        Whether goals of an action have the path: those of the topic are refused from the first on.

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
        self.frames: Frames | None = None
        self.seen_from: Pose | None = None
        self.goals = False
        self._raw: Measured | None = None
        self._course_type = course_type
        self._closed = closed

    def take_odometry(self, data: bytes, now: float) -> bool:
        """Take the bytes of an odometry message at `now` [s]; says whether they can be used.

        If not, the message is counted with its reason.
        """
        self.odometry.received += 1
        try:
            raw = measured_of(_used(decode, ODOMETRY, data))
            raw = raw._replace(stamp=raw.stamp or round(1e9 * now))
            at = 1e-9 * raw.stamp
            self._check_time(at, now)
            measured = self._in_frame(raw, raw.frame if self.course is None else self.course.frame)
        except MessageError as error:
            self.odometry_refused = self.odometry.refuse(error)
            return False
        if self.seen_from is not None:
            x, y, yaw = placed(self.seen_from, measured[:3])
            measured = measured._replace(x=x, y=y, yaw=yaw)
        self.measured, self.measured_at, self._raw = measured, min(at, now), raw
        self.odometry_refused = ""
        return True

    def take_course(self, data: bytes, now: float) -> bool:
        """Take the bytes of a path or of a trajectory at `now` [s]; says whether they can be used.

        If not, the message is counted with its reason, and the present path stays.
        """
        self.courses.received += 1
        try:
            if self.goals:
                self.courses.refuse(MessageError("goals of the action have the path"))
                return False
            points = _used(points_of_bytes, self._course_type, data)
        except MessageError as error:
            return self._refuse(error, now)
        return self.take_points(points, now, closed=self._closed)

    def take_points(
        self, points: Points, now: float, *, closed: bool = False, anew: bool = False
    ) -> bool:
        """Take points that came by another way than a message; with `anew` nothing is carried over.

        Says whether they can be used, as `take_course` does.
        """
        seen_from, before = self.seen_from, self.course
        anew = anew or before is None
        try:
            here = self.here(points.frame, now)
            if before is not None and points.frame != before.frame:
                anew = anew or here is None
                if here is not None and self.measured is not None:
                    seen_from = placed(self.measured[:3], inverse(here[:3]))
            seen_from = None if anew else seen_from
            # Without its speeds: on a path of stops a vehicle in mid-drive overruns them all.
            stands = points.speed is not None and not points.speed.any()
            driven = points._replace(speed=None) if stands else points
            path = driven.path(closed=closed, seen_from=seen_from)
        except MessageError as error:
            return self._refuse(error, now)
        if anew:
            self.measured = here
        self.seen_from = seen_from
        self.use(path, points.frame, anew=anew, stands=stands)
        return True

    def here(self, frame: str, now: float) -> Measured | None:
        """Give the last pose and speed in a frame; None where they are stale, at `now` [s].

        Odometry that is stale says nothing: it and the path may have gone over to another frame.
        Raises MessageError where that frame is not known.
        """
        if self._raw is None or now - self.measured_at > self.stale:
            return None
        return self._in_frame(self._raw, frame)

    def _in_frame(self, raw: Measured, frame: str) -> Measured:
        if self.frames is not None:
            return self.frames.transform(raw, frame)
        if raw.frame != frame:
            raise MessageError(f"frame is {raw.frame!r} of the odometry, {frame!r} of the path")
        return raw

    def _refuse(self, error: MessageError, now: float) -> bool:
        if not self.course_refused:
            self.course_refused_at = now
        self.course_refused = self.courses.refuse(error)
        return False

    def use(self, path: Path, frame: str, *, anew: bool = True, stands: bool = False) -> None:
        """Take a path that came by another way than a message, in the frame of `measured`.

        With `stands` the vehicle is to stand on it, as where its speeds are 0.
        """
        stands = stands or (path.speed is not None and not path.speed.any())
        self.course = Course(path, frame, "the path's speeds are 0" if stands else "", anew)
        self.course_number += 1
        self.course_refused = ""

    def stand(self, why: str) -> None:
        """Stand on the present path until another one comes."""
        if self.course is not None:
            self.course = replace(self.course, stands=why)

    def forget_odometry(self) -> None:
        """Wait for odometry of the clock as it is now, after that has jumped."""
        self.measured = self._raw = None
        if self.frames is not None:
            self.frames.clear()

    def _check_time(self, at: float, now: float) -> None:
        if at > now + AHEAD:
            raise MessageError(f"stamp is {at - now:.2f} s in the future")
        if now - at > self.stale:
            raise MessageError(f"stamp is {now - at:.2f} s old")
        if self.measured is not None and at < self.measured_at:
            raise MessageError(f"stamp is {self.measured_at - at:.3f} s before the last one")


def _used(convert: Callable[..., Any], name: str, data: bytes, **options: bool) -> Any:  # noqa: ANN401
    """Convert a message; what rosbags stumbles over becomes one kind of error."""
    try:
        return convert(name, data, **options)
    except MessageError:
        raise
    except Exception as error:  # cut or altered bytes may break it anywhere
        raise MessageError(f"is no {name}: {type(error).__name__}") from error
