"""The report of the benchmark, its ratios and its JSON."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from popsteer.lab.bench.calls import (
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
    from popsteer.lab.common.timing import Percentiles


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
        return _ratios(
            {name: None if row is None else row.p50 for name, row in self.results.items()}
        )

    @property
    def net_ratios(self) -> dict[str, float | None]:
        """The same from the net p50, without clock and loop: the strict ones."""
        return _ratios(
            {name: None if row is None else row.net_p50 for name, row in self.results.items()}
        )


def _ratios(medians: dict[str, float | None]) -> dict[str, float | None]:
    step = medians[POP_STEP]

    def over(numerator: float | None, denominator: float | None) -> float | None:
        return None if numerator is None or denominator is None else numerator / denominator

    return {
        "reference_over_step": over(medians[REFERENCE_STEP], step),
        "reference_over_step_of_paper": over(medians[PAPER_REFERENCE_STEP], medians[PAPER_STEP]),
        "step_over_empty_call": over(step, medians[EMPTY_CALL]),
        "paper_over_step": over(PAPER_NS, step),
        "numba_over_step": over(medians[NUMBA_STEP], step),
        "mpc_over_step": over(medians[MPC_STEP], step),
    }


def to_json(report: LatencyReport) -> str:
    """Write a report as JSON, with a line feed at its end.

    It is an object with ``build_profile``, ``results``, ``ratios``, ``net_ratios``, ``absent``,
    ``states``, ``machine`` and ``timing``.
    """
    fields = asdict(report)
    ordered = {
        "build_profile": fields.pop("build_profile"),
        "results": fields.pop("results"),
        "ratios": report.ratios,
        "net_ratios": report.net_ratios,
        **fields,
    }
    return json.dumps(ordered, indent=2, allow_nan=False) + "\n"
