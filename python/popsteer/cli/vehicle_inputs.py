"""The plants and vehicles that options name, as the library takes them."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, TypeAlias

from popsteer import plants, sim, vehicles
from popsteer._core import Vehicle
from popsteer.cli.assignments import assigned, assigned_each
from popsteer.errors import ConfigError
from popsteer.sim import CarlaIdentified, KinematicBicycle
from popsteer.sim.geometry import object_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.plants.protocol import PythonPlant

    Mover: TypeAlias = CarlaIdentified | KinematicBicycle | PythonPlant


def plant(text: str, assignments: Sequence[str] | None = None) -> Mover:
    """Give the plant that an option names.

    `text` is the name of a plant, or a file ``*.toml`` of a vehicle, of which a kinematic bicycle
    is made. `assignments` are ``NAME=VALUE`` each: parameters of the plant and fields of its
    vehicle. Raises ConfigError where no plant has this name, the file holds no vehicle or a
    parameter is refused, and PopsteerError where the plant needs an extra that is not installed.
    """
    found = KinematicBicycle(Vehicle.load(text)) if _is_file(text) else object_of(text)
    return changed_plant(found, plant_label(text), assignments)


def changed_plant(plant: Mover, name: str, assignments: Sequence[str] | None) -> Mover:
    """Give a copy of a plant, changed as assignments say; messages call it `name`.

    The assignments are those of `plant`. Raises ConfigError where a name is not known or a value is
    refused.
    """
    if not assignments:
        return plant
    if isinstance(plant, CarlaIdentified | KinematicBicycle):
        changed, vehicle = assigned_each([plant, plant.vehicle], assignments, name)
        return changed.replace(vehicle=vehicle)  # type: ignore[no-any-return]
    configurable: Any = plant
    params = assigned(configurable.params, assignments, name)
    return configurable.with_params(params)  # type: ignore[no-any-return]


def plant_label(text: str) -> str:
    """Say what tables call a plant: its name, or that of its file."""
    return FilePath(text).name if _is_file(text) else text


def named_vehicle(text: str) -> Vehicle:
    """Give the vehicle that an option names.

    `text` is a file ``*.toml`` of a vehicle, a name of `popsteer.vehicles.names`, or that of a
    plant. Raises ConfigError where no vehicle has this name or the file holds none.
    """
    if _is_file(text):
        return Vehicle.load(text)
    if text in vehicles.names():
        return vehicles.get(text)
    if plants.is_known(text):
        return sim.vehicle_of(text)
    known = (*vehicles.names(), *plants.names(), "a file *.toml")
    raise ConfigError.unknown("vehicle", text, known)


def believed(text: str | None, changes: Sequence[str] | None, itself: Vehicle) -> Vehicle:
    """Give the vehicle that the controllers are given.

    It is the one that `text` names, or without it that of the plant, `itself`; with the fields
    changed that `changes` name, ``NAME=VALUE`` each. Raises ConfigError as `named_vehicle`, and
    where a field is not known or its value refused.
    """
    vehicle = itself if text is None else named_vehicle(text)
    return assigned(vehicle, changes or [], "the vehicle")


def varied(
    plant_text: str | None,
    set_plant: Sequence[str] | None,
    vehicle: str | None,
    set_vehicle: Sequence[str] | None,
) -> tuple[Any, Vehicle, str]:
    """Give a plant before it varies, the vehicle that the controller is given, and a label.

    The arguments are those of `plant` and `believed`. Without a plant it is a kinematic bicycle of
    the vehicle, and without both the identified one. Raises ConfigError as those do.
    """
    if plant_text is None and vehicle is not None:
        label = plant_label(vehicle)
        made = changed_plant(KinematicBicycle(named_vehicle(vehicle)), label, set_plant)
    else:
        named = "carla-identified" if plant_text is None else plant_text
        made, label = plant(named, set_plant), plant_label(named)
    return made, believed(vehicle, set_vehicle, sim.vehicle_of(made)), label


def _is_file(text: str) -> bool:
    return text.lower().endswith(".toml")
