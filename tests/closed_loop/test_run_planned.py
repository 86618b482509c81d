"""Runs whose speeds a `SpeedTracker` plans and keeps."""

from __future__ import annotations

import copy
import math
import pickle
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import ConfigError, InputError, Path, Vehicle, sim, tracks
from popsteer.plants import get
from popsteer.tracks import edges
from tests.closed_loop.drives import Bicycle
from tests.helpers import authors_data

CAR = Vehicle(
    wheelbase=2.7,
    rear_axle=-1.3,
    max_steer=0.6,
    max_speed=20.0,
    max_acceleration=2.0,
    max_deceleration=3.0,
    max_lateral_acceleration=4.0,
    drive_lag=0.2,
)


def _bends() -> Path:
    return Path([(0.5 * k, 8.0 * math.sin(0.03 * k)) for k in range(500)])


def _by_hand(path: Path, plant: Any, tracker: Any, pedals: Any, settings: sim.Settings) -> Any:
    """The same loop in Python, over the plant and the public steps."""
    car = sim.vehicle_of(plant)
    controller = popsteer.PreviewPop(path, car)
    start = sim.default_start(path, vehicle=car)
    world = sim.Simulation(
        path, plant, start=start, tracked_point=controller.tracked_point, settings=settings
    )
    while not world.is_over:
        state = world.state
        command = tracker.step(*state, settings.dt)
        steer = controller.step(*state, settings.dt).steer
        gear = -1.0 if command.reverse else 1.0
        throttle, brake = pedals(command.acceleration, gear * state[3])
        world.step(steer, throttle, brake, command.reverse)
    return world.records()


@pytest.mark.parametrize("made", [_bends, edges.three_point_turn], ids=["bends", "cusps"])
def test_run_planned_is_the_loop_by_hand_to_the_bit(made: Any) -> None:
    way = made()
    path = way if isinstance(way, Path) else Path(way.xy, speed=way.speed)
    plant, settings = sim.KinematicBicycle(CAR), sim.Settings(time_limit=90.0)
    tracker = popsteer.SpeedTracker(path, CAR)
    run = sim.run(popsteer.PreviewPop(path, CAR), plant, longitudinal=tracker, settings=settings)
    assert run.ending == "finished"
    assert tracker.state.waypoint is None  # its own state is left alone
    expected = _by_hand(path, plant, tracker, sim.PedalMap.of(plant), settings)
    for name in ("x", "y", "yaw", "speed", "steer", "throttle", "brake"):
        assert np.array_equal(run.records[name], expected[name]), name


def test_run_planned_never_exceeds_what_the_path_allows() -> None:
    path = _bends()
    tracker = popsteer.SpeedTracker(path, CAR)
    noise = sim.Noise(position=0.02, yaw=0.002, speed=0.02)
    run = sim.run(
        popsteer.PreviewPop(path, CAR),
        sim.KinematicBicycle(CAR),
        longitudinal=tracker,
        noise=noise,
        seed=3,
    )
    records = run.records
    rate = np.diff(np.unwrap(records["yaw"])) / 0.05
    pull = np.convolve(np.diff(records["speed"]) / 0.05, np.ones(4) / 4.0, mode="valid")
    assert np.abs(rate * records["speed"][1:]).max() < 4.5
    assert -3.5 < pull.min() < -1.0
    assert 1.0 < pull.max() < 2.5
    assert records["speed"].max() < tracker.plan.max() + 0.3


def test_run_planned_on_a_racetrack_stays_on_it_where_the_paper_would_not() -> None:
    # Preview POP keeps the vehicle's lateral acceleration: at the paper's speeds it leaves.
    track = tracks.get("racetrack")
    car = CAR.replace(max_lateral_acceleration=3.0)
    path = Path(track.xy)
    plant = sim.KinematicBicycle(car)
    controller = popsteer.PreviewPop(path, car)
    planned = sim.run(controller, plant, longitudinal=popsteer.SpeedTracker(path, car))
    assert planned.metrics.finished
    assert planned.metrics.settled_max_abs_cross_track_error < 0.1
    assert sim.run(controller, plant).metrics.settled_max_abs_cross_track_error > 5.0


