"""CARLA's own agents drive the planner, unchanged: their calls, their routes, their stops.

No package brings them. Where POPSTEER_CARLA_AGENTS names the folder that contains CARLA's
``agents`` (``PythonAPI/carla`` of a release), and networkx and shapely are there for them, this
runs; elsewhere it is skipped. The actor is the stand-in of `carla_actor.py`.
"""

from __future__ import annotations

import importlib
import os
from itertools import pairwise
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import popsteer
from popsteer import sim
from popsteer.adapters.carla import LocalPlanner

pytest.importorskip("carla", reason='the extra "carla" is not installed')
pytest.importorskip("scenariogeneration", reason="scenariogeneration is not installed")
pytest.importorskip("networkx", reason="networkx, which CARLA's agents need, is not installed")
pytest.importorskip("shapely", reason="shapely, which CARLA's agents need, is not installed")

import carla
from scenariogeneration import xodr

from tests.adapters.carla_actor import CAR, Actor, bends, route

if not os.environ.get("POPSTEER_CARLA_AGENTS"):
    pytest.skip(
        "POPSTEER_CARLA_AGENTS does not name the folder of CARLA's agents", allow_module_level=True
    )

SPEED = 30.0  # [km/h]


def lanes() -> carla.Map:
    """Three roads, one behind the other, of two lanes a side: routes need more than one road."""
    drive = xodr.OpenDrive("bends", geo_reference="+proj=tmerc +lat_0=0 +lon_0=0")
    roads = [
        xodr.create_road(bend, id=k, left_lanes=2, right_lanes=2, lane_width=4)
        for k, bend in enumerate(bends(), 1)
    ]
    for k, (before, after) in enumerate(pairwise(roads), 1):
        before.add_successor(xodr.ElementType.road, k + 1, xodr.ContactPoint.start)
        after.add_predecessor(xodr.ElementType.road, k, xodr.ContactPoint.end)
    for road in roads:
        drive.add_road(road)
    drive.adjust_roads_and_lanes()
    return carla.Map("bends", ET.tostring(drive.get_element(), encoding="unicode"))


MAP = lanes()
ROUTE = route(MAP)
END = ROUTE[-1].transform.location


@pytest.fixture
def agents(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The classes of agents, with popsteer's planner as docs/carla.md puts it in."""
    monkeypatch.syspath_prepend(os.environ["POPSTEER_CARLA_AGENTS"])
    basic = importlib.import_module("agents.navigation.basic_agent")
    behaviour = importlib.import_module("agents.navigation.behavior_agent")
    monkeypatch.setattr(basic, "LocalPlanner", LocalPlanner)
    return {"basic": basic.BasicAgent, "behaviour": behaviour.BehaviorAgent}


def actor(speed: float = SPEED / 3.6) -> Actor:
    places = [waypoint.transform.location for waypoint in ROUTE]
    path = popsteer.Path([(place.x, -place.y) for place in places])
    start = sim.default_start(path, 0.0, CAR)
    plant = sim.KinematicBicycle(CAR)
    simulation = sim.Simulation(path, plant, start=start, speed=speed, tracked_point=CAR.rear_axle)
    return Actor(MAP, simulation)


def drive(agent: Any, driven: Actor, steps: int = 1500) -> np.ndarray[Any, Any]:
    """Drive until the agent is done; the errors [m]."""
    for _ in range(steps):
        if agent.done() or driven.simulation.is_over:
            break
        driven.apply_control(agent.run_step())
        driven.tick()
    errors: np.ndarray[Any, Any] = driven.simulation.records()["cross_track_error"]
    return errors


@pytest.mark.parametrize("kind", ["basic", "behaviour"])
def test_agent_drives_its_route_to_the_end(agents: dict[str, Any], kind: str) -> None:
    driven = actor()
    agent = agents[kind](driven, opt_dict={}, map_inst=MAP)
    agent.set_destination(END)
    errors = drive(agent, driven)
    assert agent.done()
    assert driven.get_location().distance(END) < 5.0  # the agent's waypoints are 2 m apart, or 4.5
    assert np.abs(errors).max() < 0.05


def test_agent_waits_at_a_red_light_and_drives_on(agents: dict[str, Any]) -> None:
    driven = actor()
    agent = agents["behaviour"](driven, opt_dict={}, map_inst=MAP)
    agent.set_destination(END)
    drive(agent, driven, 200)
    # While it is red the agent brakes by itself, and does not ask the planner.
    agent.traffic_light_manager = lambda: True
    drive(agent, driven, 200)
    assert driven.simulation.state[3] == pytest.approx(0.0, abs=0.01)
    del agent.traffic_light_manager
    errors = drive(agent, driven)
    assert driven.get_location().distance(END) < 5.0
    # It braked in a bend with its wheels straight; 3 s later it is back.
    assert 0.3 < np.abs(errors).max() < 1.0
    assert np.abs(errors[460:]).max() < 0.05


def test_agent_changes_speed_and_lane_and_takes_another_destination(agents: dict[str, Any]) -> None:
    driven = actor()
    agent = agents["basic"](driven, target_speed=20.0, map_inst=MAP)
    agent._local_planner = LocalPlanner(driven, {"target_speed": 20.0})  # as docs/carla.md has it
    agent.set_destination(END)
    agent.set_target_speed(18.0)
    drive(agent, driven, 150)
    assert driven.simulation.state[3] == pytest.approx(5.0, abs=0.1)
    driven.speed_limit = 36.0
    agent.follow_speed_limits()
    agent.lane_change("right", lane_change_time=3)
    errors = drive(agent, driven)
    assert errors[-1] == pytest.approx(-4.0, abs=0.6)  # the lane's width; its plan ends there
    # It speeds up, and stops where that plan ends.
    assert driven.simulation.records()["speed"].max() > 6.0
    assert agent.done()
    agent.set_destination(END, driven.get_location())
    done = len(errors)
    errors = drive(agent, driven)
    assert agent.done()
    assert len(errors) > done
    assert np.isfinite(errors).all()
