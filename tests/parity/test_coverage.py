"""Nothing public goes without a parity test; the `covers` marks say which test compares what."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from typing import Any

import pytest

import popsteer
from popsteer import paper
from tests.parity.laws import LATERAL

# Of popsteer, but not of the reference.
ALONE = {
    "Path.from_csv": "reads a file with popsteer.csv_file, then makes the path as `Path` does",
    **dict.fromkeys(
        ["Vehicle.load", "Vehicle.save"],
        "read and write a file with popsteer.vehicle_file",
    ),
    **dict.fromkeys(
        [f"{law.name}Params.{what}" for law in LATERAL for what in ("load", "save")],
        "read and write a file with popsteer.params_file",
    ),
    **dict.fromkeys(
        [
            *("Batch", "CommandBatch", "Batch.reset", "Batch.states", "Batch.steer", "Batch.step"),
            "Batch.set_path",
            *("CommandBatch.steer", "CommandBatch.cross_track_error", "CommandBatch.heading_error"),
            *("CommandBatch.predicted_cross_track_error", "CommandBatch.predicted_heading_error"),
            *("CommandBatch.target", "CommandBatch.reverse", "CommandBatch.status"),
            *("CommandBatch.reference_speed", "CommandBatch.distance_to_stop"),
        ],
        "many vehicles at once, which tests/unit/test_batch.py holds to single steps",
    ),
}
# The same objects on both sides, or no callables.
SHARED = {
    *("ConfigError", "InputError", "PathError", "PopsteerError", "Prediction", "Status"),
    *("__version__", "build_profile", "identify", "paper", "planning", "vehicles"),
}
# What the enumeration below has to find at the least, lest it pass by finding nothing.
ESSENTIAL = {
    *("wrap", "saturate", "get_distance", "get_predicted_location", "state_transition"),
    *("kinematic_bicycle", "Path", "Path.project", "Path.locate", "Path.resample"),
    *("Path.relocalise", *(f"{law.name}.relocalise" for law in LATERAL)),
    *("Vehicle", "Vehicle.turning_length", "AdaptParams", "Estimate.steer_offset"),
    *("CoupledLongitudinal.step", "SpeedPid.step", "SpeedPid.state", "Command.steer"),
    *(f"{law.name}.{member}" for law in LATERAL for member in ("step", "steer", "state", "reset")),
    *(f"{law.name}{part}" for law in LATERAL for part in ("", "Params", "State")),
}


def _constructible(kind: type) -> bool:
    try:
        kind()
    except TypeError as error:
        return "No constructor defined" not in str(error) and "cannot create" not in str(error)
    return True


def _public() -> set[str]:
    names: set[str] = set()
    for name in {*popsteer.__all__, *paper.__all__} - SHARED:
        thing: Any = getattr(paper if name in paper.__all__ else popsteer, name)
        if not inspect.isclass(thing) or _constructible(thing):
            names.add(name)
        if inspect.isclass(thing):
            names |= {f"{name}.{member}" for member in dir(thing) if not member.startswith("_")}
    return names - set(ALONE)


def _tests() -> dict[str, Any]:
    found: dict[str, Any] = {}
    for file in sorted(Path(__file__).parent.glob("test_*.py")):
        module = importlib.import_module(f"tests.parity.{file.stem}")
        found |= {name: thing for name, thing in vars(module).items() if name.startswith("test_")}
    return found


def _claimed(test: Any) -> set[str]:
    """What the marks of a test claim, those of its parameters too."""
    marks = list(getattr(test, "pytestmark", []))
    for mark in list(marks):
        if mark.name == "parametrize":
            for case in mark.args[1]:
                marks += getattr(case, "marks", ())
    return {name for mark in marks if mark.name == "covers" for name in mark.args}


def test_public_names_each_have_a_parity_test() -> None:
    claimed = {name for test in _tests().values() for name in _claimed(test)}
    # A class that is compared is compared in all that it shows: `compare.bits` sees to it.
    shown = {
        f"{kind}.{field}"
        for kind in {name.partition(".")[0] for name in claimed}
        for field in _shown(kind)
    }
    missing = _public() - claimed - shown
    assert not missing, f"no parity test claims {sorted(missing)}"


def _shown(kind: str) -> tuple[str, ...]:
    from tests.parity.compare import fields_of

    return fields_of(kind) if inspect.isclass(getattr(popsteer, kind, None)) else ()


def test_enumeration_of_public_names_finds_the_essential_ones() -> None:
    assert _public() >= ESSENTIAL
    assert all("." in name or name in popsteer.__all__ for name in ALONE)
    assert set(popsteer.__all__) >= SHARED


def test_covers_marks_name_only_what_exists() -> None:
    claimed = {name for test in _tests().values() for name in _claimed(test)}
    assert len(claimed) > 50
    assert claimed <= _public()


@pytest.mark.parametrize(
    "law", ["pop", "preview_pop", "pid", "pure_pursuit", "stanley", "speed_pid"]
)
@pytest.mark.parametrize("kind", ["edges", "random", "rollout"])
def test_law_has_parity_test_of_each_kind(law: str, kind: str) -> None:
    assert f"test_{law}_matches_reference_{kind}" in _tests()


@pytest.mark.parametrize("law", [law.name for law in LATERAL])
def test_parameter_ranges_name_every_parameter(law: str) -> None:
    (table,) = (entry for entry in LATERAL if entry.name == law)
    params = getattr(popsteer, table.params_name)()
    assert {*table.ranges, *table.counts, *table.flags} == set(params.as_dict())
