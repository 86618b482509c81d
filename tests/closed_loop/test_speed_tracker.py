"""Speeds that are planned, then kept: plants, cusps, paths without speeds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest

import popsteer
from popsteer import Path, Vehicle, planning, sim, tracks
from popsteer.planning import SpeedLimits
from popsteer.plants import get
from popsteer.tracks import edges
from studies import parking
from studies.chain import Chain

if TYPE_CHECKING:
    from numpy.typing import NDArray

DT = 0.05
# What the plants' engines and drag leave, and what is asked of them at the most.
WHAT_THEY_DRIVE = tuple(
    (float(v), min(2.0, max(0.05, 0.85 * (5.5 - 0.28 * v - 0.001 * v * v)))) for v in range(26)
)
LIMITS = SpeedLimits(max_acceleration=WHAT_THEY_DRIVE)


class Driven(NamedTuple):
    """A run, a row a step, and how it ended."""

    time: NDArray[np.float64]
    speed: NDArray[np.float64]
    yaw: NDArray[np.float64]
    reference: NDArray[np.float64]
    stops: list[tuple[float, float]]
    """Where the rear axle stood [m], at each cusp and at the end."""


def _start(path: Path, car: Vehicle) -> tuple[float, float, float]:
    """The rear axle at the first waypoint."""
    yaw = math.atan2(path.y[1] - path.y[0], path.x[1] - path.x[0])
    if path.reverse is not None and path.reverse[0]:
        yaw += math.pi
    back = car.rear_axle
    return float(path.x[0] - back * math.cos(yaw)), float(path.y[0] - back * math.sin(yaw)), yaw


def _drive(
    path: Path, plant: Any, car: Vehicle, speed: float = 0.0, limit: float = 150.0
) -> Driven:
    itself = sim.vehicle_of(plant)
    controller = popsteer.PreviewPop(path, itself)
    tracker = popsteer.SpeedTracker(path, car)
    pedals = sim.PedalMap.of(plant)
    settings = sim.Settings(dt=DT, stop_distance=0.0, time_limit=limit)
    start = _start(path, itself)
    world = sim.Simulation(path, plant, start=start, speed=speed, settings=settings)
    rows, stops, reverse, standing = [], [], False, 0
    while world.time < limit and standing < 10 and world.ending != "plant limit":
        x, y, yaw, v = world.state
        wanted = controller.step(x, y, yaw, v, DT)
        command = tracker.step(x, y, yaw, v, DT)
        gear = -1.0 if command.reverse else 1.0
        rear = (x + itself.rear_axle * math.cos(yaw), y + itself.rear_axle * math.sin(yaw))
        if command.reverse != reverse:
            reverse = command.reverse
            stops.append(rear)
        rows.append((world.time, v, yaw, gear * command.reference_speed))
        throttle, brake = pedals(command.acceleration, gear * v)
        world.step(wanted.steer, throttle, brake, command.reverse)
        standing = standing + 1 if command.standing and abs(v) < 1e-2 else 0
        if standing == 10:
            stops.append(rear)
            rows = rows[:-9]  # it has arrived when it first stands
        if v < 1.2 and speed > 0.0 and command.distance_to_stop < 1.0:
            break  # a model that does not stand
    columns = np.array(rows).T
    return Driven(columns[0], columns[1], columns[2], columns[3], stops)


def _check(driven: Driven, profile: planning.SpeedProfile) -> dict[str, float]:
    error = driven.speed - driven.reference
    along = np.gradient(driven.speed, DT)[5:-5]
    side = np.abs(np.gradient(np.unwrap(driven.yaw), DT) * driven.speed)[5:-5]
    return {
        "rms": float(np.sqrt((error * error).mean())),
        "driving": float(along.max()),
        "braking": float(-along.min()),
        "side": float(side.max()),
        "time": float(driven.time[-1]) / profile.time,
    }


@pytest.mark.parametrize("name", ["carla-identified", "commonroad-mb-2", "mujoco-car"])
@pytest.mark.parametrize("track", ["slalom", "racetrack"])
def test_planned_speed_is_kept_on_the_plants(name: str, track: str) -> None:
    if name.startswith("commonroad"):
        pytest.importorskip("vehiclemodels")
    if name.startswith("mujoco"):
        pytest.importorskip("mujoco")
    plant: Any = sim.CarlaIdentified() if name == "carla-identified" else get(name)
    itself = sim.vehicle_of(plant)
    car = itself.replace(
        max_speed=25.0,
        max_acceleration=2.0,
        max_deceleration=3.0,
        max_lateral_acceleration=4.0,
    )
    profile = planning.speed_profile(Path(tracks.get(track).xy), LIMITS, car)
    # The multi-body model has no speeds below 1 m/s.
    driven = _drive(profile.path, plant, car, 2.0 if name.startswith("commonroad") else 0.0)
    found = _check(driven, profile)
    print(name, track, {key: round(value, 3) for key, value in found.items()})  # noqa: T201
    assert found["rms"] <= 0.3
    assert found["driving"] <= 2.5
    assert found["braking"] <= 3.5
    assert found["side"] <= 4.5
    if track == "racetrack":
        assert found["time"] <= 1.02
    if not name.startswith("commonroad"):
        stop = driven.stops[-1]
        end = profile.path.x[-1], profile.path.y[-1]
        assert math.dist(stop, end) <= 0.1


@pytest.mark.parametrize("make", [edges.three_point_turn, edges.parallel_parking])
@pytest.mark.parametrize("name", ["bicycle", "mujoco-car"])
def test_vehicle_stops_at_cusps_and_at_the_end(make: Any, name: str) -> None:
    way = make()
    if name == "mujoco-car":
        pytest.importorskip("mujoco")
        plant: Any = get(name)
    else:
        plant = sim.KinematicBicycle(Vehicle(wheelbase=2.7, max_steer=0.6, max_steer_rate=0.6))
    car = sim.vehicle_of(plant).replace(max_speed=2.0, max_acceleration=1.0, max_deceleration=1.0)
    path = Path(way.xy, speed=way.speed)
    driven = _drive(path, plant, car, limit=120.0)
    assert path.reverse is not None
    cusps = np.flatnonzero(path.reverse[1:-1] != path.reverse[:-2]) + 1
    wanted = [*cusps.tolist(), len(path) - 1]
    assert len(driven.stops) == len(wanted)
    for (x, y), index in zip(driven.stops, wanted, strict=True):
        before = index - 1
        yaw = math.atan2(path.y[index] - path.y[before], path.x[index] - path.x[before])
        # Along the path; beside it is the steering's.
        off = (x - path.x[index]) * math.cos(yaw) + (y - path.y[index]) * math.sin(yaw)
        assert abs(off) <= 0.1, index


def test_path_without_speeds_is_driven_within_the_limits() -> None:
    # A planner's path with a bend that no car takes at its speed, on a simulator of its own.
    xy = [(0.5 * k, 0.0) for k in range(200)]
    xy += [
        (99.5 + 10.0 * math.sin(a), 10.0 - 10.0 * math.cos(a)) for a in np.linspace(0.05, 3.1, 62)
    ]
    car = Vehicle(wheelbase=2.7, max_steer=0.6, max_speed=20.0, drive_lag=0.2)
    for speeds in (None, [30.0] * len(xy)):
        path = Path(xy, speed=speeds)
        tracker = popsteer.SpeedTracker(path, car)
        controller = popsteer.PreviewPop(path, car)
        chain = Chain(car, (0.0, 0.0, 0.0), 0.0, DT)
        pull, fastest, side = 0.0, 0.0, 0.0
        command = tracker.step(*chain.pose, chain.speed, DT)
        for _ in range(900):
            steer = controller.step(*chain.pose, chain.speed, DT).steer
            command = tracker.step(*chain.pose, chain.speed, DT)
            if command.standing and chain.speed <= 0.0:
                break
            pull += (command.acceleration - pull) * (1.0 - math.exp(-DT / car.drive_lag))
            chain.speed = max(chain.speed + DT * pull, 0.0)
            chain.advance(steer)
            fastest = max(fastest, chain.speed)
            side = max(side, abs(chain.yaw_rate * chain.speed))
        assert command.standing
        assert math.dist(chain.pose[:2], xy[-1]) < 0.15
        assert 12.0 < fastest < 20.5
        assert side < 4.5


def test_speed_above_the_plan_is_braked_and_the_command_is_smooth() -> None:
    path = Path([(float(x), 0.0) for x in range(301)], speed=[8.0] * 301)
    params = popsteer.SpeedTrackerParams(max_jerk=5.0)
    tracker = popsteer.SpeedTracker(path, Vehicle(max_deceleration=2.0), params)
    speed, x, last = 16.0, 0.0, 0.0
    for _ in range(200):
        pull = tracker.step(x, 0.0, 0.0, speed, DT).acceleration
        assert abs(pull - last) <= 5.0 * DT + 1e-12
        assert pull >= -2.4
        last = pull
        speed += DT * pull
        x += DT * speed
    assert speed == pytest.approx(8.0, abs=0.1)


@pytest.mark.parametrize("slope", [-0.08, 0.0, 0.08])
@pytest.mark.parametrize("max_jerk", [2.0, 4.0, 10.0])
def test_braking_that_builds_up_slowly_begins_in_time(max_jerk: float, slope: float) -> None:
    gravity = -9.80665 * slope / math.hypot(1.0, slope)
    params = popsteer.SpeedTrackerParams(max_jerk=max_jerk)
    for fast in (3.0, 10.0, 20.0):
        path = Path([(float(x), 0.0) for x in range(161)], grade=[slope] * 161)
        tracker = popsteer.SpeedTracker(path, Vehicle(rear_axle=0.0, max_speed=fast), params)
        x, speed = 0.0 if fast > 10.0 else 100.0, fast
        pulls = [-gravity] * 100  # a drive that acts 0.1 s late
        for _ in range(round(60.0 / DT)):
            command = tracker.step(x, 0.0, 0.0, speed, DT)
            assert not command.cannot_stop
            for _ in range(50):
                pulls.append(command.acceleration)
                faster = speed + 1e-3 * (pulls.pop(0) + gravity)
                speed = max(faster, 0.0) if pulls[0] < 0.0 else faster
                x += 1e-3 * speed
        assert command.standing, (fast, x)
        assert abs(x - 160.0) < 0.1, (fast, x)


@pytest.mark.xfail(reason="place 0.040 m, heading 0.64 degrees since slip is learnt while parking")
def test_parking_at_the_end_of_an_arc_keeps_place_and_heading() -> None:
    for radius in (5.0, 9.0):
        for backwards in (False, True):
            pieces = [
                (backwards, 0.0, 6.0),
                (backwards, 1.0 / radius, math.pi / 4.0 * radius),
            ]
            for seed in parking.SEEDS:
                found = parking.park(pieces, seed)
                case = (radius, backwards, seed, found)
                assert math.isfinite(found.time), case
                assert found.aside < 0.15, case
                assert found.place < 0.03, case
                assert found.heading < 0.6, case


def test_a_drive_lag_told_within_a_factor_of_two_parks_as_exactly() -> None:
    for name, pieces in parking.bays(5.0).items():
        for drive_lag in (0.1, 2.0 * parking.LAG):
            found = parking.row(pieces, drive_lag=drive_lag)
            case = (name, drive_lag, found)
            assert math.isfinite(found.time), case
            assert found.aside < 0.15, case
            # How noisy positions are is not known at first, so slip is learnt more slowly there.
            assert found.place < (0.045 if name == "45°, out of a bend" else 0.04), case
            assert found.heading < 1.0, case
