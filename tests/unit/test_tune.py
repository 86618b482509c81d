"""Tuning: what is found is better, where it is judged by what it has not seen too."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import sim, tracks
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import tune
from popsteer.lab.common.varied import distribution
from popsteer.lab.tune.report import judge, losses
from popsteer.lab.tune.study import Trial, Tuned

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("scipy")

LAG = {"steer_lag": distribution("steer_lag", "uniform(0.05,0.15)")}


def _problem(track: str = "racetrack", cars: int = 1, **changes: Any) -> tune.Problem:
    shipped = tracks.get(track)
    path = popsteer.Path(shipped.xy, speed=shipped.speed)
    params = popsteer.PopParams()
    plant = sim.CarlaIdentified()
    given: dict[str, Any] = {
        "search": tune.usual_search("pop", params, plant.vehicle),
        "vary": LAG,
        "cars": cars,
        **changes,
    }
    given = {"paths": {track: path}, "plant": plant, **given}
    return tune.Problem(controller="pop", base=params, **given)


def test_pop_is_tuned_to_a_fifth_of_its_error_with_hardly_more_steering() -> None:
    pytest.importorskip("optuna")
    found = tune.run(_problem(), trials=100)
    # The vehicle itself, without those that differ from it.
    before, after = found.usual, found.problem.score(found.params)
    assert after.errors["racetrack"][0] <= before.errors["racetrack"][0] / 5
    assert after.efforts["racetrack"][0] <= 1.1 * before.efforts["racetrack"][0]
    assert found.chosen is not None
    assert found.chosen.error == after.error
    efforts = [trial.effort for trial in found.front]
    errors = [trial.error for trial in found.front]
    assert efforts == sorted(efforts)
    assert errors == sorted(errors, reverse=True)


def test_score_is_that_of_single_runs() -> None:
    problem = _problem("slalom", cars=2)
    params = popsteer.PopParams(min_lookahead=7.0)
    score = problem.score(params)
    path = problem.paths["slalom"]
    start = sim.default_start(path, 0.0, problem.given)
    nominal = sim.run(popsteer.Pop(path, params=params), start=start).metrics
    assert score.errors["slalom"][0] == nominal.settled_mean_abs_cross_track_error
    assert score.efforts["slalom"][0] == nominal.rms_steer_rate
    assert len(set(score.errors["slalom"])) == 3
    assert score.worst == max(score.errors["slalom"])
    assert score.effort_ratio(score) == 1.0
    unfinished = _problem("slalom", settings=sim.Settings(time_limit=1.0)).score(params)
    assert unfinished.mean == 100.0


def test_score_without_evidence_is_refused_and_ends() -> None:
    pytest.importorskip("optuna")
    # A path that is over before the vehicle has joined it.
    stub = popsteer.Path([(0.0, 0.0), (3.5, 0.0)])
    with pytest.raises(PopsteerError, match="stub: a run is over within the settling time"):
        tune.run(_problem(paths={"stub": stub}), trials=3)


def test_document_has_all_that_changes_a_score() -> None:
    problem = _problem("slalom")
    assert {each.name for each in fields(problem)} <= set(problem.document)
    path = problem.paths["slalom"]
    closed = popsteer.Path(
        np.column_stack((path.x, path.y)), speed=path.speed, closed=not path.closed
    )
    late = problem.plant.vehicle.replace(dead_time=0.1)
    for changes in (
        {"paths": {"slalom": closed}},
        {"plant": sim.CarlaIdentified(late)},
        {"vehicle": late},
        {"constant_speed": 5.0},
        {"settings": sim.Settings(settling_time=2.0)},
        {"adapt": None},
        {"seed": 3},
    ):
        assert _problem("slalom", **changes).document != problem.document, changes


def test_same_seed_gives_the_same_trials_and_goes_on(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    problem = _problem("slalom")
    one = tune.run(problem, tmp_path / "one.journal", trials=5)
    assert one.trials == tune.run(problem, trials=5).trials
    more = tune.run(problem, tmp_path / "one.journal", trials=8)
    assert list(more.trials[:5]) == list(one.trials)
    assert len(more.trials) == 8
    assert tune.run(problem, tmp_path / "one.journal", trials=8).trials == more.trials


def test_study_of_another_problem_or_no_study_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    file = tmp_path / "slalom.journal"
    tune.run(_problem("slalom"), file, trials=1)
    with pytest.raises(PopsteerError, match="holds another study, which differs in cars"):
        tune.run(_problem("slalom", cars=2), file, trials=1)
    file.write_text("x, y\n")
    with pytest.raises(PopsteerError, match="is no journal of Optuna"):
        tune.run(_problem("slalom"), file, trials=1)
    assert file.read_text() == "x, y\n"
    with pytest.raises(PopsteerError, match="no study can be opened there"):
        tune.run(_problem("slalom"), "nothing://nowhere", trials=1)


def test_killed_study_goes_on_and_processes_share_it(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    file = tmp_path / "shared.journal"
    command = [sys.executable, "-m", "popsteer", "tune", "--controller", "pop", "--cars", "1"]
    command += ["--tracks", "slalom", "--storage", str(file), "--trials", "100000"]
    killed = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while not file.exists() or file.stat().st_size < 4000:  # a few trials
        assert killed.poll() is None
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    command[-1] = "30"
    both = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for _ in range(2)]
    assert [each.wait() for each in both] == [0, 0]
    import optuna

    backend = optuna.storages.journal.JournalFileBackend(str(file))
    (study,) = optuna.get_all_study_summaries(optuna.storages.JournalStorage(backend))
    assert study.n_trials >= 30


def test_what_cannot_be_searched_is_refused() -> None:
    with pytest.raises(ConfigError, match="unknown parameter of pop 'lookahead'"):
        _problem(search={"lookahead": distribution("lookahead", "uniform(1,2)")})
    with pytest.raises(ConfigError, match=r"min_lookahead must be uniform\(LOW,HIGH\)"):
        _problem(search={"min_lookahead": distribution("min_lookahead", "normal(6,1)")})
    with pytest.raises(ConfigError, match="lookahead_gain must be in"):
        _problem(search={"lookahead_gain": distribution("lookahead_gain", "uniform(-1,1)")})
    with pytest.raises(ConfigError, match="cars must be"):
        _problem(cars=-1)


def _tuned(min_lookahead: float) -> Tuned:
    problem = _problem("slalom", search={"min_lookahead": distribution("m", "uniform(1,40)")})
    trial = Trial(0, {"min_lookahead": min_lookahead}, 0.1, 0.1, 0.1, 0.1, 1.0)
    return Tuned(problem, problem.score(problem.base), [trial], trial, 1.1)


def test_judge_says_where_a_tuning_loses() -> None:
    judged = judge(_tuned(30.0))
    assert [part.seen for part in judged] == [True, False, False]
    assert set(judged[2].problem.paths) == set(tracks.names()) - {"slalom"}
    assert "slalom" in losses(judged)[0]
    assert "racetrack (not seen)" in losses(judged)[0]


def test_full_disk_is_an_error_of_the_journal_which_goes_on_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    optuna = pytest.importorskip("optuna")
    backend = optuna.storages.journal.JournalFileBackend
    append, file, written = backend.append_logs, tmp_path / "slalom.journal", 0

    def full(self: Any, logs: Any) -> None:
        nonlocal written
        written += 1
        if written < 20:
            append(self, logs)
            return
        with file.open("ab") as stream:  # what fits of the line is there
            stream.write(b'{"op_code": 5, "wor')
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(backend, "append_logs", full)
        with pytest.raises(OSError, match="No space left on device") as raised:
            tune.run(_problem("slalom"), file, trials=30)
    assert raised.value.filename == str(file)
    assert len(tune.run(_problem("slalom"), file, trials=6).trials) == 6
