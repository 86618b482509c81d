"""Lists what popsteer is built from and what developing it installs, with licences.

python -m docs.site.licences     # writes docs/licences.md, as `make site` does
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "licences.md"
# The crates whose code is in the wheel, in the C library, or in both.
SHIPPED = ("--package", "popsteer-py", "--package", "popsteer-c", "--edges", "normal")
ALL = ("--workspace", "--features", "popsteer-bench/criterion", "--edges", "normal,build,dev")


def _said(*command: str) -> str:
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def _crates(*which: str) -> set[str]:
    """Give a row of a table for each crate that comes from elsewhere."""
    tree = ("cargo", "tree", "--locked", "--target", "all", "--prefix", "none")
    lines = _said(*tree, *which, "--format", "| {p} | {l} |").splitlines()
    # "(*)" marks a repetition, "(proc-macro)" a kind, and a path one of the checkout's own.
    rows = {re.sub(r" \((?:\*|proc-macro)\)", "", line) for line in lines}
    return {row for row in rows if row.startswith("|") and "(/" not in row.rpartition("| ")[0]}


def page() -> str:
    """Write the page."""
    shipped = _crates(*SHIPPED)
    lines = [
        "# Licences",
        "",
        "popsteer is under the MIT licence. This page lists what it is built from and what",
        "developing it installs; `make site` writes it, and `make audit` checks the crates by",
        "`rust/deny.toml`.",
        "",
        "## Rust crates in the wheel and the C library",
        "",
        "| crate | licence |\n|---|---|",
        *sorted(shipped),
        "",
        "## Rust crates of builds and tests",
        "",
        "In no binary that is shipped.",
        "",
        "| crate | licence |\n|---|---|",
        *sorted(_crates(*ALL) - shipped),
        "",
        "## Python packages",
        "",
        "None of them is part of popsteer's wheel. pip installs numpy with it, and tomli before",
        "Python 3.11; the others come with extras and with the groups of developers.",
        "",
        _said(sys.executable, "-m", "piplicenses", "--format", "markdown", "-i", "popsteer"),
    ]
    return "\n".join(lines)


def main() -> None:
    """Write docs/licences.md."""
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")


if __name__ == "__main__":
    main()
