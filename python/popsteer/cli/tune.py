"""``popsteer tune``: parameters of a controller for a vehicle."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.assignments import pairs
from popsteer.cli.options import optional, valued
from popsteer.cli.outputs import Progress, kept_in
from popsteer.files import write_files_atomic
from popsteer.lab.common.varied import START, distribution
from popsteer.params_file import as_toml
from popsteer.sim import Settings, vehicle_of

HELP = """\
Search for the parameters of a controller with which a vehicle stays closest to its tracks, while
the wheels move hardly more than before.

Each trial drives all tracks with the vehicle and with cars that differ. The tuning with the least
error within --effort-limit is written to --out, which --params of other commands reads; the table
judges it besides on tracks and cars that the search has not seen. The same command goes on with the
trials kept beside --out or in --storage, which several processes can share.

\b
Examples:
  popsteer tune --vehicle car.toml --waypoints course.csv --out tuned.toml
  popsteer tune --controller pop --search "min_lookahead=uniform(3,12)"
  popsteer tune --vary "steer_lag=uniform(0.05,0.2)" --seconds 60
"""


def tune(
    *,
    controller: options.Controller = None,
    params: options.Params = None,
    preset: options.Preset = "default",
    set_: options.Set = None,
    no_adapt: options.NoAdapt = False,
    search: Annotated[
        list[str] | None, optional("NAME=DISTRIBUTION", "Try uniform(LOW,HIGH) or loguniform(...).")
    ] = None,
    waypoints: options.SeveralWaypoints = None,
    tracks: options.Tracks = None,
    closed: options.Closed = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    plant: options.OwnPlant = None,
    set_plant: options.SetPlant = None,
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    vary: options.Vary = None,
    distributions: options.Distributions = None,
    cars: Annotated[int, valued("N", "How many cars that differ.")] = 7,
    seed: options.Seed = 0,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    trials: Annotated[
        int | None, optional("N", "Trials in the end; else 100, or --seconds.")
    ] = None,
    seconds: Annotated[float | None, optional("S", "How long to search, at most.")] = None,
    effort_limit: Annotated[float, valued("FACTOR", "Times the effort before.")] = 1.1,
    storage: Annotated[
        str | None, optional("URL|FILE", "Optuna's storage of trials, or a journal.")
    ] = None,
    out: Annotated[
        Path | None, optional("FILE", "The tuning, *.toml; a figure is drawn beside.")
    ] = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Search for the parameters of a controller for a vehicle."""
    moved, given, _ = inputs.varied(plant, set_plant, vehicle, set_vehicle)
    name, tuning = inputs.tuning(controller, params, preset, set_, no_adapt=no_adapt)
    base = tuning.params[name]
    wanted = lab.tune.usual_search(name, base, given)
    if search:
        named = list(pairs("--search", search, "NAME=DISTRIBUTION"))
        wanted = {field: distribution(field, text) for field, text in named}
    varies = inputs.distributions(vary, distributions, moved)
    if not vary and distributions is None:
        # Any tuning steers after noise, which would hide the differences between tunings.
        telling = {*vehicle_of(moved).as_dict(), *START}
        varies = {k: v for k, v in varies.items() if k in telling}
    courses = inputs.courses(waypoints, tracks, closed=closed, columns=columns, origin=origin)
    pedals = inputs.longitudinal(longitudinal, set_longitudinal, constant_speed, [moved])
    paths = {each.name: each.path for each in courses}
    problem = lab.tune.Problem(
        paths,
        name,
        base,
        wanted,
        moved,
        varies,
        cars,
        seed,
        vehicle=given,
        adapt=tuning.adapt,
        monitor=tuning.monitor,
        constant_speed=constant_speed,
        longitudinal=pedals,
        settings=Settings(dt=dt),
    )
    joining = problem.joining(problem.paths.values())
    problem = replace(problem, settings=joining, joined=True)
    pictures = outputs.check_file(out, report, ".toml")
    kept = out.with_suffix(".journal") if out is not None and storage is None else storage
    with kept_in(kept), Progress() as progress:
        tuned = lab.tune.run(
            problem,
            kept,
            trials=trials,
            seconds=seconds,
            effort_limit=effort_limit,
            progress=progress.update,
        )
        judged = lab.tune.report.judge(tuned, progress.update)
        if out is not None:
            from popsteer.lab.tune.figure import tune_figure

            drawn = outputs.draw_figures(out, partial(tune_figure, tuned), progress)
            write_files_atomic({**drawn, out: as_toml(tuned.params, name).encode()})
    judging = lab.tune.report
    nothing = "--out FILE writes the tuning, and a figure of the trials."
    said = outputs.written(out, pictures, nothing)
    if out is not None:
        said += f"\nThe trials are in {kept}."
    shown = judging.caption(tuned), judging.tables(judged), judging.notes(tuned, judged), said
    read = [course.path.source for course in courses]
    made_by = lab.report.Origin(outputs.command_line(context))
    outputs.show(*shown, report, read, lambda _: lab.report.of_tuning(tuned, judged, made_by))
