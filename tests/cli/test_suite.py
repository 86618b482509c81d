"""``popsteer suite``: what its conditions do, its cells, tables and files."""

from __future__ import annotations

import csv
import json
import math
import re
import shlex
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import lab, sim
from popsteer.errors import ConfigError
from popsteer.lab.suite.drive import GIVE_UP, drive
from popsteer.lab.suite.runs import Cell, _cell, leaders, mean_error, rows
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS, suite_car
from popsteer.lab.suite.table import sentences, suite_lines, worded
from studies.suite import losses
from tests.cli import command
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from pathlib import Path


class Spy:
    """Keeps what it is given, and commands what it is told."""

    def __init__(self, path: popsteer.Path, vehicle: popsteer.Vehicle) -> None:
        self.path, self.vehicle = path, vehicle
        self.seen: list[tuple[float, ...]] = []
        self.paths: list[popsteer.Path] = []
        self.steers = [0.0]

    def set_path(self, path: popsteer.Path) -> None:
        self.paths.append(path)

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
        self.seen.append((x, y, yaw, speed, dt))
        return self.steers[len(self.seen) % len(self.steers)]


def spied(
    condition: str,
    *,
    scenario: str = "beside",
    steers: tuple[float, ...] = (0.0,),
    plant: Any = None,
) -> Any:
    """Drive by a spy: the spy, and what was measured."""
    plant = suite_car() if plant is None else plant
    kept = []

    def make(path: popsteer.Path, vehicle: popsteer.Vehicle) -> Spy:
        kept.append(Spy(path, vehicle))
        kept[0].steers = list(steers)
        return kept[0]

    found = drive(SCENARIOS[scenario], CONDITIONS[condition], plant, make, seed=3)
    return kept[0], found


def test_conditions_are_what_their_titles_say() -> None:
    told, usual = spied("as told")
    car = suite_car().vehicle.replace(max_steer_rate=0.4, steer_lag=0.15)
    assert told.vehicle == car
    assert not told.paths
    exact = np.array(told.seen)

    assert spied("dead time told")[0].vehicle == car.replace(dead_time=0.15)
    late, _ = spied("dead time untold", steers=(0.3,))
    prompt, _ = spied("as told", steers=(0.3,))
    assert late.vehicle == car
    turned = [
        np.flatnonzero(np.abs(np.array(each.seen)[:, 2]) > 1e-6)[0] for each in (late, prompt)
    ]
    assert turned[0] - turned[1] == 3  # periods of 0.05 s

    for share, name in ((1.2, "wheelbase +20 %"), (0.8, "wheelbase -20 %")):
        assert spied(name)[0].vehicle == car.replace(wheelbase=share * car.wheelbase)
        identified = sim.CarlaIdentified()
        turning = identified.vehicle.turning_wheelbase
        assert turning is not None
        given, _ = spied(name, plant=identified)
        assert given.vehicle.turning_wheelbase == share * turning

    noise = np.array(spied("noise")[0].seen)[:200] - exact[:200]
    assert noise[:, :2].std() == pytest.approx(0.05, rel=0.15)
    assert noise[:, 2].std() == pytest.approx(0.01, rel=0.15)
    assert not noise[:, 3:].any()

    lost, _ = spied("loss")
    share = len(lost.seen) / len(told.seen)
    assert share == pytest.approx(0.8, abs=0.06)
    # It is told for how long there was none.
    periods = np.array(lost.seen)[:, 4]
    assert periods.sum() == pytest.approx(0.05 * len(told.seen), abs=0.2)
    assert periods.max() > 0.09

    fresh, _ = spied("fresh path")
    assert len(fresh.paths) == len(fresh.seen)
    change = np.array([each.y for each in fresh.paths[:50]])
    assert change.std() == pytest.approx(0.02, rel=0.05)
    assert (fresh.paths[0].y != fresh.paths[1].y).all()
    assert np.array(fresh.seen) == pytest.approx(exact)
    # Not the exact path, where nothing takes a fresh one either.
    assert fresh.path.y.std() == pytest.approx(0.02, rel=0.3)
    smoothed, _ = spied("smoothed path")
    # The middle of a quadratic through seven points has 1/3 of their variance.
    change = np.array([each.y[10:-10] for each in smoothed.paths[:50]])
    assert change.std() == pytest.approx(0.02 / math.sqrt(3.0), rel=0.05)

    # The slope pushes back; the tracker of the speed makes up for it.
    steep, climbed = spied("slope")
    assert np.array(steep.seen)[8:20, 3].min() < exact[8:20, 3].min() - 0.05
    assert climbed.metrics.finished == usual.metrics.finished


