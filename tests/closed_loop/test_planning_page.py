"""The code of docs/planning.md prints what the page says."""

from __future__ import annotations

from pathlib import Path

from tests.closed_loop.test_vehicle_page import BLOCK, printed

PAGE = Path(__file__).parents[2] / "docs" / "planning.md"


def test_planning_page_code_prints_what_the_page_says() -> None:
    names: dict[str, object] = {}
    blocks = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert [kind for kind, _ in blocks] == ["python", "text"] * 3
    for (_, code), (_, shown) in zip(blocks[::2], blocks[1::2], strict=True):
        assert printed(code, names) == shown
