"""Figures and pages of runs that are known by hand, value by value as they were last looked at.

    python -m tests.values.test_recorded_documents

writes `recorded.json` anew; what changed in it is to be looked at.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import Status, sim
from popsteer.lab.common.theme import THEMES
from popsteer.lab.common.varied import distribution
from tests.values import tables
from tests.values import tables as documents
from tests.values.test_known_answers_replay import identification, replay

if TYPE_CHECKING:
    from collections.abc import Callable

VARY = {"start_yaw": "uniform(-0.2,0.2)", "steer_lag": "0.1", "start_offset": "uniform(-1,1)"}


def _job() -> Any:
    vary = {name: distribution(name, text) for name, text in VARY.items()}
    return tables.job(vary=vary, runs=24, deviation=0.4)


def _rows() -> list[dict[str, Any]]:
    """Runs whose error grows with the offset: two of them with a fault, two that did not finish."""
    rows = []
    for k in range(24):
        offset, yaw = 0.05 * (k - 11), 0.01 * (7 * k % 24 - 12)
        error = 0.02 + 0.02 * k
        good = error <= 0.4
        rows.append(tables.row(k, error, start_offset=offset, start_yaw=yaw, success=good))
    for k in (3, 12):
        rows[k] |= {"success": False, "faults": int(Status.DEVIATING)}
    for k in (5, 20):
        rows[k] |= {"success": False, "finished": False}
    return rows


def _sweep() -> dict[str, Any]:
    from popsteer.lab.report import sweep
    from popsteer.lab.sweep.figure import sweep_figure

    job, rows = _job(), _rows()
    many = [{**rows[k % 24], "run": k} for k in range(3 * 1500 + 24)]
    dots, note = sweep._dots(many, np.arange(len(many)), np.arange(len(many)))
    return {
        "figure": documents.of_figure(sweep_figure(job, rows, THEMES["light"])),
        "none": documents.of_figure(sweep_figure(tables.job(vary={}), rows, THEMES["dark"])),
        "error": sweep.error_figure(job, rows),
        "start": sweep.start_figure(job, rows),
        "quantities": sweep.quantity_figures(job, rows),
        "verdicts": [sweep.verdict(each) for each in (rows, rows[:3], rows[3:4])],
        "many": [note, [len(each["x"]) for each in dots], [each["x"][:3] for each in dots]],
        "opacity": [each["marker"]["opacity"] for each in dots],
    }


def _tune() -> dict[str, Any]:
    from popsteer.lab.tune.figure import tune_figure
    from popsteer.lab.tune.study import Tuned
    from tests.values.test_known_answers_tune import USUAL, problem, trial

    tried = [trial(0, 0.5, 0.1), trial(1, 0.4, 0.2), trial(2, 0.3, 0.4), trial(3, 70.0, 0.9)]
    found = Tuned(problem(cars=0), USUAL, tried, tried[1], 1.1)
    without = replace(found, problem=problem(cars=2), trials=tried[3:], chosen=None)
    return {
        name: documents.of_figure(tune_figure(each, THEMES["light"]))
        for name, each in (("chosen", found), ("none", without))
    }


def _replay() -> dict[str, Any]:
    from popsteer.lab.replay.figure import replay_figure
    from popsteer.lab.report import replay as page

    found = replay()
    return {
        "figure": documents.of_figure(replay_figure(found, THEMES["light"])),
        "scene": _scene(page._scene(found)),
        "histogram": page._histogram(found),
        "verdict": page.verdict(found),
    }


def _identify() -> dict[str, Any]:
    from popsteer.lab.report import identify as page

    found = identification()
    moved = np.array([0.0, 0.5, 1.2, 2.0, 2.5])
    records = {**found.records, "x": moved, "simulated_x": np.array([0.0, 0.6, 1.2, 9.0, 9.5])}
    found = replace(found, records=records)
    return {"scene": _scene(page._scene(found)), "histograms": page._histograms(found)}


def _scene(scene: Any) -> dict[str, Any]:
    """Give a scene as a page has it, and the columns of its actors."""
    from popsteer.lab.report.scene import Pack

    columns = {each.name: each.columns for each in scene.actors}
    return {"document": scene.document(Pack()), "columns": columns}


def _run(law: str, error: float, finished: bool = True) -> Any:
    time = 0.5 * np.arange(6)
    records = {
        "time": time,
        "x": 5.0 * time,
        "y": 0.0 * time,
        "yaw": 0.0 * time,
        "speed": 5.0 + 0.0 * time,
        "steer": 0.1 * time,
        "cross_track_error": error - 0.1 * time,
        "heading_error": 0.02 * time,
        "status": np.array([0, 0, int(Status.DEVIATING), 0, 0, 0], dtype=np.uint32),
    }
    faults = Status.DEVIATING if error > 1.0 else Status(0)
    metrics = SimpleNamespace(
        settled_mean_abs_cross_track_error=error,
        rms_steer_rate=0.1 * (1.0 + error),
        finished=finished,
        faults=faults,
    )
    return SimpleNamespace(
        law=law,
        path=tables.STRAIGHT,
        records=records,
        metrics=metrics,
        settings=sim.Settings(settling_time=4.0),
        ending="finished" if finished else "time limit",
    )


def _comparison(plant: str, track: str, **errors: float) -> Any:
    runs = {
        name.replace("_", "-"): _run(name, abs(error), error >= 0.0)
        for name, error in errors.items()
    }
    return SimpleNamespace(
        plant=plant,
        track=track,
        runs=runs,
        tuning=dict.fromkeys(runs, "default"),
        points=dict.fromkeys(runs, "front"),
        path=tables.STRAIGHT,
        vehicle=popsteer.Vehicle(),
        first=next(iter(runs.values())),
        step_times={name: 1e-6 * (k + 0.5) for k, name in enumerate(runs)},
        latencies={name: [930 + 100 * (k % 40) for k in range(2000)] + [90_000] for name in runs},
    )


def _compare() -> dict[str, Any]:
    from popsteer.lab.report import compare as page

    one = _comparison("car", "lap", pop=0.02, preview_pop=0.01, stanley=-0.3)
    other = _comparison("van", "lap", pop=0.03, preview_pop=0.02, stanley=1.3)
    third = _comparison("car", "bend", pop=0.04, preview_pop=-0.05, stanley=0.0)
    found = [one, other, third]
    latency = page.latency_figure(one)
    # In between it says on what machine.
    latency[0]["note"] = latency[0]["note"].partition(" Single")[1:]
    bare: Any = SimpleNamespace(**{**vars(one), "latencies": {}})
    return {
        "scene": _scene(page.scene_of(bare)),
        "verdicts": [page.verdict(each) for each in ([one], [other], found)],
        "pivot": page._pivot(found),
        "figures": page._effort(found),
        "latency": latency,
    }


def _stability() -> dict[str, Any]:
    from popsteer.lab import stability
    from popsteer.lab.stability import figures

    car = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.1, dead_time=0.1)
    found = stability.run(["pop", "stanley", "preview-pop"], car, [4.0, 9.0, 15.0])
    return {"margins": documents.of_figure(figures._margins_figure(found, THEMES["light"]))}


def _plan() -> dict[str, Any]:
    from popsteer import planning
    from popsteer.lab.plan.figures import plan_figure

    x = np.arange(0.0, 60.0, 3.0)
    path = popsteer.Path(np.column_stack((x, 4.0 * np.sin(x / 7.0))))
    limits = planning.SpeedLimits(max_speed=6.0, max_lateral_acceleration=2.0)
    return {
        "plan": documents.of_figure(
            plan_figure(planning.speed_profile(path, limits), THEMES["light"])
        )
    }


DOCUMENTS: dict[str, Callable[[], dict[str, Any]]] = {
    "sweep": _sweep,
    "tune": _tune,
    "replay": _replay,
    "identify": _identify,
    "compare": _compare,
    "stability": _stability,
    "plan": _plan,
}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_document_is_the_recorded_one(name: str) -> None:
    pytest.importorskip("scipy")
    pytest.importorskip("matplotlib")
    found = documents.plain(DOCUMENTS[name]())
    assert documents.differences(found, documents.recorded()[name]) == []


if __name__ == "__main__":
    documents.record({name: make() for name, make in DOCUMENTS.items()})
