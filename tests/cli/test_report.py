"""`--report FILE.html`: what each command's page holds, and what is refused before the work."""

from __future__ import annotations

import base64
import dataclasses
import io
import math
import re
import shlex
import zlib
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

import popsteer
from popsteer import lab
from popsteer.cli import main
from popsteer.lab.common.varied import distribution
from popsteer.params_file import load_all
from tests.cli import command
from tests.helpers import looped
from tests.pages_of_html import Html, columns

# Quick ones: each command that writes a report.
DRIVEN = {
    "compare": ("compare", "--controllers", "stanley,pop", "--track", "slalom"),
    "one": (
        "compare",
        "--controllers",
        "pop",
        "--track",
        "straight",
        "--start-offset=1",
        "--set",
        "min_lookahead=4",
    ),
    "matrix": (
        "compare",
        "--plants",
        "carla-identified,kinematic-bicycle",
        "--controllers",
        "stanley,pop",
        "--tracks",
        "straight,slalom",
    ),
    "sweep": ("sweep", "--controller", "pop", "--track", "straight", "--runs", "30"),
}
WATCHED = {
    "identify": ("identify", "drive.csv", "--set-vehicle", "wheelbase=2.7"),
    "replay": ("replay", "drive.csv", "--vehicle", "car.toml", "--controllers", "stanley,pop"),
}
PLANNED = {
    "plan": ("plan", "course.csv", "--vehicle", "car.toml"),
    "stability": ("stability", "--controllers", "stanley,pop", "--speeds", "5,10"),
    "tune": (
        *("tune", "--controller", "pop", "--tracks", "straight", "--trials", "3"),
        *("--cars", "1", "--constant-speed", "8"),
    ),
}
ALL = {**DRIVEN, **WATCHED, **PLANNED}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Html, str]]:
    """The page of each command, and what it printed."""
    folder = tmp_path_factory.mktemp("reports")
    command.write_csv(folder / "drive.csv", command.drive())
    command.CAR.save(folder / "car.toml")
    bends = "".join(f"{x},{5.0 * math.sin(0.05 * x):.4f}\n" for x in range(120))
    (folder / "course.csv").write_text(bends, encoding="utf-8")
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name, arguments in ALL.items():
            # In this process: another one would spend most of its time on imports.
            printed = io.StringIO()
            with redirect_stdout(printed), pytest.raises(SystemExit) as exit_:
                main([*arguments, "--report", f"{name}.html"])
            assert exit_.value.code == 0, name
            text = (folder / f"{name}.html").read_text(encoding="utf-8")
            found[name] = (Html(text), printed.getvalue())
            assert len(text.encode()) <= 2_500_000
    return found


each_page = looped("name", ALL)


@each_page
def test_page_is_one_file_that_loads_nothing(made: dict[str, tuple[Html, str]], name: str) -> None:
    page, printed = made[name]
    assert page.loads == ["data:,"]
    assert not [found for tag, found in page.elements if tag in ("iframe", "object", "embed")]
    # Styles that load; the library's own script holds addresses, which nothing asks for.
    assert not any(re.search(r"url\(|@import", text) for text in page.texts["style"])
    assert b"plotly.js v" in zlib.decompress(base64.b64decode(page.texts["script"][0]))
    assert f"Written to {name}.html" in printed


@each_page
def test_page_has_its_parts_and_each_name_once(
    made: dict[str, tuple[Html, str]], name: str
) -> None:
    page, _ = made[name]
    assert len(page.ids()) == len(set(page.ids()))
    assert {"map", "panels", "readout", "play", "cursor", "results", "command"} <= set(page.ids())
    links = [found["href"][1:] for tag, found in page.elements if tag == "a"]
    assert set(links) <= set(page.ids())
    for tag, found in page.elements:  # whoever sees no picture is told what it is
        if found.get("role") in ("img", "region", "group", "radiogroup"):
            assert found.get("aria-label") or found.get("aria-labelledby"), (tag, found)


@each_page
def test_page_begins_with_a_verdict(made: dict[str, tuple[Html, str]], name: str) -> None:
    page, _ = made[name]
    begun = [k for k, (tag, found) in enumerate(page.elements) if found.get("id") == "results"]
    heading, badge = page.elements[begun[0] + 1 : begun[0] + 3]
    assert (heading[0], badge[1]["class"].split()[0]) == ("h2", "verdict")
    said = {
        "compare": "2 of 2 runs finished without a fault",
        "one": "1 of 1 run finished without a fault",
        "sweep": "30 of 30 runs succeeded, 100 %",
        "identify": "The vehicle explains the heading to within the noise of the log",
        "replay": "2 of 2 controllers reported no fault along the drive",
        "plan": "The wheels turn far enough for every bend",
        "stability": "4 of 4 loops are stable",
        "tune": "of 3 trials",
    }
    assert said.get(name, "runs finished") in " ".join(page.texts["strong"])


