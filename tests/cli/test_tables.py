"""Every table is whole: on a terminal of 80 columns, and where it is piped."""

from __future__ import annotations

import os
import re
import subprocess
from typing import TYPE_CHECKING

import pytest

from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path


pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a pseudo-terminal")

# The longest names that come with popsteer, runs that leave the road, and notes of every kind.
COMMANDS = {
    "compare": (
        "compare",
        "--track",
        "obstacle-avoidance",
        "--controllers",
        "pid,preview-pop",
    ),
    "several": (
        *("compare", "--controllers", "pop,pure-pursuit,preview-pop", "--constant-speed", "30"),
        *("--plants", "carla-identified,kinematic-bicycle", "--step-time"),
        *("--tracks", "obstacle-avoidance,double-lane-change", "--dt", "0.1"),
    ),
    "stability": ("stability", "--speeds", "2,25", "--set-plant", "dead_time=0.1"),
    "tracks": ("tracks",),
}
# Measured anew each time.
_TIMES = re.compile(r"(?<= )\d+\.\d\d(?= *$)", re.MULTILINE)


SHORT = ("--set-run", "time_limit=6", "--set", "deviation_limit=0.01")


def _on_terminal(arguments: tuple[str, ...], columns: int) -> str:
    """What a terminal of so many columns shows."""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", _sent(arguments, columns))


def _sent(arguments: tuple[str, ...], columns: int) -> str:
    """What a terminal of so many columns is sent."""
    reading, writing = os.openpty()
    environment = {**os.environ, "COLUMNS": str(columns), "LINES": "40", "TERM": "xterm"}
    with subprocess.Popen(
        [command.script(), *arguments],
        stdout=writing,
        stderr=subprocess.DEVNULL,
        env=environment,
    ) as process:
        os.close(writing)
        sent = command.read_terminal(reading)
    os.close(reading)
    assert process.returncode == 0
    return sent.decode().replace("\r\n", "\n")


def _words(text: str) -> list[str]:
    """What is said, in whatever order and broken wherever."""
    return sorted(re.findall(r"[^\s─]+", _TIMES.sub("", text)))


def _check(name: str, narrow: str, wide: str, columns: int = 80) -> None:
    for text in (narrow, wide):
        assert "…" not in text
    lines = [line for line in narrow.splitlines() if not line.lstrip().startswith(("--out", "Wri"))]
    assert max(map(len, lines)) <= columns
    # A cell that was cut, or a column left out, would be words that are missing.
    missing = set(_words(wide)) - set(_words(narrow))
    assert not missing, f"{name}: {missing}"


@pytest.mark.parametrize("name", COMMANDS)
def test_table_is_whole_at_80_columns_and_piped(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    piped = command.call(capsys, *COMMANDS[name])
    assert (piped.status, piped.err) == (0, "")
    _check(name, _on_terminal(COMMANDS[name], 80), piped.out)


def test_files_with_long_names_are_not_cut(tmp_path: Path) -> None:
    waypoints = tmp_path / f"{'q-very-long-name-' * 4}.csv"
    waypoints.write_text("".join(f"{x},0\n" for x in range(121)), encoding="utf-8")
    arguments = ("compare", "--controllers", "pop", "--plants", "kinematic-bicycle")
    sent = _on_terminal((*arguments, "--waypoints", str(waypoints)), 80)
    assert "…" not in sent
    # Once where it is read and once in the table.
    assert sent.count("q") == 8


@pytest.mark.parametrize("cut", ["0.1234…", "x" * 81])
def test_table_that_is_cut_is_found(cut: str) -> None:
    with pytest.raises(AssertionError):
        _check("planted", cut, "0.1234")
    with pytest.raises(AssertionError):
        _check("planted", "a 0.12", "a 0.1234")


def test_fault_and_unfinished_run_are_told_first_in_red_with_a_sign() -> None:
    sent = _sent(("compare", "--track", "slalom", "--controllers", "pop,stanley", *SHORT), 120)
    row, note = (
        f"\x1b[1;31m{each}" for each in ("✗ unfinished, deviating", "✗ POP came to an end")
    )
    assert row in sent
    assert note in sent
    assert sent.index(note) < sent.index("Starts with")


@pytest.mark.parametrize(("columns", "tables"), [(80, 2), (120, 1)])
def test_table_is_split_only_where_it_does_not_fit(columns: int, tables: int) -> None:
    sent = _on_terminal(("compare", "--track", "slalom", "--controllers", "pop,stanley"), columns)
    assert len(re.findall("^controller ", sent, re.MULTILINE)) == tables
