"""What a tuning's scores, tables and choices say, of figures whose right answers are known."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib.util import find_spec
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import tune
from popsteer.lab.common.varied import distribution
from popsteer.lab.tune import report, study
from popsteer.lab.tune.problem import Score, usual_search
from popsteer.lab.tune.report import Judged
from popsteer.lab.tune.study import Trial, Tuned
from tests.values.tables import STRAIGHT, cells

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

pytest.importorskip("scipy")

SEARCH = {"min_lookahead": "uniform(2,12)", "lookahead_gain": "loguniform(0.1,0.9)"}


def problem(**changes: Any) -> tune.Problem:
    given: dict[str, Any] = {
        "search": {name: distribution(name, text) for name, text in SEARCH.items()},
        "plant": sim.KinematicBicycle(),
        "vary": {},
        "cars": 1,
        "longitudinal": popsteer.SpeedPidParams(),
        **changes,
    }
    paths = given.pop("paths", {"straight": STRAIGHT})
    params = given.pop("base", popsteer.PopParams())
    return tune.Problem(paths, "pop", params, **given)


def score(errors: Mapping[str, Any], efforts: Mapping[str, Any]) -> Score:
    return Score(dict(errors), dict(efforts))


def trial(number: int, error: float, effort: float, ratio: float = 1.0, gain: float = 0.3) -> Trial:
    values = {"min_lookahead": 7.0, "lookahead_gain": gain}
    return Trial(number, values, error, effort, error, error, ratio)


USUAL = score({"a": (0.1, 0.3), "b": (0.2, 0.6)}, {"a": (0.1, 0.3), "b": (0.2, 0.2)})


def test_score_is_the_mean_of_mean_and_worst() -> None:
    assert USUAL.mean == pytest.approx(0.3)
    assert USUAL.worst == 0.6
    assert USUAL.error == pytest.approx(0.45)
    assert USUAL.effort == pytest.approx(0.2)


def test_effort_ratio_is_the_greatest_of_all_and_of_each_unvaried_car() -> None:
    busier = score(USUAL.errors, {"a": (0.1, 0.5), "b": (0.2, 0.2)})
    assert busier.effort_ratio(USUAL) == pytest.approx(1.25)
    shaky = score(USUAL.errors, {"a": (0.3, 0.1), "b": (0.2, 0.2)})
    assert shaky.effort_ratio(USUAL) == pytest.approx(3.0)


def test_front_has_the_trials_that_none_beats_in_both() -> None:
    tried = [trial(0, 0.5, 0.1), trial(1, 0.4, 0.3), trial(2, 0.4, 0.2), trial(3, 0.6, 0.05)]
    tried += [trial(4, 0.1, 0.9), trial(5, 0.2, 1.0)]
    found = Tuned(problem(), USUAL, tried, None, 1.1)
    assert [each.number for each in found.front] == [3, 0, 2, 4]


def test_tuning_that_was_chosen_is_said_with_its_values() -> None:
    chosen = trial(1, 0.2, 0.2, gain=0.123456)
    found = Tuned(problem(), USUAL, [trial(0, 0.5, 0.1), chosen], chosen, 1.1)
    assert report.caption(found) == (
        "pop, the best of 2 trials: min_lookahead 7, lookahead_gain 0.1235"
    )
    assert found.params == popsteer.PopParams(min_lookahead=7.0, lookahead_gain=0.123456)
    none = Tuned(problem(), USUAL, [trial(0, 0.5, 0.1)], None, 1.1)
    assert "none of 1 trials is better within 1.1 times" in report.caption(none)
    assert none.params == popsteer.PopParams()


def test_table_has_means_worsts_and_efforts_before_and_after() -> None:
    after = score({"a": (0.05, 0.15), "b": (0.3, 12.0)}, {"a": (0.2, 0.2), "b": (0.4, 0.6)})
    two = problem(paths={"a": STRAIGHT, "b": STRAIGHT})
    one = problem(paths={"c": STRAIGHT})
    unseen = score({"c": (1.0, 3.0)}, {"c": (0.5, 0.7)})
    judged = [Judged(two, USUAL, after, True), Judged(one, unseen, unseen, False)]
    (shown,) = report.tables(judged)
    _, first, second, third = cells(shown)
    assert first == ["a", "yes", "0.2000", "0.1000", "0.3000", "0.1500", "0.2000", "0.2000"]
    assert second == ["b", "yes", "0.4000", "6.1500", "0.6000", "12.0", "0.2000", "0.5000"]
    assert third[:4] == ["c", "no", "2.0000", "2.0000"]
    cars = [Judged(two, USUAL, after, True), Judged(two, USUAL, after, False)]
    seen = [line[1] for line in cells(report.tables(cars)[0])[1:]]
    assert seen == ["yes", "yes", "cars no", "cars no"]


def test_losses_of_mean_worst_and_steering_are_told_each_from_its_own_share_on() -> None:
    base = problem(cars=2)

    def told(mean: float, worst: float, effort: float) -> list[str]:
        old = score({"straight": (0.1, 0.1, 0.4)}, {"straight": (0.2,)})
        rest = 0.5 * (3.0 * mean - worst)
        new = score({"straight": (rest, rest, worst)}, {"straight": (effort,)})
        return report.losses([Judged(base, old, new, True)])

    none = (
        "On none of these tracks is mean error more than 2 % and 0.001 m, worst error more than 5 %"
        " and 0.001 m or steering more than 10 % above before."
    )
    assert told(0.2039, 0.419, 0.219) == [none]
    assert told(0.2041, 0.4, 0.2) == [
        "Mean error more than 2 % and 0.001 m above before: straight 0.2000 → 0.2041 m."
    ]
    assert told(0.19, 0.421, 0.2) == [
        "Worst error more than 5 % and 0.001 m above before: straight 0.4000 → 0.4210 m."
    ]
    assert told(0.19, 0.4, 0.221) == [
        "Steering more than 10 % above before: straight 0.200 → 0.221 rad/s."
    ]
    assert len(told(0.3, 0.6, 0.3)) == 3
    # Less than a millimetre is no loss, however little there was.
    errors = 1e-3, 1.9e-3, 2.1e-3
    least, near, far = (score({"straight": (e,)}, {"straight": (0.2,)}) for e in errors)
    assert report.losses([Judged(base, least, near, True)]) == [none]
    assert len(report.losses([Judged(base, least, far, True)])) == 2


def test_starts_of_the_cars_that_differ_are_told_as_they_are_drawn() -> None:
    drawn = {"start_offset": distribution("start_offset", "uniform(-1,1)")}
    ((_, itself, others),) = problem(vary=drawn).beginnings()
    assert itself.startswith("Starts with the front axle on the path, at ")
    begun = "Starts with the front axle left of the path by start_offset uniform(-1.0,1.0) m, "
    assert others.startswith(begun)
    found = Tuned(problem(vary=drawn), USUAL, [], None, 1.1)
    assert f"The cars that differ: s{others[1:]}" in report.notes(found, [])
    for same in (problem(vary=drawn, cars=0), problem()):
        assert same.beginnings() == [("straight", itself, "")]
    # What starts otherwise is told by its track.
    back = popsteer.Path([(float(-x), 0.0) for x in range(81)], speed=[-3.0] * 81)
    two = problem(paths={"straight": STRAIGHT, "back": back})
    found = Tuned(two, USUAL, [], None, 1.1)
    starts = [note for note in report.notes(found, []) if "tarts" in note]
    assert [note.partition(" with ")[0] for note in starts] == [
        "On straight: starts",
        "On back: starts",
    ]


def test_end_of_the_search_is_told_at_either_end() -> None:
    for values, said in (
        ({"min_lookahead": 2.1, "lookahead_gain": 0.5}, "min_lookahead"),
        ({"min_lookahead": 11.9, "lookahead_gain": 0.5}, "min_lookahead"),
        ({"min_lookahead": 7.0, "lookahead_gain": 0.89}, "lookahead_gain"),
    ):
        chosen = trial(0, 0.1, 0.1)._replace(values=values)
        found = Tuned(problem(), USUAL, [chosen], chosen, 1.1)
        told = [note for note in report.notes(found, []) if "search farther" in note]
        assert len(told) == 1, values
        assert told[0].startswith(said)


def test_usual_search_is_a_quarter_to_four_times_each_value() -> None:
    params, car = popsteer.PreviewPopParams(), popsteer.Vehicle(wheelbase=2.7)
    resolved = params.resolved(car).as_dict()
    for name, each in usual_search("preview-pop", params, car).items():
        assert each.bounds == pytest.approx((resolved[name] / 4, resolved[name] * 4)), name
        assert each.name == "loguniform"
    gain = usual_search("pop", popsteer.PopParams(lookahead_gain=0.0), car)["lookahead_gain"]
    assert gain.bounds == (0.0, 1.0)


def test_run_that_does_not_finish_scores_worse_than_any_that_does() -> None:
    # Before it has settled, and long after; a plant in Python goes another way.
    plants: list[Any] = [sim.KinematicBicycle()]
    if find_spec("vehiclemodels"):
        plants.append(sim.geometry.object_of("commonroad-st-1"))
    for plant in plants:
        for limit in (1.0, 9.0):
            short = problem(
                plant=plant, constant_speed=4.0, settings=sim.Settings(time_limit=limit)
            )
            assert short.score(popsteer.PopParams()).errors["straight"] == (100.0, 100.0)


def test_choice_is_the_least_error_within_the_effort_and_never_unfinished() -> None:
    pytest.importorskip("optuna")
    # Standing in for runs: the error rises with the lookahead, the effort is high below 6 m.
    base = problem(base=popsteer.PopParams(min_lookahead=9.0))

    def fake(params: popsteer.PopParams, progress: object = None) -> Score:
        far = params.resolved(base.given).min_lookahead or 0.0
        error = 100.0 if far < 4.0 else 0.05 * far
        return score({"straight": (error,)}, {"straight": (1.2 if far < 6.0 else 1.0,)})

    object.__setattr__(base, "score", fake)
    found = tune.run(base, trials=60)
    assert found.chosen is not None
    assert 6.0 <= found.chosen.values["min_lookahead"] < 7.5
    assert found.chosen.error < found.usual.error
    best = min(each.error for each in found.trials if each.ratio <= 1.1)
    assert found.chosen.error == best
    assert found.chosen.mean == found.chosen.worst == found.chosen.error


def test_processes_that_join_a_study_draw_otherwise_than_the_first_and_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("optuna")
    base = problem()
    monkeypatch.setattr(tune.Problem, "score", lambda *_: USUAL)
    tune.run(base, tmp_path / "first", trials=2)
    drawn = []
    for process in (None, 11, 12):
        file = tmp_path / f"joined-{process}"
        if process is not None:
            monkeypatch.setattr("os.getpid", lambda process=process: process)
            file.write_bytes((tmp_path / "first").read_bytes())
        count = 2 if process is None else 4
        drawn.append([each.values for each in tune.run(base, file, trials=count).trials[-2:]])
    values = [each["min_lookahead"] for pair in drawn for each in pair]
    assert len(set(values)) == 6


def test_searches_of_other_seeds_draw_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("optuna")
    monkeypatch.setattr(tune.Problem, "score", lambda *_: USUAL)
    # 64 apart and more: each has numbers of its own, and the same ones again.
    drawn = [
        tune.run(problem(seed=seed), trials=1).trials[0].values for seed in (3, 67, 2**20 + 3, 3)
    ]
    assert drawn[0] == drawn[3]
    assert len({each["min_lookahead"] for each in drawn}) == 3


def test_near_the_best_stays_in_bounds_and_differs_by_trial() -> None:
    base = problem()
    tried = [trial(k, 1.0 / (k + 1), 0.1) for k in range(22)]
    found = [study._near_the_best(base, tried[:count], 1.1) for count in range(15, 23)]
    assert [each is None for each in found] == [count % 3 == 0 for count in range(15, 23)]
    proposed = [each for each in found if each is not None]
    for each in proposed:
        assert 2.0 <= each["min_lookahead"] <= 12.0
        assert 0.1 <= each["lookahead_gain"] <= 0.9
    assert len({each["min_lookahead"] for each in proposed}) == len(proposed)
    assert study._near_the_best(base, tried[:14], 1.1) is None
    assert study._near_the_best(base, [each._replace(ratio=2.0) for each in tried], 1.1) is None
    near = np.array([[each[name] for name in SEARCH] for each in proposed])
    assert np.median(np.abs(near[:, 0] - 7.0)) < 3.0


def test_search_lets_interrupts_and_full_disks_be_what_they_are() -> None:
    """Whatever a study's own bookkeeping makes of them."""

    def failing(first: BaseException) -> Any:
        def optimize(*_: object, **__: object) -> None:
            error = ValueError("bookkeeping")
            error.__context__ = first
            raise error

        return SimpleNamespace(optimize=optimize)

    def search(first: BaseException) -> None:
        study._optimize(failing(first), None, 1.0, None, "trials.journal")

    with pytest.raises(KeyboardInterrupt):
        search(KeyboardInterrupt())
    for name, said in ((None, "trials.journal"), ("other.file", "other.file")):
        with pytest.raises(OSError, match="No space") as full:
            search(OSError(28, "No space", name))
        assert (full.value.errno, full.value.filename) == (28, said)
    with pytest.raises(ValueError, match="bookkeeping"):
        search(KeyError("x"))


