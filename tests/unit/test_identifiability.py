"""What a fit leaves unknown, and within which range: the rules of `identifiability`, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from popsteer import Vehicle
from popsteer.identification.identifiability import unidentified

DRIVE: Any = SimpleNamespace(usual_speed=8.0)
VALUES = {
    "turning_wheelbase": 2.7,
    "understeer": 0.001,
    "steer_offset": 0.01,
    "steer_lag": 0.3,
    "dead_time": 0.1,
    "steer_play": 0.01,
}


def _fit(errors: dict[str, float], **changes: Any) -> Any:
    wheels = SimpleNamespace(times=np.arange(0.0, 5.0, 0.1), angle=0.02 * np.arange(50.0))
    fit = {
        "values": VALUES,
        "errors": errors,
        "error_of": lambda **_: 0.01,
        "wheels": wheels,
        "rate_seen": False,
        "rounded": 0.0,
        "play_seen": True,
    }
    return SimpleNamespace(**fit | changes)


def test_lag_and_dead_time_that_are_one_lie_below_their_sum() -> None:
    unknown = unidentified(_fit({"steer_lag": 0.2, "dead_time": 0.2}), DRIVE, Vehicle())
    # 0.3 ± 2 * 0.2 and 0.1 ± 2 * 0.2, of which neither is negative nor more than 0.4 + 2 * 0.01.
    assert unknown.ranges["steer_lag"] == pytest.approx((0.0, 0.42))
    assert unknown.ranges["dead_time"] == pytest.approx((0.0, 0.42))
    short = unidentified(_fit({"steer_lag": 0.03, "dead_time": 0.03}), DRIVE, Vehicle())
    assert short.ranges["steer_lag"] == pytest.approx((0.24, 0.36))
    assert short.ranges["dead_time"] == pytest.approx((0.04, 0.16))


def test_play_that_is_not_seen_is_at_most_two_errors_more() -> None:
    unknown = unidentified(_fit({"steer_play": 0.002}, play_seen=False), DRIVE, Vehicle())
    assert unknown.ranges["steer_play"] == pytest.approx((0.0, 0.014))
    assert "steer_play" not in unidentified(_fit({"steer_play": 0.002}), DRIVE, Vehicle()).why
    none = _fit({}, values=VALUES | {"steer_play": 0.0}, play_seen=False)
    none.profile = lambda _, plays: [0.0 if play < 0.015 else -2.1 for play in plays]
    assert unidentified(none, DRIVE, Vehicle()).ranges["steer_play"] == (0.0, 0.02)


@pytest.mark.parametrize(("error", "sure"), [(0.2, True), (0.4, False)])
def test_offset_is_known_to_a_third_of_a_degree(error: float, sure: bool) -> None:
    given = Vehicle(steer_offset=0.02)
    unknown = unidentified(_fit({"steer_offset": math.radians(error)}), DRIVE, given)
    assert ("steer_offset" not in unknown.why) == sure
    assert unknown.fixed == ({} if sure else {"steer_offset": 0.02})


def test_rate_that_was_told_is_not_asked_for() -> None:
    assert "max_steer_rate" not in unidentified(_fit({}), DRIVE, Vehicle(max_steer_rate=0.4)).why
    unknown = unidentified(_fit({}), DRIVE, Vehicle())
    assert unknown.ranges["max_steer_rate"] == pytest.approx((0.2, math.inf))
