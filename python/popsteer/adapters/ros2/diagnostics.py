"""Diagnostics as ``diagnostic_msgs``: levels from those of the statuses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from popsteer import Status
from popsteer.adapters.ros2.commands import signed_speed
from popsteer.adapters.ros2.conversions import time_message
from popsteer.adapters.ros2.messages import DIAGNOSTICS, make

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer import Drive, Driver
    from popsteer.adapters.ros2.intake import Intake

OK, WARN, ERROR = 0, 1, 2
_JUMP = 1.0  # more than a planner's noise, less than a lane [m]
_LEVELS = {"ok": OK, "degraded": WARN, "fault": ERROR}
BLAMES = {
    "position": "positions repeat, jump about or do not come",
    "heading": "the heading is not that of the way, or does not come",
    "speed": "the speed is not that of the positions, or does not come",
    "steering": "the vehicle turns otherwise than commanded",
    "deviation": "it is farther off the path than its limit",
    "path": "the path is not where the vehicle is",
    "cannot-stop": "it overruns its stop, however hard it brakes",
}
"""What a fault of the driver means."""


@dataclass
class Loop:
    """What the loop's clock has measured."""

    period: float
    """The period that is wanted [s]."""
    cycles: int = 0
    """How many there were."""
    missed: int = 0
    """How many were missed, because one before took too long."""
    jumps: int = 0
    """How often the time has jumped."""
    mean_period: float = 0.0
    """The mean since the last message [s]."""
    longest_period: float = 0.0
    """The longest since the last message [s]."""
    longest_step: float = 0.0
    """The longest time that a cycle has taken since the last message [s]."""
    missed_lately: int = 0
    """How many were missed since the last message."""
    _since: int = 0

    def count(self, period: float, taken: float, missed: int) -> None:
        """Count a cycle: time since the one before, time taken [s], and how many were missed."""
        self.cycles += 1
        self.missed += missed
        self.missed_lately += missed
        self._since += 1
        self.mean_period += (period - self.mean_period) / self._since
        self.longest_period = max(self.longest_period, period)
        self.longest_step = max(self.longest_step, taken)

    def begin(self) -> None:
        """Start measuring again, after a message."""
        self._since = self.missed_lately = 0
        self.mean_period = self.longest_period = self.longest_step = 0.0


def message(  # noqa: PLR0913 - each is one thing that it tells of
    loop: Loop,
    intake: Intake,
    driver: Driver | None,
    drive: Drive | None,
    *,
    state: str,
    reason: str,
    level: int,
    deviation: float,
    path_jump: float,
    command: str,
    listeners: int,
    rivals: int,
    clocks: int,
    nanoseconds: int,
) -> Any:  # noqa: ANN401
    """Make four statuses: steering, inputs, outputs, loop.

    `state`, `reason` and `level` say what the node does, why, and how bad it is, as its attributes.
    `deviation` from the path and `path_jump`, from one path to the next beside the vehicle, are the
    largest since the last message [m]. `listeners` hear `command`, `rivals` publish on it too, and
    `clocks` publish a simulated time.
    """
    refused = intake.odometry.lately + intake.courses.lately
    troubles = [f"{refused} messages refused"] if refused else []
    if clocks > 1:
        troubles.append(f"{clocks} publishers of the clock")
    if path_jump > _JUMP:
        troubles.append(f"path jumped by {path_jump:.2f} m")
    heard = [] if listeners else [f"nobody hears {command}"]
    if rivals:
        heard.append(f"{rivals} more publish on {command}")
    age = 1e-9 * nanoseconds - intake.measured_at if intake.measured is not None else None
    inputs = {
        "odometry_received": intake.odometry.received,
        "odometry_refused": intake.odometry.refused,
        "odometry_refused_because": intake.odometry.reason,
        "odometry_age_s": "none" if age is None else age,
        "path_received": intake.courses.received,
        "path_refused": intake.courses.refused,
        "path_refused_because": intake.courses.reason,
        "path_from": "goals" if intake.goals else "topic",
    }
    times = {
        "wanted_period_s": loop.period,
        "mean_period_s": loop.mean_period,
        "longest_period_s": loop.longest_period,
        "longest_step_s": loop.longest_step,
        "cycles": loop.cycles,
        "missed_cycles": loop.missed,
        "time_jumps": loop.jumps,
    }
    late = [f"{loop.missed_lately} cycles missed"] if loop.missed_lately else []
    outputs = {"command_subscribers": listeners, "other_publishers": rivals}
    statuses = [
        _steering(driver, drive, state, reason, level, deviation),
        _warning("inputs", troubles, "all messages used", inputs),
        _warning("outputs", heard, "heard", outputs),
        _warning("loop", late, "on time", times),
    ]
    return make(DIAGNOSTICS, header={"stamp": time_message(nanoseconds)}, status=statuses)


def run_message(row: Mapping[str, float], nanoseconds: int) -> Any:  # noqa: ANN401
    """Make the message of a step of a simulated run, of its records: one status, steering."""
    status = Status(int(row["status"]))
    values = {
        "cross_track_error_m": row["cross_track_error"],
        "heading_error_rad": row["heading_error"],
        "steer_rad": row["steer"],
    }
    made = _status(_LEVELS[status.level], "steering", str(status), values)
    return make(DIAGNOSTICS, header={"stamp": time_message(nanoseconds)}, status=[made])


def _steering(
    driver: Driver | None,
    drive: Drive | None,
    state: str,
    reason: str,
    level: int,
    deviation: float,
) -> Any:  # noqa: ANN401
    said = f"{state}: {reason}" if reason else state
    if driver is None or drive is None:
        return _status(WARN, "steering", said, {"state": state})
    estimate, status = driver.estimate, str(drive.status)
    values = {
        "state": state,
        "reason": reason,
        "status": status,
        "cross_track_error_m": drive.cross_track_error,
        "heading_error_rad": drive.heading_error,
        "predicted_cross_track_error_m": drive.predicted_cross_track_error,
        "predicted_heading_error_rad": drive.predicted_heading_error,
        "deviation_m": deviation,
        "distance_to_stop_m": drive.distance_to_stop,
        "steer_rad": drive.steer,
        "speed_mps": signed_speed(drive),
        "estimated_dead_time_s": estimate.dead_time,
        "estimated_steer_offset_rad": estimate.steer_offset,
        "estimated_gain": estimate.gain,
        "estimated_slip_rad": estimate.slip,
    }
    if state == "driving":
        level, said = _LEVELS[drive.status.level], state if status == "ok" else status
        if drive.phase == "standing" and status in ("ok", "end-of-path"):
            level, said = OK, "standing at its stop"
    return _status(level, "steering", said, values)


def _warning(name: str, troubles: list[str], fine: str, values: Mapping[str, object]) -> Any:  # noqa: ANN401
    return _status(WARN if troubles else OK, name, "; ".join(troubles) or fine, values)


def _status(level: int, name: str, said: str, values: Mapping[str, object]) -> Any:  # noqa: ANN401
    worded = {k: f"{v:.6g}" if isinstance(v, float) else str(v) for k, v in values.items()}
    pairs = [make("diagnostic_msgs/msg/KeyValue", key=k, value=v) for k, v in worded.items()]
    return make(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=level,
        name=f"popsteer: {name}",
        message=said,
        hardware_id="popsteer",
        values=pairs,
    )
