"""A replay's and an identification's tables, files and figures, of values known by hand."""

from __future__ import annotations

import csv
import dataclasses
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

import popsteer
from popsteer import Status
from popsteer.lab.replay import Replay, Shadow, replay_csv, replay_table, run, summary_csv
from popsteer.lab.replay.table import caption, statuses
from popsteer.lab.report import replay as report
from popsteer.logs import Log
from tests.values.tables import STRAIGHT, cells

if TYPE_CHECKING:
    import pathlib

    from popsteer.identification import Identification

STEER = [0.1, 0.1, 0.2, 0.2, 0.2]
LOG = Log(
    [10.0, 10.1, 10.2, 12.2, 12.3],
    [0.0, 0.5, 1.0, 11.0, 11.5],
    [0.0] * 5,
    [0.1] * 5,
    [5.0, 5.0, 5.0, 7.0, 7.0],
    STEER,
    name="drive.csv",
)
DEVIATING, SATURATED = int(Status.DEVIATING), int(Status.SATURATED)


def replay() -> Replay:
    shadow = Shadow(
        "pop",
        STRAIGHT,
        np.array([0.1, 0.2, 0.1, 0.5, 0.2]),
        np.array([0.5, -1.5, 0.0, 1.0, 0.0]),
        np.array([0.0, 0.1, -0.2, 0.0, 0.0]),
        np.array([0, SATURATED, DEVIATING | SATURATED, SATURATED, 0], dtype=np.uint32),
    )
    return Replay(LOG, popsteer.Vehicle(), {"pop": shadow}, "the course")


def test_table_has_degrees_rates_and_shares_without_the_gap() -> None:
    _, driver, pop = cells(replay_table(replay()))
    # 0.1 rad in 0.1 s in one of three steps; the step over the gap counts for nothing.
    assert float(driver[3]) == pytest.approx(math.degrees(math.sqrt(1.0 / 3.0)), abs=0.006)
    difference = np.degrees([0.0, 0.1, 0.1, 0.3, 0.0])
    assert float(pop[1]) == pytest.approx(difference.mean(), abs=0.006)
    assert float(pop[2]) == pytest.approx(difference.max(), abs=0.006)
    assert float(pop[3]) == pytest.approx(math.degrees(math.sqrt(11.0 / 3.0)), abs=0.006)
    assert [float(each) for each in pop[4:6]] == [0.6, 1.5]
    assert [float(each) for each in pop[6:]] == [40.0, 20.0]


def test_files_say_what_the_table_says() -> None:
    (line,) = csv.DictReader(summary_csv(replay()).splitlines())
    assert float(line["mean_abs_difference_deg"]) == pytest.approx(math.degrees(0.1))
    assert float(line["max_abs_cross_track_error"]) == 1.5
    text = replay_csv(replay())
    rows = list(csv.DictReader(each for each in text.splitlines() if not each.startswith("#")))
    assert [float(row["t"]) for row in rows] == LOG.t.tolist()
    for name, values in (("steer", STEER), ("pop.steer", [0.1, 0.2, 0.1, 0.5, 0.2])):
        assert [float(row[name]) for row in rows] == values
    assert [float(row["pop.heading_error"]) for row in rows] == [0.0, 0.1, -0.2, 0.0, 0.0]
    assert [float(row["pop.cross_track_error"]) for row in rows] == [0.5, -1.5, 0.0, 1.0, 0.0]
    assert f"{DEVIATING} deviating" in text


def test_words_have_the_duration_the_period_and_the_shares() -> None:
    assert caption(replay()) == "drive.csv: 2.3 s, 5 rows every 100 ms, along the course"
    (said,) = statuses(replay())
    assert "saturated 60.0 %" in said
    assert "deviating 20.0 %" in said
    shadow = replay().shadows["pop"]
    assert shadow.conditions() == {"saturated": 0.6, "deviating": 0.2}


