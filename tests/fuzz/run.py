"""Fuzzes the core and the CSV reader for a while, and says what came out.

    python tests/fuzz/run.py                      # every target, 60 s each
    python tests/fuzz/run.py laws --seconds 600
    python tests/fuzz/run.py laws --input FILE    # one input again
    python tests/fuzz/run.py laws --add FILE ...  # inputs into corpus/laws.hex, to be replayed
    python tests/fuzz/run.py --keep               # the least inputs that reach all, into corpus/

Each run starts from the inputs in `corpus/TARGET.hex`, one a line in hexadecimal, sorted, and those
that earlier runs left in `out/fuzz/TARGET/corpus`. An input that breaks a rule goes to
`out/fuzz/TARGET`, and the exit code is then 1; 2 where something needed is missing. What was
executed goes to `out/fuzz/runs`, of which `table.py` makes the table in docs/fuzzing.md.
"""

from __future__ import annotations

import argparse
import datetime as dt
import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
OUT = ROOT / "out" / "fuzz"
CORPUS = HERE / "corpus"
TARGET_DIR = ROOT / "target" / "fuzz"

CORE = ("path", "laws", "limited", "vehicle", "longitudinal", "speed_tracker", "predict", "trust")
CSV = "csv_reader"
LONGEST_INPUT = {
    "path": 320,
    "laws": 400,
    "limited": 160,
    "vehicle": 320,
    "longitudinal": 96,
    "speed_tracker": 320,
    "predict": 192,
    "trust": 192,
    CSV: 512,
}

# What `cargo fuzz` passes, without a sanitizer: safe Rust has no memory errors to find, and the
# compiler need not be a nightly one.
COVERAGE = (
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
)
_EXECUTED = re.compile(r"^stat::number_of_executed_units:\s*(\d+)$", re.MULTILINE)


class Missing(Exception):  # noqa: N818 - it is no error of this program
    """Something that has to be installed first."""


@dataclass(frozen=True)
class Result:
    """What one target came to."""

    target: str
    executions: int
    seconds: float
    findings: list[str]


def read_corpus(target: str) -> list[bytes]:
    """Every input that is kept for a target."""
    text = (CORPUS / f"{target}.hex").read_text(encoding="ascii")
    return [bytes.fromhex(line) for line in text.splitlines()]


def write_corpus(target: str, inputs: Iterable[bytes]) -> None:
    """Keep these inputs for a target; the empty one is replayed anyway."""
    lines = sorted({data.hex() for data in inputs if data})
    text = "".join(f"{line}\n" for line in lines)
    (CORPUS / f"{target}.hex").write_text(text, encoding="ascii", newline="\n")
    print(f"{target}: {len(lines)} inputs, {sum(map(len, lines)) // 2} bytes")


def unpack(target: str, folder: Path) -> None:
    """Write the kept inputs of a target into a new folder, each as a file, as libFuzzer reads."""
    folder.mkdir()
    for data in read_corpus(target):
        (folder / hashlib.sha1(data, usedforsecurity=False).hexdigest()).write_bytes(data)


def core_program(target: str) -> list[str]:
    """Command of a target of the core, built first."""
    for tool in ("cargo", "rustc"):
        if shutil.which(tool) is None:
            raise Missing(f"{tool} not found: install a Rust toolchain")
    compiler = os.environ.get("CXX", "c++").split()[0]
    if shutil.which(compiler) is None:
        raise Missing(f"{compiler} not found: libFuzzer needs a C++ compiler, such as g++ or clang")
    version = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    host = version.split("host: ")[1].split()[0]
    # With --target the flags do not reach build scripts, which could not be linked with them.
    command = [
        *("cargo", "build", "--release", "--locked", "--features", "libfuzzer"),
        *("--bin", "fuzz", "--target", host, "--target-dir", str(TARGET_DIR)),
    ]
    environment = os.environ | {"CARGO_ENCODED_RUSTFLAGS": "\x1f".join(COVERAGE)}
    if subprocess.run(command, cwd=HERE, env=environment, check=False).returncode:
        raise Missing(f"the target {target} does not build, as said above")
    os.environ["POPSTEER_FUZZ"] = target
    return [str(TARGET_DIR / host / "release" / "fuzz")]


def program(target: str) -> list[str]:
    """Command of a target."""
    if target != CSV:
        return core_program(target)
    if importlib.util.find_spec("atheris") is None:
        raise Missing("atheris is not installed: pip install --group fuzz")
    return [sys.executable, str(HERE / "csv_reader.py")]


def limits(target: str) -> list[str]:
    """Options that hold in every run of a target."""
    return [f"-max_len={LONGEST_INPUT[target]}", "-timeout=10", "-rss_limit_mb=1024"]


