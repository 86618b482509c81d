from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import Vehicle, controllers, presets, vehicles
from popsteer.errors import ConfigError
from popsteer.lab import stability
from popsteer.lab.stability import margins
from popsteer.lab.stability.linear import LinearLaw, linearised, lookahead
from popsteer.lab.stability.loop import Loop, respond
from studies.chain import Chain
from tests.helpers import looped

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

SMALL = 1e-3  # errors [m, rad]
PATH = popsteer.Path(np.column_stack((np.arange(200.0), np.zeros(200))))
CAR = Vehicle(wheelbase=2.7, max_lateral_acceleration=None)

# Preview POP of another vehicle, and with a step of the prediction that is longer than the control
# period.
_Other = tuple[dict[str, float], dict[str, float]]
OTHERS: dict[str, _Other] = {
    "no-lag": ({}, {"steer_lag": 0.0}),
    "vehicle": ({"horizon": 2.7}, {"turning_wheelbase": 3.4, "understeer": 2e-3}),
    "point": ({"horizon": 0.4}, {"rear_axle": -1.3, "no_slip_point": -0.2}),
    "slow wheels": ({}, {"max_steer_rate": 0.3}),
}
ANSWERS: list[tuple[str, _Other]] = [
    *((name, ({}, {})) for name in controllers.names()),
    *(("preview-pop", other) for other in OTHERS.values()),
]


@pytest.mark.parametrize(("name", "other"), ANSWERS, ids=[*controllers.names(), *OTHERS])
@pytest.mark.parametrize("speed", [3.0, 12.0])
def test_linearised_controller_answers_small_errors_as_the_controller_does(
    name: str, other: _Other, speed: float
) -> None:
    tuning, given = other
    params, vehicle = presets.get(name, "default").replace(**tuning), CAR.replace(**given)
    if name == "pop":
        params = params.replace(candidate_count=100_001)
    weights = linearised(params, vehicle, speed, 0.05)
    rng = np.random.default_rng(7)
    make: Callable[..., controllers.Controller] = controllers.get(name).controller
    law = make(PATH, vehicle, params, adapt=None, monitor=None)  # every pose is believed
    # PID's first step has no derivative, and nothing is estimated from it.
    offsets = np.concatenate(([0.0], rng.uniform(-SMALL, SMALL, 8)))
    headings = np.concatenate(([0.0], rng.uniform(-SMALL, SMALL, 8)))
    seen = offsets + weights.tracked_point * headings
    answers: list[float] = []
    for k in range(len(seen)):
        x = 20.0 + k * speed * 0.05
        answers.append(law.steer(x, float(offsets[k]), float(headings[k]), speed, 0.05))
        wanted = -_weighed(weights.cross_track, seen[: k + 1])
        wanted -= _weighed(weights.heading, headings[: k + 1])
        wanted -= _weighed(weights.steer[1:], np.array(answers[:-1]))
        assert answers[-1] == pytest.approx(wanted, rel=3e-3, abs=3e-3 * SMALL)


@pytest.mark.parametrize("name", ["pure-pursuit", "stanley", "pop", "preview-pop"])
@pytest.mark.parametrize("dead_time", [0.02, 0.17])
def test_loop_of_a_controller_that_predicts_answers_as_the_controller_does(
    name: str, dead_time: float
) -> None:
    """The answers to a sine of the offset, alone in the open."""
    vehicle = CAR.replace(dead_time=dead_time, rear_axle=-0.4)
    params = presets.get(name, "default")
    if name == "pop":
        params = params.replace(candidate_count=100_001)
    make: Callable[..., controllers.Controller] = controllers.get(name).controller
    law = make(PATH, vehicle, params, adapt=None, monitor=None)  # every pose is believed
    speed, dt, period, steps = 8.0, 0.05, 40, 400
    loop = Loop(linearised(params, vehicle, speed, dt), vehicle, speed, dt)
    at = 2.0 * math.pi / period
    offsets = 5e-3 * np.sin(at * np.arange(steps))
    answers = [
        law.steer(20.0 + k * speed * dt, float(offset), 0.0, speed, dt)
        for k, offset in enumerate(offsets)
    ]
    phases = np.exp(-1j * at * np.arange(steps - period, steps))
    driven = (np.array(answers[-period:]) @ phases) / (offsets[-period:] @ phases)
    index = int(np.argmin(np.abs(loop.angles - at)))
    computed = -(loop._cross_track / loop._steer)[index]
    assert driven == pytest.approx(computed, rel=3e-3)


