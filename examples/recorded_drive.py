"""Record a drive as a car's computer does: an MCAP log, and beside it the waypoints.

The car is one that nobody has measured: it turns by another wheelbase than its own, its steering
has 1 degree of offset, a lag and a dead time, and its poses and speeds have noise.

    python examples/recorded_drive.py FOLDER SECONDS    # needs popsteer[lab]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import popsteer
from popsteer import sim, tracks
from popsteer.adapters.ros2 import Recording, ackermann_message, odometry_message

NOISE = np.array([0.02, 0.02, 0.002, 0.02])  # of x, y [m], yaw [rad] and speed [m/s]
PERIOD = 0.05  # of the control loop [s]
CAR = popsteer.Vehicle(
    wheelbase=2.7,
    rear_axle=-1.35,
    max_steer=0.6,
    turning_wheelbase=2.85,
    understeer=0.003,
    steer_offset=math.radians(1.0),
    steer_lag=0.1,
    dead_time=0.15,
)


def main() -> None:
    folder, seconds = Path(sys.argv[1]), float(sys.argv[2])
    track = tracks.get("racetrack")
    # With all of its speed Stanley has no margin left for the dead time.
    path = popsteer.Path(track.xy, speed=np.maximum(0.75 * track.speed, 5.0), closed=True)
    stanley = popsteer.Stanley(path, CAR)
    pedals = popsteer.SpeedPid(popsteer.SpeedPidParams(kp=1.0, ki=0.5))
    start = sim.default_start(path, vehicle=CAR)
    world = sim.Simulation(path, sim.KinematicBicycle(CAR), start=start, speed=5.0)
    random = np.random.default_rng(13)
    with Recording(folder / "drive.mcap") as log:
        while world.time < seconds:
            x, y, yaw, speed = (world.state + NOISE * random.standard_normal(4)).tolist()
            steer = stanley.step(x, y, yaw, speed, PERIOD).steer
            at = round((1.7e9 + world.time) * 1e9)  # [ns]
            log.add("/localization/odometry", odometry_message(x, y, yaw, speed, at, "map"), at)
            log.add("/control/drive", ackermann_message(steer, speed, 0.0, at, "base_link"), at)
            world.step(steer, *pedals.step(speed, world.reference_speed or 5.0, PERIOD))
    header = "x [m], y [m]"
    np.savetxt(folder / "waypoints.csv", track.xy, "%.3f", delimiter=",", header=header)
    print(f"{log.file}: {world.time:.1f} s of driving, {log.count} messages")


if __name__ == "__main__":
    main()
