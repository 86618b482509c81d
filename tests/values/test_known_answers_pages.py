"""Figures and tables of the pages of matrix, steps' times and runs, against hand calculations."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.lab import compare
from popsteer.lab.compare import table as compare_table
from popsteer.lab.compare.files import metrics_document
from popsteer.lab.report import compare as times
from popsteer.lab.report import sweep as sweep_page
from popsteer.lab.report.colours import log_axis
from popsteer.lab.report.compare import actor_of
from popsteer.lab.report.scene import _car, travelled
from popsteer.lab.sweep import repeat
from tests.pages_of_html import Html
from tests.values.tables import STRAIGHT, job, row


def test_percentiles_of_steps_are_of_each_controllers_own_times() -> None:
    # 1,000 calls of one controller: 1 to 1,000 µs; ten of the other, in nanoseconds.
    nanoseconds = [1000 * k for k in range(1, 1001)]
    stand_in: Any = SimpleNamespace(
        latencies={"pop": nanoseconds, "stanley": [500] * 10},
        step_times={"pop": 2.5e-6, "stanley": 0.4e-6},
    )
    page = Html(times.latency_table(stand_in))
    found = [text for text in page.texts["td"] if text]
    assert found[:7] == ["2.50", "501.00", "901.00", "991.00", "1000.00", "1000.0", "1000"]
    assert found[7:] == ["0.40", "0.50", "0.50", "0.50", "0.50", "0.5", "10"]
    (figure,) = times.latency_figure(stand_in)
    for trace, lowest in zip(figure["traces"], (1.0, 0.5), strict=True):
        assert sum(trace["y"]) == pytest.approx(100.0, abs=0.05)
        first = next(x for x, y in zip(trace["x"], trace["y"], strict=True) if y)
        assert 0.88 * lowest < first <= lowest * (1.0 + 1e-9)
        assert trace["y"][0] == 0.0  # it rises from nothing at its first edge
        assert trace["x"][0] == trace["x"][1] <= 0.5
    # The axis ends half as far again as the slowest but a thousandth; what took longer is said.
    stand_in.latencies = {"pop": [1000] * 4000 + [80_000], "stanley": [500] * 10}
    (figure,) = times.latency_figure(stand_in)
    assert figure["layout"]["xaxis"]["range"][1] == pytest.approx(math.log10(1.5))
    assert "up to 80 µs" in str(figure)
    stand_in.latencies["stanley"] = [60_000] * 10
    (figure,) = times.latency_figure(stand_in)
    assert figure["layout"]["xaxis"]["range"][1] > math.log10(60.0)
    assert "up to" not in str(figure)
    assert times.latency_figure(SimpleNamespace(latencies={})) == []  # type: ignore[arg-type]


def _run(error: float, finished: bool = True, faults: int = 0) -> Any:
    metrics = SimpleNamespace(
        settled_mean_abs_cross_track_error=error, finished=finished, faults=faults
    )
    return SimpleNamespace(metrics=metrics, settings=sim.Settings(settling_time=4.0))


def test_table_of_a_comparison_marks_the_best_of_those_that_finished() -> None:
    runs = {"pop": _run(0.02), "stanley": _run(0.01, False), "pid": _run(0.03)}
    comparison: Any = SimpleNamespace(runs={**runs, "mpc": _run(0.01, faults=1)})
    column = compare_table._Column("", lambda run: _settled(run.metrics), ".2f", ranked=True)
    assert compare_table._best(comparison, column) == 0.02
    comparison.runs["tied"] = _run(0.0204)
    assert compare_table._best(comparison, column) is None


def _settled(metrics: Any) -> float:
    return float(metrics.settled_mean_abs_cross_track_error)


def test_table_of_several_plants_marks_the_best_of_those_that_finished() -> None:
    runs = {"pop": _run(0.02), "stanley": _run(0.01, False), "pid": _run(0.03)}
    comparison: Any = SimpleNamespace(runs=runs, track="slalom", plant="car", first=runs["pop"])
    text = times._pivot([comparison])
    page = Html(text)
    assert page.texts["strong"] == ["0.0200"]
    assert [each for each in page.texts["td"] if "." in each] == ["0.0200", "(0.0100)", "0.0300"]
    assert "after 4 s [m]" in text
    runs["pop"] = _run(math.nan, False)
    assert "(–)" in times._pivot([comparison])


def test_logarithmic_axis_reaches_from_end_to_end() -> None:
    axis = log_axis("t", 0.011, 0.3)
    assert axis["tickvals"] == pytest.approx([0.02, 0.05, 0.1, 0.2])


def test_car_on_the_map_has_its_axles_where_they_are() -> None:
    shape = _car(popsteer.Vehicle(wheelbase=2.5, rear_axle=-1.0))
    assert (shape["rear"], shape["front"]) == (-1.0, 1.5)
    assert shape["tail"] < -1.0 < 1.5 < shape["nose"]
    assert shape["half"] == pytest.approx(0.8)


def test_distance_driven_is_positive_backwards() -> None:
    assert travelled(np.arange(3.0), np.array([-1.0, -1.0, -3.0])).tolist() == [0.0, 1.0, 3.0]


def test_car_of_a_run_has_its_records_in_degrees() -> None:
    run = sim.run(popsteer.Stanley(STRAIGHT), "kinematic-bicycle", constant_speed=5.0)
    columns = actor_of(run, "stanley", "Stanley", ["", ""]).columns
    for name in ("time", "x", "y", "yaw", "speed", "cross_track_error", "status"):
        assert np.array_equal(columns[name], run.records[name]), name
    for name in ("steer", "heading_error"):
        assert columns[f"{name}_deg"] == pytest.approx(np.degrees(run.records[name])), name
    assert columns["distance"] == pytest.approx(run.records["x"], abs=1e-6)


def test_worst_runs_are_marked_where_their_settled_error_is_greatest() -> None:
    pytest.importorskip("scipy")
    one = job(runs=2, constant_speed=5.0, settings=sim.Settings(settling_time=2.0))
    scene = sweep_page._scene(one, [0], [1], None)
    assert [actor.name for actor in scene.actors] == ["run-0", "run-1"]
    records = repeat(one, 1).records
    settled = records["time"] >= 2.0
    error = np.abs(records["cross_track_error"])
    at = int(np.flatnonzero(settled)[np.argmax(error[settled])])
    ((x, y, said),) = scene.marks
    assert (x, y) == (records["x"][at], records["y"][at])
    assert said == f"run 1: {error[at]:.2f} m"
    assert scene.panels[0].limit == one.deviation


def test_document_of_a_comparison_has_every_figure_of_its_runs() -> None:
    found = compare.run(STRAIGHT, ["stanley", "pop"], "kinematic-bicycle", constant_speed=5.0)
    document = json.loads(json.dumps(metrics_document(found)))
    for name, run in found.runs.items():
        written = document["controllers"][name]
        assert written["faults"] == list(run.metrics.faults.names)
        for key, value in vars(run.metrics).items():
            place, own = written, key
            if key.startswith("rear_axle_"):
                place, own = written["rear_axle"], key.removeprefix("rear_axle_")
            if key != "faults":
                assert place[own] == value, (name, key)


def test_envelope_spans_the_runs_and_has_the_worst_where_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Run k drives 10 (k + 1) metres at a constant error of 0.1 k to alternate sides."""
    driven = []

    def repeat(_: object, run: int) -> Any:
        driven.append(run)
        x = np.linspace(0.0, 10.0 * (run % 8 + 1), 50)
        flat = 0.0 * x
        error = (0.1 if run % 2 else -0.1) * run + flat
        records = {"x": x, "y": flat, "yaw": flat, "speed": 5.0 + flat}
        return SimpleNamespace(records={**records, "cross_track_error": error})

    monkeypatch.setattr(sweep_page, "repeat", repeat)
    rows = [row(k, 0.01 * (k % 7)) for k in range(8)]
    shares: list[float] = []
    figure = sweep_page.envelope_figure(job(runs=8), rows, shares.append)
    assert driven == [6, *range(8)]
    assert shares == pytest.approx([k / 9.0 for k in range(9)])
    low, high, worst = figure["traces"]
    assert low["y"] == pytest.approx([-0.6 if x <= 70.0 else 0.7 for x in low["x"]])
    assert set(high["y"]) == {0.7}
    assert set(worst["y"]) == {-0.6}
    assert (low["x"][0], low["x"][-1]) == (0.0, 80.0)
    assert len(low["x"]) == len(high["x"]) == 400
    assert worst["x"][-1] == pytest.approx(70.0, abs=0.3)
    assert worst["name"] == "worst: run 6"
    assert "of all runs" in figure["note"]
    # Of many runs at most a hundred are driven, evenly chosen.
    driven.clear()
    many = [row(k, 0.001 * k) for k in range(250)]
    assert "of 84 of 250 runs and it" in sweep_page.envelope_figure(job(runs=250), many)["note"]
    assert driven == [249, *range(0, 250, 3)]


def test_parameters_of_a_page_are_toml_that_says_what_they_are() -> None:
    from popsteer.toml_file import table, tomllib

    pid = popsteer.SpeedPidParams(kp=2.0, ki=0.5)
    assert table("my-pop", {"a": 1.5, "b": None, "c": True, "d": "x", "e": pid}) == (
        '[my-pop]\na = 1.5\n# b =\nc = true\nd = "x"\ne = { kp = 2.0, ki = 0.5, kd = 0.0 }\n'
    )
    assert table("my.pop", {}) == '["my.pop"]\n'
    said = {  # of a controller of one's own
        "how": 'a "b"\n\x7f\\',
        "größe": np.float64(0.3),
        "many": 10**9,
        "none": math.inf,
        "gains": (1, "a\nb"),
        "on": SimpleNamespace(as_dict=lambda: {"flag": True, "limit": None}),
    }
    read = {**said, "on": {"flag": True}}
    del read["gains"]
    assert tomllib.loads(table('my "pop"', said)) == {'my "pop"': read}
