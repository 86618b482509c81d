"""A simulation that is copied or pickled half-way drives on as the one that was not."""

from __future__ import annotations

import copy
import pickle
from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer import sim
from tests.closed_loop.drives import Bicycle

if TYPE_CHECKING:
    from collections.abc import Callable

CAR = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.1, dead_time=0.12)
PLANTS: dict[str, sim.KinematicBicycle | Bicycle] = {
    "core": sim.KinematicBicycle(CAR),
    "python": Bicycle(),
}
COPIES: dict[str, Callable[[sim.Simulation], sim.Simulation]] = {
    "pickle": lambda run: pickle.loads(pickle.dumps(run)),
    "deepcopy": copy.deepcopy,
}


def _started(plant: sim.KinematicBicycle | Bicycle) -> sim.Simulation:
    path = popsteer.Path([(2.0 * k, 0.02 * k * k) for k in range(60)], speed=[6.0] * 60)
    run = sim.Simulation(path, plant, start=(0.0, 0.5, 0.0), speed=4.0)
    for k in range(100):
        run.step(0.1 * np.sin(0.05 * k), 0.5)
    return run


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("copied", COPIES)
def test_simulation_copied_half_way_goes_on_alike(plant: str, copied: str) -> None:
    run = _started(PLANTS[plant])
    before = run.records()
    twin = COPIES[copied](run)
    assert (twin.state, twin.time, twin.vehicle) == (run.state, run.time, run.vehicle)
    # Driven on, one after the other: they share nothing that moves.
    for each in (run, twin):
        for _ in range(60):
            each.step(-0.05, 0.2, 0.1)
    for name, column in run.records().items():
        assert np.array_equal(column, twin.records()[name], equal_nan=True), name
        start = before[name]
        assert np.array_equal(column[: len(start)], start, equal_nan=True), name
    assert len(run.records()["time"]) > len(before["time"])
    for name, value in run.metrics().items():
        assert repr(twin.metrics()[name]) == repr(value), name
