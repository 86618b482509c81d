"""The suite's loop: a scenario under a condition, by one controller on one plant."""

from __future__ import annotations

import itertools
import math
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer import controllers, own
from popsteer._core import Path, Settings, Simulation, SpeedTracker, Vehicle, _path_cusps
from popsteer.errors import InputError
from popsteer.lab.common.varied import varied
from popsteer.lab.suite.scenarios import Condition, Scenario
from popsteer.sim import default_start, vehicle_of
from popsteer.sim.metrics import Metrics
from popsteer.sim.pedals import PedalMap

LATERAL = 4.0
"""Lateral acceleration that speeds are planned for [m/s²]."""
_GRAVITY = 9.806_65
_LIMITS = {"max_lateral_acceleration": LATERAL, "max_acceleration": 2.0, "max_deceleration": 3.0}
GIVE_UP = 10.0
"""A run ends so far from the path, and counts as so far where it does not reach the end [m]."""
# Waypoints of a local quadratic.
_WINDOW = 7


class Driven(NamedTuple):
    """What a run came to, as `Cell` has it; also the plant's wheelbase [m]."""

    metrics: Metrics
    wheelbase: float
    end_error: float
    ending: str
    steer_rate: float
    lateral_jerk: float
    faults: float
    step_time: float
    """Median time of the controller's step [s]."""
    traceback: str


def drive(
    scenario: Scenario,
    condition: Condition,
    plant: Any,
    make: Callable[[Path, Vehicle], Any],
    seed: int = 0,
    dt: float = 0.05,
) -> Driven:
    """Drive once. The same seed gives the same noise and the same losses to every controller."""
    path = scenario.path()
    told = varied(plant, path, scenario.plant).plant
    mover = varied(told, path, condition.plant).plant
    believed = vehicle_of(mover if condition.is_told else told)
    share, turning = condition.wheelbase, believed.turning_wheelbase
    believed = believed.replace(
        wheelbase=share * believed.wheelbase,
        turning_wheelbase=None if turning is None else share * turning,
    )
    limited = vehicle_of(mover).replace(max_speed=scenario.max_speed, **_LIMITS)
    pace = SpeedTracker(path, limited)
    start = default_start(path, scenario.start_offset, vehicle_of(mover))
    first = pace.step(*start, 0.0, dt).reference_speed if scenario.rolling else 0.0
    pace.reset()
    settings = Settings(dt=dt, give_up_distance=GIVE_UP, time_limit=300.0)
    begun: Any = {"start": start, "speed": first, "tracked_point": vehicle_of(mover).rear_axle}
    run = Simulation(path, mover, settings=settings, **begun)
    loop = _Loop(run, path, condition, pace, PedalMap.of(mover), np.random.default_rng(seed))
    trace = ""
    try:
        controller = make(loop.told(), believed)
        while not run.is_over:
            loop.cycle(controller, dt)
    except Exception as error:  # noqa: BLE001 - anything can be raised by code of one's own
        trace = own.raised(error)
    return loop.driven(trace)


