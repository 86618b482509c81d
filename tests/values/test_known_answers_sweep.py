"""A sweep's tables, notes and figures, of rows whose right answers are known by hand."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import Status, sim
from popsteer.lab.report import sweep
from popsteer.lab.report.sweep import _worst_table, verdict
from popsteer.lab.sweep import summary
from popsteer.lab.sweep.summary import ERROR
from tests.pages_of_html import Html
from tests.values.tables import cells, job, row

pytest.importorskip("scipy")

FAULT = int(Status.DEVIATING)
# Eight good runs; one with a fault; one that did not finish, whose settled error is no evidence.
ROWS = [row(k, 0.01 * (k + 1)) for k in range(8)]
ROWS += [row(8, 0.2, success=False, faults=FAULT), row(9, 0.0, success=False, finished=False)]
ROWS[9] |= {"max_abs_cross_track_error": 3.0}


def test_percentiles_are_of_values_that_occur_in_the_runs() -> None:
    rows = [row(k, float(value)) for k, value in enumerate((5, 1, 4, 2, 3, 9, 8, 7, 6, 10))]
    shown, _ = summary.tables(job(), rows)
    head, worst, mean, heading, rate = cells(shown)
    assert head == ["of the runs that have it", "runs", "median", "90 %", "99 %", "worst"]
    assert all(line.pop(1) == "10" for line in (worst, mean, heading, rate))
    # Of ten values the median is the sixth and 90 % the tenth: never between two runs.
    assert worst == ["greatest |cross-track error| [m]", "6.0000", "10.0000", "10.0000", "10.0000"]
    assert mean[1:] == ["3.0000", "5.0000", "5.0000", "5.0000"]
    assert heading[1:] == ["0.6000", "1.0000", "1.0000", "1.0000"]
    assert rate[1:] == ["12.0000", "20.0000", "20.0000", "20.0000"]


def test_percentiles_are_of_all_runs_however_many_there_are() -> None:
    for count in range(1, 12):
        errors = [float(7 * k % 11) for k in range(count)]
        shown = cells(summary.tables(job(), [row(k, error) for k, error in enumerate(errors)])[0])
        assert int(shown[1][1]) == count
        found = [float(each) for each in shown[1][2:]]
        places = [math.ceil(share * (count - 1)) for share in (0.5, 0.9, 0.99, 1.0)]
        assert found == [sorted(errors)[place] for place in places], count


def test_worst_runs_are_named_in_their_order_with_their_own_error() -> None:
    found = [each["run"] for each in summary.worst(ROWS, 4)]
    assert found == [9, 8, 7, 6]
    # Of equals the first run comes first.
    assert [each["run"] for each in summary.worst([row(2, 0.1), row(1, 0.1)])] == [1, 2]
    shown = cells(summary.tables(job(), ROWS)[1])
    plain = [line[:4] for line in shown[1:]]
    assert plain[:3] == [
        ["9", "✗ no", "–", "3.000"],
        ["8", "yes", "✗ yes", "0.200"],
        ["7", "yes", "–", "0.080"],
    ]
    assert len(plain) == 5


def test_error_of_a_run_is_the_settled_one_where_it_finished() -> None:
    assert summary.error_of(row(0, 0.3)) == 0.3
    assert summary.error_of(row(0, 0.3, finished=False)) == 3.0
    found = summary.outcomes([*ROWS, row(10, 0.0)])
    assert found.error.tolist() == pytest.approx(
        [*(0.01 * (k + 1) for k in range(8)), 0.2, 3.0, 1e-4]
    )
    assert found.good.tolist() == [True] * 8 + [False, False, True]
    assert found.ended.tolist() == [True] * 9 + [False, True]


def test_caption_and_notes_count_what_the_rows_say() -> None:
    said = summary.caption(job(course="slalom"), ROWS)
    rate = summary.success_rate(8, 10)
    assert said.startswith("pop on slalom, car: 8 of 10 runs succeeded, 80")
    assert (round(100 * rate.low, 2), round(100 * rate.high, 2)) == (49.02, 94.33)
    notes = summary.notes(job(deviation=0.25, settings=sim.Settings(settling_time=3.0)), ROWS)
    assert notes[:2] == ["✗ 1 did not finish.", "✗ 1 reported a fault: deviating."]
    assert "within 0.25 m after the first 3 s" in notes[2]
    assert any("seed 3: steer_lag uniform(0.0,1.0)" in note for note in notes), notes


def test_every_run_that_fails_is_counted_for_its_reason() -> None:
    aside = [row(k, 0.9, success=False) for k in range(3)]
    early = row(3, math.nan, success=False)  # of which another note tells
    said = ["1 did not finish", "1 reported a fault: deviating"]
    assert summary.failures(ROWS) == said
    assert summary.failures([*ROWS, *aside, early]) == [*said, "3 went farther off than is allowed"]
    assert summary.failures(ROWS[:8]) == []


def test_influence_is_the_distance_of_the_distributions() -> None:
    rows = [row(k, 0.1, success=k < 30, steer_lag=k / 40, start_offset=k % 2) for k in range(40)]
    found = summary.influence(job(), rows)
    assert list(found) == ["steer_lag", "start_offset"]
    assert found == {"steer_lag": 1.0, "start_offset": 0.0}
    # Where none fails, the tenth with the greatest error counts as failed.
    rows = [row(k, 0.01 * k, steer_lag=-k, start_offset=k < 19) for k in range(20)]
    assert summary.influence(job(), rows) == pytest.approx({"steer_lag": 1.0, "start_offset": 0.5})
    rows = [row(k, 0.1, steer_lag=k) for k in range(4)]
    assert summary.influence(job(), rows) == {"steer_lag": 0.0, "start_offset": 0.0}


def test_rates_over_tenths_cover_the_values_without_a_gap() -> None:
    values = np.arange(100.0)
    found = list(summary.success_rates(values, values % 10 < values // 10))
    assert [share for _, _, (share, _, _) in found] == pytest.approx(
        [sum(k < tenth for k in range(10)) / 10 for tenth in range(10)], abs=0.1
    )
    assert (found[0][0], found[-1][1]) == (0.0, 99.0)
    assert all(one[1] == other[0] for one, other in pairwise(found))


def test_run_at_the_end_of_a_tenth_counts_in_the_next_and_the_last_in_the_last() -> None:
    values = np.arange(11.0)
    for at, tenth in ((5.0, (5.0, 6.0)), (10.0, (9.0, 10.0)), (0.0, (0.0, 1.0))):
        found = {
            (low, high): share
            for low, high, (share, *_) in summary.success_rates(values, values == at)
        }
        (where,) = [ends for ends, share in found.items() if share]
        assert where == pytest.approx(tenth)


def test_rates_over_tenths_count_each_run_once(monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[int] = []
    monkeypatch.setattr(summary, "success_rate", lambda _, runs: counted.append(runs))
    # 21 runs, whose deciles are values of runs; many ties; one value for all.
    for values in (np.arange(21.0), np.repeat([0.0, 0.5, 1.0], (50, 1, 20)), np.zeros(30)):
        counted.clear()
        assert list(summary.success_rates(values, values > 0.0))
        assert sum(counted) == len(values)


def test_distance_by_chance_is_exceeded_by_one_in_twenty() -> None:
    random = np.random.default_rng(4)
    above = 0
    for _ in range(400):
        drawn = enumerate(random.random(160))
        rows = [row(k, 0.1, success=k >= 40, steer_lag=x, start_offset=0.0) for k, x in drawn]
        above += summary.influence(job(), rows)["steer_lag"] > summary.chance(rows)
    assert 8 <= above <= 32
    assert summary.chance(rows) == pytest.approx(1.36 * (1.0 / 40.0 + 1.0 / 120.0) ** 0.5)
    assert summary.chance(rows[:2]) == summary.chance(rows[40:42]) == 1.0


def test_histogram_has_every_run_once_in_its_bin() -> None:
    figure = sweep.error_figure(job(deviation=0.15), ROWS)
    good, bad = figure["traces"]
    assert (good["name"], sum(good["y"])) == ("succeeded", 8)
    assert (bad["name"], sum(bad["y"])) == ("failed", 2)
    counted = zip(bad["x"], bad["width"], bad["y"], strict=True)
    (low, high) = [(x, width) for x, width, count in counted if count]
    assert abs(low[0] - 0.2) < low[1]
    assert abs(high[0] - 3.0) < high[1]
    assert "10 runs" in figure["note"]
    assert "0.15 m" in figure["note"]
    (line,) = figure["layout"]["shapes"]
    assert (line["x0"], line["x1"], line["y0"], line["y1"]) == (0.15, 0.15, 0, 1)


def test_start_figure_has_degrees_and_each_kind_of_run() -> None:
    both = job()
    both.vary["start_yaw"] = both.vary["steer_lag"]  # type: ignore[index]
    rows = [row(k, 0.1, start_yaw=0.1 * k, start_offset=-1.0 * k) for k in range(3)]
    rows[1] |= {"success": False}
    rows[2] |= {"success": False, "finished": False}
    (figure,) = sweep.start_figure(both, rows)
    for k, (trace, name) in enumerate(
        zip(figure["traces"], ("succeeded", "failed", "did not finish"), strict=True)
    ):
        assert trace["name"] == name
        assert trace["x"] == pytest.approx([-1.0 * k])
        assert trace["y"] == pytest.approx([math.degrees(0.1 * k)], rel=1e-4)
        assert trace["text"] == [f"run {k}"]
    assert sweep.start_figure(job(), rows) == []


def test_share_that_succeeds_is_drawn_in_percent_with_its_interval() -> None:
    rows = [row(k, 0.1, success=k < 45, steer_lag=float(k)) for k in range(100)]
    figure = next(f for f in sweep.quantity_figures(job(), rows) if f["title"] == "steer_lag")
    rates = figure["traces"][-1]
    assert rates["y"][0] == 100.0
    assert rates["y"][-1] == 0.0
    middle = summary.success_rate(5, 10)
    assert rates["y"][4] == 50.0
    assert rates["error_y"]["array"][4] == pytest.approx(100 * (middle.high - 0.5), abs=1e-3)
    assert rates["error_y"]["arrayminus"][4] == pytest.approx(100 * (0.5 - middle.low), abs=1e-3)
    assert rates["x"][0] == pytest.approx(0.5 * (0.0 + 9.9))
    assert figure["layout"]["xaxis"]["title"]["text"] == "steer_lag [s]"


def test_report_says_the_rate_and_repeats_the_worst_run() -> None:
    text = Html(verdict(ROWS))
    assert text.texts["strong"] == ["8 of 10 runs succeeded, 80 %"]
    page = Html(_worst_table(job(), ROWS, "out/a b.csv"))
    assert any("popsteer sweep --run 'out/a b.csv':9" in each for each in page.texts["code"])
    assert "3.000" in page.texts["td"]
    assert "1009" in page.texts["td"]


def test_axis_titles_have_the_unit_of_what_varies() -> None:
    assert summary.axis_title("understeer") == "understeer [s²/m]"
    assert {summary.axis_title(name) for name in ("start_yaw", "noise_yaw", "steer_offset")} == {
        "start_yaw [rad]",
        "noise_yaw [rad]",
        "steer_offset [rad]",
    }
    assert ERROR in row(0, 0.1)


def test_worst_tenth_stands_for_failures_from_ten_runs_on() -> None:
    for count, known in ((9, False), (10, True)):
        rows = [row(k, 0.01 * (k + 1)) for k in range(count)]
        found = summary.influence(job(), rows)
        assert (max(found.values()) > 0.0) == known, count
        told = [note for note in summary.notes(job(), rows) if "Kolmogorov" in note]
        assert len(told) == known
    assert "runs that were the worst tenth from" in told[0]
    # One failure is enough to speak of those that failed.
    failed = [*rows[:-1], {**rows[-1], "success": False}]
    (said,) = [note for note in summary.notes(job(), failed) if "Kolmogorov" in note]
    assert "runs that failed from" in said
    assert "(by chance: up to 1.00)." in said


def test_progress_of_a_sweep_counts_runs_over_all_of_its_chunks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from popsteer.lab.sweep import runs as workers

    def drive(_: Any, chunk: Any, threads: int, advance: Any) -> list[dict[str, Any]]:
        advance(0.5)
        return [{"run": run, "threads": threads} for run in chunk]

    monkeypatch.setattr(workers, "drive", drive)
    monkeypatch.setattr(workers, "_CORE_CHUNK", 2)
    told: list[float] = []
    chunks = list(workers.on_core(job(), [7, 8, 9, 3, 4], 6, told.append))
    assert [[row["run"] for row in rows] for rows in chunks] == [[7, 8], [9, 3], [4]]
    assert {row["threads"] for rows in chunks for row in rows} == {6}
    assert told == [1.0, 3.0, 4.5]


def test_speed_of_a_sweep_is_planned_for_the_vehicle_that_is_given() -> None:
    given = popsteer.Vehicle(max_lateral_acceleration=1.5)
    of_given = job(vehicle=given, longitudinal=popsteer.SpeedTrackerParams())
    _, tracker = of_given.road
    assert isinstance(tracker, popsteer.SpeedTracker)
    assert tracker.vehicle == given != popsteer.sim.vehicle_of(of_given.whole)
