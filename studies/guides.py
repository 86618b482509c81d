"""Draws the figures of the guides on the driver, CARLA, Gymnasium, C, the examples and files.

python -m studies.guides [driver] [carla] [gymnasium] [c] [examples] [files]
"""

from __future__ import annotations

import math
import sys
import tempfile
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

import popsteer
from popsteer import controllers, sim
from popsteer.lab.common.names import title_of
from studies.driver import drive
from studies.layout import DOCS, write_figures

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


def program() -> dict[str, list[float]]:
    """Drive as the C program of the page does, to the numbers that it prints."""
    page = (DOCS / "c.md").read_text(encoding="utf-8")
    toml = page.partition("```toml\n")[2].partition("```")[0]
    printed = page.partition("It prints:\n\n```text\n")[2].partition("```")[0].splitlines()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "car.toml"
        file.write_text(toml, encoding="utf-8")
        car = popsteer.Vehicle.load(file)
    path = popsteer.Path([(k, 8.0 * math.sin(k / 25.0)) for k in range(200)])
    driver = popsteer.Driver(path, car)
    x, y, yaw, speed, dt = 0.0, 1.0, 0.3, 0.0, 0.05
    found: dict[str, list[float]] = {key: [] for key in ("t", "x", "y", "speed", "error")}
    while True:
        step = driver.step(x, y, yaw, speed, dt)
        t = dt * len(found["t"])
        for key, value in zip(found, (t, x, y, speed, step.cross_track_error), strict=True):
            found[key].append(value)
        if len(found["t"]) % 100 == 1:
            said = f"{t:4.1f} s: {speed:5.2f} m/s, {step.distance_to_stop:6.2f} m to the stop"
            assert printed[len(found["t"]) // 100].startswith(said), said
        if step.hold:
            return found
        turn = math.tan(step.steer) / car.wheelbase
        course = yaw + math.atan(-car.rear_axle * turn)
        x, y = x + speed * math.cos(course) * dt, y + speed * math.sin(course) * dt
        yaw, speed = yaw + speed * turn * dt, max(speed + step.acceleration * dt, 0.0)


def program_figure(found: dict[str, list[float]], theme: Theme) -> Figure:
    """Draw the way in the colours of the speed, and both over time."""
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    way, fast, off = figure.subplots(3, 1, height_ratios=(1.2, 1.0, 1.0))
    course = np.arange(200.0)
    style: dict[str, Any] = {"color": theme.path, "linewidth": 8, "solid_capstyle": "butt"}
    way.plot(course, 8.0 * np.sin(course / 25.0), label="the path", **style)
    dots = way.scatter(found["x"], found["y"], c=found["speed"], s=9, cmap="viridis", zorder=3)
    figure.colorbar(dots, ax=way, label="speed [m/s]")
    way.plot(found["x"][-1], found["y"][-1], "s", color=theme.text, label="it stands")
    way.set_aspect("equal", adjustable="datalim")
    way.set(xlabel="x [m]", ylabel="y [m]")
    way.set_title("From a metre beside the path to a stand at its end", fontsize=11)
    way.legend(loc="lower left", ncols=2, fontsize=8.5)
    line: dict[str, Any] = {"color": theme.laws["pop"], "linewidth": 1.5}
    fast.plot(found["t"], found["speed"], **line)
    fast.axhline(10.0, color=theme.faint, linewidth=1.0, linestyle="--")
    fast.text(
        found["t"][-1], 9.6, "max_speed", ha="right", va="top", color=theme.faint, fontsize=8.5
    )
    fast.set(ylabel="speed [m/s]", xlim=(0.0, found["t"][-1]), ylim=(0.0, None))
    off.plot(found["t"], found["error"], **line)
    off.axhline(0.0, color=theme.path, linewidth=0.8)
    off.set(xlabel="time [s]", ylabel="left of the path [m]", xlim=(0.0, found["t"][-1]))
    return figure


def compared() -> dict[str, Any]:
    """Drive what examples/compare_controllers.py drives: the errors along the path, by name."""
    from examples.compare_controllers import CONTROLLERS as KINDS
    from examples.compare_controllers import DRIVEN, GIVEN, NOISE, PATH

    at = np.linspace(0.0, PATH.length - 2.0, 500)
    found = {}
    for kind in KINDS:
        start = sim.default_start(PATH, 0.5, GIVEN)
        options: dict[str, Any] = {"start": start, "speed": 8.0, "noise": NOISE}
        errors = []
        for seed in range(8):
            pedals = popsteer.SpeedPid()
            run = sim.run(kind(PATH, GIVEN), DRIVEN, longitudinal=pedals, seed=seed, **options)
            path, points = PATH, zip(run.records["x"], run.records["y"], strict=True)
            placed = [path.project(*each) for each in points]
            s, off = zip(
                *((each.arc_length, each.cross_track_error) for each in placed), strict=True
            )
            errors.append(np.interp(at, s, off))
        found[controllers.name_of(kind)] = at, np.array(errors)
    return found


def compared_figure(found: dict[str, Any], theme: Theme) -> Figure:
    """Draw the middle and the range of the errors of each controller."""
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    panel = figure.subplots()
    styles, colours = theme.styles(found), theme.colours(found)
    for name, (at, errors) in found.items():
        low, middle, high = np.quantile(errors, (0.0, 0.5, 1.0), axis=0)
        panel.fill_between(at, low, high, color=colours[name], alpha=0.2, linewidth=0.0)
        style: dict[str, Any] = {"color": colours[name], "linestyle": styles[name]}
        panel.plot(at, middle, label=title_of(name), linewidth=1.6, **style)
    panel.axhline(0.0, color=theme.path, linewidth=0.8)
    panel.set(xlabel="along the path [m]", ylabel="rear axle left of the path [m]")
    panel.set_xlim(0.0, at[-1])
    title = "compare_controllers.py: a car that is not quite as described, in noise"
    panel.set_title(title, fontsize=11)
    figure.legend(
        loc="outside lower center", ncols=4, title="middle of eight runs, and all of them"
    )
    return figure


def mended() -> list[tuple[str, Any, popsteer.Path]]:
    """Read a recorded and a coarse file: a title, the waypoints of the file, and the path."""
    s = np.arange(12.0)
    recorded = np.column_stack((s, 1.6 * np.sin(s / 2.2)))
    recorded = np.insert(recorded, 9, recorded[8] + (0.002, 0.001), axis=0)  # twice
    recorded[[3, 4]] = recorded[[4, 3]]
    turn = np.linspace(0.0, np.pi, 8)
    hairpin = np.column_stack((12.0 + 5.0 * np.sin(turn), 5.0 - 5.0 * np.cos(turn)))
    ends = np.array([(5.0, 0.0), (8.5, 0.0)])
    coarse = np.vstack((ends, hairpin, np.add(ends[::-1], (0.0, 10.0))))
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, xy in (("recorded.csv", recorded), ("coarse.csv", coarse)):
            file = Path(folder) / name
            np.savetxt(file, xy, "%.4f", ",", header="x,y", comments="")
            found.append((name, xy, popsteer.Path.from_csv(file)))
    return found


def mended_figure(found: list[tuple[str, Any, popsteer.Path]], theme: Theme) -> Figure:
    """Draw the waypoints in the order of the file, and the path that is driven."""
    figure = Figure(figsize=(7.2, 3.8), layout="constrained")
    panels = figure.subplots(1, 2)
    for panel, (name, xy, path) in zip(panels, found, strict=True):
        car = popsteer.Vehicle(wheelbase=0.5, max_steer=0.6)
        start = (*xy[0], math.atan2(*(xy[1] - xy[0])[::-1]))
        options: dict[str, Any] = {"start": start, "start_at": "rear", "constant_speed": 1.0}
        options["settings"] = sim.Settings(stop_distance=0.05)
        law = popsteer.PreviewPop(path, car)
        driven = sim.run(law, sim.KinematicBicycle(car), **options).records
        wide: dict[str, Any] = {"color": theme.path, "linewidth": 7}
        panel.plot(driven["x"], driven["y"], label="the way that preview POP drives", **wide)
        style: dict[str, Any] = {"color": theme.laws["pop"], "markersize": 4, "linewidth": 0.9}
        panel.plot(*xy.T, "o--", label="the file's waypoints, in its order", **style)
        ahead = np.gradient(xy, axis=0) / np.hypot(*np.gradient(xy, axis=0).T)[:, None]
        for k, (each, (dx, dy)) in enumerate(zip(xy, ahead, strict=True)):
            side = 9.0 if k % 2 else -9.0
            beside: dict[str, Any] = {"xytext": (-side * dy, side * dx), "ha": "center"}
            beside |= {"va": "center", "textcoords": "offset points", "fontsize": 7.5}
            panel.annotate(str(k), each, **beside)
        panel.set_aspect("equal", adjustable="datalim")
        panel.set(xlabel="x [m]")
        said = (
            str(path.source).partition("columns 1, 2), ")[2] or str(path.source).partition("; ")[2]
        )
        panel.set_title(f"{name}\n{fill(said, 44)}", fontsize=9.0, fontweight="normal")
    panels[0].set_ylabel("y [m]")
    handles = panels[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def main(wanted: list[str]) -> None:
    """Draw those that are wanted, by default all."""
    figures: dict[str, Any] = {
        "driver": lambda: partial(driver_figure, faults()),
        "carla": lambda: partial(carla_figure, carla()),
        "gymnasium": lambda: partial(gymnasium_figure, gymnasium()),
        "c": lambda: partial(program_figure, program()),
        "examples": lambda: partial(compared_figure, compared()),
        "files": lambda: partial(mended_figure, mended()),
    }
    write_figures({name: made() for name, made in figures.items() if not wanted or name in wanted})


if __name__ == "__main__":
    main(sys.argv[1:])
