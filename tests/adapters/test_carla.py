"""CARLA's client reads a road, and a driver of popsteer drives its waypoints.

The library is the real one. The one stand-in is the actor with its world, in `carla_actor.py`: a
plant of popsteer moves it, by what `carla.VehicleControl` says and nothing else.
"""

from __future__ import annotations

import math
import warnings
from functools import partial
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.adapters.carla import LocalPlanner, RoadOption, path_of, steering_of

pytest.importorskip("carla", reason='the extra "carla" is not installed')
pytest.importorskip("scenariogeneration", reason="scenariogeneration is not installed")

import carla

from tests.adapters.carla_actor import CAR, Actor, road, route

SPEED = 8.0
ROADS = {"road": road(), "mirrored": road(-1.0)}
ROUTES = {name: route(each) for name, each in ROADS.items()}


def path_along(name: str, speed: float | None = None) -> popsteer.Path:
    """The route in popsteer's frame, without the adapter."""
    places = [waypoint.transform.location for waypoint in ROUTES[name]]
    xy = [(place.x, -place.y) for place in places]
    return popsteer.Path(xy, speed=None if speed is None else [speed] * len(xy))


def plan_along(name: str) -> list[tuple[Any, int]]:
    return [(waypoint, RoadOption.LANEFOLLOW) for waypoint in ROUTES[name]]


def actor_on(
    name: str, *, offset: float = 0.5, speed: float = SPEED, tracked: float = CAR.rear_axle
) -> Actor:
    """An actor beside the begin of the route; its errors are those of its rear axle."""
    path = path_along(name)
    start = sim.default_start(path, offset, CAR)
    plant = sim.KinematicBicycle(CAR)
    simulation = sim.Simulation(path, plant, start=start, speed=speed, tracked_point=tracked)
    return Actor(ROADS[name], simulation)


def drive(actor: Actor, planner: LocalPlanner, steps: int = 2000) -> None:
    for _ in range(steps):
        if actor.simulation.is_over or planner.done():
            break
        actor.apply_control(planner.run_step())
        actor.tick()


@pytest.mark.parametrize("name", ROADS)
@pytest.mark.parametrize("controller", [None, popsteer.StanleyParams(), popsteer.PopParams()])
def test_lap_through_carla_is_as_close_as_that_of_sim_run(name: str, controller: Any) -> None:
    path, plant = path_along(name, SPEED), sim.KinematicBicycle(CAR)
    make = partial(popsteer.Driver, controller=controller)
    driver = make(path, CAR.replace(stop_point=0.0))  # the actor's point stops
    start = sim.default_start(path, 0.5, CAR)
    plain = sim.run(driver, plant, start=start, speed=SPEED)
    actor = actor_on(name, tracked=driver.tracked_point)
    options, pedals = {"target_speed": 3.6 * SPEED}, sim.PedalMap.of(plant)
    planner = LocalPlanner(actor, options, driver=make, pedals=pedals)
    planner.set_global_plan(plan_along(name))
    while not actor.simulation.is_over:
        actor.apply_control(planner.run_step())
        actor.tick()
    through, direct = actor.simulation.records(), plain.records
    assert plain.metrics.finished
    assert actor.simulation.is_finished
    assert len(through["steer"]) == len(direct["steer"]) > 700
    errors = through["cross_track_error"], direct["cross_track_error"]
    assert np.abs(errors[1]).max() > 0.4  # it starts beside the path
    assert np.abs(errors[0] - errors[1]).max() < 0.01
    assert np.abs(through["steer"] - direct["steer"]).max() < 0.001
    assert np.abs(through["speed"] - direct["speed"]).max() < 0.01


def test_mirrored_road_bends_to_the_other_side() -> None:
    turns = []
    for waypoints in ROUTES.values():
        yaws = [math.radians(-waypoint.transform.rotation.yaw) for waypoint in waypoints]
        steps = np.diff(np.unwrap(yaws))
        turns.append((steps.max(), steps.min(), steps.sum()))
    assert turns[0][2] > 1.5
    assert turns[1][2] < -1.5
    assert all(most > 0.02 and least < -0.02 for most, least, _ in turns)


def test_plan_with_repeated_waypoints_is_driven_to_its_end() -> None:
    waypoints = ROUTES["road"]
    twice = [waypoint for index, waypoint in enumerate(waypoints) for _ in range(1 + index % 2)]
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan([(waypoint, RoadOption.LANEFOLLOW) for waypoint in twice])
    drive(actor, planner)
    assert planner.driver is not None
    assert len(planner.driver.path) == len(waypoints)
    assert actor.simulation.is_finished or planner.done()


