"""One run of a controller on a plant."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer import controllers, own
from popsteer._core import (
    CarlaIdentified,
    Driver,
    KinematicBicycle,
    Noise,
    Path,
    Settings,
    Simulation,
    SpeedPid,
    SpeedPidParams,
    SpeedTracker,
    Vehicle,
    _with_speed,
)
from popsteer.errors import ConfigError, PathError, short
from popsteer.ranges import check_count, check_in_range
from popsteer.sim.geometry import Plant, Pose, StartAt, object_of, pose_of
from popsteer.sim.metrics import Metrics
from popsteer.sim.pedals import Longitudinal, PedalMap, check_longitudinal
from popsteer.sim.steering import OwnController, believed, informed, told, tracked_point

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray


START_OFFSET = 2.44
"""How far to the right of the first waypoint the paper's run started [m]."""

KEEPING = SpeedPidParams(kp=1.0, ki=0.5)
"""A PI law of the pedals, without overshoot also behind a throttle that lags."""
_MAX_SEED = 2**64 - 1


@dataclass(frozen=True, eq=False)
class Run:
    """A run, and what was measured in it.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> result = run(popsteer.Stanley(path))
    >>> result.law, result.dt, len(result.records["steer"]) == result.metrics.steps
    ('stanley', 0.05, True)
    >>> result.vehicle == result.plant_vehicle  # the plant's, as none was given
    True
    """

    law: str
    """Name of the controller, as on the command line; of your own its `name` or its class."""
    plant: str
    """Name of the plant."""
    path: Path
    """What was to be followed."""
    start: Pose
    """Pose of the vehicle's point at the start [m, m, rad]."""
    settings: Settings
    """How the run went."""
    metrics: Metrics
    """The metrics."""
    records: Mapping[str, NDArray[Any]]
    """A column for each quantity, an entry for each step; `Simulation.records` names them."""
    params: Mapping[str, Any]
    """The controller's parameters by name, with those that scale with its vehicle filled in; empty
    for one of your own that has none."""
    vehicle: Vehicle | None
    """What the controller believed of the vehicle; None for one of your own that does not say."""
    plant_vehicle: Vehicle
    """What the plant was."""
    ending: str = ""
    """How it ended; `Simulation.ending` lists the ways."""
    tracked_point: float | None = None
    """Where errors are measured, ahead of the pose's point [m]; None for the front axle."""
    traceback: str = ""
    """What code of your own raised, where that ended the run and `keep_going` was asked for."""

    @property
    def dt(self) -> float:
        """Control period [s]."""
        return self.settings.dt


def default_start(path: Path, offset: float = 0.0, vehicle: Vehicle | None = None) -> Pose:
    """Give the pose that a run starts from by default.

    The front axle is at the first waypoint, or beside it. The vehicle points along the first
    segment. If that segment is driven backwards, the rear axle is there, and the vehicle points
    against it.

    Parameters
    ----------
    path : Path
        The path to follow.
    offset : float, default 0.0
        How far to the left of the first waypoint [m]; negative to the right.
    vehicle : Vehicle, optional
        The vehicle that starts; ``Vehicle()`` by default.

    Returns
    -------
    tuple of float
        Pose of the vehicle's point, (x, y, yaw) [m, m, rad].

    Raises
    ------
    ConfigError
        The offset is not in [-1000, 1000].

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
    >>> default_start(path)
    (-3.0, 0.0, 0.0)
    >>> default_start(path, 1.0, popsteer.Vehicle(rear_axle=-1.5))
    (-1.5, 1.0, 0.0)
    """
    vehicle = Vehicle() if vehicle is None else vehicle
    check_in_range("start_offset", offset, -1e3, 1e3)
    x, y = float(path.x[0]), float(path.y[0])
    yaw = math.atan2(float(path.y[1]) - y, float(path.x[1]) - x)
    x, y = x - offset * math.sin(yaw), y + offset * math.cos(yaw)
    if _starts_backwards(path):
        return pose_of((x, y, math.remainder(yaw + math.pi, math.tau)), "rear", vehicle)
    return pose_of((x, y, yaw), "front", vehicle)


def at_constant_speed(path: Path, speed: float) -> tuple[Path, SpeedPid]:
    """Give the path with a constant reference speed [m/s], and a PI controller of the pedals.

    The PI controller has kp = 1 s/m, ki = 0.5 /m on the difference of the speeds, its integral
    bounded to full pedals. Where the path is driven backwards, it still is. Raises ConfigError
    where the speed is not in [0, 100].
    """
    check_in_range("constant_speed", speed, 0.0, 100.0)
    return _driven_at(path, np.full(len(path), float(speed))), SpeedPid(KEEPING)


def with_speeds(path: Path, longitudinal: Longitudinal | None, vehicle: Vehicle) -> Path:
    """Give the path with speeds for a `SpeedPid`: its own, or those that a `SpeedTracker` plans."""
    if not isinstance(longitudinal, SpeedPid) or path.speed is not None:
        return path
    return _driven_at(path, SpeedTracker(path, vehicle).plan)


