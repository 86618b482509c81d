"""The node: at a fixed rate it takes what has come in, steers, and reports."""

from __future__ import annotations

import math
import re
import time
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from popsteer import Driver, DriverParams
from popsteer.adapters.ros2 import conversions, diagnostics, messages
from popsteer.adapters.ros2.commands import command_message, predicted_message
from popsteer.adapters.ros2.intake import Intake
from popsteer.adapters.ros2.names import expanded
from popsteer.adapters.ros2.signals import Signals
from popsteer.adapters.ros2.topics import Topics
from popsteer.errors import InputError, PopsteerError
from popsteer.ranges import check_in_range

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer import Drive, Path
    from popsteer.adapters.ros2.conversions import Measured
    from popsteer.adapters.ros2.dds import Participant
    from popsteer.adapters.ros2.recording import Recording

_SECOND = 10**9
_FIRST = 0.02  # what the first step of a drive counts [s], which has none before it
_AHEAD = 2.0  # the intended trajectory's length [s]

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
    """How long it drives on without what is missing before it brakes [s]."""
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
    """Drives a vehicle over the topics of a DDS domain.

    Parameters
    ----------
    participant : Participant
        The member of the domain.
    make_driver : callable
        Makes the driver of a path that begins a drive.
    options : Options, optional
        How it runs.
    recording : Recording, optional
        Where all messages go that come in or go out.
    say : callable, optional
        Called with a line for each change, whose `level` is the node's.

    Attributes
    ----------
    driver : Driver or None
        What drives; None before there is odometry and a path.
    drive : Drive or None
        What it answered last.
    state : str
        What the node does: "waiting", "driving", "holding" (something is missing, and it drives on
        for a moment), "braking" or "standing" (for a fault, or for something that is missing).
    reason : str
        Why it does not drive.
    waits : str
        What a path that is to begin waits for.

    Examples
    --------
    >>> from popsteer import Driver
    >>> from popsteer.adapters.ros2.dds import Participant
    >>> node = Node(Participant(79, local=True), Driver)
    >>> node.cycle(1_000_000_000, 0.02), node.waits
    (None, 'no odometry on /odom')
    """

    def __init__(
        self,
        participant: Participant,
        make_driver: Callable[[Path], Driver],
        options: Options | None = None,
        *,
        recording: Recording | None = None,
        say: Callable[[str], object] | None = None,
    ) -> None:
        self.options = options = Options() if options is None else options
        self.intake = Intake(options.topics.path_type, options.stale, closed=options.closed)
        self.loop = diagnostics.Loop(options.period)
        self.driver: Driver | None = None
        self.drive: Drive | None = None
        self.state, self.reason, self.waits = "waiting", "", ""
        self._participant = participant
        self._make = make_driver
        self._recording = recording
        self._say = say or (lambda _: None)
        topics = options.topics
        self._types = topics.types()
        for kind in self._types.values():  # the first takes up to 0.3 s, not for mid-drive
            messages.make(kind)
        self.odometry_reader = participant.reader(topics.odometry, messages.ODOMETRY)
        self.path_reader = participant.latest(topics.path, topics.path_type)
        self.signals = Signals(participant, topics)
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
        self._most = self._top = math.inf
        self._rests = self._silent = False
        # At the next odometry: whether the fault is forgotten, and whether the drive begins anew.
        self._released = self._moved = self._engaged = False
        self._jump = ""
        self._last = 0.0, 0
        self._aged = math.nan, 0.0
        self._path_jump = self._deviation = 0.0
        self._reported, self._told = 0, ""

    def jumped(self, seconds: float) -> None:
        """Note that the clock has jumped by `seconds`: what was measured before is discarded."""
        self.loop.jumps += 1
        self._jump = f"time jumped by {seconds:+.2f} s"
        self._reported = 0
        self._moved = True  # a simulation that begins anew has the vehicle elsewhere
        self.intake.forget_odometry()

    def change(self, **options: float) -> None:
        """Change `stale`, `hold` or `keep_path` of the options while it runs."""
        self.options = replace(self.options, **options)  # type: ignore[arg-type]
        self.intake.stale = self.options.stale
        self._limit()

    def limit_speed(self, most: float) -> None:
        """Drive no faster than this from now on [m/s], whatever the vehicle and the path allow."""
        self._most = most
        self._limit()

    def _limit(self) -> None:
        """Apply `hold`, and the lowest of the speeds that vehicle, user and topic allow.

        The drive goes on with a driver of the same state.
        """
        if (old := self.driver) is None:
            return
        most = self.signals.slowed(min(self._most, self._top))
        self.driver = Driver(
            old.path,
            old.vehicle.replace(max_speed=max(most, 1e-3) if most < 1e4 else None),  # its range
            old.controller,
            speed=old.speed,
            params=DriverParams(hold_time=self.options.hold),
            adapt=old.adapt,
            monitor=old.monitor,
        )
        self.driver.state = old.state

    def rest(self, why: str) -> None:
        """Brake to a standstill, and command nothing after that until there is another path."""
        self.intake.stand(why)
        self._rests = True
        self._course_number = self.intake.course_number  # what has not begun does not begin

    @property
    def stands(self) -> bool:
        """Whether there is nothing to brake: the vehicle is held, and the commanded speed is 0."""
        return self.drive is None or (self.drive.hold and self.drive.speed == 0.0)

    def release(self) -> str:
        """Forget the fault that it brakes for, once there is odometry; says what it was."""
        fault = self.driver.fault if self.driver is not None else None
        self._released = fault is not None
        return f"released: {fault}" if fault else "there is no fault"

    def cycle(self, now: int, dt: float, missed: int = 0) -> Drive | None:
        """Do one cycle: take, steer, publish.

        `now` is the time of the node's clock [ns], `dt` the measured time since the last cycle [s],
        `missed` how many were missed before it. Gives what was commanded; None before there is
        odometry and a path.
        """
        began = time.perf_counter()
        self._take(now)
        measured = self.intake.measured
        if 1e-9 * now - self.intake.measured_at > self.options.stale:
            measured = None
        begins = self._renew(measured, 1e-9 * now)
        self._step(measured, 1e-9 * now, _FIRST if begins else dt)
        self._publish_drive(now)
        # Once it stands: what moves the vehicle then is another's business.
        self._silent = self._silent or (self._rests and self.stands)
        changed = self.note(self._account())
        self.loop.count(dt, time.perf_counter() - began, missed)
        if changed or now - self._reported >= _SECOND / self.options.report_rate:
            self._report(now)
        return self.drive

    def finish(self, now: int) -> None:
        """Command a speed of 0, as the last command, at `now` of the node's clock [ns]."""
        self._publish_drive(max(now, self._last[1]), ends=True)

    def check_silence(self, waited: float) -> None:
        """Give up where nothing has come in for `waited` seconds.

        Raises PopsteerError where the time-out has passed; says what is missing and why.
        """
        if self.driver is not None or waited < self.options.timeout:
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
        self.signals.take(seconds, lambda topic, data: self._record(topic, data, now))
        if self.signals.limited:
            self._limit()
        if self.signals.released:
            self.release()
        self._engaged |= self.signals.engaged

    def _renew(self, measured: Measured | None, now: float) -> bool:
        """Go over to the path that came last; says whether a drive begins with it."""
        course = self.intake.course
        if course is None or not self._waits:
            return False
        begins = self.driver is None or course.anew or self._rests
        if self.driver is None or begins:
            if measured is None:
                return False
            self._begin(course.path, measured, now)
        else:
            if measured is not None:
                with suppress(InputError):  # of a pose that cannot be, too
                    paths = self.driver.path, course.path
                    was, to = (path.project(*measured[:2]).cross_track_error for path in paths)
                    self._path_jump = max(self._path_jump, abs(to - was))
            self.driver.set_path(course.path)
        self._course_number = self.intake.course_number
        return begins

    def _begin(self, path: Path, measured: Measured, now: float) -> None:
        """Start along a path; nothing of the drive before counts, nor a fault.

        The angle goes on from that of the wheels: as a sensor measures it, or as the odometry's yaw
        rate shows it.
        """
        self.driver = self._make(path)
        self._top = self.driver.vehicle.max_speed or math.inf
        self._limit()
        self._reset(self.driver, measured, now)
        self._rests = self._silent = self._released = self._moved = self._engaged = False
        self.state, self.reason = "driving", ""
        self._say(f"path of {len(path)} points, {path.length:.1f} m")

    def _reset(self, driver: Driver, measured: Measured, now: float) -> None:
        """Begin anew from where the vehicle is, at the angle of the wheels that others steered."""
        car, at = driver.vehicle, self.signals.steer(now, self.options.stale)
        at = conversions.shown_steer(car, measured) if at is None else at
        driver.reset(**({"steer": max(-car.max_steer, min(at, car.max_steer))} if at else {}))

    @property
    def _waits(self) -> bool:
        """Whether a path is to begin, and has not yet."""
        return self._course_number != self.intake.course_number

    def _concern(self, measured: Measured | None, now: float) -> tuple[str, bool]:
        """Say what is missing, and whether the vehicle is to stand though odometry comes."""
        intake, topics, options = self.intake, self.options.topics, self.options
        waited = now - intake.course_refused_at - options.keep_path
        waited = waited if intake.course_refused else 0.0
        stands = "" if intake.course is None else intake.course.stands
        # A path that is to begin waits for odometry, while the one before is braked on.
        halts = bool(stands) or waited > options.hold or self._waits
        if measured is None:
            since = "" if intake.measured is None else f" for {options.stale:g} s"
            missing = self._jump or f"no odometry on {topics.odometry}{since}"
            return f"{missing}{_because(intake.odometry_refused)}", halts
        self._jump = ""
        if intake.course is None:
            return f"no path on {topics.path}{_because(intake.course_refused)}", halts
        if waited > 0.0:
            return f"path on {topics.path} refused: {intake.course_refused}", halts
        return stands, halts

    def _step(self, measured: Measured | None, now: float, dt: float) -> None:
        """Take the driver's step."""
        concern, halts = self._concern(measured, now)
        if (driver := self.driver) is None:
            self.reason = self.waits = concern
            return
        if measured is not None:
            # What was missing is back: it drives again by itself, but for another fault does not.
            if self._released or driver.fault == "input":
                driver.release()
            if self._moved and driver.fault is None and self.drive is not None:
                driver.reset(steer=self.drive.steer)
            if self._engaged and driver.fault is not None:  # what a person drove is no part of it
                self._reset(driver, measured, now)
            self._released = self._moved = self._engaged = False
        if self._silent:  # who moves the vehicle now does not follow the path
            self.reason = driver.fault or concern
            return
        (driver.hold if halts else driver.go)()
        x, y, yaw, speed = 4 * (math.nan,) if measured is None else measured[:4]
        # One pose ages by the steps' times: their clock is not quite that of its stamp.
        at, (before, age) = self.intake.measured_at, self._aged
        age = age + dt if at == before else max(now - at, 0.0)
        self._aged = at, age
        age = 0.0 if measured is None else age
        wheel = self.signals.steer(now, self.options.stale)
        drive = driver.step(x, y, yaw, speed, dt, pose_age=age, measured_steer=wheel)
        self.drive = drive
        self.reason = drive.fault if drive.fault not in (None, "input") else concern
        if drive.fault or halts:
            self.state = "standing" if drive.hold else "braking"
        else:
            self.state = "holding" if concern else "driving"
        self.waits = concern if self._waits else ""
        self._deviation = max(self._deviation, abs(drive.cross_track_error))

    def _publish_drive(self, now: int, *, ends: bool = False) -> None:
        drive, driver = self.drive, self.driver
        if drive is None or driver is None or self._silent:
            return
        topics, measured = self.options.topics, self.intake.measured
        frame = "base_link" if measured is None else measured.child_frame
        before, self._last = self._last, (drive.steer, now)
        passed = 1e-9 * (now - before[1])
        rate = (drive.steer - before[0]) / passed if 0.0 < passed < 1.0 else 0.0
        message = command_message(
            topics.command_type, driver, drive, now, frame, steer_rate=rate, ends=ends
        )
        self._publish(topics.command, message, now)

    @property
    def level(self) -> int:
        """How bad what it does is, by the levels of diagnostics; OK where it is told to stand."""
        course = self.intake.course
        if self.state == "driving" or self.reason == ("" if course is None else course.stands):
            return diagnostics.OK
        return diagnostics.ERROR if self.state in ("braking", "standing") else diagnostics.WARN

    @property
    def why(self) -> str:
        """The reason, with what a fault means."""
        fault = diagnostics.BLAMES.get(self.reason)
        return f"{self.reason}: {fault}" if fault else self.reason

    def _account(self) -> str:
        """Say what it does, why, and what ends a fault."""
        told = f"{self.state}: {self.why}" if self.reason else self.state
        if self.reason not in diagnostics.BLAMES:
            return told
        return f"{told}; ~/reset or a message on {self.options.topics.release} releases it"

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
            self.driver,
            self.drive,
            state=self.state,
            reason=self.reason,
            level=self.level,
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
        driver, course = self.driver, self.intake.course
        if heard and driver is not None and self.state == "driving" and course is not None:
            with suppress(InputError):
                ahead = driver.predict(_AHEAD, self.options.period)
                message = predicted_message(ahead, self.intake.seen_from, now, course.frame)
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
