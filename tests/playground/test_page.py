"""The page, driven in a browser as a person drives it."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest

from popsteer.lab.common.theme import THEMES
from tests.cli.command import call
from tests.playground.built import BUILD

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from playwright.sync_api import Browser, Page

    from tests.playground.built import Built

    Opener = Callable[..., Page]

DONE = '#results[aria-busy="false"]'


@pytest.fixture
def opened(built: Built, browser: Browser) -> Iterator[Opener]:
    """Opens the page; fails where it says anything on the console or asks for anything."""
    said: list[str] = []
    contexts = []

    def open_(address: str = "", **options: Any) -> Page:
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: said.append(request.url))
        page.goto(built.page.as_uri() + address)
        page.locator(DONE).wait_for()
        said[:] = [each for each in said if not each.startswith((built.page.as_uri(), "data:"))]
        return page

    yield open_
    for context in contexts:
        context.close()
    assert said == []


def _wait(page: Page) -> None:
    page.locator(DONE).wait_for()


def _table(page: Page) -> dict[str, list[str]]:
    rows = [row.split("\t") for row in page.locator("#rows").inner_text().splitlines() if row]
    return {row[0]: row[1:] for row in rows}


def _message(page: Page) -> str:
    message = page.locator("#message")
    return message.inner_text() if message.is_visible() else ""


def _coloured(page: Page, canvas: str, colour: str) -> int:
    """How many pixels of a canvas have just this colour."""
    found: int = page.evaluate(
        """([canvas, colour]) => {
            const { width, height } = document.querySelector(canvas);
            const context = document.querySelector(canvas).getContext("2d");
            const { data } = context.getImageData(0, 0, width, height);
            const value = popsteer.colour(colour);
            const wanted = [1, 3, 5].map((at) => parseInt(value.slice(at, at + 2), 16)).concat(255);
            let count = 0;
            for (let at = 0; at < data.length; at += 4)
                count += wanted.every((part, index) => data[at + index] === part);
            return count;
        }""",
        [canvas, colour],
    )
    return found


def test_page_small_and_alone(built: Built) -> None:
    text = built.page.read_text(encoding="utf-8")
    assert built.page.stat().st_size <= 400_000
    assert not re.search(r"<(?:script|link|img)[^>]+(?:src|href)=\"(?!data:)", text)


def test_page_colours_are_those_of_the_figures() -> None:
    css = BUILD.with_name("style.css").read_text(encoding="utf-8")
    light, dark = css.split("@media (prefers-color-scheme: dark)")
    for theme, given in (("light", light), ("dark", dark)):
        laws = THEMES[theme].laws
        for name in ("pop", "preview-pop", "pure-pursuit", "stanley", "pid"):
            assert f"--{name}: {laws[name]};" in given, (theme, name)


def test_build_without_target_says_so_in_one_line(tmp_path: Path) -> None:
    rustc = tmp_path / "rustc"
    rustc.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    rustc.chmod(0o755)
    done = subprocess.run(
        [sys.executable, str(BUILD), str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": str(tmp_path)},
    )
    assert done.returncode == 1
    assert done.stderr == (
        "the Rust target wasm32-unknown-unknown is not installed:"
        " rustup target add wasm32-unknown-unknown\n"
    )
    assert not (tmp_path / "out").exists()


def test_page_first_look(opened: Opener) -> None:
    page = opened()
    table = _table(page)
    assert list(table) == ["POP", "Preview POP", "Pure pursuit"]
    assert all(row[-1].startswith("finished") for row in table.values())
    assert float(table["Preview POP"][0]) < 0.01 < float(table["POP"][0])
    for canvas in ("#map", "#errors", "#angles"):
        assert _coloured(page, canvas, "pop") > 50, canvas
    assert page.url.endswith("index.html")
    assert _message(page) == ""


def test_page_slider_drives_anew(opened: Opener) -> None:
    page = opened()
    before = _table(page)
    page.locator("#max_steer_rate").focus()
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
        _wait(page)
        assert _table(page) != before
        before = _table(page)
    assert page.locator("#max_steer_rate-field").input_value() == "0.15"
    assert page.url.endswith("#max_steer_rate=0.15")


def test_page_slider_dragged_fast_ends_where_it_was_left(opened: Opener) -> None:
    page = opened("#track=slalom")
    page.locator("#speed").evaluate(
        """async (range) => {
            for (let speed = 4; speed <= 12; speed += 0.5) {
                range.value = speed;
                range.dispatchEvent(new Event("input"));
                await new Promise((next) => setTimeout(next, 3));
            }
        }"""
    )
    _wait(page)
    assert page.url.endswith("#track=slalom&speed=12")
    assert _table(page) == _table(opened("#track=slalom&speed=12"))


def test_page_preview_with_limits_beats_it_without(opened: Opener) -> None:
    page = opened("#track=slalom&controllers=preview-pop,preview-pop-unlimited")
    table = _table(page)
    within, without = table["Preview POP"], table["Preview POP, limits unknown"]
    assert float(within[0]) < 0.05
    assert float(without[0]) > 1.0
    assert _coloured(page, "#map", "preview-pop-unlimited") > 50
    # Fast wheels: there is no limit to be known.
    page.locator("#max_steer_rate-field").fill("20")
    _wait(page)
    table = _table(page)
    assert float(table["Preview POP, limits unknown"][0]) < 0.1


# Small enough for all loops to be stable: in another no digit lasts.
@pytest.mark.parametrize("car", ["", "&known=0&steer_lag=0.05&dead_time=0.05"])
def test_page_command_drives_the_same(
    opened: Opener, capsys: pytest.CaptureFixture[str], car: str
) -> None:
    page = opened(f"#track=slalom&controllers=pop,pure-pursuit,stanley&speed=8{car}")
    command = page.locator("#command").inner_text()
    assert command.startswith("popsteer compare --controllers pop,pure-pursuit,stanley")
    outcome = call(capsys, *shlex.split(command.replace("\\\n", " "))[1:])
    assert outcome.status == 0
    for row in _table(page).values():
        assert row[0] in outcome.out, outcome.out
    page.locator("#slow_in_bends").check()
    _wait(page)
    assert not page.locator("#command").is_visible()


def test_page_every_track_is_driven(opened: Opener) -> None:
    page = opened("#controllers=preview-pop&speed=6")
    tracks = page.locator("#track option").evaluate_all("all => all.map((each) => each.value)")
    assert len(tracks) == 8
    for track in tracks:
        page.locator("#track").select_option(track)
        _wait(page)
        assert float(_table(page)["Preview POP"][0]) < 0.05, track
    assert "closed lap" not in page.locator("#track-title").inner_text()
    page.locator("#track").select_option("circle")
    _wait(page)
    assert "closed lap" in page.locator("#track-title").inner_text()


def test_page_track_drawn_with_the_pointer(opened: Opener) -> None:
    page = opened("#controllers=preview-pop,pure-pursuit&speed=5")
    page.get_by_role("button", name="Draw a track").click()
    box = page.locator("#map").bounding_box()
    assert box
    left, top = box["x"] + 100, box["y"] + 120
    corners = [(0, 0), (500, 0), (560, 120), (380, 240), (200, 180), (0, 300), (0, 10)]
    page.mouse.move(left, top)
    page.mouse.down()
    for x, y in corners:
        page.mouse.move(left + x, top + y, steps=12)
    page.mouse.up()
    _wait(page)
    assert page.locator("#track").input_value() == "drawn"
    assert page.locator("#track-title").inner_text().endswith("a closed lap")
    assert all(float(row[0]) < 1.0 for row in _table(page).values())
    with page.expect_download() as saving:
        page.get_by_role("link", name="Save the waypoints").click()
    lines = saving.value.path().read_text(encoding="utf-8").splitlines()
    count = int(page.locator("#track-title").inner_text().split()[0])
    assert len(lines) == count + 1
    assert "--waypoints drawn.csv --closed" in page.locator("#command").inner_text()


def test_page_track_drawn_with_the_keys(opened: Opener) -> None:
    page = opened("#controllers=preview-pop&speed=5")
    page.get_by_role("button", name="Draw a track").press("Enter")
    for key in ("ArrowRight",) * 5 + ("ArrowUp",) * 4 + ("ArrowRight",) * 5 + ("Enter",):
        page.keyboard.press(key)
    _wait(page)
    assert page.locator("#track").input_value() == "drawn"
    assert page.locator("#track-title").inner_text().endswith("open")
    page.get_by_role("button", name="Draw a track").click()
    page.keyboard.press("Escape")
    assert page.locator("#track").input_value() == "drawn"
    assert page.get_by_role("button", name="Draw a track").is_visible()


def test_page_bad_input_is_named_and_the_page_works_on(opened: Opener) -> None:
    page = opened("#wheelbase=nonsense&track=monaco")
    assert _message(page) == "wheelbase must be in [0.001, 1000.0], got NaN"
    assert _table(page) == {}
    field = page.locator("#wheelbase-field")
    field.fill("0.0000001")
    _wait(page)
    assert "wheelbase must be in" in _message(page)
    assert field.get_attribute("aria-invalid") == "true"
    field.fill("2.7")
    _wait(page)
    assert _message(page) == ""
    assert len(_table(page)) == 3
    # A track of one point.
    page.get_by_role("button", name="Draw a track").click()
    page.locator("#map").click()
    assert _message(page).startswith("a track is at least 20 m long, the line drawn is 0.0 m")
    assert page.locator("#track").input_value() == "racetrack"
    page.locator("#speed").press("ArrowRight")
    _wait(page)
    assert _message(page) == ""
    assert len(_table(page)) == 3
    for box in ("pop", "preview-pop", "pure-pursuit"):
        page.locator(f"#{box}").uncheck()
    _wait(page)
    assert _table(page) == {}


def test_page_plays_and_is_worked_by_keys(opened: Opener) -> None:
    page = opened("#track=straight")
    page.get_by_role("button", name="Play").press("Enter")
    page.get_by_role("button", name="Pause").wait_for()
    page.locator("#clock:not(:text-is('0.0 s'))").wait_for()
    page.get_by_role("button", name="Pause").press(" ")
    page.locator("#time").press("Home")
    page.locator("#clock:text-is('0.0 s')").wait_for()
    page.locator("body").focus()
    reached = set()
    for _ in range(45):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id"))
    everything = page.locator("button, select, input, canvas[tabindex]").evaluate_all(
        "all => all.map((each) => each.id)"
    )
    assert set(everything) <= reached


@pytest.mark.parametrize("width", [360, 1280, 2560])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_fits_every_screen(opened: Opener, width: int, scheme: str) -> None:
    page = opened("#track=slalom", viewport={"width": width, "height": 800}, color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    background = page.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    rgb = tuple(bytes.fromhex(THEMES[scheme].background[1:]))
    assert background == f"rgb({', '.join(map(str, rgb))})"
    assert _coloured(page, "#map", "pop") > 20
    cut = page.locator("button, select, label, input").evaluate_all(
        "(all, width) => all.filter((each) => each.getBoundingClientRect().right > width + 1"
        " && !each.closest('.table')).map((each) => each.outerHTML)",
        width,
    )
    assert cut == []
