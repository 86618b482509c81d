"""What each option of CARLA's planner does where it is given, and where it is left out."""

from __future__ import annotations

import inspect
import re
from typing import TYPE_CHECKING, Any

import pytest

import popsteer

carla = pytest.importorskip("carla", reason='the extra "carla" is not installed')

from popsteer.adapters.carla import LocalPlanner  # noqa: E402
from tests.adapters.test_carla import actor_on, drive, plan_along  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.adapters.carla_actor import Actor

PLAN = plan_along("road")[:120]


def _wanted_speed(actor: Actor, planner: LocalPlanner) -> float:
    planner.set_global_plan(PLAN)
    planner.run_step()
    assert planner.driver is not None
    speeds = planner.driver.path.speed
    assert speeds is not None
    return float(speeds[0])


def _spacing(actor: Actor, planner: LocalPlanner) -> float:
    planner.run_step()
    places = [waypoint.transform.location for waypoint, _ in planner.get_plan()]
    return float(places[20].distance(places[30])) / 10.0


def _most(actor: Actor, planner: LocalPlanner, pedal: str, speed: float) -> float:
    """The most of a pedal in a second in which another speed is wanted."""
    planner.set_global_plan(PLAN)
    planner.set_speed(speed)
    drive(actor, planner, 20)
    return float(actor.simulation.records()[pedal].max())


def _throttle(actor: Actor, planner: LocalPlanner) -> float:
    return _most(actor, planner, "throttle", 100.0)


def _brake(actor: Actor, planner: LocalPlanner) -> float:
    return _most(actor, planner, "brake", 0.0)


def _largest_angle(actor: Actor, planner: LocalPlanner) -> float:
    return planner.car.max_steer


def _to_the_right(actor: Actor, planner: LocalPlanner) -> float:
    planner.set_global_plan(PLAN)
    planner.run_step()
    path, place = planner.driver.path, PLAN[5][0].transform.location  # type: ignore[union-attr]
    return path.project(place.x, -place.y).cross_track_error


def _let_go(speed: float) -> Callable[[Actor, LocalPlanner], float]:
    """How far ahead the next waypoint lies, of those 2 m apart, at a speed."""

    def found(actor: Actor, planner: LocalPlanner) -> float:
        planner.set_global_plan(PLAN)
        planner.run_step()
        assert abs(actor.simulation.state[3]) == speed
        return float(planner.target_waypoint.transform.location.distance(actor.get_location()))

    return found


def _first_time(actor: Actor, planner: LocalPlanner) -> float:
    """The time of the first step: that in which a limited wheel turns from straight on."""
    planner.set_global_plan(PLAN)
    planner.run_step()
    assert planner.drive is not None
    return abs(planner.drive.steer) / 0.2


def _limited(actor: Actor, planner: LocalPlanner) -> float:
    actor.speed_limit = 45.0
    return _wanted_speed(actor, planner)


# The option, another value; what is measured, where it is left out and where it is given; how well.
CASES: list[tuple[str, float, Callable[[Any, Any], float], float, float, float]] = [
    ("target_speed", 36.0, _wanted_speed, 20.0 / 3.6, 10.0, 1e-6),
    ("sampling_radius", 1.2, _spacing, 2.0, 1.2, 0.02),
    ("max_throttle", 0.4, _throttle, 0.74, 0.4, 0.01),
    ("max_brake", 0.1, _brake, 0.25, 0.1, 0.01),
    ("max_steering", 0.5, _largest_angle, 1.0472, 0.5236, 1e-3),
    ("offset", 0.7, _to_the_right, 0.0, 0.7, 0.01),
    ("base_min_distance", 8.0, _let_go(0.0), 3.5, 8.5, 0.51),
    ("distance_ratio", 1.5, _let_go(10.0), 8.5, 18.5, 0.51),
    ("follow_speed_limits", 1.0, _limited, 20.0 / 3.6, 12.5, 1e-6),
    ("dt", 0.02, _first_time, 0.05, 0.02, 1e-6),
]


def test_every_option_that_is_documented_has_a_case() -> None:
    said = inspect.getdoc(LocalPlanner) or ""
    told = said.partition("opt_dict : ")[2].partition("map_inst : ")[0]
    assert {case[0] for case in CASES} == set(re.findall(r"``(\w+)``", told))


def test_every_option_does_what_is_documented_and_has_the_documented_default() -> None:
    car = popsteer.Vehicle(wheelbase=2.8, rear_axle=-1.3, max_steer=1.22, max_steer_rate=0.2)
    for name, value, measure, left_out, given, close in CASES:
        speed = {"base_min_distance": 0.0, "distance_ratio": 10.0}.get(name, 5.0)
        for options, wanted in (({}, left_out), ({name: value}, given)):
            actor = actor_on("road", offset=0.3, speed=speed)
            found = measure(actor, LocalPlanner(actor, options, car=car))
            assert found == pytest.approx(wanted, abs=close), (name, options)