@dataclass
class _Loop:
    """What goes on between the sensors and the wheels."""

    run: Simulation
    path: Path
    condition: Condition
    pace: SpeedTracker
    pedals: PedalMap
    random: np.random.Generator

    def __post_init__(self) -> None:
        self.xy = np.column_stack((self.path.x, self.path.y))
        self.push = pedals_on(self.condition.grade, self.pedals)
        self.steer = self.wheels = self.waited = 0.0
        self.times: list[float] = []
        self.faults = 0

    def cycle(self, controller: Any, dt: float) -> None:
        """Sense, decide, move on."""
        condition, random = self.condition, self.random
        x, y, yaw, speed = self.run.state
        # Every draw is made in every cycle, so that all controllers meet the same.
        aside, turned, lost = random.standard_normal(2), random.standard_normal(), random.random()
        x, y = (x, y) + condition.position * aside
        measured = (float(x), float(y), yaw + condition.yaw * turned, speed)
        if condition.path > 0.0:
            fresh = self.told()
            if hasattr(controller, "set_path"):
                controller.set_path(fresh)
        self.waited += dt
        holds = isinstance(controller, controllers.CONTROLLERS)
        start = time.perf_counter()
        if lost >= condition.loss:
            answer = controller.step(*measured, dt if holds else self.waited)
            self.waited = 0.0
        elif holds:
            answer = controller.step_or_hold(math.nan, math.nan, math.nan, math.nan, dt)
        else:
            answer = self.steer
        self.times.append(time.perf_counter() - start)
        self.steer = float(getattr(answer, "steer", answer))
        if not math.isfinite(self.steer):
            raise InputError("steer", self.steer, "finite")
        self.faults += getattr(getattr(answer, "status", None), "level", "") == "fault"
        half = 0.5 * condition.play
        self.wheels = min(max(self.wheels, self.steer - half), self.steer + half)
        drive = self.pace.step(*measured, dt)
        gear = -speed if drive.reverse else speed
        throttle, brake = self.pedals(drive.acceleration, gear)
        up, down = self.push
        self.run.step(self.wheels, min(throttle + up, 1.0), min(brake + down, 1.0), drive.reverse)

    def told(self) -> Path:
        """Give the path as it is told: itself, or with new errors of its waypoints."""
        condition, path = self.condition, self.path
        if condition.path == 0.0:
            return path
        xy = self.xy + condition.path * self.random.standard_normal(self.xy.shape)
        if condition.smoothed:
            xy = _smoothed(xy, path)
        return Path(xy, closed=path.closed, reverse=path.reverse)

    def driven(self, trace: str) -> Driven:
        """Measure what was driven."""
        records, dt = self.run.records(), self.run.settings.dt
        yaw = np.unwrap(records["yaw"])
        lateral = np.diff(yaw) / dt * records["speed"][1:]
        ending = self.run.ending or "stopped"
        if trace:
            ending = f"raised {trace.strip().splitlines()[-1]}"
        return Driven(
            metrics=Metrics.of(self.run),
            wheelbase=self.run.vehicle.wheelbase,
            end_error=abs(float(records["cross_track_error"][-1])) if len(yaw) else math.nan,
            ending=ending,
            steer_rate=rms(np.diff(records["steer"]) / dt),
            lateral_jerk=rms(np.diff(lateral) / dt),
            faults=self.faults / max(len(self.times), 1),
            step_time=float(np.median(self.times)) if self.times else math.nan,
            traceback=trace,
        )


def _smoothed(xy: NDArray[np.float64], path: Path) -> NDArray[np.float64]:
    """Smooth the waypoints of each section by local quadratics.

    A. Savitzky, M. Golay, *Smoothing and Differentiation of Data by Simplified Least Squares
    Procedures*, 1964.
    """
    from scipy.signal import savgol_filter

    ends = [0, *np.flatnonzero(_path_cusps(path)).tolist(), len(xy) - 1]
    for first, last in itertools.pairwise(ends):
        section = slice(first, last + 1)
        xy[section] = savgol_filter(xy[section], _WINDOW, 2, axis=0)
    return xy


def seed_of(*names: str) -> int:
    """Give a seed of names: another for each scenario and condition, whatever else is driven."""
    return zlib.crc32("/".join(names).encode())


def along(grade: float) -> float:
    """Give the acceleration by gravity on a slope [m/s²], negative uphill."""
    return -_GRAVITY * grade / math.hypot(1.0, grade)


def pedals_on(grade: float, pedals: PedalMap) -> tuple[float, float]:
    """Give the throttle and the brake that act as a slope does."""
    push = along(grade)
    return max(push, 0.0) / pedals.drive, max(-push, 0.0) / pedals.braking


def rms(values: np.ndarray[Any, Any]) -> float:
    """Give the root mean square; not a number of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else math.nan