def test_runs_planned_are_single_runs() -> None:
    short = Path([(0.5 * k, 3.0 * math.sin(0.05 * k)) for k in range(200)])
    paths = [_bends(), short]
    plant = sim.KinematicBicycle(CAR)
    trackers = [popsteer.SpeedTracker(path, CAR) for path in paths]
    controllers = [popsteer.PreviewPop(path, CAR) for path in paths]
    pedals = sim.PedalMap(drive=5.0, braking=8.0, drag=0.2)
    noise = sim.Noise(position=0.05)
    many = sim.run_many(
        controllers, plant, longitudinal=trackers, pedals=pedals, noise=noise, seed=[5, 6]
    )
    for index, (controller, tracker) in enumerate(zip(controllers, trackers, strict=True)):
        run = sim.run(
            controller, plant, longitudinal=tracker, pedals=pedals, noise=noise, seed=5 + index
        )
        assert run.metrics.rms_cross_track_error == many["rms_cross_track_error"][index]
        assert run.metrics.mean_speed == many["mean_speed"][index]


def test_run_planned_works_the_pedals_of_a_plant_in_python() -> None:
    pytest.importorskip("vehiclemodels")
    plant = get("commonroad-st-2")
    path = _bends()
    car = sim.vehicle_of(plant).replace(max_acceleration=2.0, max_deceleration=3.0)
    run = sim.run(popsteer.PreviewPop(path), plant, longitudinal=popsteer.SpeedTracker(path, car))
    assert run.metrics.finished
    assert run.metrics.settled_max_abs_cross_track_error < 0.2


def test_run_planned_without_known_pedals_asks_for_them() -> None:
    path = Path([(float(x), 0.0) for x in range(60)])
    plant: Any = Bicycle()
    plant.params = None
    tracker = popsteer.SpeedTracker(path, plant.vehicle)
    with pytest.raises(InputError, match=r"pedals must be given, as .* has no drive, braking"):
        sim.run(popsteer.Stanley(path), plant, longitudinal=tracker)
    plant.params = sim.KinematicBicycle()
    known = sim.run(popsteer.Stanley(path), plant, longitudinal=tracker)
    pedals = sim.PedalMap(drive=6.0, braking=9.0, drag=0.28)
    given = sim.run(popsteer.Stanley(path), plant, longitudinal=tracker, pedals=pedals)
    assert known.metrics == given.metrics


def test_run_planned_for_another_path_is_refused() -> None:
    path, other = _bends(), Path([(0.0, 0.0), (50.0, 0.0)])
    tracker = popsteer.SpeedTracker(other, CAR)
    controller = popsteer.PreviewPop(path, CAR)
    with pytest.raises(ConfigError, match="longitudinal must be a SpeedTracker of the path that"):
        sim.run(controller, sim.KinematicBicycle(CAR), longitudinal=tracker)
    with pytest.raises(ConfigError, match="of the path that is driven of controller 0"):
        sim.run_many(controller, sim.KinematicBicycle(CAR), longitudinal=tracker)
    elsewhere = popsteer.SpeedTracker(path, CAR.replace(rear_axle=0.0))
    with pytest.raises(ConfigError, match="rear_axle must be that of the plant"):
        sim.run(controller, sim.KinematicBicycle(CAR), longitudinal=elsewhere)
    with pytest.raises(ConfigError, match="pedals must be None where longitudinal is no"):
        sim.run(controller, pedals=sim.PedalMap(drive=6.0, braking=9.0))
    anything: Any = 3.0
    with pytest.raises(TypeError, match="a CoupledLongitudinal, a SpeedPid or a SpeedTracker"):
        sim.run(controller, sim.KinematicBicycle(CAR), longitudinal=anything)


def test_speed_tracker_is_pickled_and_copied_with_what_it_remembers() -> None:
    params = popsteer.SpeedTrackerParams(kp=2.0)
    tracker = popsteer.SpeedTracker(_bends(), CAR, params)
    tracker.step(10.0, 1.0, 0.4, 5.0, 0.05)
    for other in (pickle.loads(pickle.dumps(tracker)), copy.copy(tracker), copy.deepcopy(tracker)):
        assert other.state == tracker.state
        assert (other.params, other.vehicle) == (params, CAR)
        assert np.array_equal(other.plan, tracker.plan)
        before = tracker.state
        assert other.step(11.0, 1.1, 0.4, 5.2, 0.05) == tracker.step(11.0, 1.1, 0.4, 5.2, 0.05)
        tracker.state = before


