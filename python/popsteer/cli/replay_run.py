"""``popsteer compare --replay-run``: one run of a sweep again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from popsteer import lab
from popsteer.cli import outputs
from popsteer.cli.progress import Progress
from popsteer.cli.report import check, command_line
from popsteer.errors import ConfigError
from popsteer.files import check_folder

if TYPE_CHECKING:
    import typer

_WITH_IT = ("replay_run", "out", "report")


def replay_run(text: str, out: Path | None, report: Path | None, context: typer.Context) -> None:
    """Drive one run of a sweep, given as ``FILE:RUN``, and compare it with its row.

    Raises ConfigError where other options would change the run, or there is no such run.
    """
    for name, value in context.params.items():
        source = context.get_parameter_source(name)
        if name not in _WITH_IT and source is not None and source.name != "DEFAULT":
            option = f"--{name.rstrip('_').replace('_', '-')}"
            raise ConfigError(option, value, "left out where --replay-run is given")
    file, _, number = text.rpartition(":")
    if not file or not number.isdecimal():
        raise ConfigError("--replay-run", text, "written FILE:RUN")
    run = int(number)
    job, row = lab.sweep.rows.read_row(Path(file), run)
    if out is not None:
        check_folder(out, lab.compare.files.file_names([job.controller]))
    check(report)
    with Progress() as progress:
        found = lab.sweep.repeat(
            job, run, progress=lambda share: progress.update(job.controller, share)
        )
        drawn = ", ".join(f"{name} {value:.6g}" for name, value in job.drawn(run).items())
        comparison = lab.compare.Comparison(
            {job.controller: found},
            preset=f"run {run} of {Path(file).name}",
            plant=job.label,
            track=job.course,
        )
        varied = job.made(run).plant
        origin = lab.report.Origin(
            command_line(context), {job.controller: job.params}, job.adapt, {job.label: varied}
        )
        outputs.deliver(comparison, out, progress, report, origin)
    figures = vars(found.metrics)
    same = all(row[name] == figures[name] or row[name] != row[name] for name in figures)
    print(f"Drawn: {drawn or 'nothing'}.")
    said = "to the last bit what its row says" if same else "NOT what its row says"
    print(f"Run {run} of {file} is {said}; it {'succeeded' if row['success'] else 'failed'}.")
