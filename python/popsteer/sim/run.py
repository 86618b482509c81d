"""One law, one plant, one path, from the start to the end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from popsteer import laws
from popsteer._core import Path, Settings, Simulation, SpeedPid, SpeedPidParams
from popsteer.errors import ConfigError, PathError, in_range
from popsteer.parameters import Parameters
from popsteer.ranges import check_in_range
from popsteer.sim.geometry import Plant, geometry, made, with_offset
from popsteer.sim.metrics import Metrics
from popsteer.sim.steering import drive

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from popsteer._core import Actuator, CoupledLongitudinal
    from popsteer.sim.steering import OwnLaw

__all__ = ["START_OFFSET", "Pose", "Run", "at_constant_speed", "default_start", "run"]

START_OFFSET = 2.44
"""How far to the right of the first waypoint a run starts [m]: as the paper's did."""

_KEEPING = SpeedPidParams(kp=1.0, ki=0.5)  # without overshoot also behind a throttle that lags

Pose: TypeAlias = tuple[float, float, float]
"""Position and heading: x [m], y [m], yaw [rad]."""


@dataclass(frozen=True, eq=False)
class Run:
    """What a run was, and what was measured.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    >>> result = run(popsteer.Stanley(path))
    >>> result.law, result.dt, len(result.records["steer"]) == result.metrics.steps
    ('stanley', 0.05, True)
    """

    law: str
    """Name of the law, as on the command line; of one's own law its `name` or its class."""
    plant: str
    """Name of the plant."""
    path: Path
    """What was to be followed."""
    start: Pose
    """Pose of the front axle at the start [m, m, rad]."""
    settings: Settings
    """How the run went."""
    metrics: Metrics
    """What it came to."""
    records: Mapping[str, NDArray[Any]]
    """A column for each quantity, an entry for each step; `Simulation.records` names them."""
    params: Mapping[str, Any]
    """The law's parameters by name; empty for a law of one's own that has none."""
    ending: str = ""
    """How it ended; `Simulation.ending` lists the ways."""

    @property
    def dt(self) -> float:
        """Control period.

        Returns
        -------
        float
            In [s].
        """
        return self.settings.dt


def default_start(path: Path, offset: float = -START_OFFSET) -> Pose:
    """Give the pose that a run starts from unless told otherwise.

    The front axle stands beside the first waypoint and looks along the first segment; by default
    `START_OFFSET` to the right, as in the paper's run.

    Parameters
    ----------
    path : Path
        The path to follow.
    offset : float, default -2.44
        How far to the left of the first waypoint [m]; negative to the right.

    Returns
    -------
    tuple of float
        Pose of the front axle, (x, y, yaw) [m, m, rad].

    Raises
    ------
    ConfigError
        The offset is not in [-1000, 1000].

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0)])
    >>> default_start(path), default_start(path, 1.0)
    ((0.0, -2.44, 0.0), (0.0, 1.0, 0.0))
    """
    check_in_range("start_offset", offset, -1e3, 1e3)
    x, y = float(path.x[0]), float(path.y[0])
    yaw = math.atan2(float(path.y[1]) - y, float(path.x[1]) - x)
    return x - offset * math.sin(yaw), y + offset * math.cos(yaw), yaw


def at_constant_speed(path: Path, speed: float) -> tuple[Path, SpeedPid]:
    """Give what keeps a speed: the path with that reference speed, and a PI law for the pedals.

    The PI law has kp = 1 s/m, ki = 0.5 /m on the difference of the speeds, its integral bounded to
    full pedals.

    Parameters
    ----------
    path : Path
        What is followed.
    speed : float
        Speed to keep [m/s].

    Returns
    -------
    tuple
        The same path with other reference speeds, and the law of the pedals.

    Raises
    ------
    ConfigError
        The speed is not in [0, 100].

    Examples
    --------
    >>> import popsteer
    >>> path, pedals = at_constant_speed(popsteer.Path([(0.0, 0.0), (9.0, 0.0)]), 14.0)
    >>> path.speed.tolist()
    [14.0, 14.0]
    """
    if not 0.0 <= speed <= 100.0:  # NaN fails too
        raise ConfigError("constant_speed", speed, in_range(0.0, 100.0))
    xy = np.column_stack((path.x, path.y))
    kept = Path(xy, speed=np.full(len(xy), float(speed)), closed=path.closed)
    return kept, SpeedPid(_KEEPING)


