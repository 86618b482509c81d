"""The table of cases: the page prints what is driven, and what misses its bound is known."""

from __future__ import annotations

import json

from studies.cases import BEFORE, case_lines, titles
from studies.layout import table
from tests.trust.cases import CASES

MISSED = {
    "yaw noise, 20 % lost, jitter: error by that of `adapt=None`",
}


def test_page_table_of_cases_is_what_is_driven() -> None:
    lines = case_lines()
    assert table("loop.md", "cases") == lines
    missed = {
        title for title, row in zip(titles(), lines, strict=True) if "**" in row.split("|")[4]
    }
    assert missed == MISSED


def test_most_cases_are_missed_by_version_0_3_0() -> None:
    before = json.loads(BEFORE.read_text(encoding="utf-8"))
    assert list(before) == titles()
    values = zip(CASES, before.values(), strict=True)
    assert sum(value is None or not case.met(value) for case, value in values) > 30
