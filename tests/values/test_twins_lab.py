"""Runs, sweeps, tunings, replays and plans of a path backwards, and mirrored, beside forwards."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import controllers, planning, sim
from popsteer.lab import replay, sweep, tune
from popsteer.lab.common.varied import distribution, run_seed
from popsteer.logs import Log
from popsteer.planning import SpeedLimits, speed_profile
from tests.values.tables import BACKWARDS, MIRRORED, SELF, Twin

CAR = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, steer_lag=0.1, dead_time=0.05)
STRAIGHT = [(0.5 * k, 0.0) for k in range(121)]
X = np.arange(0.0, 120.0, 0.5)
BENDS = np.column_stack((X, 3.0 * np.sin(X / 9.0)))


def test_run_backwards_is_the_run_forwards_turned_by_half_a_turn() -> None:
    for options in ({"constant_speed": 4.0}, {"constant_speed": 4.0, "speed": 0.0}):
        found = []
        for twin in (SELF, BACKWARDS):
            path = twin.path(STRAIGHT)
            controller = popsteer.PreviewPop(path, CAR)
            asked: dict[str, Any] = {"start": (0.0, 0.0, 0.0), "start_at": "rear", **options}
            run = sim.run(controller, sim.KinematicBicycle(CAR), **asked)
            found.append((run, twin.columns(dict(run.records))))
        (forth, one), (back, other) = found
        assert (forth.ending, back.ending) == ("finished", "finished")
        assert one["speed"][0] == other["speed"][0] == options.get("speed", 4.0)
        both = min(len(one["x"]), len(other["x"]))
        assert both > 250
        assert other["speed"][:both] == pytest.approx(one["speed"][:both], abs=0.02)
        assert back.metrics.max_abs_steer == pytest.approx(0.0, abs=1e-6)
        assert back.metrics.mean_speed == pytest.approx(forth.metrics.mean_speed, abs=0.1)


def test_default_start_backwards_has_the_rear_axle_where_forwards_the_front_is() -> None:
    for side in (0.0, 0.5, -0.5):
        x, y, yaw = sim.default_start(SELF.path(STRAIGHT), side, CAR)
        assert (x, y, yaw) == pytest.approx((-1.35, side, 0.0))
        x, y, yaw = sim.default_start(BACKWARDS.path(STRAIGHT), side, CAR)
        # Backwards along -x the nose points to +x, and left of the path is -y.
        assert (x, y, yaw) == pytest.approx((1.35, -side, 0.0), abs=1e-9)


def _job(twin: Twin, **changes: Any) -> sweep.Job:
    vary = {"noise_speed": distribution("noise_speed", "0")}
    given: dict[str, Any] = {"vary": vary, "runs": 1, "vehicle": CAR, "start_offset": 0.0}
    plant = sim.KinematicBicycle(CAR)
    path = twin.path(STRAIGHT)
    return sweep.Job(
        path,
        "stanley",
        popsteer.StanleyParams(),
        plant,
        **{**given, "constant_speed": 4.0, **changes},
    )


def test_sweep_backwards_begins_at_the_speed_backwards() -> None:
    pytest.importorskip("scipy")
    for changes, speed in (({}, 4.0), ({"speed": 1.5}, 1.5)):
        for twin in (SELF, BACKWARDS):
            given = {name: twin.speed * value for name, value in changes.items()}
            run = sweep.repeat(_job(twin, **given), 0)
            assert run.records["speed"][0] == twin.speed * speed
            (row,) = sweep.drive(_job(twin, **given), [0])
            assert row["finished"]
            assert row["success"]
            assert row["time"] == run.metrics.time
            assert row["time"] == pytest.approx(60.0 / 4.0, abs=1.5)


def test_tuning_backwards_scores_as_forwards() -> None:
    pytest.importorskip("scipy")
    search = {"softening": distribution("softening", "uniform(0.5,2)")}
    params = popsteer.StanleyParams(softening=1.0)
    scores = []
    for twin in (SELF, BACKWARDS):
        problem = tune.Problem(
            {"straight": twin.path(STRAIGHT)},
            "stanley",
            params,
            search,
            sim.KinematicBicycle(CAR),
            {},
            cars=0,
            constant_speed=4.0,
        )
        scores.append(problem.score(params))
        name, road, made, seed = problem.scenarios[0]
        run = sim.run(
            popsteer.Stanley(road[0], CAR, params),
            made.plant,
            start=made.start,
            speed=twin.speed * 4.0,
            longitudinal=road[1],
        )
        assert scores[-1].errors[name] == (run.metrics.settled_mean_abs_cross_track_error,)
        assert seed == run_seed(0, 0)
    assert scores[0].error < 0.5
    assert scores[1].error < 0.5


def _log(twin: Twin, bends: float = 0.3) -> tuple[Log, np.ndarray]:
    """A drive along a wave of headings; backwards the car's nose points the other way."""
    t = 0.05 * np.arange(400)
    course = bends * np.sin(0.4 * t)
    speed = 5.0 + np.sin(0.3 * t)
    x, y = (np.cumsum(0.05 * speed * part) for part in (np.cos(course), np.sin(course)))
    steer = np.arctan(2.7 * np.gradient(course, t) / speed)
    return Log(t, x, twin.y * y, twin.yaw * course, speed, twin.steer * steer), course


