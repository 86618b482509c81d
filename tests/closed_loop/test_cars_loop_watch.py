"""What a controller says of a vehicle that answers otherwise than it was told, in a car's loop.

The simulator is `Chain`, apart from the library's own: a car of 2.7 m whose pose is measured at the
centre, in S-bends of 25 m radius at 8 m/s.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import MonitorParams, Status, controllers, sim
from studies.chain import Chain
from tests.closed_loop.paths import track
from tests.closed_loop.test_run_planned import bends

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from popsteer.controllers import Controller

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    steer_lag=0.15,
    dead_time=0.15,
    max_steer_rate=0.4,
    max_steer=0.6,
)
PROMPT = CAR.replace(dead_time=0.0)
SPEED, DT = 8.0, 0.05
NAMES = controllers.names()
BENDS = bends(25.0, 10.0, 0.5)

each_law = pytest.mark.parametrize("name", NAMES)


class Moment(NamedTuple):
    """A step of the loop."""

    time: float
    command: popsteer.Command
    error: float
    """How far the centre is off the path [m]."""


def loop(
    controller: Controller,
    car: popsteer.Vehicle,
    spoil: Callable[[Chain, float], float] | None = None,
    *,
    duration: float = 20.0,
    speed: float = SPEED,
    noise: float = 0.0,
    jump: float = 0.0,
) -> Iterator[Moment]:
    """Drive from the start of the path; `spoil` changes the chain and the command that it gets."""
    chain = Chain(car, (-car.rear_axle, 0.0, 0.0), speed, DT, substeps=50)
    random = np.random.default_rng(7)
    for k in range(round(duration / DT)):
        x, y, yaw = chain.pose
        y += jump if k * DT >= 5.0 else 0.0
        command = controller.step(x, y, yaw + noise * random.standard_normal(), speed, DT)
        yield Moment(k * DT, command, abs(controller.path.project(x, y).cross_track_error))
        chain.advance(command.steer if spoil is None else spoil(chain, command.steer))


def stuck(angle: float) -> Callable[[Chain, float], float]:
    def hold(chain: Chain, _command: float) -> float:
        chain.wheel = angle
        chain.commands = [angle] * len(chain.commands)
        return angle

    return hold


def inverted(_chain: Chain, command: float) -> float:
    return -command


FAULTS = {"sign": inverted, "stuck at 0": stuck(0.0), "stuck at 10": stuck(math.radians(10.0))}


def first(condition: Status, moments: Iterator[Moment]) -> Moment | None:
    return next((each for each in moments if condition in each.command.status), None)


@pytest.mark.parametrize("given", [CAR, PROMPT], ids=["dead-time", "prompt"])
@pytest.mark.parametrize("fault", FAULTS)
@each_law
def test_vehicle_that_does_not_obey_is_implausible_within_half_a_metre(
    name: str, fault: str, given: popsteer.Vehicle
) -> None:
    controller = controllers.get(name).controller(BENDS, given)
    found = first(Status.IMPLAUSIBLE, loop(controller, given, FAULTS[fault]))
    assert found is not None
    assert found.error <= 0.5
    assert found.command.status.level == "fault"


@pytest.mark.parametrize("noise", [0.002, 0.005])
@pytest.mark.parametrize("fault", FAULTS)
@each_law
def test_vehicle_that_does_not_obey_is_implausible_in_noise_too(
    name: str, fault: str, noise: float
) -> None:
    controller = controllers.get(name).controller(BENDS, CAR)
    found = first(Status.IMPLAUSIBLE, loop(controller, CAR, FAULTS[fault], noise=noise))
    assert found is not None
    assert found.error <= 1.0


@each_law
def test_dead_time_that_nobody_told_is_reported_before_two_metres(name: str) -> None:
    controller = controllers.get(name).controller(BENDS, PROMPT)
    for moment in loop(controller, CAR.replace(dead_time=0.3)):
        if moment.command.status.level == "fault":
            return
        error = max(abs(moment.command.cross_track_error), moment.error)
        assert error <= 2.0
    # What never comes off the path needs no report.


@pytest.mark.parametrize("given", [CAR, PROMPT], ids=["dead-time", "prompt"])
@pytest.mark.parametrize("wrong", [0.5, 1.5, 2.0])
@each_law
def test_wheelbase_that_is_wrong_by_a_half_is_no_alarm(
    name: str, wrong: float, given: popsteer.Vehicle
) -> None:
    believed = given.replace(turning_wheelbase=wrong * given.wheelbase)
    controller = controllers.get(name).controller(BENDS, believed)
    for moment in loop(controller, given, duration=13.0):
        assert Status.IMPLAUSIBLE not in moment.command.status
    if given.dead_time or name == "preview-pop":
        # 10 s of bends, after 20 m straight on. The others estimate only what is in flight.
        assert controller.estimate.gain == pytest.approx(wrong, rel=0.05)


@each_law
def test_steering_offset_that_nobody_told_is_no_alarm(name: str) -> None:
    for degrees, noise in ((1.0, 0.0), (-1.5, 0.0), (3.0, 0.0), (-4.0, 0.0), (4.0, 0.01)):
        controller = controllers.get(name).controller(BENDS, CAR)
        crooked = CAR.replace(steer_offset=math.radians(degrees))
        found = first(Status.IMPLAUSIBLE, loop(controller, crooked, noise=noise))
        assert found is None, (degrees, noise, found)


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@each_law
def test_right_vehicle_is_never_implausible(name: str, noise: float) -> None:
    controller = controllers.get(name).controller(BENDS, CAR)
    assert first(Status.IMPLAUSIBLE, loop(controller, CAR, noise=noise)) is None


@each_law
def test_deviating_is_what_is_beyond_the_limit_once_it_was_within(name: str) -> None:
    limit = MonitorParams(deviation_limit=0.3)
    far, near = CAR.replace(rear_axle=-1.35), 0
    controller = controllers.get(name).controller(BENDS, far, monitor=limit)
    within = False
    for moment in loop(controller, far, duration=12.0, jump=0.8):
        error = abs(moment.command.cross_track_error)
        within |= error <= 0.3
        # A jump of 0.8 m is noise of 6 cm, 5 times which may be noise beyond the limit.
        noise = controller.state.gate.position.variance**0.5
        assert noise <= 0.065
        deviates = within and error > 0.3 + 5.0 * noise
        assert (Status.DEVIATING in moment.command.status) == deviates
        near += deviates
    assert near > 0


@each_law
def test_vehicle_that_comes_from_beside_is_not_deviating(name: str) -> None:
    straight = popsteer.Path([(0.0, 0.0), (300.0, 0.0)])
    controller = controllers.get(name).controller(straight, CAR)
    chain = Chain(CAR, (1.35, 4.0, 0.0), SPEED, DT)
    for _ in range(300):
        command = controller.step(*chain.pose, SPEED, DT)
        assert Status.IMPLAUSIBLE not in command.status
        if abs(command.cross_track_error) > 1.35:
            assert Status.DEVIATING not in command.status
        chain.advance(command.steer)


@each_law
def test_alarm_ends_two_seconds_after_the_vehicle_obeys_again(name: str) -> None:
    straight = popsteer.Path([(0.0, 0.0), (400.0, 0.0)])
    controller = controllers.get(name).controller(straight, CAR)
    chain = Chain(CAR, (1.35, 0.0, 0.0), SPEED, DT)
    said = []
    for k in range(200):
        command = controller.step(*chain.pose, SPEED, DT)
        said.append(Status.IMPLAUSIBLE in command.status)
        if 40 <= k < 50:
            stuck(math.radians(10.0))(chain, 0.0)
        chain.advance(command.steer)
    assert not any(said[:41])
    assert any(said[40:60])
    assert not any(said[150:])
    # It holds without a break.
    assert np.count_nonzero(np.diff(np.array(said, dtype=int))) == 2


@pytest.mark.parametrize("what", ["held", "gap", "relocalise", "reset"])
def test_nothing_is_concluded_across_an_interruption(what: str) -> None:
    """The car was turned by half a radian while nobody looked."""
    straight = popsteer.Path([(0.0, 0.0), (400.0, 0.0)])
    controller = popsteer.PreviewPop(straight, CAR)
    chain = Chain(CAR, (1.35, 0.0, 0.0), SPEED, DT)
    for k in range(100):
        x, y, yaw = chain.pose
        if k == 50:
            chain.yaw += 0.5
            x, y, yaw = chain.pose
            if what == "held":
                for _ in range(6):
                    controller.step_or_hold(math.nan, y, yaw, SPEED, DT)
            elif what == "relocalise":
                controller.relocalise(x, y, yaw)
            elif what == "reset":
                controller.reset()
        dt = 0.5 if (k, what) == (50, "gap") else DT
        command = controller.step(x, y, yaw, SPEED, dt)
        assert Status.IMPLAUSIBLE not in command.status
        chain.advance(command.steer)


def test_a_yaw_that_jumps_is_an_outlier_and_believed_where_it_lasts() -> None:
    straight = popsteer.Path([(0.0, 0.0), (400.0, 0.0)])
    controller = popsteer.PreviewPop(straight, CAR)
    chain = Chain(CAR, (1.35, 0.0, 0.0), SPEED, DT)
    for k in range(70):
        if k == 50:
            chain.yaw += 0.5
        command = controller.step(*chain.pose, SPEED, DT)
        assert Status.IMPLAUSIBLE not in command.status
        if not 50 < k < 62:
            assert (Status.OUTLIER in command.status) == (k == 50)
        chain.advance(command.steer)


@pytest.mark.parametrize("plant", ["carla-identified", "kinematic-bicycle"])
@each_law
def test_noisy_laps_of_a_right_vehicle_are_never_implausible(name: str, plant: Any) -> None:
    controller = controllers.get(name).controller(track("racetrack"))
    noise = sim.Noise(position=0.1, yaw=0.005, speed=0.05)
    found = sim.run_many([controller] * 5, plant, noise=noise, seed=11)
    assert not (found["faults"] & Status.IMPLAUSIBLE).any()
    kept = found["max_abs_cross_track_error"] < 0.5 * 3.0 - 0.5
    assert not (found["faults"][kept] & Status.DEVIATING).any()


def test_monitor_of_none_says_nothing() -> None:
    controller = popsteer.Stanley(BENDS, CAR, monitor=None)
    assert controller.monitor is None
    for moment in loop(controller, CAR, inverted, duration=5.0):
        assert moment.command.status.level != "fault"
    assert controller.state.monitor is None
