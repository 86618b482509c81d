"""Metrics, pedals, beliefs and seeds of runs against calculations from their records."""

from __future__ import annotations

import gc
import math
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import Status, controllers, planning, sim
from popsteer.lab import compare
from popsteer.sim.pedals import PedalMap, check_longitudinal
from popsteer.sim.steering import believed, informed

X = np.arange(0.0, 90.0, 0.5)
PATH = popsteer.Path(np.column_stack((X, 2.0 * np.sin(X / 8.0))), speed=6.0 + 0.0 * X)
CAR = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, steer_lag=0.1)


def test_metrics_are_those_of_the_records() -> None:
    settings = sim.Settings(settling_time=3.0, dt=0.1)
    run = sim.run(
        popsteer.Stanley(PATH, CAR),
        sim.KinematicBicycle(CAR),
        longitudinal=popsteer.SpeedPid(),
        settings=settings,
        speed=4.0,
    )
    records, found = run.records, run.metrics
    settled = records["time"] >= 3.0 - 1e-9
    for part, rows in (("", slice(None)), ("settled_", settled)):
        for name in ("cross_track_error", "heading_error"):
            values = records[name][rows]
            for kind, expected in (
                ("mean_abs", np.abs(values).mean()),
                ("rms", math.sqrt((values**2).mean())),
                ("max_abs", np.abs(values).max()),
            ):
                metric = getattr(found, f"{part}{kind}_{name}")
                assert metric == pytest.approx(expected, rel=0.03), (part, kind, name)
    assert found.max_abs_steer == pytest.approx(np.abs(records["steer"]).max())
    rate = np.diff(records["steer"]) / 0.1
    assert found.rms_steer_rate == pytest.approx(math.sqrt((rate**2).mean()), rel=0.02)
    assert found.mean_speed == pytest.approx(records["speed"].mean(), rel=0.02)
    assert found.steps == len(records["time"])
    assert found.time == pytest.approx(0.1 * found.steps)
    assert found.finished
    assert found.faults == Status.OK
    assert run.dt == 0.1


def test_pedals_give_the_acceleration_that_they_were_asked_for() -> None:
    pedals = PedalMap(drive=3.0, braking=8.0, drag=0.05, air_drag=0.002)
    for wanted in (-12.0, -8.0, -2.0, -0.1, 0.0, 0.1, 1.0, 2.5, 9.0):
        for speed in (-3.0, 0.0, 1.0, 20.0):
            throttle, brake = pedals(wanted, speed)
            resistance = 0.05 * speed + 0.002 * speed * abs(speed)
            given = 3.0 * throttle - 8.0 * brake - resistance
            assert given == pytest.approx(min(max(wanted, -8.0 - resistance), 3.0 - resistance))
            assert min(throttle, brake) == 0.0
            assert max(throttle, brake) <= 1.0


def test_pedals_of_a_plant_are_its_own() -> None:
    every: list[Any] = [sim.CarlaIdentified(drive=2.0, braking=7.0, drag=0.3, air_drag=0.004)]
    every += [sim.KinematicBicycle(CAR, drive=2.5, braking=6.0, drag=0.2)]
    for plant in every:
        own = plant.as_dict()
        assert PedalMap.of(plant).as_dict() == {
            "drive": own["drive"],
            "braking": own["braking"],
            "drag": own["drag"],
            "air_drag": own.get("air_drag", 0.0),
        }
    assert PedalMap.of("kinematic-bicycle") == PedalMap.of(sim.KinematicBicycle())
    assert PedalMap.of("carla-identified") == PedalMap.of(sim.CarlaIdentified())
    if find_spec("vehiclemodels"):
        other: Any = sim.geometry.object_of("commonroad-st-1")
        assert PedalMap.of(other).drive == other.params.drive


