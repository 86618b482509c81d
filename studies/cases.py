"""Sensors, vehicles and paths that are not as told: what version 0.3.0 made of them, and this one.

The cases are those of tests/trust, whose car is apart from popsteer.sim.

    python -m studies.cases                   # each case, by the popsteer that is installed
    python -m studies.cases --record FILE     # ... written to a file, as studies/cases_0_3_0.json
    python -m studies.pages cases             # the table of docs/loop.md
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path as File

from studies.layout import line
from tests.trust.cases import CASES

BEFORE = File(__file__).with_name("cases_0_3_0.json")
"""What version 0.3.0 came to by this program, installed beside the checkout."""


def compute() -> dict[str, float]:
    """The number of each case by its title, after that of the case before for `...`."""
    return dict(zip(titles(), (each.compute() for each in CASES), strict=True))


def titles() -> list[str]:
    """A title for each case that says all."""
    found: list[str] = []
    for case in CASES:
        whole = case.title if not case.title.startswith("...") else f"{found[-1]}{case.title}"
        found.append(whole)
    return found


def case_lines() -> list[str]:
    """Each case: what is asked, what version 0.3.0 came to, and what this one does."""
    before, now = json.loads(BEFORE.read_text(encoding="utf-8")), compute()
    lines = []
    for title, case in zip(titles(), CASES, strict=True):
        asked = f"at {'least' if case.least else 'most'} {case.bound:g}"
        was = math.inf if before[title] is None else before[title]
        lines.append(line(case.title, asked, case.cell(was), case.cell(now[title])))
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--record", type=File, help="write the numbers to this file")
    file = parser.parse_args().record
    found = compute()
    for (title, number), case in zip(found.items(), CASES, strict=True):
        print(f"{title}: {case.cell(number)}")
    if file:
        shown = {
            title: number if math.isfinite(number) else None for title, number in found.items()
        }
        file.write_text(json.dumps(shown, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