def test_replay_mirrored_is_the_replay_mirrored() -> None:
    shadows = []
    for twin in (SELF, MIRRORED):
        log, _ = _log(twin)
        found = replay.run(log, dict.fromkeys(controllers.names()), CAR)
        shadows.append(found.shadows)
    for name in controllers.names():
        one, other = shadows[0][name], shadows[1][name]
        assert np.abs(one.steer).max() > 0.005, name
        for column in ("steer", "cross_track_error", "heading_error"):
            assert getattr(other, column) == pytest.approx(-getattr(one, column), abs=1e-6), name
        assert np.array_equal(one.status, other.status)


def test_own_path_backwards_has_the_places_of_the_one_forwards_and_its_speeds_negative() -> None:
    log, course = _log(SELF)
    nose = course + np.pi
    back = Log(log.t, log.x, log.y, nose, -log.speed, -log.steer)
    for ahead in (0.0, 1.35):
        forth = replay.own_path(log, ahead)
        found = replay.own_path(back, -ahead)
        assert forth.reverse is None
        assert found.reverse is not None
        assert found.reverse.all()
        assert found.x == pytest.approx(forth.x, abs=1e-9)
        assert found.y == pytest.approx(forth.y, abs=1e-9)
        assert found.speed == pytest.approx(-np.asarray(forth.speed), abs=1e-9)
        # The point ahead of the pose, along the nose.
        assert forth.x[0] == pytest.approx(log.x[0] + ahead, abs=0.05)


def test_speeds_backwards_are_those_forwards_with_the_other_sign() -> None:
    limits = {"max_acceleration": 1.0, "max_deceleration": 3.0, "max_lateral_acceleration": 2.0}
    for more in ({}, {"max_jerk": 4.0}):
        if more:
            pytest.importorskip("scipy")
        profiles = [
            speed_profile(twin.path(BENDS), SpeedLimits(**limits, **more), CAR)
            for twin in (SELF, BACKWARDS, MIRRORED)
        ]
        forth, back, mirrored = profiles
        assert back.speed == pytest.approx(forth.speed, abs=1e-6)
        assert mirrored.speed == pytest.approx(forth.speed, abs=1e-6)
        assert mirrored.curvature == pytest.approx(-forth.curvature, abs=1e-9)
        assert back.path.speed == pytest.approx(-forth.speed, abs=1e-6)
        assert forth.path.speed == pytest.approx(forth.speed, abs=0.0)
        assert back.acceleration == pytest.approx(forth.acceleration, abs=1e-5)
        assert back.time == pytest.approx(forth.time)


def test_smoothed_recording_backwards_and_mirrored_is_the_one_forwards() -> None:
    pytest.importorskip("scipy")
    noisy = BENDS + np.random.default_rng(0).normal(0.0, 0.02, BENDS.shape)
    forth, back, mirrored = (
        planning.smooth(twin.path(noisy), 0.1) for twin in (SELF, BACKWARDS, MIRRORED)
    )
    assert forth.reverse is None
    assert back.reverse is not None
    assert back.reverse.all()
    assert np.asarray(back.x) == pytest.approx(-np.asarray(forth.x), abs=1e-6)
    assert np.asarray(back.y) == pytest.approx(np.asarray(forth.y), abs=1e-6)
    assert np.asarray(mirrored.y) == pytest.approx(-np.asarray(forth.y), abs=1e-6)


def test_closed_loop_mirrored_steers_to_the_other_side() -> None:
    for name in controllers.names():
        found = []
        for twin in (SELF, MIRRORED):
            path = twin.path(BENDS)
            controller: Any = controllers.get(name).controller(path, CAR)
            start = twin.pose(*sim.default_start(SELF.path(BENDS), 0.5, CAR))
            run = sim.run(controller, sim.KinematicBicycle(CAR), start=start, constant_speed=5.0)
            found.append(twin.columns(dict(run.records)))
        for column in ("x", "y", "yaw", "speed", "steer", "cross_track_error"):
            assert found[1][column] == pytest.approx(found[0][column], abs=1e-6), (name, column)
