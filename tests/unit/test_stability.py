from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import laws, presets
from popsteer.errors import ConfigError
from popsteer.study import LINEAR_LAWS, Vehicle, margins, stability
from popsteer.study.linear import LinearLaw, Loop, linearised, lookahead

if TYPE_CHECKING:
    from numpy.typing import NDArray

SMALL = 1e-3  # errors [m, rad]
PATH = popsteer.Path(np.column_stack((np.arange(200.0), np.zeros(200))))


def _fitted(name: str, vehicle: Vehicle) -> laws.Params:
    return vehicle.fitted(presets.get(name, "default"))


# Preview POP with another model than the vehicle's, learning, and with a step that is longer than
# the control period; the bounds of what is learnt are far beyond the errors below.
OTHERS = {
    "learning": {"turn_learning_time": 0.4, "slip_learning_time": 0.02},
    "no-lag": {"steer_lag": 0.0, "turn_learning_time": 0.3},
    "model": {"wheelbase": 3.4, "understeer": 2e-3, "reference_offset": 1.3, "horizon": 2.7},
    "model-learning": {"reference_offset": -1.1, "slip_learning_time": 0.5, "horizon": 0.4},
}
ANSWERS = [
    *((name, {}) for name in LINEAR_LAWS),
    *(("preview-pop", change) for change in OTHERS.values()),
]


@pytest.mark.parametrize(("name", "changes"), ANSWERS, ids=[*LINEAR_LAWS, *OTHERS])
@pytest.mark.parametrize("speed", [3.0, 12.0])
def test_linearised_law_answers_small_errors_as_the_law_does(
    name: str, changes: dict[str, float], speed: float
) -> None:
    params = _fitted(name, Vehicle(wheelbase=2.7)).replace(**changes)
    if name == "pop":
        params = params.replace(candidate_count=100_001)
    weights = linearised(params, speed, 0.05)
    rng = np.random.default_rng(7)
    law = laws.get(name).controller(PATH, params)  # type: ignore[arg-type]
    # PID's first step has no derivative, and nothing is learnt from it.
    offsets = np.concatenate(([0.0], rng.uniform(-SMALL, SMALL, 8)))
    headings = np.concatenate(([0.0], rng.uniform(-SMALL, SMALL, 8)))
    seen = offsets + weights.offset * headings
    answers: list[float] = []
    for k in range(len(seen)):
        x = 20.0 + k * speed * 0.05
        answers.append(law.steer(x, float(offsets[k]), float(headings[k]), speed, 0.05))
        wanted = -_weighed(weights.cross_track, seen[: k + 1])
        wanted -= _weighed(weights.heading, headings[: k + 1])
        wanted -= _weighed(weights.steer[1:], np.array(answers[:-1]))
        assert answers[-1] == pytest.approx(wanted, rel=3e-3, abs=3e-3 * SMALL)