def test_plan_is_let_go_as_it_is_driven_and_stopped_at_its_end() -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan(plan_along("road")[:100])
    left = []
    for _ in range(600):
        control = planner.run_step()
        left.append(len(planner.get_plan()))
        # CARLA's planner looks 3 m and half a second ahead; the last waypoint stays until 1 m.
        reach = 3.0 + 0.5 * actor.simulation.state[3]
        ahead = planner.target_waypoint.transform.location.distance(actor.get_location())
        if left[-1] > 1:
            assert reach - 0.1 < ahead < reach + 1.1
        if planner.done():
            break
        actor.apply_control(control)
        actor.tick()
    assert left == sorted(left, reverse=True)
    assert planner.done()
    end = ROUTES["road"][99].transform.location
    assert actor.get_location().distance(end) < 1.0
    assert planner.get_incoming_waypoint_and_direction() == (None, RoadOption.VOID)
    for _ in range(100):
        actor.apply_control(planner.run_step())
        actor.tick()
    # The actor's point is on the last waypoint, and held there.
    assert actor.get_location().distance(end) < 0.05
    assert actor.simulation.state[3] == 0.0
    assert (actor.control.throttle, actor.control.brake) == (0.0, 1.0)


def test_pedals_that_do_more_or_less_than_their_map_says_are_learnt() -> None:
    for pedals in (sim.PedalMap(5.0, 7.0, drag=0.2), sim.PedalMap(7.0, 11.0, drag=0.4)):
        actor = actor_on("road", offset=0.0, speed=0.0)
        planner = LocalPlanner(actor, {"target_speed": 28.8}, pedals=pedals)
        planner.set_global_plan(plan_along("road"))
        drive(actor, planner, 240)
        speeds = actor.simulation.records()["speed"]
        assert speeds[-40:] == pytest.approx(8.0, abs=0.15), pedals
        assert speeds.max() < 8.5


def test_speeds_that_are_left_to_carla_are_those_of_the_driver() -> None:
    actor = actor_on("road", offset=0.0, speed=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan(plan_along("road"))
    steering = steering_of(actor)
    for _ in range(1200):
        control, speed = planner.run_ackermann_step(), actor.simulation.state[3]
        push = control.speed - speed  # by a loop that is none of popsteer's
        share = steering.share(-control.steer, speed)
        actor.apply_control(carla.VehicleControl(max(push, 0.0), share, max(-push, 0.0)))
        actor.tick()
    speeds = actor.simulation.records()["speed"]
    assert speeds[300:400] == pytest.approx(30.0 / 3.6, abs=0.05)
    assert (control.speed, planner.fault) == (0.0, None)
    assert speeds[-1] == pytest.approx(0.0, abs=1e-6)
    assert actor.get_location().distance(ROUTES["road"][-1].transform.location) < 0.3
    assert np.abs(actor.simulation.records()["cross_track_error"]).max() < 0.05


@pytest.mark.parametrize("steps", [15, 120])
@pytest.mark.parametrize("asked", [True, False])
def test_agent_that_brakes_by_itself_is_no_fault_and_driven_on_from(
    *, steps: int, asked: bool
) -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 200)  # into the first bend
    for _ in range(
        steps
    ):  # agents brake over the planner's answer, or in its place, wheels straight
        control = planner.run_step() if asked else carla.VehicleControl()
        control.throttle, control.brake = 0.0, 0.5
        actor.apply_control(control)
        actor.tick()
    before = len(actor.simulation.records()["steer"])
    drive(actor, planner, 100)
    records = actor.simulation.records()
    assert planner.fault is None
    assert records["speed"][-1] == pytest.approx(30.0 / 3.6, abs=0.5)
    drive(actor, planner)
    assert actor.simulation.is_finished
    errors = np.abs(actor.simulation.records()["cross_track_error"])
    assert errors[before + 100 :].max() < 0.05


def test_waypoints_are_let_go_as_far_ahead_of_an_actor_that_rolls_backwards() -> None:
    for speed in (6.0, -6.0):
        actor = actor_on("road", offset=0.0, speed=speed)
        planner = LocalPlanner(actor, {"base_min_distance": 2.0, "distance_ratio": 0.8})
        planner.set_global_plan(plan_along("road")[:100])
        planner.run_step()
        ahead = planner.target_waypoint.transform.location.distance(actor.get_location())
        assert 6.7 < ahead < 7.9, speed


def test_waypoint_ahead_is_the_one_so_many_steps_on() -> None:
    planner = LocalPlanner(actor_on("road"))
    plan = plan_along("road")
    planner.set_global_plan(plan)
    assert planner.get_incoming_waypoint_and_direction()[0] is plan[3][0]
    assert planner.get_incoming_waypoint_and_direction(steps=7) == plan[7]
    # As many as there are, and one less: the last is the last.
    for steps in (len(plan) - 1, len(plan)):
        assert planner.get_incoming_waypoint_and_direction(steps=steps) == plan[-1]
    assert planner.get_incoming_waypoint_and_direction(steps=10**6) == plan[-1]