def test_play_takes_up_small_commands_and_passes_on_the_rest() -> None:
    half = math.radians(0.5)
    still, _ = spied("play", steers=(0.9 * half, -0.9 * half))
    assert (np.array(still.seen)[:, 2] == 0.0).all()
    moved, _ = spied("play", steers=(3.0 * half,))
    exact, _ = spied("as told", steers=(2.0 * half,))
    assert np.array(moved.seen)[:, 2] == pytest.approx(np.array(exact.seen)[:, 2])


def test_noise_and_losses_are_the_same_for_every_controller() -> None:
    first, second = (np.array(spied("noise", steers=each)[0].seen) for each in ((0.0,), (0.1,)))
    assert first[0] == pytest.approx(second[0])
    assert first[0, 1] != pytest.approx(2.0, abs=1e-3)


def test_figures_of_a_run_are_those_of_its_records() -> None:
    _, found = spied("as told", steers=(0.0, 0.01))
    rate = 0.01 / 0.05
    assert found.steer_rate == pytest.approx(rate, rel=0.01)
    assert found.wheelbase == 2.7
    assert found.faults == 0.0
    _, straight = spied("as told")
    assert straight.lateral_jerk == 0.0
    assert straight.end_error == pytest.approx(2.0)
    assert straight.metrics.rear_axle_mean_abs_cross_track_error == pytest.approx(2.0)


def test_controller_that_raises_ends_its_run_with_its_traceback() -> None:
    class Broken(Spy):
        def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
            raise ZeroDivisionError("mine")

    found = drive(SCENARIOS["slalom"], CONDITIONS["as told"], suite_car(), Broken)
    assert found.ending == "raised ZeroDivisionError: mine"
    assert "in step" in found.traceback
    assert not found.metrics.finished


@looped("steer", (math.nan, math.inf, "left"))
def test_controller_that_crashes_has_the_worst_cell_not_the_best(steer: Any) -> None:
    class Crashing(Spy):
        def step(self, x: float, y: float, yaw: float, speed: float, dt: float) -> float:
            self.seen.append((x, y, yaw, speed, dt))
            return 0.0 if len(self.seen) == 1 else steer

    found = drive(SCENARIOS["slalom"], CONDITIONS["as told"], suite_car(), Crashing)
    cell = _cell("slalom", "as told", "suite-car", "crashing", found)
    assert (cell.mean_error, cell.success, found.ending[:6]) == (GIVE_UP, False, "raised")
    assert found.metrics.steps == 1


def test_success_counts_faults_as_a_sweep_does() -> None:
    _, found = spied("as told", scenario="step-steer")
    driven = drive(SCENARIOS["step-steer"], CONDITIONS["as told"], suite_car(), popsteer.PreviewPop)
    kept = [_cell("step-steer", "as told", "suite-car", "x", each) for each in (found, driven)]
    assert [each.success for each in kept] == [False, True]
    assert not _cell("slalom", "noise", "car", "x", driven._replace(faults=0.01)).success
    # Half a wheelbase, or where it started and a tenth of a metre more.
    beside = next(name for name, each in SCENARIOS.items() if each.start_offset)
    for scenario, largest, is_success in (
        ("slalom", 1.34, True),
        ("slalom", 1.36, False),
        (beside, 2.09, True),
        (beside, 2.11, False),
    ):
        metrics: Any = SimpleNamespace(
            finished=True,
            rear_axle_mean_abs_cross_track_error=0.1,
            rear_axle_max_abs_cross_track_error=largest,
        )
        cell = _cell(scenario, "noise", "car", "x", driven._replace(metrics=metrics))
        assert cell.success == is_success, (scenario, largest)


