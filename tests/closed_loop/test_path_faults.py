"""Faults of waypoints that people have: a vehicle drives as on the path without them."""

from __future__ import annotations

import math
import pickle
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import popsteer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Points = NDArray[np.float64]

LAWS: list[Any] = [
    popsteer.PreviewPop,
    popsteer.Pop,
    popsteer.Stanley,
    popsteer.PurePursuit,
    popsteer.Pid,
]
ALLOWED = 0.05
# Wheelbase and spacing [m].
SIZES = [(0.16, 0.1), (0.33, 0.1), (2.7, 0.1), (2.7, 0.5), (2.7, 2.0), (12.0, 0.1), (12.0, 2.0)]


def course(spacing: float, wheelbase: float) -> Points:
    """A straight, a bend of eight wheelbases, and a straight."""
    length = max(30.0 * spacing, 14.0 * wheelbase)
    radius = max(8.0 * wheelbase, 4.0 * spacing)
    s = np.arange(0.0, length, 0.1 * spacing)
    bend = np.where((s > 0.35 * length) & (s < 0.6 * length), 1.0 / radius, 0.0)
    yaw = np.cumsum(bend) * 0.1 * spacing
    steps = 0.1 * spacing * np.column_stack((np.cos(yaw), np.sin(yaw)))
    return np.cumsum(steps, axis=0)[::10]


def swapped(xy: Points, _: float) -> tuple[Points, float]:
    place = len(xy) // 2
    order = np.arange(len(xy))
    order[[place, place + 1]] = order[[place + 1, place]]
    return xy[order], 0.0


def stepped_back(xy: Points, spacing: float) -> tuple[Points, float]:
    place, back = len(xy) // 2, max(1, round(1.0 / spacing))
    aside = np.array((0.01, -0.01))
    return np.vstack((xy[:place], xy[max(place - back, 0) :] + aside)), 0.015


def stood(xy: Points, _: float) -> tuple[Points, float]:
    place = len(xy) // 2
    noise = np.random.default_rng(1).normal(0.0, 0.02, (60, 2))
    return np.vstack((xy[:place], xy[place] + noise, xy[place + 1 :])), 0.06


def ended_aside(xy: Points, _: float) -> tuple[Points, float]:
    along = (xy[-1] - xy[-2]) / np.hypot(*(xy[-1] - xy[-2]))
    aside = np.array((-along[1], along[0]))
    return np.vstack((xy, xy[-1] + 0.1 * along + 0.05 * aside)), 0.05


def half_a_millimetre_aside(xy: Points, _: float) -> tuple[Points, float]:
    along = (xy[-1] - xy[-2]) / np.hypot(*(xy[-1] - xy[-2]))
    return np.vstack((xy, xy[-1] + 5e-4 * np.array((-along[1], along[0])))), 5e-4


FAULTS: list[Any] = [swapped, stepped_back, stood, ended_aside, half_a_millimetre_aside]


def farthest(law: Any, path: popsteer.Path, clean: Points, wheelbase: float) -> float:
    """How far the vehicle gets from the clean course, whose ends go on."""
    car = popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6)
    steering, speed = law(path, car), 3.0 * math.sqrt(wheelbase)
    (x, y), (along, aside) = clean[0], clean[1] - clean[0]
    yaw, worst = math.atan2(aside, along), 0.0
    truth = popsteer.Path(clean, mend=False)
    for _ in range(int(truth.length / (0.05 * speed))):
        steer = steering.step(x, y, yaw, speed, 0.05).steer
        for _ in range(5):
            yaw += 0.01 * speed * math.tan(steer) / wheelbase
            x, y = x + 0.01 * speed * math.cos(yaw), y + 0.01 * speed * math.sin(yaw)
        worst = max(worst, abs(truth.project(x, y).cross_track_error))
    return worst


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_fault_adds_no_more_than_its_size(law: Any, fault: Any) -> None:
    for wheelbase, spacing in SIZES:
        clean = course(spacing, wheelbase)
        broken, size = fault(clean, spacing)
        path = popsteer.Path(broken)
        added = farthest(law, path, clean, wheelbase) - farthest(
            law, popsteer.Path(clean), clean, wheelbase
        )
        assert added <= ALLOWED + size, (wheelbase, spacing, path.mended)