def test_numbers_of_a_search_are_refused_beyond_their_ends() -> None:
    for seconds in (0.0, -1.0, 1e9, float("nan")):
        with pytest.raises(ConfigError, match="--seconds"):
            study._check(1, seconds, 1.1)
    for trials in (0, -1, 10**9):
        with pytest.raises(ConfigError, match="--trials"):
            study._check(trials, None, 1.1)
    for limit in (0.0, 1e3 + 1.0, float("nan")):
        with pytest.raises(ConfigError, match="--effort-limit"):
            study._check(None, None, limit)
    study._check(1, 0.999e9, 1e3)
    study._check(None, 1e-9, 1e-9)


def test_table_names_each_track_and_whether_the_search_saw_it() -> None:
    base = problem()
    other = problem(paths={"bend": STRAIGHT})
    one = score({"straight": (9.99994, 12.34)}, {"straight": (0.1, 0.3)})
    two = score({"bend": (0.5, 0.7)}, {"bend": (0.1, 0.1)})
    judged = [Judged(base, one, one, True), Judged(base, one, one, False)]
    judged.append(Judged(other, two, two, False))
    rows = cells(report.tables(judged)[0])[1:]
    assert [row[0] for row in rows] == ["straight", "straight", "bend"]
    assert [row[1] for row in rows] == ["yes", "cars no", "no"]
    assert rows[0][2:] == ["11.2", "11.2", "12.3", "12.3", "0.2000", "0.2000"]
    assert rows[2][2:] == ["0.6000", "0.6000", "0.7000", "0.7000", "0.1000", "0.1000"]
    assert (report._number(9.99994), report._number(10.0)) == ("9.9999", "10.0")


