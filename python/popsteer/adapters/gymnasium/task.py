"""The task of an environment: path, plant, start, pedals, reward, and what each episode draws."""

from __future__ import annotations

import copy
import math
from bisect import bisect_right
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast, get_args

import numpy as np
from gymnasium.spaces import Box, Space

from popsteer import CoupledLongitudinal, Path, PathError, SpeedPid, Vehicle, tracks
from popsteer._core import Episodes, Settings
from popsteer.errors import ConfigError, InputError, in_range
from popsteer.ranges import check_in_range, check_known
from popsteer.sim import Plant, Pose, plant_name, plant_names
from popsteer.sim.closed_loop import KEEPING, at_constant_speed
from popsteer.sim.geometry import CORE_PLANTS, object_of, pose_of, vehicle_of
from popsteer.tracks import Track

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray


Actions: TypeAlias = Literal["steer", "steer-and-pedals"]
"""What the agent does: steer alone, at the path's speeds, or work the pedals as well."""

# Share of an open path on which a random start may lie: the rest is left to be driven.
_START_SHARE = 0.9


@dataclass(frozen=True)
class RewardWeights:
    """Weights of the reward of a control step.

    ::

        reward = progress Δs - dt (cross_track_error e² + heading_error ψ² + steer_rate r²)

    less `off_path` at the step that leaves the path, or at which the plant reaches a limit of its
    model. Δs is the distance gained along the path [m], e [m] and ψ [rad] are cross-track and
    heading error of the rear axle after the step, r is the change of the commanded angle over dt
    [rad/s].

    Examples
    --------
    >>> RewardWeights(progress=0.0).off_path
    10.0
    """

    progress: float = 0.1
    """Weight of the distance gained along the path [1/m]."""
    cross_track_error: float = 1.0
    """Weight of the squared cross-track error [1/(m² s)]."""
    heading_error: float = 1.0
    """Weight of the squared heading error [1/(rad² s)]."""
    steer_rate: float = 0.1
    """Weight of the squared rate of the command [s/rad²]."""
    off_path: float = 10.0
    """What leaving the path costs, once."""