def fuzz(target: str, program: Sequence[str], seconds: int) -> Result:
    """Fuzz one target for so long."""
    folder = OUT / target
    grown, kept, log = folder / "corpus", folder / "kept", folder / "log"
    grown.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(kept, ignore_errors=True)
    unpack(target, kept)
    command = [
        *program,
        *limits(target),
        f"-max_total_time={seconds}",
        f"-artifact_prefix={folder}/",
        "-print_final_stats=1",
        str(grown),
        str(kept),
    ]
    begun, start = time.time(), time.monotonic()
    with log.open("w", encoding="utf-8") as sink:
        code = subprocess.run(command, stdout=sink, stderr=sink, check=False).returncode
    passed = time.monotonic() - start
    text = log.read_text(encoding="utf-8", errors="replace")
    executed = _EXECUTED.findall(text)
    # libFuzzer's names for what it could not get through; slow inputs are no findings.
    findings = [
        str(file.relative_to(ROOT))
        for kind in ("crash", "timeout", "oom", "leak")
        for file in sorted(folder.glob(f"{kind}-*"))
        if file.stat().st_mtime >= begun - 1.0
    ]
    if (code or not executed) and not findings:
        raise Missing(f"{target} ended with code {code} and no finding:\n{text[-2000:]}")
    return Result(target, int(executed[-1]) if executed else 0, passed, findings)


def keep(target: str) -> None:
    """Replace the corpus in the tree by the fewest inputs that reach what all inputs reach."""
    with tempfile.TemporaryDirectory() as temporary:
        kept, least = Path(temporary, "kept"), Path(temporary, "least")
        unpack(target, kept)
        least.mkdir()
        # Branches reached count; of the reader's few, how often they were too.
        counters = f"-use_counters={int(target == CSV)}"
        command = [*program(target), *limits(target), "-set_cover_merge=1", counters]
        sources = [folder for folder in (kept, OUT / target / "corpus") if folder.is_dir()]
        subprocess.run(
            [*command, str(least), *map(str, sources)],
            check=True,
            capture_output=True,
            stdin=subprocess.DEVNULL,
        )
        inputs = [file.read_bytes() for file in least.iterdir()]
    if not inputs:
        raise Missing(f"{target}: libFuzzer kept no input at all; the corpus stays as it is")
    write_corpus(target, inputs)


def show(result: Result) -> None:
    """Say what one target came to."""
    rate = result.executions / result.seconds
    print(
        f"{result.target:<13} {result.executions:>13,} executions in {result.seconds:6.1f} s "
        f"({rate:,.0f}/s), {len(result.findings)} findings",
        flush=True,
    )
    for finding in result.findings:
        print(
            f"  {finding}: again with: python tests/fuzz/run.py {result.target} --input {finding}"
        )


def record(results: Sequence[Result]) -> Path:
    """Write down what was executed, when and where."""
    now = dt.datetime.now(dt.timezone.utc)
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    summary = {
        "date": f"{now:%Y-%m-%d}",
        "commit": commit.stdout.strip() or None,
        "results": [asdict(result) for result in results],
    }
    file = OUT / "runs" / f"{now:%Y%m%dT%H%M%S}-{os.getpid()}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return file


def run_all(targets: Sequence[str], seconds: int) -> int:
    """Fuzz each target in turn; the exit code."""
    programs = {target: program(target) for target in targets}
    results = []
    for target in targets:
        results.append(fuzz(target, programs[target], seconds))
        show(results[-1])
    for name, those in (
        ("core", [result for result in results if result.target != CSV]),
        ("CSV reader", [result for result in results if result.target == CSV]),
    ):
        if those:
            print(f"total, {name}: {sum(result.executions for result in those):,} executions")
    print(f"written to {record(results).relative_to(ROOT)}")
    return int(any(result.findings for result in results))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(CORE)}, {CSV}")
    parser.add_argument("--seconds", type=int, default=60, help="for each target (default: 60)")
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--input", type=Path, metavar="FILE", help="run this input alone")
    one.add_argument("--add", type=Path, nargs="+", metavar="FILE", help="keep these inputs")
    one.add_argument("--keep", action="store_true", help="minimise the corpus into the tree")
    asked = parser.parse_args()
    unknown = [target for target in asked.targets if target not in LONGEST_INPUT]
    if unknown:
        parser.error(f"unknown target {unknown[0]!r}; known: {', '.join(LONGEST_INPUT)}")
    if asked.seconds < 1:
        parser.error(f"--seconds must be at least 1, got {asked.seconds}")
    files = [asked.input] if asked.input else asked.add or []
    if files and len(asked.targets) != 1:
        parser.error(f"an input is one target's: name it, one of {', '.join(LONGEST_INPUT)}")
    for file in files:
        if not file.is_file():
            parser.error(f"{file} is no file")
    return asked


def main() -> int:
    """Do what the command line says; the exit code."""
    asked = parse()
    targets = asked.targets or [*CORE, CSV]
    try:
        if asked.input:
            command = [*program(targets[0]), str(asked.input.resolve())]
            return int(subprocess.run(command, check=False).returncode != 0)
        if asked.add:
            added = [file.read_bytes() for file in asked.add]
            write_corpus(targets[0], [*read_corpus(targets[0]), *added])
            return 0
        if asked.keep:
            for target in targets:
                keep(target)
            return 0
        return run_all(targets, asked.seconds)
    except Missing as missing:
        print(missing, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
