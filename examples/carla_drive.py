"""Drive a car along its lane in a running CARLA simulator for a minute, and say how well.

It needs the extra "carla".
Run: python examples/carla_drive.py --host 127.0.0.1 --port 2000
"""

from __future__ import annotations

import argparse
from typing import Any

import popsteer
from popsteer.adapters.carla import LocalPlanner
from popsteer.adapters.carla.conversions import client_library

PERIOD = 0.05  # of a control step, and of the simulator [s]


def drive(world: Any) -> None:
    model = world.get_blueprint_library().find("vehicle.tesla.model3")
    places = world.get_map().get_spawn_points()
    actor = next(filter(None, (world.try_spawn_actor(model, place) for place in places)), None)
    if actor is None:
        raise RuntimeError("no spawn point of the map is free")
    before, settings = world.get_settings(), world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, PERIOD
    try:
        world.apply_settings(settings)
        world.tick()  # now the actor knows where it is
        planner = LocalPlanner(actor, {"target_speed": 30.0})  # km/h, as CARLA's agents have it
        time, farthest = 0.0, 0.0
        while not planner.done() and time < 60.0:
            actor.apply_control(planner.run_step())
            world.tick()
            time += PERIOD
            if planner.drive is not None:
                farthest = max(farthest, abs(planner.drive.cross_track_error))
        print(f"{time:.1f} s, never farther than {farthest:.2f} m from the middle of the lane")
    finally:
        actor.destroy()
        world.apply_settings(before)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=2000)
    parser.add_argument("--timeout", type=float, default=10.0, help="wait for an answer [s]")
    options = parser.parse_args()
    try:
        client = client_library().Client(options.host, options.port)
        client.set_timeout(options.timeout)
        drive(client.get_world())
    except (popsteer.PopsteerError, RuntimeError) as error:
        parser.exit(2, f"carla_drive: {' '.join(str(error).split())}\n")


if __name__ == "__main__":
    main()
