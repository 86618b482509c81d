from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.parity import plans
from tests.parity.compare import COMPARED

if TYPE_CHECKING:
    from collections.abc import Generator


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """A test compares every name that its `covers` marks claim, or fails."""
    COMPARED.clear()
    plans.forget()
    yield
    claimed = {name for mark in item.iter_markers("covers") for name in mark.args}
    unmet = claimed - COMPARED
    assert not unmet, f"claimed by a covers mark, but never compared: {sorted(unmet)}"
    # Plans are cut short under the strangest parameters alone, which no fixed case has.
    drawn = getattr(getattr(item, "obj", None), "is_hypothesis_test", False)
    assert drawn or not plans.CUT_SHORT
