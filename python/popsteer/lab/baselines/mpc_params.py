"""Parameters of the model-predictive controller; they need no solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from popsteer.parameters import Parameters

if TYPE_CHECKING:
    from popsteer._core import Vehicle


@dataclass(frozen=True)
class MpcParams(Parameters):
    """Weights and horizon of `Mpc`: its tuning; what is true of the car is its vehicle's.

    Parameters
    ----------
    cross_track_weight : float, optional
        Weight of the squared cross-track error [1/m²]; by default (3 / wheelbase)².
    heading_weight : float, default 10.0
        Weight of the squared heading error.
    steer_weight : float, default 0.0
        Weight of the squared difference between the angle and that of the path's curvature.
    change_weight : float, default 10.0
        Weight of the squared change of the angle from stage to stage.
    last_weight : float, default 10.0
        Factor on the weights of the errors of the last stage.
    stages : int, default 20
        Stages of the horizon.
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
    >>> import popsteer
    >>> MpcParams(stages=40).resolved(popsteer.Vehicle(wheelbase=1.5)).cross_track_weight
    4.0
    """

    RANGES: ClassVar = {
        "cross_track_weight": (1e-9, 1e9),
        "heading_weight": (0.0, 1e9),
        "steer_weight": (0.0, 1e9),
        "change_weight": (1e-9, 1e9),
        "last_weight": (1.0, 1e9),
        "stages": (2, 1000),
        "stage_time": (1e-3, 1.0),
        "tolerance": (1e-9, 1e-1),
    }

    cross_track_weight: float | None = None
    heading_weight: float = 10.0
    steer_weight: float = 0.0
    change_weight: float = 10.0
    last_weight: float = 10.0
    stages: int = 20
    stage_time: float = 0.05
    tolerance: float = 1e-4

    def resolved(self, vehicle: Vehicle) -> MpcParams:
        """Fill in what scales with the vehicle that is steered."""
        if self.cross_track_weight is not None:
            return self
        return self.replace(cross_track_weight=(3.0 / vehicle.wheelbase) ** 2)