def test_ties_are_told_from_leads() -> None:
    draws = np.exp(np.random.default_rng(1).normal(0.0, 1.0, 30))
    noise = np.exp(np.random.default_rng(2).normal(0.0, 0.3, 30))
    for share, names in ((1.02, ["a", "b"]), (1.5, ["a"])):
        cells = {
            "a": [cell("a", 0.01 * each) for each in draws],
            "b": [
                cell("b", 0.01 * share * each * by) for each, by in zip(draws, noise, strict=True)
            ],
            "c": [cell("c", 0.02 * each) for each in draws],
        }
        assert sorted(leaders(cells)) == names


@looped("name", list(SCENARIOS))
def test_scenarios_are_driven_by_preview_pop_to_their_end(name: str) -> None:
    found = drive(SCENARIOS[name], CONDITIONS["as told"], suite_car(), popsteer.PreviewPop)
    assert found.metrics.finished, found.ending
    assert found.metrics.rear_axle_max_abs_cross_track_error < 2.1
    assert found.end_error < 0.05
    assert found.faults == 0.0


def cell(controller: str, error: float, *, success: bool = True, condition: str = "noise") -> Cell:
    return Cell(
        "slalom", condition, "car", controller, error, 2.0 * error, 0.0, 0.1, 1.0, 0.0, success, ""
    )


def test_sentences_are_of_the_rows_beside_them() -> None:
    found = lab.suite.Suite("standard-2", [cell("mine", 0.02)], {"mine": 1e-6}, [])
    assert sentences(found) == []
    cells = [cell("mine", 0.02), cell("theirs", 0.01), cell("fast", 0.03)]
    cells += [cell(name, 0.01, condition="play") for name in ("mine", "theirs")]
    cells.append(cell("fast", 0.05, condition="play"))
    best = "The least error over all runs is that of theirs, 0.0100 m"
    assert sentences(lab.suite.Suite("standard-2", cells, {}, [])) == [
        f"{best}, the next that of mine, 0.0141 m: a tie.",
        "theirs alone has the least: Noise of 5 cm and 0.01 rad.",
        "Ties for the least: Slalom (mine, theirs); Play of 1° (mine, theirs).",
        "Behind the least in every row: fast.",
    ]


def test_losses_are_to_the_best_that_succeeded() -> None:
    cells = [cell("mine", 0.02), cell("theirs", 0.01), cell("fast", 0.001, success=False)]
    cells += [cell("mine", 0.0115, condition="play"), cell("theirs", 0.0105, condition="play")]
    cells.append(cell("fast", 0.001, success=False, condition="play"))
    found = lab.suite.Suite("standard-2", cells, {"mine": 1e-6, "theirs": 1e-6, "fast": 1e-6}, [])
    assert [(a.mean_error, b.controller) for a, b in losses(found, "mine")] == [(0.02, "theirs")]
    assert losses(found, "theirs") == []
    assert len(losses(found, "mine", 0.0)) == 1
    less = lab.suite.Suite("standard-2", [cell("a", 2e-4), cell("b", 1e-4)], {}, [])
    assert [len(losses(less, "a", more)) for more in (0.001, 0.0)] == [0, 1]
    two = [cell("mine", 0.01), cell("mine", 0.04, success=False)]
    assert mean_error(two) == pytest.approx(0.02)
    assert worded(two) == "0.0200 (1)"
    assert [title for title, _ in rows(found)] == [
        "Slalom",
        "Noise of 5 cm and 0.01 rad",
        "Play of 1°",
        "All",
    ]
    both = [replace(each, plant=plant) for each in cells for plant in ("car", "bus")]
    by_plant = rows(lab.suite.Suite("standard-2", both, found.step_times, []))[3:]
    assert [title for title, _ in by_plant] == ["On car", "On bus", "All"]
    assert {each.plant for each in by_plant[1][1]["mine"]} == {"bus"}
    # None of two cells each leads alone, where it does not lead in both.
    slalom = next(line for line in suite_lines(found) if line.startswith("| Slalom"))
    assert slalom == "| Slalom | 0.0152 | 0.0102 | **0.0010 (2)** |"


