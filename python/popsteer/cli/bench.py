"""``popsteer bench``: how long a control step takes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from popsteer import lab
from popsteer.cli import options, outputs
from popsteer.cli.options import optional

HELP = """\
Measure how long a control step takes when it is called from Python.

A step of POP is everything that the paper counts: window, lookahead, prediction and choice. The
other controllers are timed, too. For comparison, the same step in plain Python and an empty call
with the same arguments are timed, and the paper's 3.239 ms are listed. A debug build is refused.

In a checkout, with numba, osqp and daqp, three more are timed: POP's step compiled by numba, and
linear model-predictive controllers with 20 steps of 50 ms, on osqp and on daqp.

\b
Examples:
  popsteer bench
  popsteer bench --out out
"""


def bench(
    *,
    yardsticks: Annotated[
        Path | None,
        optional(
            "DIR",
            "Folder with the files of the yardsticks. The default is benches/yardsticks, if it"
            " exists.",
        ),
    ] = None,
    out: options.Out = None,
) -> None:
    """Measure how long a control step takes."""
    from rich.console import Console

    outputs.check_folder(out, ["latency.json"])
    file = None if out is None else out / "latency.json"
    lab.bench.run(file, Console(), yardsticks_folder=yardsticks)
    print("--out DIR writes latency.json." if file is None else f"Written to {file}")
