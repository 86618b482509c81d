"""Measures the latency of a control step, called from Python, and writes latency.json.

    python -m benches.latency out/bench

The whole step as the paper counts it, on the states of a recorded drive, beside the other
controllers, the plain reference, an empty method of the same binding and signature, and the
yardsticks from outside. `studies.bench` lays the file out as tables.
"""

from __future__ import annotations

import sys
from pathlib import Path

from benches.latency import yardsticks
from benches.latency.measure import measure
from benches.latency.report import to_json
from benches.latency.states import at_hand
from popsteer.files import write_text_atomic


def main(folder: Path) -> None:
    drive = at_hand()
    report = measure(drive, outside=yardsticks.at_hand(drive), progress=_say)
    write_text_atomic(folder / "latency.json", to_json(report))
    print(f"\nwrote {folder / 'latency.json'}")


def _say(part: float) -> None:
    print(f"\r{part:4.0%}", end="", file=sys.stderr)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