@dataclass(eq=False, kw_only=True)
class Task:
    """What the single environment and the batch share; `TrackEnv` lists the options."""

    track: str | Track | Path
    plant: Plant
    actions: Actions
    constant_speed: float | None
    longitudinal: SpeedPid | CoupledLongitudinal | None
    vehicle_ranges: Mapping[str, tuple[float, float]] | None
    random_start: bool
    start_offset: tuple[float, float]
    start_yaw: tuple[float, float]
    start_speed: float | None
    preview: Sequence[float]
    reward: RewardWeights | Mapping[str, float] | None
    off_path_distance: float
    time_limit: float
    stall_time: float | None
    dt: float
    substeps: int

    def __post_init__(self) -> None:
        path = _path_of(self.track)
        check_known("actions", self.actions, get_args(Actions))
        keeping: SpeedPid | CoupledLongitudinal = SpeedPid(KEEPING)
        if self.constant_speed is not None:
            path, keeping = at_constant_speed(path, self.constant_speed)
        if self.longitudinal is not None:
            keeping = self.longitudinal
        if self.actions == "steer" and path.speed is None and isinstance(keeping, SpeedPid):
            raise PathError("the path has no reference speeds: give it some, or a constant_speed")
        self.path = path
        # An episode begins in a few microseconds; attributes of the path are arrays, made anew.
        self._waypoints = (path.x.tolist(), path.y.tolist(), path.s.tolist())
        self._speeds = None if path.speed is None else path.speed.tolist()
        self._reverse = None if path.reverse is None else path.reverse.tolist()
        self._drawn_from = path.length if path.closed else _START_SHARE * path.length
        self.longitudinal = keeping if self.actions == "steer" else None
        self.name = plant_name(self.plant)  # refuses what is no plant
        # A name of the core's is looked up once, not at each episode.
        if isinstance(self.plant, str) and self.plant in CORE_PLANTS:
            self.plant = CORE_PLANTS[self.plant]()
        self.ranges = self._checked_ranges(self.vehicle_ranges)
        self.start_offset = _range("start_offset", self.start_offset, 1e3)
        self.start_yaw = _range("start_yaw", self.start_yaw, math.pi)
        if self.start_speed is not None:
            check_in_range("start_speed", self.start_speed, 0.0, 100.0)
        self.preview = [float(distance) for distance in self.preview]
        for distance in self.preview:
            check_in_range("preview", distance, 0.0, 1e3)
        self._weights = astuple(_reward_of(self.reward))
        if self.stall_time is not None:
            check_in_range("stall_time", self.stall_time, 0.0, 1e6, above=True)
        self.settings = Settings(
            dt=self.dt,
            substeps=self.substeps,
            give_up_distance=self.off_path_distance,
            time_limit=self.time_limit,
            keep_records=False,
        )
        # What is refused of plant and start is refused here.
        self.begin_in(self.episodes(1), 0, np.random.default_rng(0), self.own_plant())

    def _checked_ranges(
        self, ranges: Mapping[str, tuple[float, float]] | None
    ) -> dict[str, tuple[float, float]]:
        if not ranges:
            return {}
        if self.name not in plant_names():
            raise ConfigError("vehicle_ranges", dict(ranges), f"None, as {self.name} is one car")
        car = vehicle_of(self.plant)
        checked = {}
        for field, ends in ranges.items():
            check_known("field of vehicle_ranges", field, car.as_dict())
            name, wanted = f"vehicle_ranges[{field!r}]", "(lowest, highest)"
            try:
                low, high = (float(end) for end in ends)
            except (TypeError, ValueError) as error:
                raise ConfigError(name, ends, wanted) from error
            if not low <= high:
                raise ConfigError(name, (low, high), wanted)
            for end in (low, high):
                car.replace(**{field: end})  # refuses, by name, what is out of the field's range
            checked[field] = (low, high)
        return checked

    def own_plant(self) -> Any:  # noqa: ANN401 - any plant
        """Give a plant that no other vehicle shares: one in Python holds its own state."""
        if self.name in plant_names():
            return self.plant
        return object_of(self.plant) if isinstance(self.plant, str) else copy.deepcopy(self.plant)

    def episodes(self, count: int) -> Episodes:
        """Give room for so many vehicles."""
        return Episodes(
            count,
            self.preview,
            self._weights,
            longitudinal=self.longitudinal,
            settings=self.settings,
            stall_time=self.stall_time,
        )

    def observation_names(self) -> list[str]:
        """Name the entries of an observation, in order."""
        heads = [name for name in Episodes.figures() if name != "preview"]
        points = range(len(self.preview))
        return heads + [f"preview_{axis}[{k}]" for k in points for axis in "xy"]

    def observation_space(self) -> Space[NDArray[np.float32]]:
        """Give the space of observations."""
        bounds = dict(Episodes.figures())
        preview = bounds.pop("preview")
        high = np.array([*bounds.values(), *[preview] * (2 * len(self.preview))], dtype=np.float32)
        return cast("Space[NDArray[np.float32]]", Box(-high, high, dtype=np.float32))

    def action_space(self) -> Space[NDArray[np.float32]]:
        """Give the space of actions."""
        count = 1 if self.actions == "steer" else 2
        return cast("Space[NDArray[np.float32]]", Box(-1.0, 1.0, (count,), np.float32))

    def begin_in(
        self,
        episodes: Episodes,
        vehicle: int,
        rng: np.random.Generator,
        plant: Any,  # noqa: ANN401
    ) -> Vehicle:
        """Begin an episode with one of many vehicles; give what it is."""
        moved, start, speed = self.begin(rng, plant)
        episodes.begin(vehicle, self.path, moved, start, speed)
        return vehicle_of(moved)

    def begin(self, rng: np.random.Generator, plant: Any) -> tuple[Any, Pose, float]:  # noqa: ANN401
        """Draw how an episode begins: what moves, its pose, and its speed [m/s]."""
        car = vehicle_of(plant)
        if self.ranges:
            drawn = {field: rng.uniform(*ends) for field, ends in self.ranges.items()}
            car = car.replace(**drawn)
            plant = plant.replace(vehicle=car)
        arc = rng.uniform(0.0, self._drawn_from) if self.random_start else 0.0
        offset, turn = rng.uniform(*self.start_offset), rng.uniform(*self.start_yaw)
        xs, ys, arcs = self._waypoints
        segment = bisect_right(arcs, arc) - 1
        following = (segment + 1) % len(arcs)
        x, y = xs[segment], ys[segment]
        yaw = math.atan2(ys[following] - y, xs[following] - x)
        along = arc - arcs[segment]
        x += along * math.cos(yaw) - offset * math.sin(yaw)
        y += along * math.sin(yaw) + offset * math.cos(yaw)
        speed = self.start_speed
        if speed is None:
            speed = 0.0 if self._speeds is None else abs(self._speeds[segment])
        backwards = self._reverse is not None and self._reverse[segment]
        if backwards:
            yaw, speed = yaw + math.pi, -speed
        pose = (x, y, math.remainder(yaw + turn, math.tau))
        return plant, pose_of(pose, "rear", car), speed


def _path_of(track: str | Track | Path) -> Path:
    if isinstance(track, Path):
        return track
    if isinstance(track, str):
        track = tracks.get(track)
    if not isinstance(track, Track):
        raise TypeError(f"track must be a name, a Track or a Path, got {type(track).__name__}")
    return Path(track.xy, speed=track.speed, closed=track.closed)


def _reward_of(reward: RewardWeights | Mapping[str, float] | None) -> RewardWeights:
    if isinstance(reward, RewardWeights):
        return reward
    weights = reward or {}
    for name in weights:
        check_known("weight of the reward", name, RewardWeights.__dataclass_fields__)
    return RewardWeights(**weights)


def _range(name: str, ends: tuple[float, float], bound: float) -> tuple[float, float]:
    low, high = (float(end) for end in ends)
    if not -bound <= low <= high <= bound:
        raise ConfigError(name, (low, high), f"(lowest, highest) {in_range(-bound, bound)}")
    return low, high


INFO = tuple(Episodes.info_names())
"""The names of what is reported in addition to an observation."""


def actions_of(actions: ArrayLike, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    """Give actions as floats of this shape; refuse by InputError what is no such numbers."""
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(name, actions, "numbers") from error
    wanted = shape if name == "actions" else shape[1:]
    if array.shape != wanted:
        raise InputError(f"shape of {name}", array.shape, f"{wanted}")
    return array.reshape(shape)
