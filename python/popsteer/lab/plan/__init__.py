"""The table of a plan: what limits the speed where."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from popsteer.lab.common.layout import add_numbers, blank_table
from popsteer.planning import SpeedProfile
from popsteer.planning.profile import LIMITS

if TYPE_CHECKING:
    from rich.table import Table

__all__ = ["plan_caption", "plan_table"]

_WORDS = {
    "top speed": "top speed",
    "speed limit": "speed limit there",
    "lateral": "lateral acceleration",
    "steer angle": "angle of the wheels",
    "steer rate": "rate of the wheels",
    "stop": "start, cusp or end",
    "driving": "driving acceleration",
    "braking": "braking deceleration",
    "jerk": "jerk",
}


def plan_caption(profile: SpeedProfile, name: str) -> str:
    """Say in one line what a plan comes to: name, length, time and speeds."""
    path = profile.path
    kind = "lap" if path.closed else "path"
    mean = path.length / profile.time
    return (
        f"{name}: {kind} of {path.length:.1f} m, {len(path)} waypoints, in {profile.time:.2f} s,"
        f" {mean:.1f} m/s on average, {profile.speed.max():.1f} m/s at most"
    )


def plan_table(profile: SpeedProfile) -> Table:
    """Set out what limits the speed along which share of the path, the largest share first."""
    table = blank_table()
    table.add_column("limited by", no_wrap=True)
    add_numbers(table, "share\n[%]", "length\n[m]", "speeds\n[m/s]")
    for name, share in profile.shares().items():
        speeds = profile.speed[profile.limit == LIMITS.index(name)]
        low, high = float(np.min(speeds)), float(np.max(speeds))
        table.add_row(
            _WORDS[name],
            f"{100.0 * share:.1f}",
            f"{share * profile.path.length:.1f}",
            f"{low:.1f}" if high - low < 0.05 else f"{low:.1f} to {high:.1f}",
        )
    return table
