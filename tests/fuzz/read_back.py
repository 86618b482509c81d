"""What popsteer writes and reads back, damaged: each is read, or refused in one line.

``python -m tests.fuzz.read_back 2000`` tries as many files of all kinds, and says of each kind how
many were read and how many refused.
"""

from __future__ import annotations

import contextlib
import io
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from popsteer.cli import main
from tests.fuzz.mutated_files import mutated

_SHORT: tuple[str, ...] = ("--track", "circle", "--constant-speed", "6")
_SWEEP = ("sweep", "--controller", "pop", *_SHORT, "--runs", "3", "--seed", "4", "--out")
_TUNE: tuple[str, ...] = (
    *("tune", "--controller", "pop", "--tracks", "circle", "--constant-speed", "6"),
    "--cars",
)
_TUNE += ("1", "--trials", "2", "--storage")
_DISTRIBUTIONS = (
    'dead_time = "uniform(0, 0.1)"\nnoise_yaw = 0.001\nsteer_lag = "normal(0.1,0.01)"\n'
)
_SWAPS: tuple[bytes, ...] = (
    b"nan",
    b"true",
    b'"x"',
    b"null",
    b"[]",
    b"{}",
    b"-1",
    b"1e999",
    b"-0.5",
    b"9" * 30,
)
_SWAPS += (b"inf", b"\x1b[31m", b"\x07", b"uniform(0,1)", b"", b"\r", b"\xe2\x80\xa8", b"9" * 5000)


class Kind(NamedTuple):
    """A kind of file: its name, what it holds, and the command that reads it."""

    name: str
    data: bytes
    command: tuple[str, ...]
    """FILE stands for the file."""


class Said(NamedTuple):
    """How a command ended, and what it said on stderr; None where it ended in a traceback."""

    status: int | None
    err: str