def test_loss_of_effort_is_told_beyond_a_tenth() -> None:
    for factor, told in ((1.1, False), (1.1001, True)):
        before = score({"straight": (0.5,)}, {"straight": (0.2,)})
        after = score({"straight": (0.5,)}, {"straight": (factor * 0.2,)})
        (said,) = report.losses([Judged(problem(), before, after, True)])
        assert said.startswith("Steering more") == told, factor


def test_run_whose_error_or_effort_alone_is_no_number_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    base = problem(cars=0)
    for error, effort, ended, refused in (
        (0.1, math.nan, True, True),
        (math.nan, 0.1, True, True),
        (0.1, 0.2, True, False),
        (math.nan, math.nan, False, False),
    ):
        answers = [(ended,), (error,), (effort,)]
        figures = {
            name: np.array(values)
            for name, values in zip(
                ("finished", "settled_mean_abs_cross_track_error", "rms_steer_rate"),
                answers,
                strict=True,
            )
        }
        monkeypatch.setattr(sim, "run_many", lambda *_, figures=figures, **__: figures)
        if refused:
            with pytest.raises(PopsteerError, match="straight: a run is over within"):
                base.score(base.base)
        else:
            found = base.score(base.base)
            assert found.errors == {"straight": (error if ended else 100.0,)}
            assert found.efforts == {"straight": (effort if ended else 100.0,)}