def test_page_of_a_replay_has_degrees_and_breaks_at_the_gap() -> None:
    scene = report._scene(replay())
    driver, pop = (actor.columns for actor in scene.actors)
    nan = math.nan
    assert driver["time"] == pytest.approx([0.0, 0.1, 0.2, 2.2, 2.3])
    assert driver["steer_deg"] == pytest.approx(np.degrees([0.1, 0.1, 0.2, nan, 0.2]), nan_ok=True)
    assert pop["difference_deg"] == pytest.approx(
        np.degrees([0.0, 0.1, -0.1, nan, 0.0]), nan_ok=True
    )
    assert pop["heading_error_deg"][1:3] == pytest.approx(np.degrees([0.1, -0.2]))
    # The trapezium of the speeds, 5 m/s to 7 m/s over the gap.
    assert driver["distance"] == pytest.approx([0.0, 0.5, 1.0, 13.0, 13.7])
    figure = report._histogram(replay())
    (trace,) = figure["traces"]
    assert sum(trace["y"]) == pytest.approx(100.0, abs=0.01)
    largest = math.degrees(0.3)
    assert (trace["x"][0], trace["x"][-1]) == pytest.approx((-largest, largest), rel=1e-3)
    counted = {x: y for x, y in zip(trace["x"], trace["y"], strict=True) if y}
    assert sorted(counted.values()) == pytest.approx([20.0, 20.0, 20.0, 40.0])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_histogram_of_differences_to_one_side_has_all_of_them(side: float) -> None:
    found = replay()
    away = np.array(STEER) + side * np.array([0.1, 0.1, 0.2, 0.2, 0.3])
    shadows = {"pop": dataclasses.replace(found.shadows["pop"], steer=away)}
    figure = report._histogram(dataclasses.replace(found, shadows=shadows))
    (trace,) = figure["traces"]
    counted = {x: y for x, y in zip(trace["x"], trace["y"], strict=True) if y}
    assert list(counted.values()) == pytest.approx([40.0, 40.0, 20.0][:: int(side)])
    assert all(side * x > 0.0 for x in counted)


def identification() -> Identification:
    from popsteer.identification import Identification

    ones = np.ones(5)
    records: dict[str, Any] = dict.fromkeys(("x", "y", "simulated_x", "simulated_y"), 0.0 * ones)
    records |= {"t": LOG.t, "counts": np.array([True, True, True, True, False])}
    records |= {"yaw_rate": np.array([0.3, -0.3, 0.3, 0.3, 9.0])}
    records |= {"simulated_yaw_rate": np.array([0.3, -0.3, 0.3, 0.1, 0.0])}
    records |= {"position_error": np.array([0.1, 0.1, -0.1, 0.1, 9.0])}
    car = popsteer.Vehicle(
        wheelbase=2.7, understeer=0.00312, steer_offset=0.01274, steer_lag=0.12, dead_time=0.2
    )
    errors = {"wheelbase": 0.012, "understeer": 3.1e-4, "steer_offset": 0.0021}
    errors |= {"steer_lag": 0.013, "dead_time": 0.011}
    return Identification(
        vehicle=car,
        errors=errors,
        model_errors=dict.fromkeys((*errors, "delay", "turning_length"), 0.0042),
        unknown={"max_steer_rate": "drive steps"},
        ranges={"max_steer_rate": (0.31, math.inf)},
        delay=0.32,
        delay_error=0.013,
        turning_length=2.95,
        turning_length_error=0.014,
        speed=8.0,
        lag_of="wheels",
        notes=(),
        noise={"yaw": 0.002, "yaw_drift": 0.001, "position": 0.02},
        excitation={"speed": (3.1, 9.2)},
        unexplained=(),
        octaves=(),
        records=records,
        log=LOG,
        fit=cast("Any", None),
    )


def test_bars_of_an_identification_stand_in_the_middle_of_what_they_count() -> None:
    from popsteer.lab.report import identify as page

    rate, aside = (figure["traces"][0] for figure in page._histograms(identification()))
    # Residuals 0, 0, 0 and 0.2 rad/s; 0.1, 0.1, -0.1 and 0.1 m; the last row does not count.
    for bars, (low, high), counts in ((rate, (0.0, 0.2), (3, 1)), (aside, (-0.1, 0.1), (1, 3))):
        width = (high - low) / len(bars["x"])
        assert bars["x"][0] == pytest.approx(low + 0.5 * width, abs=1e-5)
        assert bars["x"][-1] == pytest.approx(high - 0.5 * width, abs=1e-5)
        assert (bars["y"][0], bars["y"][-1]) == counts
        assert sum(bars["y"]) == 4


