"""What made a page: vehicles, parameters and the run's settings, as TOML."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from popsteer import controllers, params_file, vehicle_file
from popsteer.lab.common.names import differences
from popsteer.lab.report.markup import block, paragraphs
from popsteer.lab.report.page import Section
from popsteer.toml_file import worded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from popsteer._core import Settings, Vehicle


@dataclass(frozen=True)
class Origin:
    """What the command was, and what the runs do not say themselves."""

    command: str = ""
    """The command line."""
    params: Mapping[str, Any] = field(default_factory=dict)
    """Parameters of the controllers by name."""
    adapt: Any = "auto"
    """How they adapt: AdaptParams, ``"auto"`` or None."""
    plants: Mapping[str, Any] = field(default_factory=dict)
    """The plants by what they are called."""
    monitor: Any = "auto"
    """How they watch for faults: MonitorParams, ``"auto"`` or None."""


def vehicles(whole: Mapping[str, Vehicle], believed: Mapping[str, Vehicle]) -> Section:
    """Show each plant's vehicle, and where it differs what the controllers were given of it."""
    blocks = []
    for name, vehicle in whole.items():
        blocks.append(block(f"{name}: the vehicle", vehicle_file.as_toml(vehicle)))
        given = believed.get(name, vehicle)
        if given != vehicle:
            said = differences(given, vehicle).removeprefix(", believed ")
            title = f"{name}: the vehicle that the controllers were given ({said})"
            blocks.append(block(title, vehicle_file.as_toml(given)))
    return Section("vehicle", "Vehicle", "".join(blocks))


def tuning(origin: Origin, *others: str) -> Section:
    """Show what the controllers and plants were made with, and other blocks after that."""
    blocks = []
    for name, params in origin.params.items():
        own = name in controllers.names()
        text = params_file.as_toml(params) if own else _toml(name, params.as_dict())
        blocks.append(block(f"{name}: parameters", text))
    if origin.adapt is None:
        blocks.append(paragraphs(["The controllers estimated nothing (--no-adapt)."]))
    elif hasattr(origin.adapt, "as_dict"):
        blocks.append(block("How the controllers adapt", _toml("adapt", origin.adapt.as_dict())))
    if hasattr(origin.monitor, "as_dict"):
        text = _toml("monitor", origin.monitor.as_dict())
        blocks.append(block("How the controllers watch for faults", text))
    for name, plant in origin.plants.items():
        owner = getattr(plant, "params", plant)
        values = owner.as_dict() if hasattr(owner, "as_dict") else {}
        if values := {key: value for key, value in values.items() if key != "vehicle"}:
            blocks.append(block(f"{name}: parameters of the plant", _toml(name, values)))
    return Section("parameters", "Parameters", "".join([*blocks, *others]))


def settings_block(settings: Settings) -> str:
    """Show the settings of the runs."""
    values = settings.as_dict()
    values.pop("keep_records", None)
    return block("The run: settings, as --set-run takes them", _toml("run", values))


def _toml(head: str, values: Mapping[str, Any]) -> str:
    """Word values as TOML; what is None, as a comment."""
    # A name with a dot or a space is quoted.
    plain = head.replace("-", "").replace("_", "").isalnum() and head.isascii()
    lines = [f"[{head.replace('-', '_') if plain else worded(head)}]"]
    for key, value in values.items():
        if value is None:
            lines.append(f"# {key} =")
        elif hasattr(value, "as_dict"):
            inner = ", ".join(f"{k} = {v!r}" for k, v in value.as_dict().items() if v is not None)
            lines.append(f"{key} = {{ {inner} }}")
        else:
            lines.append(f"{key} = {worded(value)}")
    return "\n".join(lines) + "\n"
