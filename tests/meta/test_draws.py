"""What hypothesis draws hangs on the test alone, not on where popsteer is installed."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

CONSTANTS = frozenset(range(7_919_000, 7_919_000 + 100))


@pytest.fixture
def _module_at_hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A module from outside of site-packages, as popsteer's are in a checkout on PYTHONPATH."""
    (tmp_path / "at_hand.py").write_text(f"NUMBERS = {sorted(CONSTANTS)}\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.import_module("at_hand")
    yield
    del sys.modules["at_hand"]


@pytest.mark.usefixtures("_module_at_hand")
def test_draws_hold_no_constants_of_modules_outside_of_site_packages() -> None:
    drawn: set[int] = set()

    @settings(max_examples=300, database=None, derandomize=True)
    @given(numbers=st.lists(st.integers(), min_size=20, max_size=20))
    def draw(numbers: list[int]) -> None:
        drawn.update(numbers)

    draw()
    assert len(drawn) > 100
    assert drawn.isdisjoint(CONSTANTS)
