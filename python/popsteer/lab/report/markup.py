"""From tables and texts to HTML, every character of them escaped."""

from __future__ import annotations

import html
import json
import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rich.table import Table


def escape(text: str) -> str:
    """Escape a text for HTML: for between tags and for attributes in quotes."""
    return html.escape(text, quote=True)


def json_for_script(document: object) -> str:
    r"""Write a document as JSON that may stand in a script element; its numbers have to be finite.

    It is without ``<``, ``>`` and ``&``, so that nothing in it ends the element.
    """
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def table(shown: Table, label: str) -> str:
    """Set out a table of the terminal as one of HTML, in a box that scrolls where it is too wide.

    Its cells are text; bold ones stay bold. `label` says what it shows, for readers that see no
    picture of it.
    """
    heads = [_text(column.header)[0] for column in shown.columns]
    columns = [[_text(cell) for cell in column.cells] for column in shown.columns]
    right = [column.justify == "right" for column in shown.columns]
    title = str(shown.title) if shown.title else label
    rows = list(zip(*columns, strict=True))
    return _table(title, heads, rows, right, visible=bool(shown.title))


def plain_table(
    label: str, heads: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1
) -> str:
    """Set out a table of plain cells, with the label above it.

    `left` is how many columns hold names rather than numbers.
    """
    cells = [[(cell, False) for cell in row] for row in rows]
    right = [place >= left for place in range(len(heads))]
    return _table(label, heads, cells, right, visible=True)


def _table(
    label: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[tuple[str, bool]]],
    right: Sequence[bool],
    *,
    visible: bool,
) -> str:
    shown = "" if visible else ' class="hidden"'
    lines = [
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}">',
        f"<table><caption{shown}>{escape(label)}</caption>",
        "<thead><tr>",
    ]
    for head, number in zip(heads, right, strict=True):
        # A head that is broken into lines for the terminal is one line again.
        whole = " ".join(head.replace("-\n", "").split())
        lines.append(f'<th scope="col"{_aligned(number=number)}>{escape(whole)}</th>')
    lines.append("</tr></thead><tbody>")
    for row in rows:
        lines.append("<tr>")
        for place, ((text, bold), number) in enumerate(zip(row, right, strict=True)):
            inner = f"<strong>{escape(text)}</strong>" if bold else escape(text)
            tag, scope = ("th", ' scope="row"') if place == 0 and not number else ("td", "")
            lines.append(f"<{tag}{scope}{_aligned(number=number)}>{inner}</{tag}>")
        lines.append("</tr>")
    lines.append("</tbody></table></div>")
    return "".join(lines)


def _aligned(*, number: bool) -> str:
    return ' class="number"' if number else ""


def _text(cell: Any) -> tuple[str, bool]:  # noqa: ANN401 - rich takes anything that it can show
    """Give what stands in a cell, and whether it is bold."""
    return str(cell), "bold" in str(getattr(cell, "style", ""))


def paragraphs(lines: Iterable[str]) -> str:
    """Set out sentences, one small paragraph each."""
    shown = "".join(f'<p class="note">{escape(line)}</p>' for line in lines)
    return f'<div class="notes">{shown}</div>'


def block(title: str, text: str, *, is_open: bool = False, wraps: bool = False) -> str:
    """Set out a file or a command: a line that opens it, and a button that copies it.

    With `wraps`, its lines break in a narrow window: between words, not at their hyphens.
    """
    shown = escape(text)
    if wraps:
        shown = re.sub(r"\S*-\S*", r'<span class="word">\g<0></span>', shown)
    return (
        f"<details{' open' if is_open else ''}><summary>{escape(title)}</summary>"
        f'<div class="code"><button type="button" class="copy">Copy</button>'
        f'<pre tabindex="0"><code>{shown}</code></pre></div></details>'
    )
