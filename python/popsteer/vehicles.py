"""Vehicles by name: the paper's, and those of the plants that popsteer brings.

======================  ===========================================================================
vehicle                 what it is
======================  ===========================================================================
``paper``               The paper's car: ``Vehicle()`` without a limit of the lateral acceleration,
                        as its track asks for up to 8.2 m/s².
``carla-identified``    What the plant identified from the authors' run is.
``kinematic-bicycle``   What the kinematic bicycle is by default: its wheels turn at once.
======================  ===========================================================================

A plant from elsewhere has its vehicle as its attribute ``vehicle``.

Examples
--------
>>> from popsteer import vehicles
>>> vehicles.get("carla-identified").turning_wheelbase
3.553
"""

from __future__ import annotations

from popsteer._core import CarlaIdentified, KinematicBicycle, Vehicle
from popsteer.ranges import check_known

__all__ = ["get", "names"]

_VEHICLES = {
    "paper": Vehicle(max_lateral_acceleration=None),
    "carla-identified": CarlaIdentified().vehicle,
    "kinematic-bicycle": KinematicBicycle().vehicle,
}


def names() -> tuple[str, ...]:
    """Names of the vehicles.

    Returns
    -------
    tuple of str
        The names that `get` knows.

    Examples
    --------
    >>> names()
    ('paper', 'carla-identified', 'kinematic-bicycle')
    """
    return tuple(_VEHICLES)


def get(name: str) -> Vehicle:
    """Give a vehicle by its name.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    Vehicle
        The vehicle, which cannot be changed; its ``replace`` gives a changed copy.

    Raises
    ------
    ConfigError
        No vehicle has this name.

    Examples
    --------
    >>> get("paper").max_lateral_acceleration is None
    True
    >>> get("truck")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown vehicle 'truck'; known: paper, carla-identified, \
kinematic-bicycle
    """
    check_known("vehicle", name, _VEHICLES)
    return _VEHICLES[name]
