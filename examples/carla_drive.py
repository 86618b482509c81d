"""Drive a car along its lane in a running CARLA simulator, and say how well.

    pip install "popsteer[carla]"
    python examples/carla_drive.py --host 127.0.0.1 --port 2000 --speed 30 --seconds 60

The simulator runs in synchronous mode meanwhile and is put back afterwards. Status 2, with one line
that says why, where no simulator answers or no car can be put on the road.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import popsteer
from popsteer.adapters.carla import LocalPlanner, RoadOption
from popsteer.adapters.carla.conversions import client_library

PERIOD = 0.05  # of a control step, and of the simulator [s]


def read_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Drive a car in a running CARLA simulator.")
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=2000)
    parser.add_argument("--timeout", type=float, default=10.0, help="wait for an answer [s]")
    parser.add_argument("--car", default="vehicle.tesla.model3", help="blueprint of the car")
    parser.add_argument("--speed", type=float, default=30.0, help="speed to go at [km/h]")
    parser.add_argument("--seconds", type=float, default=60.0, help="time to drive [s]")
    return parser.parse_args()


def put_on_road(world: Any, blueprint: str) -> Any:
    """Put a car on the first free spawn point."""
    chosen = world.get_blueprint_library().find(blueprint)
    for place in world.get_map().get_spawn_points():
        actor = world.try_spawn_actor(chosen, place)
        if actor is not None:
            return actor
    raise RuntimeError("no spawn point of the map is free")


def plan_along_lane(lane_map: Any, actor: Any, length: float) -> list[tuple[Any, RoadOption]]:
    """Waypoints of the lane ahead, one a metre; straight on or the first branch at forks."""
    waypoints = [lane_map.get_waypoint(actor.get_location())]
    while len(waypoints) < length and (following := waypoints[-1].next(1.0)):
        waypoints.append(following[0])
    return [(waypoint, RoadOption.LANEFOLLOW) for waypoint in waypoints]


def drive(world: Any, arguments: argparse.Namespace) -> None:
    actor = put_on_road(world, arguments.car)
    try:
        world.tick()  # now the actor knows where it is
        lane_map = world.get_map()
        planner = LocalPlanner(actor, {"target_speed": arguments.speed}, lane_map)
        length = arguments.seconds * arguments.speed / 3.6
        planner.set_global_plan(plan_along_lane(lane_map, actor, length))
        print(f"driving {arguments.car}, {planner.vehicle.wheelbase:.2f} m between the axles")
        errors: list[float] = []
        while not planner.done() and PERIOD * len(errors) < arguments.seconds:
            actor.apply_control(planner.run_step())
            world.tick()
            if planner.command is not None:
                errors.append(abs(planner.command.cross_track_error))
        print(
            f"{PERIOD * len(errors):.1f} s, cross-track error "
            f"{sum(errors) / max(len(errors), 1):.3f} m mean, {max(errors, default=0.0):.3f} m max"
        )
    finally:
        actor.destroy()


def main() -> int:
    arguments = read_arguments()
    try:
        carla = client_library()
        client = carla.Client(arguments.host, arguments.port)
        client.set_timeout(arguments.timeout)
        world = client.get_world()
        before = world.get_settings()
        settings = world.get_settings()
        settings.synchronous_mode = True
        settings.fixed_delta_seconds = PERIOD
        world.apply_settings(settings)
        try:
            drive(world, arguments)
        finally:
            world.apply_settings(before)
    # CARLA raises both, the second for a blueprint that it does not know.
    except (popsteer.PopsteerError, RuntimeError, IndexError) as error:
        print(f"carla_drive: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
