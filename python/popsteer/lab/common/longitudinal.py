"""Who works the pedals in an experiment, by name."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TypeAlias

from popsteer._core import (
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    Path,
    SpeedPid,
    SpeedPidParams,
    SpeedTracker,
    SpeedTrackerParams,
    Vehicle,
)
from popsteer.ranges import check_known
from popsteer.sim.closed_loop import start_speed
from popsteer.sim.geometry import Plant, Pose, object_of, vehicle_of
from popsteer.sim.pedals import Longitudinal, PedalMap

LongitudinalParams: TypeAlias = CoupledLongitudinalParams | SpeedPidParams | SpeedTrackerParams
"""Parameters of a longitudinal controller, of one class each."""
KINDS: dict[str, type[LongitudinalParams]] = {
    "coupled": CoupledLongitudinalParams,
    "speed-pid": SpeedPidParams,
    "speed-tracker": SpeedTrackerParams,
}
"""The parameters of each longitudinal controller by its name."""


def params_of(name: str) -> LongitudinalParams:
    """Give the default parameters of a longitudinal controller, one of `KINDS`."""
    check_known("longitudinal controller", name, KINDS)
    return KINDS[name]()


def name_of(params: LongitudinalParams) -> str:
    """Give the name of the longitudinal controller that has these parameters."""
    return next(name for name, kind in KINDS.items() if isinstance(params, kind))


def usual(plants: Iterable[Plant]) -> LongitudinalParams:
    """Give what works the pedals where nothing is said: a `SpeedTracker`.

    It plans within the limits of the vehicle and the speeds of the waypoints. Where a plant does
    not say what its pedals do, as `PedalMap.of` needs it, a `SpeedPid` keeps the speeds of the
    waypoints, and without any those of such a plan.
    """
    return SpeedTrackerParams() if all(map(PedalMap.is_known, plants)) else SpeedPidParams()


def made(params: LongitudinalParams | None, path: Path, vehicle: Vehicle) -> Longitudinal | None:
    """Make the longitudinal controller of a run; without parameters None, for the paper's."""
    if params is None:
        return None
    if isinstance(params, SpeedTrackerParams):
        return SpeedTracker(path, vehicle, params)
    return SpeedPid(params) if isinstance(params, SpeedPidParams) else CoupledLongitudinal(params)


def beginning(
    start: Pose,
    path: Path,
    plant: Plant,
    speed: float | None,
    constant_speed: float | None,
    longitudinal: Longitudinal | None,
    drawn: Mapping[str, object] | None = None,
) -> str:
    """Say in one line where a run of `plant` starts, the pose, and how it then drives.

    `drawn` are the distributions of what of the start differs from run to run, by name.
    """
    said = {name: f"{name} {each}" for name, each in (drawn or {}).items()}
    whole, car = object_of(plant), vehicle_of(plant)
    axle, ahead = "front", car.front_axle
    if path.reverse is not None and path.reverse[0]:
        axle, ahead = "rear", car.rear_axle
    x, y, yaw = start
    at = path.project(x + ahead * math.cos(yaw), y + ahead * math.sin(yaw))
    aside, arc = at.cross_track_error, at.arc_length
    left = "left" if aside > 0.0 else "right"
    side = f"{abs(aside):.2f} m {left} of the path" if abs(aside) > 5e-3 else "on the path"
    if "start_offset" in said:
        side = f"left of the path by {said['start_offset']} m"
    first = "at" if side == "on the path" else "beside"
    place = f"{arc:.1f} m along it" if arc > 0.05 else f"{first} its first waypoint"
    if "start_yaw" in said:
        place += f", turned by {said['start_yaw']} rad"
    begun = start_speed(path, constant_speed, whole) if speed is None else speed
    pace = said.get("start_speed", f"{begun:g}")
    least = " (this plant cannot start from rest)" if getattr(whole, "least_speed", 0.0) else ""
    if constant_speed is not None:
        then = f"{constant_speed:g} m/s are kept"
    elif isinstance(longitudinal, SpeedTracker):
        own = "" if path.speed is None else " and the speeds of the waypoints"
        then = f"speed-tracker keeps the speeds that the vehicle's limits{own} allow"
    elif isinstance(longitudinal, SpeedPid):
        whose = "that are planned within the vehicle's limits"
        then = f"speed-pid keeps the speeds {whose if path.speed is None else 'of the waypoints'}"
    else:
        given = CoupledLongitudinalParams() if longitudinal is None else longitudinal.params
        then = f"the paper's pedals (coupled) drive towards {given.speed_limit:.4g} m/s"
        then += "" if path.speed is None else ", not the speeds of the waypoints"
    return f"Starts with the {axle} axle {side}, {place}, at {pace} m/s{least}; {then}."