def test_cars_of_a_problem_have_noise_of_their_own_the_same_on_every_track() -> None:
    vary = {"noise_yaw": distribution("noise_yaw", "uniform(0.001,0.01)")}
    paths = {"a": STRAIGHT, "b": STRAIGHT}
    scenarios = problem(paths=paths, vary=vary, cars=3, seed=5).scenarios
    assert [name for name, *_ in scenarios] == ["a"] * 4 + ["b"] * 4
    seeds = [seed for *_, seed in scenarios]
    assert seeds[:4] == seeds[4:]
    assert len(set(seeds)) == 4
    assert set(seeds).isdisjoint(s for *_, s in problem(paths=paths, cars=3, seed=6).scenarios)
    noises = [made.noise for _, _, made, _ in scenarios]
    assert noises[0] is noises[4] is None
    assert [each.yaw for each in noises[1:4]] == [each.yaw for each in noises[5:]]
    assert len({each.yaw for each in noises[1:4]}) == 3


def test_judging_takes_other_cars_and_only_tracks_that_have_what_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scored: list[tuple[tune.Problem, Any]] = []

    def count(self: tune.Problem, params: Any, *_: Any) -> Score:
        scored.append((self, params))
        return USUAL

    monkeypatch.setattr(tune.Problem, "score", count)
    chosen = trial(1, 0.2, 0.2)
    told: list[float] = []
    for kind, cars in (("SpeedPidParams", 1), ("CoupledLongitudinalParams", 1), ("both", 0)):
        pedals = None if kind == "both" else getattr(popsteer, kind)()
        base = problem(seed=7, cars=cars, longitudinal=pedals)
        scored.clear()
        told.clear()
        judged = report.judge(
            Tuned(base, USUAL, [chosen], chosen, 1.1),
            lambda _, share: told.append(share),
        )
        parts = [each.problem for each in judged]
        assert [each.seen for each in judged] == [True] + [False] * (len(parts) - 1)
        assert parts[0] is base
        assert [each.seed == 7 for each in parts] == [True] + [False] * (len(parts) - 1)
        tracks = [name for name in popsteer.tracks.names() if name != "straight"]
        speeds = [name for name in tracks if popsteer.tracks.get(name).speed is not None]
        shown = speeds if kind == "SpeedPidParams" else tracks
        names = [["straight"]] * (1 + bool(cars)) + ([shown] if shown else [])
        assert [[*each.paths] for each in parts] == names, kind
        tunings = [params for _, params in scored]
        assert tunings == [popsteer.PopParams(), base.changed(chosen.values)] * len(parts)
        assert told == pytest.approx([k / len(parts) for k in range(len(parts))])


