"""An experiment as data: every field of it, so that nothing that changes a result is forgotten."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from popsteer import plants, sim
from popsteer._core import Path, Vehicle
from popsteer.lab.common import longitudinal
from popsteer.lab.common.varied import Distribution
from popsteer.sim.geometry import CORE_PLANTS

_MOST_WAYPOINTS = 10_000_000


def of_fields(experiment: Any, **resolved: Any) -> dict[str, Any]:
    """Give all fields of a dataclass as JSON has it; `resolved` stand for those of their names."""
    values = {each.name: getattr(experiment, each.name) for each in fields(experiment)}
    return {name: plain(value) for name, value in (values | resolved).items()}


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """Name the fields in which two documents differ, those that only one has too."""
    there = {name: (name in one, name in other) for name in {**one, **other}}
    return [name for name, both in there.items() if not all(both) or one[name] != other[name]]


def plain(value: Any) -> Any:  # noqa: PLR0911 - a kind of value a line
    """Give a value of a field as JSON has it; waypoints to the last bit."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Distribution):
        return str(value)
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, Path):
        return _of_path(value)
    pedals: Any = tuple(longitudinal.KINDS.values())
    if isinstance(value, pedals):
        return {"name": longitudinal.name_of(value), "params": value.as_dict()}
    if hasattr(value, "vehicle"):
        return _of_plant(value)
    return plain(value.as_dict()) if hasattr(value, "as_dict") else [plain(each) for each in value]


def _of_path(path: Path) -> dict[str, Any]:
    """Give what makes the path again: a spline's heading and curvature by their name alone."""
    _, made_of = cast("tuple[Any, Any]", path.__reduce__())
    xy, given, mends, fits = made_of
    made = {"x": xy[:, 0], "y": xy[:, 1], **given, "mends": mends, "fits": fits}
    del made["source"]
    return {
        name: _packed(each) if isinstance(each, np.ndarray) else each
        for name, each in made.items()
        if each is not None
    }


def _of_plant(plant: Any) -> dict[str, Any]:
    core = isinstance(plant, tuple(CORE_PLANTS.values()))
    params = plant if core else getattr(plant, "params", None)
    own = {} if params is None else params.as_dict()
    return {
        "name": sim.plant_name(plant),
        "params": {name: plain(each) for name, each in own.items() if name != "vehicle"},
        "vehicle": plant.vehicle.as_dict(),
    }


def path_of(document: Mapping[str, Any]) -> Path:
    """Make the path of what `plain` gave."""
    given = {
        name: _unpacked(each) if isinstance(each, str) and each != "spline" else each
        for name, each in document.items()
    }
    if "reverse" in given:
        given["reverse"] = given["reverse"].astype(bool)
    xy = np.column_stack((given.pop("x"), given.pop("y")))
    remake: Any = getattr(Path, "_remake")  # noqa: B009 - what a pickle of a path calls
    made: Path = remake(xy, given, list(map(tuple, given.pop("mends"))), given.pop("fits"))
    return made


def plant_of(document: Mapping[str, Any]) -> Any:
    """Make the plant of what `plain` gave."""
    name, vehicle = document["name"], Vehicle(**document["vehicle"])
    if name in CORE_PLANTS:
        return CORE_PLANTS[name](vehicle, **document["params"])
    found: Any = plants.get(name)
    found = found.with_params(found.params.replace(**document["params"]))
    return found.with_steering(dead_time=vehicle.dead_time, steer_offset=vehicle.steer_offset)


def _packed(column: Any) -> str:
    data = np.asarray(column, dtype=np.float64).tobytes()
    return base64.b64encode(zlib.compress(data)).decode("ascii")


def _unpacked(text: str) -> NDArray[np.float64]:
    stream = zlib.decompressobj()
    data = stream.decompress(base64.b64decode(text, validate=True), 8 * _MOST_WAYPOINTS)
    if not stream.eof:
        raise ValueError(f"a column ends early or has more than {_MOST_WAYPOINTS:,} numbers")
    return np.frombuffer(data, dtype=np.float64)