def _driven_at(path: Path, speeds: NDArray[np.float64]) -> Path:
    """Give the path with these speeds, negative where it is driven backwards."""
    backwards = path.reverse
    return _with_speed(path, speeds if backwards is None else np.where(backwards, -speeds, speeds))


def run(  # noqa: PLR0913 - each is one thing that may differ
    controller: controllers.Controller | OwnController,
    plant: Plant = "carla-identified",
    *,
    path: Path | None = None,
    start: Pose | None = None,
    start_at: StartAt = "pose",
    speed: float | None = None,
    constant_speed: float | None = None,
    longitudinal: Longitudinal | None = None,
    pedals: PedalMap | None = None,
    settings: Settings | None = None,
    noise: Noise | None = None,
    seed: int = 0,
    progress: Callable[[float], object] | None = None,
    keep_going: bool = False,
) -> Run:
    """Let a controller drive a plant along a path, until its end or until the run has failed.

    What the plant is and what the controller believes are two vehicles: a controller that was given
    none takes the plant's.

    Parameters
    ----------
    controller : Pop or PreviewPop or Pid or PurePursuit or Stanley or Driver, or one of your own
        What steers. A controller of popsteer drives in the core, from a fresh state. From one, too,
        a copy of a `popsteer.Driver` drives, which works the pedals besides. Your own has a
        method ``step(x, y, yaw, speed, dt)`` that returns the angle [rad], or an object that has it
        as `steer`; see `OwnSimpleController` for what else it may have. It is called in the state
        that it is in, and what it raises reaches you.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default "carla-identified"
        What moves; `popsteer.plants` has those from elsewhere.
    path : Path, optional
        What is followed; the controller's by default.
    start : tuple of float, optional
        Pose at the start, (x, y, yaw) [m, m, rad]; `default_start` by default.
    start_at : {"pose", "rear", "front"}, default "pose"
        Whose pose `start` is: that of the vehicle's point, of its rear or of its front axle.
    speed : float, optional
        Speed at the start [m/s]; by default `constant_speed` in the direction of the path, and 0
        where there is none.
    constant_speed : float, optional
        Speed to be kept throughout [m/s]: a PI controller works the pedals, and the path's
        reference speeds give the direction alone.
    longitudinal : CoupledLongitudinal or SpeedPid or SpeedTracker, optional
        What works the pedals, from a fresh state; the paper's coupled controller by default. A
        `SpeedTracker` of the same path chooses the gear, too. Where the path has no speeds,
        `SpeedPid` keeps those that a `SpeedTracker` plans for the controller's vehicle.
    pedals : PedalMap, optional
        Which pedals give the accelerations of a `SpeedTracker`; those of the plant by default.
    settings : Settings, optional
        Control period, limits and the like.
    noise : Noise, optional
        Noise of the pose and the speed that the controllers of steering and pedals are given; none
        by default. Records and metrics are without it.
    seed : int, default 0
        Where the noise comes from, 0 to 2**64 - 1; the same seed gives the same bits.
    progress : callable, optional
        Called now and then with the share of the path done, 0 to 1.
    keep_going : bool, default False
        Whether an exception from a controller or a plant of your own ends the run, which then has
        its `traceback`, instead of reaching you.

    Returns
    -------
    Run
        The records and the metrics.

    Raises
    ------
    ConfigError
        The plant is not known, both `constant_speed` and `longitudinal` are given, the controller's
        vehicle or that of a `SpeedTracker` has its rear axle elsewhere than the plant's, or a
        `SpeedTracker` has planned another path.
    InputError
        The start, or an angle from your controller, is not finite or beyond its bound, the plant
        cannot start at this speed, or a plant without `drive`, `braking` and `drag` is to be driven
        by a `SpeedTracker` without `pedals`.
    PopsteerError
        The plant needs an extra that is not installed.
    PathError
        The path is driven backwards in places and the plant does not reverse.
    TypeError
        Your controller carries no path and none is given, or `step` returns no angle.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> run(popsteer.Pop(path)).metrics.finished
    True

    With speeds that are planned within a vehicle's limits, and kept:

    >>> car = popsteer.vehicles.get("carla-identified").replace(max_speed=8.0)
    >>> tracker = popsteer.SpeedTracker(path, car)
    >>> result = run(popsteer.Pop(path), longitudinal=tracker)
    >>> bool(result.records["speed"].max() < 8.1)
    True

    A car that turns less than its controller believes:

    >>> car = popsteer.Vehicle(wheelbase=2.7)
    >>> heavy = popsteer.sim.KinematicBicycle(car.replace(understeer=0.01))
    >>> run(popsteer.Pop(path, car), heavy).metrics.finished
    True

    The whole vehicle by one driver:

    >>> driver = popsteer.Driver(path, car)
    >>> run(driver, popsteer.sim.KinematicBicycle(car)).metrics.finished
    True

    A controller of your own:

    >>> class TowardsZero:
    ...     def step(self, x, y, yaw, speed, dt):
    ...         return max(-0.5, min(0.5, -0.2 * y - yaw))
    >>> result = run(TowardsZero(), path=path)
    >>> result.law, bool(abs(result.records["y"][-1]) < 0.05)
    ('TowardsZero', True)
    """
    path = path if path is not None else told(controller, "path", Path)
    if path is None:
        raise TypeError("the controller carries no path: give one as path=...")
    given = path
    if constant_speed is not None:
        if longitudinal is not None:
            raise ConfigError("constant_speed", constant_speed, "None where longitudinal is given")
        path, longitudinal = at_constant_speed(path, constant_speed)
    if pedals is not None and not isinstance(longitudinal, SpeedTracker):
        raise ConfigError("pedals", pedals, "None where longitudinal is no SpeedTracker")
    check_seed(seed)
    plant = object_of(plant)  # refuses an unknown one before anything is asked of it
    vehicle = plant.vehicle
    controller = informed(controller, vehicle)
    if isinstance(controller, Driver):
        controller = _fresh(controller, path, plant, longitudinal)
    path = with_speeds(path, longitudinal, believed(controller) or vehicle)
    check_longitudinal(longitudinal, path, vehicle)
    if start is None:
        start = default_start(path, vehicle=vehicle)
    else:
        start = pose_of(start, start_at, vehicle)
    begun = start_speed(path, constant_speed, plant) if speed is None else speed
    tracked = tracked_point(controller)
    simulation = Simulation(
        path, plant, start=start, speed=begun, tracked_point=tracked, settings=settings
    )
    drive = partial(
        simulation.drive, controller, longitudinal, progress, noise=noise, seed=seed, pedals=pedals
    )
    in_core = isinstance(plant, CarlaIdentified | KinematicBicycle)
    in_core = in_core and isinstance(controller, controllers.CONTROLLERS)
    ending, trace = _raised(drive, goes_on=keep_going and not in_core)
    return Run(
        law=_name(controller),
        plant=simulation.plant,
        path=given,
        start=start,
        settings=simulation.settings,
        metrics=Metrics.of(simulation),
        records=simulation.records(),
        params=_params(controller),
        vehicle=believed(controller),
        plant_vehicle=vehicle,
        ending=ending or simulation.ending or "stopped",
        tracked_point=tracked,
        traceback=trace,
    )


