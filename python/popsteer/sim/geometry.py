"""Plants by name, and the vehicle that each of them is."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias, get_args

from popsteer import plants
from popsteer._core import CarlaIdentified, KinematicBicycle, Path, Vehicle
from popsteer.errors import PathError
from popsteer.plants.protocol import PythonPlant
from popsteer.plants.registry import ASKED
from popsteer.ranges import check_known

CorePlant: TypeAlias = str | CarlaIdentified | KinematicBicycle
"""A plant of the core, which many runs can share: its name, or an object with its parameters."""
Plant: TypeAlias = CorePlant | PythonPlant
"""A plant: its name for the default parameters, or an object with its own."""
Pose: TypeAlias = tuple[float, float, float]
"""Position and heading: x [m], y [m], yaw [rad]."""
StartAt: TypeAlias = Literal["pose", "rear", "front"]
"""Whose pose a start is: that of the vehicle's point, of its rear or of its front axle."""

CORE_PLANTS: dict[str, type[CarlaIdentified | KinematicBicycle]] = {
    "carla-identified": CarlaIdentified,
    "kinematic-bicycle": KinematicBicycle,
}
"""The classes of the plants of the core, by name."""


def plant_names() -> tuple[str, ...]:
    """Names of the plants of the core; `popsteer.plants.names` are those from elsewhere.

    Returns
    -------
    tuple of str
        The names that are known, the identified one first.

    Examples
    --------
    >>> plant_names()
    ('carla-identified', 'kinematic-bicycle')
    """
    return tuple(CORE_PLANTS)


def plant_name(plant: Plant) -> str:
    """Name of a plant.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    str
        One of `plant_names` or of `popsteer.plants.names`; of a plant of your own its `name`.

    Raises
    ------
    ConfigError
        No plant has this name.
    TypeError
        The object is no plant; says what it lacks.

    Examples
    --------
    >>> plant_name(KinematicBicycle())
    'kinematic-bicycle'
    """
    if isinstance(plant, str):
        if not plants.is_known(plant):
            check_known("plant", plant, (*CORE_PLANTS, *plants.names()))
        return plant
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        return next(name for name, kind in CORE_PLANTS.items() if isinstance(plant, kind))
    if lacking := [asked for asked in ASKED if not hasattr(plant, asked)]:
        raise TypeError(
            "plant must be a name or an object of a plant class,"
            f" got {plant!r}, which lacks {', '.join(lacking)}"
        )
    return str(plant.name)


def object_of(plant: Plant) -> CarlaIdentified | KinematicBicycle | PythonPlant:
    """Make a plant of its name, with its default parameters; an object is returned itself."""
    name = plant_name(plant)  # refuses what is no plant
    if not isinstance(plant, str):
        return plant
    return plants.get(name) if plants.is_known(name) else CORE_PLANTS[name]()


def vehicle_of(plant: Plant) -> Vehicle:
    """Tell which vehicle a plant is.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    Vehicle
        Its `vehicle`: what a controller believes unless it is given another.

    Raises
    ------
    ConfigError
        No plant has this name.
    PopsteerError
        It needs an extra that is not installed.

    Examples
    --------
    >>> car = vehicle_of("carla-identified")
    >>> car.wheelbase, car.turning_wheelbase, car.rear_axle
    (3.0, 3.553, -1.94)
    """
    return object_of(plant).vehicle


def pose_of(start: Pose, start_at: StartAt, vehicle: Vehicle) -> Pose:
    """Give the pose of a vehicle's point, from that of one of its axles, (x, y, yaw) [m, m, rad].

    `start_at` says whose `start` is: "pose", "rear" or "front"; raises ConfigError for another.
    """
    offsets = {"pose": 0.0, "rear": vehicle.rear_axle, "front": vehicle.front_axle}
    check_known("start_at", start_at, get_args(StartAt))
    ahead = offsets[start_at]
    x, y, yaw = start
    if ahead == 0.0 or not math.isfinite(yaw):  # what is not finite, the simulation refuses by name
        return x, y, yaw
    return x - ahead * math.cos(yaw), y - ahead * math.sin(yaw), yaw


def check_length(path: Path, car: Vehicle, name: str = "the path") -> None:
    """Refuse a course shorter than its vehicle, PathError: its unit is another, or its vehicle."""
    if path.length < car.wheelbase:
        name = path.source.partition(": ")[0] if path.source else name
        raise PathError(
            f"{name} is {path.length:.3g} m long, and the vehicle {car.wheelbase:g} m from axle to"
            " axle: give the columns' unit, as --columns 'x [km],y [km]' or --columns 'x=NAME"
            " [km],y=NAME [km]', or a vehicle of its size"
        )
