"""The model-predictive controller by its name: a strong baseline, within its limits."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import lab, sim
from popsteer.errors import ConfigError, PopsteerError
from popsteer.lab import baselines
from tests.closed_loop.paths import track

CAR = sim.vehicle_of("carla-identified")


def _mpc(path: popsteer.Path, vehicle: popsteer.Vehicle = CAR) -> Any:
    pytest.importorskip("daqp")
    mpc = baselines.get("mpc")
    return mpc.controller(path, vehicle, mpc.params())


@pytest.mark.parametrize("name", ["racetrack", "figure-eight", "circle", "slalom"])
def test_mpc_keeps_to_each_track(name: str) -> None:
    result = sim.run(_mpc(track(name)), longitudinal=popsteer.SpeedPid())
    assert result.ending == "finished"
    assert result.metrics.settled_mean_abs_cross_track_error < 0.05


@pytest.mark.parametrize(
    "changes",
    [{"dead_time": 0.2}, {"steer_offset": 0.03}, {"turning_wheelbase": 3.6}, {"rear_axle": -1.2}],
    ids=str,
)
def test_mpc_that_knows_its_car_tracks_better(changes: dict[str, float]) -> None:
    path = track("slalom")
    plain = popsteer.Vehicle(max_lateral_acceleration=None)
    plant = sim.KinematicBicycle(plain.replace(**changes))
    known = sim.run(_mpc(path, plant.vehicle), plant).metrics.settled_mean_abs_cross_track_error
    assert known < 0.02
    if "dead_time" in changes:  # the others it finds, or a pose that is another is refused
        wrong = sim.run(_mpc(path, plain), plant).metrics
        assert wrong.settled_mean_abs_cross_track_error > 1.5 * known


def test_mpc_keeps_its_limits() -> None:
    car = sim.vehicle_of("kinematic-bicycle").replace(max_steer=0.12, max_steer_rate=0.3)
    result = sim.run(_mpc(track("racetrack"), car), "kinematic-bicycle", constant_speed=8.0)
    steer = result.records["steer"]
    assert np.abs(steer).max() == pytest.approx(0.12, abs=1e-3)
    assert np.abs(steer).max() <= 0.12 + 1e-9
    assert np.abs(np.diff(steer)).max() <= 0.3 * 0.05 + 1e-9


def test_compare_names_a_baseline_beside_the_laws_and_times_both() -> None:
    pytest.importorskip("daqp")
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
    monkeypatch.setitem(sys.modules, "daqp", None)
    with pytest.raises(PopsteerError, match=r"\(not installed: daqp\): pip install .*\[mpc\]"):
        baselines.get("mpc").controller(path, CAR, baselines.get("mpc").params())
