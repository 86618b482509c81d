"""Measure in headless Chromium how long the playground drives: python benches/playground.py [PAGE].

A lap of three controllers, anew after each of twenty moves of a slider. PAGE is
out/playground/index.html by default, which `make playground` builds.
"""

from __future__ import annotations

import shutil
import statistics
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

DONE = '#results[aria-busy="false"]'


def measure(file: Path) -> list[float]:
    """Give the times of the laps after each move of the slider [ms]."""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page()
        page.goto(file.resolve().as_uri())
        spent = []
        page.locator(DONE).wait_for()
        page.locator("#steer_lag").focus()
        for _ in range(20):
            page.keyboard.press("ArrowLeft")
            page.locator(DONE).wait_for()
            spent.append(float(page.evaluate("popsteer.spent")))
        browser.close()
    return spent


if __name__ == "__main__":
    found = measure(Path(sys.argv[1] if len(sys.argv) > 1 else "out/playground/index.html"))
    print(
        f"a lap of three controllers: {statistics.median(found):.0f} ms (median of {len(found)}),"
        f" {min(found):.0f} to {max(found):.0f} ms"
    )
