"""What every controller is put through, on both sides."""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import popsteer
from tests.parity.compare import Controller, Pair, call, make
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
] + [(4, value) for value in (NAN, INF, -INF)]

# Control periods that are none: of a clock that repeats a stamp, or was set.
HELD_DTS = (
    *(0.0, -0.0, -0.05, -60.0, 5e-324, 1e308),
    *(math.nextafter(1e-6, 0.0), math.nextafter(1e3, INF)),
)


def controller(
    law: Law,
    path: Waypoints,
    params: dict[str, Any],
    most: int = 5000,
    vehicle: dict[str, Any] | None = None,
    estimate: dict[str, float] | None = None,
) -> Controller:
    """A controller with these parameters on this path, on both sides."""
    vehicle = vehicle or {}
    if law.searches:
        params = fitted(params, path, most, vehicle.get("wheelbase", 3.0))
    made = make("Path", path.xy, speed=path.speed, closed=path.closed, reverse=path.reverse)
    car = make("Vehicle", **vehicle)
    tuning = make(law.params_name, **params)
    return Controller(law.name, made, car, tuning, estimate_of(estimate, car))


def estimate_of(shares: dict[str, float] | None, car: Pair) -> dict[str, float]:
    """An estimate of a vehicle; lengths are given in wheelbases."""
    lengths = {"slip_length", "acceleration"}
    return {
        name: share * (car.twin.wheelbase if name in lengths else 1.0)
        for name, share in (shares or {}).items()
    }


def adapting(adapt: Any) -> dict[str, Any]:
    """The argument `adapt` of a controller of popsteer; left out for the default, "auto"."""
    if adapt == "auto":
        return {}
    return {"adapt": None if adapt is None else popsteer.AdaptParams(**adapt)}


def check_steps(pair: Controller, steps: Iterable[Sequence[float]]) -> None:
    """Take steps; angles, errors, targets and states agree."""
    for k, step in enumerate(steps):
        answer = pair.steer(*step) if k % 3 == 2 else pair.step(*step)
        assert answer is not None
        pair.state()


def check_random(
    law: Law,
    shape: Shape,
    params: dict[str, Any],
    spots: list[Spot],
    vehicle: dict[str, Any] | None = None,
    estimate: dict[str, float] | None = None,
) -> None:
    """A few steps at any places, jumping between them."""
    path = shape.build()
    pair = controller(law, path, params, vehicle=vehicle, estimate=estimate)
    check_steps(pair, [spot.at(path) for spot in spots])
    pair.reset()
    pair.state()


def check_bad_steps(law: Law) -> None:
    """Refused with the same words, and the state is as before; no time holds the last command."""
    path = Shape(count=30).build()
    pair = controller(law, path, {}, most=200)
    good = Spot(0.2, 0.7, 0.1).at(path)
    for warm in (False, True):
        if warm:
            check_steps(pair, [good])
        before = pair.state()
        bad_steps: list[list[Any]] = [[*good[:k], value, *good[k + 1 :]] for k, value in BAD_STEPS]
        # The first of several is the one named; the others are no numbers, or too few.
        bad_steps += [[NAN] * 5, [1.0, NAN, NAN, 1.0, 0.0], [None] * 5, list(good[:4])]
        for bad in bad_steps:
            for method in ("step", "steer"):
                assert pair.call(method, *bad) is None
                assert pair.rust.state == before.rust
                assert pair.twin.state == before.twin
        for count, dt in enumerate(itertools.islice(itertools.cycle(HELD_DTS), 12)):
            assert pair.step(*good[:4], dt) is not None
            assert pair.steer(*good[:4], dt) is not None
            assert pair.state().rust == before.rust.replace(held=2 * count + 2)
            assert pair.twin.state == dataclasses.replace(before.twin, held=2 * count + 2)


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
    estimate: dict[str, float] | None = None,
) -> None:
    """Rollout a kinematic bicycle by the controller, with disturbances; speed and dt always change.

    On the way the state is saved, restored, carried over to a new controller and forgotten;
    `step` and `steer` alternate, and now and then an input is refused.
    """
    path = drive.shape.build()
    pair = controller(law, path, params, most, vehicle, estimate)
    wheelbase = (vehicle or {}).get("wheelbase", 3.0)
    rng = random.Random(drive.seed)
    events = dict(
        zip(rng.sample(range(drive.steps), 4), ("save", "restore", "move", "reset"), strict=True)
    )
    saved = pair.state()
    x, y, yaw, _, period = drive.start.at(path)
    usual_speed = drive.laps * sum(path.lengths) / (drive.steps * period)
    for k in range(drive.steps):
        event = events.get(k)
        if event == "save":
            saved = pair.state()
        elif event == "restore":
            pair.restore(saved)
        elif event == "move":
            state = pair.state()
            pair = pair.anew()
            pair.restore(state)
        elif event == "reset":
            pair.reset()

        dt = 1e-4 if rng.random() < 0.02 else period * rng.uniform(0.3, 1.7)
        standing = rng.random() < 0.05
        speed = 0.0 if standing else min(usual_speed * rng.uniform(-0.1, 2.0), 80.0)
        if rng.random() < 0.02:
            assert pair.step(x, NAN, yaw, speed, dt) is None
        if rng.random() < 0.02:
            assert pair.step(x, y, yaw, speed, -dt) is not None
        if rng.random() < 0.7:
            command = pair.step(x, y, yaw, speed, dt)
            assert command is not None
            steer = command.rust.steer
        else:
            angle = pair.steer(x, y, yaw, speed, dt)
            assert angle is not None
            steer = angle.rust
        if k % 40 == 39:
            pair.state()
        x, y, yaw, _ = popsteer.paper.kinematic_bicycle(
            x, y, yaw, speed, popsteer.paper.saturate(steer, -1.2, 1.2), 0.0, wheelbase, dt
        )
        x += drive.rough * rng.gauss(0.0, 0.1)
        y += drive.rough * rng.gauss(0.0, 0.1)
        yaw = math.remainder(yaw + drive.rough * rng.gauss(0.0, 0.02), 400.0 * math.pi)
    pair.state()


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
    assert call(name, no_such_parameter=1.0) is None
    assert call(name, 1.0) is None


def check_resolved(law: Law, params: dict[str, Any], vehicle: dict[str, Any]) -> None:
    """Defaults that scale with the vehicle come to the same numbers."""
    made = make(law.params_name, **params)
    resolved = made.call("resolved", make("Vehicle", **vehicle))
    assert resolved is not None
    assert None not in resolved.rust.as_dict().values()
