"""``popsteer plan``: the fastest speeds along a path."""

from __future__ import annotations

from functools import partial
from pathlib import Path as FilePath
from typing import Annotated

import numpy as np
import typer

from popsteer import lab, planning
from popsteer._core import Path
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import assigned
from popsteer.cli.options import flag, optional
from popsteer.cli.outputs import Progress
from popsteer.errors import ConfigError
from popsteer.files import write_files_atomic
from popsteer.planning import SpeedLimits
from popsteer.sim.geometry import check_length
from popsteer.tables import Waypoints, make_path, read_waypoints

HELP = """\
Find the fastest speeds along a path that a vehicle's limits allow.

They stay within top speed, speed limits, lateral, driving and braking acceleration, friction
ellipse, and the rate of the wheels, which have to turn in time for a bend. The table gives, for
each limit, the share of the path on which it limits the speed. popsteer params limits lists those
that --set sets. FILE of --out has x [m], y [m], speed [m/s], as --waypoints elsewhere reads it.

\b
Examples:
  popsteer plan waypoints.csv --vehicle car.toml --out course.csv
  popsteer plan waypoints.csv --smooth 0.1 --out course.csv       recorded
  popsteer plan course.csv --set max_lateral_acceleration=3 --set max_jerk=2
  popsteer plan lap.csv --closed --speed-limit 100:250:8 --driving 0:3,20:1
"""


def plan(
    *,
    waypoints: Annotated[
        FilePath,
        typer.Argument(
            metavar="WAYPOINTS",
            help="Points x, y, with or without speeds: a table, GPX or GeoJSON.",
        ),
    ],
    closed: Annotated[bool, flag("--closed", "The last waypoint joins the first.")] = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    vehicle: Annotated[
        str | None, optional("NAME|FILE", "The vehicle: a file *.toml or a name.")
    ] = None,
    set_vehicle: options.SetVehicle = None,
    set_: Annotated[list[str] | None, optional("NAME=VALUE", "Set a limit.", "--set")] = None,
    driving: Annotated[
        str | None, optional("V:A,...", "Largest driving acceleration [m/s²] over speed.")
    ] = None,
    braking: Annotated[
        str | None, optional("V:A,...", "Largest deceleration [m/s²] over speed.")
    ] = None,
    speed_limit: Annotated[
        list[str] | None,
        optional(
            "FROM:TO:SPEED", "Speed limit [m/s] between two distances [m], over a lap's seam too."
        ),
    ] = None,
    keep_speeds: Annotated[
        bool, flag("--keep-speeds", "The speeds of WAYPOINTS are limits too.")
    ] = False,
    smooth: Annotated[
        float | None, optional("METRES", "First smooth the waypoints, by at most so much.")
    ] = None,
    out: Annotated[
        FilePath | None, optional("FILE", "File for the course, CSV; a figure is drawn beside it.")
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Find the fastest speeds along a path."""
    from popsteer.lab.plan import plan_caption, plan_table

    car = inputs.believed(vehicle, set_vehicle)
    limits = assigned(SpeedLimits(), set_, "the limits")
    if driving is not None:
        limits = limits.replace(max_acceleration=_points("--driving", driving))
    if braking is not None:
        limits = limits.replace(max_deceleration=_points("--braking", braking))
    pictures = outputs.check_file(out, report)
    if out in pictures or out == waypoints:
        raise ConfigError("--out", str(out), "another file than what it is made of or drawn into")
    if smooth is not None and keep_speeds:
        raise ConfigError("--keep-speeds", keep_speeds, "left out where --smooth is given")
    with Progress() as progress:
        progress.update("read", 0.0)
        found = read_waypoints(waypoints, columns=columns, origin=inputs.place(origin))
        if smooth is None:
            path = make_path(Path, found, closed=closed)
        else:
            progress.update("smooth", 0.1)
            path = planning.smooth(_recorded(found, closed=closed), smooth, closed=closed)
        check_length(path, car, str(waypoints))
        bounds = _bounds(path, speed_limit or [], keep_speeds=keep_speeds)
        progress.update("plan", 0.3)
        profile = planning.speed_profile(path, limits, car, speed_limits=bounds)
        if out is not None:
            from popsteer.lab.plan.figures import plan_figure

            drawn = outputs.draw_figures(out, partial(plan_figure, profile), progress)
            write_files_atomic({out: (found.origin_line() + profile.as_csv()).encode(), **drawn})
    below = []
    if profile.too_sharp.size:
        below.append(
            f"{profile.too_sharp.size} waypoints, the first of them {profile.too_sharp[0]}, bend"
            " more sharply than the wheels turn (max_steer)."
        )
    said = outputs.written(out, pictures, "--out FILE writes the course, and a figure of it.")
    name, read = waypoints.name, [found.source()]
    shown = plan_caption(profile, name), [plan_table(profile)], below, said, report, read
    made_by = lab.report.Origin(outputs.command_line(context))
    outputs.show(*shown, lambda _: lab.report.of_plan(profile, name, made_by))


def _recorded(found: Waypoints, *, closed: bool) -> Path | np.ndarray:
    """Give what is smoothed of a recording, whose waypoints may coincide."""
    if found.speed is None or not (found.speed < 0.0).any():
        return found.xy
    return Path(found.xy, speed=found.speed, closed=closed)


def _points(option: str, text: str) -> list[tuple[float, float]]:
    try:
        pairs = [part.split(":") for part in text.split(",")]
        return [(float(speed), float(value)) for speed, value in pairs]
    except ValueError:
        raise ConfigError(option, text, "pairs SPEED:ACCELERATION, separated by commas") from None


def _bounds(path: Path, texts: list[str], *, keep_speeds: bool) -> np.ndarray | None:
    """Give the speed limit at each waypoint, where there is one."""
    if not texts and not keep_speeds:
        return None
    bounds = np.full(len(path), 1e4)
    if keep_speeds:
        if path.speed is None:
            raise ConfigError("--keep-speeds", keep_speeds, "given with waypoints that have speeds")
        bounds = np.abs(path.speed)
        if not path.closed:  # at its ends --set start_speed and end_speed say how fast
            bounds[[0, -1]] = np.where(bounds[[0, -1]] > 0.0, bounds[[0, -1]], 1e4)
    s = np.concatenate((path.s, path.s + path.length)) if path.closed else path.s
    for text in texts:
        first, last, speed = _limit(path, text)
        # With the waypoints on both sides: between them the speed is between theirs.
        begin = int(np.searchsorted(s, first, side="right")) - 1
        inside = np.arange(begin, int(np.searchsorted(s, last)) + 1)
        inside = inside % len(path) if path.closed else inside[inside < len(path)]
        bounds[inside] = np.minimum(bounds[inside], speed)
    return bounds


def _limit(path: Path, text: str) -> tuple[float, float, float]:
    """Read a limit: from where to where along the path [m], over its seam if closed, and [m/s]."""
    try:
        first, last, speed = (float(part) for part in text.split(":"))
    except ValueError:
        raise ConfigError("--speed-limit", text, "written FROM:TO:SPEED") from None
    if path.closed and last < first:
        last += path.length  # across the seam of a lap
    if not 0.0 <= first < last:
        raise ConfigError("--speed-limit", text, "from a distance to one farther on")
    if not 1e-3 <= speed <= 1e4:
        raise ConfigError("--speed-limit", text, "a speed in [0.001, 10000]")
    if first >= path.length:
        raise ConfigError("--speed-limit", text, f"within the path, {path.length:.1f} m long")
    return first, last, speed
