"""What a predictive law is told of the vehicle that it steers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer._core import PopParams
from popsteer.sim.geometry import made, steering_model

if TYPE_CHECKING:
    from popsteer.sim.geometry import Plant

__all__ = ["VehicleModel", "model_of"]

_POP = PopParams()


class VehicleModel(NamedTuple):
    """A bicycle with understeer and lag: r' = (v tan δ / (wheelbase + understeer v²) - r) / lag."""

    wheelbase: float
    """Distance of the axles, or what stands for it in the yaw rate [m]."""
    understeer: float
    """Understeer coefficient [s^2/m]."""
    lag: float
    """Time constant of the yaw rate behind the command [s]."""
    max_steer: float = _POP.max_steer
    """Largest angle of the front wheels [rad]."""
    max_steer_rate: float = _POP.steer_span / 0.05
    """Fastest turn of the front wheels [rad/s]; that of POP's neighbourhood in 50 ms by default."""


def model_of(plant: Plant) -> VehicleModel:
    """Give what may be known of a plant without having driven it.

    That is its `steering_model`, and the limits of its steering where it says them.

    Parameters
    ----------
    plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
        The plant.

    Returns
    -------
    VehicleModel
        Its model.

    Raises
    ------
    ConfigError
        No plant has this name.

    Examples
    --------
    >>> model_of("carla-identified").wheelbase, model_of("kinematic-bicycle").lag
    (3.553, 0.0)
    """
    model = steering_model(plant)
    limits = getattr(made(plant), "steer_limits", ())  # a plant in Python may have them
    return VehicleModel(model.wheelbase, model.understeer, model.steer_lag, *limits)
