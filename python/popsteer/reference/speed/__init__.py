"""The greatest speeds along a path.

`curvature` takes the curvature from waypoints that are noisy, and `speed_profile` finds the
greatest speeds that a vehicle's limits allow along it. Both run once for a path, not in a step.
"""

from popsteer.reference.speed.curvature import path_curvature
from popsteer.reference.speed.limits import Limits, OverSpeed
from popsteer.reference.speed.profile import Course, plan_speeds

__all__ = ["Course", "Limits", "OverSpeed", "path_curvature", "plan_speeds"]
