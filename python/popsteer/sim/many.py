"""Many runs in one call, on all cores."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from popsteer import _core, controllers
from popsteer._core import CarlaIdentified, KinematicBicycle, Noise, Settings, Vehicle
from popsteer.errors import ConfigError
from popsteer.ranges import check_count
from popsteer.sim.closed_loop import check_seed, default_start
from popsteer.sim.geometry import (
    CorePlant,
    Pose,
    StartAt,
    plant_name,
    plant_names,
    pose_of,
    vehicle_of,
)
from popsteer.sim.pedals import Longitudinal, PedalMap, check_longitudinal
from popsteer.sim.steering import informed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike, NDArray

    _Driver = tuple[controllers.Controller, Vehicle, Pose]

_PLANTS = (str, CarlaIdentified, KinematicBicycle)
_MAX_THREADS = 1024


def run_many(  # noqa: PLR0913 - each is one thing that may vary
    controller: controllers.Controller | Sequence[controllers.Controller],
    plant: CorePlant | Sequence[CorePlant] = "carla-identified",
    *,
    start: ArrayLike | None = None,
    start_at: StartAt = "pose",
    speed: ArrayLike = 0.0,
    longitudinal: Longitudinal | Sequence[Longitudinal | None] | None = None,
    pedals: PedalMap | None = None,
    settings: Settings | None = None,
    noise: Noise | Sequence[Noise] | None = None,
    seed: int | Sequence[int] = 0,
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> dict[str, NDArray[Any]]:
    """Let controllers drive plants along paths, many runs at once; return the metrics of each.

    Each run equals that of `run`, bit for bit; with noise, if each run has a seed of its own. Each
    of `controller`, `plant`, `start`, `speed`, `longitudinal`, `noise` and `seed` is one value for
    all runs or a sequence with one for each run. Ctrl-C, or an error that `progress` raises, stops
    all runs within a control step.

    Parameters
    ----------
    controller : Pop or PreviewPop or Pid or PurePursuit or Stanley, or a sequence
        What steers, along its own path, from a fresh state; one that was given no vehicle takes the
        plant's.
    plant : str or CarlaIdentified or KinematicBicycle or a sequence, default "carla-identified"
        What moves.
    start : array of shape (3,) or (N, 3), optional
        Pose at the start, (x, y, yaw) [m, m, rad]; `default_start` by default.
    start_at : {"pose", "rear", "front"}, default "pose"
        Whose pose `start` is: that of the vehicle's point, of its rear or of its front axle.
    speed : float or array of shape (N,), default 0.0
        Speed at the start [m/s].
    longitudinal : CoupledLongitudinal or SpeedPid or SpeedTracker, or a sequence, optional
        What works the pedals, from a fresh state; the paper's coupled controller by default.
    pedals : PedalMap, optional
        Which pedals give the accelerations of a `SpeedTracker`; those of each plant by default.
    settings : Settings, optional
        Control period, limits and the like; no records are kept in any case.
    noise : Noise or sequence of Noise, optional
        Noise of pose and speed as the controllers get them; none by default.
    seed : int or sequence of int, default 0
        Where the noise comes from, 0 to 2**64 - 1. With one seed for all, run k draws from stream
        k; with a seed of its own, a run draws as `run` does. The same seeds give the same bits on
        any number of threads.
    threads : int, optional
        How many threads drive, 1 to 1024; by default one a core, or what the environment variable
        RAYON_NUM_THREADS says.
    progress : callable, optional
        Called some fifty times a second with the share of the runs done, and at last with 1.

    Returns
    -------
    dict of str to ndarray of shape (N,)
        An array for each field of `Metrics`, under its name, with an entry for each run; `faults`
        are the bits of `popsteer.Status`.

    Raises
    ------
    ConfigError
        A plant is not known, a number is out of its range, the sequences differ in length, a
        controller's vehicle has its rear axle elsewhere than the plant's, or a `SpeedTracker` has
        planned another path than the controller's.
    InputError
        A start is not finite or beyond its bound; it is named with its run, as ``speed[3]``.
    PathError
        `SpeedPid` is to follow the reference speeds of a path that has none, or a path is driven
        backwards in places and the plant does not reverse.
    TypeError
        A controller is none of popsteer's, or a plant none of the core's; `run` drives those.

    Examples
    --------
    A hundred runs of a POP whose position has 0.1 m of noise:

    >>> import popsteer
    >>> from popsteer.sim import Noise
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> runs = run_many([popsteer.Pop(path)] * 100, noise=Noise(position=0.1), seed=7)
    >>> runs["finished"].all(), runs["settled_mean_abs_cross_track_error"].shape
    (np.True_, (100,))

    Starts farther and farther off:

    >>> runs = run_many(popsteer.Pop(path), start=[(0.0, y, 0.0) for y in (0.5, 1.0, 2.0)])
    >>> runs["max_abs_cross_track_error"]
    array([0.5, 1. , 2. ])
    """
    starts = None if start is None else _floats("start", start, (3,))
    speeds = _floats("speed", speed, ())
    several: dict[str, Any] = {
        "controller": None if isinstance(controller, controllers.CONTROLLERS) else list(controller),
        # A name is a sequence too, of letters.
        "plant": None if isinstance(plant, _PLANTS) else list(plant),
        "start": starts if starts is not None and starts.ndim == 2 else None,
        "speed": speeds if speeds.ndim == 1 else None,
        "longitudinal": list(longitudinal) if isinstance(longitudinal, (list, tuple)) else None,
        "noise": None if noise is None or isinstance(noise, Noise) else list(noise),
        "seed": None if np.ndim(seed) == 0 else list(map(int, cast("Sequence[int]", seed))),
    }
    count = _common_length(several)

    def each(name: str, one: object) -> list[Any]:
        """Give what there is for each run, or what is for all as often as there are runs."""
        return [one] * count if several[name] is None else several[name]

    seeds = each("seed", seed)
    for given in seeds:
        check_seed(given)
    if threads is not None:
        check_count("threads", threads, 1, _MAX_THREADS)

    each_plant, each_drive = each("plant", plant), each("longitudinal", longitudinal)
    drivers = _drivers(each("controller", controller), each_plant, each_drive)
    poses = _poses(starts, start_at, drivers)
    states = np.column_stack([np.reshape(poses, (count, 3)), np.broadcast_to(speeds, count)])
    # Of one seed for all, each run has a stream of its own.
    streams = zip(seeds, range(count) if several["seed"] is None else [0] * count, strict=True)
    return _core.run_many(
        [
            (itself, moved, state, (through, *stream), drive)
            for (itself, _, _), moved, state, through, stream, drive in zip(
                *(drivers, each_plant, states.tolist(), each("noise", noise), streams, each_drive),
                strict=True,
            )
        ],
        pedals=pedals,
        settings=settings,
        threads=threads,
        progress=progress,
    )


def _floats(name: str, value: ArrayLike, one: tuple[int, ...]) -> NDArray[Any]:
    """Give `value` as an array of floats of the shape of `one` run, or of any number of them."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ConfigError(name, value, "numbers") from error
    if one not in (array.shape, array.shape[1:]):
        several = str((None, *one)).replace("None", "N")
        raise ConfigError(name, array.shape, f"of shape {one} or {several}")
    return array


