"""Drive ten laps of highway-env's racetrack, and draw them where a file is named.

Install: pip install highway-env matplotlib
Run: python examples/highway_env.py [lap.png]
"""

import sys
from typing import Any

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import popsteer

# highway-env's car: the pose is the centre's, the wheels turn at once. x, y and yaw need no sign.
CAR = popsteer.Vehicle(
    wheelbase=5.0, rear_axle=-2.5, steer_lag=0.0, max_steer=np.pi / 4, max_lateral_acceleration=None
)


def centre_line(network: Any, number: int) -> popsteer.Path:
    """Follow the lanes of that number once around, a waypoint a metre."""
    points: list[Any] = []
    for node, (following,) in network.graph.items():
        lane = network.get_lane((node, following, number))
        for along in range(int(lane.length)):
            point, yaw = lane.position(along, 0.0), lane.heading_at(along)
            # Lanes overlap where they meet: a path must not double back there.
            if not points or (point - points[-1]) @ (np.cos(yaw), np.sin(yaw)) > 0.5:
                points.append(point)
    return popsteer.Path(points, closed=True)


def drive(law: Any = popsteer.PreviewPop, laps: float = 10.0, seed: int = 0) -> Any:
    """Let a controller steer; give the path, and the poses of the car."""
    config = {"other_vehicles": 0, "duration": 1e6, "observation": {"type": "LidarObservation"}}
    env: Any = gymnasium.make("highway_env:racetrack-v1", config=config).unwrapped
    env.reset(seed=seed)
    car, dt = env.vehicle, 1.0 / env.config["policy_frequency"]
    path = centre_line(env.road.network, car.lane_index[2])
    controller = law(path, CAR)
    poses: list[Any] = []
    while car.on_road and len(poses) * dt * car.speed < laps * path.length:
        steer = controller.step(*car.position, car.heading, car.speed, dt).steer
        env.step(np.array([steer / CAR.max_steer], dtype=np.float32))  # 1 is 45 degrees
        poses.append((*car.position, car.heading))
    return path, np.array(poses)


if __name__ == "__main__":
    del sys.path[0]  # this folder, where Python would take this file for highway_env
    path, poses = drive()
    errors = [abs(path.project(x, y).cross_track_error) for x, y, _ in poses]
    print(f"{len(poses)} steps, never farther than {max(errors):.2f} m from the middle of the lane")
    if len(sys.argv) > 1:
        plt.axes(aspect="equal").plot(path.x, path.y, "0.85", linewidth=12)
        plt.plot(poses[:, 0], poses[:, 1])
        plt.savefig(sys.argv[1])
