"""A control loop of your own: a planner sends a new path at each step, the pose is the centre's.

    python examples/own_loop.py

The planner here cuts the next 30 m out of a course; the car is one line of a bicycle's motion. Put
your planner, your localisation and your car in their place.
"""

from __future__ import annotations

import math

import popsteer

PERIOD = 0.05  # of the control loop [s]
CAR = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, max_steer=0.6, max_steer_rate=0.8)
COURSE = [(0.5 * k, 8.0 * math.sin(0.5 * k / 25.0)) for k in range(601)]


def plan_from(x: float, y: float) -> popsteer.Path:
    """Plan a path as a planner does: from a little behind the vehicle to 30 m ahead."""
    nearest = min(range(len(COURSE)), key=lambda k: math.dist(COURSE[k], (x, y)))
    return popsteer.Path(COURSE[max(0, nearest - 4) : nearest + 60])


def main() -> None:
    """Drive the course and say how closely the rear axle followed it."""
    x, y, yaw, speed, steer = 0.0, 0.4, 0.3, 8.0, 0.0  # of the rear axle
    controller = popsteer.PreviewPop(plan_from(x, y), CAR)
    controller.reset(steer=steer)
    course, errors = popsteer.Path(COURSE), []
    while x < 280.0:
        centre = (x + 1.35 * math.cos(yaw), y + 1.35 * math.sin(yaw))
        controller.set_path(plan_from(*centre))
        command = controller.step_or_hold(*centre, yaw, speed, PERIOD)
        if command.status.level == "fault":
            raise SystemExit(f"stopped: {command.status}")
        errors.append(abs(course.project(x, y).cross_track_error))

        steer = command.steer
        yaw += PERIOD * speed * math.tan(steer) / 2.7
        x += PERIOD * speed * math.cos(yaw)
        y += PERIOD * speed * math.sin(yaw)
    print(f"{len(errors)} steps, as many paths; after 5 s at most {max(errors[100:]):.3f} m off")


if __name__ == "__main__":
    main()
