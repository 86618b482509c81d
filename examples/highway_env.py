"""Drive highway-env's racetrack with a controller of popsteer.

    pip install popsteer highway-env
    python examples/highway_env.py                       # ten laps, with preview POP
    python examples/highway_env.py --controller stanley --laps 1 --out lap.png

It prints how far the vehicle was from the middle of its lane, and exits with 1 if it left the lane.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

import popsteer
from popsteer import controllers

# Python looks beside the program first, where `highway_env` would be this file.
sys.path[:] = [folder for folder in sys.path if Path(folder).resolve() != Path(__file__).parent]
try:
    import gymnasium
    import highway_env  # noqa: F401 - registers racetrack-v1
except ModuleNotFoundError as error:
    sys.exit(f"this example needs {error.name}: pip install gymnasium highway-env")

LANE_WIDTH = 5.0  # m
CAR_LENGTH, CAR_WIDTH = 5.0, 2.0  # m
STEERING_RANGE = math.pi / 4  # rad at an action of 1

# What the environment's vehicle is: its pose is that of the centre, its wheels turn at once. x, y
# and yaw are used as they are: the picture alone has y downwards; left looks like right on it.
CAR = popsteer.Vehicle(
    wheelbase=CAR_LENGTH,
    rear_axle=-CAR_LENGTH / 2,
    steer_lag=0.0,
    dead_time=0.0,
    max_steer=STEERING_RANGE,
    max_steer_rate=None,
    max_lateral_acceleration=None,
)


def centre_line(road: Any, lane_index: tuple[str, str, int]) -> popsteer.Path:
    """Follow the lanes of that number once around, a waypoint a metre.

    Lanes overlap where they meet, by up to 0.7 m: what does not lie ahead of the last waypoint is
    left out, as a path that doubles back for a moment is one that no vehicle can follow.
    """
    start, _, number = lane_index
    points: list[Any] = []
    node = start
    while True:
        (following,) = road.network.graph[node]
        lane = road.network.get_lane((node, following, number))
        count = max(2, round(lane.length))
        for k in range(count):
            along = k * lane.length / count
            point, yaw = lane.position(along, 0.0), lane.heading_at(along)
            ahead = np.array([math.cos(yaw), math.sin(yaw)])
            if not points or (point - points[-1]) @ ahead > 0.5:
                points.append(point)
        node = following
        if node == start:
            return popsteer.Path(np.array(points), closed=True)


def drive(name: str, laps: float, seed: int) -> dict[str, Any]:
    """Let a controller drive; give what was seen."""
    env = gymnasium.make("racetrack-v1", config={"other_vehicles": 0, "duration": 1e6})
    env.reset(seed=seed)
    inside: Any = env.unwrapped
    car = inside.vehicle
    path = centre_line(inside.road, car.lane_index)
    controller = controllers.get(name).controller(path, CAR)
    dt = 1.0 / inside.config["policy_frequency"]
    driven, over = 0.0, False
    seen: list[tuple[float, float, float]] = []
    while driven < laps * path.length and not over:
        x, y = car.position.tolist()
        command = controller.step(x, y, car.heading, car.speed, dt)
        before = car.position.copy()
        action = np.array([command.steer / STEERING_RANGE], dtype=np.float32)
        *_, terminated, truncated, _ = env.step(action)
        over = terminated or truncated
        driven += float(np.hypot(*(car.position - before)))
        x, y = car.position.tolist()
        seen.append((x, y, margin(path, x, y, float(car.heading))))
    env.close()
    return {"path": path, "laps": driven / path.length, "over": over, "seen": np.array(seen)}


def margin(path: popsteer.Path, x: float, y: float, yaw: float) -> float:
    """Give the distance that the outermost corner of the car has left to the edge of its lane."""
    offsets = []
    for ahead in (-CAR_LENGTH / 2, CAR_LENGTH / 2):
        for left in (-CAR_WIDTH / 2, CAR_WIDTH / 2):
            corner_x = x + ahead * math.cos(yaw) - left * math.sin(yaw)
            corner_y = y + ahead * math.sin(yaw) + left * math.cos(yaw)
            offsets.append(abs(path.project(corner_x, corner_y).cross_track_error))
    return LANE_WIDTH / 2 - max(offsets)


def draw(result: dict[str, Any], file: Path) -> None:
    """Draw the lane and where the car drove, y upwards."""
    import matplotlib.pyplot as plt

    path, seen = result["path"], result["seen"]
    figure, axes = plt.subplots(figsize=(9, 6), layout="constrained")
    x, y = np.append(path.x, path.x[0]), np.append(path.y, path.y[0])
    axes.plot(x, y, color="0.85", linewidth=16, solid_capstyle="round", label="lane")
    axes.plot(x, y, color="0.5", linewidth=0.8, linestyle="--", label="its middle")
    axes.plot(seen[:, 0], seen[:, 1], color="C3", linewidth=1.2, label="centre of the car")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.legend(loc="upper right")
    figure.savefig(file, dpi=120)


def main() -> int:
    """Drive, say what came of it, and draw it where that is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--controller", default="preview-pop", choices=controllers.names())
    parser.add_argument("--laps", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0, help="which lane, and where on it")
    parser.add_argument("--out", type=Path, help="a picture of what was driven")
    options = parser.parse_args()
    result = drive(options.controller, options.laps, options.seed)
    path, seen = result["path"], result["seen"]
    errors = [path.project(x, y).cross_track_error for x, y, _ in seen]
    kept = not result["over"] and seen[:, 2].min() > 0.0
    print(
        f"{options.controller}: {result['laps']:.1f} laps of {path.length:.0f} m,"
        f" {len(seen)} steps;"
        f" the centre was {np.max(np.abs(errors)):.2f} m from the middle of the lane at most,"
        f" {np.mean(np.abs(errors)):.2f} m on average;"
        f" the outermost corner was {abs(seen[:, 2].min()):.2f} m"
        f" {'inside' if seen[:, 2].min() > 0.0 else 'beyond'} the edge of the lane"
    )
    print("the lane was kept" if kept else "the lane was LEFT")
    if options.out is not None:
        draw(result, options.out)
        print(f"picture: {options.out}")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
