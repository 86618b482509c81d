"""The report of the benchmark: its ratios, its JSON, and how its figures are worded."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from benches.latency.calls import (
    EMPTY_CALL,
    MPC_STEP,
    NUMBA_STEP,
    PAPER_NS,
    PAPER_REFERENCE_STEP,
    PAPER_STEP,
    POP_STEP,
    REFERENCE_STEP,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from benches.latency.timing import Percentiles


def cells(row: Mapping[str, Any], step: Mapping[str, Any], empty: Mapping[str, Any]) -> list[str]:
    """Word the figures of a call beside those of POP's and an empty call."""
    net, of = row["net_p50"], empty["net_p50"]
    nets = ("-", "-") if net is None or of is None else (duration(net), digits(net / of))
    return [
        *(duration(row[name]) for name in ("p50", "p99", "p999", "max")),
        nets[0],
        digits(row["p50"] / empty["p50"]),
        nets[1],
        digits(row["p50"] / step["p50"]),
    ]


def duration(nanoseconds: float) -> str:
    """Write a time with three digits or more."""
    for size, unit in ((1e9, "s"), (1e6, "ms"), (1e3, "µs")):
        if nanoseconds >= size:
            return f"{digits(nanoseconds / size)} {unit}"
    return f"{nanoseconds:.0f} ns"


def digits(value: float) -> str:
    """Write a number with no more than two places, and fewer the larger it is."""
    return f"{value:,.{2 if value < 10 else 1 if value < 100 else 0}f}"


@dataclass(frozen=True)
class LatencyReport:
    """What one run has measured.

    `results` has the `Percentiles` [ns] of each call, such as ``pop_step_ns``; None for a yardstick
    that was not at hand, for which `absent` has the reason. `states` has ``source`` and ``count``
    of the states that were driven through, `machine` ``cpu``, ``cores``, ``python`` and
    ``platform``, `timing` ``calls`` timed one by one for each name, the ``batch`` size, and what
    the clock (``timer_floor_ns``) and the empty loop (``loop_ns``) take. `build_profile` is
    "release".
    """

    build_profile: str
    results: dict[str, Percentiles | None]
    absent: dict[str, str]
    states: dict[str, Any]
    machine: dict[str, str]
    timing: dict[str, Any]

    def row(self, name: str) -> Percentiles:
        """Give the figures of a call that is always timed."""
        row = self.results[name]
        if row is None:
            raise KeyError(name)
        return row

    @property
    def ratios(self) -> dict[str, float | None]:
        """What the step is compared with, from p50: the clock's own cost is in both sides.

        They are ``reference_over_step``, ``reference_over_step_of_paper`` (both with the paper's
        search), ``step_over_empty_call``, ``paper_over_step``, and ``numba_over_step`` and
        ``mpc_over_step``, None where those were not at hand.
        """
        return self._ratios("p50")

    @property
    def net_ratios(self) -> dict[str, float | None]:
        """The same from the net p50, without clock and loop: the strict ones."""
        return self._ratios("net_p50")

    def _ratios(self, figure: str) -> dict[str, float | None]:
        of = {name: getattr(row, figure, None) for name, row in self.results.items()}
        pairs: dict[str, tuple[float | None, float | None]] = {
            "reference_over_step": (of[REFERENCE_STEP], of[POP_STEP]),
            "reference_over_step_of_paper": (of[PAPER_REFERENCE_STEP], of[PAPER_STEP]),
            "step_over_empty_call": (of[POP_STEP], of[EMPTY_CALL]),
            "paper_over_step": (PAPER_NS, of[POP_STEP]),
            "numba_over_step": (of[NUMBA_STEP], of[POP_STEP]),
            "mpc_over_step": (of[MPC_STEP], of[POP_STEP]),
        }
        return {
            name: None if above is None or below is None else above / below
            for name, (above, below) in pairs.items()
        }


def to_json(report: LatencyReport) -> str:
    """Write a report as JSON, with a line feed at its end.

    It is an object with ``build_profile``, ``results``, ``ratios``, ``net_ratios``, ``absent``,
    ``states``, ``machine`` and ``timing``.
    """
    fields = asdict(report)
    ordered = {name: fields.pop(name) for name in ("build_profile", "results")}
    ordered |= {"ratios": report.ratios, "net_ratios": report.net_ratios, **fields}
    return json.dumps(ordered, indent=2, allow_nan=False) + "\n"