def _common_length(several: dict[str, Any]) -> int:
    """Tell how many runs the sequences are for; one where there is no sequence."""
    lengths = {name: len(each) for name, each in several.items() if each is not None}
    if len(set(lengths.values())) > 1:
        names = ", ".join(lengths)
        raise ConfigError(names, tuple(lengths.values()), "single or of one length")
    return next(iter(lengths.values()), 1)


def _drivers(*each: list[Any]) -> list[_Driver]:
    """Prepare controllers for plants and pedals; what is the same for several runs, once."""
    known: dict[tuple[int, ...], _Driver] = {}
    drivers = []
    for index, own in enumerate(zip(*each, strict=True)):
        key = tuple(map(id, own))  # it stays, as the lists hold the objects
        if key not in known:
            known[key] = _prepared(index, *own)
        drivers.append(known[key])
    return drivers


def _poses(starts: NDArray[Any] | None, start_at: StartAt, drivers: list[_Driver]) -> list[Pose]:
    """Give the poses of the vehicles' points at the start: those given, or by default."""
    if starts is None:
        return [begin for _, _, begin in drivers]
    given = np.broadcast_to(starts, (len(drivers), 3)).tolist()
    return [
        pose_of(tuple(pose), start_at, vehicle)
        for pose, (_, vehicle, _) in zip(given, drivers, strict=True)
    ]


def _prepared(
    index: int, controller: object, plant: CorePlant, longitudinal: Longitudinal | None
) -> _Driver:
    """Give the controller with its vehicle, the plant's, and where it starts by default."""
    if not isinstance(controller, controllers.CONTROLLERS):
        kind = type(controller).__name__
        raise TypeError(f"controller {index} must be one of popsteer, got {kind}; see run")
    if (name := plant_name(plant)) not in plant_names():
        raise TypeError(f"plant {index}, {name}, is none of the core's; see run")
    vehicle = vehicle_of(plant)
    made = informed(controller, vehicle)
    check_longitudinal(longitudinal, made.path, vehicle, f" of controller {index}")
    return made, vehicle, default_start(made.path, vehicle=vehicle)
