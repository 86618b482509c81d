"""What is not as told, each case a drive and a number with a bound: studies.cases prints them."""

from __future__ import annotations

import functools
import math
import random
import statistics
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import popsteer
from tests.trust.car import (
    START,
    TOLD,
    Car,
    alternating,
    bends,
    circuit,
    drive,
    flips,
    freezing,
    glitching,
    jitter,
    somebody,
    straight,
    zigzag,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.trust.car import Drive, Pose

LAWS = {
    "preview POP": popsteer.PreviewPop,
    "Stanley": popsteer.Stanley,
    "pure pursuit": popsteer.PurePursuit,
    "PID": popsteer.Pid,
    "POP": popsteer.Pop,
}
CARS = 100
NOISE = (0.05, 0.01, 0.05)
GRIP = TOLD.replace(max_lateral_acceleration=4.0)
# Version 0.3.0 knows no outliers.
OUTLIER = getattr(popsteer.Status, "OUTLIER", popsteer.Status.OK)


class Case(NamedTuple):
    """A case: its number is at most (or, with `least`, at least) the bound."""

    title: str
    bound: float
    form: str
    """How the number is set, with its unit."""
    compute: Callable[[], float]
    least: bool = False

    def met(self, value: float) -> bool:
        # As it is set: what is printed as the bound meets it.
        shown = float(self.form.format(value).split()[0])
        return shown >= self.bound if self.least else shown <= self.bound

    def cell(self, value: float) -> str:
        """Set a number; in bold where it misses the bound."""
        shown = self.form.format(value) if math.isfinite(value) else "never"
        return shown if math.isfinite(value) and self.met(value) else f"**{shown}**"


def faults(driven: Drive) -> int:
    """In how many steps there was a fault."""
    return sum(status.level == "fault" for _, status in driven.statuses)


def after_fault(driven: Drive) -> tuple[float, float]:
    """How long after the failure a fault came [s], and how far off the car was then [m]."""
    first = next((t for t, s in driven.statuses if t >= START and s.level == "fault"), math.inf)
    return first - START, driven.error_at(first) if first < math.inf else math.inf


@functools.cache
def frozen(seconds: float) -> list[Drive]:
    """Freeze the pose in bends and on a straight."""
    return [
        drive(course=course, fresh=True, sense=freezing(seconds))
        for course in (bends(), straight())
    ]


def frozen_position() -> float:
    found = 0
    for seed in range(CARS):
        rng = random.Random(seed)
        car, speed = somebody(rng), rng.uniform(3.0, 15.0)
        course = bends() if speed < 9.0 and seed % 2 else straight()
        sense = freezing(100.0, yaw_alive=True)
        noise = (0.02, 0.003, 0.02)
        options: dict[str, Any] = {"sense": sense, "noise": noise, "fresh": True, "seconds": 14.0}
        driven = drive(car=car, course=course, speed=speed, **options)
        found += after_fault(driven)[1] < 0.5
    return found


def wrong_speed(factor: float) -> float:
    """In how many of six drives a wrong speed is a fault within 1 s, or before 0.5 m."""
    found = 0

    def sense(time: float, pose: Pose) -> Pose:
        return pose if time < START else (*pose[:3], factor * pose[3])

    for speed in (3.0, 8.0, 15.0):
        for course in (bends(stretch=2.0 if speed > 9.0 else 1.0), straight()):
            driven = drive(course=course, speed=speed, fresh=True, sense=sense, seconds=14.0)
            late, off = after_fault(driven)
            found += late < 1.0 or off < 0.5
    return found


def path_jumps() -> float:
    """Steps until a path that jumps 12 m to the side is a fault."""
    course = straight()
    steering = popsteer.PreviewPop(popsteer.Path(course), TOLD)
    steering.step(50.0, 0.0, 0.0, 8.0, 0.05)
    for k in range(20):
        steering.set_path(popsteer.Path(course + np.array((0.0, 12.0))))
        if steering.step(50.4 + 0.4 * k, 0.0, 0.0, 8.0, 0.05).status.level == "fault":
            return k + 1
    return math.inf


@functools.cache
def glitch(times: tuple[float, ...], aside: float, turned: float) -> tuple[int, float]:
    """Drive through poses that are off: steps with a fault; how the angle changes [mrad]."""
    healthy, off = (
        drive(car=Car(wheelbase=2.9), fresh=True, sense=sense)
        for sense in (None, glitching(times, aside, turned))
    )
    steps = zip(off.steers, healthy.steers, strict=False)
    return faults(off), 1e3 * max(abs(one[1] - other[1]) for one, other in steps)


def sometimes() -> Drive:
    """One pose in a hundred is off by up to 5 m and 1 rad."""
    rng = random.Random(3)

    def sense(_: float, pose: Pose) -> Pose:
        if rng.random() < 0.01:
            x, y, yaw, speed = pose
            return x + rng.uniform(-5, 5), y + rng.uniform(-5, 5), yaw + rng.uniform(-1, 1), speed
        return pose

    return drive(fresh=True, sense=sense, noise=NOISE)


def jumped(jump: float) -> Drive:
    def sense(time: float, pose: Pose) -> Pose:
        return pose if time < START else (pose[0], pose[1] + jump, *pose[2:])

    return drive(course=straight(), sense=sense, seconds=20.0)


def believed(jump: float) -> float:
    """How long after a lasting jump its poses are taken [s]."""
    doubted = [time for time, status in jumped(jump).statuses if OUTLIER and OUTLIER in status]
    return max(doubted, default=START - 0.05) + 0.05 - START


def carried() -> float:
    """How long after the car was carried on by a period of the bends its status is ok [s]."""
    car, done = Car(), list[float]()

    def sense(time: float, pose: Pose) -> Pose:
        if time >= START and not done:
            done.append(time)
            car.x += 20.0 * math.pi
            return car.pose()
        return pose

    driven = drive(car=car, sense=sense)
    if driven.largest(START + 5.0) > 0.5:
        return math.inf
    bad = [t for t, s in driven.statuses if t >= START and (OUTLIER in s or s.level == "fault")]
    return max(bad, default=START - 0.05) + 0.05 - START


@functools.cache
def dead_time(periods: Any, told: float = 0.15, true: float = 0.15) -> tuple[float, float]:
    """How far the learnt dead time is from that in equal periods [ms]; the ratio of the errors."""
    car = TOLD.replace(dead_time=told)
    equal = drive(car=Car(dead_time=true), told=car, periods=jitter(0.0, 0.025))
    found = drive(car=Car(dead_time=true), told=car, periods=periods)
    apart = abs(found.estimate.dead_time - equal.estimate.dead_time)
    # Half a millimetre is nothing.
    return 1e3 * apart, max(found.mean() - 5e-4, equal.mean()) / equal.mean()


def gap() -> float:
    calm = drive()
    gapped = drive(periods=lambda k, _: 0.4 if k in (200, 300) else 0.05)
    return 1e3 * abs(calm.estimate.dead_time - gapped.estimate.dead_time)


def against(adapt: Any, make: Callable[[], Car] = Car, **kind: Any) -> float:
    """Mean error through noise, over four seeds, divided by that with another estimation."""

    def mean(**options: Any) -> float:
        usual = {"course": bends(length=520.0), "seconds": 50.0}
        drives = (drive(car=make(), seed=k, **{**usual, **kind, **options}) for k in range(4))
        return statistics.fmean(each.mean() for each in drives)

    return mean() / mean(adapt=adapt)


def untold() -> float:
    """Mean error at 15 m/s with 0.2 s of dead time more than told, in bends that fit [m]."""
    course = bends(length=500.0, stretch=1.875)
    return drive(car=Car(dead_time=0.35), course=course, speed=15.0).mean()


def wander(law: Any) -> float:
    """How far the angle goes in 100 steps at rest beside the path [rad]."""
    steering = law(popsteer.Path(bends()), TOLD)
    steers = [float(steering.step(20.0, 4.5, 0.3, 0.0, 0.05).steer) for _ in range(100)]
    return max(steers) - min(steers)


def stop_and_go(law: Any) -> float:
    return drive(law, speed=lambda t: max(0.0, 10.0 * math.sin(0.4 * t)), seconds=40.0).largest()


def corners(along: float, aside: float) -> Drive:
    return drive(told=GRIP, course=zigzag(along, aside), speed=10.0, seconds=60.0)


@functools.cache
def coarse(seed: int, spacing: int, **shape: Any) -> float:
    """Mean error on a circuit whose waypoints are so far apart, at 5 m/s [m]."""
    fine = circuit(seed)
    path = popsteer.Path(fine[:: 10 * spacing], closed=True, **shape)
    steering, truth = popsteer.PreviewPop(path, TOLD), popsteer.Path(fine, closed=True)
    (x, y), (along, aside) = fine[0], fine[1] - fine[0]
    car = Car(x=x, y=y, yaw=math.atan2(aside, along), speed=5.0)
    errors = []
    while car.time < 60.0:
        car.command(steering.step(*car.pose(), 0.05).steer)
        car.advance(0.05, 5.0)
        errors.append(abs(truth.project(car.x, car.y).cross_track_error))
    return statistics.fmean(errors[100:])


def coarser(**shape: Any) -> float:
    """The largest ratio of the errors with waypoints 5 m and 1 m apart, on three circuits."""
    try:
        return max(coarse(seed, 5, **shape) / coarse(seed, 1) for seed in range(3))
    except TypeError:  # Version 0.3.0 knows no headings.
        return max(coarse(seed, 5) / coarse(seed, 1) for seed in range(3))


def lateral_with_offset(law: Any) -> float:
    """Straight on with an offset of 0.05 rad for 40 s, then 3 m to the side at 20 m/s [m/s^2]."""
    course = np.vstack((straight(800.0), straight(200.0) + np.array((800.0, 3.0))))
    car, found = Car(offset=0.05, dead_time=0.2), [0.0]

    def watch(car: Car) -> dict[str, float]:
        if car.time > 35.0:
            found.append(400.0 * abs(math.tan(car.wheel)) / car.wheelbase)
        return {}

    told = GRIP.replace(dead_time=0.2)
    drive(law, car=car, told=told, course=course, speed=20.0, seconds=46.0, report=watch)
    return max(found)


def reported(name: str) -> float:
    """Error with the wheels' angle reported at each step, divided by that without."""

    def ratio(dead_time: float) -> float:
        told = TOLD.replace(dead_time=dead_time)
        usual: dict[str, Any] = {"told": told, "periods": jitter(0.0, 0.02)}
        car = functools.partial(Car, dead_time=dead_time)
        with_it = drive(car=car(), report=lambda car: {name: car.wheel}, **usual).mean()
        without = drive(car=car(), **usual).mean()
        # Half a millimetre is nothing.
        return max(with_it - 5e-4, without) / without

    return max(map(ratio, (0.0, 0.15)))


def biased() -> float:
    """Mean error with a yaw that is 0.04 rad off, the pose at the rear axle, when it is learnt."""
    there: dict[str, Any] = {"car": Car(centre=0.0), "told": TOLD.replace(rear_axle=0.0)}
    found = drive(
        **there, sense=lambda _, pose: (*pose[:2], pose[2] + 0.04, pose[3]), speed=5.0, seconds=50.0
    )
    return found.mean(30.0)


def learnt(rate: float) -> float:
    """The offset of 0.03 rad at 5 m/s as learnt at so many steps a second [rad]."""
    driven = drive(car=Car(offset=0.03), speed=5.0, periods=jitter(0.0, 1.0 / rate))
    return driven.estimate.steer_offset


def spread() -> float:
    offsets = [learnt(rate) for rate in (20.0, 50.0, 100.0, 200.0)]
    return 100.0 * (max(offsets) / min(offsets) - 1.0)


def changes(law: Any) -> float:
    return flips(10, law)[0]


def part(number: int, case: Callable[..., tuple[float, float]], *of: Any) -> float:
    return case(*of)[number]


ALONE = popsteer.AdaptParams(slip_time=0.0)
FRESH: dict[str, Any] = {"noise": (0.05, 0.01, 0.0), "fresh": True}
LOSS: dict[str, Any] = {"noise": (0.0, 0.01, 0.0), "loss": 0.2, "periods": jitter(0.3)}
LONG: dict[str, Any] = {
    "told": TOLD.replace(wheelbase=6.0, rear_axle=-3.0),
    "course": bends(length=520.0, stretch=2.0),
    "speed": 10.0,
    "noise": (0.02, 0.0, 0.0),
    "waypoint_noise": 0.02,
    "fresh": True,
}
PERIODS = {
    "20 and 30 ms in turn": alternating(0.02, 0.03),
    "jitter of 5 %": jitter(0.05),
    "jitter of 50 %": jitter(0.5),
}
GLITCHES = {
    "one pose 2 m to the side": ((START,), 2.0, 0.0),
    "one yaw 0.3 rad off": ((START,), 0.0, 0.3),
    "three poses in a row 2 m to the side": ((START, START + 0.05, START + 0.1), 2.0, 0.0),
}

CASES = [
    Case(
        "pose frozen for 0.5 s: more error than without",
        *(0.15, "{:.2f} m"),
        lambda: max(
            short.largest() - drive(course=course, fresh=True).largest()
            for short, course in zip(frozen(0.5), (bends(), straight()), strict=True)
        ),
    ),
    Case("... faults", 0, "{:.0f} steps", lambda: sum(map(faults, frozen(0.5)))),
    Case(
        "pose frozen for 3 s: a fault after",
        *(1.0, "{:.2f} s"),
        lambda: max(after_fault(each)[0] for each in frozen(3.0)),
    ),
    Case(
        "... the car is off by then",
        *(0.5, "{:.2f} m"),
        lambda: max(after_fault(each)[1] for each in frozen(3.0)),
    ),
    Case(
        "x, y frozen, yaw and speed alive: a fault before 0.5 m",
        *(CARS, f"{{:.0f}} of {CARS} cars", frozen_position, True),
    ),
    *(
        Case(
            f"speed signal {what}: a fault within 1 s or before 0.5 m",
            *(6, "{:.0f} of 6 drives", partial(wrong_speed, factor), True),
        )
        for what, factor in (("zero", 0.0), ("halved", 0.5), ("of the wrong sign", -1.0))
    ),
    Case("path that jumps 12 m to the side: a fault after", 2, "{:.0f} steps", path_jumps),
    *(
        case
        for what, kind in GLITCHES.items()
        for case in (
            Case(f"{what}: faults", 0, "{:.0f} steps", partial(part, 0, glitch, *kind)),
            Case("... the angle changes by", 1.0, "{:.2f} mrad", partial(part, 1, glitch, *kind)),
        )
    ),
    Case(
        "1 % of the poses off by up to 5 m, 1 rad: faults",
        *(0, "{:.0f} steps", lambda: faults(sometimes())),
    ),
    Case("... largest error in that, with noise", 0.15, "{:.2f} m", lambda: sometimes().largest()),
    Case("jump of 0.5 m that lasts: believed after", 0.3, "{:.2f} s", lambda: believed(0.5)),
    Case("jump of 5 m that lasts: believed after", 1.0, "{:.2f} s", lambda: believed(5.0)),
    Case("car carried on by 63 m: found after", 1.0, "{:.2f} s", carried),
    *(
        case
        for what, kind in PERIODS.items()
        for told, true in ((0.15, 0.15), (0.2, 0.1))
        for case in (
            Case(
                f"{what}, dead time {told} s told, {true} true: learnt off by",
                *(10, "{:.0f} ms", partial(part, 0, dead_time, kind, told, true)),
            ),
            Case(
                "... error against equal periods",
                *(1.2, "{:.2f} times", partial(part, 1, dead_time, kind, told, true)),
            ),
        )
    ),
    Case("gap of 0.4 s in a bend: moves the dead time by", 5, "{:.1f} ms", gap),
    *(
        Case(
            f"fresh paths with {by} cm, poses with 5 cm, 0.01 rad: error by that of `slip_time=0`",
            *(1.2, "{:.2f} times"),
            partial(against, ALONE, waypoint_noise=0.01 * by, **FRESH),
        )
        for by in (1, 2, 3)
    ),
    Case(
        "a truck, both with 2 cm: error by that of `slip_time=0`",
        *(1.2, "{:.2f} times"),
        lambda: against(ALONE, lambda: Car(wheelbase=6.0, centre=3.0), **LONG),
    ),
    Case(
        "yaw noise, 20 % lost, jitter: error by that of `adapt=None`",
        *(1.1, "{:.2f} times", lambda: against(None, **LOSS)),
    ),
    Case("0.2 s more dead time than told, 15 m/s: mean error", 0.1, "{:.3f} m", untold),
    *(
        Case(
            f"at rest beside the path, {name}: wheels wander by",
            *(0, "{:.2f} rad", partial(wander, law)),
        )
        for name, law in LAWS.items()
    ),
    *(
        Case(
            f"stop and go in bends of 25 m, {name}: largest error",
            *(0.35, "{:.2f} m", partial(stop_and_go, law)),
        )
        for name, law in LAWS.items()
        if name != "POP"
    ),
    Case(
        "zigzag of 50 by 30 m: largest error",
        *(3.5, "{:.2f} m", lambda: corners(50.0, 30.0).largest(0.0)),
    ),
    Case(
        "zigzag of 30 by 10 m: mean error",
        *(0.42, "{:.2f} m", lambda: corners(30.0, 10.0).mean(0.0)),
    ),
    Case(
        'waypoints 5 m apart, `yaw="spline"`: error by that 1 m apart',
        *(2.0, "{:.1f} times", partial(coarser, yaw="spline")),
    ),
    *(
        Case(
            f"offset of 0.05 rad, limit of 4 m/s², {name}: lateral acceleration",
            *(4.2, "{:.2f} m/s²", partial(lateral_with_offset, law)),
        )
        for name, law in LAWS.items()
    ),
    *(
        Case(
            f"path there and back sent every 0.5 s, {name}: changes of direction",
            *(1, "{:.0f}", partial(changes, law)),
        )
        for name, law in LAWS.items()
        if name != "POP"
    ),
    Case(
        "the wheels' angle reported: error by that without",
        *(1.1, "{:.2f} times", lambda: reported("measured_steer")),
    ),
    Case("yaw 0.04 rad off, 5 m/s: mean error when it is learnt", 0.01, "{:.3f} m", biased),
    Case("offset learnt at 20 to 200 Hz: differs by", 10, "{:.0f} %", spread),
]
