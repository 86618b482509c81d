"""A page of HTML as a test reads it."""

from __future__ import annotations

import base64
import json
import zlib
from html.parser import HTMLParser
from typing import TYPE_CHECKING, Any

import numpy as np

from popsteer.lab.report.scene import HOLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

VOID = {"meta", "link", "input", "br", "hr", "img"}


class Html(HTMLParser):
    """What is on a page: its elements, the text of each, and what it would load."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: dict[str, list[str]] = {}
        self.loads: list[str] = []
        self._open: list[str] = []
        self._begun: list[list[str]] = []
        self.feed(text)
        self.close()
        assert not self._open, f"never closed: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.elements.append((tag, found))
        if tag != "a":
            self.loads += [
                found[name] for name in ("src", "href", "data", "srcset") if name in found
            ]
        if tag not in VOID:
            self._open.append(tag)
            self._begun.append([])

    def handle_endtag(self, tag: str) -> None:
        assert self._open, f"</{tag}> closes nothing"
        assert self._open[-1] == tag, f"</{tag}> closes <{self._open[-1]}>"
        self._open.pop()
        text = "".join(self._begun.pop())
        self.texts.setdefault(tag, []).append(text)
        if self._begun:
            self._begun[-1].append(text)

    def handle_data(self, data: str) -> None:
        if self._begun:
            self._begun[-1].append(data)

    def ids(self) -> list[str]:
        return [found["id"] for _, found in self.elements if "id" in found]

    def document(self) -> dict[str, Any]:
        """The data that the page carries."""
        found: dict[str, Any] = next(
            json.loads(text) for text in self.texts["script"] if text.startswith('{"scenes"')
        )
        return found


def columns(document: dict[str, Any], actor: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """The columns of an actor, read as the page reads them."""
    data = zlib.decompress(base64.b64decode(document["numbers"]))
    planes = np.frombuffer(data, dtype=np.uint8).reshape(4, -1)
    steps = planes.T.copy().view("<i4").ravel()
    found = {}
    for name, (start, count, scale, offset) in actor["columns"].items():
        sums = np.cumsum(steps[start : start + count], dtype=np.int32)
        values = offset + scale * sums.astype(np.float64)
        found[name] = np.where(sums == HOLE, np.nan, values)
    return found
