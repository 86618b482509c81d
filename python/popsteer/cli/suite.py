"""``popsteer suite``: controllers in scenarios, under conditions."""

from __future__ import annotations

import sys
from typing import Annotated

from popsteer import lab
from popsteer.cli import inputs, options, outputs
from popsteer.cli.options import optional
from popsteer.cli.outputs import Progress
from popsteer.lab.suite.runs import PLANTS, SUITE_CAR
from popsteer.lab.suite.scenarios import CONDITIONS, SCENARIOS

_CONTROLLERS, _PLANTS = ",".join(inputs.OWN_CONTROLLERS), ",".join(PLANTS)

HELP = f"""\
Drive the suite {lab.suite.names()[-1]}: controllers in scenarios, as told and under conditions.

A scenario is a path with a plan of speeds, a condition what differs from what the controllers are
told. A run is the same whatever else is driven. The controllers have their defaults, and what
--params and --set say. --out writes the table, all cells and a figure.

Scenarios: {", ".join(SCENARIOS)}.

Conditions: {", ".join(CONDITIONS)}.

\b
Examples:
  popsteer suite --controllers preview-pop,mine.py:Mine --out out
  popsteer suite --scenarios slalom --conditions "noise,dead time told"
  popsteer suite --controllers pop --set turn_time=1
"""


def suite(
    *,
    controllers: options.Controllers = _CONTROLLERS,
    params: options.Params = None,
    set_: options.Set = None,
    no_adapt: options.NoAdapt = False,
    plants: options.Plants = _PLANTS,
    scenarios: Annotated[
        str | None, optional("NAMES", "Some of the scenarios, separated by commas.")
    ] = None,
    conditions: Annotated[
        str | None, optional("NAMES", "Some of the conditions, separated by commas.")
    ] = None,
    out: options.Out = None,
) -> None:
    """Drive controllers in scenarios, under conditions."""
    names, movers = inputs.names("--controllers", controllers), inputs.names("--plants", plants)
    outputs.check_folder(out, lab.suite.table.FILES)
    tuning = inputs.tuned(names, "default", set_, no_adapt=no_adapt, params=params)
    shipped = {SUITE_CAR: lab.suite.suite_car()}
    with Progress() as progress:
        found = lab.suite.run(
            tuning.params,
            {each: shipped.get(each) or inputs.plant(each) for each in movers},
            scenarios=None if scenarios is None else inputs.names("--scenarios", scenarios),
            conditions=None if conditions is None else inputs.names("--conditions", conditions),
            adapt=tuning.adapt,
            monitor=tuning.monitor,
            progress=progress.update,
        )
        content = {} if out is None else lab.suite.table.suite_files(found)
    said = outputs.write(content, out, "--out DIR writes the table, all cells and a figure.")
    table = lab.suite.table
    shown = table.suite_caption(found), table.suite_tables(found), table.sentences(found)
    outputs.show(*shown, said=said)
    for trace in found.tracebacks:
        print(trace, file=sys.stderr)
