"""Parameters of the model-predictive controller; they need no solver."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import TYPE_CHECKING, Any, ClassVar

from popsteer.parameters import Parameters
from popsteer.sim.geometry import geometry, steering_limits, steering_model

if TYPE_CHECKING:
    from popsteer.sim.geometry import Plant

__all__ = ["MpcParams"]


@dataclass(frozen=True)
class MpcParams(Parameters):
    """Vehicle, weights and limits of `Mpc`.

    Parameters
    ----------
    wheelbase : float, default 3.0
        Distance of the axles [m].
    understeer : float, default 0.0
        Understeer coefficient [s^2/m].
    lag : float, default 0.1
        Time constant of the yaw rate behind the command [s].
    reference_offset : float, default 0.0
        Point whose cross-track error counts, ahead of that whose pose is given [m].
    max_steer : float, default 1.22
        Largest angle [rad].
    max_steer_rate : float, default radians(60)
        Largest rate [rad/s]; that of POP's neighbourhood in 50 ms.
    cross_track_weight : float, default 1.0
        Of the squared cross-track error [1/m^2].
    heading_weight : float, default 10.0
        Of the squared heading error.
    steer_weight : float, default 0.0
        Of the square of the angle less that which follows the path's curvature.
    change_weight : float, default 10.0
        Of the squared change of the angle from stage to stage.
    last_weight : float, default 10.0
        How often the errors of the last stage count.
    stages : int, default 20
        Length of the horizon.
    stage_time : float, default 0.05
        Length of a stage [s].
    tolerance : float, default 1e-4
        osqp's eps_abs and eps_rel.

    Raises
    ------
    ConfigError
        A number is not in its range.

    Examples
    --------
    >>> MpcParams.for_plant("carla-identified").understeer
    0.00029
    """

    RANGES: ClassVar = {
        "wheelbase": (1e-2, 100.0),
        "understeer": (0.0, 1.0),
        "lag": (0.0, 10.0),
        "reference_offset": (-100.0, 100.0),
        "max_steer": (1e-3, 1.5),
        "max_steer_rate": (1e-3, 1e3),
        "cross_track_weight": (1e-9, 1e9),
        "heading_weight": (0.0, 1e9),
        "steer_weight": (0.0, 1e9),
        "change_weight": (1e-9, 1e9),
        "last_weight": (1.0, 1e9),
        "stages": (2, 1000),
        "stage_time": (1e-3, 1.0),
        "tolerance": (1e-9, 1e-1),
    }

    wheelbase: float = 3.0
    understeer: float = 0.0
    lag: float = 0.1
    reference_offset: float = 0.0
    max_steer: float = 1.22
    max_steer_rate: float = radians(60.0)
    cross_track_weight: float = 1.0
    heading_weight: float = 10.0
    steer_weight: float = 0.0
    change_weight: float = 10.0
    last_weight: float = 10.0
    stages: int = 20
    stage_time: float = 0.05
    tolerance: float = 1e-4

    @classmethod
    def for_plant(cls, plant: Plant) -> MpcParams:
        """Give the defaults with the vehicle of a plant.

        Parameters
        ----------
        plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
            The plant that is to be steered.

        Returns
        -------
        MpcParams
            Its `steering_model` and the limits of its steering, and its front axle for the
            reference point.

        Raises
        ------
        ConfigError
            No plant has this name.
        """
        model = steering_model(plant)
        limits: dict[str, Any] = {**steering_limits(plant)}
        return cls(
            wheelbase=model.wheelbase,
            understeer=model.understeer,
            lag=model.steer_lag,
            reference_offset=geometry(plant).front_offset,
            **limits,
        )
