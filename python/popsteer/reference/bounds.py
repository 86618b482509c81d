"""The bounds of what a step takes: within them nothing overflows."""

from __future__ import annotations

MAX_COORDINATE = 1e9
"""The largest coordinate [m], of waypoints and vehicles alike."""
MAX_SPEED = 1e4
"""The largest reference speed, and the largest speed of a vehicle [m/s]."""
MAX_YAW = 1e6
"""The largest yaw [rad] that a step takes; it need not be wrapped."""
MIN_DT = 1e-6
"""The shortest control period [s]."""
MAX_DT = 1e3
"""The longest control period [s]."""