def test_search_tells_the_trial_and_the_greater_share_of_trials_and_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("optuna")

    def score(_: Any, params: Any, progress: Any = None) -> Score:
        if progress is not None:
            progress(0.5)
        return USUAL

    monkeypatch.setattr(tune.Problem, "score", score)
    told: list[tuple[str, float]] = []
    for trials, seconds, shares in (
        (2, None, [0.25, 0.75]),
        (2, 100.0, [0.25, 0.75]),
        (2, 12.0, [8.0 / 12.0, 1.0]),
    ):
        clock = iter(np.arange(0.0, 1e4, 8.0)).__next__
        monkeypatch.setattr(study, "time", SimpleNamespace(monotonic=clock))
        told.clear()
        tune.run(
            problem(),
            trials=trials,
            seconds=seconds,
            progress=lambda what, share: told.append((what, share)),
        )
        assert [what for what, _ in told] == ["trial 1", "trial 2"]
        assert [share for _, share in told] == pytest.approx(shares)


def test_whole_numbers_of_a_tuning_stay_whole_and_the_others_as_they_are() -> None:
    search = {"buffer_length": distribution("buffer_length", "uniform(5,40)")}
    base = replace(problem(), controller="pid", base=popsteer.PidParams(), search=search)
    for drawn, whole in ((6.4, 6), (6.6, 7), (40.0, 40)):
        found: Any = base.changed({"buffer_length": drawn, "kp": 0.01 * drawn})
        assert (found.buffer_length, found.kp) == (whole, 0.01 * drawn)
        assert isinstance(found.buffer_length, int)


def test_trial_at_the_limit_of_the_effort_is_within_it_and_the_first_of_equals_best() -> None:
    trials = [
        Trial(k, {}, error, 1.0, error, error, ratio)
        for k, (error, ratio) in enumerate([(0.1, 1.2), (0.3, 1.0), (0.2, 1.1), (0.2, 1.1)])
    ]
    assert study._best_within(trials, 1.1) is trials[2]
    assert study._best_within(trials, 1.0) is trials[1]
    assert study._best_within(trials, 0.9) is None


def test_trials_beyond_the_edge_of_the_figure_are_counted_and_do_not_stretch_it() -> None:
    from popsteer.lab.common.theme import THEMES
    from popsteer.lab.tune.figure import tune_figure

    tried = [trial(0, 0.5, 0.1), trial(1, 0.4, 0.2), trial(2, 9.0, 7.0), trial(3, 70.0, 0.3)]
    found = Tuned(problem(cars=0), USUAL, tried, tried[1], 1.1)
    figure = tune_figure(found, THEMES["light"])
    (panel,) = figure.axes
    assert "trials (2 of 4)" in panel.get_legend_handles_labels()[1]
    assert panel.get_ylim()[1] < 9.0
    assert panel.get_xlim()[1] < 7.0
    figure = tune_figure(replace(found, trials=tried[:2]), THEMES["light"])
    assert "trials" in figure.axes[0].get_legend_handles_labels()[1]
