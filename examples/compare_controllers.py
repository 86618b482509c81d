"""Compare controllers on your path, with your car, in noise: errors and steering effort.

    python examples/compare_controllers.py

The vehicle that the controllers are given differs from the car that is driven, as on a road.
"""

from __future__ import annotations

import math

import numpy as np

import popsteer
from popsteer import sim

WAYPOINTS = [(0.5 * k, 10.0 * math.sin(0.5 * k / 20.0)) for k in range(500)]
PATH = popsteer.Path(WAYPOINTS, speed=[8.0] * len(WAYPOINTS))
GIVEN = popsteer.Vehicle(wheelbase=2.7, steer_lag=0.1, dead_time=0.1, max_steer=0.6)
DRIVEN = sim.KinematicBicycle(GIVEN.replace(wheelbase=2.85, steer_lag=0.15, steer_offset=0.01))
NOISE = sim.Noise(position=0.03, yaw=0.005, speed=0.05)
CONTROLLERS = (popsteer.PreviewPop, popsteer.PurePursuit, popsteer.Stanley, popsteer.Pop)


def main() -> None:
    """Drive each controller eight times, each time with other noise, on all cores."""
    print("controller    mean error [m]   largest [m]   steering rate, rms [rad/s]   faults")
    for kind in CONTROLLERS:
        runs = sim.run_many(
            kind(PATH, GIVEN),
            DRIVEN,
            start=sim.default_start(PATH, 0.5, GIVEN),  # half a metre beside the path
            speed=8.0,
            longitudinal=popsteer.SpeedPid(),
            noise=NOISE,
            seed=range(8),
        )
        mean = np.mean(runs["rear_axle_settled_mean_abs_cross_track_error"])
        largest = np.max(runs["rear_axle_settled_max_abs_cross_track_error"])
        rate = np.mean(runs["rms_steer_rate"])
        faults = np.count_nonzero(runs["faults"])
        print(f"{kind.__name__:12} {mean:15.3f} {largest:13.3f} {rate:28.3f} {faults:8}")


if __name__ == "__main__":
    main()
