"""Sensors, vehicles and paths that are not as told: what version 0.3.0 made of them, and this one.

The cases are those of tests/trust, whose car is apart from popsteer.sim.

    python -m studies.pages cases     # the table of docs/loop.md
"""

from __future__ import annotations

import json
import math
from pathlib import Path as File

from studies.layout import line
from tests.trust.cases import CASES

BEFORE = File(__file__).with_name("cases_0_3_0.json")
"""What version 0.3.0 came to, by the titles of the cases."""


def titles() -> list[str]:
    """A title for each case that says all."""
    found: list[str] = []
    for case in CASES:
        whole = case.title if not case.title.startswith("...") else f"{found[-1]}{case.title}"
        found.append(whole)
    return found


def case_lines() -> list[str]:
    """Each case: what is asked, what version 0.3.0 came to, and what this one does."""
    before = json.loads(BEFORE.read_text(encoding="utf-8"))
    lines = []
    for title, case in zip(titles(), CASES, strict=True):
        asked = f"at {'least' if case.least else 'most'} {case.bound:g}"
        was = math.inf if before[title] is None else before[title]
        lines.append(line(case.title, asked, case.cell(was), case.cell(case.compute())))
    return lines