def run(  # noqa: PLR0913 - each is one thing that may differ
    law: laws.Controller | OwnLaw,
    plant: Plant = "carla-identified",
    *,
    path: Path | None = None,
    start: Pose | None = None,
    speed: float | None = None,
    constant_speed: float | None = None,
    longitudinal: CoupledLongitudinal | SpeedPid | None = None,
    settings: Settings | None = None,
    steering: Actuator | None = None,
    progress: Callable[[float], object] | None = None,
) -> Run:
    """Let a law drive a plant along a path until the end, or until there is no hope of it.

    Parameters
    ----------
    law : Pop or PreviewPop or Pid or PurePursuit or Stanley or BangBang, or a law of your own
        What steers. A law of popsteer drives in the core, from a fresh state; where its parameters
        leave `reference_offset` open, it is the plant's axle. Your own has a method
        ``step(x, y, yaw, speed, dt)`` that returns the angle [rad], or an object that has it as
        `steer`; see `OwnLaw` for what else it may have. It is called in the state that it is in,
        and what it raises reaches you.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant, default "carla-identified"
        What moves; `popsteer.plants` has those from elsewhere.
    path : Path, optional
        What is followed; the law's by default.
    start : tuple of float, optional
        Pose of the front axle at the start, (x, y, yaw) [m, m, rad]; `default_start` by default.
    speed : float, optional
        Speed at the start [m/s]; by default `constant_speed`, and 0 where there is none.
    constant_speed : float, optional
        Speed to be kept all the way [m/s]: a PI law works the pedals, and the path's reference
        speeds do not count.
    longitudinal : CoupledLongitudinal or SpeedPid, optional
        What works the pedals; the paper's coupled law by default.
    settings : Settings, optional
        Control period, limits and the like.
    steering : Actuator, optional
        What lies between the commands and the plant's wheels; nothing by default. What a law knows
        of it is the law's own `actuator`.
    progress : callable, optional
        Called now and then with the share of the path done, 0 to 1.

    Returns
    -------
    Run
        The records and what they come to.

    Raises
    ------
    ConfigError
        The plant is not known, or both `constant_speed` and `longitudinal` are given.
    InputError
        The start, or an angle from your law, is not finite or beyond its bound, or the plant cannot
        start at this speed.
    PopsteerError
        The plant needs an extra that is not installed.
    PathError
        `SpeedPid` is to follow the reference speeds of a path that has none.
    TypeError
        Your law carries no path and none is given, or `step` returns no angle.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> run(popsteer.Pop(path)).metrics.finished
    True

    A law of your own:

    >>> class TowardsZero:
    ...     def step(self, x, y, yaw, speed, dt):
    ...         return max(-0.5, min(0.5, -0.2 * y - yaw))
    >>> result = run(TowardsZero(), path=path)
    >>> result.law, bool(abs(result.records["y"][-1]) < 0.05)
    ('TowardsZero', True)
    """
    path = path if path is not None else getattr(law, "path", None)
    if path is None:
        raise TypeError("the law carries no path: give one as path=...")
    given = path
    if constant_speed is not None:
        if longitudinal is not None:
            raise ConfigError("constant_speed", constant_speed, "None where longitudinal is given")
        path, longitudinal = at_constant_speed(path, constant_speed)
        speed = constant_speed if speed is None else speed
    if isinstance(longitudinal, SpeedPid) and path.speed is None:
        raise PathError("the path has no reference speeds for SpeedPid to follow")
    start = default_start(path) if start is None else start
    speed = 0.0 if speed is None else speed
    settings = Settings() if settings is None else settings
    plant = made(plant)  # refuses an unknown one before anything is asked of it
    make = partial(
        Simulation, path, plant, start=start, speed=speed, settings=settings, steering=steering
    )

    if isinstance(law, laws.CONTROLLERS):
        name = laws.name_of(type(law))
        law = with_offset(law, plant)
        params = law.params.as_dict()
        offset = law.reference_offset
        simulation = make(reference_offset=offset)
        simulation.drive(law, longitudinal, progress)
        records = simulation.records()
    else:
        name = str(getattr(law, "name", type(law).__name__))
        own_params = getattr(law, "params", None)
        params = own_params.as_dict() if isinstance(own_params, Parameters) else {}
        offset = getattr(law, "reference_offset", geometry(plant).front_offset)
        simulation = make(reference_offset=offset)
        steps = drive(simulation, law, longitudinal, progress)
        records = simulation.records()
        if settings.keep_records:
            records["target_x"] = np.array([step.target[0] for step in steps], dtype=np.float64)
            records["target_y"] = np.array([step.target[1] for step in steps], dtype=np.float64)
            records["status"] = np.array([step.status for step in steps], dtype=np.uint8)
    return Run(
        law=name,
        plant=simulation.plant,
        path=given,
        start=start,
        settings=settings,
        metrics=Metrics.of(simulation),
        records=records,
        params=params,
        ending=simulation.ending or "stopped",
    )
