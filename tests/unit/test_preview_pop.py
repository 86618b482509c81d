"""Preview POP: its choice against a list of candidates, and what it does where it could do harm."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer import AdaptParams, PreviewPop, PreviewPopParams, Status, Vehicle

if TYPE_CHECKING:
    from numpy.typing import NDArray

DT = 0.05
CAR = Vehicle(wheelbase=2.7, max_lateral_acceleration=None)
LINE = popsteer.Path([(float(x), 0.0) for x in range(400)])
ANGLES = np.linspace(0.0, 2.0 * math.pi, 3000, endpoint=False)
CIRCLE = popsteer.Path(40.0 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)]), closed=True)


def _rollout(
    params: PreviewPopParams,
    vehicle: Vehicle,
    start: list[float],
    speed: float,
    bend: float,
    offset: float,
) -> Any:
    """The prediction as a linear function of the moves: its errors as (constant, matrix).

    Plainly integrated in small steps, apart from the controller's own closed solution.
    """
    params = params.resolved(vehicle)
    steps, substeps = round(params.horizon / DT), 400
    length = vehicle.turning_length(speed)
    # Columns: the constant, then each move. Rows: cross-track, heading, driven, told.
    state = np.zeros((4, steps + 1))
    state[:, 0] = start
    rows: list[NDArray[np.float64]] = []
    h = speed * DT / substeps
    for k in range(steps):
        state[3, k + 1] += 1.0
        for _ in range(substeps):
            e, p, a, c = state
            turn = np.zeros(steps + 1)
            turn[0] = bend
            state = np.array(
                [
                    e + h * (p + offset * a) + 0.5 * h * h * (a - turn),
                    p + h * (a - turn),
                    a + h * (c - a) / (vehicle.steer_lag * speed),
                    c,
                ]
            )
        e, p, a, _ = state
        rows += [e, (params.heading_cost or 0.0) * (p + offset * a)]
        move = np.zeros(steps + 1)
        move[k + 1] = (params.steer_rate_cost or 0.0) * length / DT
        rows.append(move)
    stacked = np.array(rows)
    return stacked[:, 0], stacked[:, 1:]


@pytest.mark.parametrize("radius", [np.inf, 40.0])
@pytest.mark.parametrize(("aside", "yaw", "steer"), [(0.3, 0.02, 0.0), (-0.1, -0.05, 0.03)])
@pytest.mark.parametrize("offset", [0.0, 1.06])
def test_preview_pop_choice_beats_every_candidate_of_the_neighbourhood(
    radius: float, aside: float, yaw: float, steer: float, offset: float
) -> None:
    params = PreviewPopParams(horizon=0.5, approach_angle=1.5)
    vehicle = CAR.replace(understeer=2e-3, rear_axle=-0.6)
    speed, length = 12.0, 2.7 + 2e-3 * 12.0**2
    path = LINE if np.isinf(radius) else CIRCLE
    x, y = (50.0, aside) if np.isinf(radius) else (radius - aside, 0.0)
    heading = yaw if np.isinf(radius) else 0.5 * math.pi + yaw
    law = PreviewPop(path, vehicle, params, adapt=AdaptParams(turn_time=0.0, slip_time=0.0))
    # As wheels that are on their way to the angle commanded look, after a step with no news.
    wheel = math.atan(0.01 * length)
    before = steer + (wheel - steer) / math.exp(-DT / vehicle.steer_lag)
    state = law.state
    estimate = state.estimator.estimate.replace(slip_length=offset)
    law.state = state.replace(
        law=state.law.replace(previous_steer=steer),
        steer=steer,
        in_flight=state.in_flight.replace(wheel=before),
        estimator=state.estimator.replace(estimate=estimate),
    )
    # The pose's point lies ahead of the tracked one.
    x, y = x + 0.6 * math.cos(heading), y + 0.6 * math.sin(heading)
    command = law.step(x, y, heading, speed, DT)
    given = math.tan(steer) / length
    start = [aside, yaw, 0.01, given]
    constant, matrix = _rollout(params, vehicle, start, speed, 1.0 / radius, offset)

    def cost(angle: float) -> float:
        """Least cost with this angle first, whatever follows."""
        first = math.tan(angle) / length - given
        rest = constant + matrix[:, 0] * first
        best = rest + matrix[:, 1:] @ np.linalg.lstsq(matrix[:, 1:], -rest, rcond=None)[0]
        return float(best @ best)

    span = math.radians(60.0) * DT
    candidates = np.linspace(steer - span, steer + span, 21)
    assert abs(command.steer - steer) <= span * (1 + 1e-12)
    costs = [cost(candidate) for candidate in candidates]
    assert cost(command.steer) <= min(costs) * (1 + 1e-4)
    assert max(costs) > min(costs) * 1.001, "the candidates do not differ"


def test_preview_pop_at_rest_keeps_its_angle() -> None:
    law = PreviewPop(LINE, adapt=None)
    law.reset(steer=0.125)
    for speed in (0.0, -0.0, -3.0):
        assert [law.steer(20.0, 2.0, 0.4, speed, DT) for _ in range(50)] == [0.125] * 50


def test_preview_pop_at_low_speed_turns_with_the_distance_travelled() -> None:
    moves = []
    for speed in (0.1, 0.2):
        law = PreviewPop(LINE)
        moves.append(abs(law.steer(20.0, 2.0, 0.8, speed, DT)))
    assert moves[1] == pytest.approx(2.0 * moves[0])
    assert moves[0] == pytest.approx(math.radians(60.0) * DT * 0.1 / 5.0)


def test_preview_pop_step_keeps_to_rate_angle_and_lateral_acceleration() -> None:
    vehicle = Vehicle(max_steer_rate=0.4, max_lateral_acceleration=3.0, max_steer=0.25)
    for speed, most in ((4.0, 0.25), (15.0, math.atan(3.0 * 3.0 / 15.0**2))):
        law = PreviewPop(LINE, vehicle, adapt=None)
        steer, commands = 0.0, []
        for _ in range(60):
            command = law.step(20.0, -3.0, -1.5, speed, DT)
            assert abs(command.steer - steer) <= 0.4 * DT * (1 + 1e-12)
            steer = command.steer
            commands.append(command)
        assert steer == pytest.approx(most)
        # The vehicle stands still meanwhile, which is implausible.
        assert Status.SATURATED in commands[-1].status


def test_preview_pop_on_a_circle_holds_the_angle_of_the_circle() -> None:
    law = PreviewPop(CIRCLE, CAR.replace(steer_lag=0.0))
    x, y, yaw = 40.0, 0.0, 0.5 * math.pi
    for _ in range(300):
        steer = law.steer(x, y, yaw, 10.0, DT)
        x, y, yaw, _ = popsteer.paper.kinematic_bicycle(x, y, yaw, 10.0, steer, 0.0, 2.7, DT)
    assert steer == pytest.approx(math.atan(2.7 / 40.0), rel=0.01)


@pytest.mark.parametrize("jump", [0.0, 500.0, -1e6])
def test_preview_pop_estimates_keep_within_their_bounds_after_a_jump(jump: float) -> None:
    law = PreviewPop(LINE, adapt=AdaptParams(turn_time=0.2, slip_time=0.2))
    for k in range(100):
        law.step(20.0 + 0.5 * k, jump * (k % 2), 3.0 * k, 10.0, DT)
        assert 0.4 <= law.estimate.gain <= 2.5
        assert abs(law.estimate.steer_offset) <= 0.15
        assert abs(law.estimate.slip) <= 0.15
    # Back in order, what was found wrongly is forgotten.
    for k in range(100):
        law.step(80.0 + 0.5 * k, 0.0, 0.0, 10.0, DT)
    assert abs(law.estimate.slip) < 1e-3


def test_preview_pop_that_does_not_adapt_estimates_nothing() -> None:
    law = PreviewPop(LINE, adapt=None)
    for k in range(20):
        law.step(20.0 + 0.5 * k, 0.1 * k, 0.05 * k, 10.0, DT)
    assert law.estimate == popsteer.Estimate(steer_lag=law.vehicle.steer_lag)


def test_preview_pop_finds_slip_straight_on_and_by_curvature() -> None:
    # Bends of up to 1/40 1/m by turns, in steps of 0.5 m.
    way = 0.5 * np.sin(np.arange(2000) * (0.5 / 20.0))
    x, y = 0.5 * np.cumsum(np.cos(way)), 0.5 * np.cumsum(np.sin(way))
    bend = np.gradient(way) / 0.5
    # What arrives at a place under `way` leaves it under the next one; the heading lies between.
    yaw = 0.5 * (way[:-1] + way[1:]) - (0.02 - 0.6 * bend[:-1])
    law = PreviewPop(popsteer.Path(np.column_stack([x, y])))
    for k in range(1500):
        law.step(x[k], y[k], yaw[k], 10.0, DT)
    assert law.estimate.slip == pytest.approx(0.02, abs=1e-3)
    assert law.estimate.slip_length == pytest.approx(-0.6, abs=0.03)


@pytest.mark.parametrize("jump", [0.5, 40.0, -1e6])
def test_preview_pop_slip_found_in_a_bend_keeps_within_its_bounds_after_a_jump(
    jump: float,
) -> None:
    # Without a monitor every pose is believed.
    law = PreviewPop(CIRCLE, CAR, adapt=AdaptParams(slip_time=0.1), monitor=None)
    law.step(40.0, 0.0, 0.5 * math.pi, 10.0, DT)
    most = (0.0, 0.0)
    for k in range(1, 50):
        # To the side and on from there, always farther.
        law.step(40.0 + k * jump, 0.0, 0.5 * math.pi, 10.0, DT)
        slips = (abs(law.estimate.slip), abs(law.estimate.slip_length))
        most = (max(most[0], slips[0]), max(most[1], slips[1]))
    # Without a gate all of it counts for the slip, up to the bounds.
    assert 0.1 < most[0] <= 0.15
    assert most[1] == 2.7


def test_preview_pop_smoothing_turned_off_takes_the_segments() -> None:
    corner = popsteer.Path([(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)])
    # With a limit of the lateral acceleration it would look past the corner.
    car = popsteer.Vehicle(max_lateral_acceleration=None)
    far = PreviewPop(corner, car, PreviewPopParams(smoothing_length=0.0, horizon=0.5))
    near = PreviewPop(corner, car, PreviewPopParams(smoothing_length=2.0, horizon=0.5))
    # 8 m before the corner, looking 5 m ahead: straight on, unless the direction is smoothed.
    assert abs(far.steer(12.0, 0.0, 0.0, 10.0, DT)) < 1e-12
    assert near.steer(12.0, 0.0, 0.0, 10.0, DT) > 1e-4
