"""Writes the figures of one `make bench` into the marked blocks of the READMEs.

    python -m studies.bench out/bench

The folder holds what that run wrote: `latency.json` (benches.latency), `instruction_counts.json`,
and, where that bench is there, `path_scale.json`; criterion's estimates are taken from its own
folder, those newer than the file `started`. Blocks stand between `<!-- NAME: begin ... -->` and
`<!-- NAME: end -->`; benches/README.md has the block `figures`, README.md `steps`.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benches.latency.calls import EMPTY_CALL, LABELS, POP_STEP
from benches.latency.report import cells, digits, duration
from benches.path_scale import text
from studies.layout import ROOT, line, write_blocks

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


def markdown(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Lay out a table; all columns but the first are numbers."""
    lines = [heading, ["---", *["--:"] * (len(heading) - 1)], *rows]
    return "\n".join(line(*row) for row in lines)


def machine(latency: dict[str, Any], rustc: str) -> str:
    """Name what the run ran on."""
    of = latency["machine"]
    return f"{of['cpu']}, {of['cores']} cores; {of['python']}; {rustc}."


SHORT = {
    "pop_command_ns": "POP",
    "preview_pop_car_step_ns": "preview POP, of a real car",
    "daqp_step_ns": "MPC on daqp, in numpy",
}
"""The rows of README."""


def short_table(latency: dict[str, Any]) -> str:
    """Lay out the rows of README that are at hand."""
    heading = ("step", "p50", "p99", "p99.9", "max")
    step, empty = (latency["results"][name] for name in (POP_STEP, EMPTY_CALL))
    found = {name: latency["results"].get(name) for name in SHORT}
    rows = [[SHORT[k], *cells(row, step, empty)[:4]] for k, row in found.items() if row]
    return markdown(heading, rows)


def latency_table(latency: dict[str, Any]) -> str:
    """Lay out the steps as called from Python; a yardstick not at hand says why."""
    heading = ["call", "p50", "p99", "p99.9", "max", "net p50"]
    heading += ["times an empty call", "the same, net", "times POP's angle"]
    step, empty = (latency["results"][name] for name in (POP_STEP, EMPTY_CALL))
    rows = []
    for name, row in latency["results"].items():
        label = LABELS.get(name, name)
        if row is None:
            if not label.startswith("-"):
                rows.append([label, latency["absent"][name], *[""] * 7])
            continue
        rows.append([label.replace("- ", "&nbsp;&nbsp;"), *cells(row, step, empty)])
    return markdown(heading, rows)


def ratios_table(latency: dict[str, Any]) -> str:
    """Lay out the report's ratios, of both kinds."""
    rows = []
    for name, ratio in latency["ratios"].items():
        both = (ratio, latency["net_ratios"][name])
        rows.append([f"`{name}`", *("-" if each is None else digits(each) for each in both)])
    return markdown(("ratio", "of p50", "of net p50"), rows)


def criterion_table(folder: Path, since: float) -> str:
    """Lay out the medians of the benches in Rust that are newer than a time."""
    rows = []
    for file in folder.glob("**/new/benchmark.json"):
        estimates = file.with_name("estimates.json")
        if estimates.stat().st_mtime < since:
            continue  # of an earlier run
        median = json.loads(estimates.read_text(encoding="utf-8"))["median"]
        interval = median["confidence_interval"]
        name = json.loads(file.read_text(encoding="utf-8"))["full_id"]
        bounds = f"{interval['lower_bound']:.1f} to {interval['upper_bound']:.1f}"
        rows.append([f"`{name}`", f"{median['point_estimate']:.1f}", bounds])
    if not rows:
        raise SystemExit(f"{folder}: no bench of this run; run cargo bench first")
    return markdown(("bench", "median [ns]", "95 % interval [ns]"), sorted(rows, key=_natural))


def instructions_table(counted: dict[str, Any]) -> str:
    """Lay out the instruction counts, or say why there are none."""
    if counted["counts"] is None:
        return f"Not counted in this run: {counted['reason']}."
    on = counted["toolchain"]
    rows = [
        (f"`{call}`", *(f"{each:,.0f}" for each in (counted["counts"][call], *parts.values())))
        for call, parts in counted["parts"].items()
    ]
    table = markdown(("call", "instructions", *next(iter(counted["parts"].values()))), rows)
    return f"{table}\n\nWith {on['rustc']}, {on['libc']}, {on['processor']}."


def scale_table(scale: dict[str, Any]) -> str:
    """Lay out the bench over the length of the path, lengths side by side; its figure above."""
    rows = scale["rows"]
    heading, *lines = [[name, *(text(row[name]) for row in rows)] for name in rows[0]]
    image = "![What a path costs as it grows](figures/path_scale.png)"
    return f"{image}\n\n{markdown(heading, lines)}"


def figures(folder: Path, criterion: Path, rustc: str) -> dict[str, str]:
    """Make the content of each block from one run."""
    latency = _read(folder / "latency.json")
    states = latency["states"]
    on = machine(latency, rustc)
    parts = [
        on,
        "### Called from Python",
        latency_table(latency),
        f"{states['count']} states of {states['source']}. Calls timed one by one: "
        + "; ".join(f"{LABELS[name]} {n:,}" for name, n in latency["timing"]["calls"].items())
        + f". One reading of the clock: {duration(latency['timing']['timer_floor_ns'])}.",
        ratios_table(latency),
        "### Instructions per step",
        instructions_table(_read(folder / "instruction_counts.json")),
    ]
    if (folder / "path_scale.json").exists():
        parts += ["### Over the length of the path", scale_table(_read(folder / "path_scale.json"))]
    since = (folder / "started").stat().st_mtime
    parts += ["### In Rust alone", criterion_table(criterion, since)]
    return {
        "figures": "\n\n".join(parts),
        "steps": f"{short_table(latency)}\n\n{on}",
    }


def main() -> None:
    """Rewrite the blocks."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True)
    made = figures(Path(sys.argv[1]), target / "criterion", rustc.stdout.strip())
    for file in (ROOT / "benches" / "README.md", ROOT / "README.md"):
        if write_blocks(file, made):
            print(f"wrote {file.relative_to(ROOT)}")


def _read(file: Path) -> dict[str, Any]:
    try:
        content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise SystemExit(f"{file}: {error.strerror}; run the whole of `make bench`") from error
    return content


def _natural(row: Sequence[str]) -> list[tuple[int, str]]:
    """Sort by name, numbers in it by value."""
    parts = re.findall(r"(\d+\.?\d*)|(\D+)", row[0])
    return [(round(1e6 * float(number)), "") if number else (-1, text) for number, text in parts]


if __name__ == "__main__":
    main()
