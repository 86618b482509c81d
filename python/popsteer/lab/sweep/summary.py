"""Success rate, percentiles, worst runs and causes of failure of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from popsteer.lab.common.layout import BAD, SIGN, add_numbers, blank_table
from popsteer.lab.common.names import counted
from popsteer.lab.sweep.job import Job
from popsteer.sim import plant_name
from popsteer.status import Status

if TYPE_CHECKING:
    from rich.table import Table

Rows: TypeAlias = Sequence[dict[str, Any]]
"""Rows of a sweep, as `popsteer.lab.sweep.drive` gives them."""
ERROR = "settled_max_abs_cross_track_error"
"""The error that decides whether a run succeeds."""
UNITS = {
    **dict.fromkeys(("noise_position", "start_offset", "wheelbase", "turning_wheelbase"), "m"),
    **dict.fromkeys(("steer_offset", "max_steer", "steer_play", "noise_yaw", "start_yaw"), "rad"),
    **dict.fromkeys(("max_steer_rate", "steer_rate"), "rad/s"),
    **dict.fromkeys(("steer_lag", "dead_time"), "s"),
    **dict.fromkeys(("noise_speed", "start_speed"), "m/s"),
    "understeer": "s²/m",
}
"""Units of what varies, for axes."""
_SHOWN = (
    (ERROR, "greatest |cross-track error| [m]"),
    ("settled_mean_abs_cross_track_error", "mean |cross-track error| [m]"),
    ("settled_max_abs_heading_error", "greatest |heading error| [rad]"),
    ("rms_steer_rate", "rms steering rate [rad/s]"),
)
_PERCENTILES = (50.0, 90.0, 99.0, 100.0)
_WORST = 5
_BINS = 10
_LEAST = 1e-4  # m: a logarithmic axis has no zero


class Rate(NamedTuple):
    """A share of runs, and the ends of its 95 % confidence interval."""

    share: float
    low: float
    high: float


def success_rate(successes: int, runs: int) -> Rate:
    """Give the share of the runs that succeeded, with Wilson's 95 % confidence interval.

    E. Wilson, *Probable Inference, the Law of Succession, and Statistical Inference*, 1927. It
    takes the runs for independent; those of a Latin hypercube scatter less, so it is on the safe
    side.
    """
    if runs == 0:
        return Rate(math.nan, 0.0, 1.0)
    from scipy.stats import binomtest

    ends = binomtest(successes, runs).proportion_ci(method="wilson")
    return Rate(successes / runs, float(ends.low), float(ends.high))


class Outcomes(NamedTuple):
    """What became of the runs, an entry each."""

    good: NDArray[np.bool_]
    ended: NDArray[np.bool_]
    error: NDArray[np.float64]
    """The greatest |cross-track error| [m], as `error_of`; at least 1e-4, for logarithmic axes."""


def outcomes(rows: Rows) -> Outcomes:
    """Give what became of the runs."""
    error = np.maximum(np.array([error_of(row) for row in rows], dtype=np.float64), _LEAST)
    good, ended = np.array([(row["success"], row["finished"]) for row in rows], dtype=np.bool_).T
    return Outcomes(good, ended, error)


def error_of(row: dict[str, Any]) -> float:
    """Greatest |cross-track error| after settling [m]; of all where it did not finish or settle."""
    settled: float = row[ERROR]
    whole: float = row["max_abs_cross_track_error"]
    return settled if row["finished"] and math.isfinite(settled) else whole


def success_rates(
    values: NDArray[np.float64], good: NDArray[np.bool_]
) -> Iterator[tuple[float, float, Rate]]:
    """Give the success rate between each two deciles of `values`; each run counts once."""
    edges = np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1))
    tenths = np.searchsorted(edges[1:-1], values, side="right")
    for tenth, (low, high) in enumerate(pairwise(edges.tolist())):
        inside = tenths == tenth
        if inside.any():
            yield low, high, success_rate(int(good[inside].sum()), int(inside.sum()))


def axis_title(name: str) -> str:
    """Give a quantity that varies with its unit."""
    return f"{name} [{UNITS[name]}]" if name in UNITS else name


def worst(rows: Rows, count: int = _WORST) -> list[dict[str, Any]]:
    """Give the worst runs: those that did not finish, those with faults, then by the error."""

    def badness(row: dict[str, Any]) -> tuple[bool, bool, float, int]:
        # Smaller numbers first where all else is equal.
        return not row["finished"], row["faults"] != 0, error_of(row), -row["run"]

    return sorted(rows, key=badness, reverse=True)[:count]


def influence(job: Job, rows: Rows) -> dict[str, float]:
    """Give the Kolmogorov-Smirnov distance of each quantity that varies, the largest first.

    It is the greatest distance between the distribution functions of the quantity in runs that
    failed and in those that succeeded, 0 to 1; 0 for all where every run did the same. Where none
    failed, the tenth of the runs with the greatest error counts as failed.
    """
    from scipy.stats import ks_2samp

    good = _good(rows)
    found = {name: 0.0 for name, each in job.vary.items() if not each.is_constant}
    if good.any() and not good.all():
        for name in found:
            values = np.array([row[name] for row in rows])
            found[name] = float(ks_2samp(values[good], values[~good], method="asymp").statistic)
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def chance(rows: Rows) -> float:
    """Give the distance that a quantity without influence exceeds in 5 % of sweeps, at most 1."""
    counts = np.maximum(np.bincount(_good(rows), minlength=2), 1)
    return min(1.36 * math.sqrt(float(np.sum(1.0 / counts))), 1.0)


def _good(rows: Rows) -> NDArray[np.bool_]:
    good = np.array([row["success"] for row in rows], dtype=bool)
    if good.all() and len(rows) >= 10:
        errors = np.array([error_of(row) for row in rows])
        good = errors < np.quantile(errors, 0.9)
    return good


def badly(rows: Rows) -> str:
    """Word what `influence` compares with the others: the runs that failed, or the worst tenth."""
    return "were the worst tenth" if all(row["success"] for row in rows) else "failed"


def percent(share: float, runs: int) -> str:
    """Word a share of runs in per cent, with the digits that so many runs support.

    Examples
    --------
    >>> percent(0.5, 10), percent(2 / 3, 150), percent(0.99954, 10_000)
    ('50', '66.7', '99.95')
    """
    return f"{100.0 * share:.{min(max(math.ceil(math.log10(max(runs, 1))) - 2, 0), 4)}f}"


def success_of(rows: Rows) -> tuple[int, str, str, str]:
    """Count the runs that succeeded, and word their share and the ends of its interval [%]."""
    good = sum(row["success"] for row in rows)
    share, low, high = (percent(each, len(rows)) for each in success_rate(good, len(rows)))
    return good, share, low, high


def failures(rows: Rows) -> list[str]:
    """Say how many runs failed, for each reason; a run may do so for two."""
    faulty = [Status(row["faults"]) for row in rows if row["faults"]]
    names = ", ".join(dict.fromkeys(name for each in faulty for name in each.names))
    ended = [row for row in rows if row["finished"]]
    far = [not (row["faults"] or row["success"]) and math.isfinite(row[ERROR]) for row in ended]
    counts = {"did not finish": len(rows) - len(ended), f"reported a fault: {names}": len(faulty)}
    counts["went farther off than is allowed"] = sum(far)
    return [f"{count} {what}" for what, count in counts.items() if count]


def caption(job: Job, rows: Rows) -> str:
    """Say in one line what came out: the success rate and its interval."""
    good, share, low, high = success_of(rows)
    where = f" on {job.course}" if job.course else ""
    car = job.label or plant_name(job.whole)
    return (
        f"{job.controller}{where}, {car}: {good} of {len(rows)} runs succeeded,"
        f" {share} % (95 % confidence: {low} to {high} %)"
    )


def notes(job: Job, rows: Rows) -> list[str]:
    """Say what the table has no room for."""
    success = (
        "A run succeeds if it finishes, reports no fault, and its cross-track error stays within"
        f" {job.deviation:g} m {job.settled}. The errors are those after that."
    )
    said = [*(f"{SIGN} {each}." for each in failures(rows)), success]
    if short := sum(row["steps"] < 2 for row in rows):
        said.append(
            f"{counted(short, 'run')} lasted less than two control periods: the start projects onto"
            " the end of the path. Is it a lap (--closed)?"
        )
    if early := sum(row["finished"] and not math.isfinite(row[ERROR]) for row in rows):
        said.append(
            f"{counted(early, 'run')} lasted no longer than the first"
            f" {job.settings.settling_time:g} s, and settled nothing: no success without evidence."
        )
    weights = influence(job, rows)
    if weights and max(weights.values()) > 0.0:
        first = ", ".join(f"{name} {value:.2f}" for name, value in list(weights.items())[:3])
        said.append(
            f"Kolmogorov-Smirnov distance of the runs that {badly(rows)} from the others: {first}"
            f" (by chance: up to {chance(rows):.2f})."
        )
    said.append(job.begins(job.road, job.whole, job.vary, job.start_offset))
    drawn = ", ".join(f"{name} {each}" for name, each in job.vary.items())
    said.append(f"Drawn from seed {job.seed}: {drawn or 'nothing'}.")
    return said


def tables(job: Job, rows: Rows) -> list[Table]:
    """Set out the percentiles, and the worst runs."""
    from rich.text import Text

    shares = blank_table()
    shares.add_column("of the runs that have it", no_wrap=True)
    heads = {50.0: "median", 100.0: "worst"}
    add_numbers(shares, "runs", *(heads.get(share, f"{share:g} %") for share in _PERCENTILES))
    for name, said in _SHOWN:
        values = [row[name] for row in rows if math.isfinite(row[name])]
        cells = np.percentile(values, _PERCENTILES, method="higher") if values else []
        shares.add_row(Text(said), str(len(values)), *(f"{value:.4f}" for value in cells))
    bad = blank_table()
    chief = list(influence(job, rows))[:3]
    # Three long names side by side are too wide for a terminal.
    broken = (name.replace("_", "_\n") for name in chief)
    add_numbers(bad, "worst run", "finished", "faults", "max [m]", *broken)
    for row in worst(rows):
        bad.add_row(
            str(row["run"]),
            Text("yes") if row["finished"] else Text(f"{SIGN} no", BAD),
            Text(f"{SIGN} yes", BAD) if row["faults"] else Text("–"),
            f"{error_of(row):.3f}",
            *(f"{row[name]:.4g}" for name in chief),
        )
    return [shares, bad]
