"""The model-predictive controller: a strong baseline, within its limits."""

from __future__ import annotations

import builtins
import math
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import baselines, sim, study
from popsteer.baselines import MpcParams
from popsteer.errors import ConfigError, InputError, PopsteerError
from tests.closed_loop.paths import track
from tests.helpers import authors_data


def _mpc(path: popsteer.Path, params: MpcParams | None = None) -> Any:
    pytest.importorskip("osqp")
    return baselines.get("mpc").controller(path, MpcParams() if params is None else params)


def test_mpc_on_the_authors_track_is_within_a_centimetre() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    law = _mpc(path, MpcParams.for_plant("carla-identified"))
    result = sim.run(law, start=(-183.8, 78.7, -1.574))
    metrics = result.metrics
    assert (result.law, result.ending) == ("mpc", "finished")
    assert metrics.mean_abs_cross_track_error < 0.05
    assert metrics.settled_mean_abs_cross_track_error < 0.004
    assert metrics.settled_max_abs_cross_track_error < 0.03
    assert result.params["understeer"] == sim.CarlaIdentified().understeer


@pytest.mark.parametrize("name", ["racetrack", "figure-eight", "circle", "slalom"])
def test_mpc_keeps_to_each_track(name: str) -> None:
    path = track(name)
    law = _mpc(path, MpcParams.for_plant("carla-identified"))
    result = sim.run(law, longitudinal=popsteer.SpeedPid())
    assert result.ending == "finished"
    assert result.metrics.settled_mean_abs_cross_track_error < 0.05


def test_mpc_that_knows_lag_and_understeer_tracks_better() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv")
    known = MpcParams.for_plant("carla-identified")
    errors = [
        sim.run(_mpc(path, params)).metrics.settled_mean_abs_cross_track_error
        for params in (known, known.replace(lag=0.0), known.replace(understeer=0.0))
    ]
    assert errors[0] < 0.8 * min(errors[1:])


def test_mpc_keeps_its_limits() -> None:
    path = track("racetrack")
    params = MpcParams.for_plant("kinematic-bicycle").replace(max_steer=0.12, max_steer_rate=0.3)
    result = sim.run(_mpc(path, params), "kinematic-bicycle", constant_speed=8.0)
    steer = result.records["steer"]
    assert np.abs(steer).max() == 0.12
    assert np.abs(np.diff(steer)).max() <= 0.3 * 0.05 + 1e-12
    assert result.records["status"].max() == 2  # saturated, where it was


def test_mpc_solves_the_problem_that_it_states() -> None:
    """On a straight, from a small error, without limits in reach: least squares, solved densely."""
    path = popsteer.Path([(float(x), 0.0) for x in range(201)])
    p = MpcParams(tolerance=1e-9, reference_offset=1.0, stages=12)
    h, v, e0, psi0 = p.stage_time, 8.0, 0.01, -0.002
    answered = np.array([_free(p, h, v, e0, psi0, np.eye(12)[k], zero=True) for k in range(12)]).T
    free = _free(p, h, v, e0, psi0, np.zeros(12))
    weight = np.tile([p.cross_track_weight, p.heading_weight], 12)
    weight[-2:] *= p.last_weight
    change = np.eye(12) - np.eye(12, k=-1)
    hessian = answered.T * weight @ answered + p.change_weight * change.T @ change
    wanted = np.linalg.solve(hessian, -(answered.T * weight) @ free)
    steer = _mpc(path, p).steer(49.0, e0 - math.sin(psi0), psi0, v, h)
    assert steer == pytest.approx(wanted[0], rel=1e-3)
    assert abs(wanted[0]) > 1e-5


def _free(
    p: MpcParams, h: float, v: float, e: float, psi: float, steer: Any, *, zero: bool = False
) -> Any:
    """Cross-track and heading errors of each stage, stage by stage; from nothing if `zero`."""
    e, psi, a = (0.0, 0.0, 0.0) if zero else (e, psi, 0.0)
    kept = math.exp(-h / p.lag)
    errors = []
    for delta in steer:
        share = (1.0 - kept) * p.lag / h
        rate = v * (share * a + (1.0 - share) * delta) / (p.wheelbase + p.understeer * v * v)
        e += h * v * psi + 0.5 * h * h * v * rate + h * p.reference_offset * rate
        psi += h * rate
        a = kept * a + (1.0 - kept) * delta
        errors += [e, psi]
    return np.array(errors)


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
        assert np.abs(angles).max() <= law.params.max_steer


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
    with pytest.raises(ConfigError, match="lag must be in"):
        MpcParams(lag=-0.1)
    with pytest.raises(ConfigError, match="stages must be in"):
        MpcParams(stages=1)


def test_mpc_params_for_a_plant_are_what_may_be_known_of_it() -> None:
    identified = MpcParams.for_plant(sim.CarlaIdentified(yaw_lag=0.2))
    assert (identified.lag, identified.understeer) == (0.2, 2.9e-4)
    assert identified.max_steer_rate == MpcParams().max_steer_rate
    assert MpcParams.for_plant(sim.KinematicBicycle(wheelbase=2.5)).wheelbase == 2.5
    pytest.importorskip("vehiclemodels")
    model = MpcParams.for_plant("commonroad-mb-2")
    assert model.wheelbase == pytest.approx(2.5789, abs=1e-4)
    assert (model.max_steer, model.max_steer_rate) == (1.066, 0.4)


def test_compare_names_a_baseline_beside_the_laws_and_times_both() -> None:
    pytest.importorskip("osqp")
    path = track("slalom")
    params = study.parameters(["pop", "mpc"], "default", "carla-identified")
    comparison = study.compare(path, params)
    assert {name: run.law for name, run in comparison.runs.items()} == {"pop": "pop", "mpc": "mpc"}
    timed = study.time_steps(comparison, params)
    assert timed.runs == comparison.runs
    assert list(timed.step_times) == ["pop", "mpc"]
    assert all(time > 0.0 for time in timed.step_times.values())
    with pytest.raises(ConfigError, match=r"unknown law 'lqr'; known: bang-bang, .*, mpc"):
        study.compare(path, ["pop", "lqr"])


def test_mpc_without_the_extra_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def absent(name: str, *rest: Any) -> Any:
        if name == "osqp" or name.endswith("baselines.mpc"):
            raise ModuleNotFoundError("No module named 'osqp'", name="osqp")
        return real(name, *rest)

    path = track("slalom")
    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(PopsteerError, match=r'pip install "popsteer\[mpc\]"'):
        baselines.get("mpc").controller(path, MpcParams())
