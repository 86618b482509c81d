"""The first line of a page: who finished, and who reported a fault."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.lab.common.names import title_of
from popsteer.lab.report.markup import escape

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.lab.compare import Comparison


def verdict(comparisons: Sequence[Comparison]) -> str:
    """Say as HTML, in a badge, how many runs finished without a fault, and what the others did."""
    runs = [(each, name, run) for each in comparisons for name, run in each.runs.items()]
    wrong = []
    for each, name, run in runs:
        said = [] if run.metrics.finished else [f"did not finish: {run.ending}"]
        if run.metrics.faults:
            said.append(f"fault: {', '.join(run.metrics.faults.names)}")
        if said:
            where = ", ".join(part for part in (each.plant, each.track) if part)
            on = f" on {where}" if len(comparisons) > 1 else ""
            wrong.append(f"{title_of(name)}{on} ({'; '.join(said)})")
    good = len(runs) - len(wrong)
    head = f"{good} of {len(runs)} {'run' if len(runs) == 1 else 'runs'} finished without a fault"
    rest = f" <span>{escape('; '.join(wrong))}</span>" if wrong else ""
    return f'<p class="verdict {"bad" if wrong else "good"}"><strong>{head}</strong>{rest}</p>'
