"""``popsteer replay``: what the controllers would have done on a recorded drive."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Annotated, Any

import typer

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.lab.replay.runs import Replay
from popsteer.params_file import load_all

_DEFAULT = "stanley,pop,preview-pop"

HELP = """\
Let controllers watch a recorded drive, and tell what they would have commanded.

At each row of LOG each controller is given the pose, the speed and the angle that the driver
applied, and answers what it would command now. It follows the waypoints or the track, or else the
trajectory of its own tracked point in the log. The table has the angles beside the driver's, errors
and statuses; --out writes it, a row for each row of the log, and a figure.

\b
Examples:
  popsteer replay drive.mcap --vehicle car.toml
  popsteer replay drive.csv --vehicle car.toml --controllers pop,pid
  popsteer replay drive.csv --vehicle car.toml --waypoints course.csv
"""


def replay(
    *,
    log: options.Log,
    vehicle: Annotated[
        str | None,
        optional("NAME|FILE", "What the controllers know: a vehicle *.toml. By default paper."),
    ] = None,
    set_vehicle: options.SetVehicle = None,
    controllers: Annotated[
        str | None, optional("NAMES", f"By default {_DEFAULT}, or that of --params.")
    ] = None,
    params: options.Params = None,
    preset: options.Preset = "default",
    set_: options.Set = None,
    no_adapt: options.NoAdapt = False,
    waypoints: options.Waypoints = None,
    track: options.Track = None,
    closed: options.Closed = False,
    path_columns: Annotated[str | None, optional("NAMES", "As --columns, of --waypoints.")] = None,
    origin: options.Origin = None,
    columns: options.Columns = None,
    topic: options.Topic = None,
    unit: options.Unit = None,
    out: options.Out = None,
    report: options.Report = None,
    context: typer.Context,
) -> None:
    """Let controllers watch a recorded drive."""
    from popsteer.lab.replay import caption, replay_table
    from popsteer.lab.replay import run as replayed
    from popsteer.lab.replay.table import FILES, NOTE, statuses

    given = inputs.believed(vehicle or "paper", set_vehicle)
    called = inputs.plant_label(vehicle or "paper") + (" with changes" if set_vehicle else "")
    called += "; no --vehicle says what drove" if vehicle is None else ""
    names = ",".join(load_all(params)) if controllers is None and params else controllers
    who, known = inputs.names("--controllers", names or _DEFAULT), inputs.OWN_CONTROLLERS
    how: Any = {"no_adapt": no_adapt, "params": params, "known": known}
    tuning = inputs.tuned(who, preset, set_, **how)
    chosen = tuning.params
    course = None
    if waypoints is not None or track is not None or closed or path_columns:
        course = inputs.course(waypoints, track, closed=closed, columns=path_columns, origin=origin)
    outputs.check_folder(out, FILES, report)
    with Progress() as progress:
        drive = inputs.log(log, columns, topic, unit, origin, progress)
        found = replayed(
            drive,
            chosen,
            given,
            path=None if course is None else course.path,
            course="the log's own trajectory" if course is None else course.name,
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            progress=progress.update,
        )
        found = replace(found, called=called)
        files = {} if out is None else _files(found, progress)
    nothing = "--out DIR writes a row for each row of the log, the table, and a figure."
    said = outputs.write(files, out, nothing)
    line = outputs.command_line(context)
    made_by = lab.report.Origin(line, chosen, tuning.adapt, monitor=tuning.monitor)
    driven = [(drive.t, drive.speed, drive.steer)]
    hangs = inputs.defaults_note(vehicle, set_vehicle, driven, stops=False)
    below = (*statuses(found), *drive.remarks, *hangs, NOTE)
    read = [drive.source, None if course is None else course.path.source]
    shown = caption(found), [replay_table(found)], below, said, report, read
    outputs.show(*shown, lambda _: lab.report.of_replay(found, made_by))


def _files(found: Replay, progress: Progress) -> dict[str, bytes]:
    from popsteer.lab.common.draw import files_of
    from popsteer.lab.replay import replay_csv, summary_csv
    from popsteer.lab.replay.figure import replay_figure

    return {
        **files_of({"replay": partial(replay_figure, found)}, progress.update),
        "replay.csv": replay_csv(found).encode(),
        "summary.csv": summary_csv(found).encode(),
    }