def test_waypoints_as_they_stand_throw_the_best_controller_off() -> None:
    # Without the mend the fault is one: the test above sees it.
    clean = course(0.5, 2.7)
    broken, _ = swapped(clean, 0.5)
    path = popsteer.Path(broken, mend=False)
    assert path.mended == ()
    assert farthest(popsteer.PreviewPop, path, clean, 2.7) > 0.3


def test_end_is_smoothed_for_the_vehicle_that_cannot_drive_it() -> None:
    goal, _ = ended_aside(course(0.1, 2.7), 0.1)
    path = popsteer.Path(goal)
    car = popsteer.Vehicle(wheelbase=2.7, max_steer=0.6)
    for made in (popsteer.Stanley(path, car), popsteer.SpeedTracker(path, car)):
        assert made.path.mended == (
            f"smoothed 1 end over a wheelbase, at waypoint {len(goal) - 1}",
        )
        assert (made.path.x[-1], made.path.y[-1]) == pytest.approx(tuple(goal[-1]), abs=1e-12)
        assert np.abs(made.path.y - path.y).max() < 0.06
    driven = np.diff(np.column_stack((made.path.x, made.path.y))[-30:], axis=0)
    turns = np.diff(np.unwrap(np.arctan2(driven[:, 1], driven[:, 0])))
    assert np.abs(turns).max() < 0.1 * 0.1 * math.tan(0.6) / 2.7 + 0.02
    small = popsteer.Vehicle(wheelbase=0.05, max_steer=0.6)
    assert popsteer.Stanley(path, small).path is path
    # Where the user says how the path is driven, or that it is to stay, it stays.
    for told in ({"mend": False}, {"reverse": [False] * len(goal)}):
        assert popsteer.Stanley(popsteer.Path(goal, **told), car).path.mended == ()


def test_mended_path_outlasts_a_pickle() -> None:
    goal, _ = ended_aside(course(0.1, 2.7), 0.1)
    broken, _ = swapped(goal, 0.1)
    path = popsteer.Path(broken)
    again = pickle.loads(pickle.dumps(path))
    assert again.mended == path.mended != ()
    car = popsteer.Vehicle(wheelbase=2.7)
    assert popsteer.Stanley(again, car).path.mended == popsteer.Stanley(path, car).path.mended


def test_lap_as_an_open_path_is_driven_from_its_beginning() -> None:
    for wheelbase in (0.33, 2.7):
        for spacing in (0.05, 0.5):
            count = round(math.tau * 30.0 / spacing)
            angle = math.tau * np.arange(count + 1) / count
            ring = 10.0 * wheelbase * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
            path = popsteer.Path(ring, speed=np.full(count + 1, wheelbase))
            car = popsteer.Vehicle(wheelbase=wheelbase, max_steer=0.6)
            # Behind the start, as a vehicle stands whose front axle is at it, beside it, and on it.
            for x, y in ((-wheelbase, -wheelbase), (0.0, 0.0), (-0.5 * wheelbase, 0.1 * wheelbase)):
                tracker = popsteer.SpeedTracker(path, car)
                left = tracker.step(x, y, 0.0, 0.0, 0.05).distance_to_stop
                assert left > 0.95 * path.length
                start = (x, y, 0.0)
                plant = popsteer.sim.KinematicBicycle(car)
                driver, slow = popsteer.PreviewPop(path, car), wheelbase
                result = popsteer.sim.run(driver, plant=plant, start=start, constant_speed=slow)
                assert result.metrics.time > 0.9 * path.length / wheelbase
            # One that was given another place is there.
            x, y = ring[count // 2]
            half = popsteer.SpeedTracker(path, car).step(x, y, math.pi, 0.0, 0.05)
            assert half.distance_to_stop == pytest.approx(0.5 * path.length, rel=0.01)
