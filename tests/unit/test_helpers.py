"""What the tests themselves rest on."""

from __future__ import annotations

import pytest

from tests.helpers import looped


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
