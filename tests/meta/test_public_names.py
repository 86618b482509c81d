"""What the packages show: a function hides no module, and no study's constant is public."""

from __future__ import annotations

import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import popsteer
from tests.helpers import looped

if TYPE_CHECKING:
    import pytest

PACKAGES = [
    "popsteer",
    *(each.name for each in pkgutil.walk_packages(popsteer.__path__, "popsteer.") if each.ispkg),
]


def _hidden(package: ModuleType) -> list[str]:
    """Modules of a package that something else of the same name hides."""
    inside = [each.name for each in pkgutil.iter_modules(package.__path__)]
    return [name for name in inside if not isinstance(getattr(package, name, package), ModuleType)]


def _constants(package: ModuleType) -> list[str]:
    return [name for name in getattr(package, "__all__", ()) if name.isupper()]


def test_packages_are_found() -> None:
    assert {"popsteer.lab.compare", "popsteer.sim", "popsteer.reference.speed"} <= set(PACKAGES)


@looped("name", PACKAGES)
def test_package_hides_none_of_its_modules(name: str) -> None:
    assert _hidden(importlib.import_module(name)) == []


@looped("name", [each for each in PACKAGES if each != "popsteer.cli"])
def test_package_shows_no_constants(name: str) -> None:
    package = importlib.import_module(name)
    # What a figure is drawn with is no constant of a study.
    assert set(_constants(package)) <= {"FIGURES", "THEMES"}


def test_hidden_module_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    package: Any = importlib.import_module("popsteer.lab.compare")
    monkeypatch.setattr(package, "runs", package.run)
    assert _hidden(package) == ["runs"]


LAZY = (
    *("adapters", "controllers", "identification", "lab", "logs", "paper"),
    *("planning", "plants", "presets", "reference", "sim", "tracks"),
)


def test_modules_are_found_by_name_and_loaded_then() -> None:
    code = (
        "import sys, popsteer\n"
        "dear = [name for name in ('sim', 'lab', 'tracks') if 'popsteer.' + name in sys.modules]\n"
        "dear += {'dataclasses', 'tempfile', 'tomllib', 'typing_extensions'} & sys.modules.keys()\n"
        "assert not dear, dear\n"
        f"for name in {LAZY}:\n"
        "    assert name in dir(popsteer)\n"
        "    assert getattr(popsteer, name).__name__ == 'popsteer.' + name\n"
        "try:\n"
        "    popsteer.simulation\n"
        "except AttributeError as error:\n"
        "    print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout == "module 'popsteer' has no attribute 'simulation'\n"


def test_modules_that_are_loaded_late_are_known_to_type_checkers() -> None:
    source = Path(popsteer.__file__).read_text(encoding="utf-8")
    known = re.findall(r"^    from popsteer import (\w+) as \1$", source, re.MULTILINE)
    assert tuple(known) == LAZY
