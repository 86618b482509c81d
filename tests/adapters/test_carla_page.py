"""The code of docs/carla.md, and what is said where CARLA is missing."""

from __future__ import annotations

import contextlib
import io
import re
import subprocess
import sys

import pytest

from tests.helpers import ROOT

PAGE = (ROOT / "docs" / "carla.md").read_text(encoding="utf-8")
BLOCKS = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_carla_page_code_prints_what_the_page_says() -> None:
    pytest.importorskip("carla", reason='the extra "carla" is not installed')
    blocks = BLOCKS.findall(PAGE)
    shown = [index for index, (kind, _) in enumerate(blocks) if kind == "text"]
    assert len(shown) == 1
    (_, code), (_, wanted) = blocks[shown[0] - 1 : shown[0] + 1]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(code, "carla.md", "exec"), {})
    assert out.getvalue() == wanted


def test_carla_page_code_that_needs_a_simulator_is_python() -> None:
    code = [block for kind, block in BLOCKS.findall(PAGE) if kind == "python"]
    assert len(code) == 3
    for block in code:
        compile(block, "carla.md", "exec")


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
