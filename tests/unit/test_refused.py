"""What no vehicle reports, and no parameter may be: refused by name, to the last bit.

States are refused in test_api_state.
"""

from __future__ import annotations

import math
from math import inf, nan, nextafter, pi
from typing import TYPE_CHECKING

import pytest

import popsteer
from popsteer import ConfigError, InputError
from tests.parity.laws import LATERAL, SPEED_TRACKER, Law
from tests.parity.strategies import (
    ADAPT_RANGES,
    MONITOR_OPTIONAL,
    MONITOR_RANGES,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

PATH = popsteer.Path([(float(k), 0.0) for k in range(30)])
STEP = (6.0, 0.7, 0.1, 5.0, 0.05)


def _beyond(low: float, high: float) -> tuple[float, ...]:
    return nan, inf, -inf, nextafter(high, inf), nextafter(low, -inf)


def _spoilt(good: tuple[float, ...], bounds: tuple[float, ...]) -> Iterator[tuple[float, ...]]:
    """Tuples with one entry beyond its bound."""
    for k, bound in enumerate(bounds):
        for value in (nan, inf, nextafter(bound, inf), -nextafter(bound, inf)):
            yield (*good[:k], value, *good[k + 1 :])


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_report_beyond_its_bounds_is_refused_by_name(law: Law) -> None:
    controller = getattr(popsteer, law.name)(PATH, popsteer.Vehicle(max_steer=0.5))
    controller.step(*STEP)
    before = controller.state
    bad: list[tuple[str, dict[str, float]]] = [
        *(
            (steer, {steer: value})
            for steer in ("applied_steer", "measured_steer")
            for value in _beyond(-0.5 * pi, 0.5 * pi)
        ),
        *(("pose_age", {"pose_age": value}) for value in _beyond(-1e-6, 1.0)),
        ("applied_steer", {"applied_steer": nan, "pose_age": nan}),
    ]
    for field, reported in bad:
        for method in ("step", "steer"):
            with pytest.raises(InputError) as refused:
                getattr(controller, method)(*STEP, **reported)
            assert refused.value.field == field
            assert controller.state == before
    with pytest.raises(InputError, match=r"^x must"):
        controller.step(nan, *STEP[1:], applied_steer=nan)
    for reported in (
        {"applied_steer": 0.5 * pi},
        {"measured_steer": -0.5 * pi},
        {"pose_age": 1.0},
        {"pose_age": 0.0},
    ):
        assert math.isfinite(controller.step(*STEP, **reported).steer)
    # A difference of two stamps may round to less than 0.
    controller.state = before
    rounded = controller.step(*STEP, pose_age=-5e-17)
    controller.state = before
    assert controller.step(*STEP, pose_age=0.0) == rounded
    for time, dt in ((nan, 0.05), (-1.0, 0.05), (1001.0, 0.05), (1.0, 0.0), (1.0, 1e-7)):
        with pytest.raises(InputError):
            controller.predict(time, dt)
    assert len(controller.predict(0.0, 0.05).x) == 1


def test_parameters_of_what_is_around_a_controller_have_the_documented_bounds() -> None:
    around = (
        ("AdaptParams", ADAPT_RANGES, ()),
        ("MonitorParams", MONITOR_RANGES, MONITOR_OPTIONAL),
        ("SpeedTrackerParams", SPEED_TRACKER.ranges, SPEED_TRACKER.optional),
    )
    for name, ranges, optional in around:
        kind = getattr(popsteer, name)
        for field, ((low, high), _) in ranges.items():
            for end in (low, high):
                assert kind(**{field: end}).as_dict()[field] == end
            for value in _beyond(low, high):
                with pytest.raises(ConfigError) as refused:
                    kind(**{field: value})
                assert refused.value.field == field
            if field in optional:
                assert kind(**{field: None}).as_dict()[field] is None
