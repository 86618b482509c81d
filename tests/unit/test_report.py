"""What a report carries: its numbers, its markup, and what it leaves out."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.text import Text

import popsteer
from popsteer import sim, tracks
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import compare, replay
from popsteer.lab.common.layout import blank_table
from popsteer.lab.compare.comparison import distances
from popsteer.lab.report import compare as compare_page
from popsteer.lab.report import of_comparison
from popsteer.lab.report import page as page_module
from popsteer.lab.report import replay as replay_page
from popsteer.lab.report import sweep as sweep_page
from popsteer.lab.report.colours import log_axis, style
from popsteer.lab.report.compare import scene_of
from popsteer.lab.report.markup import json_for_script, table
from popsteer.lab.report.page import Page
from popsteer.lab.report.scene import Pack, _path, deflated
from popsteer.logs import Log
from popsteer.status import Status
from tests.pages_of_html import Html, columns

NUMBERS = st.one_of(
    st.floats(-1e9, 1e9), st.sampled_from([float("nan"), float("inf"), 0.0, -0.0, 1e9])
)


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> str:
    """A library in place of plotly's, which has megabytes."""
    monkeypatch.setattr("plotly.offline.get_plotlyjs", lambda: "the library")
    return "the library"


@pytest.fixture(scope="module")
def comparison() -> compare.Comparison:
    track = tracks.get("slalom")
    # Wheels that come to their limit now and then: the status changes.
    car = popsteer.vehicles.get("carla-identified").replace(max_steer=0.16)
    path = popsteer.Path(track.xy)
    start = sim.default_start(path, -2.44, car)
    return compare.run(path, ["stanley", "pop"], vehicle=car, start=start)


def _read(pack: Pack, refs: list[list[float]]) -> list[Any]:
    actor = {"columns": {str(k): ref for k, ref in enumerate(refs)}}
    return list(columns({"numbers": pack.text()}, actor).values())


@given(st.lists(st.lists(NUMBERS, max_size=30), min_size=1, max_size=4))
def test_packed_numbers_read_back_within_their_resolution(rows: list[list[float]]) -> None:
    pack = Pack()
    refs = [pack.add(row, 1e-3) for row in rows]
    for row, ref, found in zip(rows, refs, _read(pack, refs), strict=True):
        wanted = np.array(row)
        whole = np.isfinite(wanted)
        assert np.array_equal(np.isfinite(found), whole)
        # Half a step, and what float64 leaves of numbers as large as these.
        assert np.all(np.abs(found[whole] - wanted[whole]) <= 0.5 * ref[2] + 1e-6)


def test_packed_numbers_of_a_car_are_rounded_to_what_the_page_says(
    comparison: compare.Comparison,
) -> None:
    pack = Pack()
    (stanley, _) = scene_of(comparison).document(pack)["actors"]
    found = columns({"numbers": pack.text()}, stanley)
    records = comparison.runs["stanley"].records
    for name, bound in (("x", 1e-3), ("y", 1e-3), ("cross_track_error", 1e-4), ("time", 1e-4)):
        assert np.max(np.abs(found[name] - records[name])) <= 0.51 * bound
    assert np.max(np.abs(np.radians(found["steer_deg"]) - records["steer"])) <= np.radians(0.51e-3)
    assert np.array_equal(found["status"], records["status"])


