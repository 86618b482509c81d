"""Where a plant's axles lie, and laws fitted to them."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias, TypeVar, cast

from popsteer import laws, plants
from popsteer._core import CarlaIdentified, KinematicBicycle
from popsteer._core import plants as core_plants
from popsteer.errors import ConfigError
from popsteer.plants.protocol import Geometry, PythonPlant

if TYPE_CHECKING:
    from popsteer.laws import Controller, Params

__all__ = [
    "CorePlant",
    "Geometry",
    "Plant",
    "fitted",
    "geometry",
    "made",
    "plant_name",
    "plant_names",
    "with_offset",
]

CorePlant: TypeAlias = str | CarlaIdentified | KinematicBicycle
"""A plant of the core, which many runs can share: its name, or an object with its parameters."""
Plant: TypeAlias = CorePlant | PythonPlant
"""A plant: its name for the default parameters, or an object with its own."""

_CLASSES: dict[type[object], str] = {
    CarlaIdentified: "carla-identified",
    KinematicBicycle: "kinematic-bicycle",
}

_P = TypeVar("_P", bound="Params")


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
    return tuple(core_plants())


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
        The object is no plant.

    Examples
    --------
    >>> plant_name(KinematicBicycle())
    'kinematic-bicycle'
    """
    if isinstance(plant, str):
        known = (*plant_names(), *plants.names())
        if plant not in known:
            raise ConfigError.unknown("plant", plant, known)
        return plant
    name = _CLASSES.get(type(plant))
    if name is not None:
        return name
    if isinstance(plant, PythonPlant):
        return plant.name
    raise TypeError(f"plant must be a name or an object of a plant class, got {plant!r}")


def made(plant: Plant) -> Plant:
    """Make a plant from elsewhere of its name; leave all others as they are.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    same as `plant`, or PythonPlant
        What a simulation takes.

    Raises
    ------
    ConfigError
        No plant has this name.
    PopsteerError
        It needs an extra that is not installed.

    Examples
    --------
    >>> made("carla-identified")
    'carla-identified'
    """
    name = plant_name(plant)  # refuses an unknown one
    return plants.get(name) if isinstance(plant, str) and name in plants.names() else plant


def geometry(plant: Plant) -> Geometry:
    """Tell where the axles of a plant lie.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    Geometry
        Its axles.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> geometry("carla-identified")
    Geometry(front_offset=1.06, rear_offset=-1.94, wheelbase=3.0)
    >>> geometry(KinematicBicycle(wheelbase=2.5)).front_offset
    2.5
    """
    if isinstance(plant, KinematicBicycle):
        # Its pose is that of the rear axle, so its axles follow from its one parameter.
        return Geometry(plant.wheelbase, 0.0, plant.wheelbase)
    plant = made(plant)
    if isinstance(plant, PythonPlant):
        return Geometry(*plant.geometry)
    return Geometry(*core_plants()[plant_name(plant)])


def fitted(params: _P, plant: Plant) -> _P:
    """Set a law's reference point and wheelbase to those of a plant.

    Parameters
    ----------
    params : PopParams or PidParams or PurePursuitParams or StanleyParams or BangBangParams
        The parameters of a law.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant that it is to steer.

    Returns
    -------
    same as `params`
        A copy whose `reference_offset` is the law's axle and whose `wheelbase` is the plant's.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> import popsteer
    >>> fitted(popsteer.PurePursuitParams(), "carla-identified").reference_offset
    -1.94
    """
    at = geometry(plant)
    law = laws.get(laws.name_of(type(params)))
    offset = at.front_offset if law.axle == "front" else at.rear_offset
    # `replace` of each class gives that class; through the union the type checker loses it.
    return cast("_P", params.replace(wheelbase=at.wheelbase, reference_offset=offset))


def with_offset(law: Controller, plant: Plant) -> Controller:
    """Set a law's reference point to the plant's axle where its parameters leave it open.

    Parameters
    ----------
    law : Pop or Pid or PurePursuit or Stanley or BangBang
        The law.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant that it is to steer.

    Returns
    -------
    same as `law`
        The law itself where its parameters have a `reference_offset`, else another in a fresh
        state, on the same path.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(0.0, 0.0), (50.0, 0.0)])
    >>> with_offset(popsteer.Stanley(path), "carla-identified").reference_offset
    1.06
    """
    if law.params.reference_offset is not None:
        return law
    offset = fitted(law.params, plant).reference_offset
    controller = laws.get(laws.name_of(type(law))).controller
    # The registry pairs each controller with its parameters; the type checker cannot see that.
    return controller(law.path, law.params.replace(reference_offset=offset))  # type: ignore[arg-type]
