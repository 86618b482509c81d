"""The tables of docs/edges.md."""

from __future__ import annotations

from tests.helpers import ROOT

PAGE = (ROOT / "docs" / "edges.md").read_text(encoding="utf-8")


def table(name: str) -> list[str]:
    """Lines of a table, without its two lines of heads."""
    return PAGE.partition(f"<!-- table: {name} -->\n")[2].partition("\n\n")[0].splitlines()[2:]


def line(*cells: str) -> str:
    """Set out cells as a line of a table."""
    return f"| {' | '.join(cells)} |"
