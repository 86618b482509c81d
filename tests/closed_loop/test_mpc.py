"""The model-predictive controller: a strong baseline, within its limits."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import lab, sim
from popsteer.errors import ConfigError, InputError, PopsteerError
from popsteer.lab import baselines
from popsteer.lab.baselines import MpcParams
from studies.chain import Chain
from tests.closed_loop.paths import cusps, shuttle, track
from tests.helpers import authors_data

LINE = popsteer.Path([(float(x), 0.0) for x in range(201)])
SPEED = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))


def _mpc(
    path: popsteer.Path, vehicle: popsteer.Vehicle | None = None, params: MpcParams | None = None
) -> Any:
    pytest.importorskip("osqp")
    return baselines.get("mpc").controller(path, vehicle, params)


def test_mpc_on_the_authors_track_is_within_a_centimetre() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    result = sim.run(_mpc(path), start=(-183.8, 78.7, -1.574), start_at="front")
    metrics = result.metrics
    assert (result.law, result.ending) == ("mpc", "finished")
    assert metrics.mean_abs_cross_track_error < 0.05
    assert metrics.settled_mean_abs_cross_track_error < 0.004
    assert metrics.settled_max_abs_cross_track_error < 0.03
    assert result.vehicle == result.plant_vehicle == sim.CarlaIdentified().vehicle
    assert result.params["cross_track_weight"] == 1.0


@pytest.mark.parametrize("name", ["racetrack", "figure-eight", "circle", "slalom"])
def test_mpc_keeps_to_each_track(name: str) -> None:
    result = sim.run(_mpc(track(name)), longitudinal=popsteer.SpeedPid())
    assert result.ending == "finished"
    assert result.metrics.settled_mean_abs_cross_track_error < 0.05


def test_mpc_that_knows_lag_and_understeer_tracks_better() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    car = sim.vehicle_of("carla-identified")
    errors = [
        sim.run(_mpc(path, given)).metrics.settled_mean_abs_cross_track_error
        for given in (car, car.replace(steer_lag=0.0), car.replace(understeer=0.0))
    ]
    assert errors[0] < 0.8 * min(errors[1:])


@pytest.mark.parametrize(
    "changes",
    [{"dead_time": 0.2}, {"steer_offset": 0.03}, {"turning_wheelbase": 3.6}, {"rear_axle": -1.2}],
    ids=str,
)
def test_mpc_that_knows_its_car_tracks_better(changes: dict[str, float]) -> None:
    path = track("slalom")
    plain = popsteer.Vehicle(max_lateral_acceleration=None)
    plant = sim.KinematicBicycle(plain.replace(**changes))
    known = sim.run(_mpc(path), plant).metrics.settled_mean_abs_cross_track_error
    assert known < 0.02
    if "rear_axle" not in changes:  # a pose that is another is refused
        wrong = sim.run(_mpc(path, plain), plant).metrics
        assert not wrong.settled_mean_abs_cross_track_error < 2.0 * known


def test_mpc_keeps_its_limits() -> None:
    car = sim.vehicle_of("kinematic-bicycle").replace(max_steer=0.12, max_steer_rate=0.3)
    result = sim.run(_mpc(track("racetrack"), car), "kinematic-bicycle", constant_speed=8.0)
    steer = result.records["steer"]
    assert np.abs(steer).max() == 0.12
    assert np.abs(np.diff(steer)).max() <= 0.3 * 0.05 + 1e-12
    assert set(result.records["status"].tolist()) == {0, popsteer.Status.SATURATED}


def test_mpc_keeps_the_lateral_acceleration_and_comes_back_to_it() -> None:
    car = popsteer.Vehicle(max_lateral_acceleration=2.0, max_steer_rate=0.4, steer_offset=0.02)
    law = _mpc(track("circle"), car)
    widest = {v: math.atan(2.0 * 3.0 / v**2) for v in (5.0, 12.0)}
    angles = [law.steer(0.0, 9.0, 0.5, 5.0, 0.05) for _ in range(40)]
    assert angles[-1] == min(angles) == pytest.approx(-widest[5.0] - 0.02, abs=1e-4)
    faster = [law.steer(0.0, 9.0, 0.5, 12.0, 0.05) for _ in range(40)]
    # No faster than the wheels turn.
    assert faster[0] == pytest.approx(angles[-1] + 0.4 * 0.05, abs=1e-4)
    assert faster[-1] == pytest.approx(-widest[12.0] - 0.02, abs=1e-4)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(("rear_axle", "no_slip"), [(0.0, 0.0), (-1.9, 0.1), (-0.5, -2.0)])
def test_mpc_solves_the_problem_that_it_states(
    rear_axle: float, no_slip: float, reverse: bool
) -> None:
    """On a straight, from a small error, without limits in reach: least squares, solved densely."""
    car = popsteer.Vehicle(understeer=0.003, rear_axle=rear_axle, no_slip_point=no_slip)
    p, e0, psi0, v = MpcParams(tolerance=1e-9, stages=12), 0.01, -0.002, 8.0
    # Backwards the vehicle is mirrored about the rear axle: so far ahead lies the tracked point.
    ahead = car.wheelbase + (no_slip - rear_axle) * (1.0 if reverse else -1.0)
    wanted = _dense(car, p, v, e0, psi0, 0.0, 0.0, ahead)
    gear, turn = (-1.0, math.pi) if reverse else (1.0, 0.0)
    path = popsteer.Path(np.column_stack((LINE.x, LINE.y)), reverse=[reverse] * len(LINE))
    # The pose is that of the vehicle's point, the error that of the tracked point.
    tracked = gear * car.wheelbase + rear_axle
    yaw = psi0 + turn
    x, y = 50.0 - tracked * math.cos(yaw), e0 - tracked * math.sin(yaw)
    steer = _mpc(path, car, p).steer(x, y, yaw, gear * v, 0.05)
    assert steer == pytest.approx(gear * wanted, rel=1e-3)
    assert abs(wanted) > 1e-5


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
def test_mpc_lets_the_wheels_answer_for_the_control_period(dt: float) -> None:
    """As above at the second step: the wheels are part of the way to the first command."""
    car, p = popsteer.Vehicle(steer_lag=0.15), MpcParams(tolerance=1e-9, stages=12)
    law, v = _mpc(LINE, car, p), 8.0
    first = law.steer(50.0, 0.3, 0.0, v, dt)
    second = law.steer(50.0, 0.02, -0.01, v, dt)
    ahead = 0.02 + car.wheelbase * math.sin(-0.01)
    wheel = (1.0 - math.exp(-dt / car.steer_lag)) * first
    assert second == pytest.approx(_dense(car, p, v, ahead, -0.01, wheel, first), rel=1e-3)
    if dt != p.stage_time:
        another = (1.0 - math.exp(-p.stage_time / car.steer_lag)) * first
        wrong = _dense(car, p, v, ahead, -0.01, another, first)
        assert abs(second - wrong) > 0.01 * abs(first)


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1])
def test_mpc_moves_no_farther_in_a_control_period_than_the_wheels(dt: float) -> None:
    law = _mpc(LINE, popsteer.Vehicle(max_steer_rate=0.3, max_lateral_acceleration=None))
    angles = [0.0, *(law.steer(50.0, 2.0, 0.0, 6.0, dt) for _ in range(10))]
    moves = -np.diff(angles)
    # From far off it turns as fast as it may.
    assert moves[:4] == pytest.approx(0.3 * dt, rel=0.01)
    assert np.abs(moves).max() <= 0.3 * dt + 1e-12


def _dense(
    car: popsteer.Vehicle,
    p: MpcParams,
    v: float,
    e: float,
    psi: float,
    a: float,
    before: float,
    ahead: float = 3.0,
) -> float:
    """First command of the least-squares problem on a straight, without limits."""
    count = p.stages
    answered = np.array([_free(car, p, v, 0.0, 0.0, 0.0, row, ahead) for row in np.eye(count)]).T
    free = _free(car, p, v, e, psi, a, np.zeros(count), ahead)
    assert p.cross_track_weight is None
    weight = np.tile([(3.0 / car.wheelbase) ** 2, p.heading_weight], count)
    weight[-2:] *= p.last_weight
    change = np.eye(count) - np.eye(count, k=-1)
    last = np.zeros(count)
    last[0] = before
    hessian = answered.T * weight @ answered + p.change_weight * change.T @ change
    gradient = (answered.T * weight) @ free - p.change_weight * change.T @ last
    return float(np.linalg.solve(hessian, -gradient)[0])


def _free(
    car: popsteer.Vehicle,
    p: MpcParams,
    v: float,
    e: float,
    psi: float,
    a: float,
    steer: Any,
    ahead: float,
) -> Any:
    """Cross-track and heading errors of each stage, stage by stage."""
    h, lag = p.stage_time, car.steer_lag
    kept = math.exp(-h / lag)
    errors = []
    for delta in steer:
        share = (1.0 - kept) * lag / h
        rate = v * (share * a + (1.0 - share) * delta) / (car.wheelbase + car.understeer * v * v)
        e += h * v * psi + 0.5 * h * h * v * rate + h * ahead * rate
        psi += h * rate
        a = kept * a + (1.0 - kept) * delta
        errors += [e, psi]
    return np.array(errors)


def test_mpc_with_dead_time_answers_the_vehicle_of_then() -> None:
    """What it commands is what one without dead time would that sees the car 0.2 s later."""
    car = popsteer.Vehicle(dead_time=0.2, steer_lag=0.15, max_steer_rate=0.6, rear_axle=-1.2)
    path, tight = track("slalom"), MpcParams(tolerance=1e-7)
    late, chain = _mpc(path, car, tight), Chain(car, (0.0, 0.5, 0.1), 6.0, 0.05)
    poses, commands = [], []
    for _ in range(100):
        poses.append(chain.pose)
        commands.append(late.steer(*chain.pose, 6.0, 0.05))
        chain.advance(commands[-1])
    prompt = _mpc(path, car.replace(dead_time=0.0), tight)
    expected = [prompt.steer(*pose, 6.0, 0.05) for pose in poses[4:]]
    assert commands[:-4] == pytest.approx(expected, abs=2e-4)
    assert np.ptp(commands) > 0.2


@pytest.mark.parametrize("reverse", [False, True])
def test_mpc_answers_alike_wherever_the_pose_is_measured(reverse: bool) -> None:
    shipped = track("slalom")
    backwards = [reverse] * len(shipped)
    path = popsteer.Path(np.column_stack((shipped.x, shipped.y)), reverse=backwards)
    rear = popsteer.Vehicle(dead_time=0.1, steer_offset=0.01)
    answers = []
    for offset in (0.0, -1.5, -3.0):
        law = _mpc(path, rear.replace(rear_axle=offset), MpcParams(tolerance=1e-7))
        gear = -1.0 if reverse else 1.0
        chain = Chain(rear, (0.0, 0.4, math.pi if reverse else 0.0), gear * 4.0, 0.05)
        steers = []
        for _ in range(60):
            x, y, yaw = chain.pose
            x, y = x - offset * math.cos(yaw), y - offset * math.sin(yaw)
            steers.append(law.steer(x, y, yaw, gear * 4.0, 0.05, reverse=reverse))
            chain.advance(steers[-1])
        assert abs(chain.y - path.project(chain.x, chain.y).point[1]) < 0.3
        answers.append(steers)
    assert answers[1] == pytest.approx(answers[0], abs=1e-6)
    assert answers[2] == pytest.approx(answers[0], abs=1e-6)


def test_mpc_backwards_is_mirrored() -> None:
    xy = [(-float(x), 0.02 * x * x / 10.0) for x in range(60)]
    car = popsteer.Vehicle(steer_offset=0.02)
    forward = _mpc(popsteer.Path(xy), car.replace(steer_offset=-0.02), MpcParams(tolerance=1e-8))
    law = _mpc(popsteer.Path(xy, reverse=[True] * len(xy)), car, MpcParams(tolerance=1e-8))
    for k in range(20):
        x, y, yaw = -0.2 * k, 0.3, 0.05
        wanted = forward.step(x, y, yaw + math.pi, 4.0, 0.05)
        command = law.step(x, y, yaw, -4.0, 0.05)
        assert (wanted.reverse, command.reverse) == (False, True)
        assert command.steer == pytest.approx(-wanted.steer, abs=1e-6)


@pytest.mark.parametrize("name", ["shuttle", "parking", "three-point-turn"])
@pytest.mark.parametrize("dead_time", [0.0, 0.15])
def test_mpc_drives_through_the_cusps(name: str, dead_time: float) -> None:
    path = shuttle() if name == "shuttle" else cusps(name)
    car = popsteer.Vehicle(rear_axle=-1.5, dead_time=dead_time, max_steer=0.6)
    start = sim.default_start(path, 0.3, car)
    result = sim.run(_mpc(path), sim.KinematicBicycle(car), start=start, longitudinal=SPEED)
    assert result.ending == "finished"
    assert result.records["speed"].min() < -0.3
    # The tracked point leaves the path at a cusp, as the front axle of any car does.
    assert result.metrics.rear_axle_mean_abs_cross_track_error < 0.4
    assert result.metrics.rear_axle_max_abs_cross_track_error < 0.8


def test_mpc_looks_ahead_across_the_seam_of_a_path_with_cusps() -> None:
    pytest.importorskip("osqp")
    from popsteer.lab.baselines.ahead import Ahead

    # To and fro on an arc: forward from waypoint 20 to 60, back across the seam to 20.
    angle = 0.06 * np.abs((np.arange(80) - 20 + 40) % 80 - 40)
    xy = 20.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    backwards = ~((np.arange(80) >= 20) & (np.arange(80) < 60))
    path = popsteer.Path(xy, closed=True, reverse=backwards)
    step = path.length / 80.0
    found = Ahead(path, popsteer.Vehicle())
    for segment in (60, 70, 79, 0, 7, 19, 20, 40, 59):
        left = 1.0 if 20 <= segment < 60 else -1.0  # in the order of the waypoints
        reach = ((59 if left > 0 else 19) - segment) % 80 * step + 0.7 * step
        begin = angle[segment] + 0.3 * 0.06 * left + left * 0.5 * math.pi
        distances = np.linspace(0.0, reach, 20)
        headings = found.headings(segment, float(path.s[segment]) + 0.3 * step, distances)
        np.testing.assert_allclose(np.diff(headings), left * 0.06 / step * np.diff(distances))
        assert math.remainder(headings[0] - begin, math.tau) == pytest.approx(0.0, abs=1e-9)
        beyond = reach + np.array([0.0, 5.0, 50.0])
        assert np.ptp(found.headings(segment, float(path.s[segment]) + 0.3 * step, beyond)) < 1e-9
    assert [found.turning(7, reverse=False), found.turning(59, reverse=True)] == [20, 60]
    assert found.turning(70, reverse=False) == 20
    assert found.turning(70, reverse=True) == 70
    whole = Ahead(popsteer.Path(xy[:20]), popsteer.Vehicle())
    assert whole.turning(7, reverse=True) == 7


def test_mpc_that_is_not_told_the_direction_keeps_it() -> None:
    law = _mpc(shuttle())
    assert not law.step(29.0, 0.1, 0.0, 2.0, 0.05).reverse
    assert not law.step(30.5, 0.1, 0.0, 0.5, 0.05).reverse
    assert law.step(30.5, 0.1, 0.0, 0.0, 0.05, reverse=True).reverse
    assert law.step(20.0, 0.1, 0.0, -2.0, 0.05).reverse
    assert not law.step(9.5, 0.1, 0.0, 0.0, 0.05, reverse=False).reverse
    law.reset()
    assert not law.step(1.0, 0.1, 0.0, 2.0, 0.05).reverse


@pytest.mark.parametrize("scale", [0.11, 10.0])
def test_mpc_of_a_car_of_another_size_answers_alike(scale: float) -> None:
    tight = MpcParams(tolerance=1e-8)
    shipped = track("slalom")
    xy = np.column_stack((shipped.x, shipped.y))
    car = popsteer.Vehicle(understeer=0.002, max_lateral_acceleration=5.0)
    other = popsteer.Vehicle(
        wheelbase=3.0 * scale, understeer=0.002 / scale, max_lateral_acceleration=5.0 * scale
    )
    laws = _mpc(shipped, car, tight), _mpc(popsteer.Path(xy * scale), other, tight)
    for k in range(40):
        x, y, yaw, speed = 0.5 * k, 0.6 + 0.05 * k, 0.1, 8.0
        steers = [
            law.steer(size * x, size * y, yaw, size * speed, 0.05)
            for law, size in zip(laws, (1.0, scale), strict=True)
        ]
        assert steers[1] == pytest.approx(steers[0], abs=1e-4)


def test_mpc_from_a_reset_answers_as_a_new_one() -> None:
    path = track("slalom")
    used, states = _mpc(path), [(float(k), 0.3, 0.1, 6.0, 0.05) for k in range(20)]
    first = [used.steer(*state) for state in states]
    used.reset()
    # osqp's step size has adapted meanwhile; the answer is the same to its tolerance.
    assert [used.steer(*state) for state in states] == pytest.approx(first, abs=1e-3)


@pytest.mark.parametrize("speed", [0.0, -2.0, 0.5])
def test_mpc_at_rest_and_slow_answers_without_winding_up(speed: float) -> None:
    law = _mpc(track("racetrack"))
    angles = [law.steer(0.0, 1.0, 0.0, speed, 0.05) for _ in range(100)]
    assert np.isfinite(angles).all()
    assert abs(angles[-1] - angles[-2]) < 1e-3


def test_mpc_far_away_and_facing_backwards_answers_within_its_limits() -> None:
    law = _mpc(track("racetrack"))
    for x, y, yaw in ((0.0, 40.0, 0.0), (0.0, 0.0, math.pi), (-900.0, 500.0, 2.0)):
        law.reset()
        angles = [law.steer(x, y, yaw, 10.0, 0.05) for _ in range(20)]
        assert np.abs(angles).max() <= law.vehicle.max_steer


@pytest.mark.parametrize(
    ("field", "state"),
    [
        ("x", (math.nan, 0.0, 0.0, 1.0, 0.05)),
        ("y", (0.0, math.inf, 0.0, 1.0, 0.05)),
        ("yaw", (0.0, 0.0, math.nan, 1.0, 0.05)),
        ("speed", (0.0, 0.0, 0.0, math.nan, 0.05)),
        ("dt", (0.0, 0.0, 0.0, 1.0, 0.0)),
    ],
)
def test_mpc_bad_input_is_refused(field: str, state: tuple[float, ...]) -> None:
    law = _mpc(track("slalom"))
    with pytest.raises(InputError, match=f"{field} must be"):
        law.step(*state)
    assert law.previous_steer == 0.0


def test_mpc_params_out_of_range_are_refused() -> None:
    with pytest.raises(ConfigError, match="cross_track_weight must be in"):
        MpcParams(cross_track_weight=-0.1)
    with pytest.raises(ConfigError, match="heading_weight must be in"):
        MpcParams(heading_weight=math.nan)
    with pytest.raises(ConfigError, match="stages must be in"):
        MpcParams(stages=1)


def test_mpc_params_leave_to_the_vehicle_what_scales() -> None:
    assert MpcParams().cross_track_weight is None
    small = popsteer.Vehicle(wheelbase=0.3)
    assert MpcParams().resolved(small).cross_track_weight == pytest.approx(100.0)
    given = MpcParams(cross_track_weight=2.0)
    assert given.resolved(small) is given


def test_compare_names_a_baseline_beside_the_laws_and_times_both() -> None:
    pytest.importorskip("osqp")
    path = track("slalom")
    params = lab.compare.parameters(["pop", "mpc"], "default")
    comparison = lab.compare.run(path, params)
    assert {name: run.law for name, run in comparison.runs.items()} == {"pop": "pop", "mpc": "mpc"}
    timed = lab.compare.time_steps(comparison, params)
    assert timed.runs == comparison.runs
    assert list(timed.step_times) == ["pop", "mpc"]
    assert all(time > 0.0 for time in timed.step_times.values())
    with pytest.raises(ConfigError, match=r"unknown controller 'lqr'; known: .*, mpc"):
        lab.compare.run(path, ["pop", "lqr"])


def test_mpc_without_the_extra_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    path = track("slalom")
    monkeypatch.setitem(sys.modules, "osqp", None)
    with pytest.raises(PopsteerError, match=r'pip install "popsteer\[mpc\]"'):
        baselines.get("mpc").controller(path, None, None)
