"""Tables on pages: a comment with the name, two lines of heads, the rows, an empty line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.helpers import ROOT

if TYPE_CHECKING:
    from collections.abc import Sequence

DOCS = ROOT / "docs"


def table(page: str, name: str) -> list[str]:
    """Rows of a table of a page, without its two lines of heads."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return text.partition(f"<!-- table: {name} -->\n")[2].partition("\n\n")[0].splitlines()[2:]


def with_table(text: str, name: str, rows: Sequence[str]) -> str:
    """Put rows in the place of those of a table."""
    before, mark, rest = text.partition(f"<!-- table: {name} -->\n")
    if not mark:
        raise SystemExit(f"there is no table {name}")
    old, gap, after = rest.partition("\n\n")
    heads = old.splitlines()[:2]
    return before + mark + "\n".join([*heads, *rows]) + gap + after


def line(*cells: str) -> str:
    """Set out cells as a line of a table."""
    return f"| {' | '.join(cells)} |"
