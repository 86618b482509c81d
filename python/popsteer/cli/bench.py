"""``popsteer bench``: how long a control step takes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["HELP", "bench"]

HELP = """\
Measure how long a control step of POP takes.

The whole step, as the paper counts it: window, lookahead, prediction and choice, called from
Python; beside it the pure-Python reference, an empty call of the same signature, and the paper's
3.239 ms. A debug build is refused.

In a checkout, with the extra `yardsticks` installed, also the reference's step compiled by numba
and a linear model-predictive controller on osqp, 20 steps of 50 ms.

\b
Examples:
  popsteer bench
  popsteer bench --json latency.json
"""


def bench(
    json: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the figures as JSON.", show_default=False),
    ] = None,
    yardsticks: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Where the files of the yardsticks are [default: benches/yardsticks, if there].",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Measure how long a control step takes."""
    from rich.console import Console

    from popsteer.files import check_files
    from popsteer.lab.bench import latency

    if json is not None:
        check_files([json])
    latency.run(json, Console(), yardsticks_folder=yardsticks)
