"""A controller of your own along a log: what a replay asks, around its `step`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.own import OwnCodeError
from popsteer.status import Status

if TYPE_CHECKING:
    from popsteer import Path, Vehicle


class Watched(NamedTuple):
    """What it answered, and where its tracked point was."""

    steer: float
    status: Status
    cross_track_error: float
    heading_error: float


class Watching:
    """A controller of your own, which is not told what the driver applied.

    Its name, path, vehicle and parameters are those of `popsteer.lab.compare.runs.controller`.
    """

    def __init__(
        self,
        name: str,
        path: Path,
        vehicle: Vehicle,
        params: Any,  # noqa: ANN401 - of a class of its own
        adapt: object = None,  # noqa: ARG002 - one of your own adapts as it likes
    ) -> None:
        found = baselines.get(name)
        params = found.params() if params is None else params
        self._name, self._path = name, path
        self._own: Any = found.controller(path, vehicle, params)
        self.tracked_point = getattr(self._own, "tracked_point", vehicle.front_axle)
        self.segment: int | None = None
        # As the controllers of popsteer search, of two wheelbases and the distance travelled.
        self._reach = 2.0 * vehicle.wheelbase
        self._opposite = vehicle.wheelbase * 10.0 / 3.0

    def step_or_hold(
        self,
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
        *,
        applied_steer: float,  # noqa: ARG002 - as the controllers of popsteer have it
    ) -> Watched:
        """Answer a row of the log.

        Raises OwnCodeError, with the traceback, where the controller raises.
        """
        try:
            command = self._own.step(x, y, yaw, speed, dt)
            steer = float(getattr(command, "steer", command))
        except Exception as error:
            raise OwnCodeError(self._name, error) from error
        if not math.isfinite(steer):
            raise ConfigError(f"the angle of {self._name}", steer, "finite")
        x, y = x + self.tracked_point * math.cos(yaw), y + self.tracked_point * math.sin(yaw)
        if self.segment is None:
            self.segment = self._path.relocalise(x, y, yaw, opposite_distance=self._opposite)
        reach = self._reach + abs(speed) * dt
        at = self._path.locate(x, y, yaw, self.segment, reach, opposite_distance=self._opposite)
        self.segment = at.segment
        heading = math.remainder(yaw - at.path_yaw, math.tau)
        status = Status(int(getattr(command, "status", 0)))
        return Watched(steer, status, at.cross_track_error, heading)
