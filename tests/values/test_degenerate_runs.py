"""Runs that are too short, at rest, of one step or not a number: none counts as good."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.lab import replay, sweep, tune
from popsteer.lab.common.varied import distribution
from popsteer.lab.sweep import summary
from popsteer.lab.tune.problem import Score
from popsteer.logs import Log, LogError
from tests.values.tables import STRAIGHT, cells, job, row

pytest.importorskip("scipy")

SEARCH = {"min_lookahead": distribution("min_lookahead", "uniform(2,12)")}


def _problem(**changes: Any) -> tune.Problem:
    plant = sim.KinematicBicycle()
    given: dict[str, Any] = {"cars": 0, "longitudinal": popsteer.SpeedPidParams(), **changes}
    return tune.Problem({"a": STRAIGHT}, "pop", popsteer.PopParams(), SEARCH, plant, {}, **given)


def test_sweep_whose_runs_do_not_finish_has_no_success_and_no_settled_zero() -> None:
    one = job(vary={}, runs=2, start_offset=-2.44, settings=sim.Settings(time_limit=1.0))
    rows = sweep.run(one)
    assert [each["success"] for each in rows] == [False, False]
    for each in rows:
        assert not each["finished"]
        assert summary.error_of(each) == each["max_abs_cross_track_error"] > 1.0
    assert ": 0 of 2 runs succeeded" in summary.caption(one, rows)
    assert any("2 did not finish" in note for note in summary.notes(one, rows))
    found = summary.outcomes(rows)
    assert not found.good.any()
    assert not found.ended.any()


def test_run_with_a_fault_or_beyond_the_deviation_is_no_success() -> None:
    given: dict[str, Any] = {"vary": {}, "runs": 1, "constant_speed": 5.0, "start_offset": -2.44}
    one = job(**given)
    (good,) = sweep.run(one)
    assert good["success"]
    error = good[summary.ERROR]
    for deviation, success in ((1.001 * error, True), (0.999 * error, False)):
        (found,) = sweep.run(job(**given, deviation=deviation))
        assert found["success"] == success


def test_run_that_finishes_before_it_has_settled_counts_with_its_whole_error() -> None:
    early = row(0, math.nan, finished=True, max_abs_cross_track_error=0.7)
    assert summary.error_of(early) == 0.7
    assert summary.error_of(row(1, 0.2, finished=True, max_abs_cross_track_error=0.7)) == 0.2


def test_tables_of_nothing_finite_have_no_numbers() -> None:
    rows = [row(k, math.nan, finished=False, success=False) for k in range(3)]
    shares = cells(summary.tables(job(), rows)[0])
    assert all("nan" not in each for line in shares for each in line)
    # Of no run, and so no percentile.
    assert [line[1:] for line in shares[1:]] == [["0", *[""] * 4]] * 4
    assert math.isnan(summary.success_rate(0, 0).share)


def test_score_of_one_step_is_no_good_one_and_the_search_ends() -> None:
    pytest.importorskip("optuna")
    problem = _problem(settings=sim.Settings(time_limit=0.05))
    score = problem.score(problem.base)
    assert score.errors == {"a": (100.0,)}
    found = tune.run(problem, trials=3, seconds=20.0)
    assert len(found.trials) == 3
    assert found.chosen is None
    assert found.params == problem.base


def test_choice_leaves_out_what_is_not_a_number() -> None:
    usual = Score({"a": (0.5,)}, {"a": (0.2,)})
    lost = Score({"a": (100.0,)}, {"a": (0.0,)})
    assert lost.error > usual.error
    assert lost.effort_ratio(usual) == 0.0
    still = Score({"a": (0.5,)}, {"a": (0.0,)})
    assert usual.effort_ratio(still) > 1e6
    assert still.effort_ratio(still) == 0.0


def test_replay_of_a_log_that_hardly_moves_says_how_far_it_went() -> None:
    t = 0.1 * np.arange(40)
    for speed, said in ((0.0, "0.0 m of driving"), (1.0, "3.9 m of driving")):
        log = Log(t, speed * t, 0.0 * t, 0.0 * t, speed + 0.0 * t, 0.0 * t)
        with pytest.raises(LogError, match=said):
            replay.run(log, {"stanley": None}, popsteer.Vehicle())


def test_standing_still_in_a_log_adds_no_distance() -> None:
    t = 0.1 * np.arange(300)
    speed = np.where((t > 10.0) & (t < 20.0), 0.0, 2.0)
    x = np.cumsum(0.1 * speed)
    noisy = x + np.random.default_rng(0).normal(0.0, 0.02, 300)
    path = replay.own_path(Log(t, noisy, 0.0 * t, 0.0 * t, speed, 0.0 * t))
    assert path.length == pytest.approx(40.0, abs=1.0)
    assert np.diff(path.s) == pytest.approx([0.5] * (len(path) - 1), abs=0.1)


def test_identification_of_a_drive_that_shows_nothing_is_refused() -> None:
    t = 0.05 * np.arange(600)
    zero = 0.0 * t
    for x, speed in ((zero, zero), (8.0 * t, 8.0 + zero)):
        with pytest.raises(LogError, match=r"too short|too straight|changes by"):
            popsteer.identify(Log(t, x, zero, zero, speed, zero))


def test_run_of_one_step_has_metrics_of_that_step() -> None:
    run = sim.run(
        popsteer.Stanley(STRAIGHT),
        "kinematic-bicycle",
        start=(0.0, 0.3, 0.0),
        settings=sim.Settings(time_limit=0.05),
    )
    metrics = run.metrics
    assert (metrics.steps, metrics.finished) == (1, False)
    assert metrics.max_abs_cross_track_error == pytest.approx(0.3)
    assert math.isnan(metrics.settled_mean_abs_cross_track_error)
    assert run.ending == "time limit"
    assert metrics.time == pytest.approx(0.05)
