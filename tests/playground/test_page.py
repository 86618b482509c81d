"""The page, driven in a browser as a person drives it."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from popsteer.lab.common.theme import THEMES
from tests.cli.command import call
from tests.playground.built import BUILD

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from tests.browser import Browser
    from tests.playground.built import Built

    Opener = Callable[..., Browser]

DONE = '#results[aria-busy="false"]'


@pytest.fixture
def opened(built: Built, browser: Browser) -> Iterator[Opener]:
    """Opens the page; fails where it says anything on the console or asks for anything."""
    own = (built.page.as_uri(), "data:")

    def check() -> None:
        browser.run("0")  # what was said until now has come in with the answer
        assert browser.said == []
        assert [each for each in browser.requests if not each.startswith(own)] == []

    def open_(address: str = "", width: int = 1280, height: int = 900, **look: bool) -> Browser:
        check()
        browser.open("about:blank")  # from another address of the page it would not load anew
        browser.look(width, height, **look)
        browser.open(built.page.as_uri() + address)
        _wait(browser)
        return browser

    browser.open("about:blank")
    yield open_
    check()


def _at(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)})"


def _wait(page: Browser) -> None:
    """Wait until all controllers have driven, and their runs are drawn: in the next frame."""
    page.wait(f"{_at(DONE)}?.checkVisibility()")
    page.run("new Promise((drawn) => requestAnimationFrame(() => drawn()))")


def _read(page: Browser, selector: str) -> str:
    """The text as it is shown; empty where it is hidden."""
    text: str = page.run(f"(each => each.checkVisibility() ? each.innerText : '')({_at(selector)})")
    return text


def _address(page: Browser) -> str:
    address: str = page.run("location.href")
    return address


def _focus(page: Browser, selector: str) -> None:
    page.run(f"{_at(selector)}.focus()")


def _choose(page: Browser, track: str) -> None:
    page.run(
        f"""(select => {{
            select.value = {json.dumps(track)};
            for (const kind of ["input", "change"])
                select.dispatchEvent(new Event(kind, {{ bubbles: true }}));
        }})({_at("#track")})"""
    )
    _wait(page)


def _table(page: Browser) -> dict[str, list[str]]:
    rows = [row.split("\t") for row in _read(page, "#rows").splitlines() if row]
    return {row[0]: row[1:] for row in rows}


def _coloured(page: Browser, canvas: str, colour: str) -> int:
    """How many pixels of a canvas have just this colour."""
    found: int = page.run(
        f"""((canvas, colour) => {{
            const {{ width, height }} = canvas;
            const {{ data }} = canvas.getContext("2d").getImageData(0, 0, width, height);
            const value = popsteer.colour(colour);
            const wanted = [1, 3, 5].map((at) => parseInt(value.slice(at, at + 2), 16)).concat(255);
            let count = 0;
            for (let at = 0; at < data.length; at += 4)
                count += wanted.every((part, index) => data[at + index] === part);
            return count;
        }})({_at(canvas)}, {json.dumps(colour)})"""
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
    assert _address(page).endswith("index.html")
    assert _read(page, "#message") == ""


def test_page_begins_driving_close_up_with_a_sentence_of_what_is_seen(opened: Opener) -> None:
    page = opened(motion=True)
    page.wait(f"{_at('#play')}.textContent === 'Pause'")
    page.wait(f"{_at('#clock')}.textContent !== '0.0 s'")
    assert page.run(f"{_at('#follow')}.checked")
    said = _read(page, "#seen")
    assert said.startswith("The same car on the same track, after the first 5 s: Preview POP stays")
    assert re.search(r"within 0\.0\d+ m of the track; POP is up to 1\.\d\d m off it\.$", said)
    assert page.run("document.querySelectorAll('.bad').length") == 0


def test_page_shows_failures_in_red(opened: Opener) -> None:
    page = opened("#controllers=stanley,preview-pop&dead_time=0.5&steer_lag=0.5&speed=25")
    table = _table(page)
    failed = [
        name for name, row in table.items() if not re.fullmatch(r"finished, [\d.]+ s", row[-1])
    ]
    assert failed
    red = page.run(
        "[...document.querySelectorAll('tr.bad th')].map((each) => each.innerText.trim())"
    )
    assert red == failed
    colour = page.run(f"getComputedStyle({_at('tr.bad td:last-child')}).color")
    assert colour == "rgb(180, 35, 24)"
    assert page.run("document.querySelectorAll('#seen .bad').length") == len(failed)


def test_page_slider_drives_anew(opened: Opener) -> None:
    page = opened()
    before = _table(page)
    _focus(page, "#max_steer_rate")
    for _ in range(5):
        page.press("ArrowLeft")
        _wait(page)
        assert _table(page) != before
        before = _table(page)
    assert page.run(f"{_at('#max_steer_rate-field')}.value") == "0.15"
    assert _address(page).endswith("#max_steer_rate=0.15")


def test_page_slider_dragged_fast_ends_where_it_was_left(opened: Opener) -> None:
    page = opened("#track=slalom")
    page.run(
        f"""(async (range) => {{
            for (let speed = 4; speed <= 12; speed += 0.5) {{
                range.value = speed;
                range.dispatchEvent(new Event("input"));
                await new Promise((next) => setTimeout(next, 3));
            }}
        }})({_at("#speed")})"""
    )
    _wait(page)
    assert _address(page).endswith("#track=slalom&speed=12")
    dragged = _table(page)
    assert dragged == _table(opened("#track=slalom&speed=12"))


def test_page_preview_with_limits_beats_it_without(opened: Opener) -> None:
    page = opened(
        "#track=slalom&controllers=preview-pop,preview-pop-unlimited&max_steer_rate=0.2&speed=8"
    )
    table = _table(page)
    within, without = table["Preview POP"], table["Preview POP, limits unknown"]
    assert float(within[0]) < 0.01
    assert float(without[0]) > 0.1
    assert _coloured(page, "#map", "preview-pop-unlimited") > 50
    # Fast wheels: there is no limit to be known.
    page.fill("#max_steer_rate-field", "20")
    _wait(page)
    table = _table(page)
    assert float(table["Preview POP, limits unknown"][0]) < 0.01


# Small enough for all loops to be stable: in another no digit lasts.
@pytest.mark.parametrize("car", ["", "&known=0&steer_lag=0.05&dead_time=0.05"])
def test_page_command_drives_the_same(
    opened: Opener, capsys: pytest.CaptureFixture[str], car: str
) -> None:
    page = opened(f"#track=slalom&controllers=pop,pure-pursuit,stanley&speed=8{car}")
    command = _read(page, "#command")
    assert command.startswith("popsteer compare --controllers pop,pure-pursuit,stanley")
    outcome = call(capsys, *shlex.split(command.replace("\\\n", " "))[1:])
    assert outcome.status == 0
    for row in _table(page).values():
        assert row[0] in outcome.out, outcome.out
    page.click("#slow_in_bends")
    _wait(page)
    assert page.run(f"{_at('#slow_in_bends')}.checked")
    assert _read(page, "#command") == ""


def test_page_every_track_is_driven(opened: Opener) -> None:
    page = opened("#controllers=preview-pop&speed=6")
    tracks = page.run(f"[...{_at('#track')}.options].map((each) => each.value)")
    assert len(tracks) == 8
    for track in tracks:
        _choose(page, track)
        assert float(_table(page)["Preview POP"][0]) < 0.05, track
    assert "closed lap" not in _read(page, "#track-title")
    _choose(page, "circle")
    assert "closed lap" in _read(page, "#track-title")


def test_page_track_drawn_with_the_pointer(opened: Opener, tmp_path: Path) -> None:
    page = opened("#controllers=preview-pop,pure-pursuit&speed=5")
    page.click(page.named("button", "Draw a track"))
    box = page.run(f"{_at('#map')}.getBoundingClientRect().toJSON()")
    left, top = box["x"] + 100, box["y"] + 120
    corners = [(0, 0), (500, 0), (560, 120), (380, 240), (200, 180), (0, 300), (0, 10)]
    page.drag([(left + x, top + y) for x, y in corners], steps=12)
    _wait(page)
    assert page.run(f"{_at('#track')}.value") == "drawn"
    assert _read(page, "#track-title").endswith("a closed lap")
    assert all(float(row[0]) < 1.0 for row in _table(page).values())
    page.ask("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    page.click(page.named("link", "Save the waypoints"))
    saved = tmp_path / "drawn.csv"  # it has another name until it is whole
    end = time.monotonic() + 60.0
    while not saved.exists():
        assert time.monotonic() < end, [*tmp_path.iterdir()]
        time.sleep(0.02)
    lines = saved.read_text(encoding="utf-8").splitlines()
    count = int(_read(page, "#track-title").split()[0])
    assert len(lines) == count + 1
    assert "--waypoints drawn.csv --closed" in _read(page, "#command")


def test_page_track_drawn_with_the_keys(opened: Opener) -> None:
    page = opened("#controllers=preview-pop&speed=5")
    _focus(page, page.named("button", "Draw a track"))
    page.press("Enter")
    for key in ("ArrowRight",) * 5 + ("ArrowUp",) * 4 + ("ArrowRight",) * 5 + ("Enter",):
        page.press(key)
    _wait(page)
    assert page.run(f"{_at('#track')}.value") == "drawn"
    assert _read(page, "#track-title").endswith("open")
    page.click(page.named("button", "Draw a track"))
    page.press("Escape")
    assert page.run(f"{_at('#track')}.value") == "drawn"
    assert _read(page, page.named("button", "Draw a track"))


def test_page_bad_input_is_named_and_the_page_works_on(opened: Opener) -> None:
    page = opened("#wheelbase=nonsense&track=monaco")
    assert _read(page, "#message") == "wheelbase must be in [0.001, 1000.0], got NaN"
    assert _table(page) == {}
    page.fill("#wheelbase-field", "0.0000001")
    _wait(page)
    assert "wheelbase must be in" in _read(page, "#message")
    assert page.run(f"{_at('#wheelbase-field')}.getAttribute('aria-invalid')") == "true"
    page.fill("#wheelbase-field", "2.7")
    _wait(page)
    assert _read(page, "#message") == ""
    assert len(_table(page)) == 3
    # A track of one point.
    page.click(page.named("button", "Draw a track"))
    page.click("#map")
    assert _read(page, "#message").startswith(
        "a track is at least 20 m long, the line drawn is 0.0 m"
    )
    assert page.run(f"{_at('#track')}.value") == "racetrack"
    _focus(page, "#speed")
    page.press("ArrowRight")
    _wait(page)
    assert _read(page, "#message") == ""
    assert len(_table(page)) == 3
    for box in ("pop", "preview-pop", "pure-pursuit"):
        page.click(f"#{box}")
        assert not page.run(f"{_at(f'#{box}')}.checked")
    _wait(page)
    assert _table(page) == {}


def test_page_plays_and_is_worked_by_keys(opened: Opener) -> None:
    page = opened("#track=straight")
    _focus(page, page.named("button", "Play"))
    page.press("Enter")
    page.wait(f"{_at('#clock')}.textContent !== '0.0 s'")
    _focus(page, page.named("button", "Pause"))
    page.press(" ")
    _focus(page, "#time")
    page.press("Home")
    page.wait(f"{_at('#clock')}.textContent === '0.0 s'")
    page.run("document.activeElement.blur()")
    reached = set()
    for _ in range(45):
        page.press("Tab")
        reached.add(page.run("document.activeElement.id"))
    everything = page.run(
        "[...document.querySelectorAll('button, select, input, canvas[tabindex]')]"
        ".map((each) => each.id)"
    )
    assert set(everything) <= reached


@pytest.mark.parametrize("width", [360, 1280, 2560])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_fits_every_screen(opened: Opener, width: int, scheme: str) -> None:
    page = opened("#track=slalom", width, 800, dark=scheme == "dark")
    assert page.run("document.documentElement.scrollWidth") <= width
    background = page.run("getComputedStyle(document.documentElement).backgroundColor")
    rgb = tuple(bytes.fromhex(THEMES[scheme].background[1:]))
    assert background == f"rgb({', '.join(map(str, rgb))})"
    assert _coloured(page, "#map", "pop") > 20
    cut = page.run(
        f"""[...document.querySelectorAll("button, select, label, input")].filter((each) =>
            each.getBoundingClientRect().right > {width} + 1 && !each.closest(".table")
        ).map((each) => each.outerHTML)"""
    )
    assert cut == []