def _weighed(weights: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Sum of the values, the latest with the first weight."""
    used = min(len(weights), len(values))
    return float(weights[:used] @ values[::-1][:used])


@pytest.mark.parametrize("name", LINEAR_LAWS)
@pytest.mark.parametrize("speed", [4.0, 14.0])
def test_gain_margin_is_the_factor_at_which_the_loop_turns_unstable(
    name: str, speed: float
) -> None:
    vehicle = Vehicle(dead_time=0.01)
    params = _fitted(name, vehicle)
    law = linearised(params, speed, 0.05)
    margin = margins(params, vehicle, speed).gain
    assert margin > 1.0
    for factor, stable in ((0.999, True), (1.001, False)):
        scale = factor * margin
        scaled = law._replace(cross_track=scale * law.cross_track, heading=scale * law.heading)
        assert Loop(scaled, vehicle, speed, 0.05).is_stable() is stable


@pytest.mark.parametrize("name", LINEAR_LAWS)
def test_phase_margin_turns_the_response_onto_minus_one(name: str) -> None:
    vehicle = Vehicle()
    params = _fitted(name, vehicle)
    found = margins(params, vehicle, 10.0)
    response = Loop(linearised(params, 10.0, 0.05), vehicle, 10.0, 0.05).gain()
    turned = response * np.exp(-1j * found.phase)
    assert np.abs(1.0 + turned).min() < 5e-3
    for less in (0.5, 0.9):
        assert np.abs(1.0 + response * np.exp(-1j * less * found.phase)).min() > 0.05


def test_open_loop_of_a_slow_frequency_is_the_continuous_one() -> None:
    # Stanley's at v = 10 and ω = 0.2: v / (s² (1 + τ s)) / L · (s + (s + v / a) ...) by hand.
    vehicle = Vehicle(lag=0.1, dead_time=0.12)
    params = _fitted("stanley", vehicle)
    loop = Loop(linearised(params, 10.0, 0.05), vehicle, 10.0, 0.05)
    at = int(np.argmin(np.abs(loop.angles - 0.2 * 0.05)))
    s = 1j * loop.angles[at] / 0.05
    yaw = 10.0 / 3.0 / (s * (1.0 + 0.1 * s))
    pull = 1.5 / (1e-5 + 1.3 * 10.0)
    continuous = (yaw + pull * (10.0 * yaw / s + 3.0 * yaw)) * np.exp(-s * (0.12 + 0.025))
    assert loop.gain()[at] == pytest.approx(continuous, rel=1e-4)


def test_margins_fall_with_lag_and_with_speed() -> None:
    params = _fitted("pop", Vehicle())
    by_lag = [margins(params, Vehicle(lag=lag), 10.0).dead_time for lag in (0.0, 0.1, 0.3)]
    by_speed = [margins(params, Vehicle(), speed).dead_time for speed in (5.0, 10.0, 20.0)]
    assert by_lag == sorted(by_lag, reverse=True)
    assert by_speed == sorted(by_speed, reverse=True)


def test_vehicle_of_the_identified_plant_turns_as_it_does() -> None:
    vehicle = Vehicle.of("carla-identified", dead_time=0.2)
    assert (vehicle.wheelbase, vehicle.understeer, vehicle.lag) == (3.553, 2.9e-4, 0.1)
    assert (vehicle.axle("front"), vehicle.axle("rear")) == (1.06, -1.94)
    assert vehicle.dead_time == 0.2
    plant = popsteer.sim.KinematicBicycle(wheelbase=2.0)
    assert Vehicle.of(plant) == Vehicle(wheelbase=2.0, lag=0.0)


def test_vehicle_gives_the_laws_its_axles() -> None:
    vehicle = Vehicle.of("carla-identified")
    for name in LINEAR_LAWS:
        theirs = popsteer.sim.fitted(presets.get(name, "default"), "carla-identified")
        assert vehicle.fitted(presets.get(name, "default")) == theirs


def test_stability_sets_laws_beside_speeds() -> None:
    result = stability(["stanley", "pop"], Vehicle(), [5.0, 10.0])
    assert {name: len(rows) for name, rows in result.margins.items()} == {"stanley": 2, "pop": 2}
    assert result.margins["pop"][1] == margins(_fitted("pop", Vehicle()), Vehicle(), 10.0)
    own = stability({"pop": popsteer.PopParams(reference_offset=3.0, min_lookahead=20.0)})
    assert own.margins["pop"][2].dead_time > result.margins["pop"][1].dead_time


def test_lookahead_is_that_of_the_law() -> None:
    assert lookahead(popsteer.PopParams(min_lookahead=4.0, lookahead_gain=0.5), 10.0) == 9.0
    assert lookahead(popsteer.PurePursuitParams(), 5.0) == 10.0
    assert lookahead(popsteer.StanleyParams(), 5.0) is None


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"wheelbase": 0.0}, "wheelbase must be in"),
        ({"lag": -0.1}, "lag must be in"),
        ({"dead_time": math.nan}, "dead_time must be in"),
        ({"rear_offset": 3.0}, "front_offset must be in"),
    ],
)
def test_vehicle_of_bad_figures_is_refused_by_name(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Vehicle(**wrong)


def test_margins_of_what_has_no_linear_loop_are_refused() -> None:
    with pytest.raises(ConfigError, match="law must be one with a linear loop"):
        stability(["bang-bang"])
    with pytest.raises(ConfigError, match="speed must be in"):
        stability(["pop"], speeds=[0.0])
    with pytest.raises(ConfigError, match="reference_offset must be given"):
        margins(popsteer.PopParams(), Vehicle(), 10.0)
    with pytest.raises(ConfigError, match="lookahead must be positive"):
        stability(
            {"pop": popsteer.PopParams(reference_offset=3.0, min_lookahead=0.0, lookahead_gain=0.0)}
        )


def test_loop_is_stable_where_its_poles_lie_inside_the_circle() -> None:
    # A law that remembers its last angle, also one that winds up by itself: the product of the
    # poles is the share that it keeps, so with more than all of it no loop is stable.
    vehicle, speed, dt = Vehicle(lag=0.0), 8.0, 0.05
    turning = speed / vehicle.wheelbase
    rng = np.random.default_rng(3)
    told = []
    for pull, turn, kept in rng.uniform((-0.1, -0.5, -1.2), (0.4, 3.0, 1.2), (200, 3)):
        law = LinearLaw(3.0, np.array([pull]), np.array([turn]), np.array([1.0, -kept]))
        answer = np.array([-pull, -(3.0 * pull + turn), kept])  # to e₀, ψ and the last angle
        moved = np.array([0.5 * speed * turning * dt * dt, turning * dt, 0.0])
        matrix = np.outer(moved, answer) + np.array([[1, speed * dt, 0], [0, 1, 0], [0, 0, 0]])
        matrix[2] = answer
        largest = np.abs(np.linalg.eigvals(matrix)).max()
        if abs(largest - 1.0) > 1e-3:
            assert Loop(law, vehicle, speed, dt).is_stable() is bool(largest < 1.0)
            told.append((abs(kept) > 1.0, bool(largest < 1.0)))
    assert set(told) == {(True, False), (False, True), (False, False)}
