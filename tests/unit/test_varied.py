"""What sweeps and tunings draw from, and what they make of a draw."""

from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.errors import ConfigError
from popsteer.lab.common.varied import distribution, draws, run_seed, usual, varied, varying
from tests.helpers import looped

PATH = popsteer.Path([(float(x), 0.0) for x in range(81)])


@looped(
    ("text", "quantiles"),
    [
        ("0.3", (0.3, 0.3, 0.3)),
        ("uniform(1,3)", (1.0, 2.0, 3.0)),
        ("loguniform(1,4)", (1.0, 2.0, 4.0)),
        ("triangular(0,1,2)", (0.0, 1.0, 2.0)),
        ("triangular(0,0,2)", (0.0, 2.0 - math.sqrt(2.0), 2.0)),
    ],
)
def test_distribution_has_its_quantiles(text: str, quantiles: tuple[float, ...]) -> None:
    found = distribution("x", text)
    assert [found.quantile(share) for share in (0.0, 0.5, 1.0)] == pytest.approx(quantiles)
    assert distribution("x", str(found)) == found


def test_normal_distribution_is_finite_and_has_its_deviation() -> None:
    found = distribution("x", "normal(1, 0.5)")
    shares = (np.arange(20_000) + 0.5) / 20_000
    values = [found.quantile(share) for share in shares]
    assert np.mean(values) == pytest.approx(1.0)
    assert np.std(values) == pytest.approx(0.5, rel=1e-3)
    assert all(map(math.isfinite, (found.quantile(0.0), found.quantile(1.0))))


@looped(
    "text",
    [
        *("uniform(3,1)", "uniform(1)", "gamma(1,2)", "x", "", "uniform(1,nan)", "nan"),
        *(
            "loguniform(0,1)",
            "normal(0,-1)",
            "triangular(0,3,2)",
            "uniform(1,2",
            "triangular(1,1,1)",
        ),
    ],
)
def test_what_is_no_distribution_is_refused_by_name(text: str) -> None:
    with pytest.raises(ConfigError, match=r"^lag must be"):
        distribution("lag", text)


def test_draws_fill_every_part_of_the_range_once() -> None:
    pytest.importorskip("scipy")
    vary = {"a": distribution("a", "uniform(0,50)"), "b": distribution("b", "uniform(0,50)")}
    found = draws(vary, 50, 3)
    for column in found.values():
        assert sorted(np.floor(column)) == list(range(50))
    again = draws(vary, 50, 3)
    assert all(np.array_equal(found[name], again[name]) for name in vary)
    assert not np.array_equal(found["a"], draws(vary, 50, 4)["a"])


def test_seeds_of_runs_differ() -> None:
    seeds = {run_seed(seed, run) for seed in range(3) for run in range(500)}
    assert len(seeds) == 1500
    assert all(0 <= seed < 2**64 for seed in seeds)


def test_draw_changes_what_it_names_and_nothing_else() -> None:
    plant = sim.CarlaIdentified()
    values = {
        "steer_lag": 0.2,
        "drag": 0.3,
        "noise_yaw": 0.01,
        "start_yaw": 0.1,
        "start_speed": 2.0,
    }
    made = varied(plant, PATH, values, offset=0.5)
    assert made.plant == plant.replace(vehicle=plant.vehicle.replace(steer_lag=0.2), drag=0.3)
    assert made.noise == sim.Noise(yaw=0.01)
    assert made.speed == 2.0
    assert made.start[2] == 0.1
    assert made.start[:2] == sim.default_start(PATH, 0.5, plant.vehicle)[:2]


def test_what_cannot_vary_is_refused_with_what_can() -> None:
    plant = sim.KinematicBicycle()
    for name in ("friction", "rear_axle"):
        with pytest.raises(
            ConfigError, match=f"unknown quantity that varies '{name}'; known: wheel"
        ):
            varied(plant, PATH, {name: 0.5})
    assert set(usual(plant.vehicle, plant)) <= set(varying(plant))


def test_plant_from_elsewhere_varies_in_friction_and_delay() -> None:
    pytest.importorskip("mujoco")
    plant = sim.geometry.object_of("mujoco-car")
    made = varied(plant, PATH, {"friction": 0.5, "dead_time": 0.1, "steer_offset": 0.02}).plant
    assert made.params.friction == 0.5
    assert (made.vehicle.dead_time, made.vehicle.steer_offset) == (0.1, 0.02)
