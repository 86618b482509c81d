"""What the tests themselves rest on: their loops, and what hypothesis draws."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


def test_loop_gives_each_case_and_names_the_one_that_fails() -> None:
    seen = []

    @looped("low, high", [(0, 1), (2, 1)])
    @looped("side", "lr")
    def ordered(low: int, high: int, side: str) -> None:
        seen.append((low, high, side))
        assert low < high

    with pytest.raises(AssertionError, match=r"case {'low': 2, 'high': 1}"):
        ordered()
    assert seen == [(0, 1, "l"), (0, 1, "r"), (2, 1, "l")]

    @looped("n", [1])
    def raises_nothing(n: int) -> None:
        with pytest.raises(ValueError, match="n"):
            assert n

    with pytest.raises(AssertionError, match=r"case {'n': 1}"):
        raises_nothing()


@looped("doubled", [2, 4])
def test_loop_hands_fixtures_on(tmp_path_factory: pytest.TempPathFactory, doubled: int) -> None:
    assert tmp_path_factory.getbasetemp().is_dir()
    assert doubled % 2 == 0


def test_loop_without_cases_or_of_unknown_names_is_refused() -> None:
    def test(a: int) -> None: ...

    with pytest.raises(AssertionError, match="no case to test"):
        looped("a", [])
    with pytest.raises(AssertionError, match="takes no"):
        looped("b", [1])(test)


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