@each_page
def test_page_names_the_command_that_repeats_it(
    made: dict[str, tuple[Html, str]], name: str
) -> None:
    page, _ = made[name]
    wanted = ["popsteer", *ALL[name], "--report", f"{name}.html"]
    commands = [text for text in page.texts["code"] if text.startswith("popsteer ")]
    assert wanted in map(shlex.split, commands)


@each_page
def test_page_has_the_figures_of_the_printed_table(
    made: dict[str, tuple[Html, str]], name: str
) -> None:
    page, printed = made[name]
    cells = {text for tag in ("td", "th", "strong") for text in page.texts.get(tag, [])}
    cells |= {word for cell in cells for word in cell.split()}
    # Every number with decimals that the tables hold.
    rows = [line for line in printed.splitlines() if re.match(r"^\S.* {2,}", line)]
    pattern = rf"(?<= )-?\d+\.\d{{{1 if name in ('plan', 'stability') else 2},}}(?= |$)"
    numbers = {each for line in rows for each in re.findall(pattern, line)}
    assert len(numbers) >= 4
    assert numbers <= cells


@pytest.mark.parametrize("name", ["compare", "one", "matrix", "sweep"])
def test_page_has_vehicle_and_parameters_that_load_again(
    made: dict[str, tuple[Html, str]], name: str, tmp_path: Path
) -> None:
    page, _ = made[name]
    vehicles = [text for text in page.texts["code"] if "\nwheelbase = " in text]
    assert vehicles
    for text in vehicles:
        (tmp_path / "car.toml").write_text(text, encoding="utf-8")
        car = popsteer.Vehicle.load(tmp_path / "car.toml")
        assert car in (
            popsteer.sim.vehicle_of("carla-identified"),
            popsteer.sim.vehicle_of("kinematic-bicycle"),
        )
    tuned = [text for text in page.texts["code"] if "\n[pop]\n" in text]
    (tmp_path / "pop.toml").write_text(tuned[0], encoding="utf-8")
    found: Any = load_all(tmp_path / "pop.toml")["pop"]
    if name == "one":
        assert found.min_lookahead == 4.0
    assert any("[run]" in text and "settling_time" in text for text in page.texts["code"])


def test_page_of_an_identification_has_the_vehicle_that_out_writes(
    made: dict[str, tuple[Html, str]], tmp_path: Path
) -> None:
    page, _ = made["identify"]
    (tmp_path / "car.toml").write_text(
        next(text for text in page.texts["code"] if "wheelbase = " in text), encoding="utf-8"
    )
    found = popsteer.Vehicle.load(tmp_path / "car.toml")
    assert abs(found.turning_length(8.0) - command.CAR.turning_length(8.0)) < 0.05


def test_cars_of_a_comparison_are_where_the_records_have_them(
    made: dict[str, tuple[Html, str]],
) -> None:
    page, _ = made["compare"]
    document = page.document()
    (scene,) = document["scenes"]
    track = popsteer.tracks.get("slalom")
    again = lab.compare.run(popsteer.Path(track.xy, speed=track.speed), ["stanley", "pop"])
    for actor in scene["actors"]:
        found = columns(document, actor)
        records = again.runs[actor["name"]].records
        for name in ("x", "y", "speed", "cross_track_error"):
            assert np.max(np.abs(found[name] - records[name])) < 1e-3, (actor["name"], name)
        levels = {int(bits): level for bits, (level, _) in scene["statuses"].items()}
        assert {levels[int(bits)] for bits in found["status"]} <= {"ok", "degraded", "fault"}


def test_timed_steps_are_on_the_page_of_a_comparison_and_not_in_its_printed_table(
    made: dict[str, tuple[Html, str]],
) -> None:
    page, printed = made["compare"]
    assert "step" not in printed.split("\n\n")[1]
    (scene,) = page.document()["scenes"]
    (figure,) = scene["figures"]
    assert [trace["name"] for trace in figure["traces"]] == ["Stanley", "POP"]
    for trace in figure["traces"]:
        assert abs(sum(trace["y"]) - 100.0) < 0.1
        assert trace["x"] == sorted(trace["x"])