def test_identified_values_are_shown_in_the_units_of_their_rows() -> None:
    pytest.importorskip("scipy")
    from popsteer.lab.identify import caption as identified_caption
    from popsteer.lab.identify import identified_table

    found = identification()
    assert found.yaw_rate_residual == pytest.approx(0.1)
    assert found.yaw_rate_rms == pytest.approx(0.3)
    assert found.position_residual == pytest.approx(0.1)
    shown = {line[0]: line[1:] for line in cells(identified_table(found))[1:]}

    def number(text: str) -> float:
        return float(text.split(maxsplit=1)[0])

    for name, value, error, unit in (
        ("wheelbase", 2.7, 0.012, "m"),
        ("understeer", 0.00312, 3.1e-4, "s²/m"),
        ("steering offset", 0.73, 0.12, "deg"),
        ("lag", 120.0, 13.0, "ms"),
        ("dead time", 200.0, 11.0, "ms"),
        ("dead time and lag together", 320.0, 13.0, "ms"),
        ("turning length at 8.0 m/s", 2.95, 0.014, "m"),
    ):
        line = shown[name]
        assert number(line[0]) == pytest.approx(value, rel=1e-3), name
        assert number(line[1].removeprefix("± ")) == pytest.approx(error, rel=0.05), name
        assert line[-1] == unit, name
    # Two digits of the error, and the value to match; what is unknown has neither.
    assert shown["wheelbase"][:2] == ["2.700", "0.012"]
    assert shown["rate of the wheels"][0] == "–"
    assert "explains the heading to within the noise" in found.verdict
    assert "white, 0.002 rad a sample" in found.verdict
    assert found.driven == "Driven: speed 3.1 to 9.2 m/s."
    assert "2.3 s, 5 rows every 100 ms" in identified_caption(found)


def test_replayed_errors_of_a_smaller_car_on_a_smaller_path_are_smaller_alike(
    tmp_path: pathlib.Path,
) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "class Straight:\n"
        "    def __init__(self, path, vehicle):\n"
        "        self.tracked_point = 0.0\n"
        "    def step(self, x, y, yaw, speed, dt):\n"
        "        return 0.0\n",
        encoding="utf-8",
    )
    # The car leaves a turn of a spiral until the next one is nearer: for the small car within 10 m.
    turned = np.linspace(0.0, 6.0 * np.pi, 600)
    spiral = (10.0 + 3.0 * turned / (2.0 * np.pi)) * np.array((np.cos(turned), np.sin(turned)))
    at = np.linspace(0.5, 5.0, 100)
    beside = 0.5 * (at - 0.5)
    driven = (10.0 + beside + 3.0 * at / (2.0 * np.pi)) * np.array((np.cos(at), np.sin(at)))
    errors = []
    for scale in (1.0, 0.1):
        x, y = scale * driven
        log = Log(at, x, y, at + 0.5 * np.pi, np.full(100, 12.0 * scale), 0.0 * at)
        path = popsteer.Path(scale * spiral.T)
        car = popsteer.Vehicle(wheelbase=3.0 * scale)
        found = run(log, {f"{file}:Straight": None}, car, path=path)
        errors.append(found.shadows[f"{file}:Straight"].cross_track_error / scale)
    np.testing.assert_allclose(errors[1], errors[0], atol=1e-6)
    np.testing.assert_allclose(errors[0], -beside, atol=0.05)


def test_path_of_a_noisy_log_is_whittakers_graduation_of_it() -> None:
    """Against dense matrices, of a drive without a rest: the noise decides how much is smoothed."""
    pytest.importorskip("scipy")
    from popsteer.lab.replay.runs import LEAST, MOST, NOISE, _smoothed

    for size, base in ((0.0, 3.0), (0.003, 3.0), (0.05, 2.0)):
        random = np.random.default_rng(3)
        way = np.linspace(0.0, 40.0, 161)
        points = np.stack((way, 3.0 * np.sin(way / 6.0))) + random.normal(0.0, size, (2, 161))
        step = 0.25
        third = np.diff(np.eye(161), 3, axis=0)
        spread = np.median(np.abs(third @ points.T)) * 1.4826 / math.sqrt(20.0)
        length = (0.0556 * step * (spread * base / NOISE) ** 2) ** 0.2
        length = min(max(length, LEAST * base), MOST * base)
        smooth = np.linalg.solve(np.eye(161) + (length / step) ** 6 * third.T @ third, points.T)
        at = np.linspace(0.0, 40.0, 81)
        found = _smoothed(way, points, at, base)
        assert found == pytest.approx(smooth[::2].T, abs=1e-9), size
    # Too few rows to smooth stay as they are.
    few = np.array([[0.0, 1.0, 2.0, 4.0, 5.0, 6.0], [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]])
    assert _smoothed(few[0], few, few[0][:1], 3.0) == pytest.approx(few[:, :1])


