"""A car as its steering loop sees it: its axles, how it turns, its lag and its dead time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar, cast

from popsteer import laws
from popsteer._core import PreviewPopParams
from popsteer.ranges import check_in_range
from popsteer.sim import geometry, steering_model
from popsteer.sim.geometry import SteeringModel

if TYPE_CHECKING:
    from popsteer.laws import Params
    from popsteer.sim import Plant

__all__ = ["Vehicle"]

_P = TypeVar("_P", bound="Params")


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """A car as its steering loop sees it.

    Parameters
    ----------
    wheelbase : float, default 3.0
        Wheelbase L that its turning obeys [m].
    understeer : float, default 0.0
        Understeer gradient K [s²/m]: yaw rate v δ / (L + K v²).
    front_offset : float, optional
        Front axle ahead of the point that does not slip [m]; `wheelbase` by default.
    rear_offset : float, default 0.0
        Rear axle ahead of that point [m]; negative behind it.
    lag : float, default 0.1
        Time constant τ from the commanded angle to the yaw rate [s]; 0 for none.
    dead_time : float, default 0.0
        Time until a command begins to act [s], beyond the holding of the command.

    Raises
    ------
    ConfigError
        A number is out of its range.

    Examples
    --------
    >>> Vehicle(wheelbase=2.7, dead_time=0.1).front_offset
    2.7
    """

    wheelbase: float = 3.0
    understeer: float = 0.0
    front_offset: float | None = None
    rear_offset: float = 0.0
    lag: float = 0.1
    dead_time: float = 0.0

    def __post_init__(self) -> None:
        if self.front_offset is None:
            object.__setattr__(self, "front_offset", self.wheelbase)
        bounds = {
            "wheelbase": (1e-3, 1e3),
            "understeer": (0.0, 1.0),
            "front_offset": (-1e3, 1e3),
            "rear_offset": (-1e3, 1e3),
            "lag": (0.0, 10.0),
            "dead_time": (0.0, 5.0),
        }
        for field, (low, high) in bounds.items():
            check_in_range(field, getattr(self, field), low, high)
        check_in_range("front_offset", self.axle("front") - self.rear_offset, 1e-3, 1e3)

    def axle(self, which: str) -> float:
        """Tell where an axle is.

        Parameters
        ----------
        which : {"front", "rear"}
            The axle.

        Returns
        -------
        float
            How far ahead of the point that does not slip [m].
        """
        front = self.wheelbase if self.front_offset is None else self.front_offset
        return front if which == "front" else self.rear_offset

    @classmethod
    def of(cls, plant: Plant, *, dead_time: float = 0.0) -> Vehicle:
        """Take the figures of a plant.

        Parameters
        ----------
        plant : str or CarlaIdentified or KinematicBicycle
            The plant.
        dead_time : float, default 0.0
            Time until a command begins to act [s]; the plants have none of their own.

        Returns
        -------
        Vehicle
            Its axles, how it turns, and its lag.

        Raises
        ------
        ConfigError
            No plant has this name.

        Examples
        --------
        >>> Vehicle.of("carla-identified").lag
        0.1
        """
        at, model = geometry(plant), steering_model(plant)
        return cls(
            wheelbase=model.wheelbase,
            understeer=model.understeer,
            front_offset=at.front_offset,
            rear_offset=at.rear_offset,
            lag=model.steer_lag,
            dead_time=dead_time,
        )

    def fitted(self, params: _P) -> _P:
        """Give a law this vehicle's axles.

        Parameters
        ----------
        params : any class of parameters
            Parameters of the law.

        Returns
        -------
        same as `params`
            With the distance of the axles as wheelbase, and the law's axle as reference point; of
            `PreviewPopParams` with how the vehicle turns and its lag, about the point that does not
            slip.

        Examples
        --------
        >>> from popsteer import PopParams
        >>> Vehicle(wheelbase=2.5).fitted(PopParams()).reference_offset
        2.5
        """
        if isinstance(params, PreviewPopParams):
            model = SteeringModel(self.wheelbase, self.understeer, self.lag)
            return cast("_P", params.replace(reference_offset=0.0, **model._asdict()))
        law = laws.get(laws.name_of(type(params)))
        fitted = params.replace(
            wheelbase=self.axle("front") - self.axle("rear"),
            reference_offset=self.axle(law.axle),
        )
        # `replace` of each class gives that class; through the union the type checker loses it.
        return cast("_P", fitted)
