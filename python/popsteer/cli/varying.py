"""What the commands ``sweep`` and ``tune`` share: the car that is varied, and what varies."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from popsteer import presets, sim
from popsteer._core import KinematicBicycle
from popsteer.cli import inputs
from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.lab.common.distributions import Distribution, distribution
from popsteer.lab.common.varied import usual
from popsteer.params_file import load_all

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from popsteer._core import Vehicle
    from popsteer.sim import Plant

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["DEFAULT_CONTROLLER", "car", "distributions", "tuning"]

DEFAULT_CONTROLLER = "preview-pop"
"""Who steers where neither an option nor a file of parameters says it."""


def car(
    plant: str | None,
    set_plant: Sequence[str] | None,
    vehicle: str | None,
    set_vehicle: Sequence[str] | None,
) -> tuple[Any, Vehicle, str]:
    """Give the plant before it varies, what the controller is given of it, and its label.

    Parameters
    ----------
    plant, vehicle : str or None
        As `popsteer.cli.inputs.plant` and `named_vehicle` take them. Without a plant it is a
        kinematic bicycle of the vehicle.
    set_plant, set_vehicle : sequence of str or None
        ``NAME=VALUE`` each.

    Returns
    -------
    tuple
        Plant, vehicle and label.

    Raises
    ------
    ConfigError
        A name is not known, or a value is refused.

    Examples
    --------
    >>> moved, told, label = car(None, None, "paper", None)
    >>> moved.vehicle == told, label
    (True, 'paper')
    """
    if plant is None and vehicle is not None:
        made: Any = KinematicBicycle(inputs.named_vehicle(vehicle))
        label = inputs.plant_label(vehicle)
        made = inputs.changed_plant(made, label, set_plant)
    else:
        named = "carla-identified" if plant is None else plant
        made, label = inputs.plant(named, set_plant), inputs.plant_label(named)
    return made, inputs.believed(vehicle, set_vehicle, sim.vehicle_of(made)), label


def tuning(
    controller: str | None,
    params: Path | None,
    preset: str,
    assignments: Sequence[str] | None,
    *,
    no_adapt: bool,
) -> tuple[str, inputs.Tuning]:
    """Give who steers, and what that is tuned by.

    Parameters
    ----------
    controller : str or None
        Its name; by default the one that the file is of.
    params : pathlib.Path or None
        A file of its tuning.
    preset : str
        Where the tuning comes from without a file.
    assignments : sequence of str or None
        ``NAME=VALUE`` each.
    no_adapt : bool
        Whether it estimates nothing.

    Returns
    -------
    tuple
        The name and the tuning.

    Raises
    ------
    ConfigError
        The file is refused, or has nothing of the controller.
    """
    if controller is None:
        controller = DEFAULT_CONTROLLER if params is None else next(iter(load_all(params)))
    if controller in baselines.names() and preset == "default":
        preset = presets.REPRODUCTION  # those from elsewhere have one tuning alone
    return controller, inputs.tuned(
        [controller], preset, assignments, no_adapt=no_adapt, params=params
    )


def distributions(
    vary: Sequence[str] | None, file: Path | None, plant: Plant, option: str = "--vary"
) -> dict[str, Distribution]:
    """Give what varies: of a file, changed by options; the usual where neither is given.

    Parameters
    ----------
    vary : sequence of str or None
        ``NAME=DISTRIBUTION`` each; ``NAME=none`` takes one out.
    file : pathlib.Path or None
        A TOML file of ``NAME = "DISTRIBUTION"``.
    plant : plant
        What moves.
    option : str, default "--vary"
        The option, for messages.

    Returns
    -------
    dict
        By name.

    Raises
    ------
    ConfigError
        The file cannot be read, or a text is no distribution.
    """
    texts: dict[str, Any] = {}
    if file is not None:
        try:
            texts = tomllib.loads(file.read_bytes().decode("utf-8"))
        except OSError as error:
            raise ConfigError("--distributions", str(file), f"readable: {error.strerror}") from None
        except ValueError as error:
            raise ConfigError("--distributions", str(file), f"a TOML file: {error}") from None
    elif not vary or all(each.partition("=")[2].strip() == "none" for each in vary):
        texts = dict(usual(sim.vehicle_of(plant), plant))
    for each in vary or []:
        name, equals, text = (part.strip() for part in each.partition("="))
        if not equals:
            raise ConfigError(option, each, "written NAME=DISTRIBUTION")
        if text == "none":
            texts.pop(name, None)
        else:
            texts[name] = text
    return {name: distribution(name, text) for name, text in texts.items()}
