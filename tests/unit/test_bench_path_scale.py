from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

import popsteer
from benches import path_scale

if TYPE_CHECKING:
    from pathlib import Path


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
