"""The pages of an identification and of a sweep as a browser shows them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import tracks
from popsteer.lab import report, sweep
from popsteer.lab.common.distributions import distribution
from popsteer.logs import read
from tests.cli import logs
from tests.cli.report_page import READY, SIZES, cars, fits, put

if TYPE_CHECKING:
    from pathlib import Path

    from popsteer.identification import Identification
    from tests.browser import Browser

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Identification:
    file = tmp_path_factory.mktemp("log") / "drive.csv"
    return popsteer.identify(read(logs.write_csv(file, logs.drive(20.0))))


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
