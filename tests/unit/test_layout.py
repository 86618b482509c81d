"""Tables as CSV: read back by csv, whatever names there are."""

from __future__ import annotations

import csv

from popsteer.lab.common.layout import csv_text


def test_csv_with_commas_quotes_and_line_breaks_is_read_back() -> None:
    names = ["law", 'a "b", c', "d\ne"]
    rows = [["mine.py:A,B", '"', "1.5"], ["x\ny", "", "2"]]
    text = csv_text(["two\nlines, SI"], names, rows)
    head, _, rest = text.partition("\n")
    assert head == "# two lines, SI"
    assert list(csv.reader(rest.splitlines(keepends=True))) == [names, *rows]
