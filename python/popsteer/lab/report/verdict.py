"""The first line of a page: what came out, in a badge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer.lab.common.names import counted, title_of
from popsteer.lab.report.markup import escape
from popsteer.lab.sweep.summary import percent, success_rate
from popsteer.status import Status

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.identification import Identification
    from popsteer.lab.compare import Comparison
    from popsteer.lab.replay import Replay


def of_runs(comparisons: Sequence[Comparison]) -> str:
    """Say how many runs finished without a fault, and what the others did."""
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
    head = f"{len(runs) - len(wrong)} of {counted(len(runs), 'run')} finished without a fault"
    return _badge(head, wrong, good=not wrong)


def of_rows(rows: Sequence[dict[str, Any]]) -> str:
    """Say how many runs of a sweep succeeded, with confidence, and why the others did not."""
    good = sum(bool(row["success"]) for row in rows)
    share, low, high = (percent(each, len(rows)) for each in success_rate(good, len(rows)))
    stopped = sum(not row["finished"] for row in rows)
    faults = [Status(row["faults"]) for row in rows if row["faults"]]
    names = ", ".join(dict.fromkeys(name for each in faults for name in each.names))
    said = [f"95 % confidence: {low} to {high} %"]
    said += [f"{stopped} did not finish"] if stopped else []
    said += [f"{len(faults)} reported a fault: {names}"] if faults else []
    head = f"{good} of {counted(len(rows), 'run')} succeeded, {share} %"
    return _badge(head, said, good=good == len(rows))


def of_log(found: Identification) -> str:
    """Say whether the vehicle explains the log."""
    head, _, rest = found.verdict.partition(": ")
    return _badge(head, [rest], good=found.explains)


def of_shadows(found: Replay) -> str:
    """Say how many controllers would have driven the log without a fault."""
    wrong = [
        f"{title_of(each.name)} (fault in {100.0 * each.share('fault'):.1f} % of the rows)"
        for each in found.shadows.values()
        if each.share("fault") > 0.0
    ]
    count = len(found.shadows)
    head = f"{count - len(wrong)} of {counted(count, 'controller')}"
    return _badge(f"{head} reported no fault along the drive", wrong, good=not wrong)


def _badge(head: str, details: Sequence[str], *, good: bool) -> str:
    rest = f" <span>{escape('; '.join(details))}</span>" if details else ""
    kind = "good" if good else "bad"
    return f'<p class="verdict {kind}"><strong>{escape(head)}</strong>{rest}</p>'