def test_tracker_of_speeds_is_refused_where_the_path_is_another() -> None:
    xy = np.column_stack((PATH.x, PATH.y))
    tracker = popsteer.SpeedTracker(PATH, CAR)
    check_longitudinal(tracker, popsteer.Path(xy, speed=4.0 + 0.0 * X), CAR)
    for other in (
        popsteer.Path(xy + 1e-3),
        popsteer.Path(xy * (1.0, 1.001)),
        popsteer.Path(xy, closed=True, mend=False),
        popsteer.Path(xy, reverse=np.ones(len(xy), dtype=bool)),
        popsteer.Path(xy, reverse=np.arange(len(xy)) > 50),
    ):
        with pytest.raises(popsteer.ConfigError, match="a SpeedTracker of the path"):
            check_longitudinal(tracker, other, CAR)
    with pytest.raises(popsteer.ConfigError, match="rear_axle must be that of the plant"):
        check_longitudinal(tracker, PATH, CAR.replace(rear_axle=-1.0))


def test_controller_that_was_given_no_vehicle_keeps_all_else() -> None:
    for name in controllers.names():
        kind: Any = controllers.get(name)
        params = kind.params()
        for options in ({}, {"adapt": None}):
            bare = kind.controller(PATH, params=params, **options)
            made = informed(bare, CAR)
            assert believed(made) == CAR, name
            assert made.params == params
            assert made.path.length == PATH.length
            assert made.__getnewargs_ex__()[1] == bare.__getnewargs_ex__()[1]
            given = kind.controller(PATH, CAR, params, **options)
            assert informed(given, CAR.replace(understeer=0.004)) is given


def test_same_seed_draws_the_same_noise_and_another_another() -> None:
    noise = sim.Noise(position=0.05, yaw=0.01, speed=0.1)

    def steered(seed: int) -> Any:
        run = sim.run(
            popsteer.Stanley(PATH, CAR), sim.KinematicBicycle(CAR), noise=noise, seed=seed
        )
        return run.records["steer"]

    assert np.array_equal(steered(1), steered(1))
    assert not np.array_equal(steered(1)[:50], steered(2)[:50])


def test_smoothed_waypoints_are_as_far_apart_as_asked_or_as_recorded() -> None:
    pytest.importorskip("scipy")
    for spacing in (0.5, 1.0):
        s = np.arange(0.0, 80.0, spacing)
        xy = np.column_stack((s, 0.0 * s))
        for asked, tolerance, expected in (
            (None, 0.1, spacing),
            (None, 0.4, max(spacing, 0.8)),
            (2.0, 0.1, 2.0),
        ):
            path = planning.smooth(xy, tolerance, spacing=asked)
            assert np.median(np.diff(path.s)) == pytest.approx(expected, rel=0.02)
            assert path.x[[0, -1]] == pytest.approx([0.0, s[-1]], abs=1e-3)
    angle = np.linspace(0.0, 2.0 * math.pi, 161)[:-1]
    circle = 20.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    lap = planning.smooth(circle, 0.1, closed=True)
    assert lap.length == pytest.approx(2.0 * math.pi * 20.0, rel=2e-3)
    assert np.hypot(lap.x, lap.y) == pytest.approx([20.0] * len(lap), abs=0.1)
    # What runs on beyond the start of the lap is left out.
    longer = planning.smooth(np.concatenate((circle, circle[:10])), 0.1, closed=True)
    assert longer.length == pytest.approx(lap.length, rel=2e-3)


def test_step_time_of_a_comparison_holds_a_reading_of_the_clock_a_batch(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = 0

    def clock() -> int:
        nonlocal now
        now += 100
        return now

    class Slow:
        fresh = 0

        def reset(self) -> None:
            self.fresh += 1

        def step(self, *_: float) -> float:
            nonlocal now
            now += 250
            return 0.0

    monkeypatch.setattr(compare.comparison, "perf_counter_ns", clock)
    monkeypatch.setattr(compare.comparison, "controller", lambda *_: Slow())
    driven = compare.run(PATH, compare.parameters(["stanley"], "default"))
    run = replace(driven.runs["stanley"], law="slow")
    found = compare.time_steps(replace(driven, runs={"slow": run}), {"slow": None})
    assert found.step_times["slow"] == pytest.approx((32 * 250 + 100) / 32 * 1e-9)
    assert set(found.latencies["slow"]) == {350}
    assert len(found.latencies["slow"]) >= 1000
    assert gc.isenabled()
