"""The code of docs/carla.md that needs no simulator prints what the page says."""

from __future__ import annotations

import contextlib
import io
import re

import pytest

from tests.helpers import ROOT

PAGE = (ROOT / "docs" / "carla.md").read_text(encoding="utf-8")
BLOCKS = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_carla_page_code_prints_what_the_page_says() -> None:
    pytest.importorskip("carla", reason='the extra "carla" is not installed')
    blocks = BLOCKS.findall(PAGE)
    shown = [index for index, (kind, _) in enumerate(blocks) if kind == "text"]
    assert len(shown) == 1
    (_, code), (_, wanted) = blocks[shown[0] - 1 : shown[0] + 1]
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(code, "carla.md", "exec"), {})
    assert out.getvalue() == wanted


def test_carla_page_code_that_needs_a_simulator_is_python() -> None:
    code = [block for kind, block in BLOCKS.findall(PAGE) if kind == "python"]
    assert len(code) == 3
    for block in code:
        compile(block, "carla.md", "exec")
