"""What the browser's tests ask of any report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from tests.browser import Browser

SIZES = [(360, 740), (1280, 900), (2560, 1400)]
READY = "document.documentElement.dataset.ready"


def cursor(page: Browser) -> float:
    """Where the cursor is."""
    return float(page.run("Number(document.getElementById('cursor').value)"))


def put(page: Browser, value: float) -> None:
    """Move the cursor."""
    page.run(
        "(() => { const s = document.getElementById('cursor');"
        f" s.value = {value}; s.dispatchEvent(new Event('input')); }})()"
    )


def cars(page: Browser) -> dict[str, tuple[float, float]]:
    """Where the cars are on the map [m]."""
    found: dict[str, Any] = page.run(
        """(() => {
          const {xaxis, yaxis} = document.getElementById('map')._fullLayout;
          const cars = [...document.querySelectorAll('#map [data-actor]')];
          return Object.fromEntries(cars.map((car) => {
            const m = car.transform.baseVal.consolidate().matrix;
            return [car.dataset.actor, [xaxis.p2l(m.e), yaxis.p2l(m.f)]];
          }));
        })()"""
    )
    return {name: (float(x), float(y)) for name, (x, y) in found.items()}


def box_of(page: Browser, selector: str) -> dict[str, float]:
    """Where an element lies in the window [px]."""
    found: dict[str, float] = page.run(
        f"(({{x, y, width, height}}) => ({{x, y, width, height}}))"
        f"(document.querySelector('{selector}').getBoundingClientRect())"
    )
    return found


def fits(browser: Browser, file: Path, size: tuple[int, int], *, dark: bool) -> bytes:
    """Open a page and hold that it fits its window; give the picture."""
    width, height = size
    browser.look(width, height, dark=dark, mobile=width < 500)
    browser.open(file.as_uri())
    browser.wait(READY)
    plots = "[...document.querySelectorAll('#gallery .plot')]"
    browser.wait(f"{plots}.every((plot) => plot.querySelector('.main-svg'))")
    assert browser.errors == []
    assert browser.requests == [file.as_uri()]
    assert browser.run("document.documentElement.scrollWidth") == width
    # What is not in a box that scrolls by itself lies within the window.
    outside = browser.run(
        f"""[...document.querySelectorAll('body *')].filter((each) => {{
          const box = each.getBoundingClientRect();
          return box.width && box.right > {width} + 1
            && !each.closest('.scroll, pre, .hidden, svg');
        }}).map((each) => each.outerHTML.slice(0, 80))"""
    )
    assert outside == []
    # The player lies over nothing.
    player, *others = (box_of(browser, each) for each in (".player", "#map", "#panels", "#readout"))
    for box in others:
        apart = [
            box[at] + box[size] <= player[at] + 1.0 or player[at] + player[size] <= box[at] + 1.0
            for at, size in (("x", "width"), ("y", "height"))
        ]
        assert any(apart)
    background = browser.run("getComputedStyle(document.body).backgroundColor")
    assert background == ("rgb(13, 17, 23)" if dark else "rgb(255, 255, 255)")
    picture = browser.screenshot()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 10_000  # a blank one is smaller
    return picture
