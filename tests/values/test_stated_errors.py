"""Whether stated errors cover the truth: over seeds of noise, white and correlated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer
from popsteer.logs import Log
from studies.chain import Chain as Car
from tests.closed_loop.drives import whole_errors
from tests.values.tables import MIRRORED

if TYPE_CHECKING:
    from numpy.typing import NDArray

pytest.importorskip("scipy")

CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    understeer=0.003,
    steer_offset=0.01,
    steer_lag=0.1,
    dead_time=0.15,
)
DT = 0.05
SEEDS = 3
SPEED = 10.10736
"""At which the car of `_clean(20.0)` turns most [m/s]."""


def _clean(seconds: float = 40.0) -> dict[str, NDArray[np.float64]]:
    """A drive with all that shows a car: bends to both sides, steps, and speeds that change."""
    t = DT * np.arange(round(seconds / DT))
    steer = 0.08 * np.sin(0.35 * t) + 0.05 * np.sign(np.sin(0.6 * t)) + 0.02 * np.sin(2.3 * t)
    speed = 8.0 + 3.5 * np.sin(0.21 * t)
    car = Car(CAR, (0.0, 0.0, 0.3), float(speed[0]), DT, substeps=20)
    poses = np.empty((len(t), 3))
    for k, (angle, now) in enumerate(zip(steer.tolist(), speed.tolist(), strict=True)):
        poses[k] = car.pose
        car.speed = now
        car.advance(angle)
    x, y, yaw = poses.T
    return {"t": t, "x": x, "y": y, "yaw": yaw, "speed": speed, "steer": steer}


def _noise(random: np.random.Generator, count: int, memory: float) -> NDArray[np.float64]:
    """Noise of deviation 1; each sample keeps a share of the one before."""
    white = random.standard_normal(count)
    found = white.copy()
    for k in range(1, count):
        found[k] = memory * found[k - 1] + math.sqrt(1.0 - memory**2) * white[k]
    return found


def _measured(clean: dict[str, NDArray[np.float64]], seed: int, memory: float) -> Log:
    random = np.random.default_rng(seed)
    sizes = {"x": 0.02, "y": 0.02, "yaw": 0.002, "speed": 0.02}
    noisy: dict[str, Any] = {
        name: values + sizes.get(name, 0.0) * _noise(random, len(values), memory)
        for name, values in clean.items()
    }
    return Log(**noisy)


@pytest.mark.parametrize("memory", [0.0, 0.7])
def test_errors_of_an_identification_cover_what_it_misses(memory: float) -> None:
    clean = _clean()
    misses: dict[str, list[float]] = {}
    for seed in range(SEEDS):
        found = popsteer.identify(_measured(clean, seed, memory))
        whole = whole_errors(found)
        for name, error in found.errors.items():
            if math.isfinite(error):
                off = getattr(found.vehicle, name) - getattr(CAR, name)
                misses.setdefault(name, []).append(off / whole[name])
        misses.setdefault("delay", []).append((found.delay - 0.25) / whole["delay"])
    assert {"wheelbase", "understeer", "steer_offset", "delay"} <= set(misses)
    every = [ratio for ratios in misses.values() for ratio in ratios]
    # Over all fields: neither understated nor many times too large.
    assert 0.35 < np.sqrt(np.mean(np.square(every))) < 1.5, misses
    for name, ratios in misses.items():
        assert np.sqrt(np.mean(np.square(ratios))) < 2.5, (name, ratios)


def test_identification_of_the_mirrored_drive_is_the_same_car_mirrored() -> None:
    log = _measured(_clean(), 1, 0.0)
    one = popsteer.identify(log)
    columns: dict[str, Any] = MIRRORED.columns(log.as_dict())
    other = popsteer.identify(Log(**columns))
    for name, error in one.errors.items():
        sign = -1.0 if name == "steer_offset" else 1.0
        value = getattr(one.vehicle, name)
        assert getattr(other.vehicle, name) == pytest.approx(sign * value, abs=0.2 * error), name
        assert other.errors[name] == pytest.approx(error, rel=0.1), name
    assert other.delay == pytest.approx(one.delay, abs=0.2 * one.delay_error)


def test_identification_of_a_short_drive_is_the_recorded_one() -> None:
    """Every figure as it was last looked at: by a vehicle that was given, and without one."""
    log = _measured(_clean(20.0), 5, 0.0)
    given = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, max_steer_rate=0.5)
    wanted: list[tuple[Any, str, set[str], dict[str, tuple[float, float]], list[float]]] = [
        (
            None,
            "wheels",
            {"max_steer_rate", "steer_play"},
            {
                "understeer": (0.003069232, 0.0001744444),
                "steer_offset": (0.009993138, 4.634951e-05),
                "steer_lag": (0.0973637, 0.004843259),
                "dead_time": (0.1529411, 0.004783745),
                "wheelbase": (2.692609, 0.02040512),
                "rear_axle": (-1.302548, 0.07148539),
            },
            [0.2503048, 0.001188879, 0.001835607, 9.889879e-05, 0.0206891],
        ),
        (
            given,
            "wheels",
            {"steer_play"},
            {
                "turning_wheelbase": (2.647367, 0.01786845),
                "understeer": (0.003497283, 0.0001951982),
                "steer_offset": (0.01018016, 0.0001346795),
                "steer_lag": (0.1171042, 0.006030026),
                "dead_time": (0.1247852, 0.003905204),
                "rear_axle": (-1.35, 0.01541907),
            },
            [0.2418894, 0.00365202, 0.001969265, 0.001000014, 0.02042439],
        ),
    ]
    for vehicle, lag_of, unknown, fields, others in wanted:
        told: list[float] = []
        found = popsteer.identify(log, vehicle, progress=told.append)
        assert told == pytest.approx([0.5, 0.7])
        assert (found.lag_of, set(found.unknown)) == (lag_of, unknown)
        assert found.errors.keys() == fields.keys()
        assert found.model_errors.keys() == {*fields, "delay", "turning_length"}
        whole = whole_errors(found)
        for name, (value, error) in fields.items():
            assert getattr(found.vehicle, name) == pytest.approx(value, abs=0.05 * error), name
            assert whole[name] == pytest.approx(error, rel=0.01), name
        noise = [found.noise[name] for name in ("yaw", "yaw_drift", "position")]
        assert [found.delay, whole["delay"], *noise] == pytest.approx(others, rel=0.01)
        # The length by which the car turns at the speed at which it turned most.
        car = found.vehicle
        assert found.speed == pytest.approx(SPEED, rel=1e-3)  # by the scale of the positions
        length = (car.turning_wheelbase or car.wheelbase) + car.understeer * found.speed**2
        assert found.turning_length == pytest.approx(length)
        assert found.turning_length == pytest.approx(2.7 + 0.003 * SPEED**2, rel=0.01)
        # Of the recorded whole error of a length at rest.
        (at_rest,) = (error for name, (_, error) in fields.items() if "wheelbase" in name)
        assert whole["turning_length"] < 0.5 * at_rest
        assert found.vehicle.max_steer_rate == (None if vehicle is None else 0.5)
