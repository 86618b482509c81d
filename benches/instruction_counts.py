"""Instructions per control step, counted by callgrind: two runs agree where two times never do.

    python benches/instruction_counts.py            # compare with the baseline; status 1 for more
    python benches/instruction_counts.py --record   # make these counts the baseline
    python benches/instruction_counts.py --json F   # write them to F besides

Counted is the difference of two runs of the program `steps`, whole laps apart, over the steps
between them: making the course and warming up fall out. What is inlined counts for the module that
it was written in (`PARTS`), by the line tables of the build. The counts are those of one compiler,
one C library (its sin, cos and atan2) and one kind of processor (which of them it chooses), all
recorded with the baseline; under others there is nothing to compare, and the script says so.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
BASELINE = ROOT / "benches" / "instruction_counts.json"
CALLS = (
    "pop steer",
    "pop step",
    "pop-paper steer",
    "pop-late steer",
    "preview-pop steer",
    "preview-pop step",
    "preview-pop-free steer",
    "preview-pop-slow steer",
    "preview-pop-late steer",
    "pid steer",
    "pure-pursuit steer",
    "stanley steer",
)
PARTS = {
    "path": r"path",
    "prediction, estimates": r"vehicle",
    "recursion": r"laws/preview_pop/cost_to_go",
    "limits": r"laws/preview_pop/(limited|active_set)",
    "rest of the law": r"laws",
    "tracker": r"tracker",
    "sin, exp, ...": r"",
}
"""The parts of a step, each by its modules in the core; the last has what is not of the core."""
LAPS = 1, 3
TOLERANCE = 0.03
"""One sine too many, the smallest fault worth a name, is 6 to 8 % of a POP step; an edit beside it
that only moves registers about, a percent. With nothing changed two runs differ by nothing."""


class Unavailable(Exception):  # noqa: N818 - it is no error, it is a reason to skip
    """What keeps this machine from counting, or from comparing."""


def build() -> Path:
    """Build the program; give its path."""
    cargo = _tool("cargo")
    command = [cargo, "build", "--release", "--locked", "--package", "popsteer-bench"]
    built = subprocess.run(
        [*command, "--bin", "steps", "--message-format", "json-render-diagnostics"],
        cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True,
        env=os.environ | {"CARGO_PROFILE_RELEASE_DEBUG": "line-tables-only"},
    )  # fmt: skip
    messages = [json.loads(line) for line in built.stdout.splitlines()]
    (program,) = [each["executable"] for each in messages if each.get("executable")]
    return Path(program)


def count(program: Path, call: str) -> dict[str, float]:
    """Count the instructions of one step, by its parts."""
    (few_steps, few), (many_steps, many) = (_run(program, call, laps) for laps in LAPS)
    return {part: round((many[part] - few[part]) / (many_steps - few_steps), 2) for part in PARTS}


def count_all(program: Path) -> dict[str, dict[str, float]]:
    """Count the instructions of one step of each call, by its parts."""
    _tool("valgrind")
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # counts do not mind company
        return dict(zip(CALLS, pool.map(lambda call: count(program, call), CALLS), strict=True))


def total(parts: dict[str, float]) -> float:
    """Sum the parts up."""
    return round(sum(parts.values()), 2)


def toolchain() -> dict[str, str]:
    """Name what the counts hang on."""
    command = [_tool("rustc"), "--version", "--verbose"]
    rustc = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    flags = re.search(r"^flags\s*:(.*)$", _read("/proc/cpuinfo"), re.MULTILINE)
    widest = [name for name in ("fma", "avx2") if flags and name in flags[1].split()]
    return {
        "rustc": rustc.splitlines()[0],
        "host": next(line[6:] for line in rustc.splitlines() if line.startswith("host: ")),
        "libc": " ".join(platform.libc_ver()).strip() or "unknown",
        "processor": " ".join((platform.machine(), *widest)),
        "flags": os.environ.get("RUSTFLAGS", ""),
    }


def comparable(baseline: dict[str, Any]) -> None:
    """Raise `Unavailable` where the baseline was recorded with another toolchain."""
    here = toolchain()
    for name, recorded in baseline["toolchain"].items():
        if here[name] != recorded:
            raise Unavailable(f"{name} is {here[name]!r}, the baseline's {recorded!r}")


def compare(counts: dict[str, float], baseline: dict[str, Any]) -> list[str]:
    """Give a line for each count that is more than the baseline and its tolerance."""
    return [
        f"{call}: {counts[call]} instructions, {100 * (counts[call] / recorded - 1):.1f} %"
        f" more than {recorded} (tolerance {100 * baseline['tolerance']:.0f} %)"
        for call, recorded in baseline["counts"].items()
        if not counts[call] <= recorded * (1.0 + baseline["tolerance"])
    ]


def main() -> int:
    """Count, and compare, record or write."""
    parser = argparse.ArgumentParser(description="Count the instructions of a control step.")
    parser.add_argument("--record", action="store_true", help="make these counts the baseline")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the counts as JSON")
    arguments = parser.parse_args()
    try:
        counted: dict[str, Any] = {"toolchain": toolchain(), "tolerance": TOLERANCE}
        counted["parts"] = count_all(build())
        counted["counts"] = counts = {call: total(it) for call, it in counted["parts"].items()}
    except Unavailable as reason:
        print(f"not counted: {reason}")
        counted = {"counts": None, "reason": str(reason)}
    else:
        for call, instructions in counts.items():
            print(f"{call:24} {instructions:8.1f}")
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(counted, indent=2) + "\n", encoding="utf-8")
    found: list[str] = []
    if arguments.record and counted["counts"]:
        counted.pop("parts")
        BASELINE.write_text(json.dumps(counted, indent=2) + "\n", encoding="utf-8")
    elif counted["counts"]:
        baseline = json.loads(BASELINE.read_text(encoding="utf-8"))
        try:
            comparable(baseline)
            found = compare(counts, baseline)
            print("\n".join(found) if found else "no count above the baseline and its tolerance")
        except Unavailable as reason:
            print(f"not compared: {reason}")
    return int(bool(found))


def _run(program: Path, call: str, laps: int) -> tuple[int, Counter[str]]:
    """Run the program under callgrind: steps taken, instructions executed by part."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind.out"
        done = subprocess.run(
            [_tool("valgrind"), "--tool=callgrind", f"--callgrind-out-file={out}",
             program, *call.split(), str(laps)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        text = _read(out)
    found = re.search(r"^(?:summary|totals): (\d+)", text, re.MULTILINE)
    parts = by_part(text)
    if found is None or parts.total() != int(found[1]):
        raise RuntimeError(f"callgrind's costs do not add up to its summary: {done.stderr}")
    return int(done.stdout), parts


def by_part(text: str) -> Counter[str]:
    """Add up what callgrind wrote, each function's own instructions, by the parts of a step."""
    names: dict[tuple[bool, str], str] = {}
    parts: Counter[str] = Counter()
    file = function = ""
    called = False
    for line in text.splitlines():
        if named := re.match(r"(c?f[lien])=(\(\d+\)) ?(.*)", line):
            kind, number, name = named.groups()
            key = kind.endswith("n"), number  # files and functions are numbered apart
            name = names.setdefault(key, name)
            if kind == "fn":
                function = name
            elif not kind.startswith("c"):
                file = name
        elif line.startswith("calls="):
            called = True  # the next line is what that call cost, counted where it was spent
        elif re.match(r"[-+*\d]", line):
            if not called:
                parts[_part(file, function)] += int(line.split()[-1])
            called = False
    return parts


def _part(file: str, function: str) -> str:
    written = re.search(r"rust/core/src/(\w+/.*)\.rs$", file)
    within = re.search(r"popsteer_core::(\w+::[\w:]*)", function)  # of what has no part
    module = written[1] if written else within[1].replace("::", "/") if within else ""
    return next(part for part, modules in PARTS.items() if re.match(modules, module))


def _tool(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        raise Unavailable(f"{name} is not on the path")
    return path


def _read(file: str | Path) -> str:
    try:
        return Path(file).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


if __name__ == "__main__":
    sys.exit(main())
