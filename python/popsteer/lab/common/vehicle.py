"""What is believed of a vehicle and what it is, in a few words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from popsteer._core import Vehicle


def differences(believed: Vehicle, vehicle: Vehicle) -> str:
    """Say in what the vehicle that controllers were given differs from the real one.

    The text follows the name of the plant; it is empty where nothing differs.
    """
    is_so = vehicle.as_dict()
    different = [
        f"{name} {'none' if value is None else format(value, 'g')}"
        for name, value in believed.as_dict().items()
        if value != is_so[name]
    ]
    return f", believed {' and '.join(different)}" if different else ""
