"""Tables as CSV, read back by csv whatever names there are; tables on terminals."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

from popsteer.lab.common.layout import add_numbers, blank_table, csv_text, fits

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