def test_planner_without_a_plan_follows_its_lane_to_the_end_of_the_road() -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    assert not planner.done()
    drive(actor, planner)
    errors = np.abs(actor.simulation.records()["cross_track_error"])
    assert actor.simulation.is_finished
    assert errors.max() < 0.05


def test_planner_without_a_plan_keeps_a_hundred_waypoints_ahead() -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0, "sampling_radius": 0.5})
    for _ in range(200):
        actor.apply_control(planner.run_step())
        actor.tick()
        # The step itself lets go what is nearer than it looks ahead, 7 m.
        assert 100 - 15 <= len(planner._route.ahead) < 200


def test_plan_that_begins_ahead_in_a_bend_is_reached_along_the_lane() -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    drive(actor, planner, 250)  # into the first bend
    # As BasicAgent.set_destination does: from the planner's target on.
    where = planner.target_waypoint
    later = [(where, RoadOption.LANEFOLLOW)]
    while following := later[-1][0].next(2.0):
        later.append((following[0], RoadOption.LANEFOLLOW))
    planner.set_global_plan(later)
    # What was driven for the lane before is no part of it.
    assert planner.driver is not None
    path, (x, y, *_) = planner.driver.path, actor.simulation.state
    assert math.dist((path.x[0], path.y[0]), (x, y)) < 20.0
    done = len(actor.simulation.records()["steer"])
    drive(actor, planner)
    errors = np.abs(actor.simulation.records()["cross_track_error"])
    assert errors[done:].max() < 0.05


def test_plan_added_to_the_last_one_carries_on() -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    plan = plan_along("road")
    planner.set_global_plan(plan[:80])
    drive(actor, planner, 100)
    planner.set_global_plan(plan[80:], clean_queue=False)
    drive(actor, planner)
    errors = np.abs(actor.simulation.records()["cross_track_error"])
    assert actor.simulation.is_finished
    assert errors.max() < 0.05


def test_speed_is_that_of_the_agent_or_of_the_limit() -> None:
    actor = actor_on("road", offset=0.0, speed=0.0)
    planner = LocalPlanner(actor)
    planner.set_global_plan(plan_along("road"))
    planner.set_speed(36.0)
    drive(actor, planner, 300)
    assert actor.simulation.state[3] == pytest.approx(10.0, abs=0.1)
    actor.speed_limit = 18.0
    planner.follow_speed_limits()
    drive(actor, planner, 100)
    assert actor.simulation.state[3] == pytest.approx(5.0, abs=0.1)
    # Nothing, and what is no number, is to stand: in comfort, and in its place.
    for speed_limit in (0.0, math.nan):
        actor.speed_limit = speed_limit
        drive(actor, planner, 60)
        assert (actor.simulation.state[3], planner.fault) == (0.0, None)
        actor.speed_limit = 18.0
        drive(actor, planner, 100)
        assert actor.simulation.state[3] == pytest.approx(5.0, abs=0.1)


def test_limits_of_the_agent_bound_the_control() -> None:
    actor = actor_on("road", speed=0.0)
    planner = LocalPlanner(actor, {"max_throttle": 0.3, "max_steering": 0.25})
    planner.set_global_plan(plan_along("road"))
    assert planner.car.max_steer == pytest.approx(0.25 * CAR.max_steer)
    drive(actor, planner, 20)
    assert planner.run_step().throttle == pytest.approx(0.3)


def test_offset_shifts_the_path_to_the_right() -> None:
    actor = actor_on("road", offset=0.0)
    planner = LocalPlanner(actor, {"target_speed": 30.0, "offset": 0.7})
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 200)
    assert actor.simulation.records()["cross_track_error"][-1] == pytest.approx(-0.7, abs=0.02)
    planner.set_offset(-0.7)
    drive(actor, planner, 250)
    assert actor.simulation.records()["cross_track_error"][-1] == pytest.approx(0.7, abs=0.02)


def test_second_step_in_a_frame_repeats_the_first() -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor)
    planner.set_global_plan(plan_along("road"))
    first = planner.run_step()
    answer = planner.drive
    again = planner.run_step()
    assert (again.steer, again.throttle) == (first.steer, first.throttle)
    assert answer is not None
    assert planner.drive is not None
    assert (planner.drive.steer, planner.drive.speed) == (answer.steer, answer.speed)
    # A simulator that is started anew counts from 0: that is another frame.
    actor.tick()
    planner.run_step()
    before, actor.world.time = planner.drive, 0.0
    planner.run_step()
    assert str(planner.drive) != str(before)