def _weighed(weights: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Sum of the values, the latest with the first weight."""
    used = min(len(weights), len(values))
    return float(weights[:used] @ values[::-1][:used])


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("speed", [4.0, 14.0])
def test_gain_margin_is_the_factor_at_which_the_loop_turns_unstable(
    name: str, speed: float
) -> None:
    vehicle = Vehicle(dead_time=0.01)
    params, given = presets.get(name, "default"), Vehicle()
    law = linearised(params, given, speed, 0.05)
    margin = margins(params, vehicle, speed, believed=given).gain
    assert margin > 1.0
    for factor, stable in ((0.999, True), (1.001, False)):
        scale = factor * margin
        scaled = law._replace(cross_track=scale * law.cross_track, heading=scale * law.heading)
        assert Loop(scaled, vehicle, speed, 0.05, believed=given).is_stable() is stable


@pytest.mark.parametrize("name", controllers.names())
def test_phase_margin_turns_the_response_onto_minus_one(name: str) -> None:
    vehicle = Vehicle()
    params = presets.get(name, "default")
    found = margins(params, vehicle, 10.0)
    response = Loop(linearised(params, vehicle, 10.0, 0.05), vehicle, 10.0, 0.05).gain()
    turned = response * np.exp(-1j * found.phase)
    assert np.abs(1.0 + turned).min() < 5e-3
    for less in (0.5, 0.9):
        assert np.abs(1.0 + response * np.exp(-1j * less * found.phase)).min() > 0.05


def test_open_loop_of_a_slow_frequency_is_the_continuous_one() -> None:
    # Stanley's at v = 10 and ω = 0.2: v / (s² (1 + τ s)) / L · (s + (s + v / a) ...) by hand.
    vehicle = Vehicle(steer_lag=0.1, dead_time=0.12)
    law = linearised(popsteer.StanleyParams(), Vehicle(), 10.0, 0.05)
    loop = Loop(law, vehicle, 10.0, 0.05, believed=Vehicle())
    at = int(np.argmin(np.abs(loop.angles - 0.2 * 0.05)))
    s = 1j * loop.angles[at] / 0.05
    yaw = 10.0 / 3.0 / (s * (1.0 + 0.1 * s))
    pull = 1.5 / (1.0 + 1.3 * 10.0)
    continuous = (yaw + pull * (10.0 * yaw / s + 3.0 * yaw)) * np.exp(-s * (0.12 + 0.025))
    assert loop.gain()[at] == pytest.approx(continuous, rel=1e-4)


@pytest.mark.parametrize("name", controllers.names())
@pytest.mark.parametrize("dead_time", [0.1, 0.15])
def test_poles_of_a_controller_that_predicts_are_those_without_a_dead_time(
    name: str, dead_time: float
) -> None:
    """With the right chain the prediction is exact, so what is controlled has no dead time."""
    free, late = Vehicle(), Vehicle(dead_time=dead_time)
    law = linearised(presets.get(name, "default"), free, 10.0, 0.05)
    prompt, predicting = Loop(law, free, 10.0, 0.05), Loop(law, late, 10.0, 0.05)
    without, through = (loop._steer * (1.0 + loop.gain()) for loop in (prompt, predicting))
    # The steps of the prediction are up to 50 ms long, which fast signals see.
    assert np.abs(through / without - 1.0)[prompt.angles < 1.0].max() < 0.05


def test_margins_fall_with_lag_and_with_speed() -> None:
    pop = popsteer.PopParams()
    by_lag = [margins(pop, Vehicle(steer_lag=lag), 10.0).dead_time for lag in (0.0, 0.1, 0.3)]
    by_speed = [margins(pop, Vehicle(), speed).dead_time for speed in (5.0, 10.0, 20.0)]
    assert by_lag == sorted(by_lag, reverse=True)
    assert by_speed == sorted(by_speed, reverse=True)


@pytest.mark.parametrize("name", controllers.names())
def test_margins_do_not_depend_on_where_the_pose_is_measured(name: str) -> None:
    rear = Vehicle(dead_time=0.07)
    for ahead in (1.3, -2.0):
        elsewhere = rear.replace(rear_axle=-ahead)
        params = presets.get(name, "default")
        assert margins(params, elsewhere, 9.0) == pytest.approx(margins(params, rear, 9.0))


@pytest.mark.parametrize("name", controllers.names())
def test_tracked_point_is_that_of_the_controller(name: str) -> None:
    for vehicle in (Vehicle(rear_axle=-1.2), vehicles.get("carla-identified")):
        make: Callable[..., controllers.Controller] = controllers.get(name).controller
        params = presets.get(name, "default")
        tracked = make(PATH, vehicle, params).tracked_point
        assert linearised(params, vehicle, 10.0, 0.05).tracked_point == tracked


def test_map_of_dead_times_has_the_margins_of_its_cells_for_what_is_believed() -> None:
    params, late = popsteer.PopParams(), Vehicle(dead_time=0.05)
    found = stability.dead_time_map(params, late, [6.0, 10.0], [8.0, 12.0], believed=Vehicle())
    told = stability.dead_time_map(params, late, [6.0, 10.0], [8.0, 12.0])
    for (row, column), value in np.ndenumerate(found):
        fixed = params.replace(lookahead_gain=0.0, min_lookahead=(8.0, 12.0)[row])
        speed = (6.0, 10.0)[column]
        wanted = margins(fixed, late, speed, believed=Vehicle()).dead_time
        assert value == pytest.approx(wanted, abs=1e-3)
        assert value < told[row, column] - 0.01


@looped(
    ("law", "params"),
    [
        (popsteer.Stanley, popsteer.StanleyParams()),
        (popsteer.PurePursuit, popsteer.PurePursuitParams()),
        (popsteer.PreviewPop, popsteer.PreviewPopParams()),
    ],
)
@looped("dead_time", [0.0, 0.12])
def test_answer_to_a_step_is_that_of_a_driven_vehicle(
    law: Any, params: Any, dead_time: float
) -> None:
    car = Vehicle(steer_lag=0.1, dead_time=dead_time, max_lateral_acceleration=None)
    found = respond(params, car, 10.0)
    path, aside = popsteer.Path([(float(x), 0.0) for x in range(121)]), 1e-3
    controller, chain = (
        law(path, car, params, adapt=None),
        Chain(car, (20.0, -aside, 0.0), 10.0, 0.05),
    )
    driven = []
    for _ in found.time:
        driven.append(1.0 + chain.y / aside)
        chain.advance(controller.steer(*chain.pose, 10.0, 0.05))
    assert found.offset == pytest.approx(np.array(driven), abs=0.005)
    assert 0.9 < found.offset[-1] < 1.1


def test_margins_are_where_the_answers_to_frequencies_cross() -> None:
    car = Vehicle(steer_lag=0.1)
    for name in ("pop", "stanley", "pure-pursuit", "preview-pop"):
        params = presets.get(name, "default")
        found, wanted = respond(params, car, 12.0), margins(params, car, 12.0)
        gains, phases = found.crossings()
        least = min((value + math.pi) % math.tau for _, value in gains)
        assert least == pytest.approx(wanted.phase, rel=1e-3), name
        below = [1.0 / gain for _, gain in phases if gain < 1.0]
        assert min(below) == pytest.approx(wanted.gain, rel=5e-3), name
    # An unstable loop has no answer to a step.
    late = respond(popsteer.PidParams(), Vehicle(dead_time=0.4), 20.0, believed=Vehicle())
    assert np.isnan(late.offset).all()


def test_stability_sets_controllers_beside_speeds() -> None:
    result = stability.run(["stanley", "pop"], Vehicle(), [5.0, 10.0])
    assert {name: len(rows) for name, rows in result.margins.items()} == {"stanley": 2, "pop": 2}
    assert result.margins["pop"][1] == margins(popsteer.PopParams(), Vehicle(), 10.0)
    own = stability.run({"pop": popsteer.PopParams(min_lookahead=20.0)})
    assert own.margins["pop"][2].dead_time > result.margins["pop"][1].dead_time
    late = stability.run(["pop"], Vehicle(dead_time=0.1), [10.0], believed=Vehicle())
    assert late.believed == Vehicle()
    # By default no speed that the vehicle does not reach.
    for top, speeds in (
        (3.0, (2.0, 3.0)),
        (1.0, (1.0,)),
        (None, (2.0, 5.0, 10.0, 15.0, 20.0, 25.0)),
    ):
        assert stability.run(["stanley"], Vehicle(max_speed=top)).speeds == speeds
    assert late.margins["pop"][0].dead_time < result.margins["pop"][1].dead_time


def test_lookahead_is_that_of_the_law() -> None:
    car = Vehicle()
    assert lookahead(popsteer.PopParams(min_lookahead=4.0, lookahead_gain=0.5), car, 10.0) == 9.0
    assert lookahead(popsteer.PopParams(), Vehicle(wheelbase=0.3), 2.0) == 1.0
    assert lookahead(popsteer.PurePursuitParams(), car, 5.0) == 10.0
    assert lookahead(popsteer.StanleyParams(), car, 5.0) is None


def test_margins_of_a_loop_that_does_not_move_are_refused() -> None:
    with pytest.raises(ConfigError, match="speed must be in"):
        stability.run(["pop"], speeds=[0.0])
    with pytest.raises(ConfigError, match="lookahead must be positive"):
        stability.run({"pop": popsteer.PopParams(min_lookahead=0.0, lookahead_gain=0.0)})


def test_loop_is_stable_where_its_poles_lie_inside_the_circle() -> None:
    # A law that remembers its last angle, also one that winds up by itself: the product of the
    # poles is the share that it keeps, so with more than all of it no loop is stable.
    vehicle, speed, dt = Vehicle(steer_lag=0.0), 8.0, 0.05
    turning = speed / vehicle.wheelbase
    rng = np.random.default_rng(3)
    given = []
    for pull, turn, kept in rng.uniform((-0.1, -0.5, -1.2), (0.4, 3.0, 1.2), (200, 3)):
        law = LinearLaw(3.0, np.array([pull]), np.array([turn]), np.array([1.0, -kept]))
        answer = np.array([-pull, -(3.0 * pull + turn), kept])  # to e₀, ψ and the last angle
        moved = np.array([0.5 * speed * turning * dt * dt, turning * dt, 0.0])
        matrix = np.outer(moved, answer) + np.array([[1, speed * dt, 0], [0, 1, 0], [0, 0, 0]])
        matrix[2] = answer
        largest = np.abs(np.linalg.eigvals(matrix)).max()
        if abs(largest - 1.0) > 1e-3:
            assert Loop(law, vehicle, speed, dt).is_stable() is bool(largest < 1.0)
            given.append((abs(kept) > 1.0, bool(largest < 1.0)))
    assert set(given) == {(True, False), (False, True), (False, False)}


def test_offset_that_is_driven_on_a_circle_is_the_computed_one() -> None:
    from studies.carrot import carrot_offset, driven_offset

    for radius, speed in ((30.0, 8.0), (50.0, 10.0)):
        offset, distance = driven_offset(radius, "kinematic-bicycle", speed)
        assert distance == pytest.approx(6.0 + 0.2 * speed, abs=0.01)
        computed = carrot_offset(distance, radius, vehicles.get("kinematic-bicycle"), speed)
        assert offset == pytest.approx(computed, abs=0.02)
