"""What is believed of a vehicle and what it is, in a few words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer._core import Vehicle

__all__ = ["differences"]


def differences(believed: Vehicle, vehicle: Vehicle) -> str:
    """Say what controllers were given that differs from it.

    Parameters
    ----------
    believed : Vehicle
        The vehicle that they were given.
    vehicle : Vehicle
        The vehicle as it is.

    Returns
    -------
    str
        To follow the name of the plant; empty where nothing differs.

    Examples
    --------
    >>> from popsteer import Vehicle
    >>> differences(Vehicle(steer_lag=0.2), Vehicle())
    ', believed steer_lag 0.2'
    >>> differences(Vehicle(), Vehicle())
    ''
    """
    is_so = vehicle.as_dict()
    different = [
        f"{name} {'none' if value is None else format(value, 'g')}"
        for name, value in believed.as_dict().items()
        if value != is_so[name]
    ]
    return f", believed {' and '.join(different)}" if different else ""
