"""ARCHITECTURE.md names the files that there are, and no others."""

from __future__ import annotations

import re

import pytest

from tests.helpers import ROOT

PARTS = {
    "ground": "core/src",
    **{
        part: f"core/src/{part}"
        for part in ("vehicle", "path", "laws", "tracker", "speed", "driver")
    },
    "popsteer-sim": "sim/src",
}
# What a part has besides: entry points, and the steering controllers, which are named as such.
UNNAMED = {"lib", "mod", "tests", "pop", "pid", "pure_pursuit", "stanley"}
TEXT = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("part", PARTS)
def test_table_of_the_files_has_each_once(part: str) -> None:
    (row,) = re.findall(rf"^\| `?{part}`? \| (.*)", TEXT, re.MULTILINE)
    named = set(re.findall(r"`(\w+)`", row))
    folder = ROOT / "rust" / PARTS[part]
    there = {each.stem for each in folder.iterdir() if not each.name.startswith(".")} - UNNAMED
    if part == "ground":
        there -= PARTS.keys()
    assert there <= named
    # Of a file that is a folder, too, those in it may be named.
    below = {each.stem for each in folder.rglob("*.rs")}
    assert named <= there | below


def test_paths_of_files_lead_somewhere() -> None:
    tops = "rust|python|tests|docs|ros2|benches|studies|examples"
    for path in sorted(set(re.findall(rf"`((?:{tops})/[\w/.]+)`", TEXT))):
        assert any((ROOT / f"{path}{ending}").exists() for ending in ("", ".rs", ".py")), path
