"""The report of the benchmark as a table for the terminal; needs rich."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.lab.bench.calls import EMPTY_CALL, LABELS, PAPER_NS, POP_STEP

if TYPE_CHECKING:
    from rich.table import Table

    from popsteer.lab.bench.report import LatencyReport


def table(report: LatencyReport) -> Table:
    """Lay out a report; needs rich.

    There is a row for each call: percentiles, net p50, both over the empty call's, and p50 over
    POP's.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    layout = Table(
        title="Latency of a control step, called from Python",
        caption=Text(_caption(report)),  # no markup: an extra's name stands in brackets
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        padding=0,
    )
    layout.add_column("call", no_wrap=True)
    for heading in ("p50", "p99", "p99.9", "max", "net p50", "/empty", "net /empty", "/POP"):
        layout.add_column(heading, justify="right", no_wrap=True)
    step, empty = report.row(POP_STEP), report.row(EMPTY_CALL)
    for name, row in report.results.items():
        if row is None:
            continue
        net = net_ratio = "-"
        if row.net_p50 is not None and empty.net_p50 is not None:
            net, net_ratio = duration(row.net_p50), digits(row.net_p50 / empty.net_p50)
        layout.add_row(
            LABELS.get(name, name),
            *(duration(value) for value in (row.p50, row.p99, row.p999, row.max)),
            net,
            digits(row.p50 / empty.p50),
            net_ratio,
            digits(row.p50 / step.p50),
        )
    return layout


def _caption(report: LatencyReport) -> str:
    """Say what is missing, what the columns hold, and what was driven on what."""
    missing = {name: why for name, why in report.absent.items() if not LABELS[name].startswith("-")}
    paper, net_paper = (
        digits(PAPER_NS / value) if value else "-"
        for value in (report.row(POP_STEP).p50, report.row(POP_STEP).net_p50)
    )
    clock = duration(report.timing["timer_floor_ns"])
    states, on = report.states, report.machine
    lines = [f"{LABELS[name]}: {why}" for name, why in missing.items()]
    lines += [
        f"p50 to max: single calls as read, one reading of the clock ({clock}) in each;",
        "net p50: of batches, without clock and loop.",
        f"The paper's 3.239 ms over POP's p50: {paper}; over its net p50: {net_paper}.",
        f"{states['count']} states of {states['source']}; {on['cpu']}, {on['python']}.",
    ]
    return "\n".join(lines)


def duration(nanoseconds: float) -> str:
    """Write a time with three digits or more."""
    for size, unit in ((1e9, "s"), (1e6, "ms"), (1e3, "µs")):
        if nanoseconds >= size:
            return f"{digits(nanoseconds / size)} {unit}"
    return f"{nanoseconds:.0f} ns"


def digits(value: float) -> str:
    """Write a number with no more than two places, and fewer the larger it is."""
    return f"{value:,.{2 if value < 10 else 1 if value < 100 else 0}f}"
