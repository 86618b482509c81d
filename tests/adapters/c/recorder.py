"""A controller whose calls and answers are written down, for `replay.c` to repeat."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import popsteer

if TYPE_CHECKING:
    from collections.abc import Iterable

FIELDS = (
    *("wheelbase", "width", "rear_axle", "antenna_left", "antenna_height"),
    *("no_slip_point", "turning_wheelbase", "understeer"),
    *("steer_offset", "steer_lag", "dead_time", "max_steer", "max_steer_rate", "steer_play"),
    *("max_lateral_acceleration", "max_speed", "max_acceleration", "max_deceleration"),
    *("brake_deceleration", "drive_delay", "drive_lag", "stop_point", "steers_at_rest"),
)
"""The fields of `popsteer_vehicle`: the numbers in order, then the flag."""

Waypoints = list[tuple[float, float, float]]
"""x, y [m] and speed [m/s]."""


def words(*numbers: float | None) -> str:
    """Write numbers so that C reads them to the bit."""
    return " ".join("nan" if each is None else float(each).hex() for each in numbers)


def bits(line: str) -> tuple[str, ...]:
    """Tell numbers apart by their bits, whoever wrote them; all NaN are one."""
    return tuple(float.fromhex(word).hex() for word in line.split())


def shown(command: popsteer.Command) -> str:
    """Write a command as `replay.c` does."""
    numbers = (
        *(command.steer, command.cross_track_error, command.heading_error),
        *(command.predicted_cross_track_error, command.predicted_heading_error),
        *(*command.target, command.reference_speed, command.distance_to_stop),
    )
    return f"{words(*numbers)} {int(command.status)} {int(command.reverse)}"


class Recorder:
    """A controller, the script of its calls, and what it answered."""

    def __init__(
        self, law: str, car: popsteer.Vehicle, paths: Iterable[tuple[Waypoints, bool]]
    ) -> None:
        given = list(paths)
        self.paths = [
            popsteer.Path(
                [(x, y) for x, y, _ in points], speed=[v for *_, v in points], closed=closed
            )
            for points, closed in given
        ]
        self.controller: Any = getattr(popsteer, law)(self.paths[0], car)
        self.script = [words(*(getattr(car, name) for name in FIELDS)), str(len(given))]
        for points, closed in given:
            self.script.append(f"{len(points)} {int(closed)} 1")
            self.script += [words(*each) for each in points]
        self.answers = [words(self.paths[0].length, self.controller.tracked_point)]

    def step(self, pose: tuple[float, float, float], speed: float, dt: float) -> popsteer.Command:
        self.script.append(f"s {words(*pose, speed, dt)}")
        return self._noted(self.controller.step(*pose, speed, dt))

    def step_reported(
        self, pose: tuple[float, float, float], speed: float, dt: float, applied: float, age: float
    ) -> popsteer.Command:
        self.script.append(f"r {words(*pose, speed, dt, applied, 0.5 * applied, age)}")
        angles = {"applied_steer": applied, "measured_steer": 0.5 * applied}
        return self._noted(self.controller.step(*pose, speed, dt, **angles, pose_age=age))

    def lose(self, dt: float, hold_limit: int) -> popsteer.Command:
        """Take a step whose pose is not a number."""
        self.script.append(f"h nan 0 0 0 {words(dt)} {hold_limit}")
        held = self.controller.step_or_hold(math.nan, 0.0, 0.0, 0.0, dt, hold_limit)
        return self._noted(held)

    def set_path(self, index: int) -> None:
        self.script.append(f"p {index}")
        self.controller.set_path(self.paths[index])

    def relocalise(self, pose: tuple[float, float, float]) -> None:
        self.script.append(f"l {words(*pose)}")
        self.controller.relocalise(*pose)

    def reset(self, steer: float | None = None) -> None:
        self.script.append("z" if steer is None else f"t {words(steer)}")
        self.controller.reset(steer=steer)

    def predict(self, count: int, dt: float) -> None:
        self.script.append(f"f {words(dt)} {count}")
        seen = self.controller.predict((count - 1) * dt, dt)
        columns = (seen.time, seen.x, seen.y, seen.yaw, seen.speed, seen.steer)
        self.answers += [words(*row) for row in zip(*columns, strict=True)]

    def estimate(self) -> None:
        self.script.append("e")
        known = self.controller.estimate
        self.answers.append(
            words(
                *(known.gain, known.steer_offset, known.dead_time),
                *(known.slip, known.slip_length, known.acceleration),
            )
        )

    def _noted(self, command: popsteer.Command) -> popsteer.Command:
        self.answers.append(shown(command))
        return command
