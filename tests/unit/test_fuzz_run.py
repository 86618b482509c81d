"""The fuzzer's runner says what is missing, and its table adds up what was run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import Any

import pytest

from tests.fuzz import table
from tests.helpers import ROOT


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
    [(["lawz"], "unknown target 'lawz'"), (["--seconds", "0"], "at least 1, got 0")],
)
def test_fuzz_run_bad_argument_is_named(arguments: list[str], message: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert message in done.stderr


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
