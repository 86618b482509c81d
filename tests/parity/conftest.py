from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.parity import plans

if TYPE_CHECKING:
    from collections.abc import Generator


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """What is remembered of plans is of one test."""
    plans.forget()
    yield
    # Plans are cut short under the strangest parameters alone, which no fixed case has.
    drawn = getattr(getattr(item, "obj", None), "is_hypothesis_test", False)
    assert drawn or not plans.CUT_SHORT
