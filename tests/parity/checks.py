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
from tests.parity.strategies import Shape, Spot, Waypoints, fitted

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
    actuator: dict[str, Any] | None = None,
) -> Pair:
    """A law with these parameters on this path, on both sides."""
    if law.searches:
        params = fitted(params, path, most)
    made = make("Path", path.xy, speed=path.speed, closed=path.closed)
    chain = None if actuator is None else make("Actuator", **actuator)
    return make(law.name, made, make(law.params_name, **params), actuator=chain)


def check_steps(pair: Pair, steps: Iterable[Sequence[float]]) -> None:
    """Take steps; angles, errors, targets and states agree."""
    for k, (x, y, yaw, speed, dt) in enumerate(steps):
        if k % 3 == 2:
            pair.call("steer", x, y, yaw, speed, dt)
        else:
            pair.call("step", x, y, yaw, speed, dt)
        pair.get("state")


def check_random(law: Law, shape: Shape, params: dict[str, Any], spots: list[Spot]) -> None:
    """A few steps at any places, jumping between them."""
    path = shape.build()
    pair = controller(law, path, params)
    check_steps(pair, [spot.at(path) for spot in spots])
    pair.call("reset")
    for attribute in ("state", "params", "path", "reference_offset"):
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


def check_zeros(law: Law) -> None:
    """The sign of a zero tells in which order numbers were added, and to what."""
    for x, y in ((1.0, 0.0), (-1.0, -0.0), (0.0, 1.0), (-0.0, -1.0)):
        path = Waypoints([(k * x, k * y) for k in range(30)], None, closed=False)
        for zeros in itertools.product((0.0, -0.0), repeat=4):
            pair = controller(law, path, {"reference_offset": 0.0}, most=200)
            check_steps(pair, [(*zeros, 0.05), (*zeros[:3], 5.0, 0.05), (*zeros, 0.05)])


def check_bad_states(law: Law, good: dict[str, Any], bad: list[dict[str, Any]]) -> None:
    """Restored or refused alike; a refusal leaves the state as it was."""
    path = Shape(count=30).build()
    pair = controller(law, path, {}, most=200)
    check_steps(pair, [Spot(0.2, 0.7, 0.1).at(path)])
    waypoints = [{"waypoint": waypoint} for waypoint in (30, 31, 10**6)]
    for fields in [*waypoints, *bad]:
        before = pair.get("state")
        state = make(law.state_name, **{**good, **fields})
        assert not pair.set_state(state), f"{state} was accepted"
        after = pair.get("state")
        assert after.rust == before.rust
        assert after.twin == before.twin
    for fields in ({}, {"waypoint": None}, {"waypoint": 0}, {"waypoint": 29}):
        assert pair.set_state(make(law.state_name, **{**good, **fields}))
        pair.get("state")
        check_steps(pair, [Spot(0.3, -0.4, 0.2).at(path)])


@dataclass(frozen=True)
class Drive:
    """A run of at least 200 steps: a path, a start, and a seed for all that changes on the way."""

    shape: Shape = field(default_factory=Shape)
    start: Spot = field(default_factory=Spot)
    steps: int = 200
    laps: float = 1.0
    rough: float = 0.0
    seed: int = 0


def check_rollout(law: Law, drive: Drive, params: dict[str, Any], most: int = 250) -> None:
    """Drive a kinematic bicycle by the law, with disturbances; speed and dt change all the time.

    On the way the state is saved, restored, carried over to a new controller and forgotten;
    `step` and `steer` alternate, and now and then an input is refused.
    """
    path = drive.shape.build()
    pair = controller(law, path, params, most)
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
            pair = make(law.name, pair.get("path"), pair.get("params"))
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
        x, y, yaw, _ = popsteer.kinematic_bicycle(
            x, y, yaw, speed, popsteer.saturate(steer, -1.2, 1.2), 0.0, 3.0, dt
        )
        x += drive.rough * rng.gauss(0.0, 0.1)
        y += drive.rough * rng.gauss(0.0, 0.1)
        yaw = math.remainder(yaw + drive.rough * rng.gauss(0.0, 0.02), 400.0 * math.pi)
    pair.get("state")


def check_params(law: Law) -> None:
    """Both ends of every range are taken; what lies beyond is refused with the same words."""
    name = law.params_name
    make(name)
    for field_name, ((low, high), _) in law.ranges.items():
        for value in (low, high, int(high)):
            make(name, **{field_name: value})
        beyond: tuple[Any, ...] = (
            math.nextafter(low, -INF),
            math.nextafter(high, INF),
            -1e300,
            1e300,
        )
        for refused in (NAN, INF, -INF, *beyond, [1.0], {}):
            assert call(name, **{field_name: refused}) is None
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
    assert call(name, no_such_parameter=1.0) is None
    assert call(name, 1.0) is None


def check_copies(law: Law, params: dict[str, Any], changes: dict[str, Any]) -> None:
    """`as_dict` and `replace` are what `dataclasses` has for the reference."""
    for name, fields in ((law.params_name, params), (law.state_name, {})):
        if not hasattr(popsteer, name):  # a law without memory
            continue
        pair = make(name, **fields)
        same(f"{name}.as_dict", pair.rust.as_dict, partial(dataclasses.asdict, pair.twin))
        if fields is params:
            replaced = partial(dataclasses.replace, pair.twin)
            same(f"{name}.replace", pair.rust.replace, replaced, **changes)
