"""Without the extra the adapter is imported all the same, and each entry names it."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.helpers import ROOT

HIDDEN = "import sys; sys.modules['carla'] = None\n"
WITHOUT = f"{HIDDEN}from popsteer.adapters import carla as adapter\n"
MESSAGE = 'CARLA\'s client needs the extra "carla": pip install "popsteer[carla]"'


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", WITHOUT + code], check=False, capture_output=True, text=True
    )


@pytest.mark.parametrize(
    "call",
    [
        "adapter.LocalPlanner(None)",
        "adapter.transform_of(0.0, 0.0, 0.0)",
        "adapter.vehicle_control(0.0, 0.0, 0.0, steering=adapter.Steering(1.0))",
        "adapter.ackermann_control(0.0, 0.0)",
    ],
)
def test_entry_names_the_extra_that_is_missing(call: str) -> None:
    ended = run(call)
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1] == f"popsteer.extras.MissingExtra: {MESSAGE}"


def test_adapter_is_imported_without_the_client() -> None:
    ended = run("assert adapter.speed_from_kmh(36.0) == 10.0; print(*adapter.__all__)")
    assert ended.returncode == 0, ended.stderr
    assert "LocalPlanner" in ended.stdout


def test_popsteer_imports_neither_adapter_nor_client() -> None:
    code = "import sys, popsteer; sys.exit(any('carla' in name for name in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_example_without_the_extra_ends_with_one_line_and_status_2() -> None:
    code = "import runpy; runpy.run_path(sys.argv.pop(), run_name='__main__')"
    ended = subprocess.run(
        [sys.executable, "-c", HIDDEN + code, "examples/carla_drive.py"],
        check=False,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert (ended.returncode, ended.stderr) == (2, f"carla_drive: {MESSAGE}\n")
