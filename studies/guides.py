"""Draws the figures of the guides on the driver, on CARLA and on Gymnasium.

python -m studies.guides [driver] [carla] [gymnasium]
"""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

import popsteer
from popsteer import sim
from popsteer.lab.common.names import title_of
from studies.driver import drive
from studies.layout import write_figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from popsteer.lab.common.theme import Theme

PLANTED = ("position dies (nan)", "wheels stick")
CONTROLLERS = {
    "preview-pop": None,
    "stanley": popsteer.StanleyParams(),
    "pure-pursuit": popsteer.PurePursuitParams(),
}
SPEED = 8.0  # m/s


def faults() -> dict[str, Any]:
    """Drive one car of the driver's study with each fault: time, off the path, speed, the fault."""
    found = {}
    for planted in PLANTED:
        trace: list[tuple[float, float, float, str | None]] = []
        outcome = drive(np.random.default_rng([7, 14]), planted, trace)
        time, off, speed, said = zip(*trace, strict=True)
        heard = next(k for k, each in enumerate(said) if each)
        found[planted] = (
            np.array((time, off, speed)),
            heard,
            time[heard] - outcome.after,
            said[heard],
        )
    return found


def driver_figure(found: dict[str, Any], theme: Theme) -> Figure:
    """Draw speed and distance from the path, before and after what is planted."""
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    for (planted, (rows, heard, begun, said)), role, dashes in zip(
        found.items(), ("pop", "pid"), ("-", "--"), strict=True
    ):
        time = rows[0] - begun
        style: dict[str, Any] = {"color": theme.colour(role), "linestyle": dashes}
        above.plot(time, rows[2], label=f"{planted}: fault {said!r}", **style)
        below.plot(time, rows[1], **style)
        for panel, row in ((above, 2), (below, 1)):
            panel.plot(time[heard], rows[row][heard], "o", color=style["color"], markersize=6)
    for panel in (above, below):
        panel.axvline(0.0, color=theme.faint, linewidth=1.0)
        panel.set_xlim(-2.0, 6.0)
        panel.set_ylim(bottom=0.0)
    above.set_ylabel("speed [m/s]")
    below.set_ylabel("off the path [m]")
    below.set_xlabel("time after the signal dies, or the wheels stick [s]")
    above.set_title("The driver says what fails (dot), and stops", fontsize=11)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def carla() -> dict[str, Any]:
    """Drive a route of CARLA's own map by each controller: way and error."""
    from popsteer.adapters.carla import LocalPlanner, RoadOption
    from tests.adapters.carla_actor import CAR, Actor, road, route

    lane_map = road()
    waypoints = route(lane_map)
    path = popsteer.Path([(w.transform.location.x, -w.transform.location.y) for w in waypoints])
    found = {}
    for name, controller in CONTROLLERS.items():
        start = sim.default_start(path, 0.0, CAR)
        plant = sim.KinematicBicycle(CAR)
        options: dict[str, Any] = {"start": start, "speed": SPEED, "tracked_point": CAR.rear_axle}
        actor = Actor(lane_map, sim.Simulation(path, plant, **options))
        planner = LocalPlanner(
            actor,
            {"target_speed": 3.6 * SPEED},
            driver=partial(popsteer.Driver, controller=controller),
            pedals=sim.PedalMap.of(plant),
        )
        planner.set_global_plan([(each, RoadOption.LANEFOLLOW) for each in waypoints])
        while not (actor.simulation.is_over or planner.done()):
            actor.apply_control(planner.run_step())
            actor.tick()
        records = actor.simulation.records()
        gone = np.hypot(np.diff(records["x"]), np.diff(records["y"]))
        along = np.concatenate(([0.0], np.cumsum(gone)))
        found[name] = along, records["cross_track_error"]
    return found


def carla_figure(found: dict[str, Any], theme: Theme) -> Figure:
    """Draw errors along the route."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    panel = figure.subplots()
    styles = theme.styles(found)
    for name, (along, error) in found.items():
        style: dict[str, Any] = {"color": theme.colour(name), "linestyle": styles[name]}
        panel.plot(along, 1e3 * error, label=title_of(name), **style)
    panel.set_ylabel("rear axle left of\nthe lane's middle [mm]")
    panel.set_xlabel("along the route [m]")
    panel.set_title(f"A route of CARLA's map at {SPEED:g} m/s, by three controllers", fontsize=11)
    panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def gymnasium() -> tuple[popsteer.Path, Any]:
    """Drive highway-env's race track, as the example does: its path, and the poses of a lap."""
    from examples.highway_env import drive as laps

    path, poses = laps(laps=1.0)
    return path, poses


def gymnasium_figure(found: tuple[popsteer.Path, Any], theme: Theme) -> Figure:
    """Draw a lap in the colours of its distance from the middle of the lane."""
    path, poses = found
    errors = [abs(path.project(x, y).cross_track_error) for x, y, _ in poses]
    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    panel: Axes = figure.subplots()
    closed = np.append(path.x, path.x[0]), np.append(path.y, path.y[0])
    panel.plot(*closed, color=theme.path, linewidth=9, solid_capstyle="butt", label="the lane")
    dots = panel.scatter(
        poses[:, 0], poses[:, 1], c=1e3 * np.array(errors), s=10, cmap="viridis", zorder=3
    )
    figure.colorbar(dots, ax=panel, shrink=0.8, label="from the middle of the lane [mm]")
    panel.set_aspect("equal")
    panel.invert_yaxis()  # as highway-env draws it
    panel.set_xlabel("x [m]")
    panel.set_ylabel("y [m]")
    panel.set_title("highway-env's racetrack-v1: a lap of preview POP at 10 m/s", fontsize=11)
    panel.legend(loc="lower right")
    return figure


def main(wanted: list[str]) -> None:
    """Draw those that are wanted, by default all."""
    figures: dict[str, Any] = {
        "driver": lambda: partial(driver_figure, faults()),
        "carla": lambda: partial(carla_figure, carla()),
        "gymnasium": lambda: partial(gymnasium_figure, gymnasium()),
    }
    write_figures({name: made() for name, made in figures.items() if not wanted or name in wanted})


if __name__ == "__main__":
    main(sys.argv[1:])
