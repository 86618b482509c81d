"""What every steering law is put through, on both sides."""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import popsteer
from tests.parity.compare import Pair, call, make, same
from tests.parity.strategies import Ranges, Shape, Spot, Waypoints, fitted

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from tests.parity.laws import Law

NAN, INF = math.nan, math.inf

# Each argument of a step, just beyond its bounds and far beyond.
BAD_STEPS: list[tuple[int, float]] = [
    (argument, value)
    for argument, bound in enumerate([1e9, 1e9, 1e6, 1e4])
    for value in (NAN, INF, -INF, math.nextafter(bound, INF), math.nextafter(-bound, -INF))
] + [
    (4, value)
    for value in (
        *(NAN, INF, -INF, 0.0, -0.0, -0.05, 5e-324),
        *(math.nextafter(1e-6, 0.0), math.nextafter(1e3, INF)),
    )
]


def controller(
    law: Law,
    path: Waypoints,
    params: dict[str, Any],
    most: int = 5000,
    vehicle: dict[str, Any] | None = None,
    adapt: Any = "auto",
) -> Pair:
    """A controller with these parameters on this path, on both sides."""
    car = vehicle or {}
    if law.searches:
        params = fitted(params, path, most, car.get("wheelbase", 3.0))
    made = make("Path", path.xy, speed=path.speed, closed=path.closed)
    tuning = make(law.params_name, **params)
    given = None if vehicle is None else make("Vehicle", **vehicle)
    return make(law.name, made, given, tuning, **adapting(adapt))


def adapting(adapt: Any) -> dict[str, Any]:
    """The argument `adapt` of a controller; left out for the default, "auto"."""
    if adapt == "auto":
        return {}
    return {"adapt": None if adapt is None else make("AdaptParams", **adapt)}


ATTRIBUTES = (
    *("state", "params", "path", "vehicle", "vehicle_given", "adapt", "estimate"),
    *("monitor", "tracked_point"),
)
"""What every controller shows."""


def check_steps(pair: Pair, steps: Iterable[Sequence[float]]) -> None:
    """Take steps; angles, errors, targets and states agree."""
    for k, (x, y, yaw, speed, dt) in enumerate(steps):
        if k % 3 == 2:
            pair.call("steer", x, y, yaw, speed, dt)
        else:
            pair.call("step", x, y, yaw, speed, dt)
        pair.get("state")


def check_random(
    law: Law,
    shape: Shape,
    params: dict[str, Any],
    spots: list[Spot],
    vehicle: dict[str, Any] | None = None,
    adapt: Any = "auto",
) -> None:
    """A few steps at any places, jumping between them."""
    path = shape.build()
    pair = controller(law, path, params, vehicle=vehicle, adapt=adapt)
    check_steps(pair, [spot.at(path) for spot in spots])
    pair.get("estimate")
    pair.call("reset")
    for attribute in ATTRIBUTES:
        pair.get(attribute)


def check_bad_steps(law: Law) -> None:
    """Refused with the same words, and the state is as before."""
    path = Shape(count=30).build()
    pair = controller(law, path, {}, most=200)
    good = Spot(0.2, 0.7, 0.1).at(path)
    for warm in (False, True):
        if warm:
            check_steps(pair, [good])
        before = pair.get("state")
        for argument, value in BAD_STEPS:
            bad = [*good[:argument], value, *good[argument + 1 :]]
            for method in ("step", "steer"):
                assert pair.call(method, *bad) is None
                assert pair.rust.state == before.rust
                assert pair.twin.state == before.twin
        # The first of several is the one named; the others are no numbers, or too few.
        for bad_step in ([NAN] * 5, [1.0, NAN, NAN, 1.0, 0.0], [None] * 5, good[:4]):
            assert pair.call("step", *bad_step) is None
        assert pair.get("state").rust == before.rust


# The tracked point is the pose's, for those that track the rear axle and for the others; commands
# are limited, offset and delayed, or left as they are.
ZERO_CARS: list[dict[str, Any]] = [
    {},
    {"rear_axle": -3.0},
    {"rear_axle": -3.0, "max_lateral_acceleration": None},
    {"rear_axle": -0.0, "steer_offset": -0.0, "dead_time": 0.1, "max_steer_rate": 0.5},
]


