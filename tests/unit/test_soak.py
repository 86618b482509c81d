"""The benches over long runs and long paths: the soak, and what a path costs as it grows."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

import popsteer
from benches import path_scale, soak
from benches.soak import BOUND, Sample
from tests.helpers import ROOT

if TYPE_CHECKING:
    from pathlib import Path


def test_soak_short_run_says_what_it_did(tmp_path: Path) -> None:
    file = tmp_path / "soak.json"
    command = [sys.executable, str(ROOT / "benches" / "soak.py"), "--steps", "300000"]
    done = subprocess.run(
        [*command, "--json", str(file)], capture_output=True, text=True, check=True
    )
    given = json.loads(file.read_text(encoding="utf-8"))
    assert given["called"] + given["batched"] >= 300_000
    assert given["samples"][-1]["steps"] == given["called"] + given["batched"]
    assert f"{given['called']:,} by calls of their own" in done.stdout
    assert "million steps" in done.stderr


def test_soak_memory_that_grows_is_seen() -> None:
    flat = [Sample(k, 0.0, 1_000_000 + (k < 10) * 5_000_000) for k in range(1, 101)]
    assert soak.growth(flat) == 0
    leaking = [Sample(k, 0.0, 1_000_000 + 20_000 * k) for k in range(1, 101)]
    assert soak.growth(leaking) > BOUND


def test_soak_growth_beyond_the_bound_exits_with_1(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = iter(range(0, 1000 * BOUND, BOUND))
    monkeypatch.setattr(soak, "resident", lambda: next(sizes))
    monkeypatch.setattr(sys, "argv", ["soak.py", "--steps", "2000000"])
    assert soak.main() == 1


def test_soak_interrupted_reports_what_it_reached(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls = iter([1_000_000, 1_000_000])

    def resident() -> int:
        try:
            return next(calls)
        except StopIteration:
            raise KeyboardInterrupt from None

    monkeypatch.setattr(soak, "resident", resident)
    monkeypatch.setattr(sys, "argv", ["soak.py", "--steps", "2000000"])
    assert soak.main() == 130
    assert "240,000 steps: 192,000 by calls" in capsys.readouterr().out


@pytest.mark.skipif(popsteer.build_profile != "release", reason="a debug build is not measured")
def test_path_scale_of_a_short_path_fills_its_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "path_scale.json"
    arguments = ["path_scale.py", "--largest", "1000", "--drives", "2", "--json", str(file)]
    monkeypatch.setattr("sys.argv", arguments)
    path_scale.main()
    (row,) = json.loads(file.read_text(encoding="utf-8"))["rows"]
    assert row["waypoints"] == 1000
    for name in path_scale.SEARCHES:
        assert 0.0 < row[f"{name} p50 [us]"] <= row[f"{name} p99 [us]"]
    assert path_scale.STEP in capsys.readouterr().out
