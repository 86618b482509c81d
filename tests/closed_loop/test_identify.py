"""Cars that nobody has described, identified from two minutes of their log."""

from __future__ import annotations

import math

import numpy as np
import pytest

import popsteer
from benches.latency.states import recorded
from popsteer import presets, sim
from popsteer.logs import Log
from tests.closed_loop import drives
from tests.helpers import authors_data

pytest.importorskip("scipy")


@pytest.fixture(params=drives.CARS)
def car(request: pytest.FixtureRequest) -> str:
    if request.param.startswith("commonroad"):
        pytest.importorskip("vehiclemodels")
    if request.param.startswith("mujoco"):
        pytest.importorskip("mujoco")
    return str(request.param)


def test_identify_of_an_unknown_car_finds_its_steering_and_its_point(car: str) -> None:
    found = popsteer.identify(Log(**drives.drive(car), name=car))
    offset = math.degrees(found.vehicle.steer_offset - drives.OFFSET)
    assert abs(offset) < 0.05
    assert abs(found.vehicle.dead_time - drives.DEAD_TIME) < 0.025
    # What is late beyond the dead time, at the speed that the log knows best.
    truth = drives.DEAD_TIME + drives.response(car, found.speed)
    assert abs(found.delay - truth) < 0.010
    given = sim.vehicle_of(drives.plant(car))
    assert found.turning_length == pytest.approx(given.turning_length(found.speed), rel=0.01)
    point = given.rear_axle if given.no_slip_point is None else given.no_slip_point
    assert found.vehicle.rear_axle == pytest.approx(point, abs=0.06)
    # And lets preview POP track as if it were told.
    told = drives.track(car, given)
    # None of these drives shows the limit of the wheels' rate: it is told by the manual.
    assert ("max_steer_rate" in found.unknown) == (found.vehicle.max_steer_rate is None)
    itself = drives.track(car, found.vehicle.replace(max_steer_rate=given.max_steer_rate))
    assert itself < 1.2 * told + 0.006


def test_identify_of_the_authors_run_leaves_what_their_plant_leaves() -> None:
    drive = recorded(authors_data())
    states = np.array(drive.states)
    pop = popsteer.Pop(
        drive.path,
        drive.vehicle,
        popsteer.PopParams(**presets.get("pop", "published-code").as_dict()),
        adapt=None,
    )
    steer = [pop.step(*state, 0.05).steer for state in drive.states]
    x, y, yaw, speed = states.T
    log = Log(0.05 * np.arange(len(states)), x, y, yaw, speed, steer, name="recorded")
    found = popsteer.identify(log, popsteer.Vehicle(wheelbase=3.0, rear_axle=-1.94))
    records = found.records
    left = records["yaw_rate"] - records["simulated_yaw_rate"]
    driving = records["t"] > 2.0  # before, the car stands and starts
    assert math.sqrt(np.mean(left[driving] ** 2)) < 0.0029
    plant = drive.vehicle.turning_length(found.speed)
    assert found.turning_length == pytest.approx(plant, abs=0.03)
    assert found.delay == pytest.approx(0.1, abs=0.015)
    # The point that does not slip is the plant's own, 1.94 m ahead of the rear axle.
    own = found.vehicle.no_slip_point
    assert own is not None
    assert own == pytest.approx(0.0, abs=0.1)
