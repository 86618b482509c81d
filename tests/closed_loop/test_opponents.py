"""Path trackers of others: their formulas, and what they have to keep."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_discrete_are
from scipy.spatial import KDTree

import popsteer
from popsteer import own, sim, tracks
from popsteer.lab import opponents
from popsteer.lab.opponents.lqr import cost_to_go, model, weights
from popsteer.lab.opponents.mpc import Mpc, Weights
from popsteer.lab.opponents.observer import Ahead
from popsteer.lab.opponents.pure_pursuit import AutowareGains, AutowarePurePursuit
from popsteer.lab.suite import suite_car
from popsteer.lab.suite.drive import drive, seed_of
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS
from popsteer.sim.geometry import object_of
from studies import solvers
from studies.limits import Slalom
from tests.helpers import ROOT, looped

if TYPE_CHECKING:
    from pathlib import Path

    from popsteer.lab.opponents import Seen

CAR = popsteer.Vehicle(
    wheelbase=2.7, rear_axle=-1.35, max_steer=0.6, max_steer_rate=0.8, steer_lag=0.1
)
NAMES = opponents.names()


def made(name: str, path: popsteer.Path, car: popsteer.Vehicle = CAR) -> Any:
    if name.endswith("Mpc"):
        pytest.importorskip("daqp")
    kind = own.load("controller", name)
    return kind(path, car, kind.Params())


class Line:
    """A curve of the plane by its heading over the arc length, and waypoints on it."""

    def __init__(self, curvature: float, rate: float, length: float) -> None:
        self.curvature, self.rate = curvature, rate
        self.s = np.linspace(0.0, length, 20_001)
        middle = 0.5 * (self.s[1:] + self.s[:-1])
        yaw = curvature * middle + 0.5 * rate * middle * middle
        steps = self.s[1] * np.column_stack((np.cos(yaw), np.sin(yaw)))
        self.xy = np.vstack(((0.0, 0.0), np.cumsum(steps, axis=0)))

    def at(self, s: Any) -> Any:
        """Position and direction at an arc length."""
        x, y = (np.interp(s, self.s, each) for each in self.xy.T)
        return x, y, self.curvature * s + 0.5 * self.rate * s * s

    def waypoints(self, spacing: float, *, even: bool) -> Any:
        """Every `spacing`, or at distances of 0.6 to 1.4 of it."""
        draws = np.random.default_rng(3).uniform(0.6, 1.4, 1000) if not even else np.ones(1000)
        s = spacing * np.concatenate(([0.0], np.cumsum(draws)))
        return np.column_stack(self.at(s[s < self.s[-1]])[:2])


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("shape", ["circle", "uneven circle", "clothoid"])
@looped("wheelbase", (0.16, 0.33, 2.7, 12.0))
def test_opponents_exactly_on_a_line_see_no_error_and_hold_their_wheels(
    wheelbase: float, shape: str, reverse: bool
) -> None:
    car = popsteer.Vehicle(wheelbase=wheelbase, rear_axle=-0.4 * wheelbase, max_steer=0.6)
    bend, rate = (0.1, 0.0) if "circle" in shape else (0.0, 0.006)
    line = Line(bend / wheelbase, rate / wheelbase**2, 30.0 * wheelbase)
    even = shape != "uneven circle"
    xy = line.waypoints(0.37 * wheelbase, even=even)
    path = popsteer.Path(xy, reverse=[reverse] * len(xy))
    speed, dt, side = 2.0 * wheelbase, 0.05, -1.0 if reverse else 1.0
    for name in NAMES:
        wheels = []
        for s in wheelbase * np.linspace(8.0, 20.0, 24):
            x, y, yaw = line.at(s)
            yaw = math.remainder(yaw + math.pi * reverse, math.tau)
            x, y = (x, y) - car.rear_axle * np.array((math.cos(yaw), math.sin(yaw)))
            # A fresh one at each place: nothing is estimated of a car that is moved by hand.
            opponent = made(name, path, car)
            seen = opponent.observer.see(x, y, yaw, side * speed, dt)
            assert abs(seen.error) < 2e-5 * wheelbase, (name, s)
            assert abs(seen.heading) < 3e-4, (name, s)
            ahead = wheelbase * np.array((0.0, 0.11, 0.9, 2.3))
            wanted = line.curvature + line.rate * (s + 0.5 * (ahead[1:] + ahead[:-1]))
            found = wheelbase * opponent.observer.curvature(seen, ahead)
            assert found == pytest.approx(wheelbase * wanted, abs=1e-3), (name, s)
            wheels.append(made(name, path, car).step(x, y, yaw, side * speed, dt))
        if "circle" in shape:
            assert np.ptp(wheels) < 1e-4, name


@looped("name", NAMES)
def test_opponents_on_a_circle_come_to_hold_their_wheels(name: str) -> None:
    line = Line(1.0 / 25.0, 0.0, 150.0)
    path = popsteer.Path(line.waypoints(1.0, even=True))
    start = line.at(5.0)
    plant = sim.KinematicBicycle(CAR.replace(rear_axle=0.0))
    run = sim.run(
        made(name, path, plant.vehicle), plant, path=path, start=start, constant_speed=5.0
    )
    held = run.records["steer"][(run.records["time"] > 10.0) & (run.records["time"] < 20.0)]
    assert np.ptp(held) < 1e-4
    assert held[-1] == pytest.approx(math.atan(2.7 / 25.0), abs=2e-4)


def test_opponents_see_no_error_on_both_sides_of_a_cusp() -> None:
    # Forward with the wheels to the left, then backwards with them to the right.
    first, radius = np.arange(0.0, 15.0, 1.0), 20.0
    x, y = radius * np.sin(first / radius), radius * (1.0 - np.cos(first / radius))
    end = float(first[-1] / radius)
    away = np.arange(1.0, 15.0, 1.0) / radius
    centre = x[-1] + radius * math.sin(end), y[-1] - radius * math.cos(end)
    back = centre + radius * np.column_stack((-np.sin(end + away), np.cos(end + away)))
    xy = np.vstack((np.column_stack((x, y)), back))
    path = popsteer.Path(xy, reverse=np.arange(len(xy)) >= len(first) - 1)
    car = popsteer.Vehicle(wheelbase=2.7, max_steer=0.6)
    opponent, legs = made(NAMES[1], path, car), set()
    for k in range(130):
        s = 4.0 + 0.16 * k
        if s <= first[-1]:
            speed, yaw = 3.2, float(s / radius)
            at = radius * math.sin(yaw), radius * (1.0 - math.cos(yaw))
        else:
            speed, yaw = -3.2, float(end + (s - first[-1]) / radius)
            at = centre[0] - radius * math.sin(yaw), centre[1] + radius * math.cos(yaw)
        seen = opponent.observer.see(*at, yaw, speed, 0.05)
        if abs(s - first[-1]) > 0.3:
            assert opponent.observer.reverse is (speed < 0.0)
            assert abs(seen.error) < 1e-4, s
            assert abs(seen.heading) < 1e-4, s
            # Over a tenth of the wheelbase, which begins or ends at the car.
            bend = opponent.observer.bend(seen, -0.27 * (speed > 0.0))
            assert bend == pytest.approx(1.0 / radius, abs=1e-3), s
            legs.add(opponent.observer.reverse)
    assert legs == {False, True}


def test_opponent_keeps_its_place_when_the_path_is_sent_anew() -> None:
    # Two laps, the second half a metre outside of the first: after a while the car is nearer to it.
    angle = np.arange(0.0, 4.0 * math.pi, 0.05)
    radius = 20.0 + 0.5 * (angle > 2.0 * math.pi)
    xy = np.column_stack((radius * np.sin(angle), 20.0 - radius * np.cos(angle)))
    arcs = popsteer.Path(xy).s
    for name in NAMES:
        opponent = made(name, popsteer.Path(xy))
        for k in range(200):
            yaw = 1.0 + 0.02 * k
            out = 20.0 + min(0.01 * k, 0.4)
            opponent.set_path(popsteer.Path(xy))
            opponent.step(out * math.sin(yaw), 20.0 - out * math.cos(yaw), yaw, 8.0, 0.05)
            found = opponent.observer._segment
            assert abs(arcs[found] - 20.0 * yaw) < 3.0, (name, k)


@looped("name", NAMES)
def test_opponent_on_a_fresh_path_sees_what_one_that_begins_there_sees(name: str) -> None:
    # The same bend again: begun later, with other waypoints, and a third of a metre to the left.
    line = Line(0.0, 0.0004, 150.0)
    car = CAR.replace(rear_axle=0.0)
    first = popsteer.Path(line.waypoints(1.0, even=True))
    x, y, yaw = line.at(np.arange(10.0, 140.0, 0.4))
    aside = np.column_stack((x - np.sin(yaw) / 3.0, y + np.cos(yaw) / 3.0))
    opponent = made(name, first, car)
    for step in range(80):
        opponent.step(*line.at(20.0 + 0.4 * step), 8.0, 0.05)
    pose = *line.at(52.0), 8.0, 0.05
    fresh = made(name, popsteer.Path(aside), car)
    opponent.set_path(fresh.path)
    fresh.observer.steer, fresh.observer.wheel = opponent.observer.steer, opponent.observer.wheel
    seen, wanted = opponent.observer.see(*pose), fresh.observer.see(*pose)
    assert wanted.error == pytest.approx(-1.0 / 3.0, abs=2e-3)
    assert seen.segment == wanted.segment
    assert seen.arc == pytest.approx(wanted.arc, abs=1e-6)
    assert seen.error == pytest.approx(wanted.error, abs=1e-6)
    assert seen.heading == pytest.approx(wanted.heading, abs=2e-3)  # slip has been estimated
    ahead = np.array((0.0, 2.0, 5.0))
    for each in (opponent, fresh):
        bends = each.observer.curvature(seen, ahead)
        assert bends == pytest.approx(0.0004 * np.array((53.0, 55.5)), abs=2e-4)
    angles = [each.step(*line.at(52.4), 8.0, 0.05) for each in (opponent, fresh)]
    assert angles[0] == pytest.approx(angles[1], abs=5e-3)


def straight() -> popsteer.Path:
    return popsteer.Path([(float(x), 0.0) for x in range(0, 201, 2)])


@pytest.mark.parametrize("name", NAMES)
def test_opponents_follow_a_slalom_both_ways_within_the_limits_of_the_car(name: str) -> None:
    xy = tracks.get("slalom").xy
    allowed = 0.9 if "Autoware" in name else 0.03
    for reverse in (False, True):
        path = popsteer.Path(xy, reverse=[reverse] * len(xy))
        car = CAR.replace(max_lateral_acceleration=4.0)
        plant = sim.KinematicBicycle(car)
        start = sim.default_start(path, 0.0, car)
        run = sim.run(made(name, path, car), plant, path=path, start=start, constant_speed=6.0)
        assert run.metrics.finished, (name, run.ending)
        assert run.metrics.rear_axle_max_abs_cross_track_error < allowed, (name, reverse)
        rates = np.diff(run.records["steer"]) / run.dt
        assert np.abs(rates).max() <= CAR.max_steer_rate + 1e-9  # type: ignore[operator]
        lateral = run.records["speed"] ** 2 * np.tan(run.records["steer"]) / CAR.wheelbase
        assert np.abs(lateral[40:]).max() < 4.1


@looped("name", NAMES)
def test_mirrored_world_gives_the_mirrored_angle(name: str) -> None:
    xy = tracks.get("double-lane-change").xy[:120]
    pair = [made(name, popsteer.Path(xy * (1.0, side))) for side in (1.0, -1.0)]
    x, y = xy[10]
    for k in range(40):
        at = x + 0.4 * k
        left, right = (
            each.step(at, side * (y + 0.2), side * 0.03, 8.0, 0.05)
            for each, side in zip(pair, (1.0, -1.0), strict=True)
        )
        assert left == pytest.approx(-right, abs=1e-9)


def test_model_predictive_controller_is_the_regulator_where_no_limit_binds() -> None:
    pytest.importorskip("daqp")
    lqr, mpc = (
        kind(straight(), CAR, kind.Params(heading=3.0, change=10.0))
        for kind in (own.load("controller", NAMES[1]), own.load("controller", NAMES[0]))
    )
    for k in range(20):
        given = (20.0 + 0.4 * k, 0.01, 0.002, 8.0, 0.05)
        assert mpc.step(*given) == pytest.approx(lqr.step(*given), abs=1e-6)


def test_regulator_has_the_cost_of_its_riccati_equation_and_the_model_of_its_equations() -> None:
    a, b = model(8.0, 2.7, 0.1, 1.0, 0.05)
    q, r = weights(2.7, 3.0, 10.0)
    p = cost_to_go(a, b, q, r)
    assert np.allclose(p, solve_discrete_are(a, b, q, r), rtol=1e-9)
    assert np.allclose(p, p.T, rtol=1e-9)
    # The model over a period against a fine integration of its equations.
    e = psi = 0.0
    wheel, steer, speed, length, lag, fine = 0.02, 0.05, 8.0, 2.7, 0.1, 1e-5
    for _ in range(round(0.05 / fine)):
        e, psi = e + fine * speed * psi, psi + fine * speed * wheel / length
        wheel += fine * (steer - wheel) / lag
    found = a @ np.array([0.0, 0.0, 0.02, 0.05])
    assert found[1:3] == pytest.approx((psi, wheel), rel=1e-3)
    assert found[0] == pytest.approx(e, rel=0.2)  # its mean angle is taken as constant


def test_autowares_lookahead_distance_is_that_of_its_parameters() -> None:
    chased = AutowarePurePursuit(
        straight(), CAR.replace(wheelbase=2.79), AutowareGains(velocity_ratio=2.4)
    )
    for speed, y, wanted in ((1.0, 0, 4.35), (3.0, 0.2, 7.2), (3.0, 0.8, 7.2 + 2.88), (9.0, 0, 15)):
        chased.reset()
        eye = chased.observer
        asked: list[float] = []

        def towards(seen: Seen, distance: float, asked: list[float] = asked) -> tuple[float, float]:
            asked.append(distance)
            return distance, 0.0

        eye.towards = towards  # type: ignore[method-assign]
        chased.step(20.0, y, 0.0, speed, 0.05)
        assert asked == pytest.approx([wanted], rel=1e-6)


def test_observer_knows_offset_and_dead_time() -> None:
    car = CAR.replace(dead_time=0.2, steer_offset=0.02)
    path = straight()
    run = sim.run(
        made(NAMES[1], path, car), sim.KinematicBicycle(car), path=path, constant_speed=8.0
    )
    assert run.records["steer"][-20:] == pytest.approx(-0.02, abs=1e-3)
    assert run.metrics.rear_axle_settled_max_abs_cross_track_error < 0.2
    assert math.isclose(float(run.records["rear_cross_track_error"][-1]), 0.0, abs_tol=0.01)


def test_opponents_look_ahead_across_the_seam_of_a_path_with_cusps() -> None:
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


def test_mpc_far_beside_a_slalom_returns_behind_wheels_that_turn_slowly() -> None:
    pytest.importorskip("daqp")
    metrics = Slalom("carla-identified", 0.2, 8.0).drive("mpc")
    assert metrics.settled_mean_abs_cross_track_error < 0.2


def test_problem_by_stages_costs_what_the_condensed_one_does() -> None:
    pytest.importorskip("daqp")
    driven = solvers.courses(solvers.Recorded, "noise", ["slalom"])
    # The last is from 3 m aside.
    driven += solvers.courses(solvers.Recorded, solvers.ASIDE)[-1:]
    q, r = weights(2.7, Weights().heading, Weights().change)
    random = np.random.default_rng(0)
    courses = [solvers.problems(course)[0] for course in driven]
    for given, k in [(each, k) for each in courses for k in range(0, len(each["fresh"]), 50)]:
        last = np.flatnonzero(given["fresh"][: k + 1])[-1]
        a, b = given["dynamics"][k], given["inputs"][k]
        p = cost_to_go(a, b, q, r)

        def staged(
            changes: Any, given: Any = given, k: int = k, a: Any = a, b: Any = b, p: Any = p
        ) -> float:
            x, cost = given["start"][k], 0.0
            for stage, change in enumerate(changes, 1):
                x = a @ x + b[:, 0] * change
                off = x - given["wanted"][k][stage]
                cost += off @ (p if stage == len(changes) else q) @ off + r[0, 0] * change**2
            return 0.5 * cost

        assert np.array_equal(given["hessian"][k], given["hessian"][last])
        changes = 0.05 * random.standard_normal(20)
        condensed = 0.5 * changes @ given["hessian"][k] @ changes + given["gradient"][k] @ changes
        assert staged(changes) - staged(0.0 * changes) == pytest.approx(condensed, rel=1e-6)


@looped("name", ("double-lane-change", "racetrack"))
def test_cubics_that_the_whole_mpc_is_told_are_the_headings_of_the_path(name: str) -> None:
    path = SCENARIOS[name].path()
    cubics = solvers.cubics(path, CAR)
    arcs = np.append(path.s, path.length) if path.closed else path.s
    for segment in range(0, len(cubics), 7):
        share = np.linspace(0.05, 0.95, 7)
        at = share * (arcs[segment + 1] - arcs[segment])
        wanted = Ahead(path, CAR).headings(segment, float(arcs[segment]), at)
        found = np.polynomial.polynomial.polyval(share, cubics[segment])
        apart = np.cos(found - wanted)
        assert apart == pytest.approx(1.0, abs=1e-15), (name, segment)


def test_mpc_in_c_answers_as_the_one_in_python() -> None:
    sources = ROOT / "out" / "solvers"
    if not list(sources.glob("daqp-*.tar.gz")):
        pytest.skip("needs daqp's sources: `pydoc studies.solvers` says whence")
    whole = solvers.build(sources, "daqp", "mpc_daqp.c", *solvers.DAQP)
    for condition, names in (("noise", ["hairpin", "zigzag", "beside"]), (solvers.ASIDE, [])):
        for course in solvers.courses(solvers.Recorded, condition, names):
            commands, _ = solvers.by_whole(whole, course, Ahead(course.path, course.car).path)
            assert commands == pytest.approx(course.commands, abs=solvers.AGREE)


def splined(path: popsteer.Path, car: popsteer.Vehicle) -> Mpc:
    """The MPC, told error, heading and curvature of a cubic spline by scipy, and not of `Path`."""
    mpc, xy = Mpc(path, car, Weights()), np.column_stack((path.x, path.y))
    spline = CubicSpline(np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T))), xy)
    at = np.linspace(0.0, spline.x[-1], round(100.0 * spline.x[-1]))
    place, tangent = spline(at), spline(at, 1)
    yaws = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
    arcs = np.append(0.0, np.cumsum(np.hypot(*np.diff(place, axis=0).T)))
    observed, point, places = mpc.observer.see, mpc.tracked_point, KDTree(place)

    def see(x: float, y: float, yaw: float, speed: float, dt: float) -> Seen:
        seen = observed(x, y, yaw, speed, dt)
        x, y = x + point * math.cos(yaw), y + point * math.sin(yaw)
        nearest = int(places.query((x, y))[1])
        along, (dx, dy) = yaws[nearest], (x, y) - place[nearest]
        arc = arcs[nearest] + math.cos(along) * dx + math.sin(along) * dy
        heading = yaw - float(np.interp(arc, arcs, yaws)) + mpc.observer.eye.estimate.slip
        aside = math.cos(along) * dy - math.sin(along) * dx
        return seen._replace(error=aside, heading=heading, arc=arc)

    def curvature(seen: Seen, distances: Any) -> Any:
        return np.diff(np.interp(seen.arc + distances, arcs, yaws)) / np.diff(distances)

    mpc.observer.see, mpc.observer.curvature = see, curvature  # type: ignore[method-assign]
    return mpc


SMOOTH = (
    "double-lane-change",
    "obstacle-avoidance",
    "step-steer",
    "slalom",
    "hairpin",
    "racetrack",
)


@pytest.mark.parametrize(
    ("condition", "most", "draws"), [("as told", 0.01, [()]), ("noise", 0.02, [(), ("1",), ("2",)])]
)
def test_mpc_errs_as_one_that_is_told_a_spline(
    condition: str, most: float, draws: list[tuple[str, ...]]
) -> None:
    # Of noise three draws: one alone is off by 1 % either way.
    pytest.importorskip("daqp")
    ratios = []
    movers = (suite_car(), object_of("carla-identified"))
    for name, mover, draw in itertools.product(SMOOTH, movers, draws):
        ours, theirs = (
            drive(
                SCENARIOS[name], CONDITIONS[condition], mover, make, seed_of(name, condition, *draw)
            ).metrics.rear_axle_mean_abs_cross_track_error
            for make in (splined, lambda path, car: Mpc(path, car, Weights()))
        )
        if condition == "as told":
            assert ours == pytest.approx(theirs, rel=0.02, abs=1e-6), name
        ratios.append(max(ours, 1e-5) / max(theirs, 1e-5))  # as the suite counts them
    assert math.exp(np.mean(np.log(ratios))) == pytest.approx(1.0, abs=most)


def test_solvers_whose_sources_are_missing_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["solvers", str(tmp_path)])
    with pytest.raises(SystemExit, match=r"holds no daqp-\*.tar.gz"):
        solvers.main()