def test_speed_tracker_goes_on_along_a_new_path() -> None:
    x = [0.5 * k for k in range(400)]
    tracker = popsteer.SpeedTracker(Path([(a, 0.0) for a in x]), CAR)
    for k in range(20):
        before = tracker.step(40.5 + 0.5 * k, 0.0, 0.0, 10.0, 0.05)
    # The same way, but shorter: the place stays, and the command changes by the jerk alone.
    tracker.set_path(Path([(a, 0.0) for a in x[:220]]))
    assert tracker.state.waypoint == 97
    after = tracker.step(50.5, 0.0, 0.0, 10.0, 0.05)
    assert after.distance_to_stop == pytest.approx(109.5 - 49.2)
    assert abs(after.acceleration - before.acceleration) <= 20.0 * 0.05
    # One that begins elsewhere too: waypoint 38 is at 49 m.
    tracker.set_path(Path([(a + 30.0, 0.1) for a in x[:220]]))
    assert tracker.state.waypoint == 37
    assert tracker.step(51.0, 0.0, 0.0, 10.0, 0.05).distance_to_stop == pytest.approx(139.5 - 49.7)


SMALL = popsteer.Vehicle(wheelbase=0.33, max_steer=0.42, steer_lag=0.05, max_steer_rate=3.0)


def bends(radius: float, transition: float, spacing: float) -> popsteer.Path:
    """S-bends of a radius, joined by curvatures that change evenly over a length [m]."""
    arc = 2.0 * radius
    pattern = [1.0, -1.0] * 8
    curvature = [0.0] * 40
    for sign in pattern:
        start = curvature[-1] * radius
        ramp = np.linspace(start, sign, round(transition / spacing * abs(sign - start) / 2))
        curvature += (ramp / radius).tolist() + [sign / radius] * round(arc / spacing)
    yaw = np.cumsum(np.array(curvature) * spacing)
    x, y = np.cumsum(np.cos(yaw) * spacing), np.cumsum(np.sin(yaw) * spacing)
    return popsteer.Path(np.column_stack((x, y)))


@pytest.mark.parametrize(
    ("controller", "mean", "largest"),
    [
        (popsteer.PreviewPop, 0.003, 0.02),
        (popsteer.Stanley, 0.03, 0.06),
        (popsteer.PurePursuit, 0.3, 0.5),
        (popsteer.Pop, 0.3, 0.5),
        (popsteer.Pid, 0.06, 0.12),
    ],
)
def test_small_car_on_the_defaults_stays_on_its_path(
    controller: type[popsteer.PreviewPop], mean: float, largest: float
) -> None:
    path = bends(1.5, 1.0, 0.02)
    run = sim.run(
        controller(path),
        sim.KinematicBicycle(SMALL),
        constant_speed=2.0,
        settings=sim.Settings(dt=0.02, settling_time=3.0),
    )
    assert run.ending == "finished"
    assert run.metrics.settled_mean_abs_cross_track_error <= mean
    assert run.metrics.settled_max_abs_cross_track_error <= largest


def drive(
    path: popsteer.Path, start: tuple[float, float, float], offset: float
) -> tuple[list[popsteer.Estimate], float]:
    """What preview POP knows at each step, and its mean error after 5 s [m].

    The identified plant's wheels stand at `offset` at the command 0, which nobody told.
    """
    given = popsteer.vehicles.get("carla-identified")
    plant = sim.CarlaIdentified(given.replace(steer_offset=offset))
    controller = popsteer.PreviewPop(path, given)
    pedals = popsteer.CoupledLongitudinal()
    simulation = sim.Simulation(path, plant, start=start, tracked_point=controller.tracked_point)
    known = []
    while not simulation.is_over:
        x, y, yaw, speed = simulation.state
        command = controller.step(x, y, yaw, speed, simulation.settings.dt)
        known.append(controller.estimate)
        simulation.step(command.steer, *pedals.step(speed, command.steer))
    assert simulation.is_finished
    return known, simulation.metrics()["settled_mean_abs_cross_track_error"]


def check_offset(path: popsteer.Path, start: tuple[float, float, float]) -> None:
    offset = math.radians(1.0)
    straight, error = drive(path, start, 0.0)
    known, crooked_error = drive(path, start, offset)
    after = round(10.0 / 0.05)
    for estimate in known[after:]:
        assert abs(estimate.steer_offset - offset) < math.radians(0.1)
    for estimate in straight[after:]:
        assert abs(estimate.steer_offset) < math.radians(0.1)
    assert crooked_error <= 2.0 * error


def test_steering_offset_that_nobody_told_is_found_in_ten_seconds_of_bends() -> None:
    track = tracks.get("racetrack")
    path = popsteer.Path(track.xy, speed=track.speed)
    check_offset(path, sim.default_start(path, vehicle=popsteer.vehicles.get("carla-identified")))


def test_steering_offset_is_found_on_the_authors_track() -> None:
    path = popsteer.Path.from_csv(authors_data() / "waypoints.csv", columns="x,y,speed")
    check_offset(path, (-183.797, 79.760, -1.574))
