"""What no controller could remember, and no vehicle report: refused by name, to the last bit."""

from __future__ import annotations

import math
from math import inf, nan, nextafter, pi
from typing import TYPE_CHECKING, Any

import pytest

import popsteer
from popsteer import ConfigError, InputError
from tests.parity.laws import LATERAL, SPEED_TRACKER, Law
from tests.parity.strategies import (
    ADAPT_OPTIONAL,
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


# The range of each number that any controller of the default vehicle remembers.
RANGES: dict[str, tuple[float, float]] = {
    "steer": (-1.22, 1.22),
    "handover_remaining": (0.0, 1.0),
    "held_time": (0.0, 1e3),
    "period": (0.0, 1e3),
    **dict.fromkeys(("turn_turn", "offset_offset", "change"), (0.0, 1e100)),
    **dict.fromkeys(("turn_offset", "turn_measured", "offset_measured"), (-1e100, 1e100)),
    "turn": (-1e30, 1e30),
    "gain": (0.4, 2.5),
    "steer_offset": (-0.15, 0.15),
    "slip": (-0.15, 0.15),
    "slip_length": (-3.0, 3.0),
    "acceleration": (-60.0, 60.0),
    "past_wheel": (-0.5 * pi, 0.5 * pi),
}
_DEVIATION, _AHEAD = (0.5, 0.1, 1.0, 0.0), (None, inf)
_REST = ((1.0, 2.0), False, _AHEAD, _DEVIATION)
# What the monitor remembers: of the last step, of the last second, of all the time, its alarm, and
# whether the deviation was within its limit.
_MONITORED: tuple[Any, ...] = (
    *((0.1, 0.2, 0.01), (0.1, 0.2, 0.1, 0.3, 2.0, 0.0), (1.0, 1e-6, 9.0, 0.1)),
    *(0.5, True),
)
_POSE = (0.0, 0.0, 0.0, 1.0)


def _bad_states() -> Iterator[tuple[str, dict[str, Any]]]:
    """States that no controller could be in, each with the field that is named."""
    for field in ("waypoint", "measured_waypoint"):
        yield from ((field, {field: waypoint}) for waypoint in (30, 31, 10**6, -1))
    for field, (low, high) in RANGES.items():
        yield from ((field, {field: value}) for value in _beyond(low, high))
    for value in _beyond(-2.59, 2.59):
        yield "handover_offset", {"handover_offset": value, "handover_remaining": 0.5}
    for value in _beyond(0.0, 1e6):
        yield "past_since", {"past_wheel": 0.0, "past_since": value}
    yield "past_angles", {"past_wheel": 0.0, "past_angles": ((0.0, 0.1),) * 131}
    for each in ((nan, 0.1), (1.6, 0.1), (0.1, nan), (0.1, -0.1), (0.1, 2e6)):
        yield "past_angles", {"past_wheel": 0.0, "past_angles": ((0.0, 0.1), each)}
    yield from (("place", {"place": place}) for place in _spoilt(_POSE, (4e9,) * 4))
    poses = _spoilt(_POSE, (2e9, 2e9, 1e6, 1e4))
    yield from (("last_measured", {"last_measured": pose}) for pose in poses)
    yield from (("answer", {"answer": answer}) for answer in _bad_answers())
    yield from (("monitor", {"monitor": monitored}) for monitored in _bad_monitored())
    # The first in the order of the check is the one named.
    yield "waypoint", {"waypoint": 99, "measured_waypoint": 99, "steer": nan, "gain": nan}
    yield "measured_waypoint", {"measured_waypoint": 99, "steer": nan, "gain": nan}
    yield "steer", {"steer": nan, "handover_remaining": nan, "turn_turn": nan}


def _bad_monitored() -> Iterator[tuple[Any, ...]]:
    all_bounds = ((0.5 * pi, 1e6, 1e100), (1e100,) * 6, (2.0, 1e100, 1e100, 1e100))
    for part, bounds in enumerate(all_bounds):
        for bad in _spoilt(_MONITORED[part], bounds):
            yield (*_MONITORED[:part], bad, *_MONITORED[part + 1 :])
    for value in (nan, inf, -0.1, 2.1):
        yield (*_MONITORED[:3], value, False)


def _bad_answers() -> Iterator[tuple[Any, ...]]:
    for deviation in _spoilt(_DEVIATION, (4e9, 2e6, 4e9, 4e9)):
        yield (deviation, _DEVIATION, *_REST)
        yield (_DEVIATION, deviation, *_REST)
    for target in _spoilt((1.0, 2.0), (4e9, 4e9)):
        yield (_DEVIATION, _DEVIATION, target, True, _AHEAD, _DEVIATION)
    for ahead in ((nan, 1.0), (2.1e4, 1.0), (-2.1e4, 1.0), (1.0, nan), (1.0, -inf), (1.0, 2e18)):
        yield (_DEVIATION, _DEVIATION, (1.0, 2.0), True, ahead, _DEVIATION)
    for pose in _spoilt(_POSE, (1e9, 1e9, 1e6, 1e4)):
        yield (_DEVIATION, _DEVIATION, (1.0, 2.0), True, _AHEAD, pose)


OWN: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "Pop": [("previous_steer", {"previous_steer": each}) for each in _beyond(-1.22, 1.22)],
    "PreviewPop": [
        *(("previous_steer", {"previous_steer": each}) for each in _beyond(-1.22, 1.22)),
        # Its wheels are modelled always: what is in flight has to be what can be.
        *(("wheel", {"wheel": each}) for each in _beyond(-0.5 * pi, 0.5 * pi)),
        *(
            ("commands_in_flight", {"wheel": 0.1, "commands_in_flight": commands})
            for commands in (((nan, 0.0),), ((1.6, 0.0),), ((0.1, 1e-6),), ((0.0, 0.0),) * 197)
        ),
    ],
    "Pid": [
        *(("previous_error", {"previous_error": each}) for each in _beyond(-1e16, 1e16)),
        *(("previous_position", {"previous_position": (0.0, each)}) for each in _beyond(-4e9, 4e9)),
        *(("sum", {"sum": each}) for each in _beyond(-1e16, 1e16)),
        *(("terms", {"terms": (each, 1.0), "next": 2}) for each in _beyond(-1e16, 1e16)),
        *(("next", {"terms": (0.1, 0.2), "next": each}) for each in (0, 1, 3, 500, 501)),
        *(("next", {"terms": (0.0,) * 500, "next": each}) for each in (500, 501)),
        *(("terms", {"terms": (0.0,) * each, "next": 0}) for each in (501, 1001)),
    ],
    "PurePursuit": [("previous_alpha", {"previous_alpha": each}) for each in _beyond(-pi, pi)],
    "Stanley": [],
}


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_state_beyond_its_bounds_is_refused_by_name(law: Law) -> None:
    controller = getattr(popsteer, law.name)(PATH)
    controller.step(*STEP)
    before = controller.state
    for field, changes in (*OWN[law.name], *_bad_states()):
        state = type(before)(**{**before.as_dict(), **changes})
        with pytest.raises(InputError) as refused:
            controller.state = state
        assert refused.value.field == field, changes
        assert controller.state == before
    good: list[dict[str, Any]] = [{name: end} for name, ends in RANGES.items() for end in ends]
    good += [{"monitor": _MONITORED}, {"place": (4e9, -4e9, 0.0, 0.0)}]
    good += [{"answer": (_DEVIATION, _DEVIATION, *_REST)}, {"last_measured": (2e9, 0.0, 1e6, 1e4)}]
    for changes in good:
        controller.state = type(before)(**{**before.as_dict(), **changes})
        controller.step(*STEP)


