"""Long commands killed at any place where they touch a file: files are whole or not there."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytest.importorskip("optuna")
pytest.importorskip("scipy")
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")

TRIALS = 3
COMMANDS = {
    "sweep": "sweep --track slalom --runs 8 --workers 1 --constant-speed 8 --out s.csv"
    " --report s.html",
    "tune": f"tune --controller pop --cars 1 --trials {TRIALS} --tracks slalom --constant-speed 8"
    " --out t.toml",
    "record": "compare --controllers pop --track slalom --constant-speed 8"
    " --record r.mcap --out out",
}
KILLS = int(os.environ.get("KILLS", "1"))  # of each command, and two at its end

# Kills a child, for each command of the line, at its `at`th change of a file below the folder. What
# is opened to be read does not count: Optuna reads its journal as often as it has the time to.
CHILDREN = """
import os, signal, sys
import matplotlib.figure, optuna, plotly, scipy.optimize, scipy.stats  # noqa: F401 - once for all
from popsteer.cli import app, main  # noqa: F401
from popsteer.lab import report  # noqa: F401

matplotlib.figure.Figure.draw_without_rendering = lambda self: None
matplotlib.figure.Figure.savefig = lambda self, stream, **_: stream.write(b"blank")
TOUCHED = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.link"}


def run(folder, at, command):
    told_by, told_to = os.pipe()
    if child := os.fork():
        os.close(told_to)
        told = os.read(told_by, 20)
        os.close(told_by)
        return told.decode() if os.waitpid(child, 0)[1] == 0 else "killed"
    os.chdir(folder)
    here, seen = os.path.realpath(folder), 0

    def look(event, given):
        nonlocal seen
        if event not in TOUCHED or isinstance(given[0], int):
            return
        if event == "open" and given[1] in ("r", "rb"):
            return
        if os.path.realpath(os.fsdecode(given[0])).startswith(here):
            seen += 1
            if seen == at:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(look)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        main(command.split())
    except SystemExit as ended:
        told = -1 if ended.code else seen
    os.write(told_to, str(told).encode())
    os._exit(0)


for line in sys.stdin:
    folder, at, command = line.rstrip().split("|")
    print(run(folder, int(at), command), flush=True)
"""


@pytest.fixture(scope="module")
def children() -> Iterator[subprocess.Popen[str]]:
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", CHILDREN]
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, cwd=ROOT) as found:
        yield found
        assert found.stdin is not None
        found.stdin.close()


def _run(children: subprocess.Popen[str], folder: Path, at: int, command: str) -> str:
    """Run a command in a folder; how often it has changed files in it, or "killed"."""
    assert children.stdin is not None
    assert children.stdout is not None
    folder.mkdir(exist_ok=True)
    print(f"{folder}|{at}|{command}", file=children.stdin, flush=True)
    return children.stdout.readline().strip()


def _ends(data: bytes) -> bytes:
    return data[:8] + data[-8:]


def _files(folder: Path) -> dict[str, bytes]:
    """What stands in a folder, but for what was staged, or waits to be gone on with."""
    every = [file for file in folder.rglob("*") if file.is_file()]
    names = {str(file.relative_to(folder)): file for file in every}
    kept = (".part", ".journal", ".lock")
    return {
        # A record has the time of its making in it: its two ends tell that it is whole.
        name: file.read_bytes() if file.suffix != ".mcap" else _ends(file.read_bytes())
        for name, file in names.items()
        if not name.endswith(kept) and ".popsteer-" not in name
    }


@pytest.mark.parametrize("name", COMMANDS)
def test_killed_command_leaves_whole_files_and_ends_as_if_it_had_not_been(
    children: subprocess.Popen[str], name: str, tmp_path: Path
) -> None:
    if name == "record":
        pytest.importorskip("rosbags")
    command, whole = COMMANDS[name], tmp_path / "whole"
    changes = int(_run(children, whole, -1, command))
    wanted = _files(whole)
    assert changes > len(wanted) > 0
    # Here and there, and at the end, where all files take their names.
    places = {round((k + 0.5) * changes / KILLS) for k in range(KILLS)}
    for at in sorted(places | {changes - 1, changes}):
        folder = tmp_path / f"killed-{at}"
        assert _run(children, folder, at, command) == "killed"
        found = _files(folder)
        assert found == {each: wanted.get(each) for each in found}, at
        if at not in (min(places), max(places)):
            continue
        # What was kept leads to the same end; a study keeps its trials, and draws others.
        kept = {file: file.read_bytes() for file in folder.glob("*.journal")}
        assert int(_run(children, folder, -1, command)) > 0
        found = _files(folder)
        assert found.keys() == wanted.keys()
        for file, data in kept.items():
            assert file.read_bytes().startswith(data[: data.rfind(b"\n") + 1]), at
            assert file.read_bytes().count(b'"state":1,') == TRIALS
        assert kept or found == wanted, at
