"""What the commands ``sweep`` and ``tune`` share: who steers, and what varies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import presets, sim, toml_file
from popsteer.cli import inputs
from popsteer.errors import ConfigError
from popsteer.lab import baselines
from popsteer.lab.common.distributions import Distribution, distribution
from popsteer.lab.common.varied import usual
from popsteer.params_file import load_all

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from popsteer.sim import Plant

DEFAULT_CONTROLLER = "preview-pop"
"""The controller by default."""


def tuning(
    controller: str | None,
    params: Path | None,
    preset: str,
    assignments: Sequence[str] | None,
    *,
    no_adapt: bool,
) -> tuple[str, inputs.Tuning]:
    """Give the name of the controller, by default the one that the file is of, and its tuning.

    The arguments are those of `popsteer.cli.inputs.tuned`. Raises ConfigError as that does.
    """
    if controller is None:
        controller = DEFAULT_CONTROLLER if params is None else next(iter(load_all(params)))
    if baselines.is_known(controller) and preset == "default":
        preset = presets.REPRODUCTION  # those from elsewhere have one tuning alone
    return controller, inputs.tuned(
        [controller], preset, assignments, no_adapt=no_adapt, params=params
    )


def distributions(
    vary: Sequence[str] | None, file: Path | None, plant: Plant
) -> dict[str, Distribution]:
    """Give what varies, by name: that of a file, or else what usually does, changed by `vary`.

    `vary` is ``NAME=DISTRIBUTION`` each; ``NAME=none`` takes one out, and anything else leaves
    what usually varies with the plant out. Raises ConfigError where the file is no TOML file of
    ``NAME = "DISTRIBUTION"``, or a text is no distribution.
    """
    texts: dict[str, Any] = {}
    if file is not None:
        texts = toml_file.read(file, "--distributions")
    elif not vary or all(each.partition("=")[2].strip() == "none" for each in vary):
        texts = dict(usual(sim.vehicle_of(plant), plant))
    for each in vary or []:
        name, equals, text = (part.strip() for part in each.partition("="))
        if not equals:
            raise ConfigError("--vary", each, "written NAME=DISTRIBUTION")
        if text == "none":
            texts.pop(name, None)
        else:
            texts[name] = text
    return {name: distribution(name, text) for name, text in texts.items()}
