"""Where a plant's axles lie, and laws fitted to them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeAlias, TypeVar, cast

from popsteer import laws, plants
from popsteer._core import (
    Actuator,
    CarlaIdentified,
    KinematicBicycle,
    PopParams,
    PreviewPopParams,
)
from popsteer._core import plants as core_plants
from popsteer.errors import ConfigError
from popsteer.plants.protocol import Geometry, PythonPlant

if TYPE_CHECKING:
    from popsteer.laws import Controller, Params

__all__ = [
    "CorePlant",
    "Geometry",
    "Plant",
    "SteeringModel",
    "actuator",
    "fitted",
    "geometry",
    "made",
    "plant_name",
    "plant_names",
    "steering_limits",
    "steering_model",
    "with_offset",
]

CorePlant: TypeAlias = str | CarlaIdentified | KinematicBicycle
"""A plant of the core, which many runs can share: its name, or an object with its parameters."""
Plant: TypeAlias = CorePlant | PythonPlant
"""A plant: its name for the default parameters, or an object with its own."""

_CLASSES: dict[type[CarlaIdentified | KinematicBicycle], str] = {
    CarlaIdentified: "carla-identified",
    KinematicBicycle: "kinematic-bicycle",
}

_P = TypeVar("_P", bound="Params")

FOREIGN_LAG = 0.1
"""Lag of the yaw rate that a plant from elsewhere is taken to have [s]."""


LEARNING_TIME = 10.0
"""Time over which an `actuator` learns [s]: a few bends."""


class SteeringModel(NamedTuple):
    """How a plant answers to the steering: what a law that predicts is to know of it."""

    wheelbase: float
    """Effective wheelbase [m]."""
    understeer: float
    """Understeer [s²/m]: curvature = tan(steer) / (wheelbase + understeer speed²)."""
    steer_lag: float
    """Time constant with which the curvature follows the angle [s]."""


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
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        return _CLASSES[type(plant)]
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


def steering_model(plant: Plant) -> SteeringModel:
    """Tell how a plant answers to the steering, as far as that is known without driving it.

    Of the identified vehicle that is what was identified, of the kinematic bicycle its wheelbase.
    Of plants from elsewhere it is the published wheelbase, no understeer, and a lag of 0.1 s:
    nothing is fitted to them.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    SteeringModel
        Its bicycle model.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> steering_model("carla-identified")
    SteeringModel(wheelbase=3.553, understeer=0.00029, steer_lag=0.1)
    >>> steering_model(KinematicBicycle(wheelbase=2.5))
    SteeringModel(wheelbase=2.5, understeer=0.0, steer_lag=0.0)
    """
    plant = made(plant)
    if isinstance(plant, str):
        plant = {name: kind for kind, name in _CLASSES.items()}[plant_name(plant)]()
    if isinstance(plant, CarlaIdentified):
        return SteeringModel(plant.wheelbase, plant.understeer, plant.yaw_lag)
    if isinstance(plant, KinematicBicycle):
        return SteeringModel(plant.wheelbase, 0.0, 0.0)
    return SteeringModel(geometry(plant).wheelbase, 0.0, FOREIGN_LAG)


def steering_limits(plant: Plant) -> dict[str, float]:
    """Tell how far and how fast the wheels of a plant turn, where it says so.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant; those written in Python may say it.

    Returns
    -------
    dict
        ``max_steer`` [rad] and ``max_steer_rate`` [rad/s], or nothing.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> steering_limits("kinematic-bicycle")
    {}
    """
    turns = getattr(made(plant), "steer_limits", None)
    return {} if turns is None else dict(zip(("max_steer", "max_steer_rate"), turns, strict=True))


def actuator(plant: Plant, dead_time: float = 0.0, max_rate: float | None = None) -> Actuator:
    """Give what predicts a plant for a law: its dead time, and the plant's own answer.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant that is predicted.
    dead_time : float, default 0.0
        Time from a command to its first effect on the wheels [s].
    max_rate : float, optional
        Fastest move of the wheels [rad/s]; no limit by default.

    Returns
    -------
    Actuator
        With the plant's `steering_model`, its lag included; it learns over `LEARNING_TIME`.

    Raises
    ------
    ConfigError
        No plant has this name, or a number is out of its range.

    Examples
    --------
    >>> actuator("carla-identified", 0.2)
    Actuator(dead_time=0.2, lag=0.1, max_rate=None, wheelbase=3.553, understeer=0.00029, \
learning_time=10.0)
    """
    model = steering_model(plant)
    return Actuator(
        dead_time=dead_time,
        lag=model.steer_lag,
        max_rate=max_rate,
        wheelbase=model.wheelbase,
        understeer=model.understeer,
        learning_time=LEARNING_TIME,
    )


def fitted(params: _P, plant: Plant) -> _P:
    """Set a law's reference point and wheelbase to those of a plant.

    Parameters
    ----------
    params : PopParams or PreviewPopParams or PidParams or PurePursuitParams or StanleyParams \
or BangBangParams
        The parameters of a law.
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant that it is to steer.

    Returns
    -------
    same as `params`
        A copy whose `reference_offset` is the law's axle and whose `wheelbase` is the plant's; of
        `PreviewPopParams` one with the plant's `SteeringModel`, about the point that does not slip;
        of `PopParams` with a horizon one with that model at the law's axle.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> import popsteer
    >>> fitted(popsteer.PurePursuitParams(), "carla-identified").reference_offset
    -1.94
    >>> fitted(popsteer.PreviewPopParams(), "carla-identified").wheelbase
    3.553
    """
    at = geometry(plant)
    if isinstance(params, PreviewPopParams):
        model = steering_model(plant)
        return cast("_P", params.replace(reference_offset=0.0, **model._asdict(), **_limits(plant)))
    law = laws.get(laws.name_of(type(params)))
    offset = at.front_offset if law.axle == "front" else at.rear_offset
    if isinstance(params, PopParams) and params.horizon is not None:
        model = steering_model(plant)
        return cast("_P", params.replace(reference_offset=offset, **model._asdict()))
    # `replace` of each class gives that class; through the union the type checker loses it.
    return cast("_P", params.replace(wheelbase=at.wheelbase, reference_offset=offset))


def _limits(plant: Plant) -> dict[str, float]:
    """Limits for a predictive law, as far as a plant written in Python says them."""
    plant = made(plant)
    found = steering_limits(plant)
    grip = getattr(plant, "grip", None)
    if grip is not None:
        # A bend must leave grip for the way back to the path.
        found["max_lateral_acceleration"] = 0.8 * grip
    return found


def with_offset(law: Controller, plant: Plant) -> Controller:
    """Set a law's reference point to the plant's axle where its parameters leave it open.

    Parameters
    ----------
    law : Pop or PreviewPop or Pid or PurePursuit or Stanley or BangBang
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
    params = law.params.replace(reference_offset=offset)
    return controller(law.path, params, actuator=law.actuator)  # type: ignore[arg-type]
