"""From tables and texts to HTML, every character of them escaped."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from popsteer.lab.common.layout import BAD

if TYPE_CHECKING:
    from rich.table import Table


def json_for_script(document: object) -> str:
    """Write a document as JSON without signs that could end the script element it stands in."""
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def table(shown: Table, label: str) -> str:
    """Set out a table of the terminal as one of HTML; bold cells stay bold.

    `label` says what it shows, for readers that see no picture of it.
    """
    heads = [str(column.header) for column in shown.columns]
    columns = [[_cell(cell) for cell in column.cells] for column in shown.columns]
    right = [column.justify == "right" for column in shown.columns]
    rows = zip(*columns, strict=True)
    return html_table(str(shown.title or label), heads, rows, right, visible=bool(shown.title))


def plain_table(
    label: str, heads: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1
) -> str:
    """Set out a table of plain cells, with the label above it, and `left` columns of names."""
    right = [place >= left for place in range(len(heads))]
    return html_table(label, heads, (map(escape, row) for row in rows), right)


def html_table(
    label: str,
    heads: Sequence[str],
    rows: Iterable[Iterable[str]],
    right: Sequence[bool],
    *,
    visible: bool = True,
) -> str:
    """Set out cells of HTML as a table, in a box that scrolls where it is too wide."""
    shown = "" if visible else ' class="hidden"'
    lines = [
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}">',
        f"<table><caption{shown}>{escape(label)}</caption>",
        "<thead><tr>",
    ]
    aligned = [' class="number"' if number else "" for number in right]
    for head, kind in zip(heads, aligned, strict=True):
        # A head that is broken into lines for the terminal is one line again.
        whole = " ".join(head.replace("-\n", "").split())
        lines.append(f'<th scope="col"{kind}>{escape(whole)}</th>')
    lines.append("</tr></thead><tbody>")
    for row in rows:
        lines.append("<tr>")
        for place, (cell, kind) in enumerate(zip(row, aligned, strict=False)):
            tag, scope = ("th", ' scope="row"') if place == 0 and not kind else ("td", "")
            lines.append(f"<{tag}{scope}{kind}>{cell}</{tag}>")
        lines.append("</tr>")
    lines.append("</tbody></table></div>")
    return "".join(lines)


def _cell(cell: Any) -> str:
    text, style = escape(str(cell)), str(getattr(cell, "style", ""))
    if "bold" not in style:
        return text
    return f'<strong class="bad">{text}</strong>' if style == BAD else f"<strong>{text}</strong>"


def paragraphs(lines: Iterable[str]) -> str:
    """Set out sentences, one small paragraph each."""
    shown = "".join(f'<p class="note">{escape(line)}</p>' for line in lines)
    return f'<div class="notes">{shown}</div>'


def badge(head: str, details: Iterable[str], *, good: bool) -> str:
    """Set out what came out, the first line of a page: in green if it is good, else in red."""
    said = escape("; ".join(details))
    rest = f" <span>{said}</span>" if said else ""
    kind = "good" if good else "bad"
    return f'<p class="verdict {kind}"><strong>{escape(head)}</strong>{rest}</p>'


def block(title: str, text: str, *, is_open: bool = False, wraps: bool = False) -> str:
    """Set out a file or a command, to open and copy; with `wraps`, lines break between words."""
    shown = escape(text)
    if wraps:
        shown = re.sub(r"\S*-\S*", r'<span class="word">\g<0></span>', shown)
    return (
        f"<details{' open' if is_open else ''}><summary>{escape(title)}</summary>"
        f'<div class="code"><button type="button" class="copy">Copy</button>'
        f'<pre tabindex="0"><code>{shown}</code></pre></div></details>'
    )
