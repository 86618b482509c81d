"""The ROS 2 pilot drives a path backwards, and mirrored, as it drives it forwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from popsteer.adapters import ros2
from tests.values.tables import BACKWARDS, MIRRORED, SELF, Twin

if TYPE_CHECKING:
    from collections.abc import Callable

DT = 0.02
XY = [(5.0 * k, 0.0) for k in range(40)]
CAR = popsteer.Vehicle(wheelbase=2.7, max_acceleration=1.0, max_deceleration=2.5, steer_lag=0.1)


def _here(twin: Twin, x: float, speed: float, y: float = 0.0) -> ros2.Measured:
    return ros2.Measured(*twin.pose(x, y, 0.0), twin.speed * speed, 0, "map", "base_link")


def _drive(twin: Twin, event: Callable[[int], bool], steps: int = 700) -> np.ndarray:
    """Commands as the forward case has them, of a vehicle that obeys; odometry but in the event."""
    path = twin.path(XY, [4.0] * 40)
    pilot = ros2.Pilot(popsteer.PreviewPop(path, CAR))
    x, speed, found = 0.0, 0.0, []
    for k in range(steps):
        known = not event(k)
        measured = _here(twin, x, speed) if known else None
        drive = pilot.step(measured, 0.0, DT, "" if known else "no odometry")
        speed = twin.speed * drive.speed
        x += speed * DT
        state = list(ros2.State).index(pilot.state)
        found.append((speed, drive.acceleration, drive.limit, twin.steer * drive.steer, state))
    return np.array(found)


EVENTS: dict[str, Callable[[int], bool]] = {
    "none": lambda k: False,
    "held": lambda k: 300 <= k < 308,
    "stopped and gone on": lambda k: 300 <= k < 500,
    "braked and gone on": lambda k: 300 <= k < 340,
}


@pytest.mark.parametrize("name", EVENTS)
def test_pilot_backwards_commands_what_it_commands_forwards(name: str) -> None:
    forth, back = _drive(SELF, EVENTS[name]), _drive(BACKWARDS, EVENTS[name])
    assert back[:, [0, 1, 2, 4]] == pytest.approx(forth[:, [0, 1, 2, 4]], abs=1e-6)
    assert forth[:, 0].min() >= 0.0
    assert forth[299, 0] > 3.0


def test_safe_stop_brakes_from_the_speed_it_had_at_the_vehicles_limit() -> None:
    for twin in (SELF, BACKWARDS):
        found = _drive(twin, EVENTS["stopped and gone on"])
        states = found[:, 4].astype(int)
        driving, holding, braking, standing = range(4)
        held = found[states == holding]
        assert set(held[:, 0]) == {found[299, 0]}
        steps = -np.diff(found[:, 0], prepend=0.0)[states == braking]
        assert steps == pytest.approx(2.5 * DT)
        assert (found[states == braking, 1] == -2.5).all()
        assert (found[states == standing, 0] == 0.0).all()
        # Then it goes on from rest as any start does, no faster than it may.
        again = found[500:, 0]
        assert (states[500:] == driving).all()
        assert 0.0 < again[0] <= 0.1
        assert np.diff(again).max() <= 1.5 * DT


def test_limit_of_a_command_is_the_vehicles_for_driving_or_braking_and_a_reserve() -> None:
    reserve = popsteer.SpeedTrackerParams().reserve
    for twin in (SELF, BACKWARDS):
        found = _drive(twin, EVENTS["held"])
        speeding, braking = found[:, 1] > 0.1, found[:, 1] < -0.1
        assert speeding.any()
        assert found[speeding, 2] == pytest.approx(1.0 + reserve)
        holding = found[:, 4] == 1
        assert found[holding | braking, 2] == pytest.approx(2.5 + reserve)
        assert holding.any()


def test_pilot_mirrored_steers_to_the_other_side() -> None:
    for offset in (0.4, -0.4):
        found = []
        for twin in (SELF, MIRRORED):
            pilot = ros2.Pilot(popsteer.PreviewPop(twin.path(XY, [4.0] * 40), CAR))
            steps = [pilot.step(_here(twin, 0.08 * k, 4.0, offset), 0.0, DT) for k in range(50)]
            found.append([(twin.steer * each.steer, each.speed) for each in steps])
        assert np.array(found[0]) == pytest.approx(np.array(found[1]), abs=1e-12)
        assert np.sign(found[0][-1][0]) == -np.sign(offset)