@pytest.mark.parametrize("law", LATERAL, ids=lambda law: law.name)
def test_report_beyond_its_bounds_is_refused_by_name(law: Law) -> None:
    controller = getattr(popsteer, law.name)(PATH, popsteer.Vehicle(max_steer=0.5))
    controller.step(*STEP)
    before = controller.state
    bad: list[tuple[str, dict[str, float]]] = [
        *(("applied_steer", {"applied_steer": value}) for value in _beyond(-0.5 * pi, 0.5 * pi)),
        *(("pose_age", {"pose_age": value}) for value in _beyond(0.0, 1.0)),
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
    for reported in ({"applied_steer": 0.5 * pi}, {"pose_age": 1.0}, {"pose_age": 0.0}):
        assert math.isfinite(controller.step(*STEP, **reported).steer)
    for time, dt in ((nan, 0.05), (-1.0, 0.05), (1001.0, 0.05), (1.0, 0.0), (1.0, 1e-7)):
        with pytest.raises(InputError):
            controller.predict(time, dt)
    assert len(controller.predict(0.0, 0.05).x) == 1


def test_parameters_of_what_is_around_a_controller_have_the_documented_bounds() -> None:
    around = (
        ("AdaptParams", ADAPT_RANGES, ADAPT_OPTIONAL),
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


def test_state_of_a_speed_pid_beyond_its_bounds_is_refused_by_name() -> None:
    controller = popsteer.SpeedPid()
    controller.step(1.0, 20.0, 0.05)
    for field, (low, high) in {"integral": (-1.0, 1.0), "previous_error": (-2e4, 2e4)}.items():
        before = controller.state
        for value in _beyond(low, high):
            with pytest.raises(InputError) as refused:
                controller.state = type(before)(**{field: value})
            assert refused.value.field == field
            assert controller.state == before
        for end in (low, high):
            controller.state = type(before)(**{field: end})