def check_zeros(law: Law) -> None:
    """The sign of a zero tells in which order numbers were added, and to what."""
    for x, y in ((1.0, 0.0), (-1.0, -0.0), (0.0, 1.0), (-0.0, -1.0)):
        path = Waypoints([(k * x, k * y) for k in range(30)], None, closed=False)
        for zeros in itertools.product((0.0, -0.0), repeat=4):
            for car in ZERO_CARS:
                pair = controller(law, path, {}, most=200, vehicle=car)
                check_steps(pair, [(*zeros, 0.05), (*zeros[:3], 5.0, 0.05), (*zeros, 0.05)])


def _beyond(field_name: str, low: float, high: float) -> list[dict[str, Any]]:
    return [
        {field_name: value}
        for value in (NAN, INF, -INF, math.nextafter(high, INF), math.nextafter(low, -INF))
    ]


def _spoilt(field_name: str, good: tuple[float, ...], bounds: Sequence[float]) -> list[Any]:
    """Tuples with one entry beyond its bound."""
    return [
        {field_name: (*good[:k], value, *good[k + 1 :])}
        for k, bound in enumerate(bounds)
        for value in (NAN, INF, math.nextafter(bound, INF), -math.nextafter(bound, INF))
    ]


_DEVIATION = (0.5, 0.1, 1.0, 0.0)
_AHEAD = (None, INF)
# What the monitor remembers: of the last step, of the last second, of all the time, its alarm, and
# whether the deviation was within its limit.
_MONITORED: tuple[Any, ...] = (
    *((0.1, 0.2, 0.01), (0.1, 0.2, 0.1, 0.3, 2.0, 0.0), (1.0, 1e-6, 9.0, 0.1)),
    *(0.5, True),
)
_SUMS = ("turn_offset", "turn_measured", "offset_measured")
# What no state remembers beside the law's own, of the default vehicle.
BAD_TAILS: list[dict[str, Any]] = [
    *({"measured_waypoint": waypoint} for waypoint in (30, 31, 10**6, -1)),
    *_beyond("steer", -1.22, 1.22),
    *({**fields, "handover_remaining": 0.5} for fields in _beyond("handover_offset", -2.59, 2.59)),
    *_beyond("handover_remaining", 0.0, 1.0),
    *_spoilt("place", (0.0, 0.0, 0.0, 1.0), (4e9,) * 4),
    *_beyond("held_time", 0.0, 1e3),
    *_beyond("period", 0.0, 1e3),
    *_spoilt("last_measured", (0.0, 0.0, 0.0, 1.0), (2e9, 2e9, 1e6, 1e4)),
    *(
        fields
        for name in ("turn_turn", "offset_offset", "change")
        for fields in _beyond(name, 0.0, 1e100)
    ),
    *(fields for name in _SUMS for fields in _beyond(name, -1e100, 1e100)),
    *_beyond("turn", -1e30, 1e30),
    *_beyond("gain", 0.4, 2.5),
    *_beyond("steer_offset", -0.15, 0.15),
    *_beyond("longer_dead_time", 0.0, 0.0),
    *_beyond("slip", -0.15, 0.15),
    *_beyond("slip_length", -3.0, 3.0),
    *_beyond("acceleration", -60.0, 60.0),
    *(
        {
            "answer": (
                *([fields["last_measured"], _DEVIATION][::turn]),
                (1.0, 2.0),
                False,
                _AHEAD,
                _DEVIATION,
            )
        }
        for fields in _spoilt("last_measured", _DEVIATION, (4e9, 2e6, 4e9, 4e9))
        for turn in (1, -1)
    ),
    *(
        {"answer": (_DEVIATION, _DEVIATION, fields["target"], True, _AHEAD, _DEVIATION)}
        for fields in _spoilt("target", (1.0, 2.0), (4e9, 4e9))
    ),
    *(
        {"answer": (_DEVIATION, _DEVIATION, (1.0, 2.0), True, ahead, _DEVIATION)}
        for ahead in ((NAN, 1.0), (2.1e4, 1.0), (-2.1e4, 1.0), (1.0, NAN), (1.0, -INF), (1.0, 2e18))
    ),
    *(
        {"answer": (_DEVIATION, _DEVIATION, (1.0, 2.0), True, _AHEAD, fields["vehicle"])}
        for fields in _spoilt("vehicle", (0.0, 0.0, 0.0, 1.0), (1e9, 1e9, 1e6, 1e4))
    ),
    *_beyond("past_wheel", -0.5 * math.pi, 0.5 * math.pi),
    *({"past_wheel": 0.0, **fields} for fields in _beyond("past_since", 0.0, 1e6)),
    {"past_wheel": 0.0, "past_angles": ((0.0, 0.1),) * 131},
    *(
        {"past_wheel": 0.0, "past_angles": ((0.0, 0.1), each)}
        for each in ((NAN, 0.1), (1.6, 0.1), (0.1, NAN), (0.1, -0.1), (0.1, 2e6))
    ),
    *(
        {"monitor": (*_MONITORED[:place], *(fields["part"],), *_MONITORED[place + 1 :])}
        for place, bounds in (
            (0, (0.5 * math.pi, 1e6, 1e100)),
            (1, (1e100,) * 6),
            (2, (2.0, 1e100, 1e100, 1e100)),
        )
        for fields in _spoilt("part", _MONITORED[place], bounds)
    ),
    *({"monitor": (*_MONITORED[:3], value, False)} for value in (NAN, INF, -0.1, 2.1)),
    # The first in the order of the check is the one named.
    {"waypoint": 99, "measured_waypoint": 99, "steer": NAN, "handover_remaining": NAN, "gain": NAN},
    {"measured_waypoint": 99, "steer": NAN, "handover_remaining": NAN, "gain": NAN},
    {
        "steer": NAN,
        "handover_remaining": NAN,
        "gain": NAN,
        "turn_turn": NAN,
        "last_measured": (NAN,) * 4,
    },
    {
        "handover_remaining": NAN,
        "handover_offset": NAN,
        "turn_turn": NAN,
        "last_measured": (NAN,) * 4,
    },
    {"turn_turn": NAN, "change": NAN, "turn": NAN, "gain": NAN, "slip": NAN},
]


