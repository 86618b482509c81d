"""A report as a browser shows it: driven by keys and pointer, at three widths, in both schemes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import sim, tracks
from popsteer.lab import compare, replay, report, sweep
from popsteer.lab.common.varied import distribution
from popsteer.logs import Log, read
from tests.cli import command
from tests.cli.report_page import READY, SIZES, box_of, cars, cursor, fits, put

if TYPE_CHECKING:
    from pathlib import Path

    from popsteer.identification import Identification
    from tests.browser import Browser

NAMES = ["pure-pursuit", "stanley", "pop"]
SPAN = "((r) => r[1] - r[0])(document.getElementById('map')._fullLayout.xaxis.range)"


def _path(name: str) -> popsteer.Path:
    track = tracks.get(name)
    return popsteer.Path(track.xy, speed=track.speed, closed=track.closed)


@pytest.fixture(scope="module")
def comparison() -> compare.Comparison:
    params = compare.parameters(NAMES, "reproduction")
    path = _path("slalom")
    # From beside the path, where the wheels come to their limits: there are statuses to be drawn.
    start = sim.default_start(path, -2.44, sim.vehicle_of("carla-identified"))
    found = replace(compare.run(path, params, start=start), track="slalom")
    times = dict.fromkeys(NAMES, 1e-6)
    return replace(found, step_times=times, latencies={name: [900, 1000, 1100] for name in NAMES})


@pytest.fixture(scope="module")
def file(comparison: compare.Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_bytes(report.of_comparison(comparison, origin=report.Origin("popsteer compare")))
    return file


@pytest.fixture
def page(browser: Browser, file: Path) -> Browser:
    """The page, open at a usual width."""
    browser.look(1280, 900)
    browser.open(file.as_uri())
    browser.wait(READY)
    browser.run("document.getElementById('drive').scrollIntoView({behavior: 'instant'})")
    _view(browser, "")
    browser.wait(f"{SPAN} > 300")
    return browser


def _view(page: Browser, choice: str) -> None:
    page.run(
        f"(() => {{ const v = document.getElementById('view'); v.value = '{choice}';"
        " v.dispatchEvent(new Event('change')); })()"
    )


def _near(places: dict[str, tuple[float, float]], runs: compare.Comparison, at: float) -> None:
    """Hold that each car is where its record has it at a time."""
    for name, (x, y) in places.items():
        records = runs.runs[name].records
        there = [np.interp(at, records["time"], records[axis]) for axis in ("x", "y")]
        assert np.hypot(there[0] - x, there[1] - y) < 0.05, name


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES, ids=lambda size: str(size[0]))
def test_page_fits_its_window_and_asks_the_network_for_nothing(
    browser: Browser, file: Path, size: tuple[int, int], dark: bool
) -> None:
    fits(browser, file, size, dark=dark)


def test_letters_of_the_plots_follow_the_scheme_when_it_changes(page: Browser) -> None:
    colour = "getComputedStyle(document.querySelector('#panels .annotation-text')).fill"
    light = page.run(colour)
    swatch = "document.querySelector('#readout .swatch').style.background"
    before = page.run(swatch)
    page.look(1280, 900, dark=True)
    page.wait(f"{colour} !== '{light}'")
    assert (light, page.run(colour)) == ("rgb(31, 35, 40)", "rgb(230, 237, 243)")
    page.wait(f"{swatch} !== '{before}'")
    page.wait(
        "document.querySelector('#map [data-actor=pop] rect').getAttribute('fill') === '#56b4e9'"
    )
    assert page.errors == []


def test_pointer_over_a_plot_moves_cursor_cars_and_values(
    page: Browser, comparison: compare.Comparison
) -> None:
    box = box_of(page, "#panels .nsewdrag")
    x = box["x"] + 0.4 * box["width"]
    page.point(x, box["y"] + 20.0)
    at = cursor(page)
    first, last = page.run("document.getElementById('panels')._fullLayout.xaxis.range")
    assert abs(at - (first + 0.4 * (last - first))) < 0.1
    line = box_of(page, "#panels .line")
    assert abs(line["x"] - x) < 2.0
    assert line["height"] > 300.0  # over all plots
    _near(cars(page), comparison, at)
    cells = page.run("[...document.querySelectorAll('#readout tbody tr')].map((r) => r.innerText)")
    for name, text in zip(NAMES, cells, strict=True):
        error = comparison.runs[name].records["cross_track_error"]
        shown = float(text.split("\t")[1].replace("\u2212", "-"))
        assert abs(shown - np.interp(at, np.arange(len(error)) * 0.05, error)) < 2e-3


def test_cars_look_and_steer_as_their_records_have_it(
    page: Browser, comparison: compare.Comparison
) -> None:
    put(page, 6.0)
    shown = page.run(
        """Object.fromEntries([...document.querySelectorAll('#map [data-actor]')].map((car) => {
          const m = car.transform.baseVal.consolidate().matrix;
          const turns = [...car.querySelectorAll('g')].map((wheel) =>
            wheel.getAttribute('transform').match(/rotate\\(([-.e\\d]+)\\)/)?.[1] ?? 0);
          return [car.dataset.actor, [Math.atan2(-m.b, m.a), Math.hypot(m.a, m.b), turns]];
        }))"""
    )
    for name, (yaw, scale, turns) in shown.items():
        records = comparison.runs[name].records
        k = int(np.searchsorted(records["time"], 6.0 - 1e-6))
        assert abs(np.angle(np.exp(1j * (records["yaw"][k] - yaw)))) < 1e-3, name
        assert scale > 0.0
        steer = np.degrees(records["steer"][k])
        assert np.allclose(list(map(float, turns)), [0.0, 0.0, steer, steer], atol=2e-3), name


def test_statuses_are_read_and_drawn(page: Browser, comparison: compare.Comparison) -> None:
    status = comparison.runs["stanley"].records["status"]
    k = int(np.flatnonzero(status)[0])
    put(page, 0.05 * k + 1e-4)
    cell = "document.querySelectorAll('#readout tbody tr')[1].lastElementChild"
    said = popsteer.Status(int(status[k]))
    assert page.run(f"[{cell}.textContent, {cell}.className]") == [
        str(said).replace("|", ", "),
        said.level,
    ]
    drawn = page.run(
        "document.getElementById('panels').data.filter((t) => t.actor === 'stanley'"
        " && t.yaxis === 'y5'"
        f" && t.line.width === {4 if said.level == 'degraded' else 11}).map((t) => [...t.x])[0]"
    )
    assert any(x is not None and abs(x - 0.05 * k) < 1e-3 for x in drawn)


def test_axes_fit_what_is_zoomed_to(page: Browser) -> None:
    ends = "document.getElementById('panels')._fullLayout.yaxis.range"
    low, high = page.run(ends)
    assert max(-low, high) < 2.0  # without the start, 2.44 m beside
    page.run("(Plotly.relayout('panels', {'xaxis.range[0]': 0, 'xaxis.range[1]': 1}), null)")
    page.wait(f"{ends}[0] < -2.4")
    page.run("(Plotly.relayout('panels', {'xaxis.autorange': true}), null)")
    page.wait(f"{ends}[0] === {low}")
    assert page.errors == []


def test_pointer_on_the_map_moves_the_cursor_to_that_place(
    page: Browser, comparison: compare.Comparison
) -> None:
    records = comparison.runs["pop"].records
    k = len(records["x"]) // 2
    place = page.run(
        f"""(() => {{
          const map = document.getElementById('map'), box = map.getBoundingClientRect();
          const {{xaxis, yaxis}} = map._fullLayout;
          return [box.x + xaxis._offset + xaxis.l2p({records["x"][k]}),
                  box.y + yaxis._offset + yaxis.l2p({records["y"][k]})];
        }})()"""
    )
    page.point(*place)
    # The nearest of three cars that go the same way, one pixel of map beside it at most.
    places = cars(page)
    assert min(abs(x - records["x"][k]) for x, _ in places.values()) < 1.5
    assert abs(cursor(page) - 0.05 * k) < 1.5


def test_space_plays_and_pauses_and_cars_drive(
    page: Browser, comparison: compare.Comparison
) -> None:
    before = cars(page)
    page.press(" ")
    assert page.run("document.getElementById('play').getAttribute('aria-label')") == "Pause"
    page.wait("Number(document.getElementById('cursor').value) > 3")
    page.press(" ")
    at = cursor(page)
    after = cars(page)
    assert page.run("document.getElementById('play').getAttribute('aria-label')") == "Play"
    assert all(np.hypot(after[n][0] - before[n][0], after[n][1] - before[n][1]) > 3 for n in NAMES)
    _near(after, comparison, at)
    assert cursor(page) == at
    assert page.errors == []


def test_playing_stops_at_the_end_and_begins_anew(page: Browser) -> None:
    page.press("End")
    end = cursor(page)
    page.press("ArrowLeft", shift=True)
    assert 0.3 < end - cursor(page) < 0.7
    page.press(" ")
    page.wait("document.getElementById('play').getAttribute('aria-label') === 'Play'")
    assert cursor(page) == end
    page.press(" ")
    page.wait(f"Number(document.getElementById('cursor').value) < {end} / 2")
    page.press(" ")


def test_arrows_move_the_cursor_by_a_step(page: Browser) -> None:
    put(page, 5.0)
    page.run("document.activeElement.blur()")
    page.press("ArrowRight")
    assert abs(cursor(page) - 5.05) < 1e-3
    page.press("ArrowLeft")
    page.press("ArrowLeft", shift=True)
    assert abs(cursor(page) - 4.5) < 1e-3
    page.press("Home")
    assert cursor(page) == 0.0
    text = page.run("document.getElementById('cursor').getAttribute('aria-valuetext')")
    assert text == "0.00 s"


def test_keyboard_reaches_every_control(page: Browser) -> None:
    page.run("document.activeElement.blur(); window.scrollTo(0, 0)")
    seen = set()
    for _ in range(60):
        page.press("Tab")
        seen.add(page.run("document.activeElement.id || document.activeElement.className"))
    assert {"view", "play", "cursor", "rate", "copy", "skip"} <= seen


def test_distance_puts_the_cars_side_by_side_under_the_same_cursor(page: Browser) -> None:
    put(page, 12.0)
    apart = {name: x for name, (x, _) in cars(page).items()}
    page.run("document.querySelector('input[value=distance]').click()")
    page.wait("document.getElementById('now').textContent.endsWith(' m')")
    together = {name: x for name, (x, _) in cars(page).items()}
    assert max(together.values()) - min(together.values()) < 2.5
    assert max(apart.values()) - min(apart.values()) > max(together.values()) - min(
        together.values()
    )
    # The first car stays where it was.
    assert abs(together[NAMES[0]] - apart[NAMES[0]]) < 0.2
    title = page.run("document.getElementById('panels')._fullLayout.xaxis.title.text")
    assert title == "distance along the path [m]"
    page.run("document.querySelector('input[value=time]').click()")
    page.wait("document.getElementById('now').textContent.endsWith(' s')")
    assert abs(cursor(page) - 12.0) < 0.05


def test_hidden_controller_leaves_map_and_plots(page: Browser) -> None:
    put(page, 6.0)
    page.run("document.querySelector('#readout tbody input').click()")
    page.wait("document.querySelector('#map [data-actor=pure-pursuit]').style.display === 'none'")
    shown = page.run(
        "document.getElementById('panels').data.filter((t) => t.visible).map((t) => t.actor)"
    )
    assert set(shown) == {"stanley", "pop"}
    page.run("document.querySelector('#readout tbody input').click()")
    page.wait("document.querySelector('#map [data-actor=pure-pursuit]').style.display === ''")


def test_map_follows_the_car_that_is_chosen(page: Browser) -> None:
    _view(page, "2")
    put(page, 10.0)
    middle = "((r) => (r[0] + r[1]) / 2)(document.getElementById('map')._fullLayout.xaxis.range)"
    for _ in range(100):
        put(page, 10.0)
        if abs(float(page.run(middle)) - cars(page)["pop"][0]) < 0.5:
            break
    assert abs(float(page.run(middle)) - cars(page)["pop"][0]) < 0.5
    near = page.run(SPAN)
    page.look(1280, 900, dark=True)
    page.wait("getComputedStyle(document.body).backgroundColor === 'rgb(13, 17, 23)'")
    page.wait(f"Math.abs({SPAN} - {near}) < 1")  # the change of colours keeps it there
    assert abs(float(page.run(middle)) - cars(page)["pop"][0]) < 0.5
    assert page.errors == []


def test_map_of_a_long_line_follows_a_car_and_paper_is_light_and_as_wide_as_a_sheet(
    browser: Browser, file: Path
) -> None:
    browser.look(1280, 900, dark=True)
    browser.open(file.as_uri())
    browser.wait(READY)
    # The whole slalom, 307 m by 6 m, would be a hairline.
    assert browser.run("document.getElementById('view').value") == "0"
    browser.wait(f"{SPAN} < 50")
    widths = "[...document.querySelectorAll('.main-svg')].map((each) => each.clientWidth)"
    shut = "document.querySelectorAll('details:not([open])').length"
    closed = browser.run(shut)
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    colour = "getComputedStyle(document.querySelector('#panels .annotation-text')).fill"
    browser.wait(f"{colour} === 'rgb(31, 35, 40)'")
    assert set(browser.run(widths)) == {680}
    assert (closed > 0, browser.run(shut)) == (True, 0)
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    browser.wait(f"{colour} === 'rgb(230, 237, 243)'")
    browser.wait(f"!{widths}.includes(680)")
    assert browser.run(shut) == closed
    assert browser.errors == []


def test_choice_of_plant_and_track_shows_its_map(browser: Browser, tmp_path: Path) -> None:
    found = compare.run_each(
        {name: _path(name) for name in ("straight", "slalom")}, ["pop"], ["kinematic-bicycle"]
    )
    file = tmp_path / "several.html"
    file.write_bytes(report.of_comparison(*found))
    browser.look(1280, 900)
    browser.open(file.as_uri())
    browser.wait(READY)
    high = "Math.max(...document.getElementById('map').data.at(-1).y)"
    assert browser.run(high) < 0.5  # along the straight
    browser.run("document.querySelector('[data-scene=\"1\"]').click()")
    browser.wait(f"{high} > 1")
    assert browser.run("document.getElementById('scene').value") == "1"
    browser.wait("document.querySelectorAll('#gallery .main-svg').length >= 2")
    assert browser.errors == []


def test_command_is_copied_or_else_selected(page: Browser) -> None:
    button = "document.querySelector('#command .copy')"
    page.run(f"{button}.click()")
    page.wait(f"{button}.textContent !== 'Copy'")
    if page.run(f"{button}.textContent") == "Selected":
        assert page.run("getSelection().toString()") == "popsteer compare"
    page.wait(f"{button}.textContent === 'Copy'")
    assert page.errors == []


def test_log_with_a_gap_is_drawn_with_a_gap_and_driven_by_the_driver(
    browser: Browser, tmp_path: Path
) -> None:
    t = np.arange(0.0, 20.0, 0.05)
    t[200:] += 5.0
    log = Log(t, 8.0 * t, 0.0 * t, 0.0 * t, 8.0 + 0.0 * t, 0.01 + 0.0 * t)
    assert log.gaps == (200,)
    found = replay.run(log, {"stanley": None, "pop": None}, popsteer.Vehicle())
    file = tmp_path / "replay.html"
    file.write_bytes(report.of_replay(found))
    browser.look(360, 740, mobile=True)
    browser.open(file.as_uri())
    browser.wait(READY)
    for plot, axis in (("map", "x"), ("panels", "y")):
        driver = f"document.getElementById('{plot}').data.find((t) => t.actor === 'driver').{axis}"
        broken = browser.run(f"[...{driver}].flatMap((v, k) => Number.isFinite(v) ? [] : [k])")
        assert broken == [200], plot
    put(browser, 5.0)
    places = cars(browser)
    assert abs(places["driver"][0] - 40.0) < 0.05
    # The others are rays on the driver's car.
    assert places["stanley"] == places["pop"] == places["driver"]
    assert browser.run("document.documentElement.scrollWidth") == 360
    assert browser.errors == []


pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Identification:
    file = tmp_path_factory.mktemp("log") / "drive.csv"
    return popsteer.identify(read(command.write_csv(file, command.drive(20.0))))


@pytest.fixture(scope="module")
def identified(found: Identification, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("identify") / "report.html"
    command = "popsteer identify drive.csv --set-vehicle wheelbase=2.7 --report report.html"
    file.write_bytes(report.of_identification(found, origin=report.Origin(command)))
    return file


@pytest.fixture(scope="module")
def job() -> sweep.Job:
    path = popsteer.Path(tracks.get("straight").xy)
    # The first is longer than the narrow page.
    vary = {"start_offset": "uniform(-0.87654321,0.87654321)", "start_yaw": "normal(0,0.05)"}
    drawn = {name: distribution(name, text) for name, text in vary.items()}
    return sweep.Job(path, "pop", popsteer.PopParams(), "kinematic-bicycle", drawn, 12)


@pytest.fixture(scope="module")
def swept(job: sweep.Job, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("sweep") / "report.html"
    file.write_bytes(report.of_sweep(job, sweep.run(job)))
    return file


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES, ids=lambda size: str(size[0]))
def test_page_of_an_identification_fits_its_window_and_is_whole(
    browser: Browser, identified: Path, size: tuple[int, int], dark: bool
) -> None:
    fits(browser, identified, size, dark=dark)
    assert browser.run("document.querySelectorAll('#gallery figure').length") == 2
    # Where the command breaks, it breaks between words.
    words = browser.run(
        """[...document.querySelectorAll('#command .word')].map(
          (each) => [each.textContent, each.getBoundingClientRect().height])"""
    )
    assert [word for word, _ in words] == ["--set-vehicle", "--report"]
    assert len({height for _, height in words}) == 1


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES, ids=lambda size: str(size[0]))
def test_page_of_a_sweep_fits_its_window_and_is_whole(
    browser: Browser, swept: Path, job: sweep.Job, size: tuple[int, int], dark: bool
) -> None:
    fits(browser, swept, size, dark=dark)
    titles = browser.run("[...document.querySelectorAll('#gallery figcaption')].map((c) => c.id)")
    # The worst run, errors, starts, and a figure for each quantity that varies.
    assert len(titles) == 3 + len(job.vary)
    # No button lies over what it copies.
    covered = browser.run(
        """[...document.querySelectorAll('details[open] .code')].map((each) => {
          const button = each.querySelector('.copy').getBoundingClientRect();
          const range = document.createRange();
          range.selectNodeContents(each.querySelector('code'));
          return [...range.getClientRects()].some((line) =>
            line.right > button.left && line.top < button.bottom && line.bottom > button.top);
        })"""
    )
    assert covered == [False]


def test_identified_car_and_its_simulation_stand_where_the_log_has_them(
    browser: Browser, found: Identification, identified: Path
) -> None:
    browser.look(1280, 900)
    browser.open(identified.as_uri())
    browser.wait(READY)
    records = found.records
    for at in (0.0, 7.3):
        put(browser, at)
        places = cars(browser)
        for name, x, y in (("measured", "x", "y"), ("simulated", "simulated_x", "simulated_y")):
            there = [np.interp(at, records["t"] - records["t"][0], records[c]) for c in (x, y)]
            assert np.hypot(there[0] - places[name][0], there[1] - places[name][1]) < 0.05
    # At the ends of the drive the map has room for the car.
    left, right = browser.run("document.getElementById('map')._fullLayout.xaxis.range")
    assert left + 0.03 * (right - left) < np.min(records["x"])
    assert np.max(records["x"]) < right - 0.03 * (right - left)
    assert browser.run("document.querySelectorAll('#map circle').length") == 1
    assert browser.errors == []


def test_cars_of_a_sweep_are_its_median_run_and_its_worst_ones(
    browser: Browser, swept: Path, job: sweep.Job
) -> None:
    browser.look(360, 740, dark=True, mobile=True)
    browser.open(swept.as_uri())
    browser.wait(READY)
    places = cars(browser)
    assert len(places) == 7
    for name, (x, y) in places.items():
        run = sweep.repeat(job, int(name.removeprefix("run-")))
        start = run.records["x"][0], run.records["y"][0]
        assert np.hypot(start[0] - x, start[1] - y) < 0.05, name
    marks = browser.run("document.getElementById('map').data.at(-1).text")
    assert len(marks) == 6
    browser.run("document.querySelectorAll('#readout tbody input')[0].click()")
    browser.wait("document.querySelector('#map [data-actor]').style.display === 'none'")
    browser.press(" ")
    browser.wait("Number(document.getElementById('cursor').value) > 1")
    browser.press(" ")
    assert browser.errors == []
