"""The page of a plan: a car that drives it, its speeds, and what limits them."""

from __future__ import annotations

from typing import Any

import numpy as np

from popsteer.lab.common.names import counted
from popsteer.lab.plan import plan_caption, plan_table
from popsteer.lab.plan.figures import COLOURS
from popsteer.lab.report.colours import figure, line, named
from popsteer.lab.report.markup import badge, block, table
from popsteer.lab.report.page import NOWHERE, Origin, Page, Section, vehicles
from popsteer.lab.report.scene import ANGLES, Actor, Panel, Scene
from popsteer.planning import SpeedProfile
from popsteer.planning.profile import LIMITS

_PANELS = (
    Panel("speed", "Speed [m/s]", "v [m/s]", 2),
    Panel("along", "Acceleration along the path [m/s²]", "a [m/s²]", 2),
    Panel("aside", "Acceleration to the side [m/s²]", "a_y [m/s²]", 2),
    ANGLES,
)


def of_plan(profile: SpeedProfile, name: str, origin: Origin = NOWHERE) -> bytes:
    """Make the page of a plan of the speeds along a path of that name.

    Examples
    --------
    >>> import popsteer
    >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    >>> profile = popsteer.planning.speed_profile(path)
    >>> of_plan(profile, "straight").startswith(b"<!doctype html>")
    True
    """
    limits = "\n".join(f"{key} = {value}" for key, value in vars(profile.limits).items())
    head = "The wheels turn far enough for every bend"
    if profile.too_sharp.size:
        bends = counted(profile.too_sharp.size, "waypoint")
        head = f"Too sharp for the wheels: the path at {bends}"
    return Page(
        title=f"Speeds along {name}",
        lead=plan_caption(profile, name),
        command=origin.command,
        results=badge(head, [], good=not profile.too_sharp.size)
        + table(plan_table(profile), "What limits the speed"),
        scenes=[_scene(profile, name)],
        roles={"plan": named("pop")} | {key: named(key) for key in set(COLOURS.values())},
        figures=[_figure(profile)],
        sections=[
            vehicles(("plan", profile.vehicle, profile.vehicle)),
            Section("parameters", "Limits", block("The limits, as --set takes them", limits)),
        ],
    ).content()


def _scene(profile: SpeedProfile, name: str) -> Scene:
    path, speed = profile.path, profile.speed
    gone = np.diff(path.s)
    taken = 2.0 * gone / np.maximum(speed[1:] + speed[:-1], 1e-3)
    heading = np.unwrap(np.arctan2(np.gradient(path.y), np.gradient(path.x)))
    car = profile.vehicle
    along = np.resize(profile.acceleration, len(speed))
    columns: dict[str, Any] = {
        "time": np.concatenate(([0.0], np.cumsum(taken))),
        "distance": path.s,
        "x": path.x,
        "y": path.y,
        "yaw": heading if path.reverse is None else heading + np.pi * np.asarray(path.reverse),
        "speed": speed,
        "along": along,
        "aside": speed * speed * profile.curvature,
        "steer_deg": np.degrees(np.arctan(car.turning_length(0.0) * profile.curvature)),
    }
    return Scene(name, [Actor("plan", "the plan", named("pop"), columns)], _PANELS, car, [path])


def _figure(profile: SpeedProfile) -> dict[str, Any]:
    """Draw the speeds, each stretch in the colour of what limits it."""
    traces = []
    for limit in profile.shares():
        mine = profile.limit == LIMITS.index(limit)
        shown = mine.copy()
        shown[:-1] |= mine[1:]
        speeds = np.where(shown, profile.speed, np.nan)
        traces.append(line(limit, profile.path.s, speeds, f"@{COLOURS[limit]}", width=2.0))
    return figure(
        "Planned speed and what limits it",
        f"{profile.time:.1f} s for the whole path.",
        traces,
        "distance along the path [m]",
        {"title": {"text": "speed [m/s]"}, "rangemode": "tozero"},
    )
