"""The node: at a fixed rate it takes what has come in, steers, and reports."""

from __future__ import annotations

import math
import re
import time
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import TYPE_CHECKING, Any

from popsteer.adapters.ros2 import conversions, diagnostics, messages
from popsteer.adapters.ros2.intake import Intake
from popsteer.adapters.ros2.names import expanded
from popsteer.adapters.ros2.paths import inverse, placed
from popsteer.adapters.ros2.pilot import DriveCommand, Pilot, State
from popsteer.adapters.ros2.topics import Topics
from popsteer.errors import InputError, PopsteerError
from popsteer.logs.messages import STEERING
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer import Path
    from popsteer.adapters.ros2.conversions import Measured
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.recording import Recording
    from popsteer.controllers import Controller

_SECOND = 10**9
_AHEAD = 2.0  # the intended trajectory's length [s] ...
_POSES = 40  # ... and its poses at most
_STANDING = 0.05  # a vehicle slower than this stands [m/s]

RANGES = {
    "rate": (1.0, 1000.0),
    "stale": (0.01, 1.0),
    "hold": (0.0, 10.0),
    "keep_path": (0.0, 1e6),
    "timeout": (0.0, 1e6),
    "report_rate": (0.1, 1000.0),
}
"""What the numbers of `Options` may be."""


@dataclass(frozen=True)
class Options:
    """How a node runs.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> Options(rate=100.0).period
    0.01
    >>> Options(rate=0.0)
    Traceback (most recent call last):
    popsteer.errors.ConfigError: rate must be in [1, 1000], got 0.0
    """

    rate: float = 50.0
    """Control steps a second [Hz]."""
    stale: float = 0.3
    """Odometry older than this is not steered by [s]."""
    hold: float = 0.2
    """How long the last command is held before the node brakes [s]."""
    keep_path: float = 1.0
    """How long the last path stays in force where those after it are refused [s]."""
    timeout: float = 10.0
    """How long it waits for the first odometry and the first path [s]."""
    closed: bool = False
    """Whether the last point of a path joins its first."""
    sim_time: bool = False
    """Whether time is that of the topic clock."""
    topics: Topics = field(default_factory=Topics)
    """The topics."""
    report_rate: float = 10.0
    """Diagnostics and intended trajectories a second [Hz]."""

    def __post_init__(self) -> None:
        for name, (low, high) in RANGES.items():
            check_in_range(name, getattr(self, name), low, high)

    @property
    def period(self) -> float:
        """Time from one step to the next [s]."""
        return 1.0 / self.rate


