"""``popsteer matrix``: laws × plants × tracks in a table, files and a figure."""

from __future__ import annotations

import csv
import json
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import study
from popsteer.errors import ConfigError
from tests.cli import command

if TYPE_CHECKING:
    from pathlib import Path

PLANTS = ("carla-identified", "kinematic-bicycle")
LAWS = ("stanley", "pop")


def test_matrix_writes_every_combination(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = command.call(
        capsys,
        "matrix",
        *("--laws", ",".join(LAWS), "--plants", ",".join(PLANTS)),
        *("--tracks", "straight,slalom", "--out", str(out)),
    )
    assert (outcome.status, outcome.err) == (0, "")
    names = {f"matrix{dark}.{kind}" for dark in ("", "-dark") for kind in ("png", "svg")}
    assert {file.name for file in out.iterdir()} == names | {"matrix.csv", "matrix.json"}
    lines = (out / "matrix.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    wanted = {(p, t, law) for p in PLANTS for t in ("straight", "slalom") for law in LAWS}
    assert {(row["plant"], row["track"], row["law"]) for row in rows} == wanted
    assert len(rows) == len(wanted)
    document = json.loads((out / "matrix.json").read_text(encoding="utf-8"))
    for comparison in document["comparisons"]:
        for name, figures in comparison["controllers"].items():
            row = next(
                row
                for row in rows
                if (row["plant"], row["track"], row["law"])
                == (comparison["plant"], comparison["path"]["name"], name)
            )
            assert float(row["step_time"]) == figures["step_time"] > 0.0
            column = "settled_mean_abs_cross_track_error"
            assert float(row[column]) == figures[column]
            assert row["ending"] == figures["ending"] == "finished"


def test_matrix_figures_are_those_of_compare() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(121)])
    shares: list[float] = []
    found = study.matrix({"a": path}, LAWS, PLANTS, progress=lambda _, share: shares.append(share))
    for comparison, plant in zip(found.comparisons, PLANTS, strict=True):
        alone = study.compare(path, LAWS, plant)
        assert comparison.runs.keys() == alone.runs.keys()
        for name, run in comparison.runs.items():
            assert run.metrics == alone.runs[name].metrics
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--laws", "pop,lqr"), "unknown law 'lqr'"),
        (("--plants", "tank"), "unknown plant 'tank'"),
        (("--tracks", "monza"), "unknown track 'monza'"),
    ],
)
def test_matrix_wrong_name_is_refused(
    capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str
) -> None:
    outcome = command.call(capsys, "matrix", *options)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err


def test_matrix_of_nothing_is_refused() -> None:
    path = popsteer.Path([(0.0, 0.0), (9.0, 0.0)])
    with pytest.raises(ConfigError, match="plants must be at least one"):
        study.matrix({"a": path}, ["pop"], [])