def _fresh(driver: Driver, path: Path, plant: Plant, longitudinal: Longitudinal | None) -> Driver:
    """Give a driver before its first step on a path, for a plant whose pedals are known."""
    if longitudinal is not None:
        raise ConfigError("longitudinal", longitudinal, "None: a Driver works the pedals itself")
    if not PedalMap.is_known(plant):
        raise ConfigError("plant", plant, "one with drive, braking and drag, for a Driver's pedals")
    driver = copy(driver)
    driver.reset()
    if driver.path is not path:
        driver.set_path(path)
    return driver


def _raised(drive: Callable[[], object], *, goes_on: bool) -> tuple[str, str]:
    """Drive; give how what code of the user's own raised ended it, and its traceback."""
    try:
        drive()
    except (ConfigError, PathError):
        raise
    except Exception as error:
        if not goes_on:
            raise
        said = short(" ".join(f"raised {type(error).__name__}: {error}".split()))
        return said, own.raised(error)
    return "", ""


def start_speed(path: Path, constant_speed: float | None, plant: object) -> float:
    """Give the speed that a run starts with [m/s], signed as the path: the constant one, or none.

    A plant that cannot start from rest has a `least_speed` [m/s].
    """
    least = float(getattr(plant, "least_speed", 0.0))
    speed = least if constant_speed is None else constant_speed
    return -speed if _starts_backwards(path) else speed


def check_seed(seed: int) -> None:
    """Refuse by ConfigError a seed that the generator does not take."""
    check_count("seed", seed, 0, _MAX_SEED)


def _starts_backwards(path: Path) -> bool:
    return path.reverse is not None and bool(path.reverse[0])


def _name(controller: controllers.Controller | OwnController) -> str:
    if isinstance(controller, controllers.CONTROLLERS):
        return controllers.name_of(type(controller))
    return told(controller, "name", str) or type(controller).__name__


def _params(controller: controllers.Controller | OwnController) -> dict[str, Any]:
    """Give the parameters of a controller, with those that scale with its vehicle filled in."""
    params = told(controller, "params", object)
    vehicle = believed(controller)
    if isinstance(params, type) or not callable(told(params, "as_dict", object)):
        return {}  # an attribute of one's own that has this name
    if vehicle is not None and hasattr(params, "resolved"):
        params = params.resolved(vehicle)
    return dict(params.as_dict())
