"""Runs on paths with cusps, and backwards."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import controllers, sim
from popsteer.errors import PathError
from tests.closed_loop.paths import cusps, shuttle
from tests.closed_loop.test_run import PLANTS, SPEED, Constant, Own


@pytest.mark.parametrize("name", ["pop", "stanley", "pure-pursuit", "preview-pop"])
def test_own_law_on_a_path_with_cusps_gives_the_same_bits(name: str) -> None:
    """With its gear from the answer; `shuttle` and `cusps` turn round twice."""
    for path in (shuttle(), cusps("parking")):
        law = controllers.get(name).controller(path, sim.vehicle_of(PLANTS[1]))
        core = sim.run(law, PLANTS[1], longitudinal=SPEED)
        stepped = sim.run(Own(law), PLANTS[1], path=path, longitudinal=SPEED)
        assert core.ending == "finished"
        assert core.records["speed"].min() < -0.3
        assert core.records.keys() == stepped.records.keys()
        for column in ("x", "y", "yaw", "speed", "steer", "throttle", "brake", "status"):
            np.testing.assert_array_equal(core.records[column], stepped.records[column])


class TowardsTheLine:
    """Steers to y = 0 and yaw = 0, forwards, and backwards if it is told so."""

    def __init__(self) -> None:
        self.directions: list[bool] = []

    def step(
        self, x: float, y: float, yaw: float, speed: float, dt: float, *, reverse: bool
    ) -> float:
        self.directions.append(reverse)
        wanted = 0.1 * y - yaw if reverse else -0.1 * y - yaw
        return max(-0.5, min(-wanted if reverse else wanted, 0.5))


@pytest.mark.parametrize("constant", [None, 2.0])
def test_own_law_that_is_told_the_direction_passes_the_cusps(constant: float | None) -> None:
    law = TowardsTheLine()
    longitudinal = SPEED if constant is None else None
    path = shuttle()
    result = sim.run(
        law, "kinematic-bicycle", path=path, constant_speed=constant, longitudinal=longitudinal
    )
    assert result.ending == "finished"
    turns = [a for a, b in zip(law.directions, law.directions[1:], strict=False) if a is not b]
    assert turns == [False, True]
    assert result.metrics.rear_axle_settled_mean_abs_cross_track_error < 0.3
    backwards = result.records["speed"] < -1.0
    assert backwards.sum() > 80
    assert np.diff(result.records["x"])[backwards[:-1]].max() < 0.0


def test_own_law_that_is_told_nothing_drives_in_the_direction_of_the_path() -> None:
    result = sim.run(Constant(0.0), "kinematic-bicycle", path=shuttle(), longitudinal=SPEED)
    assert result.ending == "finished"
    assert result.records["speed"].min() < -2.0


def test_own_law_that_answers_the_direction_is_the_one_that_counts() -> None:
    class Ahead(NamedTuple):
        steer: float = 0.0
        reverse: bool = False

    settings = sim.Settings(time_limit=60.0)
    result = sim.run(
        Constant(Ahead()),
        "kinematic-bicycle",
        path=shuttle(),
        longitudinal=SPEED,
        settings=settings,
    )
    assert result.records["speed"].min() >= 0.0
    assert result.ending != "finished"


def test_constant_speed_on_a_reversing_path_reverses() -> None:
    path = shuttle()
    plant = sim.KinematicBicycle(popsteer.Vehicle())
    for law in (popsteer.PreviewPop(path), popsteer.PurePursuit(path)):
        result = sim.run(law, plant, constant_speed=2.0)
        speed, x = result.records["speed"], result.records["x"]
        assert result.ending == "finished"
        assert result.path is path
        assert speed[0] == 2.0
        for kept in (speed[speed > 0.0], -speed[speed < 0.0]):
            assert np.median(kept) == pytest.approx(2.0, abs=0.1)
            assert kept.max() < 2.7
        backwards = x[speed < 0.0]
        assert (backwards.max(), backwards.min()) == pytest.approx((30.0, 10.0), abs=1.0)
        assert result.metrics.time == pytest.approx(path.length / 2.0, rel=0.1)


@pytest.mark.parametrize("longitudinal", [None, SPEED], ids=["constant", "speeds"])
def test_plant_that_does_not_reverse_refuses_a_reversing_path(longitudinal: Any) -> None:
    path = shuttle()
    constant = 2.0 if longitudinal is None else None
    for law in (popsteer.Pop(path), Own(popsteer.Pop(path))):
        with pytest.raises(PathError, match="carla-identified does not reverse"):
            sim.run(law, path=path, constant_speed=constant, longitudinal=longitudinal)
    with pytest.raises(PathError, match="carla-identified does not reverse"):
        sim.run_many(popsteer.Pop(path))
