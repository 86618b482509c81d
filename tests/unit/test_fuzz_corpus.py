"""The CSV reader on every input that fuzzing has kept; the core's are replayed by `cargo test`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.fuzz import csv_reader, run

if TYPE_CHECKING:
    from pathlib import Path


def test_csv_reader_corpus_replayed_breaks_no_rule(tmp_path: Path) -> None:
    inputs = run.read_corpus(run.CSV)
    assert len(inputs) >= 10
    for kept in inputs:
        csv_reader.check(kept, tmp_path / "waypoints.csv")


def test_csv_reader_check_of_a_wrong_reader_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(file: Path) -> None:
        raise IndexError

    monkeypatch.setattr("popsteer.csv_file.read_waypoints", refuse)
    with pytest.raises(IndexError):
        csv_reader.check(b"0,0\n1,1\n", tmp_path / "waypoints.csv")
