"""Planning: the fastest speeds along a path, and a path from recorded waypoints.

Examples
--------
>>> import popsteer
>>> from popsteer import planning
>>> car = popsteer.Vehicle(wheelbase=2.7, max_steer_rate=0.4, max_speed=15.0)
>>> path = popsteer.Path([(float(x), 0.0) for x in range(201)])
>>> profile = planning.speed_profile(path, vehicle=car)
>>> float(profile.speed.max())
15.0
"""

from popsteer.planning.limits import SpeedLimits
from popsteer.planning.profile import SpeedProfile
from popsteer.planning.smoothing import smooth
from popsteer.planning.speeds import curvature, speed_profile, speeds_along

__all__ = [
    "SpeedLimits",
    "SpeedProfile",
    "curvature",
    "smooth",
    "speed_profile",
    "speeds_along",
]
