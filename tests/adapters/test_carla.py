"""CARLA's client reads a road, and a controller of popsteer drives its waypoints.

The library is the real one. The one stand-in is the actor with its world, in `carla_actor.py`: a
plant of popsteer moves it, by what `carla.VehicleControl` says and nothing else.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.adapters.carla import LocalPlanner, RoadOption, path_of

pytest.importorskip("carla", reason='the extra "carla" is not installed')
pytest.importorskip("scenariogeneration", reason="scenariogeneration is not installed")

import carla

from tests.adapters.carla_actor import CAR, Actor, road, route

SPEED = 8.0
ROADS = {"road": road(), "mirrored": road(-1.0)}
ROUTES = {name: route(each) for name, each in ROADS.items()}


def path_along(name: str) -> popsteer.Path:
    """The route in popsteer's frame, without the adapter."""
    places = [waypoint.transform.location for waypoint in ROUTES[name]]
    return popsteer.Path([(place.x, -place.y) for place in places])


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
@pytest.mark.parametrize("make", [popsteer.PreviewPop, popsteer.Stanley, popsteer.Pop])
def test_lap_through_carla_is_as_close_as_that_of_sim_run(name: str, make: Any) -> None:
    path = path_along(name)
    controller = make(path, CAR)
    start = sim.default_start(path, 0.5, CAR)
    plain = sim.run(controller, sim.KinematicBicycle(CAR), start=start, constant_speed=SPEED)
    actor = actor_on(name, tracked=controller.tracked_point)
    planner = LocalPlanner(actor, {"target_speed": 3.6 * SPEED}, controller=make)
    planner.set_global_plan(plan_along(name))
    drive(actor, planner)
    through, direct = actor.simulation.records(), plain.records
    assert plain.metrics.finished
    assert actor.simulation.is_finished
    assert len(through["steer"]) == len(direct["steer"]) > 700
    errors = through["cross_track_error"], direct["cross_track_error"]
    assert np.abs(errors[1]).max() > 0.4  # it starts beside the path
    assert np.abs(errors[0] - errors[1]).max() < 0.01
    assert np.abs(through["steer"] - direct["steer"]).max() < 0.001


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
    assert planner.controller is not None
    assert len(planner.controller.path) == len(waypoints)
    assert actor.simulation.is_finished or planner.done()


def test_plan_is_let_go_as_it_is_driven_and_ends_with_full_brakes() -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0, "max_brake": 0.3})
    planner.set_global_plan(plan_along("road")[:100])
    left = []
    for _ in range(400):
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
    stopping = planner.run_step()
    assert (stopping.throttle, stopping.brake) == (0.0, 1.0)
    for _ in range(100):
        actor.apply_control(planner.run_step())
        actor.tick()
    assert abs(actor.simulation.state[3]) < 0.1


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
    assert planner.controller is not None
    path, (x, y, *_) = planner.controller.path, actor.simulation.state
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
    assert planner.run_ackermann_step().speed == pytest.approx(5.0)


def test_limits_of_the_agent_bound_the_control() -> None:
    actor = actor_on("road", speed=0.0)
    planner = LocalPlanner(actor, {"max_throttle": 0.4, "max_steering": 0.25})
    planner.set_global_plan(plan_along("road"))
    assert planner.car.max_steer == pytest.approx(0.25 * CAR.max_steer)
    assert planner.run_step().throttle == pytest.approx(0.4)


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
    assert planner.controller is not None
    state = planner.controller.state
    again = planner.run_step()
    assert (again.steer, again.throttle) == (first.steer, first.throttle)
    assert planner.controller.state == state
    # A simulator that is started anew counts from 0: that is another frame.
    actor.tick()
    planner.run_step()
    before, actor.world.time = planner.command, 0.0
    planner.run_step()
    assert planner.command is not before


def test_pose_that_is_no_number_is_held_and_then_stops_the_car(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    actor = actor_on("road")
    planner = LocalPlanner(actor, {"target_speed": 30.0})
    planner.set_global_plan(plan_along("road"))
    drive(actor, planner, 50)
    before = actor.control
    broken = carla.Transform(carla.Location(math.nan, 0.0, 0.0), carla.Rotation())
    monkeypatch.setattr(actor, "get_transform", lambda: broken)
    for step in range(12):
        actor.world.time += 0.05
        control = planner.run_step()
        held = step < 10
        assert control.brake == (0.0 if held else 1.0)
        assert control.throttle == (pytest.approx(before.throttle) if held else 0.0)
        assert control.steer == pytest.approx(before.steer, abs=1e-3)
    assert planner.command is not None
    assert popsteer.Status.INPUT_LOST in planner.command.status
    monkeypatch.undo()
    # What comes again does not drive by itself; a plan is the word to.
    actor.world.time += 0.05
    assert planner.run_step().brake == 1.0
    assert popsteer.Status.INPUT_LOST in planner.fault
    planner.set_global_plan(plan_along("road"))
    actor.world.time += 0.05
    assert planner.run_step().throttle > 0.0


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
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        LocalPlanner(actor_on("road"), {"sampling_radius": 1.0})


def test_path_of_waypoints_is_theirs_with_y_to_the_left() -> None:
    found, wanted = path_of(ROUTES["road"]), path_along("road")
    assert np.array_equal(found.x, wanted.x)
    assert np.array_equal(found.y, wanted.y)
