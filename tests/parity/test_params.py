from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import popsteer
from tests.parity.checks import check_copies, check_resolved
from tests.parity.compare import make
from tests.parity.laws import ALL, LATERAL, Law
from tests.parity.strategies import VEHICLES, Shape

# One test a law with this body; the marks name what each of them compares.
_LAWS = [
    pytest.param(
        law,
        id=law.name,
        marks=pytest.mark.covers(
            law.params_name,
            f"{law.params_name}.as_dict",
            f"{law.params_name}.replace",
            *([f"{law.params_name}.resolved"] if law in LATERAL else []),
            *(f"{law.params_name}.{name}" for name in (*law.ranges, *law.counts, *law.flags)),
            *([f"{law.state_name}.as_dict"] if hasattr(popsteer, law.state_name) else []),
        ),
    )
    for law in ALL
]


@pytest.mark.parametrize("law", _LAWS)
@given(data=st.data())
def test_params_matches_reference_random(law: Law, data: st.DataObject) -> None:
    params = data.draw(law.params())
    check_copies(law, params, data.draw(law.params()))
    if law in LATERAL:
        check_resolved(law, params, data.draw(VEHICLES))


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
@pytest.mark.parametrize("waypoint", [-1, -(10**6), 2**53])
def test_state_naming_no_waypoint_matches_reference(law: Law, waypoint: int) -> None:
    pair = make(law.name, make("Path", Shape().build().xy))
    assert not pair.set_state(make(law.state_name, waypoint=waypoint))


@pytest.mark.parametrize("following", [-1, -(10**6), 2**53])
def test_pid_state_naming_no_place_matches_reference(following: int) -> None:
    pair = make("Pid", make("Path", Shape().build().xy))
    state: dict[str, Any] = {"next": following}
    assert not pair.set_state(make("PidState", **state))
