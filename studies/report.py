"""Takes the pictures of docs/report.md, and says how large the page is and how fast it opens."""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from popsteer import sim
from popsteer.files import write_bytes_atomic
from popsteer.lab import compare, report
from studies.layout import DOCS, track
from tests.browser import Browser

CONTROLLERS = ("pid", "pure-pursuit", "stanley", "pop", "preview-pop")
COMMAND = f"popsteer compare --controllers {','.join(CONTROLLERS)} --report report.html"
# Before a bend: the cars are apart.
DISTANCE = 470.0
SCENE = f"""(async () => {{
  const view = document.getElementById("view");
  view.value = 3;
  view.dispatchEvent(new Event("change"));
  document.querySelector("input[value=distance]").click();
  const slider = document.getElementById("cursor");
  for (let k = 0; k < 20; k++) {{
    await new Promise((done) => setTimeout(done, 100));
    slider.value = {DISTANCE};
    slider.dispatchEvent(new Event("input"));
  }}
  document.getElementById("drive").scrollIntoView({{behavior: "instant"}});
}})()"""


def page() -> bytes:
    """The page of the command that docs/report.md shows."""
    params = compare.parameters(CONTROLLERS, "reproduction")
    found = replace(compare.run(track("racetrack"), params), track="racetrack")
    found = compare.time_steps(found, params)
    plants = {found.plant: sim.CarlaIdentified()}
    return report.of_comparison(found, origin=report.Origin(COMMAND, params, "auto", plants))


def main() -> None:
    """Measure, and write the pictures."""
    data = Path(sys.argv[1]).read_bytes() if len(sys.argv) > 1 else page()
    print(f"{len(data)} bytes")
    with tempfile.TemporaryDirectory() as folder, Browser(Path(folder) / "profile") as browser:
        file = Path(folder) / "report.html"
        file.write_bytes(data)
        # The processor's time besides: the wall clock counts what else the machine does.
        browser.ask("Performance.enable", timeDomain="threadTicks")
        for turn in ("first", "again"):
            browser.look(1280, 860)
            browser.open("about:blank")
            browser.open(file.as_uri())
            browser.wait("document.documentElement.dataset.ready")
            ready = browser.run("document.documentElement.dataset.ready")
            paint = browser.run(
                "performance.getEntriesByName('first-contentful-paint')[0]?.startTime"
            )
            metrics = browser.ask("Performance.getMetrics")["metrics"]
            busy = next(each["value"] for each in metrics if each["name"] == "TaskDuration")
            print(
                f"{turn}: text after {paint:.0f} ms, cars and plots after {ready} ms,"
                f" of which the processor worked {1e3 * busy:.0f} ms"
            )
        if len(sys.argv) > 1:
            return
        for dark in (False, True):
            browser.look(1280, 860, dark=dark)
            browser.run(SCENE)
            time.sleep(1.0)
            name = f"report{'-dark' if dark else ''}.png"
            write_bytes_atomic(DOCS / "figures" / name, browser.screenshot())
            print(f"written: docs/figures/{name}")


if __name__ == "__main__":
    main()