@pytest.mark.usefixtures("library")
def test_page_of_too_many_samples_leaves_some_out_and_says_so(
    comparison: compare.Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(comparison)
    page = Page("t", "l", "", "", [scene])
    whole = page.content()
    monkeypatch.setattr(page_module, "LARGEST", len(whole) - 1)
    part = page.content()
    assert len(part) < len(whole)
    found = Html(part.decode())
    said = f"Of {scene.samples} samples one in 2 is drawn"
    assert any(said in text for text in found.texts["p"])
    assert not any("one in" in text for text in Html(whole.decode()).texts["p"])
    document = found.document()
    kept = columns(document, document["scenes"][0]["actors"][0])
    records = comparison.runs["stanley"].records
    count = len(records["time"])
    assert 0.45 * count < len(kept["time"]) < 0.6 * count


def test_samples_that_tell_most_are_never_left_out(comparison: compare.Comparison) -> None:
    pack = Pack()
    actors = scene_of(comparison).document(pack, 64)["actors"]
    text = pack.text()
    for actor in actors:
        kept = columns({"numbers": text}, actor)
        records = comparison.runs[actor["name"]].records
        assert len(kept["time"]) < 0.1 * len(records["time"])
        largest = [int(np.argmax(np.abs(records[n]))) for n in ("heading_error", "steer", "speed")]
        changes = np.flatnonzero(np.diff(records["status"].astype(int))).tolist()
        assert changes
        wanted = {0, len(records["time"]) - 1, *largest, *changes, *(k + 1 for k in changes)}
        found = np.rint(kept["time"] / 0.05).astype(int)
        assert wanted <= set(found.tolist()), actor["name"]


@pytest.mark.usefixtures("library")
def test_page_that_cannot_be_small_enough_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_module, "LARGEST", 1000)
    with pytest.raises(PopsteerError, match=r"a report of [0-9]+ bytes, where at most 1000"):
        Page("t", "l", "", "", []).content()


