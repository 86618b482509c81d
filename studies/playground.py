"""Measure in headless Chromium how long the playground drives: python -m studies.playground [PAGE].

A lap of three controllers, anew after each of twenty moves of a slider. PAGE is
out/playground/index.html by default, which `make playground` builds.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path

from tests.browser import Browser

DONE = "document.querySelector('#results[aria-busy=\"false\"]')"


def measure(file: Path) -> list[float]:
    """Give the times of the laps after each move of the slider [ms]."""
    with tempfile.TemporaryDirectory() as profile, Browser(Path(profile)) as page:
        page.look(1280, 720)
        page.open(file.resolve().as_uri())
        page.wait(DONE)
        page.run("document.getElementById('steer_lag').focus()")
        spent = []
        for _ in range(20):
            page.press("ArrowLeft")
            page.wait(DONE)
            spent.append(float(page.run("popsteer.spent")))
    return spent


if __name__ == "__main__":
    found = measure(Path(sys.argv[1] if len(sys.argv) > 1 else "out/playground/index.html"))
    print(
        f"a lap of three controllers: {statistics.median(found):.0f} ms (median of {len(found)}),"
        f" {min(found):.0f} to {max(found):.0f} ms"
    )
