"""Draws the figures of README and docs/ anew.

    python -m studies.figures          # those of `popsteer paper` and `popsteer stability`

The others are drawn by the commands that measure what they show; `MADE_BY` has all of them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from studies.layout import DOCS

FIGURES = DOCS / "figures"
# The command that draws each figure, light and dark, by the beginning of its name.
MADE_BY = {
    "results": "popsteer paper",
    "carrot-offset": "popsteer stability --vehicle carla-identified",
    "preview-choice": "popsteer stability",
    "stability-map": "popsteer stability",
    "stability-margins": "popsteer stability",
    "stability-loops": "popsteer stability",
    "versus": "python -m studies.versus",
    "matrix": "make matrix",
    "report": "python -m studies.report",
    "limits-map": "python -m studies.limits",
    "front": "python -m studies.front",
    "suite": "make suite",
}


def main() -> None:
    """Run the commands and copy what the pages show."""
    commands = {by for by in MADE_BY.values() if by.startswith("popsteer")}
    for command in sorted(commands):
        with tempfile.TemporaryDirectory() as folder:
            popsteer = [sys.executable, "-m", *command.split(), "--out", folder]
            subprocess.run(popsteer, check=True, stdout=subprocess.DEVNULL)
            for name, by in MADE_BY.items():
                for suffix in ("", "-dark") if by == command else ():
                    shutil.copy(Path(folder) / f"{name}{suffix}.png", FIGURES)
    print(f"drew {FIGURES}: {', '.join(name for name, by in MADE_BY.items() if by in commands)}")


if __name__ == "__main__":
    main()
