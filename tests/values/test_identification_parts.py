"""The steps of an identification, each against a plain loop or an answer known by hand."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from popsteer._core import _Wheels as Wheels
from popsteer.identification import drive, rounding, whiten
from popsteer.identification.chain import Chain
from popsteer.logs import Log

pytest.importorskip("scipy")

drives: Any = drive
unrounded: Any = rounding.unrounded

DT = 0.05


def _log(gap: float = 20.0) -> Log:
    """8 s of driving, a gap, 6 s more with a rest of 2 s in them."""
    t = np.concatenate((DT * np.arange(160), 8.0 - DT + gap + DT * np.arange(120)))
    speed = 5.0 + 0.1 * t
    speed[200:240] = 0.0
    steer = np.round(0.1 * np.sin(t), 3)
    return Log(t + 50.0, 3.0 * t, -2.0 * t, 0.05 * t, speed, steer)


def test_prepared_log_has_pauses_of_five_seconds_and_cells_in_which_the_car_stands() -> None:
    log = _log()
    ready = drives.prepare(log)
    assert [part.start for part in ready.unbroken] == [0, 160]
    wanted = np.concatenate((DT * np.arange(160), 7.95 + 5.0 + DT * np.arange(120)))
    assert ready.t == pytest.approx(wanted)
    assert ready.cell == pytest.approx(0.025)
    assert ready.edges[0] == 0.0
    assert ready.t[-1] <= ready.edges[-1] < ready.t[-1] + 2.0 * ready.cell
    assert ready.usual_step == pytest.approx(DT)
    middle = 0.5 * (ready.edges[1:] + ready.edges[:-1])
    pause = (middle > wanted[159]) & (middle < wanted[160])
    assert (ready.speed[pause] == 0.0).all()
    assert ready.speed[~pause] == pytest.approx(
        np.interp(middle[~pause], ready.t, ready.sample_speed)
    )
    # Of the rest, nothing counts; nor does the first second of each part.
    assert (ready.moving == (log.speed > 0.1)).all()
    assert [(part.start, part.stop) for part in ready.parts()] == [
        (20, 160),
        (180, 200),
        (240, 280),
    ]
    # The command before the gap is the one after it, from there on.
    expected = log.steer.copy()
    expected[159] = log.steer[160]
    assert ready.commands.tolist() == expected.tolist()
    assert (ready.times == ready.t).all()
    assert ready.yaw.tolist() == log.yaw.tolist()


def test_rests_are_as_long_as_a_second() -> None:
    t = DT * np.arange(100)
    for samples, rests in ((20, False), (21, True)):
        speed = np.full(100, 2.0)
        speed[40 : 40 + samples] = -0.1
        moving = drives._moving(t, np.abs(speed) > 0.1, [slice(0, 100)])
        assert moving.all() != rests, samples
        assert (~moving).sum() == (samples if rests else 0)
    assert drives._moving(t, np.full(100, True), [slice(0, 100)]).all()


def test_cells_are_equal_and_at_most_a_fortieth_of_a_second() -> None:
    for step, cell in ((0.01, 0.025), (0.02, 0.025), (0.04, 0.02), (0.09, 0.0225)):
        t = step * np.arange(50)
        edges, speed, _ = drives._cells(t, (), (t, 2.0 * t))
        assert np.diff(edges) == pytest.approx(cell), step
        middle = 0.5 * (edges[1:] + edges[:-1])
        inside = middle < t[-1]
        assert speed[inside] == pytest.approx(2.0 * middle[inside])


def test_outliers_are_replaced_by_the_line_of_their_neighbours() -> None:
    t = np.cumsum(np.random.default_rng(0).uniform(0.04, 0.06, 60))
    clean = 2.0 * t + 0.001 * np.random.default_rng(1).standard_normal(60)
    moving = np.ones(60, dtype=bool)
    assert drives._without_outliers(t, clean, moving)[1] == 0
    values = clean.copy()
    values[[17, 40]] += (5.0, -1.5)
    kept, count = drives._without_outliers(t, values, moving)
    assert count == 2
    assert kept == pytest.approx(clean, abs=0.01)
    # Six times the usual step of the signal is the least that stands out.
    step = float(np.median(np.diff(clean)))
    for factor, found in ((5.0, 0), (7.0, 1)):
        values = clean.copy()
        values[30] += factor * step
        assert drives._without_outliers(t, values, moving)[1] == found, factor
    assert drives._without_outliers(t[:8], values[24:32], moving[:8])[1] == 0
    # At rest everything is the same: the size is that of the moving car.
    still = np.where(np.arange(60) < 40, clean[40], clean)
    still[10] += 0.05
    assert drives._without_outliers(t, still, np.arange(60) >= 41)[1] == 0
    assert drives._without_outliers(t, still, np.arange(60) >= 55)[1] > 0


def test_noise_of_a_signal_is_that_of_its_second_differences() -> None:
    random = np.random.default_rng(2)
    t = np.arange(20_000.0)
    assert drives.noise_of(3.0 * t + random.normal(0.0, 0.2, 20_000)) == pytest.approx(
        0.2, rel=0.03
    )
    assert drives.noise_of(np.array([1.0, 2.0])) == 0.0
    # Second differences of 0, 1, 0, 1, ... are 2 in size.
    assert drives.noise_of(np.tile([0.0, 1.0], 9)) == pytest.approx(1.4826 * 2.0 / math.sqrt(6.0))


def test_commands_on_the_clock_without_gaps_keep_their_order() -> None:
    log, clock = np.array([10.0, 11.0, 31.0, 32.0]), np.array([0.0, 1.0, 6.0, 7.0])
    times = np.array([8.0, 10.5, 11.0, 21.0, 21.0, 29.0, 31.5, 35.0])
    found = drives._on_clock(times, log, clock)
    # In the gap the last keep their distance to its end, and the earlier ones fall together.
    assert found == pytest.approx([-2.0, 0.5, 1.0, 1.0, 1.0, 4.0, 6.5, 10.0], abs=1e-7)
    assert (np.diff(found) > 0.0).all()


def test_edges_of_gaps_are_no_accelerations() -> None:
    t = DT * np.arange(2_400)
    t = t[t % 12.0 < 8.0]
    ready = drives.prepare(Log(t, 10.0 * t, 0.0 * t, 0.1 * t, 0.0 * t + 10.0, 0.1 * np.sin(t)))
    assert len(ready.unbroken) == 10
    assert np.abs(ready.acceleration).max() < 1e-9
    assert (ready.speed == 0.0).any()


def test_usual_speed_is_that_at_which_the_car_turns() -> None:
    t = DT * np.arange(400)
    speed = np.where(t < 10.0, 4.0, -12.0)
    rate = np.where(t < 10.0, 0.3, 0.1)
    usual = drives._usual_speed(t, np.cumsum(DT * rate), speed)
    # Weighted by the squares of the rates, 9 to 1.
    assert usual == pytest.approx((9.0 * 4.0 + 12.0) / 10.0, rel=0.02)
    assert drives._usual_speed(t, 0.1 * t, 0.0 * t) == 1e-3


def test_acceleration_is_the_slope_of_the_speeds_within_its_bounds() -> None:
    t = 0.025 * np.arange(400)
    assert drives._acceleration(1.5 * t, 0.025)[80:320] == pytest.approx(1.5, rel=1e-3)
    assert drives._acceleration(np.where(t < 5.0, 0.0, 90.0), 0.025).max() == 12.0
    # A step of 1 m/s becomes the bell of its smoothing, 0.3 s wide.
    bell = drives._acceleration(np.where(t < 5.0, 0.0, 1.0), 0.025)
    assert bell.max() == pytest.approx(1.0 / (0.3 * math.sqrt(2.0 * math.pi)), rel=0.01)


def test_whitened_error_is_the_innovations_without_what_the_first_sample_leaves() -> None:
    random = np.random.default_rng(3)
    error = np.cumsum(random.standard_normal(60))
    parts = [slice(0, 25), slice(30, 60)]
    for theta in (0.0, 0.5, 0.9):
        pieces = []
        for part in parts:
            left, last = [], 0.0
            for step in np.diff(error[part]):
                last = step + theta * last
                left.append(last)
            # Orthogonal to the powers of theta.
            powers = theta ** np.arange(float(len(left)))
            piece = np.array(left)
            pieces.append(piece - powers * (powers @ piece) / (powers @ powers))
        found = whiten.whitened(error, parts, theta)
        assert found == pytest.approx(np.concatenate(pieces), abs=1e-7), theta
        both = whiten.whitened(np.stack((error, 2.0 * error), axis=1), parts, theta)
        assert both == pytest.approx(np.stack((found, 2.0 * found), axis=1))


def test_theta_is_the_one_that_the_noise_was_made_with() -> None:
    random = np.random.default_rng(4)
    for theta in (0.0, 0.5, 0.9):
        w = random.standard_normal(4000)
        steps = w.copy()
        steps[1:] -= theta * w[:-1]
        chosen = whiten.choose_theta(np.cumsum(steps), [slice(0, 4000)])
        assert chosen == pytest.approx(theta, abs=0.02)


def test_digits_that_repeat_are_noise_of_their_own() -> None:
    # A heading that turns by a step in 50 rows: what rounding leaves is a saw, not a random walk.
    turned = 2e-4 * np.arange(4000.0)
    error, parts = np.round(turned, 2) - turned, [slice(0, 4000)]
    least = 0.01 / np.sqrt(12.0)
    assert whiten.choose_theta(error, parts) < 0.5
    theta = whiten.choose_theta(error, parts, least)
    white = whiten.whitened(error, parts, theta)
    assert theta * np.mean(white**2) == pytest.approx(least**2, rel=0.2)
    # No innovation is an outlier then, which would take a turn for none.
    assert np.max(np.abs(white)) < 2.0 * least


def test_spread_and_mean_square_are_not_those_of_outliers() -> None:
    values = np.array([3.0, 1.0, 2.0, 5.0, 4.0])
    assert whiten.spread(values) == pytest.approx(1.4826)
    assert whiten.clipped_mean_square(values) == pytest.approx(
        (9.0 + 1.0 + 4.0 + 16.0 + 9.0 * 1.4826**2) / 5.0
    )
    spoilt = np.concatenate((np.tile([-1.0, 1.0], 50), [1000.0]))
    assert whiten.clipped_mean_square(spoilt) == pytest.approx(
        (100.0 + 9.0 * whiten.spread(spoilt) ** 2) / 101.0
    )
    assert whiten.clipped_mean_square(np.array([0.0, 0.0, 0.0, 6.0])) == 9.0


def test_errors_of_least_squares_are_those_of_newey_and_west() -> None:
    random = np.random.default_rng(5)
    jacobian = random.standard_normal((300, 3)) * (1.0, 40.0, 0.01)
    residual = random.standard_normal(300)
    residual[1:] += 0.8 * residual[:-1]
    for memory in (0, 4):
        inverse = np.linalg.inv(jacobian.T @ jacobian)
        middle = np.zeros((3, 3))
        for one in range(300):
            for other in range(max(0, one - memory), min(300, one + memory + 1)):
                weight = 1.0 - abs(one - other) / (memory + 1)
                products = residual[one] * residual[other]
                middle += weight * products * np.outer(jacobian[one], jacobian[other])
        wanted = inverse @ middle @ inverse
        plain = inverse * np.mean(residual**2)
        found = whiten.known(jacobian, residual, memory)
        floor = np.maximum(np.diag(wanted), np.diag(plain))
        assert np.diag(found.covariance) == pytest.approx(floor, rel=1e-6)
        grow = np.sqrt(floor / np.diag(wanted))
        assert found.covariance == pytest.approx(wanted * np.outer(grow, grow), rel=1e-6)
        assert found.errors() == pytest.approx(np.sqrt(floor))
        weights = np.array([1.0, 2.0, -0.5])
        assert found.error(weights) == pytest.approx(
            math.sqrt(weights @ found.covariance @ weights)
        )
        noise = math.sqrt(weights @ plain @ weights)
        assert found.split(weights) == pytest.approx(
            (noise, math.sqrt(max(found.error(weights) ** 2 - noise**2, 0.0)))
        )


def test_errors_are_not_below_those_that_noise_alone_makes() -> None:
    random = np.random.default_rng(8)
    parts, theta, sample = [slice(0, 60), slice(70, 110)], 0.9, 0.3
    steps = random.uniform(0.01, 0.05, 109)
    jacobian = whiten.whitened(random.standard_normal((110, 2)).cumsum(axis=0), parts, theta)
    # By matrices: the filter of each sample's error, and the covariance of these errors.
    filtered = jacobian.T @ whiten.whitened(np.eye(110), parts, theta)
    walk = np.tri(110, 109, -1)
    noise = sample**2 * np.eye(110) + walk @ np.diag(steps**2) @ walk.T
    added = whiten.influence(jacobian, parts, theta)
    score = whiten.noise_score(added, parts, sample, steps)
    assert score == pytest.approx(filtered @ noise @ filtered.T, rel=1e-6)
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    residual = 1e-6 * random.standard_normal(len(jacobian))
    found = whiten.known(jacobian, residual, 3, score).errors()
    assert found == pytest.approx(np.sqrt(np.diag(inverse @ score @ inverse)), rel=1e-6)


def test_direction_that_is_not_excited_is_not_known() -> None:
    jacobian = np.random.default_rng(6).standard_normal((50, 3))
    jacobian[:, 2] = 2.0 * jacobian[:, 1]
    found = whiten.known(jacobian, jacobian[:, 0], 2)
    first, second, third = found.errors()
    assert math.isfinite(first)
    assert second == third == math.inf
    assert found.split(np.array([0.0, 1.0, 0.0])) == (math.inf, math.inf)
    # What both do together is known all the same.
    assert math.isfinite(found.error(np.array([0.0, 1.0, 2.0])))
    jacobian[:, 0] = 0.0
    assert whiten.known(jacobian, jacobian[:, 1], 2).errors()[0] == math.inf


@pytest.mark.parametrize(("lag", "rate"), [(0.1, None), (0.1, 0.4), (1e-7, 0.3)])
def test_wheels_behind_play_turn_as_in_small_steps(lag: float, rate: float | None) -> None:
    times = np.linspace(0.0, 4.95, 100)
    commands = np.cumsum(0.05 * np.random.default_rng(0).standard_normal(100))
    late, scale, offset, play, h = 0.137, 0.9, 0.01, 0.03, 1e-4
    fine = np.arange(0.0, 5.0, h)
    place = np.clip(np.searchsorted(times, fine - late, side="right") - 1, 0, None)
    angle, wheel, angles = commands[0], scale * commands[0] + offset, []
    for target in commands[place].tolist():
        steer = scale * angle + offset
        wheel = max(steer - 0.5 * play, min(wheel, steer + 0.5 * play))
        angles.append(wheel)
        step = (target - angle) * (1.0 - math.exp(-h / lag))
        angle += step if rate is None else max(-rate * h, min(step, rate * h))
    total = np.concatenate(([0.0], np.cumsum(angles) * h))
    edges = np.linspace(0.0, 4.95, 199)
    wheels = Wheels(times, commands, lag, rate)
    found = wheels.behind_play(edges, late, scale, offset, play)
    # Of the means of the steering over cells it would be off by 0.2 to 1 mrad s.
    assert found == pytest.approx(np.interp(edges, fine, total[:-1]), abs=1e-4)


def _chain_drive() -> Any:
    cell = 0.02
    edges = cell * np.arange(301)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return SimpleNamespace(
        edges=edges,
        cell=cell,
        t=edges[::3],
        times=edges[::5],
        commands=0.2 * np.sin(1.3 * edges[::5]),
        speed=6.0 + 2.0 * np.sin(middle),
        acceleration=2.0 * np.cos(middle),
        usual_speed=6.5,
    )


def test_chain_turns_the_car_as_its_formula_says() -> None:
    drive = _chain_drive()
    kinds: tuple[Any, ...] = ("wheels", 0.0), ("wheels", 0.06), ("yaw rate", 0.15), ("tyres", 0.15)
    # The slip is that of the turn that it makes; of the turn without it, it is nearly the same.
    for (kind, behind), (slip, close) in itertools.product(kinds, ((0.0, 1e-6), (0.012, 5e-5))):
        chain = Chain(drive, kind)
        lag, dead_time, offset, shift = 0.15, 0.07, 0.02, 3e-4
        values = {"turning_wheelbase": 2.6, "understeer": 0.003, "load_shift": shift}
        values["front_slip"] = slip
        values |= {"steer_offset": offset, "steer_lag": lag, "dead_time": dead_time}
        values |= {"tyre_lag": behind} if kind == "wheels" else {}
        wheels = Wheels(drive.times, drive.commands, lag - behind, None)
        total = wheels.integral(drive.edges - dead_time)
        angle = np.diff(total) / drive.cell + offset
        v = drive.speed
        length, rate = 2.6 + (0.003 + shift * drive.acceleration) * v**2, 0.0 * v
        for _ in range(9 if slip else 1):
            front, rear = slip * v * rate, (slip + 2.6 / v**2 - length / v**2) * v * rate
            side = np.tan(angle - front / np.cos(angle)) + front
            rate = v * (side + np.tan(rear) - rear) / length
        if behind:
            state, means, axle = rate[0], [], max(slip - 0.003, 0.0)  # the rear axle's slip
            poles = (behind / 6.5 + axle) * (2.6 + 0.003 * 6.5**2)
            for k, given in enumerate(rate.tolist()):
                tau = behind if kind == "yaw rate" else v[k] * (poles / length[k] - axle)
                # The mean of a first-order response over a cell, by fine steps of it.
                fine = given + (state - given) * np.exp(-np.linspace(0.0, drive.cell, 2001) / tau)
                means.append(float(np.mean(0.5 * (fine[1:] + fine[:-1]))))
                state = fine[-1]
            rate = np.array(means)
        found = chain.rate(**values)
        assert found == pytest.approx(rate, abs=close), kind
        yaw = chain.yaw(**values)
        heading = np.concatenate(([0.0], np.cumsum(rate))) * drive.cell
        assert yaw == pytest.approx(np.interp(drive.t, drive.edges, heading), abs=close)


def test_chain_remembers_the_wheels_of_its_last_lags_and_limits() -> None:
    chain = Chain(_chain_drive(), "wheels")
    first = chain.wheels(0.1)
    assert chain.wheels(0.1) is first
    assert chain.wheels(0.1, 0.5) is not first
    assert chain.wheels(0.1, 0.5).rate == 0.5
    other = Chain(_chain_drive(), "tyres")
    assert other.wheels(0.1) is other.wheels(0.2)


def _positions(
    rear: float, slip: float, bias: float = 0.0, excess: float = 0.0
) -> tuple[Any, np.ndarray]:
    """A drive of 30 s whose point moves as the docstring of `point` says, along chords of arcs."""
    t = DT * np.arange(600)
    yaw = 0.6 * np.sin(0.5 * t) + 0.1 * t
    speed = 7.0 + 3.0 * np.sin(0.3 * t)
    x, y, place = [5.0], [-3.0], [0.0j]
    for k in range(599):
        turn, step = yaw[k + 1] - yaw[k], t[k + 1] - t[k]
        middle, v = yaw[k] + 0.5 * turn, 0.5 * (speed[k] + speed[k + 1])
        chord = v * step * np.sinc(0.5 * turn / math.pi)
        place.append(place[-1] + chord * np.exp(1j * middle))
        ahead = (1.0 + excess) * chord
        left, middle = -(rear + slip * v * v) * 2.0 * math.sin(0.5 * turn), middle + bias
        x.append(x[-1] + ahead * math.cos(middle) - left * math.sin(middle))
        y.append(y[-1] + ahead * math.sin(middle) + left * math.cos(middle))
    given = {"t": t, "yaw": yaw, "sample_speed": speed, "unbroken": [slice(0, len(t))]}
    ready = SimpleNamespace(
        **given,
        x=np.array(x),
        y=np.array(y),
        place=np.array(place),
        usual_step=DT,
        parts=lambda: [slice(20, 600)],
        least_noise={"position": 1e-3},
        speed_noise=1e-3,
    )
    return ready, yaw


def test_point_of_the_car_is_found_where_it_was() -> None:
    from popsteer.identification.point import NAMES, fit_point

    ready, yaw = _positions(-1.3, 0.002, 0.01, -0.02)
    found = fit_point(ready, yaw, ready.place, 0.9)
    assert [found.values[name] for name in NAMES] == pytest.approx(
        [-1.3, 0.002, 0.01, -0.02], abs=1e-7
    )
    random = np.random.default_rng(7)
    misses = []
    for _ in range(6):
        noisy: Any = SimpleNamespace(**vars(ready))
        noisy.x = ready.x + random.normal(0.0, 0.02, 600)
        noisy.y = ready.y + random.normal(0.0, 0.02, 600)
        noisy.x[300] += 4.0  # which weighs as little as it should
        one = fit_point(noisy, yaw, ready.place, 0.9)
        assert one.noise == pytest.approx(0.02, rel=0.2)
        true = dict(zip(NAMES, (-1.3, 0.002, 0.01, -0.02), strict=True))
        misses += [(one.values[name] - true[name]) / one.errors[name] for name in NAMES]
        weights = np.array([1.0, 36.0, 0.0, 0.0])
        assert one.error_at(6.0) == one.known.error(weights) < one.errors["rear_axle"]
        assert one.split(6.0) == one.known.split(weights)
    assert 0.4 < np.sqrt(np.mean(np.square(misses))) < 1.6


def test_simulated_motion_restarts_every_ten_seconds_and_is_off_to_the_left() -> None:
    from popsteer.identification.result import _starts, compared

    ready, yaw = _positions(-1.3, 0.002, 0.01)
    assert _starts(ready) == [0, 20, 220, 420]
    log: Any = SimpleNamespace(t=ready.t, x=ready.x, y=ready.y)
    values = {"rear_axle": -1.3, "slip": 0.002, "heading_bias": 0.01}
    point: Any = SimpleNamespace(values=values)
    records = compared(log, ready, yaw, 0.5, point)
    assert records["simulated_x"] == pytest.approx(ready.x, abs=1e-9)
    assert records["simulated_y"] == pytest.approx(ready.y, abs=1e-9)
    assert records["position_error"] == pytest.approx(np.zeros(600), abs=1e-9)
    assert records["simulated_yaw_rate"] == pytest.approx(records["yaw_rate"])
    assert records["yaw_rate"][1:] == pytest.approx(np.diff(yaw) / DT)
    assert records["yaw_rate"][0] == 0.0
    assert np.flatnonzero(records["counts"]).tolist() == list(range(21, 600))
    # A car that has drifted 0.3 m to its left since sample 300, on the part that began at 220.
    late = np.arange(600) >= 300
    ready.x = ready.x - 0.3 * late * np.sin(yaw + 0.01)
    ready.y = ready.y + 0.3 * late * np.cos(yaw + 0.01)
    off = compared(log, ready, yaw, 0.5, point)["position_error"]
    assert off[300:420] == pytest.approx(0.3, abs=1e-6)
    assert off[:300] == pytest.approx(0.0, abs=1e-6)


def test_smoothed_walk_is_an_exponential_mean_both_ways() -> None:
    from popsteer.identification.point import smooth

    values = np.random.default_rng(8).standard_normal(80)
    for theta in (0.0, 0.8):
        wanted = values.copy()
        part = values[10:70]
        for _ in range(2):
            last = float(np.mean(part[: max(1, round(1.0 / (1.0 - theta)))]))
            kept = []
            for value in part:
                last = theta * last + (1.0 - theta) * value
                kept.append(last)
            part = np.array(kept)[::-1]
        wanted[10:70] = part
        ready: Any = SimpleNamespace(parts=lambda: [slice(10, 70)])
        assert smooth(values, theta, ready) == pytest.approx(wanted)


def test_rounded_commands_are_taken_without_their_stairs() -> None:
    times = 0.05 * np.arange(400)
    # A car of a field: it turns to and fro, and holds an angle between two levels for 2 s.
    smooth = np.where(times < 12.0, 0.3 * np.sin(0.4 * times), 0.3 * np.sin(4.8))
    for digits, step in ((9, 0.02), (4, math.radians(1.0))):
        recorded = np.round(step * np.round(smooth / step), digits)
        assert rounding.grain_of(recorded) == pytest.approx(step, rel=1e-3)
        found = unrounded(times, recorded, step)
        moves = times < 11.0
        assert np.std((found - smooth)[moves]) < 0.5 * np.std((recorded - smooth)[moves])
        assert np.max(np.abs(found - smooth)) < 0.75 * step
        assert abs(np.mean((found - smooth)[moves])) < 0.05 * step
        assert found[-1] == recorded[-1]
    # Commands of a program, which jump from angle to angle, are what they are.
    jumps = np.repeat([0.1, -0.3, 0.2, 0.0, 0.3, -0.1, -0.2, 0.1], 50)
    assert unrounded(times, jumps, 0.1) is jumps
    assert rounding.grain_of(np.array([0.1, 0.3, 0.35, 0.4142])) == 0.0


def test_chain_gives_the_rates_of_one_that_remembers_nothing() -> None:
    base = {"turning_wheelbase": 2.6, "understeer": 0.003, "load_shift": 3e-4, "front_slip": 0.01}
    base |= {
        "steer_offset": 0.02,
        "steer_lag": 0.15,
        "dead_time": 0.07,
        "steer_scale": 0.9,
        "max_steer_rate": 0.1,
    }
    for kind in ("wheels", "yaw rate", "tyres"):
        chain, seen = Chain(_chain_drive(), kind), []
        for play in (0.0, 0.03):
            start = base | {"steer_play": play}
            for values in (start, *(start | {name: 1.1 * start[name]} for name in start), start):
                seen.append(chain.rate(**values))
                assert (seen[-1] == Chain(_chain_drive(), kind).rate(**values)).all(), values
        # Each parameter counts: the first of all once with its moved play, which is 0.
        assert len({each.tobytes() for each in seen}) == 2 * (len(base) + 1) + 1