def test_stretches_shorter_than_a_third_of_a_wheelbase_are_no_turns() -> None:
    from popsteer.lab.replay.runs import _turns

    way = np.array([0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 5.0, 6.0])
    for flags, ends in (
        ("00000000", [0.0, 6.0]),
        ("00011111", [0.0, 3.0, 6.0]),
        ("00001011", [0.0, 3.5, 6.0]),
        ("10000001", [0.0, 6.0]),
    ):
        backwards = np.array([flag == "1" for flag in flags])
        assert _turns(way, backwards, 1.0) == ends, flags


def test_own_controller_is_watched_where_its_point_is(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "import math\n"
        "from types import SimpleNamespace as Answer\n"
        "class Mine:\n"
        "    def __init__(self, path, vehicle):\n"
        "        self.tracked_point = 2.0\n"
        "    def step(self, x, y, yaw, speed, dt):\n"
        "        return Answer(steer=0.01 * x + y + yaw, status=64 if x > 3.0 else 0)\n",
        encoding="utf-8",
    )
    t = 0.1 * np.arange(80)
    for twin, sign in ((1.0, 1.0), (-1.0, -1.0)):
        yaw = np.full(80, sign * 0.2)
        log = Log(t, 0.5 * t, twin * (0.3 + 0.1 * t), yaw, 0.5 + 0.0 * t, 0.0 * t)
        name = f"{file}:Mine"
        shadow = run(log, {name: None}, popsteer.Vehicle(), path=STRAIGHT).shadows[name]
        assert shadow.cross_track_error == pytest.approx(log.y + 2.0 * np.sin(yaw))
        assert shadow.heading_error == pytest.approx(yaw)
        assert shadow.steer == pytest.approx(0.01 * log.x + log.y + yaw)
        assert shadow.status.tolist() == np.where(log.x > 3.0, 64, 0).tolist()


def test_progress_of_a_replay_rises_to_its_end() -> None:
    t = 0.05 * np.arange(1100)
    log = Log(t, 8.0 * t, 0.0 * t, 0.0 * t, 8.0 + 0.0 * t, 0.0 * t)
    told: list[tuple[str, float]] = []
    run(log, {"pid": None}, popsteer.Vehicle(), progress=lambda *each: told.append(each))
    assert [name for name, _ in told] == ["pid"] * 3
    assert [share for _, share in told] == pytest.approx([512 * k / 1100 for k in range(3)])


def test_page_of_an_identification_breaks_where_the_simulation_restarts_backwards_too() -> None:
    from popsteer.lab.report.identify import _scene

    t = 0.1 * np.arange(40)
    for speed in (6.0, -6.0):
        x = speed * t
        zero = 0.0 * t
        log = Log(t, x, zero, zero, zero + speed, zero)
        found = identification()
        # It restarts at row 25, two metres to the left.
        jump = np.where(np.arange(40) < 25, 0.0, 2.0)
        places = {"t": t, "x": x, "y": zero, "simulated_x": x, "simulated_y": jump}
        rates = dict.fromkeys(("yaw_rate", "simulated_yaw_rate", "position_error"), zero)
        records = {**places, **rates, "counts": t > 1.0}
        scene = _scene(replace(found, log=log, records=records))
        measured, simulated = (actor.columns for actor in scene.actors)
        assert np.flatnonzero(np.isnan(simulated["x"])).tolist() == [25], speed
        assert not np.isnan(measured["x"]).any()
        assert measured["distance"][-1] == pytest.approx(6.0 * 3.9)
