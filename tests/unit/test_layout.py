"""Tables as CSV, read back by csv whatever names there are; tables on terminals."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

from rich.text import Text

from popsteer.lab.common.layout import add_numbers, blank_table, csv_text, fits, number

if TYPE_CHECKING:
    import pytest


def test_csv_with_commas_quotes_and_line_breaks_is_read_back() -> None:
    names = ["law", 'a "b", c', "d\ne"]
    rows = [["mine.py:A,B", '"', "1.5"], ["x\ny", "", "2"]]
    text = csv_text(["two\nlines, SI"], names, rows)
    head, _, rest = text.partition("\n")
    assert head == "# two lines, SI"
    assert list(csv.reader(rest.splitlines(keepends=True))) == [names, *rows]


def test_table_fits_as_many_characters_as_it_has_on_any_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    table = blank_table(1)
    add_numbers(table, *["ten digits"] * 10)
    monkeypatch.setenv("FORCE_COLOR", "1")  # as on a terminal
    monkeypatch.delenv("LINES", raising=False)
    for kind in ("xterm", "dumb"):
        monkeypatch.setenv("TERM", kind)
        assert [fits(table, width) for width in (100, 120)] == [False, True], kind


def test_no_number_of_a_table_is_a_negative_zero() -> None:
    for value, form in ((-0.0, "g"), (-4e-6, ".5f"), (-0.4, ".0f")):
        said = format(value, form)
        assert said.startswith("-0")
        table = blank_table()
        add_numbers(table, "plain", "styled", "in brackets", "of two")
        table.add_row(said, Text(said, "bold"), f"({said})", f"{said} to -0.5")
        cells = [str(next(iter(column.cells))) for column in table.columns]
        assert cells == [said[1:], said[1:], f"({said[1:]})", f"{said[1:]} to -0.5"]
        assert number(value, form) == said[1:]
    table = blank_table()
    add_numbers(table, *"abcd")
    kept = "-0.00050", "-0.5", "run-0", "-0x"
    table.add_row(*kept)
    assert tuple(next(iter(column.cells)) for column in table.columns) == kept
