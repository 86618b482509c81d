"""The reference mirrors the Rust core, file for file and name for name.

What is linear algebra in it has the names of its matrices.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

import popsteer
from popsteer import _core, paper, reference, sim
from popsteer.reference.tracker.state import TrackerState
from tests.helpers import ROOT
from tests.parity.laws import ALL, LATERAL

REFERENCE = ROOT / "python" / "popsteer" / "reference"
CORE = ROOT / "rust" / "core" / "src"
FILES = sorted(file.relative_to(REFERENCE) for file in REFERENCE.rglob("*.py"))
OTHERS = ["SpeedPidState", "SpeedTrackerState"]
LAWS = ["pop", "preview_pop/__init__", "pid/__init__", "pure_pursuit", "stanley"]


def _twins(file: Path) -> list[Path]:
    """Where the Rust twin of a file of the reference may stand."""
    if file.name == "__init__.py":
        return [CORE / file.parent / name for name in ("mod.rs", "lib.rs")]
    return [CORE / file.with_suffix(".rs")]


def test_reference_holds_the_controllers_and_their_modules() -> None:
    held = {file.as_posix() for file in FILES}
    assert {f"laws/{law}.py" for law in LAWS} <= held
    assert {"math.py", "error.py", "path/locate.py", "path/lookahead.py"} <= held
    assert {"path/resample.py", "vehicle/bicycle.py", "vehicle/delay.py"} <= held
    assert {"vehicle/estimator.py", "tracker/step.py", "speed/coupled.py"} <= held


@pytest.mark.parametrize("file", FILES, ids=str)
def test_reference_file_has_its_twin_in_the_core(file: Path) -> None:
    twins = _twins(file)
    assert any(twin.is_file() for twin in twins), f"none of {', '.join(map(str, twins))}"


def test_core_file_has_its_twin_in_the_reference_or_is_a_shortcut() -> None:
    files = {file.relative_to(CORE) for file in CORE.rglob("*.rs")} - {
        Path("lib.rs"),
        Path("status.rs"),
    }
    twins = {
        Path(file.parent, "mod.rs") if file.name == "__init__.py" else file.with_suffix(".rs")
        for file in FILES
    }
    # What the plain loops need not have; each is compared with them where it stands.
    shortcuts = {
        Path("path/jump.rs"): "get_lookahead_point",
        Path("path/nearby.rs"): "locate_by_scan",
        # The search for the plan, which the reference finds as a quadratic program.
        Path("laws/preview_pop/active_set.rs"): "limited",
    }
    files -= {file for file in files if file.name in ("tests.rs", "fixtures.rs")}
    assert files - set(shortcuts) <= twins
    assert all(plain in (CORE / file).read_text("utf-8") for file, plain in shortcuts.items())


@pytest.mark.parametrize("law", ALL, ids=lambda law: law.name)
def test_params_have_the_same_fields_in_the_same_order(law: Any) -> None:
    ours = list(getattr(popsteer, law.params_name)().as_dict())
    assert len(ours) >= 3
    assert ours == [field.name for field in dataclasses.fields(getattr(reference, law.params_name))]


@pytest.mark.parametrize("name", ["Vehicle", "AdaptParams", "MonitorParams", "Estimate"])
def test_values_have_the_same_fields_in_the_same_order(name: str) -> None:
    ours = list(getattr(popsteer, name)().as_dict())
    assert ours == [field.name for field in dataclasses.fields(getattr(reference, name))]


@pytest.mark.parametrize("name", [*(law.state_name for law in LATERAL), *OTHERS])
def test_states_have_the_same_fields_in_the_same_order(name: str) -> None:
    ours = list(getattr(popsteer, name)().as_dict())
    assert ours
    fields = [field.name for field in dataclasses.fields(getattr(reference, name))]
    if name not in OTHERS:
        # What all controllers remember comes first where a class is derived from it.
        tail = [field.name for field in dataclasses.fields(TrackerState)]
        fields = [*(field for field in fields if field not in tail), *tail]
    assert ours == fields


def test_public_names_are_sorted_and_all_of_the_extension() -> None:
    assert popsteer.__all__ == sorted(popsteer.__all__)
    assert len(set(popsteer.__all__)) == len(popsteer.__all__)
    exported = {name for name in dir(_core) if not name.startswith("_")} | {"__version__"}
    # The five laws and their parts alone are fifteen.
    assert len(exported) > 30
    # The batch below an adapter is that adapter's.
    assert exported - {"plants", "Episodes"} <= {*popsteer.__all__, *paper.__all__, *sim.__all__}
    for name in popsteer.__all__:
        assert getattr(popsteer, name) is not None


def test_reference_answers_to_the_public_names() -> None:
    alone = {"ConfigError", "InputError", "PathError", "PopsteerError", "__version__", "vehicles"}
    alone |= {"identify"}  # what is done with logs, not in a control step
    ours = {*popsteer.__all__, *paper.__all__} - alone - {"build_profile", "paper", "planning"}
    # What takes many vehicles at once has one vehicle's law for its reference.
    missing = ours - set(reference.__all__)
    assert missing <= {name for name in ours if name.endswith("Batch")}