def check_bad_states(law: Law, good: dict[str, Any], bad: list[dict[str, Any]]) -> None:
    """Restored or refused alike; a refusal leaves the state as it was."""
    path = Shape(count=30).build()
    pair = controller(law, path, {}, most=200)
    check_steps(pair, [Spot(0.2, 0.7, 0.1).at(path)])
    waypoints = [{"waypoint": waypoint} for waypoint in (30, 31, 10**6)]
    for fields in [*waypoints, *bad, *BAD_TAILS]:
        before = pair.get("state")
        state = make(law.state_name, **{**good, **fields})
        assert not pair.set_state(state), f"{state} was accepted"
        after = pair.get("state")
        assert after.rust == before.rust
        assert after.twin == before.twin
    for fields in (
        *({}, {"waypoint": None}, {"waypoint": 0}, {"waypoint": 29}, {"held": -1}),
        *({"handover_remaining": -0.0}, {"handover_offset": 0.1}, {"handover_remaining": 0.5}),
        {"place": (1.0, 2.0, 3.0, 4.0), "held_time": 0.3, "period": 0.1},
        {
            "answer": (_DEVIATION, _DEVIATION, (1.0, 2.0), True, (-2.0, 3.0), _DEVIATION),
            "last_measured": _DEVIATION,
            "measured_waypoint": 3,
        },
        {"past_wheel": 0.1, "past_angles": ((0.2, 0.3), (0.1, 0.5)), "past_since": 0.05},
        {"monitor": _MONITORED},
        {"wheel": 0.1, "commands_in_flight": ((5.0, 9.0),) * 300 if not law.reads_belief else ()},
    ):
        assert pair.set_state(make(law.state_name, **{**good, **fields}))
        pair.get("state")
        check_steps(pair, [Spot(0.3, -0.4, 0.2).at(path)])


@dataclass(frozen=True)
class Rollout:
    """A run of at least 200 steps: a path, a start, and a seed for all that changes on the way."""

    shape: Shape = field(default_factory=Shape)
    start: Spot = field(default_factory=Spot)
    steps: int = 200
    laps: float = 1.0
    rough: float = 0.0
    seed: int = 0