def test_pose_that_is_no_number_stops_the_car_along_the_path(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0, "max_brake": 0.2})
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 190)  # before a bend
    broken = carla.Transform(carla.Location(math.nan, 0.0, 0.0), carla.Rotation(yaw=math.nan))
    monkeypatch.setattr(actor, "get_transform", lambda: broken)
    for step in range(200):
        control = planner.run_step()
        assert (planner.fault is None) == (step < 9), step  # half a second
        assert math.isfinite(control.steer)
        actor.apply_control(control)
        actor.tick()
    assert planner.fault == "input"
    assert len(planner.get_plan()) > 150  # no waypoint is taken for one that is driven
    assert actor.simulation.state[3] == 0.0
    assert (control.throttle, control.brake) == (0.0, 1.0)
    errors = actor.simulation.records()["cross_track_error"]
    assert np.abs(errors[100:]).max() < 0.3  # it goes on around the bend
    monkeypatch.undo()
    # What comes again does not drive by itself; a plan is the word to.
    for _ in range(20):
        actor.apply_control(planner.run_step())
        actor.tick()
    assert (planner.fault, actor.simulation.state[3]) == ("input", 0.0)
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 60)
    assert (str(planner.fault), actor.simulation.state[3] > 1.0) == ("None", True)


def test_pose_with_one_number_that_is_none_counts_as_none(monkeypatch: pytest.MonkeyPatch) -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 190)  # before a bend
    # Its rotation is finite, and not that of the car.
    broken = carla.Transform(carla.Location(math.nan, 0.0, 0.0), carla.Rotation(yaw=120.0))
    monkeypatch.setattr(actor, "get_transform", lambda: broken)
    drive(actor, planner, 200)
    assert (planner.fault, actor.simulation.state[3]) == ("input", 0.0)
    errors = actor.simulation.records()["cross_track_error"]
    assert np.abs(errors[100:]).max() < 0.3


def test_car_whose_speed_is_dead_or_whose_wheels_are_stuck_is_stopped_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for fault in ("speed", "steering"):
        actor = actor_on("road", offset=0.0)
        planner = LocalPlanner(actor, {"target_speed": 30.0})
        planner.set_global_plan(plan_along("road"))
        drive(actor, planner, 100)
        if fault == "speed":
            monkeypatch.setattr(actor, "get_velocity", carla.Vector3D)
        for _ in range(250):
            control = planner.run_step()
            actor.apply_control(control)
            if fault == "steering":  # the wheels are stuck, and the actor does not say so
                own = carla.VehicleControl(steer=control.steer)
                monkeypatch.setattr(actor, "get_control", lambda o=own: o)
                control.steer = 0.1
            actor.tick()
        monkeypatch.undo()
        assert planner.fault == fault
        assert actor.simulation.state[3] == 0.0, fault


def test_agents_own_call_makes_the_planner() -> None:
    actor = actor_on("road")
    options = {"target_speed": 20, "ignore_traffic_lights": True, "sampling_resolution": 2.0}
    planner = LocalPlanner(vehicle=actor, opt_dict=options, map_inst=ROADS["road"])
    assert planner.target_waypoint.road_id == 1
    assert planner.target_road_option == RoadOption.LANEFOLLOW
    assert list(planner.get_plan()) == [(planner.target_waypoint, RoadOption.LANEFOLLOW)]
    planner.run_step(debug=True)
    assert len(actor.world.debug.points) == 1


def test_vehicle_that_is_let_go_is_not_driven() -> None:
    planner = LocalPlanner(actor_on("road"), car=popsteer.Vehicle(wheelbase=2.5))
    assert planner.car.wheelbase == 2.5
    planner.run_step()
    planner.reset_vehicle()
    for step in (planner.run_step, planner.run_ackermann_step):
        with pytest.raises(popsteer.PopsteerError, match="no vehicle after reset_vehicle"):
            step()


def test_gains_of_carlas_loops_are_said_not_to_apply() -> None:
    with pytest.warns(UserWarning, match="lateral_control_dict"):
        LocalPlanner(actor_on("road"), {"lateral_control_dict": {"K_P": 1.0}})
    with pytest.warns(UserWarning, match="'target_sped' is not used: did you mean 'target_speed'"):
        LocalPlanner(actor_on("road"), {"target_sped": 30.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        agents = {"sampling_resolution": 2.0, "ignore_traffic_lights": True}
        LocalPlanner(actor_on("road"), {"sampling_radius": 1.0, **agents})


def test_path_of_waypoints_is_theirs_with_y_to_the_left() -> None:
    found, wanted = path_of(ROUTES["road"]), path_along("road")
    assert np.array_equal(found.x, wanted.x)
    assert np.array_equal(found.y, wanted.y)