def test_page_of_a_matrix_has_a_map_for_each_plant_and_track(
    made: dict[str, tuple[Html, str]],
) -> None:
    page, _ = made["matrix"]
    titles = [scene["title"] for scene in page.document()["scenes"]]
    plants, tracks = ("carla-identified", "kinematic-bicycle"), ("straight", "slalom")
    assert titles == [f"{plant}, {track}" for plant in plants for track in tracks]
    assert [text for text in page.texts["option"] if "," in text] == titles
    assert len(page.document()["figures"]) == len(plants)


def test_page_of_a_sweep_has_rate_seeds_and_the_worst_runs(
    made: dict[str, tuple[Html, str]],
) -> None:
    page, printed = made["sweep"]
    share = re.search(r"([\d.]+) % \(95 % confidence: ([\d.]+) to ([\d.]+) %\)", printed)
    assert share is not None
    assert any(text.endswith(f", {share[1]} %") for text in page.texts["strong"])
    assert any(f"{share[2]} to {share[3]} %" in text for text in page.texts["span"])
    worst = re.search(r"worst run +finished[^\n]*\n[^\n]*\n +(\d+)", printed)
    assert worst is not None
    (scene,) = page.document()["scenes"]
    names = [actor["title"] for actor in scene["actors"]]
    assert names[0].startswith("median, run ")
    assert names[1] == f"run {worst[1]}"
    assert len(scene["marks"]) == len(names) - 1
    path = popsteer.Path(popsteer.tracks.get("straight").xy)
    job = lab.sweep.Job(path, "pop", popsteer.PopParams(), "carla-identified", {}, 30)
    assert str(job.seed_of(int(worst[1]))) in page.texts["td"]
    first = page.document()["figures"][0]
    assert "the envelope is of all runs" in first["note"]
    low, high, line = (dict(zip(t["x"], t["y"], strict=True)) for t in first["traces"])
    assert set(line) <= set(low) == set(high)
    assert all(low[x] <= y <= high[x] for x, y in line.items())
    assert max(high.values()) - min(low.values()) > 1.01 * (max(line.values()) - min(line.values()))


def test_page_of_a_replay_drives_the_log_and_shows_who_would_have_steered(
    made: dict[str, tuple[Html, str]],
) -> None:
    page, _ = made["replay"]
    document = page.document()
    (scene,) = document["scenes"]
    assert [actor["body"] for actor in scene["actors"]] == ["car", "ray", "ray"]
    driver, stanley, _ = (columns(document, actor) for actor in scene["actors"])
    assert np.allclose(
        stanley["difference_deg"], stanley["steer_deg"] - driver["steer_deg"], atol=2e-3
    )


@pytest.fixture
def _parked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails the test where something is driven or read."""

    def refuse(*_: object, **__: object) -> NoReturn:
        pytest.fail("the work was done before the output was refused")

    for experiment, work in ((lab.compare, "run_each"), (lab.sweep, "run")):
        monkeypatch.setattr(experiment, work, refuse)
    monkeypatch.setattr("popsteer.cli.inputs.log", refuse)


@pytest.mark.usefixtures("_parked")
@pytest.mark.parametrize("arguments", ALL.values(), ids=ALL)
def test_report_that_cannot_be_written_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    command.CAR.save(tmp_path / "car.toml")
    (tmp_path / "drive.csv").write_text("t,x\n")
    (tmp_path / "folder.html").mkdir()
    for place, said in (
        ("page.pdf", "--report must be a file *.html, got 'page.pdf'"),
        ("page", "--report must be a file *.html, got 'page'"),
        ("folder.html", "folder.html: Is a directory"),
        ("car.toml/page.html", "car.toml/page.html: Not a directory"),
    ):
        outcome = command.call(capsys, *arguments, "--report", place)
        assert (outcome.status, outcome.out) == (2, "")
        assert outcome.err == f"popsteer: {said}\n"
    left = {file.name for file in tmp_path.iterdir()}
    assert left == {"car.toml", "drive.csv", "folder.html"}


def test_report_of_a_repeated_run_is_that_run(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = popsteer.Path(popsteer.tracks.get("straight").xy)
    lag = {"steer_lag": distribution("steer_lag", "uniform(0.05,0.2)")}
    job = lab.sweep.Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", lag, 10)
    job = dataclasses.replace(job, course="straight")
    rows = lab.sweep.run(job, Path("sweep.csv"))
    again = ("sweep", "--run", "sweep.csv:7", "--report", "run.html")
    outcome = command.call(capsys, *again)
    assert outcome.status == 0
    assert "to the last bit" in outcome.out
    page = Html((tmp_path / "run.html").read_text(encoding="utf-8"))
    assert "POP on straight" in page.texts["h1"]
    whole = Html(lab.report.of_sweep(job, rows, "sweep.csv").decode())
    assert any("--run sweep.csv:" in text for text in whole.texts["code"])
