"""``popsteer matrix``: controllers × plants × tracks."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.controllers import names as own_names
from popsteer.errors import ConfigError
from popsteer.files import write_bytes_atomic
from popsteer.lab.common.names import differences
from popsteer.lab.compare.runs import DEFAULT_CONTROLLERS
from popsteer.lab.suite.conditions import CONDITIONS
from popsteer.lab.suite.scenarios import SCENARIOS
from popsteer.ranges import check_known
from popsteer.sim import Settings, vehicle_of

_CONTROLLERS = ",".join(DEFAULT_CONTROLLERS)

HELP = """\
Drive several controllers on several plants along several tracks, and time a step of each.

The table has the errors, the median time of a step, and whether the run reached the end; a run that
did not says why. With --out the table is also written as matrix.csv and matrix.md, all metrics as
matrix.json, and a figure shows the error over the time of a step.

With --suite it drives a suite instead: scenarios such as a double lane change, a hairpin or a
parking bay, each as told and under conditions such as a dead time, noise, lost poses, play or a
slope. The controllers have their defaults, and what --params and --set say. --controllers,
--plants, --scenarios and --conditions choose; a run is the same whatever else is driven.

\b
Examples:
  popsteer matrix
  popsteer matrix --controllers pop,mpc --plants carla-identified,commonroad-mb-2
  popsteer matrix --tracks slalom --start-offset 0 --constant-speed 10
  popsteer matrix --plants car.toml,loaded-car.toml --vehicle car.toml
  popsteer matrix --tracks racetrack,slalom --waypoints waypoints.csv --out out
  popsteer matrix --tracks slalom,circle --report matrix.html
  popsteer matrix --suite standard-2 --controllers preview-pop,mine.py:Mine --out out
  popsteer matrix --suite standard-2 --scenarios slalom --conditions noise
"""

_WITH_SUITE = ("suite", "scenarios", "conditions", "controllers", "params", "set_", "plants", "out")


def matrix(
    *,
    controllers: options.Controllers = _CONTROLLERS,
    preset: options.Preset = "default",
    params: options.Params = None,
    set_: options.Set = None,
    waypoints: Annotated[
        list[Path] | None,
        optional("FILE", "Waypoints to follow as well, as compare's --waypoints. Can be repeated."),
    ] = None,
    tracks: options.Tracks = None,
    closed: options.Closed = False,
    columns: options.Columns = None,
    origin: options.Origin = None,
    plants: options.Plants = "carla-identified,kinematic-bicycle",
    vehicle: options.Vehicle = None,
    set_vehicle: options.SetVehicle = None,
    no_adapt: options.NoAdapt = False,
    start_offset: options.StartOffset = None,
    speed: options.Speed = None,
    constant_speed: options.ConstantSpeed = None,
    longitudinal: options.Longitudinal = None,
    set_longitudinal: options.SetLongitudinal = None,
    dt: options.Dt = options.DEFAULT_DT,
    suite: Annotated[
        str | None, optional("NAME", f"The suite to drive: {', '.join(lab.suite.names())}.")
    ] = None,
    scenarios: Annotated[
        str | None, optional("NAMES", f"Some of its scenarios: {', '.join(SCENARIOS)}.")
    ] = None,
    conditions: Annotated[
        str | None, optional("NAMES", f"Some of its conditions: {', '.join(CONDITIONS)}.")
    ] = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Drive controllers on plants along tracks."""
    if suite is not None:
        options.check_alone(context, "--suite", _WITH_SUITE)
        _suite(context, suite, out)
        return
    for option, chosen in (("--scenarios", scenarios), ("--conditions", conditions)):
        if chosen is not None:
            raise ConfigError(option, chosen, "given with --suite")
    names = inputs.names("--controllers", controllers)
    courses = inputs.courses(waypoints, tracks, closed=closed, columns=columns, origin=origin)
    outputs.check_folder(out, lab.matrix.table.FILES, report)
    with Progress() as progress:
        movers = {name: inputs.plant(name) for name in inputs.names("--plants", plants)}
        given = {
            name: inputs.believed(vehicle, set_vehicle, vehicle_of(mover))
            for name, mover in movers.items()
        }
        tuning = inputs.tuned(names, preset, set_, no_adapt=no_adapt, params=params)
        found = lab.matrix.run(
            {course.name: course.path for course in courses},
            tuning.params,
            movers,
            vehicle=given,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            preset=tuning.called,
            start_offset=start_offset,
            speed=speed,
            constant_speed=constant_speed,
            longitudinal=inputs.longitudinal(
                longitudinal, set_longitudinal, constant_speed, courses, movers.values()
            ),
            settings=Settings(dt=dt),
            progress=progress.update,
        )
        content = {} if out is None else lab.matrix.table.matrix_files(found)
        made_by = lab.report.Origin(
            outputs.command_line(context),
            tuning.params,
            tuning.adapt,
            movers,
            tuning.monitor,
        )
        page = b"" if report is None else lab.report.of_matrix(found, made_by)
    said = outputs.write(content, out, "--out DIR writes the table, all metrics and a figure.")
    if report is not None:
        write_bytes_atomic(report, page)
    notes = lab.matrix.table.matrix_notes(found)
    for name, believed in given.items():
        if otherwise := differences(believed, vehicle_of(movers[name])):
            notes.append(f"{name}{otherwise}")
    tables = lab.matrix.table.matrix_tables(found, outputs.console().width)
    read = [course.path.source for course in courses]
    outputs.show(lab.matrix.table.matrix_caption(found), tables, notes, said, report, read)
    outputs.say_raised(run for each in found.comparisons for run in each.runs.values())


def _suite(context: typer.Context, name: str, out: Path | None) -> None:
    """Drive a suite: all popsteer's own controllers on its own plants by default."""
    check_known("suite", name, lab.suite.names())
    given = context.params
    chosen, movers = list(own_names()), list(lab.suite.runs.PLANTS)
    if options.is_given(context, "controllers"):
        chosen = inputs.names("--controllers", given["controllers"])
    if options.is_given(context, "plants"):
        movers = inputs.names("--plants", given["plants"])
    outputs.check_folder(out, lab.suite.table.FILES)
    tuning = inputs.tuned(chosen, "default", given["set_"], no_adapt=False, params=given["params"])
    scenarios, conditions = (
        None if given[key] is None else [part.strip() for part in given[key].split(",")]
        for key in ("scenarios", "conditions")
    )
    own = lab.suite.runs.SUITE_CAR
    with Progress() as progress:
        found = lab.suite.run(
            tuning.params,
            {each: lab.suite.suite_car() if each == own else inputs.plant(each) for each in movers},
            scenarios=scenarios,
            conditions=conditions,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            progress=progress.update,
        )
        content = {} if out is None else lab.suite.table.suite_files(found)
    said = outputs.write(content, out, "--out DIR writes the table, all cells and a figure.")
    table = lab.suite.table
    outputs.show(table.suite_caption(found), table.suite_tables(found), said=said)
    for trace in found.tracebacks:
        print(trace, file=sys.stderr)