def call(*arguments: str) -> Said:
    """Run a command in this process."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(arguments)
    except SystemExit as ended:
        return Said(int(ended.code or 0), err.getvalue())
    except Exception as error:  # noqa: BLE001 - what this looks for
        return Said(None, f"{type(error).__name__}: {error}")


def kinds(folder: Path) -> list[Kind]:
    """Let the commands write a file of each kind."""

    def made(name: str, *arguments: str) -> bytes:
        said = call(*arguments)
        assert said.status == 0, said
        return (folder / name).read_bytes()

    table = made("s.csv", *_SWEEP, f"{folder}/s.csv")
    head, *rows = made("s.csv.part", *_journal(folder)).splitlines(keepends=True)
    journal = made("t.journal", *_TUNE, f"{folder}/t.journal")
    tuned = made("t.toml", *_TUNE, f"{folder}/t.journal", "--out", f"{folder}/t.toml")
    record = made("runs/pop.csv", "compare", "--controllers", "pop", *_SHORT, "--out", str(folder))
    drive = ("compare", "--controllers", "pop", "--track", "circle", "--constant-speed", "6")
    found = [
        Kind("s.csv", table, ("sweep", "--run", "FILE:1")),
        Kind("s.csv.part", head + b"".join(rows), ("sweep", "--run", "FILE:1")),
        Kind("go.csv.part", head + b"".join(rows), (*_SWEEP, "GO")),
        Kind("go.csv", table, (*_SWEEP, "FILE")),
        Kind("t.journal", journal, (*_TUNE, "FILE")),
        Kind("t.toml", tuned, (*drive, "--params", "FILE")),
        Kind("car.toml", _car(folder), (*drive, "--plant", "FILE")),
        Kind("d.toml", _DISTRIBUTIONS.encode(), (*_SWEEP[:-1], "--distributions", "FILE")),
        Kind("run.csv", record, ("plan", "FILE")),
        Kind("log.csv", record, ("replay", "FILE", "--vehicle", "paper")),
    ]
    with contextlib.suppress(ImportError):
        import pyarrow as pa  # noqa: F401

        data = made("s.parquet", *_SWEEP, f"{folder}/s.parquet")
        found.append(Kind("s.parquet", data, ("sweep", "--run", "FILE:1")))
    with contextlib.suppress(ImportError):
        import rosbags  # noqa: F401

        data = made("r.mcap", *drive, "--record", f"{folder}/r.mcap")
        found.append(Kind("r.mcap", data, ("replay", "FILE", "--vehicle", "paper")))
    return found


def _journal(folder: Path) -> tuple[str, ...]:
    """Leave the journal of the sweep as it is just before its end, and say how it goes on."""
    from popsteer.lab.sweep import rows

    job, found = rows.read(folder / "s.csv")
    with rows.Journal(folder / "s.csv.part", job) as journal:
        journal.add(found)
    return "tracks", "--help"


def _car(folder: Path) -> bytes:
    from popsteer import Vehicle

    Vehicle(wheelbase=2.7, dead_time=0.1, max_speed=20.0).save(folder / "car.toml")
    return (folder / "car.toml").read_bytes()


def damaged(data: bytes, draw: random.Random) -> bytes:
    """Cut, flip bits, lose or repeat lines, or put another value in the place of one."""
    change = draw.randint(0, 6)
    place = draw.randrange(max(1, len(data)))
    lines = data.splitlines(keepends=True)
    if change == 0:
        return data[:place]
    if change == 1:
        flipped = bytearray(data)
        for _ in range(draw.choice((1, 1, 8))):
            flipped[draw.randrange(len(flipped))] ^= 1 << draw.randrange(8)
        return bytes(flipped)
    if change == 2 and len(lines) > 1:
        line = draw.randrange(len(lines))
        lines[line : line + 1] = draw.choice(([], [lines[line]] * 2, [b"\n"], [b"\n", lines[line]]))
        return b"".join(lines)
    if change in (3, 4):  # a value, as they stand between marks
        marks = b",:=\n[]{}()"
        ends = [k for k, byte in enumerate(data) if byte in marks]
        if len(ends) > 1:
            first = draw.randrange(len(ends) - 1)
            return data[: ends[first] + 1] + draw.choice(_SWAPS) + data[ends[first + 1] :]
    if change == 5:
        return data + draw.choice((b"\n", b"x\n", b"1,2\n", b"{}\n", b"\x00", b"\n\n"))
    return mutated(data, draw)


def run(count: int, seed: int, only: str = "") -> tuple[Counter[str], list[str]]:
    """Try damaged files of all kinds in turn: how many were read and refused; what is at fault."""
    draw, counts, faults = random.Random(seed), Counter[str](), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = [each for each in kinds(folder) if each.name.startswith(only)]
        for k in range(count):
            kind = files[k % len(files)]
            shutil.rmtree(folder / "case", ignore_errors=True)
            file = folder / "case" / kind.name
            file.parent.mkdir()
            data = damaged(kind.data, draw)
            file.write_bytes(data)
            going = str(file).removesuffix(".part")
            words = [each.replace("FILE", str(file)).replace("GO", going) for each in kind.command]
            begun = time.process_time()
            said = call(*words)
            slow = time.process_time() - begun
            counts[f"{kind.name} {'read' if said.status == 0 else 'refused'}"] += 1
            if fault := _fault(said, file):
                faults.append(f"{k} {kind.name}: {fault}")
            elif slow > 10.0:
                faults.append(f"{k} {kind.name}: {slow:.1f} s: {said}")
    return counts, faults


def _fault(said: Said, file: Path) -> str:
    """Say what is wrong with an answer; empty where nothing is."""
    text = said.err.removesuffix("\n")
    if said.status is None:
        return f"traceback: {text[:300]}"
    if said.status not in (0, 2):
        return f"status {said.status}: {text[:300]}"
    if said.status == 2 and not (0 < len(text) < 800 and text.isprintable()):
        return f"no line, {len(text)} characters: {text[:300]!r}"
    # What is drawn, or planned along a path, is read already.
    named = file.name.removesuffix(".part") in text or file.name in ("d.toml", "run.csv")
    if said.status == 2 and not named:
        return f"no file is named: {text[:300]}"
    return ""


def _main() -> None:
    counts, faults = run(int(sys.argv[1]), int((*sys.argv, "1")[2]), (*sys.argv, "", "")[3])
    print(*faults, sep="\n")
    for name, count in sorted(counts.items()):
        print(f"{name}: {count}")
    sys.exit(f"{len(faults)} at fault" if faults else None)


if __name__ == "__main__":
    _main()
