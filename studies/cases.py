"""Sensors, vehicles and paths that are not as told: what is asked, and what comes out.

The cases are those of tests/trust, whose car is apart from popsteer.sim.

    python -m studies.pages cases     # the table of docs/loop.md
"""

from __future__ import annotations

from studies.layout import line
from tests.trust.cases import CASES


def case_lines() -> list[str]:
    """Each case: what is asked, and what comes out."""
    asked = ("least" if case.least else "most" for case in CASES)
    return [
        line(case.title, f"at {end} {case.bound:g}", case.cell(case.compute()))
        for end, case in zip(asked, CASES, strict=True)
    ]