def check_rollout(
    law: Law,
    drive: Rollout,
    params: dict[str, Any],
    most: int = 250,
    vehicle: dict[str, Any] | None = None,
    adapt: Any = "auto",
) -> None:
    """Drive a kinematic bicycle by the law, with disturbances; speed and dt change all the time.

    On the way the state is saved, restored, carried over to a new controller and forgotten;
    `step` and `steer` alternate, and now and then an input is refused.
    """
    path = drive.shape.build()
    pair = controller(law, path, params, most, vehicle, adapt)
    wheelbase = (vehicle or {}).get("wheelbase", 3.0)
    rng = random.Random(drive.seed)
    events = dict(
        zip(rng.sample(range(drive.steps), 4), ("save", "restore", "move", "reset"), strict=True)
    )
    saved = pair.get("state")
    x, y, yaw, _, period = drive.start.at(path)
    usual_speed = drive.laps * sum(path.lengths) / (drive.steps * period)
    for k in range(drive.steps):
        event = events.get(k)
        if event == "save":
            saved = pair.get("state")
        elif event == "restore":
            assert pair.set_state(saved)
        elif event == "move":
            state = pair.get("state")
            parts = [pair.get(part) for part in ("path", "vehicle", "params")]
            pair = make(law.name, *parts, adapt=pair.get("adapt"))
            assert pair.set_state(state)
        elif event == "reset":
            pair.call("reset")

        dt = 1e-4 if rng.random() < 0.02 else period * rng.uniform(0.3, 1.7)
        standing = rng.random() < 0.05
        speed = 0.0 if standing else min(usual_speed * rng.uniform(-0.1, 2.0), 80.0)
        if rng.random() < 0.02:
            assert pair.call("step", x, NAN, yaw, speed, dt) is None
        if rng.random() < 0.7:
            command = pair.call("step", x, y, yaw, speed, dt)
            assert command is not None
            steer = command.rust.steer
        else:
            angle = pair.call("steer", x, y, yaw, speed, dt)
            assert angle is not None
            steer = angle.rust
        if k % 40 == 39:
            pair.get("state")
        x, y, yaw, _ = popsteer.paper.kinematic_bicycle(
            x, y, yaw, speed, popsteer.paper.saturate(steer, -1.2, 1.2), 0.0, wheelbase, dt
        )
        x += drive.rough * rng.gauss(0.0, 0.1)
        y += drive.rough * rng.gauss(0.0, 0.1)
        yaw = math.remainder(yaw + drive.rough * rng.gauss(0.0, 0.02), 400.0 * math.pi)
    pair.get("state")
    pair.get("estimate")


def check_params(law: Law) -> None:
    """Both ends of every range are taken; what lies beyond is refused with the same words."""
    name = law.params_name
    check_ranges(name, law.ranges, law.optional)
    for field_name, (least, most) in law.counts.items():
        for count in (least, most):
            make(name, **{field_name: count})
        for no_count in (least - 1, 0, -1, most + 1, 2**53, -(2**53), 21.0, "21", None):
            assert call(name, **{field_name: no_count}) is None
    for field_name, flag in itertools.product(law.flags, (True, False)):
        make(name, **{field_name: flag})
    # The first refused in the order of the constructor is the one named.
    everything = dict.fromkeys(law.ranges, NAN) | dict.fromkeys(law.counts, 0)
    while everything:
        assert call(name, **everything) is None
        everything.popitem()


def check_ranges(name: str, ranges: Ranges, optional: Sequence[str]) -> None:
    """The same of the numbers of a class alone."""
    make(name)
    for field_name, ((low, high), _) in ranges.items():
        for value in (low, high, int(high)):
            make(name, **{field_name: value})
        beyond: tuple[Any, ...] = (
            math.nextafter(low, -INF),
            math.nextafter(high, INF),
            *(-1e300, 1e300, 10**400, -(10**400)),
        )
        for refused in (NAN, INF, -INF, *beyond, [1.0], {}):
            assert call(name, **{field_name: refused}) is None
        assert (call(name, **{field_name: None}) is None) == (field_name not in optional)
    everything = dict.fromkeys(ranges, NAN)
    while everything:
        assert call(name, **everything) is None
        everything.popitem()
    assert call(name, no_such_parameter=1.0) is None
    assert call(name, 1.0) is None


def check_resolved(law: Law, params: dict[str, Any], vehicle: dict[str, Any]) -> None:
    """Defaults that scale with the vehicle come to the same numbers."""
    made = make(law.params_name, **params)
    resolved = made.call("resolved", make("Vehicle", **vehicle))
    assert resolved is not None
    assert None not in resolved.rust.as_dict().values()


def check_copies(law: Law, params: dict[str, Any], changes: dict[str, Any]) -> None:
    """`as_dict` and `replace` are what `dataclasses` has for the reference."""
    check_copy(law.params_name, params, changes)
    if hasattr(popsteer, law.state_name):  # else a law without memory
        check_copy(law.state_name, {}, None)


def check_copy(name: str, fields: dict[str, Any], changes: dict[str, Any] | None) -> None:
    """The same of any class; without `changes` of one that has no `replace`."""
    pair = make(name, **fields)
    same(f"{name}.as_dict", pair.rust.as_dict, partial(dataclasses.asdict, pair.twin))
    if changes is not None:
        replaced = partial(dataclasses.replace, pair.twin)
        same(f"{name}.replace", pair.rust.replace, replaced, **changes)
