"""Writes the table of docs/fuzzing.md from what `run.py` wrote down.

    python tests/fuzz/table.py out/fuzz/runs/*.json

Runs of one target are added up.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "fuzzing.md"
CSV = "csv_reader"
_BLOCK = re.compile(r"(<!-- runs: begin .*?-->\n).*?(<!-- runs: end -->)", re.DOTALL)


def table(runs: Sequence[dict[str, Any]]) -> str:
    """Lay out what each target came to, and the core's total."""
    results = [result for run in runs for result in run["results"]]
    lines = [
        "| target | executions | hours | a second | findings |",
        "| --- | --: | --: | --: | --: |",
    ]
    by_target: dict[str, list[dict[str, Any]]] = {}
    for result in results:
        by_target.setdefault(result["target"], []).append(result)
    lines += [_line(target, those) for target, those in by_target.items()]
    core = [result for result in results if result["target"] != CSV]
    lines.append(_line("the core's together", core))
    dates = sorted({run["date"] for run in runs})
    commits = list(dict.fromkeys(run["commit"] for run in runs if run["commit"]))
    when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
    return "\n".join([*lines, "", f"{len(runs)} runs, {when}, of commits {', '.join(commits)}."])


def _line(name: str, results: Sequence[dict[str, Any]]) -> str:
    executions = sum(result["executions"] for result in results)
    seconds = sum(result["seconds"] for result in results)
    findings = sum(len(result["findings"]) for result in results)
    rate = executions / seconds if seconds else 0.0
    return f"| {name} | {executions:,} | {seconds / 3600.0:.2f} | {rate:,.0f} | {findings} |"


def main() -> None:
    """Read the command line and rewrite the page."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("runs", nargs="+", type=Path, metavar="FILE", help="of out/fuzz/runs")
    files = parser.parse_args().runs
    runs = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(files)]
    content = table(runs)
    page = PAGE.read_text(encoding="utf-8")
    made, count = _BLOCK.subn(lambda found: f"{found[1]}{content}\n{found[2]}", page)
    if count != 1:
        raise SystemExit(f"{PAGE}: expected one block of runs, found {count}")
    PAGE.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()
