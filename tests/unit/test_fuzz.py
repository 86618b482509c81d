"""The fuzzer's runner, its table, and the CSV reader on every input that fuzzing has kept.

The inputs of the core are replayed by `cargo test`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest

from tests.fuzz import csv_reader, table
from tests.fuzz import run as fuzz
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / "tests" / "fuzz" / "run.py"), *arguments]
    return subprocess.run(
        command, env=os.environ | environment, capture_output=True, text=True, check=False
    )


def test_fuzz_run_without_a_cpp_compiler_says_so() -> None:
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not on the path")
    done = run("predict", CXX="no-such-compiler")
    assert done.returncode == 2
    assert done.stderr.startswith("no-such-compiler not found: libFuzzer needs a C++ compiler")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["lawz"], "unknown target 'lawz'"),
        (["--seconds", "0"], "at least 1, got 0"),
        (["--add", "found"], "an input is one target's: name it"),
        (["laws", "--input", "none/such"], "none/such is no file"),
    ],
)
def test_fuzz_run_bad_argument_is_named(arguments: list[str], message: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert message in done.stderr


def test_fuzz_corpus_written_is_read_again_and_one_more_input_is_one_more_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz, "CORPUS", tmp_path)
    every = bytes(range(256))
    fuzz.write_corpus("laws", [b"\r\n", every, b"", b"\r\n"])
    file = tmp_path / "laws.hex"
    before = file.read_text(encoding="ascii").splitlines()
    assert fuzz.read_corpus("laws") == [every, b"\r\n"]
    found = tmp_path / "crash-1"
    found.write_bytes(b"\x05new")
    monkeypatch.setattr(sys, "argv", ["run.py", "laws", "--add", str(found)])
    assert fuzz.main() == 0
    after = file.read_text(encoding="ascii").splitlines()
    assert [line for line in after if line != "056e6577"] == before
    assert len(after) == len(before) + 1
    fuzz.unpack("laws", tmp_path / "unpacked")
    unpacked = sorted(file.read_bytes() for file in (tmp_path / "unpacked").iterdir())
    assert unpacked == fuzz.read_corpus("laws")


def test_fuzz_corpus_of_every_target_is_as_the_runner_writes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = {target: fuzz.read_corpus(target) for target in fuzz.LONGEST_INPUT}
    files = {file.name: file.read_bytes() for file in fuzz.CORPUS.iterdir()}
    monkeypatch.setattr(fuzz, "CORPUS", tmp_path)
    for target, inputs in kept.items():
        assert max(map(len, inputs)) <= fuzz.LONGEST_INPUT[target], target
        fuzz.write_corpus(target, inputs)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == files


def test_fuzz_table_adds_up_runs_and_keeps_the_reader_apart() -> None:
    def given(date: str, target: str, executions: int, *findings: str) -> dict[str, Any]:
        result = {"target": target, "executions": executions, "seconds": 36.0}
        return {"date": date, "commit": "abc", "results": [result | {"findings": findings}]}

    made = table.table(
        [
            given("2026-01-02", "laws", 3000),
            given("2026-01-03", "laws", 4200, "out/fuzz/laws/crash-1"),
            given("2026-01-03", "path", 360),
            given("2026-01-03", "csv_reader", 9),
        ]
    )
    assert "| laws | 7,200 | 0.02 | 100 | 1 |" in made
    assert "| the core's together | 7,560 | 0.03 | 70 | 1 |" in made
    assert "| csv_reader | 9 |" in made
    assert "4 runs, 2026-01-02 to 2026-01-03, of commits abc." in made


def test_csv_reader_corpus_replayed_breaks_no_rule(tmp_path: Path) -> None:
    inputs = fuzz.read_corpus(fuzz.CSV)
    assert len(inputs) >= 10
    for kept in inputs:
        csv_reader.check(kept, tmp_path / "waypoints.csv")


def test_csv_reader_check_of_a_wrong_reader_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: Path) -> None:
        raise IndexError

    monkeypatch.setattr("popsteer.tables.read_waypoints", refuse)
    with pytest.raises(IndexError):
        csv_reader.check(b"0,0\n1,1\n", tmp_path / "waypoints.csv")
