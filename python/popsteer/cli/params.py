"""``popsteer params``: the parameters that can be set by name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Annotated, Any, NamedTuple

import typer
from rich.table import Table
from rich.text import Text

from popsteer import controllers, own, plants, presets, sim, vehicles
from popsteer._core import AdaptParams, MonitorParams, Vehicle
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import described
from popsteer.errors import printable
from popsteer.lab import baselines
from popsteer.lab.common.layout import blank_table
from popsteer.lab.common.longitudinal import KINDS
from popsteer.lab.common.names import controller_names, law_of
from popsteer.planning import SpeedLimits
from popsteer.plants.pedals import MujocoCarParams, PedalParams
from popsteer.ranges import check_known
from popsteer.sim import Settings
from popsteer.sim.geometry import CORE_PLANTS

HELP = """\
List the parameters that can be set by name, with defaults, ranges and meaning.

Without NAME it lists the names: of controllers, plants, presets and what else has parameters.
Numbers marked * scale with the vehicle; they are shown for --vehicle.

\b
Examples:
  popsteer params
  popsteer params pop
  popsteer params preview-pop --vehicle car.toml
  popsteer params vehicle
  popsteer params mine.py:Mpc
"""

_PRESETS = {
    "default": "popsteer's own tuning, which scales with the vehicle",
    "paper": "the paper's text",
    "published-code": "its authors' code",
    "reproduction": "for each controller the one that comes closer to the paper's table",
}
_PEDALS = {
    "speed-tracker": "keeps speeds that it plans within the vehicle's limits and the waypoints'",
    "speed-pid": "keeps the speeds of the waypoints",
    "coupled": "the paper's: slower in bends and away from the path",
}


class _Kind(NamedTuple):
    """What has parameters: their class, and the option that sets them."""

    params: type[Any]
    option: str
    also: str = ""
    """What else the option sets."""


def _kinds() -> dict[str, _Kind]:
    loop = "; --set also takes those of adapt and monitor"
    fields = "; --set-plant also takes the fields of vehicle"
    return {
        **{
            name: _Kind(law_of(name).params, "--set", loop if name in controllers.names() else "")
            for name in controller_names()
        },
        "adapt": _Kind(AdaptParams, "--set"),
        "monitor": _Kind(MonitorParams, "--set"),
        "vehicle": _Kind(Vehicle, "--set-vehicle"),
        **{name: _Kind(params, "--set-plant", fields) for name, params in CORE_PLANTS.items()},
        **{
            name: _Kind(MujocoCarParams if name == "mujoco-car" else PedalParams, "--set-plant")
            for name in plants.names()
        },
        **{name: _Kind(params, "--set-longitudinal") for name, params in KINDS.items()},
        "run": _Kind(Settings, "--set-run"),
        "limits": _Kind(SpeedLimits, "--set", " of popsteer plan"),
    }


def params(
    *,
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Whose parameters.", show_default=False)
    ] = None,
    vehicle: options.Vehicle = None,
) -> None:
    """List the parameters that can be set by name."""
    if name is None:
        said = (
            "Names that options take; popsteer params NAME lists the parameters of what has some."
        )
        outputs.show(said, [_table(_overview(), "names")])
        return
    car, kind = inputs.believed(vehicle, None), _kind(name)
    rows = list(_rows(kind.params, car))
    head = f"{name}, set by {kind.option} NAME=VALUE{kind.also}"
    if not rows:
        head = f"{name} has no parameters"
    scaled = f"* scales with the vehicle, here {vehicle or 'one'} of {car.wheelbase:g} m wheelbase"
    notes = [scaled] if any("*" in default for _, default, _, _ in rows) else []
    outputs.show(head, [_table(rows, "name", "default", "range")] if rows else [], notes)


def _kind(name: str) -> _Kind:
    """Give what has this name; ConfigError where nothing has, OwnCodeError as `own.load`."""
    known = _kinds()
    if name not in known:
        for what, option in (("controller", "--set"), ("plant", "--set-plant")):
            if own.is_named(what, name):  # type: ignore[arg-type]
                return _Kind(own.params_of(own.load(what, name)), option)  # type: ignore[arg-type]
    check_known("name of parameters", name, known)
    return known[name]


def _rows(kind: type[Any], car: Vehicle) -> Iterator[tuple[str, str, str, str]]:
    """Give name, default, range and text of each parameter; those that scale are of a vehicle."""
    usual = kind()
    values = usual.as_dict()
    scaled = usual.resolved(car).as_dict() if hasattr(usual, "resolved") else values
    said = described(kind)
    for name, value in values.items():
        if name == "vehicle":
            continue  # its fields have a list of their own
        text, within = said.get(name, ("", ""))
        low, high = getattr(kind, "RANGES", {}).get(name, (None, None))
        if low is not None:
            within = f"{low:g} to {high:g}"
        star = "*" if value is None and scaled[name] is not None else ""
        yield name, f"{_word(scaled[name])}{star}", within, text


def _word(value: object) -> str:
    if value is None or isinstance(value, bool):
        return str(value).lower()
    return f"{value:.4g}" if isinstance(value, float) else printable(str(value))


def _table(rows: Iterable[tuple[str, ...]], *heads: str) -> Table:
    table = blank_table()
    for head in heads:
        table.add_column(head, no_wrap=len(heads) > 1)  # names alone may be many
    table.add_column("", overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    return table


def _overview() -> list[tuple[str, str]]:
    """Name all that has parameters, and the presets, each with what it is."""
    shipped = ", ".join(sim.plant_names())
    return [
        (", ".join(controllers.names()), "--controllers: the controllers of popsteer"),
        (", ".join(baselines.names()), "--controllers: needs the extra 'mpc'"),
        ("adapt, monitor", "what the controllers estimate, and what they take for a fault"),
        (", ".join(vehicles.names()), "--vehicle; or a file *.toml, or the name of a plant"),
        ("vehicle", "the fields of a vehicle"),
        (shipped, "--plant; or a file *.toml, driven as a kinematic bicycle"),
        ("commonroad-MODEL-CAR", "--plant: MODEL st, std or mb, CAR 1 to 3; extra 'plants'"),
        ("mujoco-car", "--plant: needs the extra 'plants'"),
        *((name, f"--longitudinal: {_PEDALS[name]}") for name in _PEDALS),
        ("run", "the run: time limit, settling time, ..."),
        ("limits", "the limits of popsteer plan"),
        *((name, f"--preset: {_PRESETS[name]}") for name in presets.names("pop")),
        ("FILE.py:NAME", "a controller, plant or track of your own"),
    ]