class Node:
    """Steers a vehicle over the topics of a DDS domain.

    Parameters
    ----------
    participant : Participant
        The member of the domain.
    make_controller : callable
        Makes the controller of the first path.
    options : Options, optional
        How it runs.
    recording : Recording, optional
        Where all messages go that come in or go out.
    say : callable, optional
        Called with a line for each change.

    Examples
    --------
    >>> from popsteer import Stanley
    >>> from popsteer.adapters.ros2.dds import Participant
    >>> node = Node(Participant(79, local=True), Stanley)
    >>> node.cycle(1_000_000_000, 0.02), node.waits
    (None, 'no odometry on /odom')
    """

    def __init__(
        self,
        participant: Participant,
        make_controller: Callable[[Path], Controller],
        options: Options | None = None,
        *,
        recording: Recording | None = None,
        say: Callable[[str], object] | None = None,
    ) -> None:
        self.options = options = Options() if options is None else options
        self.intake = Intake(options.topics.path_type, options.stale, closed=options.closed)
        self.loop = diagnostics.Loop(options.period)
        self.pilot: Pilot | None = None
        self.drive: DriveCommand | None = None
        self.waits = ""
        self._participant = participant
        self._make = make_controller
        self._recording = recording
        self._say = say or (lambda _: None)
        topics = options.topics
        self._types = topics.types()
        for kind in self._types.values():  # the first takes up to 0.3 s, not for mid-drive
            messages.make(kind)
        self.odometry_reader = participant.reader(topics.odometry, messages.ODOMETRY)
        self.path_reader = participant.latest(topics.path, topics.path_type)
        # What says who drives, and the wheels' angle, where there are such topics.
        more = (topics.release, topics.speed_limit, topics.steering)
        self._others = {
            topic: participant.reader(topic, self._types[topic])
            for topic in (*more, topics.mode, topics.operation_mode)
            if topic
        }
        self._engaged: dict[str, bool] = {}
        self._wheel: tuple[float, float] | None = None
        names = participant.node, participant.namespace
        self._resets = participant.service(expanded("~/reset", *names), self.release)
        # Autoware's controllers keep their last command, as its gate asks for.
        latched, writer = topics.command_type == messages.CONTROL, participant.writer
        self._writers = {
            topics.command: writer(topics.command, topics.command_type, latched=latched),
            topics.predicted: writer(topics.predicted, messages.PATH),
            topics.diagnostics: writer(topics.diagnostics, messages.DIAGNOSTICS, depth=10),
        }
        self._course_number = 0
        self._most = math.inf
        self._said_limit: Any = None
        self._rests = self._silent = False
        self._jump = ""
        self._last = 0.0, 0
        self._path_jump = 0.0
        self._deviation = 0.0
        self._reported = 0
        self._told = ""

    def jumped(self, seconds: float) -> None:
        """Note that the clock has jumped by `seconds`: what was measured before is discarded."""
        self.loop.jumps += 1
        self._jump = f"time jumped by {seconds:+.2f} s"
        self._reported = 0
        self.intake.forget_odometry()
        if self.pilot is not None:
            self.pilot.reset()

    def change(self, **options: float) -> None:
        """Change `stale`, `hold` or `keep_path` of the options while it runs."""
        self.options = replace(self.options, **options)  # type: ignore[arg-type]
        self.intake.stale = self.options.stale
        if self.pilot is not None:
            self.pilot.hold = self.options.hold

    def limit_speed(self, most: float) -> None:
        """Drive no faster than this from now on [m/s], whatever the vehicle and the path allow."""
        self._most = most
        self._apply_limit()

    def _apply_limit(self) -> None:
        """Apply the lowest of what the vehicle, the user and the topic say of the speed."""
        if self.pilot is None:
            return
        most = min(self._most, self.pilot.vehicle.max_speed or math.inf)
        if (said := self._said_limit) is not None and said.speed_limit > 0.0:
            most = min(
                most, 0.01 * said.speed_limit * most if said.percentage else said.speed_limit
            )
        self.pilot.limit_speed(most)

    def rest(self, why: str) -> None:
        """Brake to a standstill, and command nothing after that until there is another path."""
        self.intake.stand(why)
        self._rests = True
        self._course_number = self.intake.course_number  # what has not begun does not begin

    @property
    def stands(self) -> bool:
        """Whether there is nothing to brake: command and speed, if that is known, are 0."""
        measured = self.intake.measured
        still = measured is None or abs(measured.speed) < _STANDING
        return self.drive is None or (self.drive.speed == 0.0 and still)

    def release(self) -> str:
        """Forget the fault that it brakes for; says what it was."""
        fault = self.pilot.release() if self.pilot is not None else ""
        return f"released: {fault}" if fault else "there is no fault"

    def cycle(self, now: int, dt: float, missed: int = 0) -> DriveCommand | None:
        """Do one cycle: take, steer, publish.

        `now` is the time of the node's clock [ns], `dt` the measured time since the last cycle [s],
        `missed` how many were missed before it. Gives what was commanded; None before there is
        odometry and a path.
        """
        began = time.perf_counter()
        self._take(now)
        self._renew()
        self.drive = self._steer(now, dt)
        if self.drive is not None and not self._silent:
            self._publish_drive(self.drive, now)
        # Once it stands: what moves the vehicle then is another's business.
        self._silent = self._silent or (self._rests and self.stands)
        changed = self._tell()
        self.loop.count(dt, time.perf_counter() - began, missed)
        if changed or now - self._reported >= _SECOND / self.options.report_rate:
            self._report(now)
        return self.drive

    def finish(self, now: int) -> None:
        """Command a speed of 0, as the last command, at `now` of the node's clock [ns]."""
        if self.drive is not None and not self._silent:
            limit = abs(self.drive.limit)
            self._publish_drive(DriveCommand(self.drive.steer, 0.0, -limit, limit), now)

    def check_silence(self, waited: float) -> None:
        """Give up where nothing has come in for `waited` seconds.

        Raises PopsteerError where the time-out has passed; says what is missing and why.
        """
        if self.pilot is not None or waited < self.options.timeout:
            return
        topics, intake, participant = self.options.topics, self.intake, self._participant
        if intake.measured is None:
            topic, reader, count = topics.odometry, self.odometry_reader, intake.odometry
        else:
            topic, reader, count = topics.path, self.path_reader, intake.courses
        kind = self._types[topic]
        if count.refused:
            why = f"{count.refused} of {count.received} messages refused, the last: {count.reason}"
            if count.reason.startswith("stamp is"):
                why += "; the clocks have to agree, and simulated time needs --sim-time"
        else:
            why = participant.graph.why_silent(topic, kind, reader)
        raise PopsteerError(
            f"no {kind} that can be used on {topic} in domain {participant.domain} within"
            f" {self.options.timeout:g} s: {why}"
        )

    def _take(self, now: int) -> None:
        topics, seconds = self.options.topics, 1e-9 * now
        for data in self.odometry_reader.take():
            self._record(topics.odometry, data, now)
            self.intake.take_odometry(data, seconds)
        for data in self.path_reader.take():
            self._record(topics.path, data, now)
            self.intake.take_course(data, seconds)
        self._resets.take()
        for topic, reader in self._others.items():
            for data in reader.take():
                self._record(topic, data, now)
                with suppress(Exception):  # bytes that are no message say nothing
                    self._hear(topic, messages.decode(self._types[topic], data), seconds)

    def _hear(self, topic: str, message: Any, now: float) -> None:  # noqa: ANN401
        """Take what is said of the speed, of the wheels, and of who drives.

        A fault is forgotten where somebody says so, or hands the vehicle over.
        """
        topics, kind = self.options.topics, self._types[topic]
        if topic == topics.speed_limit:
            before, self._said_limit = self._said_limit, message
            if before is None or before.speed_limit != message.speed_limit:
                self._apply_limit()
            return
        if topic == topics.steering:
            angle = float(reduce(getattr, STEERING[kind].angle, message))
            if abs(angle) < 0.5 * math.pi:
                self._wheel = angle, now
            return
        was = topic != topics.release and self._engaged.get(topic, False)
        if topic == topics.release:
            engaged = True
        elif topic == topics.mode:
            engaged = message.mode == 1
        else:
            engaged = message.mode == message.AUTONOMOUS and message.is_autoware_control_enabled
        self._engaged[topic] = engaged
        if engaged and not was:
            self.release()

    def _renew(self) -> None:
        """Go over to the path that came last."""
        course, measured = self.intake.course, self.intake.measured
        if course is None or self._course_number == self.intake.course_number:
            return
        if self.pilot is None or course.anew or self._rests:
            if measured is None:
                return
            controller = self._make(course.path)
            if self.pilot is None:
                self.pilot = Pilot(controller, hold=self.options.hold)
            else:
                self.pilot.begin(controller)
            self._apply_limit()
            self._rests = self._silent = False
            self._say(f"path of {len(course.path)} points, {course.path.length:.1f} m")
        else:
            if measured is not None:
                with suppress(InputError):  # of a pose that the controller refuses, too
                    paths = self.pilot.controller.path, course.path
                    was, now = (path.project(*measured[:2]).cross_track_error for path in paths)
                    self._path_jump = max(self._path_jump, abs(now - was))
            self.pilot.set_path(course.path)
        self._course_number = self.intake.course_number

    def _concern(self, now: int) -> tuple[str, Measured | None]:
        """Say what is missing, and what can be steered by all the same."""
        intake, topics = self.intake, self.options.topics
        measured, course = intake.measured, intake.course
        if measured is None or 1e-9 * now - intake.measured_at > self.options.stale:
            since = "" if measured is None else f" for {self.options.stale:g} s"
            missing = self._jump or f"no odometry on {topics.odometry}{since}"
            return f"{missing}{_because(intake.odometry_refused)}", None
        self._jump = ""
        if course is None:
            return f"no path on {topics.path}{_because(intake.course_refused)}", None
        waited = 1e-9 * now - intake.course_refused_at
        if intake.course_refused and waited > self.options.keep_path:
            return f"path on {topics.path} refused: {intake.course_refused}", measured
        return course.stands, measured

    def _steer(self, now: int, dt: float) -> DriveCommand | None:
        concern, measured = self._concern(now)
        if self.pilot is None:
            self.waits = concern
            return None
        age = 1e-9 * now - self.intake.measured_at
        wheel = self._wheel
        if wheel is not None and 1e-9 * now - wheel[1] > self.options.stale:
            wheel = None
        drive = self.pilot.step(measured, age, dt, concern, wheel and wheel[0])
        if self.pilot.command is None:  # it has not driven yet, so there is nothing to hold
            self.waits = concern
            return None
        # A path that is to begin waits for odometry, while the one before is braked on.
        self.waits = concern if self._course_number != self.intake.course_number else ""
        self._deviation = max(self._deviation, abs(self.pilot.command.cross_track_error))
        return drive

    def _publish_drive(self, drive: DriveCommand, now: int) -> None:
        topics, measured = self.options.topics, self.intake.measured
        frame = "base_link" if measured is None else measured.child_frame
        kind, steer, speed = topics.command_type, drive.steer, drive.speed
        message: Any
        if kind == messages.CONTROL:
            before, self._last = self._last, (steer, now)
            passed = 1e-9 * (now - before[1])
            rate = (steer - before[0]) / passed if 0.0 < passed < 1.0 else 0.0
            message = conversions.control_message(
                steer, speed, drive.acceleration, now, steer_rate=rate
            )
        elif kind in (messages.TWIST, messages.TWIST_STAMPED) and self.pilot is not None:
            message = conversions.twist_message(speed, self.pilot.yaw_rate(drive))
            if kind == messages.TWIST_STAMPED:
                message = conversions.twist_stamped_message(message, now, frame)
        else:
            message = conversions.ackermann_message(steer, speed, drive.limit, now, frame)
        self._publish(topics.command, message, now)

    def _tell(self) -> bool:
        """Say what has changed."""
        if self.pilot is None or self.drive is None:
            return self.note(f"waiting: {self.waits}")
        if self.pilot.state is State.DRIVING:
            return self.note("driving")
        return self.note(f"{self.pilot.state.value}: {self.pilot.reason}")

    def note(self, told: str) -> bool:
        """Say what goes on, where that is news: more than another number in the same words."""
        words = re.sub(r"[-+]?\d[\d.]*", "", told)
        changed, self._told = words != self._told, words
        if changed:
            self._say(told)
        return changed

    def _report(self, now: int) -> None:
        """Publish diagnostics and the intended trajectory."""
        topics = self.options.topics
        graph = self._participant.graph
        graph.look()
        report = diagnostics.message(
            self.loop,
            self.intake,
            self.pilot,
            self.drive,
            waits=self.waits,
            deviation=self._deviation,
            path_jump=self._path_jump,
            command=topics.command,
            listeners=self._writers[topics.command].peers,
            rivals=graph.others(topics.command),
            clocks=graph.others(topics.clock) if self.options.sim_time else 0,
            nanoseconds=now,
        )
        self._publish(topics.diagnostics, report, now)
        self.loop.begin()
        self.intake.odometry.lately = self.intake.courses.lately = 0
        self._reported, self._deviation, self._path_jump = now, 0.0, 0.0
        heard = self._recording is not None or self._writers[topics.predicted].peers > 0
        pilot, course = self.pilot, self.intake.course
        if not heard or pilot is None or pilot.state is not State.DRIVING or course is None:
            return
        try:
            ahead = pilot.controller.predict(_AHEAD, self.options.period)
        except InputError:
            return
        every = -(-len(ahead.time) // _POSES)
        columns = (values[::every].tolist() for values in (ahead.x, ahead.y, ahead.yaw))
        # The message is in the frame of the path.
        back = inverse(self.intake.seen_from or (0.0, 0.0, 0.0))
        poses = [placed(back, pose) for pose in zip(*columns, strict=True)]
        x, y, yaw = zip(*poses, strict=True)
        message = conversions.path_message(x, y, yaw, now, course.frame)
        self._publish(topics.predicted, message, now)

    def _publish(self, topic: str, message: Any, now: int) -> None:  # noqa: ANN401
        data = messages.encode(message)
        self._writers[topic].write(data)
        self._record(topic, data, now)

    def _record(self, topic: str, data: bytes, now: int) -> None:
        if self._recording is not None:
            self._recording.add_bytes(topic, self._types[topic], data, now)


def _because(reason: str) -> str:
    return f"; the last one was refused: {reason}" if reason else ""
