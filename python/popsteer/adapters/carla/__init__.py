"""CARLA: a local planner for its agents, and what converts between it and popsteer.

`LocalPlanner` replaces that of CARLA's agents, so that a ``BasicAgent`` drives with a
controller of popsteer::

    agent = BasicAgent(actor)
    agent._local_planner = popsteer.adapters.carla.LocalPlanner(actor)

It needs the extra ``carla``. See docs/carla.md.

Every sign and unit that differs is converted in `popsteer.adapters.carla.conversions`:

==================  =========================  ================================================
quantity            CARLA                      popsteer
==================  =========================  ================================================
y                   to the right               to the left
yaw                 clockwise [°]              counter-clockwise [rad]
speed of the agent  [km/h]                     [m/s]
steering            share of the lock, right   angle of the front wheels, left [rad]
Ackermann steering  to the right [rad]         to the left [rad]
positions of wheels in the world [cm]          ahead of the vehicle's point [m]
==================  =========================  ================================================

Examples
--------
>>> import carla
>>> from popsteer.adapters.carla import Steering, pose_of, vehicle_control
>>> pose_of(carla.Transform(carla.Location(x=3.0, y=4.0), carla.Rotation(yaw=-90.0)))
(3.0, -4.0, 1.5707963267948966)
>>> control = vehicle_control(-0.25, 0.5, 0.0, steering=Steering(lock=1.0))
>>> control.steer, control.throttle
(0.25, 0.5)
"""

from popsteer.adapters.carla.conversions import (
    Steering,
    ackermann_control,
    path_of,
    pose_of,
    speed_from_kmh,
    speed_of,
    transform_of,
    vehicle_control,
)
from popsteer.adapters.carla.planner import LocalPlanner
from popsteer.adapters.carla.route import RoadOption
from popsteer.adapters.carla.vehicle import steering_of, vehicle_of

__all__ = [
    "LocalPlanner",
    "RoadOption",
    "Steering",
    "ackermann_control",
    "path_of",
    "pose_of",
    "speed_from_kmh",
    "speed_of",
    "steering_of",
    "transform_of",
    "vehicle_control",
    "vehicle_of",
]
