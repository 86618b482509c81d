"""The driver drives a path backwards, and mirrored, as it drives it forwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import popsteer
from tests.values.tables import BACKWARDS, MIRRORED, SELF, Twin

if TYPE_CHECKING:
    from collections.abc import Callable

DT = 0.02
XY = [(5.0 * k, 0.0) for k in range(40)]
CAR = popsteer.Vehicle(wheelbase=2.7, max_acceleration=1.0, max_deceleration=2.5, steer_lag=0.1)
Pose = tuple[float | None, float | None, float | None, float | None]
NOTHING: Pose = (None, None, None, None)
HELD, FAULT, STANDING = 1, 2, 3


def _drive(twin: Twin, event: Callable[[int], bool], steps: int = 700) -> np.ndarray:
    """Commands as the forward case has them, of a vehicle that obeys; inputs but in the event.

    What is missing for longer is a fault, which is released where it is back.
    """
    hold = popsteer.DriverParams(hold_time=0.2)
    driver = popsteer.Driver(twin.path(XY, [4.0] * 40), CAR, params=hold)
    x, speed, found = 0.0, 0.0, []
    for k in range(steps):
        known = not event(k)
        if known:
            driver.release()
        pose: Pose = (*twin.pose(x, 0.0, 0.0), twin.speed * speed) if known else NOTHING
        drive = driver.step(*pose, DT)
        speed = twin.speed * (-drive.speed if drive.reverse else drive.speed)
        x += speed * DT
        state = STANDING if drive.hold else FAULT if drive.fault else HELD if not known else 0
        found.append((speed, drive.acceleration, twin.steer * drive.steer, state))
    return np.array(found)


EVENTS: dict[str, Callable[[int], bool]] = {
    "none": lambda k: False,
    "held": lambda k: 300 <= k < 308,
    "stopped and gone on": lambda k: 300 <= k < 500,
    "braked and gone on": lambda k: 300 <= k < 340,
}


@pytest.mark.parametrize("name", EVENTS)
def test_driver_backwards_commands_what_it_commands_forwards(name: str) -> None:
    forth, back = _drive(SELF, EVENTS[name]), _drive(BACKWARDS, EVENTS[name])
    assert back == pytest.approx(forth, abs=1e-6)
    assert forth[:, 0].min() >= 0.0
    assert forth[299, 0] > 3.0


def test_safe_stop_brakes_from_the_speed_it_had_at_the_vehicles_limit() -> None:
    for twin in (SELF, BACKWARDS):
        found = _drive(twin, EVENTS["stopped and gone on"])
        states = found[:, -1].astype(int)
        assert found[states == HELD, 0] == pytest.approx(found[299, 0], abs=0.05)
        braking = found[states == FAULT]
        assert (np.diff(braking[:, 0]) <= 0.0).all()
        assert np.median(braking[:, 1]) == pytest.approx(-2.5, abs=0.05)
        assert found[states == STANDING].shape[0] > 50
        assert (found[states == STANDING, 0] == 0.0).all()
        # Then it goes on from rest as any start does, no faster than it may.
        again = found[500:, 0]
        assert (states[500:] == 0).all()
        assert 0.0 < again[0] <= 0.1
        assert np.diff(again).max() <= 1.5 * DT


def test_driver_mirrored_steers_to_the_other_side() -> None:
    for offset in (0.4, -0.4):
        found = []
        for twin in (SELF, MIRRORED):
            driver = popsteer.Driver(twin.path(XY, [4.0] * 40), CAR)
            pose = [(*twin.pose(0.08 * k, offset, 0.0), twin.speed * 4.0) for k in range(50)]
            steps = [driver.step(*each, DT) for each in pose]
            found.append([(twin.steer * each.steer, each.speed) for each in steps])
        assert np.array(found[0]) == pytest.approx(np.array(found[1]), abs=1e-12)
        assert np.sign(found[0][-1][0]) == -np.sign(offset)
