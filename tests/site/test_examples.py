"""The programs of examples/ run as a user runs them."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from typing import TYPE_CHECKING

from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from pathlib import Path

EXAMPLES = ROOT / "examples"
# Run by the tests of what they drive, with the options that a simulator of others needs.
ELSEWHERE = {
    "carla_drive.py": "tests/adapters/test_carla_example.py",
    "from_log_to_car.sh": "tests/cli/test_from_log_to_car.py",
    "highway_env.py": "tests/adapters/test_highway_env.py",
    "ros2_vehicle.py": "tests/adapters/test_pages.py",
    "embedded": "tests/core/test_embedded.py",
}
HERE = ("compare_controllers.py", "own_controller.py", "own_loop.py")
LONGEST = 59  # lines
MOST = 9


def _run(name: str, folder: Path) -> str:
    program = [sys.executable, "-W", "error", str(EXAMPLES / name)]
    ran = subprocess.run(program, cwd=folder, check=False, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert not list(folder.iterdir())
    return ran.stdout


def test_own_loop_stays_on_paths_that_are_new_each_step(tmp_path: Path) -> None:
    found = re.fullmatch(
        r"(\d+) steps, as many paths; after 5 s at most ([\d.]+) m off\n",
        _run("own_loop.py", tmp_path),
    )
    assert found is not None
    assert int(found[1]) > 500
    assert float(found[2]) < 0.05


def test_compared_controllers_have_the_order_that_the_pages_give(tmp_path: Path) -> None:
    _, *rows = _run("compare_controllers.py", tmp_path).splitlines()
    errors = {row.split()[0]: float(row.split()[1]) for row in rows}
    assert sorted(errors, key=errors.__getitem__) == ["PreviewPop", "Stanley", "PurePursuit", "Pop"]
    assert all(row.split()[-1] == "0" for row in rows)


def test_bang_bang_leaves_the_road_where_pop_does_not(tmp_path: Path) -> None:
    said = _run("own_controller.py", tmp_path)
    first, second = said.splitlines()
    assert first.startswith("bang-bang: too far from the path after ")
    assert second.startswith("pop: finished after ")
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    assert textwrap.indent(said, "    ") in page


def _names() -> list[str]:
    return sorted(file.name for file in EXAMPLES.iterdir() if file.name != "__pycache__")


@looped("name", _names())
def test_example_is_short(name: str) -> None:
    file = EXAMPLES / name
    source = file / "src" / "main.rs" if file.is_dir() else file
    lines = source.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= LONGEST
    assert max(map(len, lines)) <= 100


def test_every_example_is_run_and_on_the_page() -> None:
    page = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
    found = _names()
    assert len(found) <= MOST
    assert set(found) == {*re.findall(r"^\| `([\w.]+)/?` \|", page, re.MULTILINE)}
    # The script runs the program that records its log.
    assert set(found) == {*HERE, *ELSEWHERE, "recorded_drive.py"}
    assert "recorded_drive.py" in (EXAMPLES / "from_log_to_car.sh").read_text(encoding="utf-8")
    for name, test in ELSEWHERE.items():
        assert name in (ROOT / test).read_text(encoding="utf-8")