def test_suite_writes_its_cells_and_one_is_repeated_alone(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "mine.py").write_text("def mine(path, vehicle):\n    raise ZeroDivisionError\n")
    # Wheels that stand have no place on a logarithmic axis.
    still = "class Still:\n    step = lambda self, *_: 0.0\n    __init__ = lambda self, *_: None\n"
    (tmp_path / "still.py").write_text(still)
    one = ("suite", "--scenarios", "hairpin", "--controllers")
    outcome = command.call(
        capsys,
        *one,
        f"{tmp_path / 'still.py'}:Still,preview-pop,{tmp_path / 'mine.py'}:mine",
        *("--conditions", "as told,noise", "--out", str(tmp_path)),
    )
    assert outcome.status == 0
    assert "12 runs on suite-car, carla-identified" in " ".join(outcome.out.split())
    assert "nan" not in outcome.out  # what raised at once has neither rate nor jerk
    last = next(line for line in outcome.out.splitlines() if line.startswith("lateral jerk"))
    assert re.fullmatch(r"lateral jerk, rms \[m/s³\] +[\d.]+ +[\d.]+ +–", last)
    document = json.loads((tmp_path / "suite.json").read_text(encoding="utf-8"))
    assert (document["schema"], document["suite"]) == ("popsteer-suite/1", "standard-2")
    lines = (tmp_path / "suite.csv").read_text(encoding="utf-8").splitlines()[1:]
    table = list(csv.DictReader(lines))
    assert len(table) == len(document["cells"]) == 12
    broken = 0
    for row, each in zip(table, document["cells"], strict=True):
        assert row["controller"] == each["controller"]
        if each["ending"] == "raised ZeroDivisionError":
            broken += 1
            assert (row["mean_error"], each["mean_error"], each["success"]) == ("10.0", 10.0, False)
        else:
            assert float(row["mean_error"]) == each["mean_error"]
    assert broken == 4
    assert [k for k, v in document["step_times"].items() if v is None] == [each["controller"]]
    again = lab.suite.run(
        ["preview-pop"], ["suite-car"], scenarios=["hairpin"], conditions=["noise"]
    )
    kept = next(
        each
        for each in document["cells"]
        if (each["controller"], each["condition"], each["plant"])
        == ("preview-pop", "noise", "suite-car")
    )
    assert again.cells[0] == Cell(**kept)


def test_commands_of_the_page_are_taken(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    block = page.partition("```sh\n")[2].partition("```")[0]
    commands = [shlex.split(line, comments=True)[1:] for line in block.splitlines()]
    asked: list[Any] = []

    def run(*given: Any, **more: Any) -> None:
        asked.append((given, more))
        raise ZeroDivisionError

    monkeypatch.setattr(lab.suite, "run", run)
    for words in commands[:1] + commands[2:]:
        with pytest.raises(ZeroDivisionError):
            command.call(capsys, *words)
    (own, _), ((one, plants), chosen) = asked
    assert list(own[0]) == list(popsteer.controllers.names())
    assert (list(one), list(plants)) == (["stanley"], ["suite-car"])
    assert (chosen["scenarios"], chosen["conditions"]) == (["hairpin"], ["noise"])
    assert commands[1][:4] == [*commands[0], "--controllers", "preview-pop,mine.py:Mine", "--out"]


def test_suite_refuses_what_it_does_not_know(capsys: pytest.CaptureFixture[str]) -> None:
    for words, said in (
        (("suite", "--scenarios", "moose"), "unknown scenario 'moose'"),
        (("suite", "--conditions", "rain"), "unknown condition 'rain'"),
        (("suite", "--conditions", ""), "--conditions must be names"),
        (
            ("suite", "--scenarios", "parking-bay", "--plants", "carla-identified"),
            "one that drives backwards",
        ),
        (("compare", "--suite", "standard-2"), "No such option: --suite; it is popsteer suite now"),
    ):
        outcome = command.call(capsys, *words)
        assert (outcome.status, said in outcome.err) == (2, True), outcome.err
    with pytest.raises(ConfigError, match="controllers"):
        lab.suite.run([], ["suite-car"])
    with pytest.raises(ConfigError, match=r"scenarios must be at least one, got \[\]"):
        lab.suite.run(["pop"], ["suite-car"], scenarios=[])
    assert sim.vehicle_of(suite_car()).wheelbase == 2.7
