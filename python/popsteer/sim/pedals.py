"""What works the pedals in a run: from an acceleration to throttle and brake."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from popsteer import toml_file
from popsteer._core import CoupledLongitudinal, Path, SpeedPid, SpeedTracker, Vehicle
from popsteer.errors import ConfigError, PathError
from popsteer.parameters import Parameters
from popsteer.sim.geometry import Plant, check_length, object_of

if TYPE_CHECKING:
    import os

Longitudinal: TypeAlias = CoupledLongitudinal | SpeedPid | SpeedTracker
"""What works the pedals: the paper's controller, a PID on the path's speeds, or a plan that is
kept."""


@dataclass(frozen=True)
class PedalMap(Parameters):
    """The pedals that give an acceleration, for a vehicle whose drive is linear in them.

    a = drive·throttle - braking·brake - drag·v - air_drag·v², v along the direction of driving.

    Parameters
    ----------
    drive : float
        Acceleration at full throttle [m/s^2].
    braking : float
        Deceleration at full brake [m/s^2].
    drag : float, default 0.0
        Drag linear in speed [1/s].
    air_drag : float, default 0.0
        Drag quadratic in speed [1/m].

    Raises
    ------
    ConfigError
        A number is not in its range.

    Examples
    --------
    >>> pedals = PedalMap(drive=6.0, braking=9.0, drag=0.3)
    >>> pedals(3.0, 10.0), pedals(-12.0, 0.0), pedals(0.0, 0.0)
    ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
    """

    RANGES: ClassVar = {
        "drive": (1e-3, 1e3),
        "braking": (1e-3, 1e3),
        "drag": (0.0, 1e3),
        "air_drag": (0.0, 1e3),
    }

    drive: float
    braking: float
    drag: float = 0.0
    air_drag: float = 0.0

    @classmethod
    def of(cls, plant: Plant) -> PedalMap:
        """Give the map of a plant.

        Parameters
        ----------
        plant : str or CarlaIdentified or KinematicBicycle or PythonPlant
            One whose parameters, or those that it has as `params`, name `drive`, `braking` and
            `drag`.

        Returns
        -------
        PedalMap
            The map, without the plant's losses in bends.

        Raises
        ------
        ConfigError
            No plant has this name.

        Examples
        --------
        >>> PedalMap.of("carla-identified").air_drag
        0.001
        """
        params = _params_of(plant)
        return cls(params.drive, params.braking, params.drag, getattr(params, "air_drag", 0.0))

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> PedalMap:
        r"""Read the map from the table ``[pedals]`` of a vehicle file, as `identify` writes it.

        Parameters
        ----------
        file : str or os.PathLike
            The file.

        Returns
        -------
        PedalMap
            The map.

        Raises
        ------
        ConfigError
            The file cannot be read, has no such table, or a key in it is unknown or out of range.

        Examples
        --------
        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder) / "car.toml"
        ...     _ = file.write_text("[pedals]\ndrive = 4.1\nbraking = 7.9\n")
        ...     PedalMap.load(file).braking
        7.9
        """
        table = toml_file.read(file, "vehicle file").get("pedals")
        if not isinstance(table, dict):
            refused = ConfigError("pedals", table, "a table [pedals] in the vehicle file")
            raise toml_file.in_file(file, refused)
        toml_file.check(file, table, cls(1.0, 1.0).as_dict(), "pedals")
        try:
            return cls(**table)
        except TypeError:
            refused = ConfigError("pedals", table, "drive and braking")
            raise toml_file.in_file(file, refused) from None
        except ConfigError as error:
            raise toml_file.in_file(file, error) from None

    @staticmethod
    def is_known(plant: Plant) -> bool:
        """Whether a plant says what its pedals do, as `of` needs it; raises what `of` does."""
        params = _params_of(plant)
        return all(hasattr(params, name) for name in ("drive", "braking", "drag"))

    def __call__(self, acceleration: float, speed: float) -> tuple[float, float]:
        """Give the pedals for an acceleration.

        Parameters
        ----------
        acceleration : float
            In the direction of driving [m/s^2].
        speed : float
            In that direction too [m/s].

        Returns
        -------
        tuple of float
            (throttle, brake), each in 0 to 1, one of them 0.
        """
        drag = self.drag * speed + self.air_drag * speed * abs(speed)
        pull = acceleration + drag
        if pull >= 0.0:
            return min(pull / self.drive, 1.0), 0.0
        return 0.0, min(-pull / self.braking, 1.0)


def _params_of(plant: Plant) -> Any:  # noqa: ANN401 - any class that has the fields
    found = object_of(plant)
    return getattr(found, "params", found)


def check_longitudinal(
    longitudinal: Longitudinal | None, path: Path, plant: Vehicle, whose: str = ""
) -> None:
    """Refuse a longitudinal controller that cannot work in a run; `whose` path it is, for messages.

    PathError where `SpeedPid` needs a path's speeds or the path is shorter than the plant,
    ConfigError where a `SpeedTracker` has another path, or its rear axle elsewhere than the plant.
    """
    check_length(path, plant, f"the path{whose}")
    if isinstance(longitudinal, SpeedPid) and path.speed is None:
        raise PathError(f"the path{whose} has no reference speeds for SpeedPid to follow")
    if isinstance(longitudinal, SpeedTracker):
        axle = longitudinal.vehicle.rear_axle
        if axle != plant.rear_axle:
            required = f"that of the plant, {plant.rear_axle!r}, in the SpeedTracker's vehicle"
            raise ConfigError("rear_axle", axle, required)
        if not all(map(np.array_equal, _line(longitudinal.path), _line(path))):
            required = f"a SpeedTracker of the path that is driven{whose}"
            raise ConfigError("longitudinal", longitudinal, required)


def _line(path: Path) -> tuple[Any, ...]:
    """Give what a path is without its speeds, with where it is driven backwards."""
    reverse = np.zeros(len(path), dtype=bool) if path.reverse is None else path.reverse
    return path.x, path.y, path.closed, reverse
