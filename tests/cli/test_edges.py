"""``popsteer edges`` and ``popsteer delay``: a table, CSV and JSON."""

from __future__ import annotations

import csv
import json
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import lab, sim
from tests.cli import command
from tests.closed_loop.paths import track

if TYPE_CHECKING:
    from pathlib import Path

TRACKS = ("touching", "parallel-parking")
LAWS = ("stanley", "pop")


def _rows(file: Path) -> list[dict[str, str]]:
    lines = file.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_edges_writes_what_the_study_finds(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table, document = tmp_path / "edges.csv", tmp_path / "edges.json"
    outcome = command.call(
        capsys,
        "edges",
        *("--controllers", ",".join(LAWS), "--tracks", ",".join(TRACKS)),
        *("--out", str(tmp_path)),
    )
    assert (outcome.status, outcome.err) == (0, "")
    known = {track.name: track for track in lab.edges.edge_tracks()}
    runs = lab.edges.run(LAWS, [known[name] for name in TRACKS])
    written = json.loads(document.read_text(encoding="utf-8"))
    assert written["plant"] == "kinematic-bicycle"
    assert written["vehicle"] == written["plant_vehicle"]
    assert written["plant_vehicle"]["max_steer"] == 0.6
    for run, row, entry in zip(runs, _rows(table), written["runs"], strict=True):
        assert (row["track"], row["law"]) == (entry["track"], entry["law"]) == (run.track, run.law)
        assert row["finished"] == "true"
        assert entry["finished"] is True
        assert float(row["max_error"]) == entry["max_error"] == run.max_error
        assert float(row["max_jump"]) == entry["max_jump"] == run.max_jump
        counts = {str(status): count for status, count in run.statuses.items()}
        assert entry["statuses"] == counts
        assert entry["steps"] == run.steps
        assert dict(part.split("=") for part in row["statuses"].split()) == {
            status: str(count) for status, count in counts.items()
        }
        assert f"{run.max_error:.3f}" in outcome.out
    assert f"Written to {tmp_path}/: edges.csv, edges.json" in outcome.out
    assert "end-of-path" in outcome.out
    assert all(unit in outcome.out for unit in ("[s]", "[m]", "[deg]"))  # no markup


def test_edges_by_default_drives_every_law_on_every_track(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table = tmp_path / "edges.csv"
    outcome = command.call(capsys, "edges", "--out", str(tmp_path))
    assert outcome.status == 0
    driven = {(row["track"], row["law"]) for row in _rows(table)}
    tracks = [track.name for track in lab.edges.edge_tracks()]
    assert driven == {(track, law) for track in tracks for law in lab.edges.runs.EDGE_CONTROLLERS}


def test_edges_of_a_car_of_ones_own_are_driven_by_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    car, document = tmp_path / "car.toml", tmp_path / "edges.json"
    vehicle = popsteer.Vehicle(rear_axle=-1.5, max_steer=0.5, steer_lag=0.2)
    vehicle.save(car)
    options = (
        "--controllers",
        "preview-pop",
        "--tracks",
        "parallel-parking",
        "--out",
        str(tmp_path),
    )
    given = ("--plant", str(car), "--set-vehicle", "steer_lag=0.1")
    outcome = command.call(capsys, "edges", *options, *given)
    assert (outcome.status, outcome.err) == (0, "")
    assert "plant kinematic-bicycle, believed steer_lag 0.1, speeds" in outcome.out
    assert "largest angle 29°" in outcome.out
    written = json.loads(document.read_text(encoding="utf-8"))
    assert written["plant_vehicle"] == vehicle.as_dict()
    assert written["vehicle"] == vehicle.replace(steer_lag=0.1).as_dict()
    track = next(track for track in lab.edges.edge_tracks() if track.name == "parallel-parking")
    (run,) = lab.edges.run(
        ["preview-pop"],
        [track],
        plant=sim.KinematicBicycle(vehicle),
        vehicle=vehicle.replace(steer_lag=0.1),
    )
    assert written["runs"][0]["max_error"] == run.max_error


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("edges", "--tracks", "monza"), "unknown track 'monza'"),
        (("edges", "--plant", "tank"), "unknown plant 'tank'"),
        (("edges", "--plant", "carla-identified"), "carla-identified does not reverse"),
        (("edges", "--controllers", "lqr"), "unknown controller 'lqr'"),
        (("edges", "--out", "nowhere/at/all", "--tracks", "touching"), "nowhere"),
        (("delay", "--controllers", "lqr"), "unknown controller 'lqr'"),
        (("delay", "--track", "monza"), "unknown track 'monza'"),
        (("delay", "--dead-time", "0"), "dead_time"),
        (("delay", "--preset", "tuned"), "unknown preset 'tuned'"),
        (("delay", "--plant", "mujoco-car"), "--plant must be carla-identified, kinematic-"),
    ],
)
def test_edges_and_delay_refuse_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    (tmp_path / "nowhere").write_text("a file, not a folder", encoding="utf-8")
    given = [part.replace("nowhere", str(tmp_path / "nowhere")) for part in arguments]
    outcome = command.call(capsys, *given)
    assert (outcome.status, outcome.out) == (2, "")
    assert said in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize("no_adapt", [(), ("--no-adapt",)])
def test_delay_writes_what_the_study_finds(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, no_adapt: tuple[str, ...]
) -> None:
    table, document = tmp_path / "delay.csv", tmp_path / "delay.json"
    outcome = command.call(
        capsys,
        "delay",
        *("--controllers", "stanley,pop", "--track", "slalom", "--dead-time", "0.15", *no_adapt),
        *("--out", str(tmp_path)),
    )
    assert (outcome.status, outcome.err) == (0, "")
    assert "slalom, plant carla-identified, dead time 0.15 s" in outcome.out
    slalom = track("slalom")
    rows = lab.delay.run(slalom, LAWS, dead_time=0.15, adapt=None if no_adapt else "auto")
    written = json.loads(document.read_text(encoding="utf-8"))
    assert (written["track"], written["plant"]) == ("slalom", "carla-identified")
    cells = iter(_rows(table))
    for row, entry in zip(rows, written["laws"], strict=True):
        assert entry["law"] == row.law
        for run in ("prompt", "late", "predicted", "short", "long", "early", "later"):
            found, cell = getattr(row, run), next(cells)
            assert (cell["law"], cell["run"]) == (row.law, run)
            error = found.mean_abs_cross_track_error
            assert float(cell["mean_abs_cross_track_error"]) == error
            assert entry["runs"][run]["mean_abs_cross_track_error"] == error
            ratio = row.ratio(found) if found.finished else None
            assert entry["runs"][run]["ratio"] == ratio
            assert cell["ratio"] == ("" if ratio is None else repr(ratio))