@pytest.mark.usefixtures("library")
def test_page_leaves_out_runs_then_figures_and_says_so(
    comparison: compare.Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(comparison)
    # Each starts elsewhere, so that no two have a column in common.
    scenes = [
        replace(
            scene,
            actors=[
                replace(actor, columns={**actor.columns, "x": np.asarray(actor.columns["x"]) + k})
                for actor in scene.actors
            ],
        )
        for k in range(8)
    ]
    figure = {"title": "noise", "traces": np.random.default_rng(0).random(3000).tolist()}
    page = Page("t", "l", "", "", scenes, [figure])
    thin = page_module._STRIDES[-1:]
    monkeypatch.setattr(page_module, "_STRIDES", thin)
    sizes = [len(replace(page, scenes=scenes[:k]).content()) for k in (2, 4, 8)]
    assert sizes == sorted(sizes)
    monkeypatch.setattr(page_module, "_STRIDES", tuple(2**k for k in range(16)))
    monkeypatch.setattr(page_module, "LARGEST", sizes[1] - 1)
    found = Html(page.content().decode())
    assert len(found.document()["scenes"]) == 2
    said = "Left out, so that the page fits, are the last 6 of 8 drives."
    assert any(said in text for text in found.texts["p"])
    monkeypatch.setattr(page_module, "LARGEST", sizes[0] - 20_000)
    found = Html(page.content().decode())
    assert found.document()["figures"] == []
    assert any("Left out are the figures." in text for text in found.texts["p"])


def test_path_of_half_a_million_waypoints_is_drawn_by_fewer() -> None:
    turn = np.linspace(0.0, 1.5 * np.pi, 500_000)
    circle = np.column_stack((900.0 * np.cos(turn), 900.0 * np.sin(turn)))
    for closed in (False, True):
        path = popsteer.Path(circle, closed=closed)
        pack = Pack()
        x, y = _path(path, pack)
        drawn = _read(pack, [x, y])
        assert len(drawn[0]) <= 20_001
        assert np.hypot(*drawn) == pytest.approx(np.full(len(drawn[0]), 900.0), abs=0.002)
        end = circle[0 if closed else -1]
        assert (drawn[0][-1], drawn[1][-1]) == pytest.approx(tuple(end), abs=0.002)


@pytest.mark.usefixtures("library")
def test_page_of_many_points_is_thinned_so_that_it_opens_quickly(
    comparison: compare.Comparison, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(comparison)
    monkeypatch.setattr(page_module, "_MOST_POINTS", scene.points // 3)
    text = Page("t", "l", "", "", [scene]).content().decode()
    assert "one in 4 is drawn" in text


def test_markup_of_a_name_ends_nothing(library: str) -> None:
    evil = '</script><img src="https://example.org/x" onerror=1>&amp;\u2028 {{plotly}}'
    assert json.loads(json_for_script({"name": evil})) == {"name": evil}
    assert not set("<>&\u2028") & set(json_for_script({"name": evil}))
    text = Page(evil, evil, evil, "", []).content().decode()
    assert text.count(deflated(library.encode())) == 1
    found = Html(text)
    assert not [name for name, _ in found.elements if name == "img"]
    assert evil in found.texts["h1"]
    assert evil in found.texts["code"]
    assert found.loads == ["data:,"]


def test_table_of_the_terminal_keeps_heads_cells_and_what_is_bold() -> None:
    shown = blank_table()
    shown.add_column("controller")
    shown.add_column("fin-\nished\n", justify="right")
    shown.add_row(Text("a<b"), Text("0.5", style="bold"))
    found = Html(table(shown, "label"))
    assert found.texts["th"] == ["controller", "finished", "a<b"]
    assert found.texts["strong"] == found.texts["td"] == ["0.5"]


def test_page_tells_the_plant_from_what_the_controllers_were_given() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    car = popsteer.Vehicle(wheelbase=2.7, dead_time=0.2)
    found = compare.run(
        path, ["pop"], sim.KinematicBicycle(car), vehicle=car.replace(dead_time=0.1)
    )
    page = Html(of_comparison(found).decode())
    titles = [text for text in page.texts["summary"] if "the vehicle" in text]
    assert titles == [
        "kinematic-bicycle: the vehicle",
        "kinematic-bicycle: the vehicle that the controllers were given (dead_time 0.1)",
    ]
    whole, given_one = (text for text in page.texts["code"] if "\nwheelbase = " in text)
    assert "\ndead_time = 0.2\n" in whole
    assert "\ndead_time = 0.1\n" in given_one


def test_page_begins_with_who_finished_and_who_did_not(comparison: compare.Comparison) -> None:
    good = '<p class="verdict good"><strong>2 of 2 runs finished without a fault</strong></p>'
    assert compare_page.verdict([comparison]) == good
    assert f"<h2>Results</h2>{good}" in of_comparison(comparison).decode()
    path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    short = compare.run(path, ["pop"], settings=sim.Settings(time_limit=1.0))
    said = compare_page.verdict([comparison, short])
    assert said.startswith('<p class="verdict bad"><strong>2 of 3 runs finished')
    assert "POP on carla-identified (did not finish: time limit" in said


def test_verdict_of_a_sweep_and_of_a_replay_says_what_went_wrong() -> None:
    row = {"success": True, "finished": True, "faults": 0}
    fault = row | {"success": False, "faults": int(Status.DEVIATING)}
    said = sweep_page.verdict([row] * 8 + [fault, fault | {"finished": False}])
    assert '"verdict bad"><strong>8 of 10 runs succeeded, 80 %</strong>' in said
    assert "49 to 94 %; 1 did not finish; 2 reported a fault: deviating" in said
    t = np.arange(0.0, 10.0, 0.05)
    yaw = 0.4 * t  # a left turn, with the angle of a right one
    log = Log(t, 20.0 * np.sin(yaw), 20.0 - 20.0 * np.cos(yaw), yaw, 8.0 + 0.0 * t, 0.0 * t - 0.13)
    found = replay.run(log, {"stanley": None}, popsteer.Vehicle())
    assert '"verdict bad"><strong>0 of 1 controller reported no fault' in replay_page.verdict(found)


def test_papers_columns_are_of_the_papers_track_alone(comparison: compare.Comparison) -> None:
    heads = [
        str(each.header) for shown in compare.table.tables(comparison) for each in shown.columns
    ]
    assert any("mean" in head for head in heads)
    assert not any("paper" in head or "ratio" in head for head in heads)
    assert not any("paper's figures" in note for note in compare.table.notes(comparison))


def test_fault_tells_the_greatest_error_while_it_held_not_that_of_the_start() -> None:
    track = tracks.get("slalom")
    path = popsteer.Path(track.xy)
    far = sim.default_start(path, 6.0)
    slow = {"stanley": popsteer.StanleyParams(cross_track_gain=0.1)}
    for records in (True, False):
        settings = sim.Settings(keep_records=records)
        found = compare.run(path, slow, constant_speed=15.0, start=far, settings=settings)
        told = compare.table.notes(found)[0]
        assert told.startswith("✗ Fault of Stanley: deviating")
        if not records:
            assert told == "✗ Fault of Stanley: deviating."
            continue
        run = found.first.records
        error, time, x, y = map(float, re.findall(r"-?\d+\.\d+", told))
        held = [Status.DEVIATING in Status(int(bits)) for bits in run["status"]]
        errors = np.where(held, np.abs(run["cross_track_error"]), 0.0)
        place = [run[name][np.argmax(errors)] for name in ("time", "x", "y")]
        assert error == round(float(errors.max()), 2)
        assert (time, x, y) == pytest.approx(place, abs=0.051)
        assert found.first.metrics.max_abs_cross_track_error > 2.0 * error


def test_runs_without_records_make_no_report() -> None:
    path = popsteer.Path([(float(x), 0.0) for x in range(81)])
    bare = compare.run(path, ["pop"], settings=sim.Settings(keep_records=False))
    with pytest.raises(ConfigError, match="keep_records"):
        of_comparison(bare)


def test_distances_count_the_laps_of_a_closed_path() -> None:
    angle = np.linspace(0.0, 4.0 * np.pi, 400)
    circle = np.column_stack((np.cos(angle[:200:2]), np.sin(angle[:200:2])))
    path = popsteer.Path(20.0 * circle[:-1], closed=True)
    x, y = 20.0 * np.cos(angle), 20.0 * np.sin(angle)
    found = distances(path, x, y, angle + 0.5 * np.pi, np.ones(400))
    assert abs(found[-1] - found[0] - 2.0 * path.length) < 1.0
    assert np.all(np.diff(found) >= 0.0)
    # Two metres before the start of a lap are not at its end.
    x, y, angle = (np.roll(each, 6) for each in (x, y, angle))
    early = distances(path, x, y, angle + 0.5 * np.pi, np.ones(400))
    assert -8.0 < early[0] < -1.0


def test_distances_go_on_along_a_path_that_is_driven_backwards() -> None:
    x = np.concatenate((np.arange(0.0, 30.5, 0.5), np.arange(29.5, -0.5, -0.5)))
    speed = np.where(np.arange(len(x)) < 61, 3.0, -3.0)
    path = popsteer.Path(np.column_stack((x, 0.0 * x)), speed=speed)
    run = sim.run(popsteer.Stanley(path), "kinematic-bicycle", longitudinal=popsteer.SpeedPid())
    assert run.records["speed"].min() < -1.0
    records = run.records
    found = distances(path, records["x"], records["y"], records["yaw"], records["speed"])
    assert np.all(np.diff(found) >= 0.0)
    assert found[-1] > 0.5 * path.length


def test_log_axis_has_marks_that_are_read_at_once() -> None:
    assert log_axis("t", 0.011, 0.3)["ticktext"] == ["0.02", "0.05", "0.1", "0.2"]
    assert log_axis("t", 0.001, 20.0)["ticktext"] == ["0.001", "0.01", "0.1", "1", "10"]
    assert "tickvals" not in log_axis("t", 3.0, 4.0)


def test_style_has_both_schemes_and_loads_nothing() -> None:
    assert "prefers-color-scheme: dark" in style()
    whole = style() + page_module._asset("page.css")
    assert "url(" not in whole
    assert "@import" not in whole
